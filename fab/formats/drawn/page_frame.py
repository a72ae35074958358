"""The frame of a page among the borders of a drawing: around the sheet, and no part of it."""

from __future__ import annotations

import numpy as np

from fab.formats.drawn.line_soup import UNLETTERED
from fab.formats.drawn.lines import Lines
from fab.geometry.planar_regions import Regions, points_within, regions_of
from solver.graphs import labels
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["page_frame"]


def page_frame(
    lines: Lines,
    closed: BoolArray,
    regions: Regions,
    outside: BoolArray,
    twice: BoolArray,
    tolerance_mm: float,
) -> BoolArray:
    """Which borders are those of a page around the sheet, shape (n,); none where there is no page.

    closed, regions : which lines enclose regions, and those. outside : which lines are next to or
    within nothing that is a sheet by its borders. twice : where two borders are in one place.

    Without a crease of their own, nor any between them and the sheet, they are the outermost
    borders in one of these cases: they would leave all creases within them outside of the sheet;
    they are a rectangle around a second one, that of a double frame, with the creases inside; they
    are a rectangle of which the sheet takes a part of its own, so that its outline is drawn twice
    where both are in one place.
    """
    creases = ~np.isin(lines.letters, ["B", UNLETTERED])
    borders = lines.letters == "B"
    frame = np.zeros(len(lines.pairs), bool)
    part = labels(lines.pairs, len(lines.coords))[lines.pairs[:, 0]]
    middles = lines.coords[lines.pairs].mean(axis=1)
    lost = outside & creases
    for outermost in np.unique(part[np.flatnonzero(closed)[regions.outer]]).tolist():
        own = part == outermost
        outline = regions_of(lines.coords, lines.pairs[own & closed])
        around = (points_within(middles, lines.coords, outline) >= 0) & ~own
        plain = not (creases & own).any()
        if plain and (lost & around).any() and not (creases & ~lost & around).any():
            frame |= own & borders
        elif not _rectangular(lines, own & closed, outline, tolerance_mm):
            continue
        elif not plain:
            frame |= _shared(lines, own, closed, regions, creases, twice)
        elif (second := _second(lines, closed, part, around, tolerance_mm)).any():
            frame |= (own | second) & borders
    return frame


def _rectangular(lines: Lines, rows: BoolArray, outline: Regions, tolerance_mm: float) -> bool:
    """Whether the outside of closed lines is an upright rectangle.

    outline : the regions of these lines.
    """
    ends = lines.coords[lines.pairs[rows][outline.outer]]
    corners: FloatArray = np.array([ends.min(axis=(0, 1)), ends.max(axis=(0, 1))])
    # corner, line, end, coordinate
    near = np.abs(ends - corners[:, None, None]) <= tolerance_mm
    return bool(np.all(np.any(np.all(near, axis=2), axis=(0, 2))))


def _second(
    lines: Lines, closed: BoolArray, part: IntArray, around: BoolArray, tolerance_mm: float
) -> BoolArray:
    """The lines of a rectangle without creases that has all creases in it, among these."""
    creases = around & ~np.isin(lines.letters, ["B", UNLETTERED])
    middles = lines.coords[lines.pairs].mean(axis=1)
    for number in np.unique(part[around & closed]).tolist():
        own: BoolArray = part == number
        outline = regions_of(lines.coords, lines.pairs[own & closed])
        within = points_within(middles[creases], lines.coords, outline) >= 0
        plain = within.any() and within.all() and not (creases & own).any()
        if plain and _rectangular(lines, own & closed, outline, tolerance_mm):
            return own
    return np.zeros(len(part), bool)


def _shared(
    lines: Lines,
    own: BoolArray,
    closed: BoolArray,
    regions: Regions,
    creases: BoolArray,
    twice: BoolArray,
) -> BoolArray:
    """Borders of a page alone, where the sheet is at its edge or in its corner."""
    frame = np.zeros(len(own), bool)
    rows = np.flatnonzero(closed)
    loose = np.flatnonzero(~closed & creases)
    middles = lines.coords[lines.pairs[loose]].mean(axis=1)
    creased = np.zeros(regions.count + 1, bool)  # the last is the outside of all
    creased[regions.sides[creases[rows]]] = True
    creased[points_within(middles, lines.coords, regions)] = True
    creased[-1] = False
    outer = regions.outer & own[rows]
    margin = np.zeros(regions.count + 1, bool)
    margin[regions.sides[outer]] = True
    margin &= ~creased
    margin[-1] = False
    sheet = outer & ~margin[regions.sides].any(axis=1)
    if not sheet.any() or not margin.any() or not twice[rows[sheet]].all():
        return frame
    margin[-1] = True
    frame[rows] = margin[regions.sides].all(axis=1) & own[rows] & (lines.letters[rows] == "B")
    return frame
