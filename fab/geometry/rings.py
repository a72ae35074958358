"""Rings: polygons one after another in an array, walked, sorted by size, measured.

Ring i has the corners offsets[i]:offsets[i + 1]; offsets has one entry more than there are rings.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from solver.polygons import next_corner
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["are_convex", "by_size", "is_hole", "ring_areas"]


def by_size(corners: IntArray, offsets: IntArray) -> Iterator[tuple[IntArray, IntArray]]:
    """For each number n of corners: the rings that have it, and their corners (n', n)."""
    sizes = np.diff(offsets)
    for n in np.unique(sizes):
        rings = np.flatnonzero(sizes == n)
        yield rings, corners[offsets[rings][:, None] + np.arange(n)]


def ring_areas(corners: FloatArray, offsets: IntArray) -> FloatArray:
    """Signed areas, positive where counterclockwise, of plane rings, shape (n,).

    >>> ring_areas(np.array([[0.0, 0.0], [2.0, 0.0], [0.0, 2.0]]), np.array([0, 3]))
    array([2.])
    """
    if len(offsets) == 1:
        return np.empty(0)
    local = corners - np.repeat(corners[offsets[:-1]], np.diff(offsets), axis=0)
    following = local[next_corner(offsets)]
    twice = local[:, 0] * following[:, 1] - local[:, 1] * following[:, 0]
    out: FloatArray = np.add.reduceat(twice, offsets[:-1]) / 2
    return out


def is_hole(ring: FloatArray) -> bool:
    """Whether a ring, shape (m, 2), runs clockwise, so that material on its left is around it."""
    return bool(ring_areas(ring, np.array([0, len(ring)]))[0] < 0)


def are_convex(corners: FloatArray, offsets: IntArray) -> BoolArray:
    """Whether each counterclockwise ring nowhere turns right or back, shape (n,)."""
    following = next_corner(offsets)
    side = corners[following] - corners
    turn = side[:, 0] * side[following, 1] - side[:, 1] * side[following, 0]
    size = np.hypot(*side.T) * np.hypot(*side[following].T)
    onward = (side * side[following]).sum(axis=1) > 0
    fine = (turn > 1e-9 * size) | (onward & (turn >= -1e-9 * size))
    out: BoolArray = np.logical_and.reduceat(fine, offsets[:-1])
    return out
