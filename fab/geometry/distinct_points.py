"""Points of the plane, each once."""

from __future__ import annotations

import numpy as np

from solver.vectors import FloatArray, IntArray

__all__ = ["distinct_points"]


def distinct_points(points: FloatArray) -> tuple[FloatArray, IntArray]:
    """Distinct points by their coordinates, x first, and which of them each one is.

    points : shape (n, 2). As `numpy.unique` of rows, which compares these one by one.

    >>> distinct, place = distinct_points(np.array([[1.0, 2.0], [0.0, 5.0], [1.0, 2.0]]))
    >>> distinct.tolist(), place.tolist()
    ([[0.0, 5.0], [1.0, 2.0]], [1, 0, 1])
    """
    order = np.lexsort((points[:, 1], points[:, 0]))
    new = np.ones(len(points), bool)
    new[1:] = (points[order][1:] != points[order][:-1]).any(axis=1)
    place = np.empty(len(points), np.int64)
    place[order] = np.cumsum(new) - 1
    return points[order][new], place
