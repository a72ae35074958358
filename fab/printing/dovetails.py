r"""Joints along creases at which a sheet is printed in two parts: dovetails, pins or tape.

The web stays with one part. Beyond it, its panel gives up a tongue that is printed on the web, and
keeps a pocket for it, larger by a fit. Seen from above, and cut across the crease:

    ____________________            panel       roof       web   panel
   |     ________       |  panel   +-------+============+       +------
   |     \  +--+  /     |          |       |  tongue  | |       |
   |      \  \/  /      |          +-------+..........+ +=======+------
   +-------+ || +-------+                              axis
   ----------||---------- crease

Tongue and pocket are within the space of their panel, so whatever folded apart before still does:
the tongue moves as its panel does.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import product
from typing import Literal, TypeAlias

import numpy as np
import shapely

from fab.errors import Finding, Severity, counted, first_few
from fab.geometry.booleans import section
from fab.panels.hinge_room import crease_sides
from fab.panels.hinges import crease_kinds
from fab.panels.thick_sheet import ThickSheet
from fab.printing.joint_plans import (
    ROUNDING_MM,
    STEP_MM,
    Frame,
    Levels,
    joint_levels,
    joint_plan,
    places,
)
from fab.printing.knuckle_joints import BEYOND_MM, barrel_tongues, knuckle_place
from fab.printing.plate_settings import SIZES, JointSettings
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["Joint", "make_joints"]

_Kind: TypeAlias = Literal["dovetail", "pin"]


@dataclass(frozen=True)
class Joint:
    """What joins the two panels of a crease between two parts.

    Attributes
    ----------
    crease : its edge. kind : "dovetail", "pin" or "tape".
    faces : the face whose part keeps the web and carries the tongues, and that with the pockets.
    mouths : shape (k, 4, 2), mm: the part of the web below each of k tongues.
    tongues, pockets : shapes (k, n, 2): plans, counterclockwise, from the crease inwards.
    holes : shape (k, m, 2), holes of pins; m = 0 where there are none.
    through : whether tongues and pockets go through their panel, as those behind knuckles do.
    cleared : rings, shape (n, 2), of what a panel gives up besides pockets, each with its face.
    beyond : shape (n, 2), corners of what else the part with the tongues reaches out to.
    """

    crease: int
    kind: Literal["dovetail", "pin", "tape"]
    faces: tuple[int, int]
    mouths: FloatArray
    tongues: FloatArray
    pockets: FloatArray
    holes: FloatArray
    through: bool = False
    cleared: tuple[tuple[int, FloatArray], ...] = ()
    beyond: FloatArray = field(default_factory=lambda: np.empty((0, 2)))


@dataclass(frozen=True)
class _Site:
    """The sheet that joints are made in.

    Attributes
    ----------
    sides : the sides of panels beside each crease, in its first and second face (`crease_sides`).
    webs : the bodies of each crease that bend. bodies : the panel of each face.
    rooms : where a panel has material at all heights of a pocket, for faces that were asked for.
    """

    sheet: ThickSheet
    settings: JointSettings
    levels: Levels
    sides: tuple[IntArray, IntArray]
    webs: dict[int, list[int]]
    bodies: dict[int, int]
    rooms: dict[int, shapely.Geometry] = field(default_factory=dict)

    @classmethod
    def of(cls, sheet: ThickSheet, settings: JointSettings) -> _Site:
        webs: dict[int, list[int]] = {}
        for number in np.flatnonzero((sheet.creases >= 0) & sheet.flexible).tolist():
            webs.setdefault(int(sheet.creases[number]), []).append(number)
        bodies = {face: number for number, face in enumerate(sheet.panels.faces.tolist())}
        sides = crease_sides(sheet.pattern, sheet.panels)
        return cls(sheet, settings, joint_levels(sheet, settings), sides, webs, bodies)

    @property
    def kinds(self) -> tuple[_Kind, ...]:
        """Which joints to try; a pin holds in the roof above its strap."""
        order: tuple[_Kind, ...] = ("dovetail", "pin")
        if self.settings.joint != "dovetail":
            order = ("pin",)
        if self.levels.through:
            order = order[:-1]
        return () if self.settings.joint == "tape" else order

    def has_web(self, crease: int) -> bool:
        """Whether a crease has one web: what is joined by several is taped."""
        return len(self.webs.get(crease, [])) == 1

    def room(self, face: int) -> shapely.Geometry:
        """Where in a panel there is material at all heights of a pocket, without its holes."""
        if face not in self.rooms:
            number, low = self.bodies[face], self.levels.low
            top = min(self.levels.roof, self.levels.high - ROUNDING_MM)
            bare, made = (
                bodies.mesh(number) for bodies in (self.sheet.panels.bodies, self.sheet.bodies)
            )
            room = section(bare, low) & section(bare, top)
            if self.sheet.hinge.hole_mm > 0:  # barrels of knuckles are no room
                room &= section(made, low)
            self.rooms[face] = room
        return self.rooms[face]


def make_joints(
    sheet: ThickSheet, cuts: IntArray, settings: JointSettings
) -> tuple[list[Joint], list[Finding]]:
    """A joint for each of some creases.

    cuts : shape (n, 3): edge, face that should carry the tongues, face that should have the
    pockets; exchanged where only the first has room for pockets.

    Creases that have no web, or several, are taped, and so are films. Of knuckles the part with the
    pin carries tongues on the barrels of the other panel (`fab.printing.knuckle_joints`); what has
    no room for these gives up its knuckles and is taped.

    Raises `InvalidValue` for tongues that leave no roof of `roof_mm` above their pockets.
    """
    site = _Site.of(sheet, settings)
    taken: dict[int, list[shapely.Polygon]] = {}
    joints: list[Joint] = []
    knuckled = set(sheet.knuckles.creases.tolist())
    for edge, tongue, pocket in cuts.tolist():
        joint: Joint | None = None
        if edge in knuckled:
            joint = _of_knuckles(site, edge, taken)
        elif site.has_web(edge):
            joint = _largest_joint(site, edge, (tongue, pocket), taken)
        if joint is None:
            none = np.empty((0, 0, 2))
            joint = Joint(edge, "tape", (tongue, pocket), none, none, none, none)
        pockets = shapely.polygons(joint.pockets).tolist() if len(joint.pockets) else []
        taken.setdefault(joint.faces[1], []).extend(pockets)
        joints.append(joint)
    kinds = crease_kinds(sheet.pattern, sheet.hinge)
    filmed, bare = kinds == "film", kinds == "none"
    refused = [
        joint
        for joint in joints
        if joint.kind != settings.joint and not (filmed | bare)[joint.crease]
    ]
    return joints, [
        *_taped_films(joints, filmed, embedded=sheet.hinge.embedded),
        *_bare(joints, bare),
        *_findings(site, refused),
    ]


def _of_knuckles(site: _Site, edge: int, taken: dict[int, list[shapely.Polygon]]) -> Joint:
    """The joint of a crease with knuckles."""
    sheet, settings = site.sheet, site.settings
    place = knuckle_place(sheet, edge)
    pinned, other = sheet.pattern.edges_faces[edge].tolist()
    if settings.joint != "tape":
        found = barrel_tongues(place, settings, site.room(other), taken.get(other, []))
        if found is not None:
            return Joint(
                edge,
                "dovetail",
                (pinned, other),
                found.mouths,
                found.tongues,
                found.pockets,
                np.empty((len(found.tongues), 0, 2)),
                True,
                tuple((other, ring) for ring in found.cleared),
                place.strip,
            )
    none = np.empty((0, 0, 2))
    both = tuple(zip((pinned, other), place.strips(), strict=True))
    return Joint(edge, "tape", (pinned, other), none, none, none, none, True, both)


def _taped_films(joints: Sequence[Joint], filmed: BoolArray, *, embedded: bool) -> list[Finding]:
    edges = [joint.crease for joint in joints if filmed[joint.crease]]
    if not edges:
        return []
    how = "tape the film below along each of them. The tape folds as the film does."
    if embedded:
        how = "glue a strip of film over each of these gaps, on the side that opens."
    text = (
        f"the film is cut along {counted(len(edges), 'crease', 'creases')} between parts: lay the "
        f"parts edge to edge, and {how}"
    )
    return [Finding("film-taped", Severity.NOTE, text, creases=first_few(edges))]


def _bare(joints: Sequence[Joint], bare: BoolArray) -> list[Finding]:
    """A note of the creases between parts that are to have no hinge, and so no joint."""
    edges = [joint.crease for joint in joints if bare[joint.crease]]
    if not edges:
        return []
    text = (
        f"{counted(len(edges), 'crease', 'creases')} between parts without a hinge: join them as "
        "all others that have none, by tape or laminate."
    )
    return [Finding("joint-bare", Severity.NOTE, text, creases=first_few(edges))]


def _largest_joint(
    site: _Site, edge: int, faces: tuple[int, int], taken: dict[int, list[shapely.Polygon]]
) -> Joint | None:
    """The first joint that has room: the wanted kind, the wanted faces, the full size first."""
    for kind, turned in product(site.kinds, (False, True)):
        tongue, pocket = faces[::-1] if turned else faces
        for size in SIZES if kind == "dovetail" else SIZES[:1]:
            joint = _joint(site, edge, (tongue, pocket), kind, size, taken.get(pocket, []))
            if joint is not None:
                return joint
    return None


def _joint(
    site: _Site,
    edge: int,
    faces: tuple[int, int],
    kind: _Kind,
    size: float,
    taken: Sequence[shapely.Polygon],
) -> Joint | None:
    """A joint of one kind and size; None where it has no room.

    taken : pockets of other joints in the same panel.
    """
    sheet, levels = site.sheet, site.levels
    first, second = site.sides
    side = first[edge] if sheet.pattern.edges_faces[edge, 0] == faces[1] else second[edge]
    sides, back = sheet.panels.sides, sheet.panels.setbacks
    frame = Frame(sides.start[side], sides.along[side], sides.inward[side])
    web = sheet.bodies.mesh(site.webs[edge][0]).vertices_coords
    near = float(min(back.at(z)[edge] for z in np.unique(web[:, 2]).tolist()))
    face = float(max(back.at(levels.low)[edge], back.at(min(levels.roof, levels.high))[edge]))
    plan = joint_plan(site.settings, kind, size, near, face)
    x = frame.x(web[:, :2])
    run = float(x.min()), float(x.max())
    middles = places(frame, plan, run, site.room(faces[1]), taken, face)
    if not len(middles):
        return None
    shift = np.stack([middles, np.zeros(len(middles))], axis=1)[:, None]
    wide = plan.mouth / 2 - STEP_MM
    far = face + BEYOND_MM
    across = np.array([[-wide, -far], [wide, -far], [wide, far], [-wide, far]])
    return Joint(
        edge,
        kind,
        faces,
        frame.out(across + shift),
        frame.out(plan.tongue + shift),
        frame.out(plan.pocket + shift),
        frame.out(plan.hole + shift),
    )


def _findings(site: _Site, joints: Sequence[Joint]) -> list[Finding]:
    """Findings of joints of another kind than is asked for, with the longest of their creases."""
    sheet, settings = site.sheet, site.settings
    findings = []
    ends = sheet.pattern.vertices_coords[sheet.pattern.edges_vertices]
    length = np.hypot(*(ends[:, 1] - ends[:, 0]).T)
    for kind in ("pin", "tape"):
        edges = [joint.crease for joint in joints if joint.kind == kind]
        if not edges:
            continue
        longest = max(edges, key=lambda edge: float(length[edge]))
        size = SIZES[-1] if settings.joint == "dovetail" else 1.0
        plan = joint_plan(settings, settings.joint, size, 0.0, 0.0)
        needs = f"{plan.width:.4g} x {float(np.ptp(plan.pocket[:, 1])):.4g} mm"
        why = f"no room in its panels for a pocket of {needs} and walls of {settings.wall_mm:g} mm"
        cure = "Lower mouth_mm, depth_mm or wall_mm, or enlarge the sheet."
        if longest in sheet.knuckles.creases:
            why = f"no room for pockets behind its barrels, with walls of {settings.wall_mm:g} mm"
        elif not site.has_web(longest):
            why, cure = "no web", "The finding hinge-missing says what gives it one."
        elif settings.joint == "pin" and not site.kinds:
            why = f"no roof of {settings.roof_mm:g} mm above a strap"
        which = ("crease between parts is", "creases between parts are")
        joined = "joined by pins" if kind == "pin" else "to be taped"
        most = "the longest, " if len(edges) > 1 else ""
        findings.append(
            Finding(
                f"joint-{kind}",
                Severity.WARNING,
                f"{counted(len(edges), *which)} {joined}: {most}crease {longest} of "
                f"{length[longest]:.4g} mm, has {why}. {cure}",
                creases=first_few(edges),
            )
        )
    return findings
