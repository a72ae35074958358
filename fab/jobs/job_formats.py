"""Kinds of files that a job makes."""

from __future__ import annotations

from enum import StrEnum

__all__ = ["OF_SCENES", "SOLID", "Format"]


class Format(StrEnum):
    """The kinds of files that a job makes, named by their endings."""

    FOLD = "fold"
    DXF = "dxf"
    SVG = "svg"
    STEP = "step"
    STL = "stl"
    THREEMF = "3mf"
    PNG = "png"
    ZIP = "zip"
    GLB = "glb"
    HTML = "html"
    PDF = "pdf"
    LBRN2 = "lbrn2"
    PLT = "plt"
    GCODE = "gcode"
    ASSEMBLY = "assembly"


# Those of the thick sheet, and those that show the sheet in space.
SOLID = frozenset({Format.STEP, Format.STL, Format.THREEMF, Format.ZIP})
OF_SCENES = frozenset({Format.GLB, Format.HTML})
