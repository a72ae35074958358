"""Lines of ORIPA's family of formats (CP, OPX, Oriedita's ORI) as a drawing with y upwards.

These programs draw a crease pattern on the screen with y downwards: ORIPA and Oriedita put it
through transforms that never change the sign of y onto a Java canvas, and both negate y where they
export DXF. So y is negated when a file is read and when one is written. What the screen shows is
then the sheet seen from above: red stays mountain and blue valley, and nothing is mirrored.
(Their own FOLD files have the y of the screen, and are mirror images to a program with y upwards.)
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from fab.errors import Finding, InvalidFile, Severity
from fab.formats.drawn.letters import key_of, letter_of, unused_colours
from fab.formats.drawn.line_soup import LineSoup
from fab.formats.read_options import ReadOptions
from solver.vectors import FloatArray, IntArray

__all__ = ["AUXILIARY", "oripa_soup"]

AUXILIARY = "auxiliary"
_LISTED = 6


def oripa_soup(
    path: Path,
    title: str,
    lines: tuple[IntArray, FloatArray],
    kinds: Mapping[int, str],
    elements: Sequence[str],
    findings: Sequence[Finding],
    options: ReadOptions,
) -> LineSoup:
    """The drawing of lines whose numbers are as the file has them.

    Parameters
    ----------
    lines : type of each line, shape (n,), and x, y of both ends with y downwards, shape (n, 4).
    kinds : names of the types: border, mountain, valley, auxiliary or unassigned. Other types are
        auxiliary lines, with a finding.

    Letters are those of the names, unless the options give another one. Borders within the sheet
    are cuts: ORIPA calls their type "cut". Raises `InvalidFile` where
    there are no lines, and for numbers that are not finite. Codes of the findings: "line-type",
    "auxiliary-lines", "colours-unused".
    """
    types, rows = lines
    if not len(rows):
        raise InvalidFile(f"{path}: it has no lines. Export it again, with its creases.")
    broken = np.flatnonzero(~np.isfinite(rows).all(axis=1))
    if len(broken):
        raise InvalidFile(f"{path}: {elements[broken[0]]} has a coordinate that is not finite.")
    out = list(findings)
    present, source, counts = np.unique(types, return_inverse=True, return_counts=True)
    names = [kinds.get(kind, AUXILIARY) for kind in present.tolist()]
    unknown = [
        f"{count} of type {kind}"
        for kind, count in zip(present.tolist(), counts.tolist(), strict=True)
        if kind not in kinds
    ]
    if unknown:
        known = ", ".join(f"{kind} {name}" for kind, name in kinds.items())
        more = f", and {len(unknown) - _LISTED} more types" if len(unknown) > _LISTED else ""
        text = (
            f"lines of unknown type are taken for auxiliary ones: {', '.join(unknown[:_LISTED])}"
            f"{more}. Types are: {known}."
        )
        out.append(Finding("line-type", Severity.WARNING, text))
    letters = [letter_of(None, [name], options.colours) or "F" for name in names]
    auxiliary = sum(
        count for name, count in zip(names, counts.tolist(), strict=True) if name == AUXILIARY
    )
    if auxiliary:
        letter = letters[names.index(AUXILIARY)]
        what = "facet creases, which stay flat" if letter == "F" else f"of assignment {letter}"
        one = auxiliary == 1
        text = (
            f"{auxiliary} auxiliary {'line is' if one else 'lines are'} read as {what}. Give "
            f'another assignment with --colours "auxiliary=unassigned".'
        )
        out.append(Finding("auxiliary-lines", Severity.NOTE, text))
    out += unused_colours(options.colours, set(map(key_of, names)))
    count = len(rows)
    return LineSoup(
        path,
        title,
        rows.reshape(count, 2, 2) * [1.0, -1.0] + 0.0,  # without negative zeros
        np.array(letters)[source],
        np.full(count, np.nan),
        np.arange(count),
        tuple(elements),
        None,
        tuple(out),
        downwards=True,
        border_is_cut=True,
    )
