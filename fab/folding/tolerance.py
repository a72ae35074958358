"""How exactly a fold must reach its target."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from solver.errors import require_positive

__all__ = ["Tolerance"]

# Of an angle of 0.1 degrees.
_PER_DEG = 1e-3
_CLOSURE_PER_DEG = 1e-2
# Layers that lie on each other keep a distance h, relative to the sheet. A layer within a fold
# moves out of its crease by x, where both sides have the angle h / x between them: what bends and
# what stretches balance at x ~ sqrt(h), so that angles, in radians, the shape and strains are off
# by about as much. For h from 1e-6 to 1e-4, angles of a bird base by 2.7 sqrt(h) and its strain by
# 0.34 sqrt(h); those of a maze, whose creases hold more layers, by 4.9 and 0.89.
_LAYERS_RAD, _LAYERS_SHAPE, _LAYERS_STRAIN = 5.0, 1.0, 1.0


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
        return _PER_DEG * self.angle_deg + _LAYERS_SHAPE * float(np.sqrt(self.layers_rel))

    @property
    def crease_deg(self) -> float:
        """Of a crease's angle, with the room that layers in contact take."""
        return self.angle_deg + float(np.degrees(_LAYERS_RAD * np.sqrt(self.layers_rel)))

    def with_layers(self, layers_rel: float) -> Tolerance:
        """The same for a sheet whose layers are layers_rel apart."""
        return replace(self, layers_rel=layers_rel)

    @property
    def strain(self) -> float:
        """Of lengths, relative; 1e-4 by default."""
        return _PER_DEG * self.angle_deg + _LAYERS_STRAIN * float(np.sqrt(self.layers_rel))

    @property
    def closure_rad(self) -> float:
        """Of the rotations around a vertex, which multiply to the identity; 1e-3 by default."""
        return _CLOSURE_PER_DEG * self.angle_deg
