"""Findings about the unit of a file, and about the size that options give it."""

from __future__ import annotations

from fab.errors import Finding, Severity
from fab.formats.read_options import ReadOptions

__all__ = ["unit_named", "unit_unknown"]

_SAME_REL = 1e-9


def unit_unknown(what: str, mm: float) -> Finding:
    """The finding of a file without a unit. what : such as "the file names no unit: one unit"."""
    text = (
        f"{what} is taken for {mm:.6g} mm. Give --width-mm or --mm-per-unit where this is not "
        "meant."
    )
    return Finding("unit-unknown", Severity.NOTE, text)


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
