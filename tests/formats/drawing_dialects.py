"""Crease patterns as the CP, OPX, ORI and DXF files of the programs that write them.

Each dialect is a function of a `Source` that gives the bytes of a file, after what the program's
own code or files do: number formats, header blocks, letters that it drops or merges, y downwards,
its size and place of the sheet. `python tests/formats/drawing_dialects.py FOLDER` writes all files.
"""

from __future__ import annotations

import io
import json
import math
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import ezdxf
import numpy as np
from ezdxf.enums import InsertUnits

PATTERNS = Path(__file__).parent.parent / "patterns"


@dataclass(frozen=True)
class Source:
    """Lines (n, 2, 2) with y upwards, and their letters."""

    name: str
    lines: np.ndarray
    letters: np.ndarray

    def on_screen(self, size: float = 400.0) -> np.ndarray:
        """Lines as ORIPA and Oriedita have them: y downwards, `size` wide, the middle at 0."""
        low, high = self.lines.min(axis=(0, 1)), self.lines.max(axis=(0, 1))
        scale = size / (high - low).max()
        return (self.lines - (low + high) / 2) * scale * [1, -1]


@dataclass(frozen=True)
class Dialect:
    """A manner of writing.

    write : the file of a source.
    letters : what the file says instead of a letter, "" where its lines are left out.
    mm_per_unit : None where the file names no unit.
    """

    ending: str
    write: Callable[[Source], bytes]
    letters: dict[str, str]
    mm_per_unit: float | None = None

    def kept(self, source: Source) -> Source:
        """What a reader should find, in units of the source."""
        letters = np.array([self.letters.get(letter, letter) for letter in source.letters.tolist()])
        there = letters != ""
        return Source(source.name, source.lines[there], letters[there])


def published(name: str) -> Source:
    """A pattern of tests/patterns."""
    document = json.loads((PATTERNS / f"{name}.fold").read_text())
    coords = np.array(document["vertices_coords"], float)[:, :2]
    letters = np.array([letter.upper() for letter in document["edges_assignment"]])
    return Source(name, coords[np.array(document["edges_vertices"])], letters)


def spiral(count: int = 17) -> Source:
    """Lines of every letter and of irrational lengths, none of whose mirror images is its own."""
    turn = np.arange(count + 1) * 0.7
    points = np.column_stack([turn * np.cos(turn), 1.3 * turn * np.sin(turn)]) * math.pi
    lines = np.stack([points[:-1], points[1:]], axis=1)
    return Source("spiral", lines, np.array(list("BMVFUCJ"))[np.arange(count) % 7])


def tree() -> Source:
    """A bisected corner again and again on a square, as in the base of a tree: M, V, B and F."""
    lines, letters = [], []
    corners = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float)
    for i in range(4):
        lines.append([corners[i], corners[(i + 1) % 4]])
        letters.append("B")
    for k in range(1, 8):
        angle = math.pi / 4 * k / 4
        end = [1.0, math.tan(angle)] if angle <= math.pi / 4 else [1 / math.tan(angle), 1.0]
        lines.append([[0, 0], end])
        letters.append("MVFV"[k % 4])
    return Source("tree", np.array(lines), np.array(letters))


SOURCES = [
    *(published(path.stem) for path in sorted(PATTERNS.glob("*.fold"))),
    spiral(),
    tree(),
]
BY_NAME = {source.name: source for source in SOURCES}


def java(value: float) -> str:
    """A double as Java prints it: "2.0E-14" outside of [0.001, 10 000 000)."""
    if value == 0 or 1e-3 <= abs(value) < 1e7:
        return repr(float(value))
    shortest = next(text for k in range(17) if float(text := f"{value:.{k}e}") == value)
    digits, _, exponent = shortest.partition("e")
    return f"{digits if '.' in digits else digits + '.0'}E{int(exponent)}"


# CP


_CP_TYPES = {"B": 1, "C": 1, "M": 2, "V": 3}
_ORIEDITA = {"U": "F", "J": "F", "C": "B"}


def cp_rows(
    source: Source, aux: int | None = 4, number: Callable[[float], str] = java, between: str = " "
) -> list[str]:
    out = []
    for row, letter in zip(source.on_screen().reshape(-1, 4).tolist(), source.letters, strict=True):
        kind = _CP_TYPES.get(letter, aux)
        if kind is not None:
            out.append(between.join([str(kind), *(number(value) for value in row)]))
    return out


