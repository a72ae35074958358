"""The bodies of a sheet with joints: pockets in panels, webs cut to their tongues, tongues."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import shapely

from fab.geometry.bodies import Bodies, TriangleMesh, bodies_of
from fab.geometry.booleans import difference, meshes, prism, solid
from fab.panels.film_parts import connected, film_numbers, film_regions, film_solid
from fab.panels.thick_sheet import ThickSheet
from fab.printing.dovetails import Joint
from fab.printing.joint_plans import Levels, joint_levels
from fab.printing.knuckle_joints import BEYOND_MM
from fab.printing.plate_settings import JointSettings
from solver.vectors import IntArray

if TYPE_CHECKING:
    from manifold3d import Manifold

__all__ = ["jointed"]


@dataclass(frozen=True)
class _Row:
    """A body of the jointed sheet: what is cut from which old one, and its attributes.

    home : the face with whose part it is printed. made : the body itself, where it is no cut.
    """

    source: int
    cut: Callable[[Manifold], Manifold] | None
    name: str
    face: int
    crease: int
    flexible: bool
    home: int
    made: TriangleMesh | None = None


def jointed(
    sheet: ThickSheet, joints: Sequence[Joint], settings: JointSettings, faces_part: IntArray
) -> tuple[ThickSheet, IntArray]:
    """The sheet with its joints, and for each of its bodies the face with whose part it is printed.

    Panels with pockets stay in their places; webs are cut to their tongues, or left out where a
    crease is taped; films are cut along the creases between parts; tongues come last, each a body
    that moves with the face of its pocket.

    faces_part : shape (nf,), the part of each face, -1 for those without a panel: what is below
    these comes with a face beside them.
    """
    levels = joint_levels(sheet, settings)
    rows = [
        *_panel_rows(sheet, joints, levels),
        *_web_rows(sheet, joints, levels),
        *_film_rows(sheet, faces_part),
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
    cutters: dict[int, list[Manifold]] = {}
    for joint in joints:
        own = cutters.setdefault(joint.faces[1], [])
        top = high if levels.through or joint.through else levels.roof
        own += [prism(ring, low, top) for ring in joint.pockets]
        own += [prism(ring, low, high) for ring in joint.holes if len(ring)]
        for face, ring in joint.cleared:
            cutters.setdefault(face, []).append(prism(ring, low, high))
    for number in range(len(sheet.panels.bodies)):
        face = int(sheet.faces[number])
        cut = _without(cutters[face]) if face in cutters else None
        yield _old(sheet, number, cut, sheet.names[number], face)


def _web_rows(sheet: ThickSheet, joints: Sequence[Joint], levels: Levels) -> Iterator[_Row]:
    """Bodies that are no panels: webs below tongues, and whole ones."""
    by_crease = {joint.crease: joint for joint in joints}
    films = set(film_numbers(sheet).tolist())
    for number in range(len(sheet.panels.bodies), len(sheet.bodies)):
        if number in films:
            continue
        face, edge = int(sheet.faces[number]), int(sheet.creases[number])
        name = sheet.names[number]
        if edge in by_crease:
            mouths, home = by_crease[edge].mouths, by_crease[edge].faces[0]
            for ring, label in zip(mouths, _numbered(name, len(mouths)), strict=True):
                yield _old(sheet, number, _within(prism(ring, *_reach(levels))), label, home)
        else:
            home = face if face >= 0 else int(sheet.pattern.edges_faces[edge, 0])
            yield _old(sheet, number, None, name, home)


def _film_rows(sheet: ThickSheet, faces_part: IntArray) -> Iterator[_Row]:
    """Films, a body for each part of the sheet that they lie below."""
    part = _of_all_faces(sheet, faces_part)
    for number in film_numbers(sheet).tolist():
        film, name = sheet.bodies.mesh(number), sheet.names[number]
        regions: dict[int, list[shapely.Polygon]] = {}
        for region, face in film_regions(film, sheet.pattern):
            if part[face] >= 0:
                regions.setdefault(int(part[face]), []).append(region)
        if len(regions) == 1:
            home = int(np.flatnonzero(faces_part == next(iter(regions)))[0])
            yield _old(sheet, number, None, name, home)
            continue
        pieces = [(owner, own) for owner in sorted(regions) for own in connected(regions[owner])]
        labels = _numbered(name, len(pieces))
        for (owner, own), label in zip(pieces, labels, strict=True):
            home = int(np.flatnonzero(faces_part == owner)[0])
            yield _Row(number, None, label, -1, -1, True, home, film_solid(own, film))


def _of_all_faces(sheet: ThickSheet, faces_part: IntArray) -> IntArray:
    """The part of every face; those without a panel go with a face beside them."""
    out = faces_part.copy()
    beside = sheet.pattern.edges_faces[sheet.pattern.edges_joining]
    both = np.concatenate([beside, beside[:, ::-1]])
    while True:
        gives = both[(out[both[:, 0]] < 0) & (out[both[:, 1]] >= 0)]
        if not len(gives):
            return out
        out[gives[:, 0]] = out[gives[:, 1]]


def _tongue_rows(sheet: ThickSheet, joints: Sequence[Joint], levels: Levels) -> Iterator[_Row]:
    """Tongues, cut from the panels of their pockets."""
    low, high = _reach(levels)
    body = {face: number for number, face in enumerate(sheet.panels.faces.tolist())}
    for joint in joints:
        names = _numbered(f"tongue_{joint.crease}", len(joint.tongues))
        home, face = joint.faces
        top = high if levels.through or joint.through else levels.tongue
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

    def mesh(row: _Row) -> TriangleMesh:
        if row.made is not None:
            return row.made
        return old.mesh(row.source) if row.cut is None else next(fresh)

    return bodies_of([mesh(row) for row in rows])


def _numbered(name: str, count: int) -> list[str]:
    return [name] if count == 1 else [f"{name}_{number + 1}" for number in range(count)]
