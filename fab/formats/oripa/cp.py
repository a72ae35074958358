"""CP files of ORIPA and Oriedita: a line of text for each crease.

    type x1 y1 x2 y2

Types are 1 border, 2 mountain, 3 valley and 4 auxiliary; some programs write 0 for auxiliary lines,
and Oriedita takes every other number for one. There is no header, no unit and no fold angle: the
usual sheet is 400 wide around the origin, y downwards (`oripa_lines` has the proof).
"""

from __future__ import annotations

import io
import re
from pathlib import Path

import numpy as np

from fab.errors import Finding, InvalidFile, Severity
from fab.formats.drawn.line_soup import LineSoup
from fab.formats.oripa.lines import AUXILIARY, oripa_soup
from fab.formats.read_options import ReadOptions
from fab.formats.source_files import shown, source_text
from fab.pattern.crease_pattern import CreasePattern
from solver.vectors import FloatArray

__all__ = ["cp_bytes", "lost_in_cp", "read_cp"]

# About two million lines.
LARGEST_BYTES = 200_000_000
_KINDS = {1: "border", 2: "mountain", 3: "valley", 4: AUXILIARY, 0: AUXILIARY}
_TYPES = {"B": 1, "C": 1, "M": 2, "V": 3}
_COLUMNS = 5
_COMMENT = ("#", "//", ";", "%", "!")
_NUMBER = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eEdD][+-]?\d+)?")
_COMMA_NUMBER = re.compile(r"[+-]?\d+,\d*([eE][+-]?\d+)?")
_NAMED = 6


def read_cp(path: Path, options: ReadOptions) -> LineSoup:
    """The lines of a CP file of up to 200 MB; y is turned upwards, the file names no unit.

    Raises `InvalidFile` with the number of the line for lines that are not five numbers, NaN, and
    types that are not whole. Codes of the findings: "comment-lines", "decimal-commas",
    "separators", "one-line", and those of `oripa_soup`.
    """
    text = source_text(path, LARGEST_BYTES)
    try:  # the five columns of every program, a hundred times faster than line by line
        rows = np.loadtxt(io.StringIO(text), ndmin=2, comments=None)
        plain = rows.shape[1] == _COLUMNS and bool(np.isfinite(rows).all())
    except ValueError:
        plain = False
    findings: list[Finding] = []
    if plain:
        numbers = _line_numbers(text, len(rows))
    else:
        rows, numbers, findings = _rows(path, text)
    whole = rows[:, 0] == np.floor(rows[:, 0])
    odd = np.flatnonzero(~whole | (np.abs(rows[:, 0]) > 1e9))
    if len(odd):
        raise InvalidFile(
            f"{path}: line {numbers[odd[0]]}: the type {rows[odd[0], 0]:g} is none of 1 (border), "
            "2 (mountain), 3 (valley), 4 (auxiliary). Each line is: type x1 y1 x2 y2."
        )
    elements = [f"line {number}" for number in numbers]
    lines = rows[:, 0].astype(np.int64), np.ascontiguousarray(rows[:, 1:])
    return oripa_soup(path, "", lines, _KINDS, elements, findings, options)


def cp_bytes(pattern: CreasePattern) -> bytes:
    """The CP file of a pattern: a unit is a millimetre, the middle of its box is the origin.

    Borders and cuts have type 1, which ORIPA calls cut; facet creases, joins and unassigned creases
    type 4. `lost_in_cp` reports what the file has no place for.
    """
    coords = pattern.vertices_coords
    middle = (coords.min(axis=0) + coords.max(axis=0)) / 2
    places = (coords - middle) * [1.0, -1.0] + 0.0
    ends = places[pattern.edges_vertices].reshape(-1, 4)
    return "".join(
        f"{_TYPES.get(letter, 4)} {x1!r} {y1!r} {x2!r} {y2!r}\n"
        for letter, (x1, y1, x2, y2) in zip(
            pattern.edges_assignment.tolist(), ends.tolist(), strict=True
        )
    ).encode()


def lost_in_cp(pattern: CreasePattern) -> tuple[Finding, ...]:
    """What a CP file has no place for: letters apart from B, M, V, F, and partial fold angles."""
    letters, angles = pattern.edges_assignment, np.abs(pattern.edges_foldAngle)
    lost = np.flatnonzero(np.isin(letters, ["U", "C", "J"]))
    partial = np.flatnonzero(np.isin(letters, ["M", "V"]) & (np.abs(angles - 180.0) > 1e-9))
    out = []
    if len(lost):
        some = "cuts, joins or unassigned creases have"
        what = "cut, join or unassigned crease has" if len(lost) == 1 else some
        text = (
            f"{len(lost)} {what} no type in CP files: cuts are written as borders, the others as "
            "auxiliary lines. Keep the FOLD file."
        )
        out.append(("lost-in-cp", text, lost))
    if len(partial):
        what = "crease folds" if len(partial) == 1 else "creases fold"
        text = (
            f"{len(partial)} {what} by less than 180 degrees, which CP files cannot say. Keep the "
            "FOLD file."
        )
        out.append(("angles-lost-in-cp", text, partial))
    return tuple(
        Finding(code, Severity.WARNING, text, tuple(edges[:20].tolist()))
        for code, text, edges in out
    )


