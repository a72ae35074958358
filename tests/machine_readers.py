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


@dataclass(frozen=True)
class Plot:
    """Strokes by tool in order, mm; where the head goes at all, shape (n, 2); speeds, cm/s."""

    strokes: list[Stroke]
    moves: np.ndarray
    speeds: dict[str, int]

    def turned_back(self, width: float) -> Plot:
        """With x and y of a sheet that many mm wide, whose depth was along the x axis."""

        def back(points: np.ndarray) -> np.ndarray:
            return np.column_stack([width - points[:, 1], points[:, 0]])

        strokes = [Stroke(stroke.tool, back(stroke.points)) for stroke in self.strokes]
        return Plot(strokes, back(self.moves), self.speeds)


def read_plotter(data: bytes) -> Plot:
    """HP-GL as a plotter obeys it: instruction by instruction, pen up or down, 40 units a mm."""
    tool, down, at = "0", False, (0, 0)
    moves, strokes, speeds, drawn = [at], [], {}, []
    text = data.decode("ascii").replace("\n", "")
    assert text.startswith("IN;")
    assert text.endswith(";")
    for number, word in enumerate(text[:-1].split(";")):
        name, rest = word[:2], word[2:]
        values = [int(value) for value in rest.split(",")] if rest else []
        if name in ("PU", "SP") and drawn:
            strokes.append(Stroke(tool, np.array(drawn) / 40))
            drawn = []
        if name == "IN":
            assert number == 0
        elif name == "SP":
            assert not down
            tool = str(*values)
        elif name == "VS":
            speeds[tool] = values[0]
        elif name in ("PU", "PD"):
            assert len(values) % 2 == 0
            down = name == "PD"
            assert tool != "0" or not down
            points = list(zip(values[::2], values[1::2], strict=True))
            if down:
                drawn = [*(drawn or [at]), *points]
            at = points[-1] if points else at
            moves += points
        else:
            assert word == "PA"
    assert not down
    assert tool == "0"
    return Plot(strokes, np.array(moves) / 40, speeds)


@dataclass(frozen=True)
class LaserRun:
    """Strokes with the laser on, by the comment before them; all places of the head, shape (n, 2);
    S and F of each tool."""

    strokes: list[Stroke]
    moves: np.ndarray
    settings: dict[str, tuple[float, float]]


def read_grbl(data: bytes) -> LaserRun:
    """G-code as GRBL 1.1 runs it: modal words, one block a line, the laser on in G1 after M4."""
    tool, drawn_by, motion, on, ended = "", "", "", False, False
    at, power, feed = (0.0, 0.0), 0.0, 0.0
    moves, strokes, settings, drawn = [at], [], {}, []
    modes = set()
    for line in data.decode("ascii").splitlines():
        assert len(line) < 80, "GRBL's line buffer"
        assert not set(line) & set("?!~\x18"), "GRBL obeys these at once"
        assert not ended
        code, _, comment = line.partition(";")
        if not code.strip():
            tool = comment.strip()
            continue
        words = re.findall(rf"([A-Z])({_NUMBER})", code)
        assert "".join(f"{letter}{number}" for letter, number in words) == code.replace(" ", "")
        values = {letter: float(number) for letter, number in words}
        assert len(values) == len(words)
        power, feed = values.get("S", power), values.get("F", feed)
        if "M" in values:
            assert values["M"] in (2, 4, 5)
            on, ended = values["M"] == 4, values["M"] == 2
        if "G" in values:
            name = f"G{values['G']:g}"
            assert name in ("G0", "G1", "G21", "G90", "G94")
            if name in ("G0", "G1"):
                motion = name
            else:
                modes.add(name)
        burning = on and motion == "G1" and power > 0
        if drawn and not ("X" in values and burning):
            strokes.append(Stroke(drawn_by, np.array(drawn)))
            drawn = []
        if "X" in values:
            assert modes == {"G21", "G90", "G94"}
            assert motion == "G0" or feed > 0
            place = (values["X"], values["Y"])
            if burning:
                drawn = [*(drawn or [at]), place]
                drawn_by = tool
                assert settings.setdefault(tool, (power, feed)) == (power, feed)
            at = place
            moves.append(at)
    assert ended
    assert not on
    return LaserRun(strokes, np.array(moves), settings)
