"""Fold angles between two triangles or faces on a common edge, and their gradients."""

from __future__ import annotations

import numpy as np

from solver.vectors import FloatArray, IntArray, cross, dot, norm

__all__ = ["hinge_angles", "hinge_gradients"]


def hinge_angles(coords: FloatArray, hinges_vertices: IntArray) -> FloatArray:
    """Fold angles of hinges, radians in (-pi, pi], valley positive, shape (n,).

    coords : shape (nv, 3). hinges_vertices : shape (n, 4), both ends of the common edge, then a
        corner on its left and one on its right.

    >>> coords = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    >>> np.degrees(hinge_angles(coords, np.array([[0, 1, 2, 3]]))).tolist()
    [90.0]
    """
    e, p, q = _sides(coords, hinges_vertices)
    first, second = cross(e, p), cross(q, e)
    out: FloatArray = np.arctan2(dot(cross(second, first), e) / norm(e), dot(first, second))
    return out


def hinge_gradients(coords: FloatArray, hinges_vertices: IntArray) -> FloatArray:
    """Gradients of fold angles, shape (n, 4, 3): both corners rise along their faces' normals.

    As `hinge_angles`; Schenk and Guest (2011), after Bekker.
    """
    e, p, q = _sides(coords, hinges_vertices)
    length, square = norm(e)[:, None], dot(e, e)
    first, second = cross(e, p), cross(q, e)
    at_p = length * first / dot(first, first)[:, None]
    at_q = length * second / dot(second, second)[:, None]
    a, b = (dot(p, e) / square)[:, None], (dot(q, e) / square)[:, None]
    start = -(1 - a) * at_p - (1 - b) * at_q
    return np.stack([start, -a * at_p - b * at_q, at_p, at_q], axis=1)


def _sides(
    coords: FloatArray, hinges_vertices: IntArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Along the common edge, and from its first end to both corners off it."""
    start = coords[hinges_vertices[:, 0]]
    along, first, second = (coords[hinges_vertices[:, k]] - start for k in (1, 2, 3))
    return along, first, second
