"""Arcs of the circle: their union, and the angles that they leave free.

An arc is a row (start, end), radians in [0, 2 pi), that runs from start counterclockwise to end,
past 0 where end < start.
"""

from __future__ import annotations

import numpy as np

from solver.vectors import BoolArray, FloatArray

__all__ = ["at_share", "contain", "free_arcs", "united"]

_TURN = 2 * np.pi


def united(arcs: FloatArray) -> FloatArray:
    """Union of arcs, shape (n, 2), as disjoint arcs in rising order, shape (k, 2).

    The whole circle is the one row (0, 2 pi). Exact: only comparisons of the given ends.

    >>> united(np.array([[6.0, 1.0], [0.5, 2.0], [3.0, 4.0]]))
    array([[3., 4.],
           [6., 2.]])
    """
    arcs = np.asarray(arcs, float).reshape(-1, 2)
    whole = (arcs[:, 0] == 0) & (arcs[:, 1] >= _TURN)
    if whole.any():
        return np.array([[0.0, _TURN]])
    past = arcs[:, 1] < arcs[:, 0]
    pieces = np.concatenate(
        [
            arcs[~past],
            np.column_stack([arcs[past, 0], np.full(past.sum(), _TURN)]),
            np.column_stack([np.zeros(past.sum()), arcs[past, 1]]),
        ]
    )
    merged: list[list[float]] = []
    for start, end in pieces[np.argsort(pieces[:, 0], kind="stable")].tolist():
        if merged and start <= merged[-1][1]:
            merged[-1][1] = max(merged[-1][1], end)
        else:
            merged.append([start, end])
    if len(merged) > 1 and merged[0][0] == 0 and merged[-1][1] == _TURN:
        merged[-1][1] = merged.pop(0)[1]
    return np.array(merged).reshape(-1, 2)


def free_arcs(arcs: FloatArray) -> FloatArray:
    """What a union of arcs leaves of the circle, as disjoint arcs, shape (k, 2).

    >>> free_arcs(np.array([[6.0, 1.0], [0.5, 2.0], [3.0, 4.0]]))
    array([[4., 6.],
           [2., 3.]])
    """
    covered = united(arcs)
    if not len(covered):
        return np.array([[0.0, _TURN]])
    if covered[0, 0] == 0 and covered[0, 1] == _TURN:
        return np.empty((0, 2))
    gaps = np.column_stack([covered[:, 1], np.roll(covered[:, 0], -1)])
    gaps[gaps[:, 0] == _TURN, 0] = 0.0
    out: FloatArray = gaps[gaps[:, 0] != gaps[:, 1]]
    return out


def contain(arcs: FloatArray, angles: FloatArray) -> BoolArray:
    """Whether each angle, in [0, 2 pi), lies inside one of the arcs, shape (n,)."""
    start, end = np.asarray(arcs, float).reshape(-1, 2, 1).swapaxes(0, 1)
    after, before = angles > start, angles < end
    inside = np.where(start < end, after & before, after | before)
    return np.asarray(inside.any(axis=0))


def at_share(arcs: FloatArray, share: float) -> float:
    """The angle, in [0, 2 pi), that has this share of the arcs' total length before it.

    arcs : at least one, shape (k, 2); share : in [0, 1). A uniform share gives a uniform angle.

    >>> round(at_share(np.array([[6.0, 1.0], [2.0, 3.0]]), 0.75), 6)
    2.429204
    """
    start, end = np.asarray(arcs, float).reshape(-1, 2).T
    sizes = np.where(end > start, end - start, end - start + _TURN)
    ends = np.cumsum(sizes)
    along = share * float(ends[-1])
    i = min(int(np.searchsorted(ends, along, side="right")), len(sizes) - 1)
    return float((start[i] + along - (ends[i] - sizes[i])) % _TURN)
