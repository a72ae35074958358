"""Fold angles of the creases that a file gives, and of those for which it gives none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fab.errors import Finding, Severity, first_few
from fab.formats.drawn.line_soup import UNLETTERED, Letters
from fab.formats.drawn.lines import Lines, places_of
from fab.formats.read_options import ReadOptions
from fab.pattern.crease_pattern import FLAT_ANGLE_DEG
from solver.vectors import BoolArray, FloatArray

__all__ = ["full_fold_deg", "with_fold_angles"]

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

    Mountains and valleys whose angle is 0 are flat creases (F), unless it is that of all of them:
    a flat sheet was stored, and its letters say how it folds.

    Angles are those of the file, of the folded form, or else `options.fold_deg`. Lines without a
    letter get that of their angle, and are unassigned (U) where they have none either.
    """
    full = full_fold_deg(options)
    letters, angles = lines.letters, lines.angles
    sign = np.select([letters == letter for letter in _SIGNS], [*_SIGNS.values()])
    unlettered = letters == UNLETTERED
    findings = []
    folding = (sign != 0) & ~border
    stored = folding & ~np.isnan(angles)
    flat = stored & (np.abs(angles) <= FLAT_ANGLE_DEG)
    if flat.any() and flat[stored].all():  # nothing but the flat state, which letters exceed
        rows = np.flatnonzero(flat)
        instead = f"folded by {full:g} degrees" if measured is None else "measured"
        text = (
            f"{lines.named(rows)} with fold angle 0, as all mountains and valleys: that is the "
            f"flat sheet, the letters hold, {instead}."
        )
        findings.append(_of_lines("fold-angle-zero", Severity.WARNING, text, lines, rows))
        angles = np.where(flat, np.nan, angles)
    lacking = np.isnan(angles) & ((sign != 0) | (letters == "U") | unlettered) & ~border
    if measured is not None and lacking.any():
        sideless = (sign != 0) & (np.abs(measured) > _FULLY_FOLDED_DEG - _SIDELESS_DEG)
        measured = np.where(sideless, sign * _FULLY_FOLDED_DEG, measured)
        rows = np.flatnonzero(lacking & ~np.isnan(measured))
        if len(rows):
            text = f"{lines.named(rows)} without fold angle: that of the folded form is taken."
            findings.append(_of_lines("fold-angle-measured", Severity.NOTE, text, lines, rows))
        angles = np.where(lacking, measured, angles)
    rows = np.flatnonzero(np.isnan(angles) & (sign != 0) & ~flat)
    if options.fold_deg is not None and not (np.isnan(angles) & (sign != 0)).any():
        findings += _unused(options, letters)
    if len(rows) and options.fold_deg is None:
        text = f"{lines.named(rows)} without fold angle: folded by {full:g} degrees."
        if none_given:
            text = f"{none_given}: mountains and valleys fold by {full:g} degrees. "
            text += "Give their angle with --fold-deg."
            rows = rows[:0]
        findings.append(_of_lines("fold-angle-missing", Severity.NOTE, text, lines, rows))
    signed = np.where(angles > 0, "V", np.where(angles < 0, "M", "F"))
    signed = np.where(border, "B", np.where(np.isnan(angles), "U", signed))
    letters = np.where(unlettered, signed, letters)
    angles = np.where(np.isnan(angles), sign * full, angles)
    still = np.flatnonzero(folding & (np.abs(angles) <= FLAT_ANGLE_DEG))
    if len(still):
        text = (
            f"{lines.named(still)}: {'mountains and valleys' if len(still) > 1 else 'a crease'} "
            "with fold angle 0 among others that fold: taken for flat (F)."
        )
        findings.append(_of_lines("fold-angle-zero", Severity.WARNING, text, lines, still))
        letters, sign = letters.copy(), sign.copy()
        letters[still], sign[still], angles[still] = "F", 0.0, 0.0
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


def _unused(options: ReadOptions, letters: Letters) -> list[Finding]:
    """The finding of an angle that is given for creases of which there are none."""
    if options.rigid or (options.assign and bool(np.isin(letters, ["U", UNLETTERED]).any())):
        return []
    text = (
        f"--fold-deg {options.fold_deg:g} has no effect: no mountain or valley is without a fold "
        "angle."
    )
    return [Finding("fold-deg-unused", Severity.WARNING, text)]


def full_fold_deg(options: ReadOptions) -> float:
    """What mountains and valleys without an angle fold by."""
    return _FULLY_FOLDED_DEG if options.fold_deg is None else options.fold_deg


def _of_lines(code: str, severity: Severity, text: str, lines: Lines, rows: np.ndarray) -> Finding:
    creases, places = first_few(np.sort(lines.number[rows])), places_of(lines.middles(rows))
    return Finding(code, severity, text, creases=creases, places=places)
