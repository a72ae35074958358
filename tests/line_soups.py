"""Line soups for the tests: of patterns, of lists of lines."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fab.formats.drawn.line_soup import LineSoup

SQUARE = [
    ("B", 0, 0, 100, 0),
    ("B", 100, 0, 100, 100),
    ("B", 100, 100, 0, 100),
    ("B", 0, 100, 0, 0),
]


def soup_of(rows, angles=None, mm_per_unit=1.0, elements=None) -> LineSoup:
    """Rows of a letter and four coordinates; each line is an element unless they are named."""
    count = len(rows)
    coords = np.array([row[1:] for row in rows], float).reshape(count, 2, 2)
    element = np.arange(count) if elements is None else np.array(elements)
    return LineSoup(
        Path("drawing.svg"),
        "drawing",
        coords,
        np.array([row[0] for row in rows], "U1"),
        np.full(count, np.nan) if angles is None else np.array(angles, float),
        element,
        tuple(f"line {number + 1}" for number in range(int(element.max(initial=-1)) + 1)),
        mm_per_unit,
    )


def soup_of_pattern(pattern) -> LineSoup:
    """The edges of a pattern as lines."""
    ends = pattern.vertices_coords[pattern.edges_vertices].reshape(-1, 4)
    rows = [(letter, *row) for letter, row in zip(pattern.edges_assignment, ends, strict=True)]
    angles = np.where(pattern.edges_assignment == "B", np.nan, pattern.edges_foldAngle)
    return soup_of(rows, angles)


def lengths(pattern) -> dict[str, float]:
    """Total length of the edges by letter."""
    ends = pattern.vertices_coords[pattern.edges_vertices]
    length = np.hypot(*(ends[:, 1] - ends[:, 0]).T)
    letters = pattern.edges_assignment
    return {str(x): float(length[letters == x].sum()) for x in np.unique(letters)}