def _noise(value: float) -> str:
    """Rounding of a program that turned the drawing, as in Oriedita's own samples."""
    return java(value + 1e-13 * math.sin(value * 12345.678))


def _one_line(source: Source) -> bytes:
    return " ".join(cp_rows(source)).encode()


CP = {
    "oriedita": lambda s: ("\n".join(cp_rows(s)) + "\n").encode(),
    "oriedita_windows": lambda s: ("\r\n".join(cp_rows(s, number=_noise)) + "\r\n").encode(),
    "orihime_tabs": lambda s: "\n".join(cp_rows(s, between="\t")).encode(),
    "origamidraw_decimals": lambda s: "\n".join(cp_rows(s, number=lambda x: f"{x:.12f}")).encode(),
    "type_zero": lambda s: "\n".join(cp_rows(s, aux=0)).encode(),
    "type_of_a_newer_program": lambda s: "\n".join(cp_rows(s, aux=7)).encode(),
    "bom_and_blank_lines": lambda s: (
        b"\xef\xbb\xbf" + ("  \r\n\r\n".join(cp_rows(s)) + "  \r\n\r\n").encode()
    ),
    "old_macintosh": lambda s: ("\r".join(cp_rows(s)) + "\r").encode(),
    "spaces_in_columns": lambda s: "\n".join(
        cp_rows(s, number=lambda x: f"{x:>+25.15e}", between="  ")
    ).encode(),
    "decimal_commas": lambda s: "\n".join(
        cp_rows(s, number=lambda x: f"{x:.13f}".replace(".", ","))
    ).encode(),
    "commas_between": lambda s: "\n".join(cp_rows(s, between=", ")).encode(),
    "commented": lambda s: (f"# {s.name}\n" + "\n".join(cp_rows(s))).encode(),
    "one_line": _one_line,
    "utf16": lambda s: ("\n".join(cp_rows(s)) + "\n").encode("utf-16"),
}
_CP_DIALECTS = {name: Dialect(".cp", write, _ORIEDITA) for name, write in CP.items()}
_CP_DIALECTS["oripa"] = Dialect(
    ".cp",
    lambda s: ("\n".join(cp_rows(s, aux=None)) + "\n").encode(),
    {"F": "", "U": "", "J": "", "C": "B"},
)


# OPX


_OPX_TYPES = {"B": 1, "C": 1, "M": 2, "V": 3, "U": 4}


def _property(name: str, kind: str, value: str, indent: str, end: str) -> str:
    inner = f"{indent} " if indent else ""
    return (
        f'{indent}<void property="{name}">{end}{inner}<{kind}>{value}</{kind}>{end}{indent}'
        f"</void>{end}"
    )


def opx(source: Source, head: str, fields: str, *, zeros: bool, end: str, unassigned: bool) -> str:
    """A data set with its lines. Java leaves out what is zero, and so does its type 0."""
    rows = []
    for number, (row, letter) in enumerate(
        zip(source.on_screen().reshape(-1, 4).tolist(), source.letters, strict=True)
    ):
        kind = _OPX_TYPES.get(letter, 0)
        kind = 0 if kind == 4 and not unassigned else kind
        places = dict(zip(("x0", "y0", "x1", "y1"), row, strict=True))
        inner = ""
        if kind or zeros:
            inner += _property("type", "int", str(kind), "      ", end)
        for name in ("x0", "x1", "y0", "y1"):  # in the order of their names
            if places[name] or zeros:
                inner += _property(name, "double", java(places[name]), "      ", end)
        rows.append(
            f'    <void index="{number}">{end}     <object class="oripa.OriLineProxy">{end}{inner}'
            f"     </object>{end}    </void>{end}"
        )
    return (
        f'<?xml version="1.0" encoding="UTF-8"?>{end}<java version="{head}" '
        f'class="java.beans.XMLDecoder">{end} <object class="oripa.DataSet" id="DataSet0">{end}'
        f'{fields}  <void property="lines">{end}   <array class="oripa.OriLineProxy" '
        f'length="{len(rows)}">{end}{"".join(rows)}   </array>{end}  </void>{end}'
        f'  <void property="mainVersion">{end}   <int>1</int>{end}  </void>{end}'
        f'  <void property="paperSize">{end}   <double>400.0</double>{end}  </void>{end}'
        f" </object>{end}</java>{end}"
    )


