"""Bodies of a thick sheet that are checked together, and which pairs of them may touch."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fab.geometry.bodies import Bodies, TriangleMesh, bodies_of
from fab.geometry.booleans import corners_and_triangles
from fab.panels.thick_sheet import ThickSheet
from solver.vectors import BoolArray, IntArray

if TYPE_CHECKING:
    from manifold3d import Manifold

__all__ = ["CheckedBodies", "checked_bodies", "faces_with_barrels", "may_touch"]


@dataclass(frozen=True)
class CheckedBodies:
    """Some bodies of a sheet, where they are when flat.

    Attributes
    ----------
    bodies : with the convex hull in place of each body with knuckles: a plane that separates two
        hulls separates the bodies, and is as far from both.
    solids : the bodies themselves, for exact measures.
    names : such as "panel 3". faces, creases : as in a `ThickSheet`.
    mates, mates_edge : shapes (k, 2) and (k,): panels across a crease, and that crease.
    linked : shape (k,), the number of the knuckles that join them, -1 without.
    """

    bodies: Bodies
    solids: list[Manifold]
    names: tuple[str, ...]
    faces: IntArray
    creases: IntArray
    mates: IntArray
    mates_edge: IntArray
    linked: IntArray


def checked_bodies(sheet: ThickSheet, solids: list[Manifold], chosen: IntArray) -> CheckedBodies:
    """Some of the bodies of a sheet, by rising number. solids : all of them."""
    faces, creases = sheet.faces[chosen], sheet.creases[chosen]
    place = np.full(sheet.pattern.face_count, -1)
    panels = np.flatnonzero((creases < 0) & (faces >= 0))
    place[faces[panels]] = panels
    mates = place[sheet.pattern.edges_faces]
    edges = np.flatnonzero(sheet.pattern.edges_joining & (mates >= 0).all(axis=1))
    every = len(chosen) == len(sheet.bodies)
    bodies = sheet.bodies if every else sheet.bodies.chosen(chosen)
    chosen_solids = [solids[body] for body in chosen.tolist()]
    with_barrels = np.isin(faces, faces_with_barrels(sheet)) & (creases < 0)
    if with_barrels.any():
        bodies = bodies_of(
            [
                _hull(chosen_solids[i]) if hollow else bodies.mesh(i)
                for i, hollow in enumerate(with_barrels.tolist())
            ]
        )
    linked = np.full(len(mates), -1)
    linked[sheet.knuckles.creases] = np.arange(len(sheet.knuckles.creases))
    return CheckedBodies(
        bodies,
        chosen_solids,
        tuple(sheet.names[body].replace("_", " ") for body in chosen.tolist()),
        faces,
        creases,
        np.sort(mates[edges], axis=1),
        edges,
        linked[edges],
    )


def faces_with_barrels(sheet: ThickSheet) -> IntArray:
    """The faces whose panels have barrels of knuckles, rising."""
    return np.unique(sheet.pattern.edges_faces[sheet.knuckles.creases])


def _hull(solid: Manifold) -> TriangleMesh:
    """The convex hull of a body; each triangle is a side of its own."""
    coords, triangles = corners_and_triangles(solid.hull())
    return TriangleMesh(coords, triangles, np.arange(len(triangles)))


def may_touch(checked: CheckedBodies, pairs: IntArray) -> BoolArray:
    """Whether both bodies are of one face, or one of them is a hinge, shape (n,).

    pairs : shape (n, 2), numbers of bodies.
    """
    first, second = checked.faces[pairs].T
    hinge = (checked.faces < 0) | (checked.creases >= 0)
    return np.asarray((first == second) | hinge[pairs].any(axis=1))
