"""How do cut paths become an SVG file?

In millimetres, one group per operation with Inkscape's layer attributes, hairline strokes.
"""

from __future__ import annotations

from xml.sax.saxutils import escape, quoteattr

from fab.paths import CutPaths, Layer, Operation

__all__ = ["svg_bytes"]

_COLOURS = {
    Operation.ENGRAVE: "#00a000",
    Operation.MOUNTAIN: "#ff0000",
    Operation.VALLEY: "#0000ff",
    Operation.RELIEF: "#ff00ff",
    Operation.CUT: "#000000",
}
_HAIRLINE_MM = 0.1


def svg_bytes(paths: CutPaths, title: str) -> bytes:
    """The SVG file, the same bytes for the same paths; drawn as seen from the upper side.

    SVG's y axis points down, so y is turned around: the picture is not mirrored.
    """
    width, height = paths.size_mm
    edge = _HAIRLINE_MM  # room for half a stroke on every side
    box = (-edge, -edge, width + 2 * edge, height + 2 * edge)
    head = (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<svg xmlns="http://www.w3.org/2000/svg" '
        'xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" '
        f'width="{box[2]:.6f}mm" height="{box[3]:.6f}mm" '
        f'viewBox="{box[0]:.6f} {box[1]:.6f} {box[2]:.6f} {box[3]:.6f}">\n'
        f"<title>{escape(title)}</title>\n"
    )
    groups = [_group(layer, height) for layer in paths.layers]
    return "".join([head, *groups, "</svg>\n"]).encode("utf-8")


def _group(layer: Layer, height: float) -> str:
    name = quoteattr(layer.operation)
    segments = layer.segments.reshape(-1, 4) * [1, -1, 1, -1] + [0, height, 0, height]
    dashes = ["M%.6f,%.6fL%.6f,%.6f" % tuple(row) for row in segments.tolist()]
    outlines = []
    for outline in layer.outlines:
        points = (outline * [1, -1] + [0, height]).tolist()
        outlines.append("M" + "L".join("%.6f,%.6f" % (x, y) for x, y in points) + "Z")
    drawn = "".join(f'<path d="{d}"/>\n' for d in (" ".join(dashes), *outlines) if d)
    return (
        f'<g id={name} inkscape:groupmode="layer" inkscape:label={name} fill="none" '
        f'stroke="{_COLOURS[layer.operation]}" stroke-width="{_HAIRLINE_MM}">\n{drawn}</g>\n'
    )