def _properties(title: str, author: str, end: str) -> str:
    return _property("originalAuthorName", "string", author, "  ", end) + _property(
        "title", "string", title, "  ", end
    )


def _fields(title: str, author: str, end: str) -> str:
    out = ""
    for name, text in (("memo", ""), ("originalAuthorName", author), ("title", title)):
        out += (
            f'  <void class="oripa.DataSet" method="getField">{end}   <string>{name}</string>{end}'
            f'   <void method="set">{end}    <object idref="DataSet0"/>{end}'
            f"    <string>{text}</string>{end}   </void>{end}  </void>{end}"
        )
    return out


_OPX = {
    "oripa_2005": lambda s: opx(
        s,
        "1.5.0_02",
        _properties(s.name, "", " \n"),
        zeros=False,
        end=" \n",
        unassigned=False,
    ),
    "oripa_2013": lambda s: opx(
        s, "1.7.0_45", _fields(s.name, "", "\r\n"), zeros=False, end="\r\n", unassigned=False
    ),
    "oripa_2024": lambda s: opx(
        s, "17.0.2", _fields(s.name, "", "\n"), zeros=False, end="\n", unassigned=True
    ),
    "fold_converter": lambda s: opx(
        s, "1.5.0_05", _properties(s.name, "", "\n"), zeros=True, end="\n", unassigned=False
    ),
    "without_line_breaks": lambda s: opx(
        s, "11.0.1", _fields(s.name, "", ""), zeros=False, end="", unassigned=True
    ),
}
_OPX_DIALECTS = {
    name: Dialect(
        ".opx",
        lambda s, write=write: write(s).encode(),
        {"J": "F", "C": "B"}
        | ({} if name in ("oripa_2024", "without_line_breaks") else {"U": "F"}),
    )
    for name, write in _OPX.items()
}


# ORI and ORH


_COLOURS = {"B": "BLACK_0", "C": "BLACK_0", "M": "RED_1", "V": "BLUE_2", "U": "GREY_10"}


def ori(source: Source, version: dict[str, str]) -> bytes:
    """What Oriedita writes, with lines that take no part in folding, circles and its settings."""
    look = {"customized": 0, "customizedColor": "ff64c8c8"}
    segments = [
        {
            "a": f"{java(x1)},{java(y1)}",
            "b": f"{java(x2)},{java(y2)}",
            "active": "INACTIVE_0",
            "color": _COLOURS.get(letter, "CYAN_3"),
            **look,
            "selected": 0,
        }
        for (x1, y1, x2, y2), letter in zip(
            source.on_screen().reshape(-1, 4).tolist(), source.letters, strict=True
        )
    ]
    live = {"a": "150.0,50.0", "b": "-150.0,50.0", "color": "ORANGE_4", **look}
    circle = {"x": 100.00000000000001, "y": -100.0, "r": 50.0, "color": "CYAN_3", **look}
    document = {
        **version,
        "lineSegments": segments,
        "circles": [circle],
        "title": "_",
        "points": [],
        "auxLineSegments": [live],
        "gridModel": {"gridSize": 8, "baseState": "WITHIN_PAPER"},
    }
    return json.dumps(document, separators=(",", ":")).encode()


def orh(source: Source, encoding: str) -> bytes:
    """What Orihime writes, and Oriedita for it."""
    numbers = {"B": 0, "C": 0, "M": 1, "V": 2}
    out = ["<タイトル>", f"タイトル,{source.name}", "<線分集合>"]
    for number, (row, letter) in enumerate(
        zip(source.on_screen().reshape(-1, 4).tolist(), source.letters, strict=True), 1
    ):
        out += [f"番号,{number}", f"色,{numbers.get(letter, 3)}", "<tpp>0</tpp>"]
        out += ["<tpp_color_R>100</tpp_color_R>", "座標," + ",".join(java(v) for v in row)]
    out += ["<円集合>", "番号,1", "中心と半径と色,0.0,0.0,50.0,3", "<補助線分集合>", "補助番号,1"]
    out += ["補助色,4", "補助座標,0.0,0.0,1.0,1.0", "<camera_of_orisen_nyuuryokuzu>"]
    out += ["<camera_kakudo>0.0</camera_kakudo>", "</camera_of_orisen_nyuuryokuzu>"]
    return ("\n".join(out) + "\n").encode(encoding)


