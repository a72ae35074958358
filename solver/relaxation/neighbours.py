"""Neighbours in a quad mesh: rings around vertices, opposite vertices.

    around an interior vertex v, counterclockwise
    seen from the upper side:
             2
             |
          3--v--1
             |
             0

All are found from `faces_vertices` alone, shape (nf, 4), whether the mesh is a grid, a tube or
neither.
"""

from __future__ import annotations

import numpy as np

from solver.graphs import EdgeIndex
from solver.mesh import edges_of, interior_vertices
from solver.vectors import IntArray

__all__ = ["opposite_pairs", "sides", "vertex_rings"]


def sides(faces_vertices: IntArray) -> IntArray:
    """Unique sides of the faces, shape (ne, 2), in the order in which the faces name them."""
    offsets = 4 * np.arange(len(faces_vertices) + 1)
    return edges_of(faces_vertices.ravel(), offsets).edges_vertices


def vertex_rings(faces_vertices: IntArray, count: int) -> IntArray:
    """Each interior vertex and its neighbours, counterclockwise, shape (n, 1 + k).

    count : number of vertices. k is the largest number of neighbours, or 4 if that is more; rows
    with fewer neighbours end with -1.

    >>> faces = np.array([[0, 1, 4, 3], [1, 2, 5, 4], [3, 4, 7, 6], [4, 5, 8, 7]])
    >>> vertex_rings(faces, 9).tolist()
    [[4, 3, 1, 5, 7]]
    """
    inside = np.flatnonzero(interior_vertices(faces_vertices, count))
    corner, after, before = _corners(faces_vertices)
    valence = np.bincount(corner, minlength=count)[inside]
    rings = np.full((len(inside), 1 + int(valence.max(initial=4))), -1)
    if not len(inside):
        return rings
    index = EdgeIndex.of(np.column_stack([corner, after]), count, directed=True)
    rings[:, 0] = inside
    first = np.full(count, -1)
    first[corner[::-1]] = after[::-1]
    rings[:, 1] = first[inside]
    for k in range(2, rings.shape[1]):
        going = valence >= k
        sector = index.find(rings[going][:, [0, k - 1]])
        rings[going, k] = before[sector]
    return rings


def opposite_pairs(faces_vertices: IntArray, count: int) -> IntArray:
    """Vertices two apart along a grid line, each pair once, shape (n, 2).

    They are opposite each other around an interior vertex of four faces, along the boundary around
    a vertex of two, or both around one of three, where the outline has a concave corner.

    >>> faces = np.array([[0, 1, 4, 3], [1, 2, 5, 4]])
    >>> opposite_pairs(faces, 6).tolist()
    [[0, 2], [5, 3]]
    """
    rings = vertex_rings(faces_vertices, count)
    regular = rings[(rings >= 0).sum(axis=1) == 5]
    inner = regular[:, [1, 3, 2, 4]].reshape(-1, 2)
    corner, after, before = _corners(faces_vertices)
    rim = ~interior_vertices(faces_vertices, count)
    size = np.bincount(corner, minlength=count)
    # of the sectors at such a vertex one begins and another one ends at the boundary
    starts = ~np.isin(corner * count + after, corner * count + before) & rim[corner]
    ends = ~np.isin(corner * count + before, corner * count + after) & rim[corner]
    neighbours = np.full((4, count), -1)  # of the first sector, and of the last
    for k, (side, of) in enumerate(
        ((after, starts), (before, starts), (after, ends), (before, ends))
    ):
        neighbours[k, corner[of]] = side[of]
    first, second, third, last = neighbours
    two, three = rim & (size == 2), rim & (size == 3)
    outer = np.column_stack([last[two], first[two]])
    across = np.column_stack([third[three], first[three], last[three], second[three]])
    outer = np.concatenate([outer, across.reshape(-1, 2)])
    return np.concatenate([inner, outer])


def _corners(faces_vertices: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Corners of all faces with the vertices after and before them."""
    after, before = np.roll(faces_vertices, -1, axis=1), np.roll(faces_vertices, 1, axis=1)
    return faces_vertices.ravel(), after.ravel(), before.ravel()
