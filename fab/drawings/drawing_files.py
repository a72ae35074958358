"""Files of a drawing, in every format that is asked for."""

from __future__ import annotations

from collections.abc import Sequence
from enum import StrEnum

from fab.drawings.cut_paths import CutPaths
from fab.drawings.dxf import DxfVersion, dxf_bytes
from fab.drawings.layer_colours import Colours
from fab.drawings.svg import STROKE_MM, svg_bytes

__all__ = ["SheetFormat", "drawing_files"]


class SheetFormat(StrEnum):
    """Formats of drawings, named by the endings of their files."""

    DXF = "dxf"
    SVG = "svg"
    PDF = "pdf"


def drawing_files(
    paths: CutPaths,
    name: str,
    formats: Sequence[SheetFormat],
    colours: Colours | None = None,
    dxf_version: DxfVersion = DxfVersion.R2000,
    stroke_mm: float = STROKE_MM,
) -> dict[str, bytes]:
    """Files by name, in the order of `SheetFormat`; all of them hold the same lines.

    Parameters
    ----------
    name : of the files, without their endings, and the title of the drawing.
    colours : of the operations; where left out, the default ones.
    stroke_mm : width of the lines in SVG; in DXF and PDF they are as thin as can be.

    Raises `InvalidValue` where a sheet is larger than a page of PDF may be.
    """
    files = {}
    if SheetFormat.DXF in formats:
        files[f"{name}.dxf"] = dxf_bytes(paths, colours, dxf_version)
    if SheetFormat.SVG in formats:
        files[f"{name}.svg"] = svg_bytes(paths, name, colours, stroke_mm)
    if SheetFormat.PDF in formats:
        from fab.drawings.pdf import pdf_bytes

        files[f"{name}.pdf"] = pdf_bytes(paths, name, colours)
    return files