_ORI_DIALECTS = {
    "oriedita_v1.1": Dialect(".ori", lambda s: ori(s, {"@version": "v1.1"}), {"C": "B", "J": "F"}),
    "oriedita_0.0.11": Dialect(
        ".ori", lambda s: ori(s, {"version": "0.0.11"}), {"C": "B", "J": "F"}
    ),
    "orihime": Dialect(".orh", lambda s: orh(s, "utf-8"), _ORIEDITA),
    "orihime_shift_jis": Dialect(".orh", lambda s: orh(s, "shift_jis"), _ORIEDITA),
}


# DXF


def tags(*pairs: tuple[int, object], end: str = "\n") -> str:
    return "".join(f"{code:>3}{end}{value}{end}" for code, value in pairs)


def _r12_lines(source: Source, scale: float, centre: tuple[float, float], style: dict) -> bytes:
    """The little DXF of ORIPA and Oriedita: no tables, y negated, inches or nothing in mind."""
    out = tags((0, "SECTION"), (2, "HEADER"), (9, "$ACADVER"), (1, "AC1009"), (0, "ENDSEC"))
    out += tags((0, "SECTION"), (2, "ENTITIES"))
    for row, letter in zip(source.on_screen().reshape(-1, 4).tolist(), source.letters, strict=True):
        layer, colour = style.get(letter, ("noname", 0))
        x1, y1, x2, y2 = row
        out += tags((0, "LINE"), (8, layer), (6, "CONTINUOUS"), (62, colour))
        out += tags((10, java(x1 * scale + centre[0])), (20, java(-y1 * scale + centre[1])))
        out += tags((11, java(x2 * scale + centre[0])), (21, java(-y2 * scale + centre[1])))
    return (out + tags((0, "ENDSEC"), (0, "EOF"))).encode()


_ORIPA_STYLE = {
    "B": ("CutLine", 3),
    "C": ("CutLine", 3),
    "M": ("MountainLine", 1),
    "V": ("ValleyLine", 5),
}
_ORIEDITA_STYLE = {
    "B": ("CutLine", 250),
    "C": ("CutLine", 250),
    "M": ("MountainLine", 1),
    "V": ("ValleyLine", 5),
    "F": ("AuxiliaryLine", 4),
    "U": ("AuxiliaryLine", 4),
    "J": ("AuxiliaryLine", 4),
}
_ACI = {"B": 7, "M": 1, "V": 5, "F": 2, "U": 6, "C": 3, "J": 2}
_RGB = {"B": 0x231F20, "M": 0xED1C24, "V": 0x2E3192, "F": 0xFFF200, "U": 0xEC008C, "C": 0x00A651}


def _saved(document: ezdxf.document.Drawing, end: str = "\n") -> bytes:
    stream = io.StringIO()
    document.write(stream)
    return stream.getvalue().replace("\n", end).encode(document.output_encoding, "dxfreplace")


def librecad(source: Source, version: str, unit: InsertUnits, per_mm: float) -> bytes:
    """Lines by layer on layers of their colours, a construction layer that is off, Windows' ends;
    $MEASUREMENT says 1 whatever the unit, as its bug 636 has it."""
    document = ezdxf.new(version)
    if version != "R12":
        document.units = unit
        document.header["$MEASUREMENT"] = 1
    space = document.modelspace()
    for letter, colour in _ACI.items():
        document.layers.add(f"layer {letter}_", color=colour)
    document.layers.add("Hilfskonstruktion", color=252).off()
    for (start, end), letter in zip(source.lines.tolist(), source.letters, strict=True):
        attributes = {"layer": f"layer {letter}_", "linetype": "BYLAYER"}
        space.add_line([v * per_mm for v in start], [v * per_mm for v in end], attributes)
    space.add_line((0, 0), (1e4, 1e4), {"layer": "Hilfskonstruktion"})
    space.add_text("Faltmuster ä", dxfattribs={"layer": "0"})
    return _saved(document, "\r\n")