def _line_numbers(text: str, count: int) -> list[int]:
    """Numbers of the lines that are not blank, of which there are `count`."""
    # as numpy breaks lines, which str.splitlines does not: it also breaks at form feeds
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    if len(lines) in (count, count + 1) and all(lines[:count]):
        return list(range(1, count + 1))
    return [number for number, line in enumerate(lines, 1) if line.strip()][:count]


def _rows(path: Path, text: str) -> tuple[FloatArray, list[int], list[Finding]]:
    """Rows of five numbers, the numbers of their lines, and what was repaired."""
    rows: list[list[float]] = []
    numbers: list[int] = []
    repaired: dict[str, list[int]] = {}
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    filled = [(number, line) for number, line in enumerate(lines, 1) if line.strip()]
    if len(filled) == 1 and (whole := _one_line(filled[0][1])) is not None:
        text = (
            "all numbers are in one line: five of them in turn are taken for a crease, as ORIPA "
            "reads them."
        )
        count = len(whole)
        return whole, [filled[0][0]] * count, [Finding("one-line", Severity.NOTE, text)]
    for number, line in filled:
        if line.lstrip().startswith(_COMMENT):
            repaired.setdefault("comment-lines", []).append(number)
            continue
        words = line.split()
        apart = len(words) == _COLUMNS and not any(word.endswith((",", ";")) for word in words)
        if not apart and ("," in line or ";" in line):
            between = ";" if ";" in line else ","
            words = [word.strip() for word in line.split(between)]
            repaired.setdefault("separators", []).append(number)
        if any(_COMMA_NUMBER.fullmatch(word) for word in words):
            if not any("." in word for word in words):
                words = [word.replace(",", ".") for word in words]
            repaired.setdefault("decimal-commas", []).append(number)
        rows.append(_numbers(path, number, words))
        numbers.append(number)
    return np.array(rows).reshape(-1, _COLUMNS), numbers, _repairs(repaired)


def _numbers(path: Path, number: int, words: list[str]) -> list[float]:
    where = f"{path}: line {number}"
    cure = "Each line is: type x1 y1 x2 y2. Correct it, or put # before it."
    if len(words) != _COLUMNS:
        what = "1 column" if len(words) == 1 else f"{len(words)} columns"
        raise InvalidFile(f"{where}: {what} instead of 5: {shown(' '.join(words))}. {cure}")
    wrong = next((word for word in words if not _NUMBER.fullmatch(word)), None)
    if wrong is not None:
        raise InvalidFile(f"{where}: {shown(wrong)} is no finite number. {cure}")
    values = [float(word.replace("d", "e").replace("D", "e")) for word in words]
    if not np.isfinite(values).all():
        raise InvalidFile(f"{where}: a number is too large to be read. {cure}")
    return values


def _one_line(line: str) -> FloatArray | None:
    """Creases of a file whose only line has several of them; None where it is anything else."""
    words = line.split()
    if len(words) <= _COLUMNS or len(words) % _COLUMNS:
        return None
    if not all(_NUMBER.fullmatch(word) for word in words):
        return None
    if not all(re.fullmatch(r"\d", word) for word in words[::_COLUMNS]):
        return None
    return np.array([float(word.replace("d", "e").replace("D", "e")) for word in words]).reshape(
        -1, _COLUMNS
    )


def _repairs(repaired: dict[str, list[int]]) -> list[Finding]:
    texts = {
        "comment-lines": "without numbers of a crease, left out as a comment",
        "separators": "with columns between commas or semicolons instead of blanks",
        "decimal-commas": "with decimal commas, read as decimal points",
    }
    out = []
    for code, text in texts.items():
        numbers = repaired.get(code, [])
        if not numbers:
            continue
        listed = ", ".join(str(number) for number in numbers[:_NAMED])
        more = f" and {len(numbers) - _NAMED} more" if len(numbers) > _NAMED else ""
        what = "line" if len(numbers) == 1 else f"{len(numbers)} lines"
        severity = Severity.NOTE if code == "comment-lines" else Severity.WARNING
        out.append(Finding(code, severity, f"{what} {text}: {listed}{more}."))
    return out
