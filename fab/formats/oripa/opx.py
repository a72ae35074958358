"""OPX files of ORIPA: a data set that Java's XMLEncoder wrote.

The file describes Java objects. It is read as data alone: elements and attributes are compared with
the few that ORIPA writes, and nothing is made or called by its name. Document types, and with them
entities, are refused.
"""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from fab.errors import Finding, InvalidFile, Severity
from fab.files import shortened
from fab.formats.drawn.line_soup import LineSoup
from fab.formats.oripa.lines import AUXILIARY, oripa_soup
from fab.formats.read_options import ReadOptions
from fab.formats.source_files import shown, source_bytes

__all__ = ["read_opx"]

# About 150,000 lines.
LARGEST_BYTES = 100_000_000
# Of elements in each other, and of all; ORIPA writes some ten for a line.
DEEPEST, MOST_ELEMENTS = 100, 4_000_000
_LINE, _DATA = "oripa.OriLineProxy", "oripa.DataSet"
_ENDS = ("x0", "y0", "x1", "y1")
# 4 since ORIPA 1.60 or so; its lines of type 9 show a cut through the folded model.
_KINDS = {0: AUXILIARY, 1: "border", 2: "mountain", 3: "valley", 4: "unassigned"}
_NUMBER = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?")
_TEXTS = ("title", "originalAuthorName")


def read_opx(path: Path, options: ReadOptions) -> LineSoup:
    """The lines of an OPX file of up to 100 MB; y is turned upwards, the file names no unit.

    XMLEncoder leaves out numbers that are zero, so what a line does not have is zero: a line
    without a type is an auxiliary one. The title is followed by the name of the original author.

    Raises `InvalidFile` for what is no XML, no data set of ORIPA, has a document type or a line
    with something else than numbers. Codes of the findings: "lines-missing", and those of
    `oripa_soup`.
    """
    types: list[int] = []
    rows: list[list[float]] = []
    texts: dict[str, str] = {}
    announced = 0
    belongs = False
    for element in _elements(path):
        kind = element.get("class")
        if element.tag == "array" and kind == _LINE:
            announced = _announced(element.get("length"))
        elif element.tag == "object" and kind == _DATA:
            belongs = True
        elif element.tag == "object" and kind == _LINE:
            belongs = True
            values = _properties(path, len(rows), element)
            types.append(int(values.get("type", 0)))
            rows.append([values.get(name, 0.0) for name in _ENDS])
            element.clear()
        elif element.tag == "void":
            _keep_text(element, texts)
            if element.get("index") is not None:
                element.clear()
    if not belongs:
        raise InvalidFile(f"{path}: no data set of ORIPA is in it. Save it in ORIPA as OPX.")
    findings = []
    if announced > len(rows):
        text = f"the file announces {announced} lines and has {len(rows)}: the others are missing."
        findings.append(Finding("lines-missing", Severity.WARNING, text))
    title, author = (texts.get(name, "").strip() for name in _TEXTS)
    if author and author not in title:
        title = f"{title or 'Untitled'}, by {author}"
    elements = [f"line {number}" for number in range(len(rows))]
    lines = np.array(types, np.int64), np.array(rows, np.float64).reshape(-1, 4)
    return oripa_soup(path, title, lines, _KINDS, elements, findings, options)


def _elements(path: Path) -> Iterator[Any]:
    """Elements of the file as they end."""
    from xml.etree.ElementTree import ParseError

    from defusedxml import DefusedXmlException
    from defusedxml.ElementTree import iterparse

    data = source_bytes(path, LARGEST_BYTES)
    depth = count = 0
    try:
        for event, element in iterparse(io.BytesIO(data), events=("start", "end"), forbid_dtd=True):
            if event == "end":
                depth -= 1
                yield element
                continue
            depth, count = depth + 1, count + 1
            if depth > DEEPEST or count > MOST_ELEMENTS:
                raise InvalidFile(
                    f"{path}: has over {MOST_ELEMENTS} elements, or over {DEEPEST} in each other, "
                    "as no file of ORIPA has. Save it in ORIPA again."
                )
    except InvalidFile:  # which is a ValueError too
        raise
    except DefusedXmlException as error:
        raise InvalidFile(
            f"{path}: it has a document type or entities, which ORIPA never writes. Remove them."
        ) from error
    except ParseError as error:
        raise InvalidFile(f"{path}: not an XML file: {error}. Save it in ORIPA again.") from error
    except (ValueError, LookupError) as error:  # an encoding that is unknown, or not of one byte
        raise InvalidFile(
            f"{path}: not an XML file that can be decoded: {shortened(str(error))}."
        ) from error


def _properties(path: Path, number: int, line: Any) -> dict[str, float]:
    """The numbers of a line by the names of its properties."""
    out = {}
    for void in line:
        name = void.get("property")
        if name not in ("type", *_ENDS):
            continue
        text = "".join(child.text or "" for child in void).strip()
        whole = name != "type" or re.fullmatch(r"[+-]?\d{1,9}", text)
        if not whole or not _NUMBER.fullmatch(text):
            what = "whole" if name == "type" else "finite"
            raise InvalidFile(
                f"{path}: line {number}: {name} = {shown(text)} is no {what} number. Correct it, "
                "or save the file in ORIPA again."
            )
        out[name] = float(text)
    return out


def _announced(length: str | None) -> int:
    return int(length) if length and re.fullmatch(r"\d{1,9}", length) else 0


def _keep_text(void: Any, texts: dict[str, str]) -> None:
    """Put a title or name into `texts`: the string of a property, or that a field is set to."""
    name = void.get("property")
    strings = [child.text or "" for child in void.iter("string")]
    if void.get("method") == "getField" and len(strings) > 1:
        name, strings = strings[0], strings[1:]
    if name in _TEXTS and strings:
        texts.setdefault(name, strings[0])
