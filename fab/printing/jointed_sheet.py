"""The bodies of a sheet with joints: pockets in panels, webs cut to their tongues, tongues."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from fab.geometry.bodies import Bodies, bodies_of
from fab.geometry.booleans import difference, meshes, prism, solid
from fab.panels.thick_sheet import ThickSheet
from fab.printing.dovetails import BEYOND_MM, Joint
from fab.printing.joint_plans import Levels, joint_levels
from fab.printing.plate_settings import JointSettings
from solver.errors import InvalidValue
from solver.vectors import IntArray

if TYPE_CHECKING:
    from manifold3d import Manifold

__all__ = ["jointed"]


@dataclass(frozen=True)
class _Row:
    """A body of the jointed sheet: what is cut from which old one, and its attributes.

    home : the face with whose part it is printed.
    """

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
    levels = joint_levels(sheet, settings)
    rows = [
        *_panel_rows(sheet, joints, levels),
        *_web_rows(sheet, joints, levels),
        *_tongue_rows(sheet, joints, levels),
    ]
    bodies, joining = (_made(old, rows) for old in (sheet.bodies, sheet.joining))
    new = replace(
        sheet,
        panels=replace(sheet.panels, bodies=bodies.chosen(np.arange(len(sheet.panels.bodies)))),
        bodies=bodies,
        names=tuple(row.name for row in rows),
        faces=np.array([row.face for row in rows]),
        creases=np.array([row.crease for row in rows]),
        flexible=np.array([row.flexible for row in rows]),
        joining=joining,
    )
    return new, np.array([row.home for row in rows])


def _panel_rows(sheet: ThickSheet, joints: Sequence[Joint], levels: Levels) -> Iterator[_Row]:
    """Panels, without the pockets and holes in them."""
    low, high = _reach(levels)
    top = high if levels.through else levels.roof
    cutters: dict[int, list[Manifold]] = {}
    for joint in joints:
        own = cutters.setdefault(joint.faces[1], [])
        own += [prism(ring, low, top) for ring in joint.pockets]
        own += [prism(ring, low, high) for ring in joint.holes if len(ring)]
    for number in range(len(sheet.panels.bodies)):
        face = int(sheet.faces[number])
        cut = _without(cutters[face]) if face in cutters else None
        yield _old(sheet, number, cut, sheet.names[number], face)


def _web_rows(sheet: ThickSheet, joints: Sequence[Joint], levels: Levels) -> Iterator[_Row]:
    """Bodies that are no panels: webs below tongues, and whole ones."""
    by_crease = {joint.crease: joint for joint in joints}
    for number in range(len(sheet.panels.bodies), len(sheet.bodies)):
        face, edge = int(sheet.faces[number]), int(sheet.creases[number])
        name = sheet.names[number]
        if edge in by_crease:
            mouths, home = by_crease[edge].mouths, by_crease[edge].faces[0]
            for ring, label in zip(mouths, _numbered(name, len(mouths)), strict=True):
                yield _old(sheet, number, _within(prism(ring, *_reach(levels))), label, home)
        else:
            home = face if face >= 0 else int(sheet.pattern.edges_faces[edge, 0])
            yield _old(sheet, number, None, name, home)


def _tongue_rows(sheet: ThickSheet, joints: Sequence[Joint], levels: Levels) -> Iterator[_Row]:
    """Tongues, cut from the panels of their pockets."""
    low, high = _reach(levels)
    top = high if levels.through else levels.tongue
    body = {face: number for number, face in enumerate(sheet.panels.faces.tolist())}
    for joint in joints:
        names = _numbered(f"tongue_{joint.crease}", len(joint.tongues))
        home, face = joint.faces
        for ring, hole, label in zip(joint.tongues, joint.holes, names, strict=True):
            whole = prism(ring, low, top)
            strap = difference([whole, prism(hole, low, high)]) if len(hole) else whole
            yield _Row(body[face], _within(strap), label, face, joint.crease, False, home)


def _reach(levels: Levels) -> tuple[float, float]:
    """Bottom and top of cutters that go through all bodies."""
    return levels.low - BEYOND_MM, levels.high + BEYOND_MM


def _old(
    sheet: ThickSheet,
    number: int,
    cut: Callable[[Manifold], Manifold] | None,
    name: str,
    home: int,
) -> _Row:
    """What a cut leaves of a body of the sheet."""
    face, crease = int(sheet.faces[number]), int(sheet.creases[number])
    return _Row(number, cut, name, face, crease, bool(sheet.flexible[number]), home)


def _without(tools: Sequence[Manifold]) -> Callable[[Manifold], Manifold]:
    return lambda body: difference([body, *tools])


def _within(limit: Manifold) -> Callable[[Manifold], Manifold]:
    return lambda body: body ^ limit


def _made(old: Bodies, rows: Sequence[_Row]) -> Bodies:
    """What the rows cut from the old bodies; those that nothing is cut from as they are."""
    cuts = meshes([row.cut(solid(old.mesh(row.source))) for row in rows if row.cut is not None])
    fresh = iter(cuts)
    return bodies_of([old.mesh(row.source) if row.cut is None else next(fresh) for row in rows])


def _numbered(name: str, count: int) -> list[str]:
    return [name] if count == 1 else [f"{name}_{number + 1}" for number in range(count)]
