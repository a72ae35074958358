"""Development of a folded sheet: its flat shape, how exact it is, where it overlaps itself."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import shapely
from scipy.sparse.csgraph import dijkstra

from fab.geometry.rings import by_size
from fab.pattern.overlap import overlapping_faces
from solver.errors import InvalidValue
from solver.graphs import EdgeIndex, labels, weighted_graph
from solver.measure import isometry
from solver.mesh import Edges, QuadMesh
from solver.polygons import next_corner
from solver.vectors import ComplexArray, FloatArray, IntArray, cross, dot, norm, unit

__all__ = ["Development", "develop"]

# Distance of pieces that are laid side by side, in sizes of the largest.
_GAP = 0.03


@dataclass(frozen=True)
class Development:
    """A sheet unfolded into the plane, its faces counterclockwise seen from +z.

    Attributes
    ----------
    vertices_coords : shape (nv, 2), in the units of the mesh; the box of least area around it has
        a corner at the origin and its longer side along x.
    isometry_max_rel : largest relative change of a side or diagonal of a face.
    closure_max : largest distance between the places that different faces give a vertex.
    overlaps : pairs of faces that overlap in the plane, shape (n, 2).
    """

    vertices_coords: FloatArray
    isometry_max_rel: float
    closure_max: float
    overlaps: IntArray


def develop(mesh: QuadMesh) -> Development:
    """Unfold a sheet rigidly, face by face along a tree that avoids short edges.

    Sheets in several pieces are laid side by side, the largest first.

    Every face is laid down as it is, so nothing is fitted: where the mesh is developable the
    faces agree on their vertices, and `closure_max` says how well. Cost: O(nf log nf).

    Raises `InvalidValue` for a mesh without faces or with a face without area.

    >>> from solver import Miura
    >>> flat = develop(Miura(columns=4, rows=3).grow().mesh)
    >>> flat.isometry_max_rel < 1e-12, len(flat.overlaps)
    (True, 0)
    """
    count = len(mesh.polygons[1]) - 1
    if count == 0:
        raise InvalidValue("faces", 0, "be at least 1", "Grow a strip before developing.")
    beside = mesh.edges.edges_faces
    piece = labels(beside[beside[:, 1] >= 0], count)
    if not piece.any():
        return _developed(mesh)
    return _side_by_side(mesh, piece)


def _side_by_side(mesh: QuadMesh, piece: IntArray) -> Development:
    """Every piece unfolded, in shelves about as wide as all of them are high."""
    corner, offsets = mesh.polygons
    quads = len(mesh.faces_vertices)
    flat = np.zeros((len(mesh.vertices_coords), 2))
    parts, vertices, faces = [], [], []
    for number in range(int(piece.max()) + 1):
        mine = piece == number
        used = np.unique(corner[np.repeat(mine, np.diff(offsets))])
        rank = np.full(len(flat), -1)
        rank[used] = np.arange(len(used))
        part = QuadMesh(
            mesh.vertices_coords[used],
            rank[mesh.faces_vertices[mine[:quads]]],
            np.empty((0, 0), np.int64),
            pentagons=rank[mesh.pentagons[mine[quads:]]],
        )
        parts.append(_developed(part))
        vertices.append(used)
        faces.append(np.flatnonzero(mine))
    sizes = np.array([part.vertices_coords.max(axis=0) for part in parts])
    for number, corner_at in enumerate(_shelves(sizes)):
        flat[vertices[number]] = parts[number].vertices_coords + corner_at
    overlaps = [faces[k][part.overlaps] for k, part in enumerate(parts) if len(part.overlaps)]
    return Development(
        _upright(flat),
        max(part.isometry_max_rel for part in parts),
        max(part.closure_max for part in parts),
        np.concatenate(overlaps) if overlaps else np.empty((0, 2), np.int64),
    )


def _shelves(sizes: FloatArray) -> FloatArray:
    """Lower left corners of boxes of these sizes, in rows of falling height, shape (n, 2)."""
    gap = _GAP * float(sizes.max())
    width = max(float(sizes[:, 0].max()), float(np.sqrt((sizes + gap).prod(axis=1).sum())))
    out = np.zeros_like(sizes)
    x = y = high = 0.0
    for number in np.argsort(-sizes[:, 1], kind="stable").tolist():
        if x > 0 and x + sizes[number, 0] > width:
            x, y, high = 0.0, y + high + gap, 0.0
        out[number] = x, y
        x, high = x + float(sizes[number, 0]) + gap, max(high, float(sizes[number, 1]))
    return out


def _developed(mesh: QuadMesh) -> Development:
    """A sheet in one piece, unfolded."""
    coords = mesh.vertices_coords
    corner, offsets = mesh.polygons
    count, sizes = len(offsets) - 1, np.diff(offsets)
    local = _local_coordinates(coords, corner, offsets)
    centres = np.add.reduceat(coords[corner], offsets[:-1]) / sizes[:, None]
    root = int(np.argmin(norm(centres - coords.mean(axis=0))))
    parent, levels = _unfolding_tree(coords, mesh.edges, count, root)
    turn, shift = _face_motions(local, corner, offsets, mesh.edges, parent, levels)
    placed = np.repeat(turn, sizes) * local + np.repeat(shift, sizes)
    uses = np.bincount(corner, minlength=len(coords))
    with np.errstate(invalid="ignore"):
        mean = (
            np.bincount(corner, placed.real, len(coords)) / uses
            + 1j * np.bincount(corner, placed.imag, len(coords)) / uses
        )
    closure = float(np.abs(placed - mean[corner]).max())
    flat = _upright(np.column_stack([mean.real, mean.imag]))
    return Development(
        flat,
        max(float(isometry(coords, flat, f).max()) for _, f in by_size(corner, offsets)),
        closure,
        overlapping_faces(flat, corner, offsets, mesh.edges),
    )


def _local_coordinates(coords: FloatArray, corner: IntArray, offsets: IntArray) -> ComplexArray:
    """Corners of each face in its own plane, as complex numbers, shape (total,)."""
    sizes = np.diff(offsets)
    arm = coords[corner] - np.repeat(coords[corner[offsets[:-1]]], sizes, axis=0)
    normal = np.add.reduceat(cross(arm, arm[next_corner(offsets)]), offsets[:-1])
    flat = np.flatnonzero(~(norm(normal) > 0))
    if len(flat):
        raise InvalidValue(
            f"area of face {flat[0]}", 0.0, "be greater than 0", "Remove degenerate faces."
        )
    x = unit(arm[offsets[:-1] + 2])
    y = cross(unit(normal), x)
    out: ComplexArray = dot(arm, np.repeat(x, sizes, 0)) + 1j * dot(arm, np.repeat(y, sizes, 0))
    return out


def _unfolding_tree(
    coords: FloatArray, edges: Edges, count: int, root: int
) -> tuple[IntArray, list[IntArray]]:
    """Parent of each face, and the faces of each depth.

    A turn across an edge is uncertain by rounding over the edge's length, so the tree of least
    summed 1 / length keeps the error of every face least.
    """
    shared = edges.edges_faces[:, 1] >= 0
    ends = coords[edges.edges_vertices[shared]]
    length = norm(ends[:, 1] - ends[:, 0])
    cost = length.max() / np.maximum(length, 1e-100 * length.max()) if len(length) else length
    graph = weighted_graph(cost, edges.edges_faces[shared], count)
    distance, parent = dijkstra(graph, directed=False, indices=root, return_predecessors=True)
    depth = np.full(count, -1)
    depth[root] = 0
    order = np.argsort(distance, kind="stable")
    up = parent.tolist()
    rank = depth.tolist()
    for face in order[1:].tolist():
        rank[face] = rank[up[face]] + 1
    depth = np.array(rank)
    by_depth = np.argsort(depth, kind="stable")
    bounds = np.searchsorted(depth[by_depth], np.arange(depth.max() + 2))
    return parent, [by_depth[i:j] for i, j in pairwise(bounds)]


def _face_motions(
    local: ComplexArray,
    corner: IntArray,
    offsets: IntArray,
    edges: Edges,
    parent: IntArray,
    levels: list[IntArray],
) -> tuple[ComplexArray, ComplexArray]:
    """Rotation (unit complex) and shift that lay every face down."""
    child = np.concatenate(levels[1:]) if len(levels) > 1 else np.empty(0, np.int64)
    # the edge to the parent; of several between two faces (a straight crease) the first
    shared = np.flatnonzero(edges.edges_faces[:, 1] >= 0)
    count = len(parent)
    beside = EdgeIndex.of(edges.edges_faces[shared], count)
    found = shared[beside.find(np.column_stack([child, parent[child]]))] if len(child) else child
    # it runs from u to v in the parent and back in the child
    u, v = edges.edges_vertices[found].T
    swap = edges.edges_faces[found, 0] == child
    u, v = np.where(swap, v, u), np.where(swap, u, v)
    following = next_corner(offsets)
    ends = np.column_stack([corner, corner[following]])
    sides = EdgeIndex.of(ends, int(corner.max()) + 1, directed=True)

    def side(start: IntArray, end: IntArray) -> tuple[ComplexArray, ComplexArray]:
        at = sides.find(np.column_stack([start, end]))
        return local[at], local[following[at]]

    q0, q1 = side(v, u)
    p1, p0 = side(u, v)
    ratio = (p1 - p0) / (q1 - q0)
    ratio /= np.abs(ratio)
    step = (p0 + p1) / 2 - ratio * (q0 + q1) / 2
    turn = np.ones(count, complex)
    shift = np.zeros(count, complex)
    start = 0
    for level in levels[1:]:
        part = slice(start, start + len(level))
        start += len(level)
        g = parent[level]
        turned = turn[g] * ratio[part]
        turn[level] = turned / np.abs(turned)
        shift[level] = turn[g] * step[part] + shift[g]
    return turn, shift


def _upright(flat: FloatArray) -> FloatArray:
    """Rotate the box of least area onto the axes, longer side along x, lower left at (0, 0)."""
    used = np.isfinite(flat[:, 0])
    hull = shapely.convex_hull(shapely.multipoints(flat[used]))
    ring = shapely.get_coordinates(hull)[:-1]
    edge = np.diff(np.vstack([ring, ring[:1]]), axis=0)
    edge /= np.hypot(edge[:, 0], edge[:, 1])[:, None]
    across = np.column_stack([-edge[:, 1], edge[:, 0]])
    chunks = range(0, len(edge), 256)  # a hull of ten thousand corners would fill the memory
    extent = tuple(
        np.concatenate([np.ptp(ring @ axis[i : i + 256].T, axis=0) for i in chunks])
        for axis in (edge, across)
    )
    area = extent[0] * extent[1]
    # rounding must not decide between equal boxes (a Miura sheet has two)
    best = int(np.flatnonzero(area <= area.min() * (1 + 1e-9))[0])
    u = edge[best]
    if extent[1][best] > extent[0][best]:
        u = np.array([-u[1], u[0]])
    if u[0] < -1e-12 or (abs(u[0]) <= 1e-12 and u[1] < 0):
        u = -u
    turned = np.column_stack([flat @ u, flat @ np.array([-u[1], u[0]])])
    out: FloatArray = turned - np.nanmin(turned, axis=0)
    return out
