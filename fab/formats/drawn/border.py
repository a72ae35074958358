"""The border of a sheet among the lines of a drawing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from fab.errors import InvalidFile, Severity, counted
from fab.formats.drawn.lines import Lines, Repair
from fab.formats.read_options import ReadOptions
from fab.geometry.planar_graph import without_dangling
from fab.geometry.planar_regions import points_within, regions_of
from solver.graphs import labels
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["with_border"]

# Of the diagonal: points nearer to a line are on it.
_STRAIGHT_REL = 1e-6
_HULL = "draw the outline, or give --border hull for the convex hull of all lines"


def with_border(
    lines: Lines, tolerance_mm: float, options: ReadOptions
) -> tuple[Lines, list[Repair]]:
    """The lines with closed borders (B), some of which the drawing does not mark.

    Without any border it is the outermost closed lines; a straight line of another letter between
    two ends of the border belongs to it. With `options.inner_border` "cut", borders that end
    within the sheet are cuts (C). Raises `InvalidFile` for outlines that stay open, with
    both ends of the gap, and where no closed line is around all others.
    """
    if not (lines.letters == "B").any():
        return _found(lines)
    degree = _degree(lines)
    if not (degree == 1).any():
        return lines, []
    closed = without_dangling(lines.pairs)
    outer = np.zeros(len(closed), bool)
    outer[closed] = regions_of(lines.coords, lines.pairs[closed]).outer
    size = float(np.hypot(*np.ptp(lines.coords, axis=0)))
    missing = _straight_runs(lines, outer, degree == 1, max(tolerance_mm, _STRAIGHT_REL * size))
    repairs = []
    if len(missing):
        text = f"{lines.named(missing)} with a face on one side alone: taken for border (B)."
        edges, places = lines.planar[missing], lines.middles(missing)
        repairs.append(Repair("border-unmarked", Severity.WARNING, text, edges, places))
        letters = lines.letters.copy()
        letters[missing] = "B"
        lines = replace(lines, letters=letters)
        degree = _degree(lines)
    ends = np.flatnonzero(degree == 1)
    if len(ends) and options.inner_border == "cut":
        lines, cuts = _slits_cut(lines, outer)
        repairs += cuts
        ends = np.flatnonzero(_degree(lines) == 1)
    if len(ends):
        _refuse_gap(lines, ends)
    return lines, repairs


def _slits_cut(lines: Lines, outer: BoolArray) -> tuple[Lines, list[Repair]]:
    """Borders that end within the sheet as cuts: those that are part of no closed line."""
    borders = np.flatnonzero(lines.letters == "B")
    open_ones = borders[~without_dangling(lines.pairs[borders])]
    rows = open_ones[~outer[open_ones]]
    if not len(rows):
        return lines, []
    text = f"{lines.named(rows)}: a border that ends within the sheet is taken for a cut (C)."
    edges, places = lines.planar[rows], lines.middles(rows)
    letters = lines.letters.copy()
    letters[rows] = "C"
    repair = Repair("border-inside", Severity.WARNING, text, edges, places)
    return replace(lines, letters=letters), [repair]


def _degree(lines: Lines) -> IntArray:
    """Number of borders at each vertex."""
    ends = lines.pairs[lines.letters == "B"].ravel()
    return np.bincount(ends, minlength=len(lines.coords))


def _found(lines: Lines) -> tuple[Lines, list[Repair]]:
    """The outermost closed lines as borders."""
    closed = without_dangling(lines.pairs)
    regions = regions_of(lines.coords, lines.pairs[closed])
    if not regions.count:
        raise InvalidFile(f"{lines.path}: its edges enclose no face. To mend it, {_HULL}.")
    loose = np.flatnonzero(~closed)
    middles = lines.coords[lines.pairs[loose]].mean(axis=1)
    free = loose[points_within(middles, lines.coords, regions) < 0]
    if len(free):
        raise InvalidFile(
            f"{lines.path}: no line is a border, and {lines.named(free)} outside of the outermost "
            f"closed lines. To mend it, {_HULL}."
        )
    rows = np.flatnonzero(closed)[regions.outer]
    text = (
        f"no line is a border: the outermost closed lines are taken, "
        f"{counted(len(rows), 'edge')}, the first at {lines.place(rows[0])}."
    )
    letters = lines.letters.copy()
    letters[rows] = "B"
    edges, places = lines.planar[rows], lines.middles(rows)
    repair = Repair("border-found", Severity.WARNING, text, edges, places)
    return replace(lines, letters=letters), [repair]


def _straight_runs(lines: Lines, outer: BoolArray, ends: BoolArray, near: float) -> IntArray:
    """Outermost lines that run straight from one open end of the border to another."""
    rows = np.flatnonzero(outer & (lines.letters != "B"))
    # runs are cut apart at vertices where borders are
    count = len(lines.coords)
    marked = _degree(lines) > 0
    fresh = count + np.arange(2 * len(rows)).reshape(-1, 2)
    nodes = np.where(marked[lines.pairs[rows]], fresh, lines.pairs[rows])
    run = labels(nodes, count + 2 * len(rows))[nodes[:, 0]] if len(rows) else rows
    out = []
    for number in np.unique(run).tolist():
        own = rows[run == number]
        touched = np.unique(lines.pairs[own])
        tips = touched[ends[touched]]
        if len(tips) == 2 and (marked[touched].sum() == 2):
            start, end = lines.coords[tips]
            if (_off(start, end, lines.coords[touched]) <= near).all():
                out.append(own)
    return np.sort(np.concatenate(out)) if out else np.empty(0, np.int64)


def _off(start: FloatArray, end: FloatArray, points: FloatArray) -> FloatArray:
    span, arm = end - start, points - start
    out: FloatArray = np.abs(span[0] * arm[:, 1] - span[1] * arm[:, 0]) / np.hypot(*span)
    return out


def _refuse_gap(lines: Lines, ends: IntArray) -> None:
    """Raise `InvalidFile` with the nearest two ends of the border, or its only one."""
    borders = np.flatnonzero(lines.letters == "B")
    rows = [int(borders[(lines.pairs[borders] == end).any(axis=1)][0]) for end in ends.tolist()]
    points = lines.coords[ends]
    if len(ends) == 1:
        raise InvalidFile(
            f"{lines.path}: the outline is open at {lines.name(rows[0])}: it ends at "
            f"{lines.point(points[0])}. Go on to another border, or make it a cut (C), as "
            "--inner-border cut does."
        )
    apart, other = cKDTree(points).query(points, k=2)
    first = int(np.argmin(apart[:, 1]))
    second = int(other[first, 1]) if other[first, 1] != first else int(other[first, 0])
    gap = float(np.hypot(*(points[first] - points[second])))
    more = f" {counted(len(ends) - 2, 'more end')} of the outline." if len(ends) > 2 else ""
    if rows[first] == rows[second]:
        raise InvalidFile(
            f"{lines.path}: {lines.name(rows[first])} is a border that joins no other, from "
            f"{lines.point(points[first])} to {lines.point(points[second])}. Remove it, or make it "
            f"a crease or a cut (C), as --inner-border cut does.{more}"
        )
    raise InvalidFile(
        f"{lines.path}: the outline is open at {lines.name(rows[first])}: a gap of {gap:.4g} mm "
        f"between {lines.point(points[first])} and {lines.point(points[second])} "
        f"({lines.name(rows[second])}). Close it, give --merge-mm {gap * 1.01:.3g} or more, or "
        f"make what ends within the sheet a cut (C), as --inner-border cut does.{more}"
    )
