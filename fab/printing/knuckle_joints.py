r"""Joints at knuckles: barrels of one panel that are printed with the other, around its pin.

The panel that carries the pin is printed with all barrels of the crease. Those of the other panel
end in tongues, as wide as the barrels with half of their play, for pockets through that panel:

      +--+  pin  +--+            ________________
      |  |=======|  |           |   __      __    |  panel, laid over the tongues
      +--+ +---+ +--+           |  \  /    \  /   |
           |   |                +--+  +----+  +---+
           +---+  barrel           |  |    |  |
           \   /  tongue
            ---
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from fab.panels.barrels import barrel_rows
from fab.panels.hinge_room import crease_sides
from fab.panels.hinges import barrel_radius_mm
from fab.panels.thick_sheet import ThickSheet
from fab.printing.joint_plans import ROUNDING_MM, STEP_MM, Frame, rim_of
from fab.printing.plate_settings import SIZES, JointSettings
from solver.vectors import FloatArray

__all__ = ["BEYOND_MM", "BarrelTongues", "KnucklePlace", "barrel_tongues", "knuckle_place"]

# Cutters reach out of what they cut by this.
BEYOND_MM = 1.0


@dataclass(frozen=True)
class KnucklePlace:
    """The knuckles of a crease, in frames of both of its panels, first that with the pin.

    Attributes
    ----------
    frames : x along the crease, y into the panel.
    ends : shape (2, 2), where the first barrel begins and the last one ends, in each frame, mm.
    runs : shape (k, 2), from where to where the barrels of the second panel are, in its frame.
    near, face : distance from the crease to where a panel begins at some height, and at all.
    far : how far barrels reach beyond the crease. play : between two barrels.
    """

    frames: tuple[Frame, Frame]
    ends: FloatArray
    runs: FloatArray
    near: float
    face: float
    far: float
    play: float

    @property
    def strip(self) -> FloatArray:
        """Corners of what all barrels together cover at most, shape (4, 2)."""
        low, high = self.ends[1].tolist()
        return self._rectangle(1, low, high, self.far)

    def strips(self) -> tuple[FloatArray, FloatArray]:
        """Rings around the barrels of each panel, up to where the panel begins."""
        out = [
            self._rectangle(k, low - self.play / 2, high + self.play / 2, self.near)
            for k, (low, high) in enumerate(self.ends.tolist())
        ]
        return out[0], out[1]

    def barrel(self, run: FloatArray) -> FloatArray:
        """A ring around one barrel of the second panel."""
        low, high = run.tolist()
        return self._rectangle(1, low - self.play / 2, high + self.play / 2, self.near)

    def _rectangle(self, panel: int, low: float, high: float, inward: float) -> FloatArray:
        out = -self.far - BEYOND_MM
        corners = np.array([[low, out], [high, out], [high, inward], [low, inward]])
        return self.frames[panel].out(corners)


@dataclass(frozen=True)
class BarrelTongues:
    """Tongues of barrels, and what else the panel gives up: rings on the sheet.

    Attributes
    ----------
    mouths : shape (k, 4, 2), around the barrels with tongues. tongues, pockets : shapes (k, n, 2),
    with their barrels. cleared : rings around barrels without room for a tongue.
    """

    mouths: FloatArray
    tongues: FloatArray
    pockets: FloatArray
    cleared: tuple[FloatArray, ...]


def knuckle_place(sheet: ThickSheet, edge: int) -> KnucklePlace:
    """Where the knuckles of a crease are."""
    knuckles, panels = sheet.knuckles, sheet.panels
    number = int(np.flatnonzero(knuckles.creases == edge)[0])
    both = np.array([side[edge] for side in crease_sides(sheet.pattern, panels)])
    length = panels.sides.length_mm[both[0]]
    barrels = barrel_rows(
        np.array([edge]),
        both[None],
        np.array([length]),
        knuckles.ends[number][None],
        knuckles.counts[number][None],
        knuckles.play_mm,
    )
    ends = knuckles.ends[number]
    back = [float(panels.setbacks.at(z)[edge]) for z in (*panels.heights_mm, 0.0)]
    sides = panels.sides
    first, second = (
        Frame(sides.start[side], sides.along[side], sides.inward[side]) for side in both.tolist()
    )
    return KnucklePlace(
        (first, second),
        np.stack([ends, length - ends[::-1]]),
        barrels.runs[~barrels.pinned],
        min(back),
        max(back),
        barrel_radius_mm(sheet.panel),
        knuckles.play_mm,
    )


def barrel_tongues(
    place: KnucklePlace,
    settings: JointSettings,
    room: shapely.Geometry,
    taken: Sequence[shapely.Polygon],
) -> BarrelTongues | None:
    """Tongues for as many barrels of the second panel as it has room for, the largest that have.

    room : of that panel, at all heights. taken : its other pockets. None without room for any.
    """
    best: list[tuple[int, FloatArray, FloatArray]] = []
    for size in SIZES:
        found = _with_room(place, settings, size, room, taken)
        if len(found) > len(best):
            best = found
    if not best:
        return None
    held = {number for number, _, _ in best}
    lost = [run for number, run in enumerate(place.runs) if number not in held]
    return BarrelTongues(
        np.array([place.barrel(place.runs[number]) for number in sorted(held)]),
        np.array([tongue for _, tongue, _ in best]),
        np.array([pocket for _, _, pocket in best]),
        tuple(place.barrel(run) for run in lost),
    )


def _with_room(
    place: KnucklePlace,
    settings: JointSettings,
    size: float,
    room: shapely.Geometry,
    taken: Sequence[shapely.Polygon],
) -> list[tuple[int, FloatArray, FloatArray]]:
    """Barrels with room for a tongue of a size: their numbers, tongues and pockets."""
    if room.is_empty:
        return []
    frame = place.frames[1]
    rim, out = rim_of(frame, room, taken, place.face), []
    for number, (low, high) in enumerate(place.runs.tolist()):
        middle, half = (low + high) / 2, (high - low + place.play) / 2
        depth = size * settings.depth_mm
        wide = half + (depth - STEP_MM) * np.tan(np.radians(settings.undercut_deg))
        side = [
            (half, -place.far - BEYOND_MM),
            (half, place.face + STEP_MM),
            (wide, place.face + depth),
        ]
        ring = np.array([*side, *((-x, y) for x, y in reversed(side))])
        ring[:, 0] += middle
        around = shapely.Polygon(ring).buffer(settings.fit_mm, join_style="mitre")
        pocket = shapely.get_coordinates(shapely.orient_polygons(around))[:-1]
        shape = shapely.Polygon(frame.out(pocket))
        begin = shapely.Point(frame.out(np.array([middle, place.face + 2 * ROUNDING_MM])))
        if rim.distance(shape) < settings.wall_mm - ROUNDING_MM or not room.contains(begin):
            continue
        out.append((number, frame.out(ring), frame.out(pocket)))
        rim = shapely.union(rim, shape)
    return out
