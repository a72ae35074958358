"""Sheets that end at the rim of their surface: cells beyond it dropped, creases shortened to it.

        o---o---o            a vertex with two faces ends a crease: it moves along this crease;
        |   |   |            one with a single face is a corner: it moves along a diagonal, or
    - - + - + - + - rim      along the side that ends in it;
        |   |   |            one with three faces stays, for its creases run on.
        o---o---o

Faces stay planar and sectors as they are: the sheet is as exact as before. A face at the rim has a
free side, which may swing into another one: such faces are dropped.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from solver.coverage import one_piece
from solver.graphs import EdgeIndex
from solver.mesh import QuadMesh, edges_of, grid_faces
from solver.self_intersection import crossing_faces
from solver.targets.mesh_target import MeshTarget
from solver.vectors import BoolArray, FloatArray, IntArray, norm

__all__ = ["shares_over", "trimmed", "trimmings"]

# Points along either direction of a face at which it is seen whether it is over the surface.
_WITHIN = (np.arange(8) + 0.5) / 8
# Faces that are looked at together.
_AT_ONCE = 4000
# Faces with less than this share over the surface may be dropped, together this share of the whole.
_SLIVER = 0.2
_MAY_MISS = 0.003
# A crease keeps at least this share of its length, a diagonal the second one.
_SHORTEST = 0.3
_SHORTEST_DIAGONAL = 0.6
# Halvings of the way along a crease: its end is found to 2^-20 of its length.
_HALVINGS = 20
# Steps in which a side gets its length back.
_EASINGS = 8


def shares_over(target: MeshTarget, coords: FloatArray, faces_vertices: IntArray) -> FloatArray:
    """Which share of each face is over the surface and not beyond its rim, shape (nf,)."""
    s, t = (a.reshape(-1, 1) for a in np.meshgrid(_WITHIN, _WITHIN))
    weights = np.stack([(1 - s) * (1 - t), s * (1 - t), s * t, (1 - s) * t])
    share = np.empty(len(faces_vertices))
    for first in range(0, len(faces_vertices), _AT_ONCE):
        block = slice(first, first + _AT_ONCE)
        within = np.einsum("kpq,fkd->fpd", weights, coords[faces_vertices[block]])
        over = _over(target, within.reshape(-1, 3))
        share[block] = over.reshape(within.shape[:2]).mean(axis=1)
    return share


def trimmed(
    target: MeshTarget,
    mesh: QuadMesh,
    fine: Callable[[FloatArray, IntArray], BoolArray] | None = None,
    most_beyond: float = np.inf,
    may_fall: float = 0.0,
) -> QuadMesh:
    """The sheet without cells beyond the rim of its surface, its sides shortened to the rim.

    mesh : an open patch. Cells with less than a fifth over the surface are dropped, as long as no
    more than 0.3 % of the sheet is lost. Where a side would keep less than 0.3 of its length it is
    left longer. Faces of the rim that cross others are dropped where no more than 0.3 % of
    all have to be. fine : of vertices and faces, whether each face may be so; where one is not fine
    any more, its sides are left longer too. most_beyond : vertices that remain farther beyond the
    rim lose a face each, as long as no more than the share `may_fall` of the sheet is lost so.
    """
    return next(trimmings(target, mesh, [may_fall], fine, most_beyond))


def trimmings(
    target: MeshTarget,
    mesh: QuadMesh,
    may_fall: Sequence[float],
    fine: Callable[[FloatArray, IntArray], BoolArray] | None = None,
    most_beyond: float = np.inf,
) -> Iterator[QuadMesh]:
    """The sheet as it is `trimmed` with each of several shares that may be lost, one by one."""
    share = shares_over(target, mesh.vertices_coords, mesh.faces_vertices)
    if not share.any():  # a sheet that went astray
        yield from (mesh for _ in may_fall)
        return
    whole = _without(mesh, _slivers(share))
    for fall in may_fall:
        yield _cut_short(target, whole, fine, most_beyond, fall * float(share.sum()))


def _cut_short(
    target: MeshTarget,
    mesh: QuadMesh,
    fine: Callable[[FloatArray, IntArray], BoolArray] | None,
    most_beyond: float,
    budget: float,
) -> QuadMesh:
    """The sheet shortened to the rim, without faces of vertices too far beyond; see `trimmed`."""
    while True:
        short = _shortened(target, mesh)
        if fine is not None:
            eased = _eased(mesh.vertices_coords, short.vertices_coords, mesh.faces_vertices, fine)
            short = replace(short, vertices_coords=eased)
        drop, lost = _far_beyond(target, short, most_beyond, budget)
        budget -= lost
        left = _without(mesh, drop)  # which fills up corners that touch: it may drop none
        if len(left.faces_vertices) == len(mesh.faces_vertices):
            return _uncrossed(short)
        mesh = left


def _far_beyond(
    target: MeshTarget, mesh: QuadMesh, most: float, budget: float
) -> tuple[BoolArray, float]:
    """Faces of vertices that are too far beyond the rim, and their share that is over the surface.

    One for each vertex, that with the least share over the surface; the farthest vertices first,
    as many as the budget of shares allows.
    """
    coords, faces = mesh.vertices_coords, mesh.faces_vertices
    _, _, places = target.distance(coords, target.unknown(len(coords)))
    beyond = norm(target.point(places) - target.mesh_point(places))
    around = np.flatnonzero((beyond > most)[faces].any(axis=1))
    if not len(around):
        return np.zeros(len(faces), bool), 0.0
    share = shares_over(target, coords, faces[around])
    drop, lost = np.zeros(len(faces), bool), 0.0
    for vertex in np.argsort(-beyond, kind="stable")[: np.count_nonzero(beyond > most)].tolist():
        beside = np.flatnonzero((faces[around] == vertex).any(axis=1))
        if not len(beside) or drop[around[beside]].any():
            continue
        least = beside[np.argmin(share[beside])]
        if lost + share[least] <= budget:
            drop[around[least]] = True
            lost += float(share[least])
    return drop, lost


def _shortened(target: MeshTarget, mesh: QuadMesh) -> QuadMesh:
    """The mesh with the sides that end beyond the rim shortened to it."""
    coords, faces = mesh.vertices_coords.copy(), mesh.faces_vertices
    count = np.bincount(faces.ravel(), minlength=len(coords))
    edges = edges_of(faces.ravel(), 4 * np.arange(len(faces) + 1))
    ends = np.concatenate([edges.edges_vertices, edges.edges_vertices[:, ::-1]])
    inner = np.tile(edges.edges_faces[:, 1] >= 0, 2)
    outer = np.zeros(len(coords), bool)
    outer[edges.edges_vertices[edges.edges_faces[:, 1] < 0]] = True
    # ends of creases: one inner edge, two faces
    sliding = inner & outer[ends[:, 0]] & (count[ends[:, 0]] == 2)
    # corners beside another corner: the face is held by one edge alone, both slide along its sides
    corner = (count == 1)[ends[:, 0]]
    paired = np.zeros(len(coords), bool)
    both = corner & (count == 1)[ends[:, 1]]
    paired[ends[both, 0]] = True
    sliding |= corner & paired[ends[:, 0]] & (count[ends[:, 1]] > 1)
    _slide(target, coords, ends[sliding, 1], ends[sliding, 0], _SHORTEST)
    face, place = np.nonzero((count == 1)[faces] & ~paired[faces])
    _slide(target, coords, faces[face, (place + 2) % 4], faces[face, place], _SHORTEST_DIAGONAL)
    return replace(mesh, vertices_coords=coords)


def _uncrossed(mesh: QuadMesh) -> QuadMesh:
    """The mesh without faces of its rim that cross others; as it is where others cross too."""
    faces = mesh.faces_vertices
    pairs = crossing_faces(mesh.vertices_coords, *mesh.polygons)
    edges_faces = edges_of(faces.ravel(), 4 * np.arange(len(faces) + 1)).edges_faces
    rim = np.zeros(len(faces), bool)
    rim[edges_faces[edges_faces[:, 1] < 0, 0]] = True
    drop = np.zeros(len(faces), bool)
    while len(pairs) and drop.sum() + 1 <= _MAY_MISS * len(faces):
        crossed = np.where(rim, np.bincount(pairs.ravel(), minlength=len(faces)), 0)
        worst = int(np.argmax(crossed))
        if not crossed[worst]:
            break
        drop[worst] = True
        pairs = pairs[(pairs != worst).all(axis=1)]
    return mesh if len(pairs) or not drop.any() else _without(mesh, drop)


def _eased(
    whole: FloatArray,
    short: FloatArray,
    faces: IntArray,
    fine: Callable[[FloatArray, IntArray], BoolArray],
) -> FloatArray:
    """Vertices between `whole` and `short`, as short as faces that were fine remain so."""
    share = np.ones((len(whole), 1))
    hurt = fine(whole, faces)
    for k in range(_EASINGS):
        between = whole + share * (short - whole)
        bad = faces[hurt & ~fine(between, faces)]
        if not len(bad):
            return between
        share[bad] = share[bad] - 1 / _EASINGS if k < _EASINGS - 1 else 0.0
        share = np.maximum(share, 0.0)
    return whole + share * (short - whole)


def _slivers(share: FloatArray) -> BoolArray:
    """Faces that are hardly over the surface."""
    order = np.argsort(share, kind="stable")
    lost = np.cumsum(share[order]) <= _MAY_MISS * share.sum()
    drop = np.zeros(len(share), bool)
    drop[order] = lost & (share[order] < _SLIVER)
    return drop


def _without(mesh: QuadMesh, drop: BoolArray) -> QuadMesh:
    """The mesh without the faces to drop, shape (nf,), in one piece."""
    corners = grid_faces(mesh.grid, mesh.closed)
    number = EdgeIndex.of(mesh.faces_vertices[:, [0, 2]], len(mesh.vertices_coords), directed=True)
    face = number.find(corners[:, [0, 2]])
    cells = (corners >= 0).all(axis=1) & (face >= 0)
    kept = cells & ~drop[face]
    shape = mesh.grid.shape[0] - 1, -1
    return mesh.with_faces(one_piece(kept.reshape(shape), cells.reshape(shape)))


def _slide(
    target: MeshTarget, coords: FloatArray, start: IntArray, end: IntArray, shortest: float
) -> None:
    """Move the vertices `end` towards `start`, as far as the rim where they are beyond it."""
    if not len(end):
        return
    arm = coords[end] - coords[start]
    beyond = ~_over(target, coords[end])
    low, high = np.full(len(end), shortest), np.ones(len(end))
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        over = _over(target, coords[start] + middle[:, None] * arm)
        low, high = np.where(over, middle, low), np.where(over, high, middle)
    coords[end[beyond]] = (coords[start] + low[:, None] * arm)[beyond]


def _over(target: MeshTarget, points: FloatArray) -> BoolArray:
    """Whether the nearest point of the surface is not on its rim, or the point is just above it."""
    _, _, places = target.distance(points, target.unknown(len(points)))
    aside = norm(target.point(places) - target.mesh_point(places))
    over: BoolArray = aside <= 1e-9 * target.mesh.size
    return over
