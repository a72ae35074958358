"""Readers of what machines follow line by line, written after the documentation of each format.

They share no code with the writers. Each gives the lines that are cut or drawn, in order, with the
name or number of their operation.
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass

import numpy as np

_NUMBER = r"-?[0-9]+(?:\.[0-9]+)?"


@dataclass(frozen=True)
class Stroke:
    """A line drawn in one go: shape (m, 2), mm; and what draws it."""

    tool: str
    points: np.ndarray

    @property
    def length(self) -> float:
        return float(np.hypot(*np.diff(self.points, axis=0).T).sum())


def lengths_by_tool(strokes: list[Stroke]) -> dict[str, float]:
    out: dict[str, float] = {}
    for stroke in strokes:
        out[stroke.tool] = out.get(stroke.tool, 0.0) + stroke.length
    return out


@dataclass(frozen=True)
class LightBurnProject:
    """Layers in the order of their priority, by name: their values; strokes in file order."""

    layers: dict[str, dict[str, str]]
    strokes: list[Stroke]
    notes: ElementTree.Element
    planner: dict[str, float]


def read_lightburn(data: bytes) -> LightBurnProject:
    root = ElementTree.fromstring(data)
    assert root.tag == "LightBurnProject"
    assert (root.get("FormatVersion"), root.get("MirrorX"), root.get("MirrorY")) == (
        "1",
        "False",
        "False",
    )
    tables = [{v.tag: v.get("Value") for v in table} for table in root.findall("CutSetting")]
    assert all(table.get("type") == "Cut" for table in root.findall("CutSetting"))
    tables.sort(key=lambda table: int(table["priority"]))
    names = {table["index"]: table["name"] for table in tables}
    assert len(names) == len(tables)
    strokes = []
    for shape in root.findall("Shape"):
        assert shape.get("Type") == "Path"
        a, b, c, d, e, f = map(float, shape.findtext("XForm").split())
        text, handles = shape.findtext("VertList"), r"(?:c0x1|c0x\S+?c0y\S+?)?(?:c1x1)?"
        assert re.fullmatch(rf"(V{_NUMBER} {_NUMBER}{handles})+", text)
        found = re.findall(rf"V({_NUMBER}) ({_NUMBER})", text)
        points = np.array(found, float) @ [[a, b], [c, d]] + [e, f]
        sides = shape.findtext("PrimList")
        assert re.fullmatch(r"(L\d+ \d+)+", sides)
        pairs = np.array(re.findall(r"L(\d+) (\d+)", sides), int)
        assert (pairs[1:, 0] == pairs[:-1, 1]).all()
        order = [pairs[0, 0], *pairs[:, 1]]
        strokes.append(Stroke(names[shape.get("CutIndex")], points[order]))
    planner = {v.tag: float(v.get("Value")) for v in root.find("UIPrefs")}
    return LightBurnProject({t["name"]: t for t in tables}, strokes, root.find("Notes"), planner)
