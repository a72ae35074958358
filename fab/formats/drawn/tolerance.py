"""How near the ends of a drawing's lines may be to be joined."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from fab.errors import InvalidFile
from fab.geometry.distinct_points import distinct_points
from solver.graphs import labels
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["Tolerance", "tolerance_of"]

# Of the diagonal: creases of one in six published drawings miss the outline by about as much.
_DRAWN_REL = 1e-3
# Of the shortest line, so that a line's own ends are never joined.
_LENGTH_REL = 1 / 3
# Of the diagonal: shorter lines are crumbs, which bound nothing.
_CRUMB_REL = 1e-5
# Lines of one element that bend by less (the cosine) are a curve.
_SMOOTH = np.cos(np.radians(30.0))
# Ends that are joined may be so many tolerances apart; with more pairs than this they are crowded.
_SPREAD, _CROWD = 1.5, 4.0
# Of the diagonal: less is no tolerance, as files with faces are read with 1e-8.
_LEAST_REL = 2e-7


@dataclass(frozen=True)
class Tolerance:
    """How far ends reach, and why.

    Attributes
    ----------
    mm : the tolerance of the drawing. reach : of each end, shape (n, 2), mm; joints of curves with
        short lines reach less.
    reason : where `mm` comes from, for messages.
    """

    mm: float
    reach: FloatArray
    reason: str


def tolerance_of(coords: FloatArray, element: IntArray, merge_mm: float | None) -> Tolerance:
    """The tolerance of lines, shape (n, 2, 2), mm, that belong to elements, shape (n,).

    A thousandth of the diagonal; no more than a third of the shortest line (curves count as one
    line), and no more than what keeps ends apart that are in a row.
    """
    length = np.hypot(*(coords[:, 1] - coords[:, 0]).T)
    smooth = _smooth_joints(coords, element, length)
    size = float(np.hypot(*np.ptp(coords.reshape(-1, 2), axis=0)))
    if merge_mm is not None:
        if merge_mm >= size / 2:
            raise InvalidFile(
                f"--merge-mm {merge_mm:g}: must be under half the drawing's diagonal, "
                f"{size / 2:.6g} mm."
            )
        reach = np.maximum(_reach(merge_mm, length, smooth), _LEAST_REL * size)
        return Tolerance(merge_mm, reach, "given by --merge-mm")
    run = np.concatenate([[0], np.cumsum(~smooth)])[: len(length)]
    lengths = np.bincount(run, length)
    lengths = lengths[lengths > _CRUMB_REL * size]
    tolerance, reason = _DRAWN_REL * size, "0.1 % of the drawing's diagonal"
    shortest = float(lengths.min(initial=size))
    if _LENGTH_REL * shortest < tolerance:
        tolerance = _LENGTH_REL * shortest
        reason = f"a third of the shortest line, {shortest:.4g} mm"
    reach = _reach(tolerance, length, smooth)
    least = _LEAST_REL * size
    while tolerance > least and not _compact(coords, reach, tolerance):
        tolerance = max(tolerance / 2, least)
        reason = "halved until ends that are drawn apart stay apart"
        reach = _reach(tolerance, length, smooth)
    return Tolerance(tolerance, np.maximum(reach, least), reason)


def _smooth_joints(coords: FloatArray, element: IntArray, length: FloatArray) -> BoolArray:
    """Whether each line but the last goes on in the next one as a curve, shape (n - 1,)."""
    span = coords[:, 1] - coords[:, 0]
    joined = (coords[:-1, 1] == coords[1:, 0]).all(axis=1) & (element[:-1] == element[1:])
    along = (span[:-1] * span[1:]).sum(axis=1)
    smooth: BoolArray = joined & (along > _SMOOTH * length[:-1] * length[1:])
    return smooth


def _reach(tolerance: float, length: FloatArray, smooth: BoolArray) -> FloatArray:
    """Ends reach as far as the tolerance; joints of curves a third of the shorter line."""
    reach = np.full((len(length), 2), tolerance)
    joint = np.minimum(tolerance, _LENGTH_REL * np.minimum(length[:-1], length[1:]))
    rows = np.flatnonzero(smooth)
    reach[rows, 1] = reach[rows + 1, 0] = joint[rows]
    return reach


def _compact(coords: FloatArray, reach: FloatArray, tolerance: float) -> bool:
    """Whether ends that would be joined are all near to each other, and not one of a row."""
    points, place = distinct_points(coords.reshape(-1, 2))
    least = np.full(len(points), tolerance)
    np.minimum.at(least, place, reach.ravel())
    tree = cKDTree(points)
    if tree.count_neighbors(tree, tolerance) > (1 + 2 * _CROWD) * len(points):
        return False
    pairs = tree.query_pairs(tolerance, output_type="ndarray")
    apart = np.hypot(*(points[pairs[:, 0]] - points[pairs[:, 1]]).T)
    pairs = pairs[apart <= least[pairs].min(axis=1)]
    if not len(pairs):
        return True
    group = labels(pairs, len(points))
    order = np.argsort(group, kind="stable")
    first = np.searchsorted(group[order], np.arange(int(group.max()) + 1))
    high = np.maximum.reduceat(points[order], first)
    low = np.minimum.reduceat(points[order], first)
    return bool((np.hypot(*(high - low).T) <= _SPREAD * tolerance).all())
