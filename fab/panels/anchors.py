r"""Dovetails by which webs of a material of their own hold in their panels.

Two plastics that meet side by side come apart. Where that is to be expected, webs reach into their
panels at their own height, below the rest of the panel. Seen from above:

       panel          | web |          panel
          \-----------+     +-----------/
           |   tooth                   |
          /-----------+     +-----------\
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely

from fab.errors import Finding, Severity, counted, first_few
from fab.geometry.bodies import Bodies, bodies_of
from fab.geometry.booleans import difference, joined, meshes, prism, section, solid
from fab.panels.bevelled_panels import Panels
from fab.panels.hinge_room import crease_sides
from fab.panels.hinges import HingeSettings
from fab.pattern.crease_pattern import CreasePattern
from solver.vectors import FloatArray, IntArray

__all__ = ["anchored"]

# Widths of a tooth where it begins and where it ends, and of the space to the next one, in lengths.
_NECK, _END, _SPACE = 1.0, 1.5, 1.0
_ROUNDING_MM = 1e-6
# Within their panel teeth begin to widen by this: what meets but for rounding leaves slivers.
_STEP_MM = 0.05
# Pockets of webs that lie at the bottom of their panels are cut from this far below.
_BEYOND_MM = 1.0


@dataclass(frozen=True)
class _Side:
    """A web and one of its panels: coordinates x along the crease and y into the panel.

    Attributes
    ----------
    origin, along, inward : of the frame. run : where the web begins and ends, x.
    near, face : y at which the web ends at least, and from which on all is within the panel.
    """

    origin: FloatArray
    along: FloatArray
    inward: FloatArray
    run: tuple[float, float]
    near: float
    face: float

    def teeth(self, length: float) -> FloatArray:
        """Plans of as many teeth as there is place for along the web, shape (n, 6, 2)."""
        room, pitch = self.run[1] - self.run[0], (_END + _SPACE) * length
        count = int((room + _SPACE * length + _ROUNDING_MM) / pitch)
        middles = np.mean(self.run) + (np.arange(count) - (count - 1) / 2) * pitch
        neck, end = _NECK * length / 2, _END * length / 2
        half = [
            (neck, self.near / 2),
            (neck, self.face + _STEP_MM),
            (end, self.face + length),
        ]
        plan = np.array([*half, *((-x, y) for x, y in reversed(half))])
        x = plan[:, 0] + middles[:, None]
        y = np.broadcast_to(plan[:, 1], x.shape)
        return np.asarray(
            self.origin + x[..., None] * self.along + y[..., None] * self.inward, np.float64
        )


def anchored(
    pattern: CreasePattern, panels: Panels, creases: IntArray, bodies: Bodies, hinge: HingeSettings
) -> tuple[Bodies, list[Finding]]:
    """Bodies whose webs reach into their panels by `anchor_mm`, and webs that do not.

    bodies : one for each panel, then the web of each of `creases`, then others.
    """
    count = len(panels.bodies)
    if not len(creases):
        return bodies, []
    low, high = bodies.boxes()
    bottom, top = float(low[count, 2]), float(high[count, 2])  # of all webs
    first, second = crease_sides(pattern, panels)
    body = {face: number for number, face in enumerate(panels.faces.tolist())}
    rooms: dict[int, shapely.Geometry] = {}
    taken: dict[int, list[shapely.Polygon]] = {}
    pockets: dict[int, list[FloatArray]] = {}
    tongues: dict[int, list[FloatArray]] = {}
    loose = []
    for number, crease in enumerate(creases.tolist(), count):
        for side in (int(first[crease]), int(second[crease])):
            panel = body[int(panels.sides.faces[side])]
            if panel not in rooms:
                mesh = bodies.mesh(panel)
                levels = (bottom + _ROUNDING_MM, top - _ROUNDING_MM)
                rooms[panel] = section(mesh, levels[0]) & section(mesh, levels[1])
            plans = _side(panels, bodies, number, crease, side, bottom, top).teeth(hinge.anchor_mm)
            fitting = _fitting(plans, rooms[panel], taken.setdefault(panel, []), hinge)
            pockets.setdefault(panel, []).extend(fitting)
            tongues.setdefault(number, []).extend(fitting)
            if not fitting:
                loose.append(crease)
    floor = bottom - _BEYOND_MM if bottom <= panels.heights_mm[0] + _ROUNDING_MM else bottom
    out = [bodies.mesh(number) for number in range(len(bodies))]
    changed = {
        number: difference([solid(out[number]), *(prism(ring, floor, top) for ring in rings)])
        for number, rings in pockets.items()
        if rings
    } | {
        number: joined([solid(out[number]), *(prism(ring, bottom, top) for ring in rings)])
        for number, rings in tongues.items()
        if rings
    }
    for number, mesh in zip(changed, meshes(list(changed.values())), strict=True):
        out[number] = mesh
    return bodies_of(out), _not_anchored(np.unique(np.array(loose, np.int64)), hinge)


def _side(
    panels: Panels, bodies: Bodies, web: int, crease: int, side: int, bottom: float, top: float
) -> _Side:
    sides = panels.sides
    origin, along = sides.start[side], sides.along[side]
    x = (bodies.mesh(web).vertices_coords[:, :2] - origin) @ along
    levels = [bottom, top, *([0.0] if bottom < 0 < top else [])]
    back = [float(panels.setbacks.at(z)[crease]) for z in levels]
    run = float(x.min()), float(x.max())
    return _Side(origin, along, sides.inward[side], run, min(back), max(back))


def _fitting(
    plans: FloatArray,
    room: shapely.Geometry,
    taken: list[shapely.Polygon],
    hinge: HingeSettings,
) -> list[FloatArray]:
    """The teeth that keep `wall_mm` to the other sides of their panel, and to other teeth.

    taken : all teeth of the panel, to which these are added.
    """
    out = []
    for plan in plans:
        end = shapely.MultiPoint(plan[2:4])
        tooth = shapely.Polygon(plan)
        if not room.contains(end) or room.boundary.distance(end) < hinge.wall_mm:
            continue
        if any(tooth.distance(other) < hinge.wall_mm for other in taken):
            continue
        taken.append(tooth)
        out.append(np.asarray(plan, np.float64))
    return out


def _not_anchored(creases: IntArray, hinge: HingeSettings) -> list[Finding]:
    if not len(creases):
        return []
    text = (
        f"{counted(len(creases), 'web has', 'webs have')} no dovetail in one of "
        f"{'its' if len(creases) == 1 else 'their'} panels and may come off: there is no room for "
        f"anchor_mm = {hinge.anchor_mm:g} and walls of wall_mm = {hinge.wall_mm:g}. Lower these, "
        "or enlarge the sheet."
    )
    return [Finding("web-not-anchored", Severity.WARNING, text, creases=first_few(creases))]