def autocad_blocks(source: Source) -> bytes:
    """A mirrored and turned block of a block, its lines on layer 0 or BYBLOCK, inserted once for
    each letter on the layer or in the colour of that letter; feet."""
    document = ezdxf.new("R2018")
    document.units = InsertUnits.Feet
    space = document.modelspace()
    names = {"B": "PAPER OUTLINE", "M": "Mountain folds", "V": "valley_folds", "C": "SLITS"}
    for index, letter in enumerate(dict.fromkeys(source.letters.tolist())):
        inner = document.blocks.new(f"INNER{index}", base_point=(3, -2))
        for start, end in source.lines[source.letters == letter].tolist():
            inner.add_line(start, end, {"layer": "0", "color": 0})
        # half a turn, mirrored along x, twice as large
        outer = document.blocks.new(f"*U{index}")
        outer.add_blockref(
            f"INNER{index}", (0, 0), {"color": 0, "rotation": 180, "xscale": -2, "yscale": 2}
        )
        layer = names.get(letter, f"Ebene {index}")
        if layer not in document.layers:
            document.layers.add(layer, color=_ACI[letter])
        # the other half turn, mirrored again, back to size
        space.add_blockref(
            f"*U{index}", (7, 5), {"layer": layer, "rotation": 180, "xscale": -0.5, "yscale": 0.5}
        )
    space.add_mtext("A title block")
    document.layout("Layout1").add_line((0, 0), (297, 0))
    return _saved(document, "\r\n")


def autocad_polylines(source: Source) -> bytes:
    """Polylines of one side in a plane of extrusion (0, 0, -1), at a height; inches."""
    document = ezdxf.new("R2000")
    document.units = InsertUnits.Inches
    document.header["$MEASUREMENT"] = 0
    space = document.modelspace()
    for number, ((start, end), letter) in enumerate(
        zip(source.lines.tolist(), source.letters, strict=True)
    ):
        attributes = {"color": _ACI[letter]}
        flipped = [(-x, y) for x, y in (start, end)]
        mirrored = {**attributes, "extrusion": (0, 0, -1), "elevation": 4.0}
        if number % 3 == 0:
            space.add_lwpolyline(flipped, dxfattribs=mirrored)
        elif number % 3 == 1:
            space.add_polyline2d(flipped, dxfattribs={**attributes, "extrusion": (0, 0, -1)})
        else:
            space.add_polyline3d([(*start, 2.0), (*end, 2.0)], dxfattribs=attributes)
    return _saved(document)


def inkscape(source: Source) -> bytes:
    """R14 as "Desktop Cutting Plotter" writes it: metric but no unit, no objects, %f numbers."""
    out = tags((999, "DXF R14 created by Inkscape"), (0, "SECTION"), (2, "HEADER"))
    out += tags((9, "$ACADVER"), (1, "AC1014"), (9, "$HANDSEED"), (5, "FFFF"))
    out += tags((9, "$MEASUREMENT"), (70, 1), (0, "ENDSEC"))
    out += tags((0, "SECTION"), (2, "TABLES"), (0, "TABLE"), (2, "LAYER"), (5, 2))
    out += tags((100, "AcDbSymbolTable"), (70, 1), (0, "LAYER"), (5, 10))
    out += tags((100, "AcDbSymbolTableRecord"), (100, "AcDbLayerTableRecord"), (2, "Ebene 1"))
    out += tags((70, 0), (62, 7), (6, "CONTINUOUS"), (0, "ENDTAB"), (0, "ENDSEC"))
    out += tags((0, "SECTION"), (2, "BLOCKS"), (0, "ENDSEC"), (0, "SECTION"), (2, "ENTITIES"))
    handle = 255
    for number, ((start, end), letter) in enumerate(
        zip(source.lines.tolist(), source.letters, strict=True)
    ):
        handle += 1
        head = [(5, f"{handle:x}"), (100, "AcDbEntity"), (8, "Ebene 1"), (62, _ACI[letter])]
        (x1, y1), (x2, y2) = start, end
        if number % 2:
            out += tags((0, "LINE"), *head, (100, "AcDbLine"), (10, f"{x1:f}"), (20, f"{y1:f}"))
            out += tags((30, "0.0"), (11, f"{x2:f}"), (21, f"{y2:f}"), (31, "0.0"))
        else:
            out += tags((0, "LWPOLYLINE"), *head, (100, "AcDbPolyline"), (90, 2), (70, 0), (43, 0))
            out += tags((10, f"{x1:f}"), (20, f"{y1:f}"), (30, "0.0"))
            out += tags((10, f"{x2:f}"), (20, f"{y2:f}"), (30, "0.0"))
    return (out + tags((0, "ENDSEC"), (0, "EOF"))).encode()


