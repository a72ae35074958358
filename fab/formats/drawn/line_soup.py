"""Straight lines of a drawing, as its reader finds them, before they are a crease pattern.

Every reader of drawings (SVG, DXF, CP, ORIPA, FOLD without faces) gives a `LineSoup`, and one
importer makes a crease pattern of it.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fab.errors import Finding, InvalidFile, Severity, counted
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = [
    "LETTERS",
    "MOST_LINES",
    "UNLETTERED",
    "Letters",
    "LineSoup",
    "require_few_lines",
    "with_length",
]

# Assignments of the FOLD format.
LETTERS = "BMVFUCJ"
# Stands for the assignment of a line of which the drawing says nothing.
UNLETTERED = "?"

Letters = NDArray[np.str_]

# Drawings of more lines would take more than a gigabyte of memory.
MOST_LINES = 1_000_000


@dataclass(frozen=True)
class LineSoup:
    """The lines of a drawing. They may cross, overlap, repeat, and miss each other by a little.

    Attributes
    ----------
    path : of the file, for messages.
    title : of the drawing; empty where it has none.
    lines_coords : both ends of each line, in units of the drawing, y upwards, shape (n, 2, 2).
    lines_assignment : shape (n,), one of `LETTERS` or `UNLETTERED`.
    lines_foldAngle : shape (n,), degrees, valley positive; NaN where the drawing gives none.
    lines_element : shape (n,), which of `elements` each line was drawn by: a curve becomes many
        lines of one element.
    elements : what the file calls each of its elements, for messages, such as "path 'crease-3'" or
        "line 17".
    mm_per_unit : millimetres per unit of the drawing; None where it names no unit.
    findings : what the reader left out, assumed or approximated.
    downwards : whether y points down in the file: places in messages are those of the file.
    border_is_cut : whether the format has one letter for borders and cuts, so that a border within
        the sheet is a cut.
    """

    path: Path
    title: str
    lines_coords: FloatArray
    lines_assignment: Letters
    lines_foldAngle: FloatArray  # noqa: N815 (after the FOLD format's edges_foldAngle)
    lines_element: IntArray
    elements: tuple[str, ...]
    mm_per_unit: float | None
    findings: tuple[Finding, ...] = ()
    downwards: bool = False
    border_is_cut: bool = False


def require_few_lines(path: Path, count: int) -> None:
    """Raise `InvalidFile` for a drawing of more lines than are imported.

    Readers ask as soon as they know: what is done with lines before they are imported, such as
    joining dashes, needs as much memory as the import.
    """
    if count > MOST_LINES:
        raise InvalidFile(
            f"{path}: {count} lines are over the bound of {MOST_LINES}. Leave out what is no "
            "crease, or split the drawing into several files."
        )


def with_length(lines_coords: FloatArray) -> tuple[BoolArray, list[Finding]]:
    """Which lines, shape (n, 2, k), have a length, and the finding of the others."""
    kept: BoolArray = (lines_coords[:, 0] != lines_coords[:, 1]).any(axis=1)
    count = int((~kept).sum())
    if not count:
        return kept, []
    text = f"{counted(count, 'line')} without length: left out."
    return kept, [Finding("line-without-length", Severity.NOTE, text)]
