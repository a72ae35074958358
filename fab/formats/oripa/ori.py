"""ORI files of Oriedita, which are JSON, and ORH files of Orihime, from which they came: text."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np

from fab.errors import Finding, InvalidFile, Severity
from fab.formats.drawn.line_soup import LineSoup
from fab.formats.json_files import read_json
from fab.formats.oripa.lines import AUXILIARY, oripa_soup
from fab.formats.read_options import ReadOptions
from fab.formats.source_files import decoded, shown, source_bytes

__all__ = ["read_ori"]

# About 500,000 lines.
LARGEST_BYTES = 100_000_000
# Colours of Oriedita and Orihime by their numbers: the first three are folding lines, the others
# auxiliary ones in eight colours.
_KINDS = {0: "border", 1: "mountain", 2: "valley", **dict.fromkeys(range(3, 10), AUXILIARY)}
_KINDS |= {10: "unassigned"}
_NUMBER = r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?"
_POINT = re.compile(rf"\s*({_NUMBER})\s*,\s*({_NUMBER})\s*")
_COLOUR = re.compile(r"(?:[A-Z]+_)?(\d{1,2})")
_LINES_OF_ORIHIME = "<線分集合>"
_ENCODINGS = ("utf-8", "euc_jp", "shift_jis")
_LEFT_OUT = {
    "auxLineSegments": ("line that takes no part in folding", "lines that take no part in folding"),
    "circles": ("circle", "circles"),
    "texts": ("text", "texts"),
}


def read_ori(path: Path, options: ReadOptions) -> LineSoup:
    """The lines of an ORI or ORH file of up to 100 MB; y is turned upwards, there is no unit.

    Raises `InvalidFile` for what is neither, and for segments without two finite ends and a colour,
    with their number. Codes of the findings: "elements-skipped", and those of `oripa_soup`.
    """
    data = source_bytes(path, LARGEST_BYTES)
    if data.lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"{"):
        return _from_json(path, options)
    text = decoded(path, data, _ENCODINGS)
    if _LINES_OF_ORIHIME in text:
        return _from_orihime(path, text, options)
    raise InvalidFile(
        f"{path}: neither a JSON file of Oriedita nor a text file of Orihime. Open it in Oriedita "
        "and export it as CP or FOLD."
    )


def _from_json(path: Path, options: ReadOptions) -> LineSoup:
    document = read_json(path, LARGEST_BYTES)
    segments = document.get("lineSegments")
    if not isinstance(segments, list):
        raise InvalidFile(f"{path}: it has no lineSegments. Save it in Oriedita again.")
    types = np.zeros(len(segments), np.int64)
    rows = np.zeros((len(segments), 4))
    for number, segment in enumerate(segments):
        if not isinstance(segment, dict):
            raise InvalidFile(f"{path}: lineSegments[{number}] is no object with ends a and b.")
        for key, at in (("a", 0), ("b", 2)):
            rows[number, at : at + 2] = _point(path, f"lineSegments[{number}].{key}", segment, key)
        types[number] = _colour(path, number, segment.get("color"))
    title = document.get("title")
    title = title if isinstance(title, str) and title != "_" else ""  # Oriedita's own for none
    counts = {key: document.get(key) for key in _LEFT_OUT}
    findings = _left_out({k: len(v) for k, v in counts.items() if isinstance(v, list) and v})
    elements = [f"lineSegments[{number}]" for number in range(len(segments))]
    return oripa_soup(path, title, (types, rows), _KINDS, elements, findings, options)


def _point(path: Path, where: str, segment: dict[str, Any], key: str) -> tuple[float, float]:
    value = segment.get(key)
    found = _POINT.fullmatch(value) if isinstance(value, str) and len(value) < 200 else None
    if found is None:
        raise InvalidFile(
            f"{path}: {where} = {shown(str(value))} is no point such as '-200.0,200.0'. Correct "
            "it, or save the file in Oriedita again."
        )
    return float(found[1]), float(found[2])


def _colour(path: Path, number: int, value: object) -> int:
    """Number of a colour such as RED_1; NONE and ANGLE of Oriedita are those of no folding line."""
    if value in ("NONE", "ANGLE"):
        return 10
    found = _COLOUR.fullmatch(str(value))
    if found is None:
        raise InvalidFile(
            f"{path}: lineSegments[{number}].color = {shown(str(value))} is no colour such as "
            "RED_1. Correct it, or save the file in Oriedita again."
        )
    return int(found[1])


def _left_out(counts: dict[str, int]) -> list[Finding]:
    if not counts:
        return []
    listed = ", ".join(f"{n} {_LEFT_OUT[key][n > 1]}" for key, n in counts.items())
    text = f"left out: {listed}."
    return [Finding("elements-skipped", Severity.NOTE, text)]


def _from_orihime(path: Path, text: str, options: ReadOptions) -> LineSoup:
    """Lines of Orihime: numbered records of a colour and four coordinates, within the section of
    line segments; circles and lines that take no part in folding have sections of their own.
    """
    types: list[int] = []
    rows: list[list[float]] = []
    skipped = {"auxLineSegments": 0, "circles": 0}
    title, section, colour = "", "", 0
    for number, line in enumerate(text.splitlines(), 1):
        head, _, rest = line.strip().partition(",")
        if re.fullmatch(r"<[^/>]*>", head):
            section = head
        elif section == "<タイトル>" and head == "タイトル" and rest not in ("", "_"):
            title = rest
        elif section == _LINES_OF_ORIHIME and head == "色":
            colour = _whole(path, number, rest)
        elif section == _LINES_OF_ORIHIME and head == "座標":
            words = rest.split(",")
            if len(words) != 4 or not all(re.fullmatch(_NUMBER, word.strip()) for word in words):
                raise InvalidFile(
                    f"{path}: line {number}: {shown(rest)} are not four finite numbers. Correct it."
                )
            types.append(colour)
            rows.append([float(word) for word in words])
        elif head == "中心と半径と色":
            skipped["circles"] += 1
        elif head == "補助座標":
            skipped["auxLineSegments"] += 1
    findings = _left_out({key: count for key, count in skipped.items() if count})
    elements = [f"line segment {number}" for number in range(1, len(rows) + 1)]
    lines = np.array(types, np.int64), np.array(rows, np.float64).reshape(-1, 4)
    return oripa_soup(path, title, lines, _KINDS, elements, findings, options)


def _whole(path: Path, number: int, text: str) -> int:
    if not re.fullmatch(r"-?\d{1,3}", text.strip()):
        raise InvalidFile(f"{path}: line {number}: {shown(text)} is no colour from 0 to 9.")
    return int(text)
