"""What is the flat shape of a folded sheet, and does it overlap itself?"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import shapely
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from fab.polygons import ring_areas
from solver.errors import InvalidValue
from solver.measure import isometry
from solver.mesh import Edges, QuadMesh, boundary_loops
from solver.vectors import ComplexArray, FloatArray, IntArray, cross, norm, unit

__all__ = ["Development", "develop", "overlapping_faces"]


# Faces that lie on each other by less than this share of the sheet's diagonal are in contact.
_CONTACT_REL = 1e-9


@dataclass(frozen=True)
class Development:
    """A sheet unfolded into the plane, its faces counterclockwise seen from +z.

    Attributes
    ----------
    vertices_coords : shape (nv, 2), in the units of the mesh; the box of least area around it
        stands on the origin, its longer side along x.
    isometry_max_rel : largest relative change of a side or diagonal of a face.
    closure_max : largest distance between the places that different faces give a vertex.
    overlaps : pairs of faces that overlap in the plane, shape (n, 2).
    """

    vertices_coords: FloatArray
    isometry_max_rel: float
    closure_max: float
    overlaps: IntArray


def develop(mesh: QuadMesh) -> Development:
    """Unfold a patch rigidly, face by face along a tree that avoids short edges.

    Every face is laid down as it is, so nothing is fitted: where the mesh is developable the
    faces agree on their vertices, and `closure_max` says how well. Cost: O(nf log nf).

    Raises `InvalidValue` for a mesh without faces, with a face without area, or in several pieces.
    """
    coords, faces = mesh.vertices_coords, mesh.faces_vertices
    if len(faces) == 0:
        raise InvalidValue("faces", 0, "be at least 1", "Grow a strip before developing.")
    local = _local_coordinates(coords, faces)
    root = int(np.argmin(norm(coords[faces].mean(axis=1) - coords.mean(axis=0))))
    parent, levels = _unfolding_tree(coords, mesh.edges, len(faces), root)
    turn, shift = _face_motions(local, faces, parent, levels)
    placed = turn[:, None] * local + shift[:, None]
    corner = faces.ravel()
    uses = np.bincount(corner, minlength=len(coords))
    with np.errstate(invalid="ignore"):
        mean = (
            np.bincount(corner, placed.real.ravel(), len(coords)) / uses
            + 1j * np.bincount(corner, placed.imag.ravel(), len(coords)) / uses
        )
    closure = float(np.abs(placed.ravel() - mean[corner]).max())
    flat = _upright(np.column_stack([mean.real, mean.imag]))
    return Development(
        flat,
        float(isometry(coords, flat, faces).max()),
        closure,
        overlapping_faces(flat, faces, mesh.edges),
    )


def _local_coordinates(coords: FloatArray, faces: IntArray) -> ComplexArray:
    """Corners of each face in its own plane, as complex numbers, shape (nf, 4)."""
    corners = coords[faces]
    first = corners[:, 2] - corners[:, 0]
    normal = cross(first, corners[:, 3] - corners[:, 1])
    flat = np.flatnonzero(~(norm(normal) > 0))
    if len(flat):
        raise InvalidValue(
            f"area of face {flat[0]}", 0.0, "be greater than 0", "Remove degenerate faces."
        )
    x = unit(first)
    y = cross(unit(normal), x)
    arm = corners - corners[:, :1]
    out: ComplexArray = np.einsum("fni,fi->fn", arm, x) + 1j * np.einsum("fni,fi->fn", arm, y)
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
    one, two = edges.edges_faces[shared].T
    cost = length.max() / np.maximum(length, 1e-100 * length.max()) if len(length) else length
    graph = csr_array((cost, (one, two)), shape=(count, count))
    distance, parent = dijkstra(graph, directed=False, indices=root, return_predecessors=True)
    if not np.isfinite(distance).all():
        lost = np.flatnonzero(~np.isfinite(distance))
        raise InvalidValue(
            "mesh",
            f"faces {root} and {lost[0]} not connected",
            "be one piece",
            "Develop each piece.",
        )
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
    local: ComplexArray, faces: IntArray, parent: IntArray, levels: list[IntArray]
) -> tuple[ComplexArray, ComplexArray]:
    """Rotation (unit complex) and shift that lay every face down."""
    child = np.concatenate(levels[1:]) if len(levels) > 1 else np.empty(0, np.int64)
    above = parent[child]
    # the shared edge: side j of the child runs from b to a where the parent's side runs a to b
    same = faces[child][:, :, None] == faces[above][:, None, :]
    back = same & np.roll(np.roll(same, -1, axis=1), 1, axis=2)  # child j+1 is parent i-1
    side, other = np.divmod(back.reshape(len(child), 16).argmax(axis=1), 4)
    row = np.arange(len(child))
    q0, q1 = local[child][row, side], local[child][row, (side + 1) % 4]
    p0, p1 = local[above][row, other], local[above][row, (other - 1) % 4]
    ratio = (p1 - p0) / (q1 - q0)
    ratio /= np.abs(ratio)
    step = (p0 + p1) / 2 - ratio * (q0 + q1) / 2
    turn = np.ones(len(faces), complex)
    shift = np.zeros(len(faces), complex)
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
    along, across = ring @ edge.T, ring @ np.column_stack([-edge[:, 1], edge[:, 0]]).T
    extent = np.ptp(along, axis=0), np.ptp(across, axis=0)
    area = extent[0] * extent[1]
    # equal boxes (a Miura sheet has two) must not be told apart by rounding
    best = int(np.flatnonzero(area <= area.min() * (1 + 1e-9))[0])
    u = edge[best]
    if extent[1][best] > extent[0][best]:
        u = np.array([-u[1], u[0]])
    if u[0] < -1e-12 or (abs(u[0]) <= 1e-12 and u[1] < 0):
        u = -u
    turned = np.column_stack([flat @ u, flat @ np.array([-u[1], u[0]])])
    out: FloatArray = turned - np.nanmin(turned, axis=0)
    return out


def overlapping_faces(flat: FloatArray, faces: IntArray, edges: Edges) -> IntArray:
    """Pairs of faces whose interiors overlap in the plane, shape (n, 2).

    Overlaps no deeper than 1e-9 of the sheet's diagonal are contact, not overlap.

    A sheet of one piece whose faces all turn the same way and whose outline does not cross itself
    cannot overlap; only where that fails are the faces compared pair by pair.
    """
    loops = boundary_loops(edges)
    areas = ring_areas(flat[faces].reshape(-1, 2), np.arange(len(faces) + 1) * 4)
    same_way = len(loops) == 1 and areas.min() > 0
    if same_way and shapely.is_valid(shapely.polygons(flat[loops[0]])):
        return np.empty((0, 2), np.int64)
    return np.array(list(_overlapping_pairs(flat, faces)), np.int64).reshape(-1, 2)


def _overlapping_pairs(flat: FloatArray, faces: IntArray) -> Iterator[tuple[int, int]]:
    shapes = shapely.polygons(flat[faces])
    valid = shapely.is_valid(shapes)
    for face in np.flatnonzero(~valid).tolist():
        yield face, face
    plain = np.flatnonzero(valid)
    # rounding lays neighbours on each other by slivers: a face overlaps what it meets when shrunk.
    # A yes or no about two shapes is exact, where their common area may fail to be built.
    contact = _CONTACT_REL * float(np.hypot(*np.ptp(flat[faces].reshape(-1, 2), axis=0)))
    shrunk = shapely.buffer(shapes[plain], -contact, join_style="mitre")
    one, two = plain[shapely.STRtree(shapes[plain]).query(shrunk, predicate="intersects")]
    pairs = np.unique(np.sort(np.column_stack([one, two])[one != two], axis=1), axis=0)
    yield from map(tuple, pairs.tolist())
