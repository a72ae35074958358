"""Hinges of a quad mesh: edges between two faces, with a corner of either face beyond them.

             end
first face | second face
           start
"""

from __future__ import annotations

import numpy as np

from solver.graphs import EdgeIndex
from solver.mesh import edges_of
from solver.vectors import IntArray

__all__ = ["hinges", "side_hinges"]


def hinges(faces_vertices: IntArray) -> IntArray:
    """Start and end of each inner edge, and a corner of either face beyond it, shape (n, 4).

    The edge runs in the direction of its first face, which is on its left; the third vertex is the
    one before the start in the first face, the fourth the one after it in the second.

    >>> hinges(np.array([[0, 1, 4, 3], [1, 2, 5, 4]])).tolist()
    [[1, 4, 0, 2]]
    """
    offsets = 4 * np.arange(len(faces_vertices) + 1)
    edges = edges_of(faces_vertices.ravel(), offsets)
    inner = edges.edges_faces[:, 1] >= 0
    ends, beside = edges.edges_vertices[inner], faces_vertices[edges.edges_faces[inner]]
    rows = np.arange(len(ends))
    start = (beside == ends[:, :1, None]).argmax(axis=2)
    first = beside[rows, 0, (start[:, 0] + 3) % 4]
    second = beside[rows, 1, (start[:, 1] + 1) % 4]
    return np.column_stack([ends, first, second])


def side_hinges(faces_vertices: IntArray, count: int) -> tuple[IntArray, IntArray]:
    """All `hinges`, and which of them each side of each face is, shape (nf, 4); -1 at the rim.

    count : number of vertices. Side k is from corner k to the next.

    >>> side_hinges(np.array([[0, 1, 4, 3], [1, 2, 5, 4]]), 6)[1].tolist()
    [[-1, 0, -1, -1], [-1, -1, -1, 0]]
    """
    inner = hinges(faces_vertices)
    sides = np.stack([faces_vertices, np.roll(faces_vertices, -1, axis=1)], axis=-1)
    found = EdgeIndex.of(inner[:, :2], count).find(sides.reshape(-1, 2))
    return inner, found.reshape(faces_vertices.shape)
