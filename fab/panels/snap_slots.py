r"""Slots by which barrels snap onto the pins of the other panel, and come off again.

The barrels that turn about a pin are open at the top, by a slot that is a little narrower than the
pin and widens upwards. Seen along the axis:

        ___     ___
       /   \   /   \
      /     | |     \
     |     /   \     |
     |     \ o /     |
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from fab.geometry.bodies import Bodies, bodies_of
from fab.geometry.booleans import difference, meshes, solid
from fab.panels.barrels import Barrels
from fab.panels.bevelled_panels import Panels
from fab.panels.hinges import HingeSettings, hole_radius_mm
from solver.vectors import FloatArray

if TYPE_CHECKING:
    from manifold3d import Manifold

__all__ = ["slot_mm", "with_snap_slots"]

# Height of the narrow part over the hole, in widths of the play.
_STRAIGHT = 1.0
_BEYOND_MM = 1.0


def slot_mm(hinge: HingeSettings) -> float:
    """Width of the slot: that of the pin less half of its play.

    >>> slot_mm(HingeSettings(pin_mm=1.2, play_mm=0.3))
    1.05
    """
    return hinge.pin_mm - hinge.play_mm / 2


def with_snap_slots(
    panels: Panels, barrels: Barrels, bodies: Bodies, hinge: HingeSettings
) -> Bodies:
    """Bodies of panels whose barrels without a pin are open at the top. bodies : one per panel."""
    turning = np.flatnonzero(~barrels.pinned)
    owner = np.searchsorted(panels.faces, panels.sides.faces[barrels.sides[turning]])
    top = panels.heights_mm[1]
    out = [bodies.mesh(number) for number in range(len(bodies))]
    changed = np.unique(owner).tolist()
    cut = [
        difference(
            [
                solid(out[body]),
                *(
                    cutter
                    for barrel in turning[owner == body].tolist()
                    for cutter in _cutters(panels, barrels, barrel, top, hinge)
                ),
            ]
        )
        for body in changed
    ]
    for body, mesh in zip(changed, meshes(cut), strict=True):
        out[body] = mesh
    return bodies_of(out)


def _cutters(
    panels: Panels, barrels: Barrels, barrel: int, top_mm: float, hinge: HingeSettings
) -> Iterator[Manifold]:
    """The narrow part of a slot, from the axis upwards, and the wide one above it."""
    from manifold3d import Manifold

    side = int(barrels.sides[barrel])
    sides = panels.sides
    half, hole = slot_mm(hinge) / 2, hole_radius_mm(hinge)
    neck = float(np.sqrt(hole**2 - half**2)) + _STRAIGHT * hinge.play_mm
    high = top_mm + _BEYOND_MM
    wide = half + max(0.0, high - neck)
    ends = barrels.runs[barrel] + np.array([-0.5, 0.5]) * hinge.play_mm

    def hull(section: list[tuple[float, float]]) -> Manifold:
        corners: list[FloatArray] = []
        for x in ends.tolist():
            for y, z in section:
                flat = sides.start[side] + x * sides.along[side] + y * sides.inward[side]
                corners.append(np.array([*flat, z]))
        return Manifold.hull_points(np.array(corners))

    yield hull([(-half, 0.0), (half, 0.0), (half, high), (-half, high)])
    if neck < high:
        yield hull([(-half, neck), (half, neck), (wide, high), (-wide, high)])
