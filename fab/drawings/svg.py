"""SVG files of cut paths.

In millimetres, a group per operation with Inkscape's layer attributes, thin strokes.
"""

from __future__ import annotations

import io
from typing import BinaryIO
from xml.sax.saxutils import escape, quoteattr

from fab.drawings.cut_paths import CutPaths, Layer
from fab.drawings.layer_colours import Colours
from fab.drawings.number_records import write_records
from fab.outputs import plain_title

__all__ = ["STROKE_MM", "svg_bytes"]

# Width of lines where no other is asked for.
STROKE_MM = 0.1


def svg_bytes(
    paths: CutPaths,
    title: str,
    colours: Colours | None = None,
    stroke_mm: float = STROKE_MM,
    remark: str = "",
) -> bytes:
    """The SVG file, the same bytes for the same paths; drawn as seen from the upper side.

    The y axis of SVG points down, so y is turned around: the picture is not mirrored. A page on a
    bed is as large as the bed; others are larger than the drawing, by a stroke on every side.
    title : of the document; "_" replaces what cannot be printed. remark : its description.
    """
    width, height = paths.size_mm
    edge = 0.0 if paths.on_bed else stroke_mm
    low = 0.0 - edge  # never a negative zero
    box = (low, low, width + 2 * edge, height + 2 * edge)
    head = (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<svg xmlns="http://www.w3.org/2000/svg" '
        'xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" '
        f'width="{box[2]:.6f}mm" height="{box[3]:.6f}mm" '
        f'viewBox="{box[0]:.6f} {box[1]:.6f} {box[2]:.6f} {box[3]:.6f}">\n'
        f"<title>{escape(plain_title(title))}</title>\n"
    )
    if remark:
        head += f"<desc>{escape(plain_title(remark))}</desc>\n"
    chosen = colours or Colours()
    out = io.BytesIO()
    out.write(head.encode())
    for layer in paths.layers:
        _write_group(out, layer, height, chosen.of(layer.operation).hex, stroke_mm)
    out.write(b"</svg>\n")
    return out.getvalue()


def _write_group(out: BinaryIO, layer: Layer, height: float, colour: str, stroke_mm: float) -> None:
    """Write the lines of a layer: all segments in one path, each other line in its own."""
    name = quoteattr(layer.operation)
    out.write(
        f'<g id={name} inkscape:groupmode="layer" inkscape:label={name} fill="none" '
        f'stroke="{colour}" stroke-width="{stroke_mm:g}">\n'.encode()
    )
    segments = layer.segments.reshape(-1, 4) * [1, -1, 1, -1] + [0, height, 0, height]
    if len(segments):
        out.write(b'<path d="')
        write_records(out, [b"M", b",", b"L", b",", b" "], segments)
        out.write(b'"/>\n')
    for line, end in [*((c, "") for c in layer.chains), *((o, "Z") for o in layer.outlines)]:
        points = (line * [1, -1] + [0, height]).tolist()
        path = "M" + "L".join("%.6f,%.6f" % (x, y) for x, y in points) + end
        out.write(f'<path d="{path}"/>\n'.encode())
    out.write(b"</g>\n")
