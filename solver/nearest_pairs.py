"""Points of different groups that are nearest to each other."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from solver.vectors import FloatArray, IntArray

__all__ = ["nearest_pairs"]


def nearest_pairs(points: FloatArray, group: IntArray, reach: float) -> IntArray:
    """Pairs of points of different groups, each the nearest to the other, within reach, (n, 2).

    points : shape (n, 3). group : of each point, shape (n,).

    >>> points = np.array([[0.0, 0, 0], [5, 0, 0], [0, 1, 0], [0, 3, 0]])
    >>> nearest_pairs(points, np.array([0, 0, 1, 1]), 2.0).tolist()
    [[0, 2]]
    """
    nearest, far = np.full(len(points), -1), np.full(len(points), np.inf)
    for number in np.unique(group):
        own, others = np.flatnonzero(group == number), np.flatnonzero(group != number)
        if len(others):
            far[own], found = cKDTree(points[others]).query(points[own])
            nearest[own] = others[found]
    known = np.flatnonzero(far <= reach)
    mutual = known[nearest[nearest[known]] == known]
    first = mutual[mutual < nearest[mutual]]
    return np.column_stack([first, nearest[first]])
