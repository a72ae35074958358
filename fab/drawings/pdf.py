"""PDF files of cut paths, at 1:1.

A page exactly as large as the sheet, an optional content group (layer) per operation, hairlines.
pikepdf makes the file; what is drawn on the page is formatted in bulk.
"""

from __future__ import annotations

import io
from typing import BinaryIO

import pikepdf
from pikepdf import Array, Dictionary, Name, String

from fab.drawings.cut_paths import CutPaths, Layer
from fab.drawings.layer_colours import Colours
from fab.drawings.number_records import write_records
from fab.outputs import plain_title
from solver.errors import InvalidValue

__all__ = ["pdf_bytes"]

_POINTS_PER_MM = 72 / 25.4
# ISO 32000-1, annex C: 14400 units, that is 200 inches.
_LARGEST_MM = 5080.0
# Drivers of laser cutters follow lines of up to 0.001 inch as paths.
_HAIRLINE_MM = 0.01


def pdf_bytes(paths: CutPaths, title: str, colours: Colours | None = None) -> bytes:
    """The PDF file, the same bytes for the same paths; as seen from the upper side, y up.

    title : of the document; "_" replaces what cannot be printed. Raises `InvalidValue` where the
    sheet is larger than a page may be.
    """
    if max(paths.size_mm) > _LARGEST_MM:
        cure = "Split the sheet, or write DXF or SVG."
        raise InvalidValue("sheet", paths.size_mm, f"be at most {_LARGEST_MM:g} mm wide", cure)
    chosen = colours or Colours()
    pdf = pikepdf.new()
    groups = {
        f"/{layer.operation}": pdf.make_indirect(
            Dictionary(Type=Name.OCG, Name=String(layer.operation))
        )
        for layer in paths.layers
    }
    scale = b"%.12f" % _POINTS_PER_MM
    drawn = io.BytesIO()
    drawn.write(b"%b 0 0 %b 0 0 cm\n%.2f w\n" % (scale, scale, _HAIRLINE_MM))
    for layer in paths.layers:
        _write_group(drawn, layer, chosen.of(layer.operation).hex)
    page = Dictionary(
        Type=Name.Page,
        MediaBox=Array([0, 0, *(round(side * _POINTS_PER_MM, 6) for side in paths.size_mm)]),
        Resources=Dictionary(Properties=Dictionary(groups)),
        Contents=pdf.make_stream(drawn.getvalue()),
    )
    pdf.pages.append(pikepdf.Page(pdf.make_indirect(page)))
    everything = Array(list(groups.values()))
    pdf.Root.OCProperties = Dictionary(
        OCGs=everything, D=Dictionary(Order=everything, ON=everything, Name=String("operations"))
    )
    pdf.docinfo[Name.Title] = String(plain_title(title))
    out = io.BytesIO()
    pdf.save(out, deterministic_id=True, min_version="1.5")  # layers are of 1.5
    return out.getvalue()


def _write_group(out: BinaryIO, layer: Layer, colour: str) -> None:
    """Write the lines of a layer, each stroked alone: readers keep no path of a million parts."""
    red, green, blue = (int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5))
    name = layer.operation.encode()
    out.write(b"/OC /%b BDC\n%.4f %.4f %.4f RG\n" % (name, red, green, blue))
    write_records(out, [b"", b" ", b" m ", b" ", b" l S\n"], layer.segments.reshape(-1, 4))
    for line, end in [*((c, b"S") for c in layer.chains), *((o, b"s") for o in layer.outlines)]:
        points = b" l\n".join(b"%.6f %.6f" % (x, y) for x, y in line.tolist())
        out.write(points.replace(b" l\n", b" m\n", 1) + b" l %b\n" % end)
    out.write(b"EMC\n")
