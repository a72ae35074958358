"""How exactly a fold must reach its target."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from solver.errors import require_positive
from solver.vectors import FloatArray

__all__ = ["Tolerance"]

# Of an angle of 0.1 degrees.
_PER_DEG = 1e-3
_CLOSURE_PER_DEG = 1e-2
# Layers that lie on each other keep a distance h, relative to the sheet. A layer within a fold
# moves out of its crease by x, where both sides have the angle h / x between them: what bends and
# what stretches balance at x ~ sqrt(h), so that angles, in radians, the shape and strains are off
# by about as much. For h from 1e-6 to 1e-4, angles of a bird base by 2.7 sqrt(h) and its strain by
# 0.34 sqrt(h); those of a maze, whose creases hold more layers, by 4.9 and 0.89;
# those of four equal panels rolled up, whose ends lie in creases, by 6.0 and 0.48, and its shape by
# 1.4.
_LAYERS_RAD, _LAYERS_SHAPE, _LAYERS_STRAIN = 6.5, 1.5, 1.0
# A thickness of the order of the panels is no small distance: beyond these it keeps creases,
# lengths and the shape from their target, and the sheet is stopped. Creases that fold all the way
# open most, where layers lie between their sides: those of a Miura with acute angles of 70 degrees
# by 13.3 degrees at a thickness of 1/13 of its sides. Others do not close on layers: they are off
# as far as the law was seen to hold, up to h = 1e-4, and so are strains.
_FLAT_FOLDED_DEG, _MOST_DEG, _MOST_SHAPE = 165.0, 15.0, 0.1
_MOST_OTHER_REL = 1e-4


@dataclass(frozen=True)
class Tolerance:
    """Largest errors of a fold that has reached its target.

    By default files with four decimals in their angles pass, and a wrong crease fails.

    Attributes
    ----------
    angle_deg : of a crease's angle; the others are in proportion to it.
    layers_rel : how far layers that lie on each other are apart, relative to the sheet; 0 without
        contact.
    """

    angle_deg: float = 0.1
    layers_rel: float = 0.0

    def __post_init__(self) -> None:
        require_positive("tolerance_deg", self.angle_deg)

    @property
    def shape_rel(self) -> float:
        """Of the shape, relative to its diagonal; 1e-4 by default."""
        room = min(_LAYERS_SHAPE * float(np.sqrt(self.layers_rel)), _MOST_SHAPE)
        return _PER_DEG * self.angle_deg + room

    @property
    def crease_deg(self) -> float:
        """Of the angle of a crease that is nearly flat-folded, with the room that layers take."""
        room = float(np.degrees(_LAYERS_RAD * np.sqrt(self.layers_rel)))
        return self.angle_deg + min(room, _MOST_DEG)

    def creases_deg(self, target_deg: FloatArray) -> FloatArray:
        """Of the angles of creases with these targets, shape (n,): less for those not nearly flat.

        `crease_deg` for creases that fold by 165 degrees or more.
        """
        other = self.with_layers(min(self.layers_rel, _MOST_OTHER_REL))
        flat = np.abs(target_deg) >= _FLAT_FOLDED_DEG
        return np.where(flat, self.crease_deg, other.crease_deg)

    def with_layers(self, layers_rel: float) -> Tolerance:
        """The same for a sheet whose layers are layers_rel apart."""
        return replace(self, layers_rel=layers_rel)

    @property
    def strain(self) -> float:
        """Of lengths, relative; 1e-4 by default."""
        layers = min(self.layers_rel, _MOST_OTHER_REL)
        return _PER_DEG * self.angle_deg + _LAYERS_STRAIN * float(np.sqrt(layers))

    @property
    def closure_rad(self) -> float:
        """Of the rotations around a vertex, which multiply to the identity; 1e-3 by default."""
        return _CLOSURE_PER_DEG * self.angle_deg
