"""Fold angles of the creases that a file gives, and of those for which it gives none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fab.errors import Finding, Severity, first_few
from fab.formats.line_soup import UNLETTERED
from fab.formats.lines import Lines
from fab.formats.read_options import ReadOptions
from solver.errors import InvalidValue
from solver.vectors import BoolArray, FloatArray

__all__ = ["with_fold_angles"]

# What a crease without an angle folds by, over the driving angle, by its letter.
_SIGNS = {"M": -1.0, "V": 1.0}
_FULLY_FOLDED_DEG = 180.0
# The side to which a crease folds cannot be measured this near to 180 degrees.
_SIDELESS_DEG = 1e-3


def with_fold_angles(
    lines: Lines,
    border: BoolArray,
    measured: FloatArray | None,
    options: ReadOptions,
    *,
    none_given: str,
) -> tuple[Lines, list[Finding]]:
    """The lines with letters and fold angles that agree, and what was assumed for that.

    border : lines with a face on one side alone, shape (n,). measured : angles of a folded form,
    NaN where it has none, shape (n,). none_given : what to call a file in which no line has an
    angle; empty where some have.

    Angles are those of the file, of the folded form, or else `options.fold_deg`. Lines without a
    letter get that of their angle, and are unassigned (U) where they have none either.
    """
    full = _FULLY_FOLDED_DEG if options.fold_deg is None else options.fold_deg
    if not 0 < full <= _FULLY_FOLDED_DEG:
        raise InvalidValue(
            "fold_deg", options.fold_deg, "be over 0 and at most 180", "Give --fold-deg in degrees."
        )
    letters, angles = lines.letters, lines.angles
    sign = np.select([letters == letter for letter in _SIGNS], [*_SIGNS.values()])
    unlettered = letters == UNLETTERED
    lacking = np.isnan(angles) & ((sign != 0) | (letters == "U") | unlettered) & ~border
    findings = []
    if measured is not None and lacking.any():
        sideless = (sign != 0) & (np.abs(measured) > _FULLY_FOLDED_DEG - _SIDELESS_DEG)
        measured = np.where(sideless, sign * _FULLY_FOLDED_DEG, measured)
        rows = np.flatnonzero(lacking & ~np.isnan(measured))
        if len(rows):
            text = f"{lines.named(rows)} without fold angle: that of the folded form is taken."
            findings.append(_of_lines("fold-angle-measured", Severity.NOTE, text, lines, rows))
        angles = np.where(lacking, measured, angles)
    rows = np.flatnonzero(np.isnan(angles) & (sign != 0))
    if len(rows) and options.fold_deg is None:
        text = f"{lines.named(rows)} without fold angle: folded by {full:g} degrees."
        if none_given:
            text = f"{none_given}: mountains and valleys fold by {full:g} degrees."
            rows = rows[:0]
        findings.append(_of_lines("fold-angle-missing", Severity.NOTE, text, lines, rows))
    signed = np.where(angles > 0, "V", np.where(angles < 0, "M", "F"))
    signed = np.where(border, "B", np.where(np.isnan(angles), "U", signed))
    letters = np.where(unlettered, signed, letters)
    angles = np.where(np.isnan(angles), sign * full, angles)
    wrong = np.flatnonzero((angles * sign < 0) | ((letters == "F") & (angles != 0)))
    if len(wrong):
        wrong = wrong[np.argsort(lines.number[wrong], kind="stable")]
        text = (
            f"{lines.named(wrong).removesuffix(',')}: the sign of the fold angle "
            f"({angles[wrong[0]]:g}) contradicts the assignment {letters[wrong[0]]}; the "
            "assignment holds."
        )
        findings.append(_of_lines("fold-angle-contradicts", Severity.WARNING, text, lines, wrong))
        angles[wrong] = sign[wrong] * np.abs(angles[wrong])
    return replace(lines, letters=letters, angles=angles), findings


def _of_lines(code: str, severity: Severity, text: str, lines: Lines, rows: np.ndarray) -> Finding:
    return Finding(code, severity, text, creases=first_few(np.sort(lines.number[rows])))
