"""Files of a drawing, in every format that is asked for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum

from fab.drawings.cut_paths import CutPaths, Operation
from fab.drawings.cut_settings import CutSetting
from fab.drawings.dxf import DxfVersion, dxf_bytes
from fab.drawings.layer_colours import Colours
from fab.drawings.svg import STROKE_MM, svg_bytes

__all__ = ["PROGRAMS", "USUAL", "DrawingStyle", "SheetFormat", "drawing_files"]


class SheetFormat(StrEnum):
    """Formats of drawings, named by the endings of their files."""

    DXF = "dxf"
    SVG = "svg"
    PDF = "pdf"
    LBRN2 = "lbrn2"
    PLT = "plt"
    GCODE = "gcode"


# What is made where nobody says; the others are made on request.
USUAL = (SheetFormat.DXF, SheetFormat.SVG, SheetFormat.PDF)
# What a machine follows line by line: dashes have to be lines in it.
PROGRAMS = frozenset({SheetFormat.LBRN2, SheetFormat.PLT, SheetFormat.GCODE})


@dataclass(frozen=True)
class DrawingStyle:
    """What a machine wants of its drawings, besides their lines.

    Attributes
    ----------
    colours : of the operations.
    stroke_mm : width of the lines in SVG; in DXF and PDF they are as thin as can be.
    settings : speed and power of the operations, for formats that hold them.
    s_max : S of G-code at full power.
    remark : one line, as a comment in SVG and DXF; empty for none.
    """

    colours: Colours = field(default_factory=Colours)
    dxf_version: DxfVersion = DxfVersion.R2000
    stroke_mm: float = STROKE_MM
    settings: Mapping[Operation, CutSetting] = field(default_factory=dict)
    s_max: float = 1000.0
    remark: str = ""


def drawing_files(
    paths: CutPaths,
    name: str,
    formats: Sequence[SheetFormat],
    style: DrawingStyle | None = None,
) -> dict[str, bytes]:
    """Files by name, in the order of `SheetFormat`; all of them hold the same lines.

    name : of the files, without their endings, and the title of the drawing.

    G-code has a second file, `name`_frame, a run around the lines without power.

    Raises `InvalidValue` where a sheet is larger than a page of PDF may be, `InvalidState` where
    G-code has an operation without power.
    """
    style = style or DrawingStyle()
    files = {}
    if SheetFormat.DXF in formats:
        files[f"{name}.dxf"] = dxf_bytes(paths, style.colours, style.dxf_version, style.remark)
    if SheetFormat.SVG in formats:
        files[f"{name}.svg"] = svg_bytes(paths, name, style.colours, style.stroke_mm, style.remark)
    if SheetFormat.PDF in formats:
        from fab.drawings.pdf import pdf_bytes

        files[f"{name}.pdf"] = pdf_bytes(paths, name, style.colours)
    if SheetFormat.LBRN2 in formats:
        from fab.drawings.lightburn import lightburn_bytes

        files[f"{name}.lbrn2"] = lightburn_bytes(paths, name, style.settings)
    if SheetFormat.PLT in formats:
        from fab.drawings.plotter import plotter_bytes

        files[f"{name}.plt"] = plotter_bytes(paths, style.settings)
    if SheetFormat.GCODE in formats:
        from fab.drawings.gcode import frame_bytes, gcode_bytes

        files[f"{name}.gcode"] = gcode_bytes(paths, style.settings, style.s_max)
        files[f"{name}_frame.gcode"] = frame_bytes(paths, style.settings)
    return files
