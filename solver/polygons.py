"""Polygons one after another: corners of all of them, and where each begins."""

from __future__ import annotations

import numpy as np

from solver.vectors import FloatArray, IntArray, cross, unit

__all__ = ["face_normals", "next_corner"]


def next_corner(offsets: IntArray) -> IntArray:
    """Index of the following corner in the same ring, for all rings' corners.

    >>> next_corner(np.array([0, 3, 7])).tolist()
    [1, 2, 0, 4, 5, 6, 3]
    """
    following = np.arange(offsets[-1]) + 1
    following[offsets[1:] - 1] = offsets[:-1]
    return following


def face_normals(
    coords: FloatArray, faces_vertices: IntArray, faces_offsets: IntArray
) -> FloatArray:
    """Unit area normals of polygons in space, shape (nf, 3)."""
    sizes = np.diff(faces_offsets)
    corner = coords[faces_vertices] - np.repeat(
        coords[faces_vertices[faces_offsets[:-1]]], sizes, 0
    )
    following = corner[next_corner(faces_offsets)]
    return unit(np.add.reduceat(cross(corner, following), faces_offsets[:-1]))
