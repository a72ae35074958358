r"""How are two panels joined along a crease at which the sheet is printed in two parts?

The web stays with one part. Beyond it, its panel gives up a tongue that is printed on the web, and
keeps a pocket for it, larger by a fit. Seen from above, and cut across the crease:

    ____________________            panel       roof       web   panel
   |     ________       |  panel   +-------+============+       +------
   |     \  +--+  /     |          |       |  tongue  | |       |
   |      \  \/  /      |          +-------+..........+ +=======+------
   +-------+ || +-------+                              axis
   ----------||---------- crease

Tongue and pocket lie within the space of their panel, so whatever folded apart before still does:
the tongue moves as its panel does.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import TYPE_CHECKING, Literal

import numpy as np
import shapely

from fab.errors import Finding, Severity
from fab.geometry.bodies import Bodies, bodies_of
from fab.geometry.booleans import meshes, prism, section, solid
from fab.panels.hinge_room import crease_sides
from fab.panels.thick_sheet import ThickSheet
from fab.printing.plate_settings import SIZES, JointSettings
from solver.errors import InvalidValue
from solver.vectors import FloatArray, IntArray

if TYPE_CHECKING:
    from manifold3d import Manifold

__all__ = ["Joint", "depths_mm", "jointed", "make_joints"]

# Places that are tried along a web.
_PLACES = 201
# Sides of a pin's hole.
_ROUND = 32
# Webs are so much narrower than the mouths of their tongues, on both sides, and tongues begin to
# widen so far within their panel: what meets but for rounding leaves slivers in the joined surface.
_STEP_MM = 0.05
# Cutters reach so far out of what they cut, in mm.
_BEYOND_MM = 1.0
_ROUNDING_MM = 1e-6


@dataclass(frozen=True)
class Joint:
    """What joins the two panels of a crease between two parts.

    Attributes
    ----------
    crease : its edge. kind : "dovetail", "pin" or "tape".
    faces : the face whose part keeps the web and carries the tongues, and that with the pockets.
    mouths : shape (k, 4, 2), mm: over what of the web each of k tongues stands.
    tongues, pockets : shapes (k, n, 2): plans, counterclockwise, from the crease inwards.
    holes : shape (k, m, 2), holes of pins; m = 0 where there are none.
    """

    crease: int
    kind: Literal["dovetail", "pin", "tape"]
    faces: tuple[int, int]
    mouths: FloatArray
    tongues: FloatArray
    pockets: FloatArray
    holes: FloatArray


@dataclass(frozen=True)
class _Levels:
    """Heights over the axes, mm: of panels and tongues; roof is the top of the pockets."""

    low: float
    high: float
    tongue: float
    roof: float

    @property
    def through(self) -> bool:
        return self.roof >= self.high


@dataclass(frozen=True)
class _Frame:
    """Coordinates x along a crease and y into the panel with the pocket."""

    origin: FloatArray
    along: FloatArray
    inward: FloatArray

    def out(self, points: FloatArray) -> FloatArray:
        """Points (..., 2) of this frame on the sheet."""
        return self.origin + points[..., :1] * self.along + points[..., 1:] * self.inward

    def x(self, points: FloatArray) -> FloatArray:
        """How far along the crease points of the sheet lie."""
        return np.asarray((points - self.origin) @ self.along)


def depths_mm(sheet: ThickSheet, settings: JointSettings) -> FloatArray:
    """How far a joint on each crease may reach into the panels beside it, mm, shape (ne,)."""
    levels = _levels(sheet, settings)
    back = sheet.panels.setbacks
    if settings.joint == "tape":
        return np.zeros(len(back.axis_mm))
    depth = settings.depth_mm if settings.joint == "dovetail" else _strap_mm(settings)
    face = np.maximum(back.at(levels.low), back.at(min(levels.roof, levels.high)))
    return np.where(np.isfinite(face), face, 0.0) + max(depth, _strap_mm(settings))


def make_joints(
    sheet: ThickSheet, cuts: IntArray, settings: JointSettings
) -> tuple[list[Joint], list[Finding]]:
    """A joint for each of some creases.

    cuts : shape (n, 3): edge, face that should carry the tongues, face that should have the
    pockets; the other way round where there is no room for pockets but in the first.

    Creases that have no web, or several, are taped. Raises `InvalidValue` for tongues that leave no
    roof of `roof_mm` above their pockets.
    """
    levels = _levels(sheet, settings)
    body = {face: number for number, face in enumerate(sheet.panels.faces.tolist())}
    first, second = crease_sides(sheet.pattern, sheet.panels)
    webs: dict[int, list[int]] = {}
    for number in np.flatnonzero((sheet.creases >= 0) & sheet.flexible).tolist():
        webs.setdefault(int(sheet.creases[number]), []).append(number)
    taken: dict[int, list[shapely.Polygon]] = {}

    @cache
    def room(face: int) -> shapely.Geometry:
        """Where in a panel there is material at all heights of a pocket."""
        mesh = sheet.panels.bodies.mesh(body[face])
        top = min(levels.roof, levels.high - _ROUNDING_MM)
        return section(mesh, levels.low) & section(mesh, top)

    def placed(edge: int, tongue: int, pocket: int, kind: str, size: float) -> Joint | None:
        side = first[edge] if sheet.pattern.edges_faces[edge, 0] == pocket else second[edge]
        sides = sheet.panels.sides
        frame = _Frame(sides.start[side], sides.along[side], sides.inward[side])
        back = sheet.panels.setbacks
        web = sheet.bodies.mesh(webs[edge][0]).vertices_coords
        near = float(min(back.at(z)[edge] for z in np.unique(web[:, 2]).tolist()))
        face = float(max(back.at(levels.low)[edge], back.at(min(levels.roof, levels.high))[edge]))
        plan = _plan(settings, kind, size, near, face)
        x = frame.x(web[:, :2])
        middles = _places(
            frame, plan, (float(x.min()), float(x.max())), room(pocket), taken.get(pocket, []), face
        )
        if not len(middles):
            return None
        shift = np.stack([middles, np.zeros(len(middles))], axis=1)[:, None]
        wide = plan.mouth / 2 - _STEP_MM
        far = face + _BEYOND_MM
        across = np.array([[-wide, -far], [wide, -far], [wide, far], [-wide, far]])
        joint = Joint(
            edge,
            "dovetail" if kind == "dovetail" else "pin",
            (tongue, pocket),
            frame.out(across + shift),
            frame.out(plan.tongue + shift),
            frame.out(plan.pocket + shift),
            frame.out(plan.hole + shift),
        )
        taken.setdefault(pocket, []).extend(shapely.polygons(joint.pockets).tolist())
        return joint

    joints: list[Joint] = []
    refused: list[int] = []
    for edge, tongue, pocket in cuts.tolist():
        tries = [
            (one, other, kind, size)
            for kind in _kinds(settings, levels)
            for one, other in ((tongue, pocket), (pocket, tongue))
            for size in (SIZES if kind == "dovetail" else SIZES[:1])
        ]
        made = None
        if len(webs.get(edge, [])) == 1:
            made = next((j for t in tries if (j := placed(edge, *t)) is not None), None)
        if made is None:
            none = np.empty((0, 0, 2))
            made = Joint(edge, "tape", (tongue, pocket), none, none, none, none)
        if made.kind != settings.joint:
            refused.append(len(joints))
        joints.append(made)
    return joints, _findings(sheet, [joints[n] for n in refused], webs, settings)


@dataclass(frozen=True)
class _Plan:
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


def _plan(settings: JointSettings, kind: str, size: float, near: float, face: float) -> _Plan:
    """Near : from the crease to where the web ends; face : to where all heights are panel."""
    if kind == "dovetail":
        mouth, depth = size * settings.mouth_mm, size * settings.depth_mm
        neck = face + _STEP_MM
        wide = mouth / 2 + (depth - _STEP_MM) * np.tan(np.radians(settings.undercut_deg))
        half = [(mouth / 2, near / 2), (mouth / 2, neck), (wide, face + depth)]
        hole = np.empty((0, 2))
    else:
        mouth = depth = _strap_mm(settings)
        half = [(mouth / 2, near / 2), (mouth / 2, face + depth)]
        turn = (np.arange(_ROUND) + 0.5) * (2 * np.pi / _ROUND)
        # around the circle, so that the pin goes in
        radius = (settings.pin_mm + settings.fit_mm) / 2 / np.cos(np.pi / _ROUND)
        hole = np.column_stack([np.cos(turn), np.sin(turn)]) * radius + [0.0, face + depth / 2]
    tongue = np.array([*half, *((-x, y) for x, y in reversed(half))])
    around = shapely.Polygon(tongue).buffer(settings.fit_mm, join_style="mitre")
    pocket = shapely.get_coordinates(shapely.orient_polygons(around))[:-1]
    return _Plan(mouth, tongue, pocket, hole, settings.wall_mm)


def _places(
    frame: _Frame,
    plan: _Plan,
    web: tuple[float, float],
    room: shapely.Geometry,
    taken: Sequence[shapely.Polygon],
    face: float,
) -> FloatArray:
    """Middles x of as many pockets as there is room for with their walls, spread along the web."""
    low, high = web[0] + plan.mouth / 2, web[1] - plan.mouth / 2
    if high < low or room.is_empty:
        return np.empty(0)
    far = 2 * (high - low) + 2 * plan.width
    outside = np.array([[-far, -far], [high + far, -far], [high + far, face], [-far, face]])
    outside[2:, 1] += _ROUNDING_MM
    rim = shapely.union_all(
        [shapely.difference(shapely.boundary(room), shapely.Polygon(frame.out(outside))), *taken]
    )

    def free(x: FloatArray) -> FloatArray:  # those of some places that have room
        shift = np.stack([x, np.zeros(len(x))], axis=1)
        pockets = shapely.polygons(frame.out(plan.pocket + shift[:, None]))
        begin = shapely.points(frame.out(np.array([0.0, face + 2 * _ROUNDING_MM]) + shift))
        good = shapely.distance(pockets, rim) >= plan.wall - _ROUNDING_MM
        return np.asarray(x[good & shapely.contains(room, begin)])

    tried = np.linspace(low, high, _PLACES) if high > low else np.array([low])
    good = free(tried)
    if not len(good):
        return good
    step = (high - low) / (_PLACES - 1)
    chosen = []
    for run in np.split(good, np.flatnonzero(np.diff(good) > 1.5 * step) + 1):
        # its ends may lie up to one step further out
        first = free(np.linspace(max(low, run[0] - step), run[0], _PLACES))[0]
        last = free(np.linspace(run[-1], min(high, run[-1] + step), _PLACES))[-1]
        count = 1 + int((last - first) / (plan.width + plan.wall))
        chosen.append(np.linspace(first, last, count) if count > 1 else run[[len(run) // 2]])
    places = free(np.concatenate(chosen))
    apart = np.concatenate([[True], np.diff(places) >= plan.width + plan.wall - _ROUNDING_MM])
    return np.asarray(places[apart])


@dataclass(frozen=True)
class _Row:
    """A body of the jointed sheet: what is cut from which old one, and what is said of it."""

    source: int
    cut: Callable[[Manifold], Manifold] | None
    name: str
    face: int
    crease: int
    flexible: bool
    home: int


def jointed(
    sheet: ThickSheet, joints: Sequence[Joint], settings: JointSettings
) -> tuple[ThickSheet, IntArray]:
    """The sheet with its joints, and for each of its bodies the face with whose part it is printed.

    Panels with pockets stay in their places; webs are cut to their tongues, or left out where a
    crease is taped; tongues come last, each a body that moves with the face of its pocket.

    Raises `InvalidValue` for bodies of no face and no crease, such as a film under all panels.
    """
    whole = np.flatnonzero((sheet.faces < 0) & (sheet.creases < 0))
    if len(whole):
        raise InvalidValue(
            "body of a divided sheet",
            sheet.names[whole[0]],
            "belong to a face or to a crease",
            "Choose hinges of single creases, or a bed that holds the sheet.",
        )
    levels = _levels(sheet, settings)
    low, high = levels.low - _BEYOND_MM, levels.high + _BEYOND_MM
    panels = len(sheet.panels.bodies)
    body = {face: number for number, face in enumerate(sheet.panels.faces.tolist())}
    cutters: dict[int, list[Manifold]] = {}
    for joint in joints:
        mine = cutters.setdefault(joint.faces[1], [])
        top = high if levels.through else levels.roof
        mine += [prism(ring, low, top) for ring in joint.pockets]
        mine += [prism(ring, low, high) for ring in joint.holes if len(ring)]

    def without(tools: list[Manifold]) -> Callable[[Manifold], Manifold]:
        return lambda body: _less([body, *tools])

    def within(limit: Manifold) -> Callable[[Manifold], Manifold]:
        return lambda body: body ^ limit

    by_crease = {joint.crease: joint for joint in joints}
    rows: list[_Row] = []
    for number in range(len(sheet.bodies)):
        face, edge = int(sheet.faces[number]), int(sheet.creases[number])
        name, soft = sheet.names[number], bool(sheet.flexible[number])
        if number < panels:
            cut = without(cutters[face]) if face in cutters else None
            rows.append(_Row(number, cut, name, face, edge, soft, face))
        elif edge in by_crease:
            mouths, home = by_crease[edge].mouths, by_crease[edge].faces[0]
            rows += [
                _Row(number, within(prism(ring, low, high)), label, face, edge, soft, home)
                for ring, label in zip(mouths, _numbered(name, len(mouths)), strict=True)
            ]
        else:
            home = face if face >= 0 else int(sheet.pattern.edges_faces[edge, 0])
            rows.append(_Row(number, None, name, face, edge, soft, home))
    for joint in joints:
        top = high if levels.through else levels.tongue
        names = _numbered(f"tongue_{joint.crease}", len(joint.tongues))
        for ring, hole, label in zip(joint.tongues, joint.holes, names, strict=True):
            whole = prism(ring, low, top)
            strap = _less([whole, prism(hole, low, high)]) if len(hole) else whole
            own, other = joint.faces[1], joint.faces[0]
            rows.append(_Row(body[own], within(strap), label, own, joint.crease, False, other))
    made = [_made(old, rows) for old in (sheet.bodies, sheet.joining)]
    new = replace(
        sheet,
        panels=replace(sheet.panels, bodies=made[0].chosen(np.arange(panels))),
        bodies=made[0],
        names=tuple(row.name for row in rows),
        faces=np.array([row.face for row in rows]),
        creases=np.array([row.crease for row in rows]),
        flexible=np.array([row.flexible for row in rows]),
        joining=made[1],
    )
    return new, np.array([row.home for row in rows])


def _less(solids: list[Manifold]) -> Manifold:
    """The first without all others."""
    from manifold3d import Manifold, OpType

    return Manifold.batch_boolean(solids, OpType.Subtract)


def _made(old: Bodies, rows: Sequence[_Row]) -> Bodies:
    """What the rows cut from the old bodies; those that nothing is cut from as they are."""
    cuts = meshes([row.cut(solid(old.mesh(row.source))) for row in rows if row.cut is not None])
    fresh = iter(cuts)
    return bodies_of([old.mesh(row.source) if row.cut is None else next(fresh) for row in rows])


def _numbered(name: str, count: int) -> list[str]:
    return [name] if count == 1 else [f"{name}_{number + 1}" for number in range(count)]


def _strap_mm(settings: JointSettings) -> float:
    """Width and length of a strap around the hole of its pin."""
    return settings.pin_mm + settings.fit_mm + 2 * settings.wall_mm


def _kinds(settings: JointSettings, levels: _Levels) -> tuple[str, ...]:
    """Which joints to try; a pin holds in the roof above its strap."""
    order: tuple[str, ...] = ("dovetail", "pin") if settings.joint == "dovetail" else ("pin",)
    if levels.through:
        order = order[:-1]
    return () if settings.joint == "tape" else order


def _levels(sheet: ThickSheet, settings: JointSettings) -> _Levels:
    low, high = sheet.panels.heights_mm
    webs = sheet.flexible & (sheet.creases >= 0)
    top = float(sheet.bodies.boxes()[1][webs, 2].max(initial=low))
    most = high - settings.fit_mm - settings.roof_mm
    through = _Levels(low, high, high, high)
    if settings.tongue_mm is None:
        tongue = max((low + high) / 2, top)
        return _Levels(low, high, tongue, tongue + settings.fit_mm) if tongue <= most else through
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
    return _Levels(low, high, tongue, tongue + settings.fit_mm)


def _findings(
    sheet: ThickSheet, joints: list[Joint], webs: dict[int, list[int]], settings: JointSettings
) -> list[Finding]:
    findings = []
    ends = sheet.pattern.vertices_coords[sheet.pattern.edges_vertices]
    length = np.hypot(*(ends[:, 1] - ends[:, 0]).T)
    for kind in ("pin", "tape"):
        edges = [joint.crease for joint in joints if joint.kind == kind]
        if not edges:
            continue
        longest = max(edges, key=lambda edge: float(length[edge]))
        size = SIZES[-1] if settings.joint == "dovetail" else 1.0
        plan = _plan(settings, settings.joint, size, 0.0, 0.0)
        needs = f"{plan.width:.4g} x {float(np.ptp(plan.pocket[:, 1])):.4g} mm"
        why = f"no room in its panels for a pocket of {needs} and walls of {settings.wall_mm:g} mm"
        if len(webs.get(longest, [])) != 1:
            why = "no web"
        elif settings.joint == "pin" and not _kinds(settings, _levels(sheet, settings)):
            why = f"no roof of {settings.roof_mm:g} mm above a strap"
        then = "are joined by pins" if kind == "pin" else "are to be taped"
        findings.append(
            Finding(
                f"joint-{kind}",
                Severity.WARNING,
                f"{len(edges)} creases between parts {then}: the longest, crease {longest} of "
                f"{length[longest]:.4g} mm, has {why}. Lower mouth_mm, depth_mm or wall_mm, or "
                "enlarge the sheet.",
                creases=tuple(edges[:20]),
            )
        )
    return findings
