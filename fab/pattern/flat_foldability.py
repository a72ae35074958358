"""Flat-foldability of single vertices: which mountains and valleys let a vertex fold flat.

After Kawasaki, the sectors around a vertex that folds flat have an alternating sum of zero; after
Maekawa, mountains and valleys differ by two. The assignments that fold flat are those that crimps
reduce to two creases alike: two creases of different letters beside a smallest sector are folded
away, which joins that sector with its neighbours (Hull 1994; Bern and Hayes 1996; Demaine and
O'Rourke 2007, chapter 12).
"""

from __future__ import annotations

from functools import cache
from itertools import combinations

import numpy as np

from solver.vectors import BoolArray, FloatArray

__all__ = ["balanced_letters", "foldable_letters", "kawasaki_rad"]

# This many creases of vertices and assignments are crimped at once.
_CHUNK = 1 << 20


def kawasaki_rad(sectors: FloatArray) -> FloatArray:
    """By how much vertices of an even degree n miss Kawasaki's condition, radians, shape (k,).

    sectors : angles around each vertex, radians, shape (k, n).

    >>> kawasaki_rad(np.radians([[90.0, 90.0, 90.0, 90.0], [100.0, 80.0, 90.0, 90.0]])).round(9)
    array([0.        , 0.34906585])
    """
    out: FloatArray = np.abs(sectors[:, ::2].sum(axis=1) - sectors[:, 1::2].sum(axis=1))
    return out


@cache
def balanced_letters(degree: int) -> BoolArray:
    """All assignments that Maekawa's condition admits, True for a valley, shape (a, degree).

    >>> len(balanced_letters(4)), len(balanced_letters(6))
    (8, 30)
    """
    half = degree // 2
    chosen = [c for count in (half - 1, half + 1) for c in combinations(range(degree), count)]
    out = np.zeros((len(chosen), degree), bool)
    for row, valleys in enumerate(chosen):
        out[row, list(valleys)] = True
    out.flags.writeable = False
    return out


def foldable_letters(sectors: FloatArray, tolerance_rad: float) -> BoolArray:
    """Which of `balanced_letters` let each vertex fold flat, shape (k, a).

    sectors : angles around k vertices of an even degree n for which Kawasaki's condition holds,
        radians, shape (k, n); sector i is between the creases i and i + 1.
    tolerance_rad : sectors that differ by less are equal. Every assignment that folds flat with
        any sectors within it is among them.

    Hull's counts for four creases: all sectors equal, two pairs of equal ones, none equal.

    >>> sectors = np.radians([[90.0, 90, 90, 90], [60, 60, 120, 120], [40, 60, 140, 120]])
    >>> foldable_letters(sectors, 1e-9).sum(axis=1).tolist()
    [8, 6, 4]
    """
    count, degree = sectors.shape
    letters = balanced_letters(degree)
    out = np.empty((count, len(letters)), bool)
    step = max(1, _CHUNK // letters.size)
    for begin in range(0, count, step):
        part = sectors[begin : begin + step]
        rows = np.repeat(part, len(letters), axis=0)
        valleys = np.tile(letters, (len(part), 1))
        out[begin : begin + step] = _crimped_away(rows, valleys, tolerance_rad).reshape(
            len(part), -1
        )
    return out


def _crimped_away(sectors: FloatArray, valleys: BoolArray, tolerance_rad: float) -> BoolArray:
    """Whether crimps reduce each row, shapes (r, n), to two creases alike, shape (r,)."""
    out = np.ones(len(sectors), bool)
    while (degree := sectors.shape[1]) > 2:
        crimps = valleys != np.roll(valleys, -1, axis=1)
        crimps &= sectors <= sectors.min(axis=1, keepdims=True) + tolerance_rad
        out &= crimps.any(axis=1)
        # the crimped sector comes second
        turn = (crimps.argmax(axis=1)[:, None] - 1 + np.arange(degree)) % degree
        sectors = np.take_along_axis(sectors, turn, axis=1)
        valleys = np.take_along_axis(valleys, turn, axis=1)
        joined = sectors[:, :1] - sectors[:, 1:2] + sectors[:, 2:3]
        sectors = np.concatenate([joined, sectors[:, 3:]], axis=1)
        valleys = np.concatenate([valleys[:, :1], valleys[:, 3:]], axis=1)
    out &= valleys[:, 0] == valleys[:, 1]
    return out