def illustrator(source: Source) -> bytes:
    """True colours of the CMYK swatches, straight splines, every path on a layer of its number."""
    document = ezdxf.new("R2007")
    document.units = InsertUnits.Millimeters
    space = document.modelspace()
    for (start, end), letter in zip(source.lines.tolist(), source.letters, strict=True):
        attributes = {"layer": "Layer 1", "true_color": _RGB.get(letter, _RGB["F"]), "color": 250}
        thirds = [np.add(start, np.subtract(end, start) * t / 3).tolist() for t in range(4)]
        space.add_open_spline([(*point, 0.0) for point in thirds], dxfattribs=attributes)
    return _saved(document)


def fusion(source: Source) -> bytes:
    """A sketch: one layer, white lines alone, centimetres named as such."""
    document = ezdxf.new("R2010")
    document.units = InsertUnits.Centimeters
    space = document.modelspace()
    for start, end in source.lines.tolist():
        space.add_line((*start, 0.0), (*end, 0.0))
    space.add_point((0, 0))
    return _saved(document, "\r\n")


def paper_space(source: Source) -> bytes:
    """All lines in a layout, true colours by layer; metres."""
    document = ezdxf.new("R2013")
    document.units = InsertUnits.Meters
    layout = document.layout("Layout1")
    for letter, colour in _ACI.items():
        layer = document.layers.add(f"Ebene-{ord(letter)}", color=8)
        layer.rgb = ezdxf.colors.aci2rgb(colour)
    for (start, end), letter in zip(source.lines.tolist(), source.letters, strict=True):
        layout.add_line(start, end, {"layer": f"Ebene-{ord(letter)}"})
    return _saved(document)


def binary(source: Source) -> bytes:
    """Binary DXF of colours."""
    document = ezdxf.new("R2004")
    document.units = InsertUnits.Millimeters
    for (start, end), letter in zip(source.lines.tolist(), source.letters, strict=True):
        document.modelspace().add_line(start, end, {"color": _ACI[letter]})
    stream = io.BytesIO()
    document.write(stream, fmt="bin")
    return stream.getvalue()


_JOINED = {"J": "F"}
_DXF_DIALECTS = {
    "oripa": Dialect(
        ".dxf",
        lambda s: _r12_lines(s, 6.0 / 400, (4.0, 7.0), _ORIPA_STYLE),
        {"C": "B", "U": "F", "J": "F"},
    ),
    "oriedita": Dialect(
        ".dxf", lambda s: _r12_lines(s, 3.0, (604.0, 604.0), _ORIEDITA_STYLE), _ORIEDITA
    ),
    "librecad_mm": Dialect(
        ".dxf", lambda s: librecad(s, "R2007", InsertUnits.Millimeters, 1.0), _JOINED, 1.0
    ),
    "librecad_inch": Dialect(
        ".dxf", lambda s: librecad(s, "R2000", InsertUnits.Inches, 1 / 25.4), _JOINED, 25.4
    ),
    "librecad_r12": Dialect(
        ".dxf", lambda s: librecad(s, "R12", InsertUnits.Millimeters, 1.0), _JOINED
    ),
    "autocad_blocks": Dialect(".dxf", autocad_blocks, _JOINED, 304.8),
    "autocad_polylines": Dialect(".dxf", autocad_polylines, _JOINED, 25.4),
    "inkscape": Dialect(".dxf", inkscape, _JOINED),
    "illustrator": Dialect(".dxf", illustrator, _JOINED, 1.0),
    "fusion": Dialect(".dxf", fusion, dict.fromkeys("MVFUCJ", "B"), 10.0),
    "paper_space": Dialect(".dxf", paper_space, _JOINED, 1000.0),
    "binary": Dialect(".dxf", binary, _JOINED, 1.0),
}

DIALECTS = {
    f"{dialect.ending[1:]}_{name}": dialect
    for group in (_CP_DIALECTS, _OPX_DIALECTS, _ORI_DIALECTS, _DXF_DIALECTS)
    for name, dialect in group.items()
}


def files() -> dict[str, tuple[Dialect, Source]]:
    """Dialects with their sources by name of file: each dialect with three sources in turn, the
    spiral of all letters among them."""
    out = {}
    for number, (name, dialect) in enumerate(DIALECTS.items()):
        picked = [SOURCES[(2 * number + k) % len(SOURCES)] for k in range(2)] + [BY_NAME["spiral"]]
        for source in {source.name: source for source in picked}.values():
            out[f"{source.name}_{name}{dialect.ending}"] = dialect, source
    return out


if __name__ == "__main__":
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    for file, (dialect, source) in files().items():
        (folder / file).write_bytes(dialect.write(source))
