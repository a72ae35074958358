"""Readers of sheets as DXF, SVG and PDF files, written after the documentation of each format.

They share no code with the writers, and none with the readers of the project. Each gives the
lines of every layer, with y upwards, and the size of the page.
"""

from __future__ import annotations

import io
import re
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pypdf

_SVG = "{http://www.w3.org/2000/svg}"
_INKSCAPE = "{http://www.inkscape.org/namespaces/inkscape}"
_NUMBER = r"-?(?:[0-9]+\.?[0-9]*|\.[0-9]+)"
_MM_PER_POINT = 25.4 / 72


@dataclass(frozen=True)
class ReadSheet:
    """Lines by layer, each of shape (m, 2), closed ones with their first point again, mm.

    page : width and height in mm.
    """

    lines: dict[str, list[np.ndarray]]
    page: tuple[float, float]

    def sides(self, layer: str) -> np.ndarray:
        """Sides of all lines of a layer in an order that does not depend on theirs, (n, 4)."""
        sides = [
            sorted((tuple(first), tuple(second)))
            for line in self.lines.get(layer, [])
            for first, second in pairwise(line.tolist())
        ]
        return np.array(sorted(sides), float).reshape(-1, 4)

    def length(self, *layers: str) -> float:
        """Of all lines of some layers."""
        found = [line for layer in layers for line in self.lines.get(layer, [])]
        return sum(float(np.hypot(*np.diff(line, axis=0).T).sum()) for line in found)


def read_dxf_sheet(data: bytes) -> ReadSheet:
    """LINE, LWPOLYLINE and POLYLINE entities of a DXF file in millimetres, pair by pair."""
    rows = data.decode("utf-8").replace("\r", "").split("\n")
    pairs = [(int(code), value) for code, value in zip(rows[::2], rows[1::2], strict=False)]
    head: dict[str, list[float]] = {}
    for number, (_, name) in enumerate(pairs):
        if name in ("$EXTMIN", "$EXTMAX"):
            head[name] = [float(value) for _, value in pairs[number + 1 : number + 3]]
        assert name != "$INSUNITS" or pairs[number + 1][1].strip() == "4"
    assert head["$EXTMIN"] == [0.0, 0.0]
    start = pairs.index((2, "ENTITIES"))
    entities: list[list[tuple[int, str]]] = []
    for code, value in pairs[start + 1 :]:
        if code == 0 and value == "ENDSEC":
            break
        if code == 0:
            entities.append([])
        entities[-1].append((code, value))
    lines: dict[str, list[np.ndarray]] = {}
    chain: list[list[float]] = []
    closed, layer = False, ""
    for entity in entities:
        kind = entity[0][1]
        values: dict[int, list[str]] = {}
        for code, value in entity:
            values.setdefault(code, []).append(value)
        numbers = {code: [float(x) for x in values.get(code, [])] for code in (10, 20, 11, 21)}
        assert not any(float(x) for x in values.get(42, [])), "bulges are curves"
        if kind == "LINE":
            points = [numbers[10] + numbers[20], numbers[11] + numbers[21]]
            lines.setdefault(values[8][0], []).append(np.array(points))
        elif kind == "LWPOLYLINE":
            points = np.column_stack([numbers[10], numbers[20]])
            ring = int(values.get(70, ["0"])[0]) & 1
            lines.setdefault(values[8][0], []).append(_line(points, closed=bool(ring)))
        elif kind == "POLYLINE":
            chain, layer = [], values[8][0]
            closed = bool(int(values.get(70, ["0"])[0]) & 1)
        elif kind == "VERTEX":
            chain.append(numbers[10] + numbers[20])
        elif kind == "SEQEND":
            lines.setdefault(layer, []).append(_line(np.array(chain), closed=closed))
        else:
            raise AssertionError(f"an entity {kind}")
    return ReadSheet(lines, (head["$EXTMAX"][0], head["$EXTMAX"][1]))


def _line(points: np.ndarray, *, closed: bool) -> np.ndarray:
    return np.concatenate([points, points[:1]]) if closed else points


def read_svg_sheet(data: bytes) -> ReadSheet:
    """Paths of absolute M, L and Z in the layers of an SVG file whose user unit is a millimetre."""
    root = ElementTree.fromstring(data)
    width, height = (float(root.get(side).removesuffix("mm")) for side in ("width", "height"))
    box = [float(word) for word in root.get("viewBox").split()]
    assert box == [0.0, 0.0, width, height]
    lines: dict[str, list[np.ndarray]] = {}
    for group in root.iter(f"{_SVG}g"):
        assert group.get(f"{_INKSCAPE}label") == group.get("id")
        own = lines.setdefault(group.get("id"), [])
        for path in group:
            assert path.tag == f"{_SVG}path"
            for part in re.findall(r"M[^M]*", path.get("d")):
                assert re.fullmatch(rf"M{_NUMBER},{_NUMBER}(L{_NUMBER},{_NUMBER})*Z?\s*", part)
                points = np.array(re.findall(rf"({_NUMBER}),({_NUMBER})", part), float)
                points[:, 1] = height - points[:, 1]
                own.append(_line(points, closed="Z" in part))
    return ReadSheet({name: own for name, own in lines.items() if own}, (width, height))


def read_pdf_sheet(data: bytes) -> ReadSheet:
    """Lines in the optional contents of the one page of a PDF file, operator by operator."""
    (page,) = pypdf.PdfReader(io.BytesIO(data)).pages
    words = page.get_contents().get_data().decode("latin-1").split()
    scale, layer = 1.0, ""
    stack: list[str] = []
    lines: dict[str, list[np.ndarray]] = {}
    points: list[list[float]] = []
    for word in words:
        if re.fullmatch(rf"{_NUMBER}|/\S+", word):
            stack.append(word)
            continue
        if word == "cm":
            matrix = [float(x) for x in stack]
            assert matrix[1:3] == [0.0, 0.0]
            assert matrix[0] == matrix[3]
            assert matrix[4:] == [0.0, 0.0]
            scale *= matrix[0] * _MM_PER_POINT
        elif word == "BDC":
            layer = stack[1][1:]
        elif word == "EMC":
            layer = ""
        elif word in ("m", "l"):
            points.append([float(x) * scale for x in stack])
        elif word in ("S", "s"):
            assert layer
            lines.setdefault(layer, []).append(_line(np.array(points), closed=word == "s"))
            points = []
        else:
            assert word in ("w", "RG", "J", "j", "q", "Q"), word
        stack = []
    left, bottom, right, top = (float(x) * _MM_PER_POINT for x in page.mediabox)
    assert (left, bottom) == (0.0, 0.0)
    return ReadSheet(lines, (right, top))
