"""Findings about the unit of a file, and about the size that options give it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fab.errors import Finding, Severity
from fab.formats.read_options import ReadOptions
from fab.pattern.crease_pattern import CreasePattern

__all__ = ["sheet_small", "unit_named", "unit_unknown", "with_size_given"]

_SIZE_CURE = "Give --width-mm or --mm-per-unit where this is not meant."

_SAME_REL = 1e-9
# Sheets of files without a unit that are smaller than this are probably of another unit, mm.
_SMALL_MM = 20.0


def unit_unknown(what: str, mm: float) -> Finding:
    """The finding of a file without a unit. what : such as "the file names no unit: one unit"."""
    text = f"{what} is taken for {mm:.6g} mm. {_SIZE_CURE}"
    return Finding("unit-unknown", Severity.NOTE, text)


def with_size_given(finding: Finding, done: str) -> Finding:
    """A finding where the user gave the size of the sheet: of a unit, what was done with that."""
    if finding.code != "unit-unknown":
        return finding
    return replace(finding, text=finding.text.replace(_SIZE_CURE, f"{done}, as asked for."))


def unit_named(mm: float, options: ReadOptions) -> list[Finding]:
    """The finding of a file whose unit, in mm, comes before another one that the options give."""
    given = options.mm_per_unit
    if given is None or abs(given - mm) <= _SAME_REL * mm:
        return []
    text = (
        f"the file names its unit, {mm:.6g} mm: --mm-per-unit or --dpi do not apply. Give --scale "
        f"{given / mm:.6g} for units of {given:.6g} mm."
    )
    return [Finding("unit-named", Severity.NOTE, text)]


def sheet_small(findings: Sequence[Finding], pattern: CreasePattern) -> list[Finding]:
    """The finding of a sheet so small that the unit which its file does not name is another one.

    findings : of the file's reader.
    """
    sides = np.ptp(pattern.vertices_coords, axis=0)
    if sides.max() >= _SMALL_MM or all(finding.code != "unit-unknown" for finding in findings):
        return []
    text = (
        f"the file names no unit, and the sheet is only {sides[0]:.4g} x {sides[1]:.4g} mm large. "
        "Give its longer side with --width-mm, such as --width-mm 100."
    )
    return [Finding("sheet-small", Severity.WARNING, text)]
