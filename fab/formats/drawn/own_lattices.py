"""Living hinges of our own sheets as the creases that they were."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial import KDTree

from fab.formats.drawn.dashes import Rows
from fab.formats.drawn.line_soup import Letters
from solver.graphs import labels
from solver.vectors import FloatArray, IntArray

__all__ = ["without_lattices"]

# Places of slits of one hinge agree within this, mm.
_AGREE_MM = 2e-3
_NEIGHBOURS = 6


def without_lattices(
    rows: Rows, lines_coords: FloatArray, lines_assignment: Letters, agree: float = _AGREE_MM
) -> tuple[Rows, int]:
    """Rows of slits beside each other as one row in their middle, and how many hinges these were.

    Neighbours in a hinge have the same rhythm and the same middle, and one of them has a slit more
    than the other (`fab.sheets.crease_styles.LatticeStyle`).
    """
    pairs = _neighbours(rows, lines_coords, lines_assignment, agree)
    if not len(pairs):
        return rows, 0
    hinge = labels(pairs, len(rows.ends))
    order = np.lexsort((np.arange(len(hinge)), hinge))
    ends = rows.ends.copy()
    kept = hinge.copy()
    count = 0
    for own in np.split(order, np.flatnonzero(np.diff(hinge[order])) + 1):
        if len(own) < 2:
            continue
        longest = own[np.argmax(rows.dashes[own])]
        start, end = rows.ends[longest]
        along = (end - start) / np.hypot(*(end - start))
        across = np.array([-along[1], along[0]])
        heights = np.sort((rows.ends[own].mean(axis=1) - start) @ across)
        if np.ptp(np.diff(heights)) > agree:
            kept[own] = len(hinge) + own
            continue
        ends[own] = rows.ends[longest] + heights.mean() * across
        count += 1
    _, first, again = np.unique(kept, return_index=True, return_inverse=True)
    widest = np.zeros(len(first))
    np.maximum.at(widest, again, rows.gap)
    dashes = np.bincount(again, weights=rows.dashes).astype(np.int64)
    return replace(rows, row=again[rows.row], ends=ends[first], dashes=dashes, gap=widest), count


def _neighbours(
    rows: Rows, lines_coords: FloatArray, lines_assignment: Letters, agree: float
) -> IntArray:
    """Pairs of rows that are beside each other in a hinge, shape (m, 2), the longer one first."""
    _, first = np.unique(rows.row, return_index=True)
    letters = lines_assignment[first]
    span = rows.ends[:, 1] - rows.ends[:, 0]
    length = np.hypot(*span.T)
    drawn = np.bincount(rows.row, weights=np.hypot(*(lines_coords[:, 1] - lines_coords[:, 0]).T))
    several = rows.dashes > 1
    with np.errstate(divide="ignore", invalid="ignore"):
        period = (length - drawn / rows.dashes) / (rows.dashes - 1)
    crease = np.flatnonzero(~np.isin(letters, ["B", "C"]) & (length > 0))
    if len(crease) < 2 or not several[crease].any():
        return np.empty((0, 2), np.int64)
    middles = rows.ends[crease].mean(axis=1)
    most = min(_NEIGHBOURS + 1, len(crease))
    near = KDTree(middles).query(middles, k=most)[1].reshape(len(crease), most)
    long = np.repeat(crease, most)
    short = crease[near.ravel()]
    fits = several[long] & (rows.dashes[long] == rows.dashes[short] + 1)
    fits &= letters[long] == letters[short]
    long, short = long[fits], short[fits]
    along = span[long] / length[long, None]
    apart = rows.ends[short].mean(axis=1) - rows.ends[long].mean(axis=1)
    turn = np.abs(along[:, 0] * span[short, 1] - along[:, 1] * span[short, 0])
    height = np.abs(along[:, 0] * apart[:, 1] - along[:, 1] * apart[:, 0])
    same = (np.abs((apart * along).sum(axis=1)) < agree) & (turn < agree)
    same &= (height > agree) & (height < period[long])
    same &= np.abs(length[long] - length[short] - period[long]) < agree
    out: IntArray = np.column_stack([long, short])[same]
    return out
