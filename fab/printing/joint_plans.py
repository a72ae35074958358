"""Plans of joints between printed parts: their outlines, their heights, and room for them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from fab.panels.thick_sheet import ThickSheet
from fab.printing.plate_settings import JointSettings
from solver.errors import InvalidValue
from solver.vectors import FloatArray

__all__ = [
    "ROUNDING_MM",
    "STEP_MM",
    "Frame",
    "Levels",
    "Plan",
    "depths_mm",
    "joint_levels",
    "joint_plan",
    "places",
    "rim_of",
    "strap_mm",
]

# Places that are tried along a web.
_PLACES = 201
# Sides of a pin's hole.
_ROUND = 32
# By this much webs are narrower than the mouths of their tongues, on both sides, and within their
# panel tongues begin to widen: what meets but for rounding leaves slivers in the joined surface.
STEP_MM = 0.05
ROUNDING_MM = 1e-6


@dataclass(frozen=True)
class Levels:
    """Heights over the axes, mm: bottom and top of panels, tops of tongues and of pockets."""

    low: float
    high: float
    tongue: float
    roof: float

    @property
    def through(self) -> bool:
        """Whether pockets go through their panels."""
        return self.roof >= self.high


def joint_levels(sheet: ThickSheet, settings: JointSettings) -> Levels:
    """Heights of the tongues and pockets of a sheet.

    Raises `InvalidValue` for tongues that leave no roof of `roof_mm` above their pockets.
    """
    low, high = sheet.panels.heights_mm
    webs = sheet.flexible & (sheet.creases >= 0)
    top = float(sheet.bodies.boxes()[1][webs, 2].max(initial=low))
    most = high - settings.fit_mm - settings.roof_mm
    through = Levels(low, high, high, high)
    if settings.tongue_mm is None:
        tongue = max((low + high) / 2, top)
        return Levels(low, high, tongue, tongue + settings.fit_mm) if tongue <= most else through
    tongue = max(low + settings.tongue_mm, top)
    if tongue >= high:
        return through
    if tongue > most:
        raise InvalidValue(
            "tongue_mm",
            f"{tongue - low:g}",
            f"be at most {most - low:.6g} mm, which leaves roof_mm = {settings.roof_mm:g} and "
            f"fit_mm = {settings.fit_mm:g} above it, or the thickness of the panels, "
            f"{high - low:g} mm",
            "Leave it out to have it chosen.",
        )
    return Levels(low, high, tongue, tongue + settings.fit_mm)


@dataclass(frozen=True)
class Frame:
    """Coordinates x along a crease and y into the panel with the pocket."""

    origin: FloatArray
    along: FloatArray
    inward: FloatArray

    def out(self, points: FloatArray) -> FloatArray:
        """Points (..., 2) of this frame on the sheet."""
        return self.origin + points[..., :1] * self.along + points[..., 1:] * self.inward

    def x(self, points: FloatArray) -> FloatArray:
        """Coordinate along the crease of points of the sheet."""
        return np.asarray((points - self.origin) @ self.along)


@dataclass(frozen=True)
class Plan:
    """Plans around x = 0 over a crease at y = 0; mouth is the width at the web."""

    mouth: float
    tongue: FloatArray
    pocket: FloatArray
    hole: FloatArray
    wall: float

    @property
    def width(self) -> float:
        """Of the pocket at its widest."""
        return float(np.ptp(self.pocket[:, 0]))


def joint_plan(settings: JointSettings, kind: str, size: float, near: float, face: float) -> Plan:
    """The plan of a dovetail, or of a strap for a pin.

    size : share of the width and depth of a dovetail. near, face : distance from the crease to
    where the web ends, and to where the panel begins at all heights, mm.
    """
    if kind == "dovetail":
        mouth, depth = size * settings.mouth_mm, size * settings.depth_mm
        neck = face + STEP_MM
        wide = mouth / 2 + (depth - STEP_MM) * np.tan(np.radians(settings.undercut_deg))
        half = [(mouth / 2, near / 2), (mouth / 2, neck), (wide, face + depth)]
        hole = np.empty((0, 2))
    else:
        mouth = depth = strap_mm(settings)
        half = [(mouth / 2, near / 2), (mouth / 2, face + depth)]
        turn = (np.arange(_ROUND) + 0.5) * (2 * np.pi / _ROUND)
        # around the circle, so that the pin goes in
        radius = (settings.pin_mm + settings.fit_mm) / 2 / np.cos(np.pi / _ROUND)
        hole = np.column_stack([np.cos(turn), np.sin(turn)]) * radius + [0.0, face + depth / 2]
    tongue = np.array([*half, *((-x, y) for x, y in reversed(half))])
    around = shapely.Polygon(tongue).buffer(settings.fit_mm, join_style="mitre")
    pocket = shapely.get_coordinates(shapely.orient_polygons(around))[:-1]
    return Plan(mouth, tongue, pocket, hole, settings.wall_mm)


def depths_mm(sheet: ThickSheet, settings: JointSettings) -> FloatArray:
    """How far a joint on each crease may reach into the panels beside it, mm, shape (ne,).

    Raises `InvalidValue` as `joint_levels` does.
    """
    levels = joint_levels(sheet, settings)
    back = sheet.panels.setbacks
    if settings.joint == "tape":
        return np.zeros(len(back.axis_mm))
    depth = settings.depth_mm if settings.joint == "dovetail" else strap_mm(settings)
    face = np.maximum(back.at(levels.low), back.at(min(levels.roof, levels.high)))
    knuckled = sheet.knuckles.creases  # whose tongues go through
    face[knuckled] = np.maximum(face[knuckled], back.at(levels.high)[knuckled])
    return np.where(np.isfinite(face), face, 0.0) + max(depth, strap_mm(settings))


def strap_mm(settings: JointSettings) -> float:
    """Width and length of a strap around the hole of its pin."""
    return settings.pin_mm + settings.fit_mm + 2 * settings.wall_mm


def places(
    frame: Frame,
    plan: Plan,
    web: tuple[float, float],
    room: shapely.Geometry,
    taken: Sequence[shapely.Polygon],
    face: float,
) -> FloatArray:
    """Middles x of as many pockets as there is room for with their walls, spread along the web.

    web : where it begins and ends along the crease. room : of the panel, at all heights of a
    pocket. taken : its other pockets. face : as in `joint_plan`.
    """
    low, high = web[0] + plan.mouth / 2, web[1] - plan.mouth / 2
    if high < low or room.is_empty:
        return np.empty(0)
    rim = rim_of(frame, room, taken, face)

    def free(x: FloatArray) -> FloatArray:  # the places among x that have room
        shift = np.stack([x, np.zeros(len(x))], axis=1)
        pockets = shapely.polygons(frame.out(plan.pocket + shift[:, None]))
        begin = shapely.points(frame.out(np.array([0.0, face + 2 * ROUNDING_MM]) + shift))
        good = shapely.distance(pockets, rim) >= plan.wall - ROUNDING_MM
        return np.asarray(x[good & shapely.contains(room, begin)])

    tried = np.linspace(low, high, _PLACES) if high > low else np.array([low])
    good = free(tried)
    if not len(good):
        return good
    step = (high - low) / (_PLACES - 1)
    chosen = []
    for run in np.split(good, np.flatnonzero(np.diff(good) > 1.5 * step) + 1):
        # its ends may be up to one step further out
        first = free(np.linspace(max(low, run[0] - step), run[0], _PLACES))[0]
        last = free(np.linspace(run[-1], min(high, run[-1] + step), _PLACES))[-1]
        count = 1 + int((last - first) / (plan.width + plan.wall))
        chosen.append(np.linspace(first, last, count) if count > 1 else run[[len(run) // 2]])
    middles = free(np.concatenate(chosen))
    apart = np.concatenate([[True], np.diff(middles) >= plan.width + plan.wall - ROUNDING_MM])
    return np.asarray(middles[apart])


def rim_of(
    frame: Frame, room: shapely.Geometry, taken: Sequence[shapely.Polygon], face: float
) -> shapely.Geometry:
    """What pockets keep away from: the rim of their panel but for the side at the crease.

    room, taken, face : as in `places`.
    """
    x = frame.x(shapely.get_coordinates(room))
    far = float(np.ptp(x)) + 1.0
    low, high = float(x.min()) - far, float(x.max()) + far
    outside = np.array([[low, -far], [high, -far], [high, face], [low, face]])
    outside[2:, 1] += ROUNDING_MM
    inner = shapely.difference(shapely.boundary(room), shapely.Polygon(frame.out(outside)))
    return shapely.union_all([inner, *taken])
