"""Crease patterns as drawings for Origami Simulator, which reads them from colours.

https://origamisimulator.org: the colour of a line says what it is, its opacity how far it folds.
"""

from __future__ import annotations

import math
from xml.sax.saxutils import escape

import numpy as np

from fab.outputs import plain_title
from fab.pattern.crease_pattern import FLAT_ANGLE_DEG, CreasePattern

__all__ = ["simulator_svg_bytes"]

_COLOURS = {
    "M": "#ff0000",
    "V": "#0000ff",
    "B": "#000000",
    "C": "#00ff00",
    "F": "#ffff00",
    "J": "#ffff00",
    "U": "#ff00ff",
}
# Ends of lines nearer than 3 units are merged when the file is read.
_SHORTEST = 10.0
# Width of lines, mm, and the largest share of the longer side that it is.
_STROKE_MM, _STROKE_REL = 0.2, 0.005


def simulator_svg_bytes(pattern: CreasePattern, title: str) -> bytes:
    """The SVG file: red mountains, blue valleys, black borders, green cuts, yellow creases that
    stay flat, magenta ones that are free; opacity is the fold angle over 180 degrees. Assignments
    and angles that this does not say (joins, mountains and valleys that stay flat, free creases
    with an angle) are data attributes as well.

    It has its size in millimetres; its units are as many times smaller, by a power of ten, as the
    shortest edge needs. Seen from the upper side (SVG's y axis points down).
    """
    ends = pattern.vertices_coords[pattern.edges_vertices]
    low, high = pattern.vertices_coords.min(axis=0), pattern.vertices_coords.max(axis=0)
    shortest = float(np.hypot(*(ends[:, 1] - ends[:, 0]).T).min())
    factor = 10.0 ** max(0, math.ceil(math.log10(_SHORTEST / shortest)))
    stroke = min(_STROKE_MM, _STROKE_REL * float((high - low).max()))
    (width, height), places = high - low, (ends - low) * [1, -1] + [0, high[1] - low[1]]
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.9g}mm" height="{height:.9g}mm" '
        f'viewBox="0 0 {width * factor:.9g} {height * factor:.9g}">',
        f"<title>{escape(plain_title(title))}</title>",
        f'<g fill="none" stroke-width="{stroke * factor:g}">',
    ]
    for (p, q), letter, angle in zip(
        (places * factor).tolist(),
        pattern.edges_assignment.tolist(),
        pattern.edges_foldAngle.tolist(),
        strict=True,
    ):
        folds = letter in "MV" and abs(angle) > FLAT_ANGLE_DEG
        colour = _COLOURS["F" if letter in "MV" and not folds else letter]
        opacity = f' stroke-opacity="{abs(angle) / 180:.9g}"' if folds else ""
        lines.append(
            f'<line x1="{p[0]:.9g}" y1="{p[1]:.9g}" x2="{q[0]:.9g}" y2="{q[1]:.9g}" '
            f'stroke="{colour}"{opacity}{_data(letter, angle, folds)}/>'
        )
    return ("\n".join([*lines, "</g>", "</svg>"]) + "\n").encode()


def _data(letter: str, angle: float, folds: bool) -> str:
    """Attributes with what colour and opacity of a line do not say."""
    if letter == "J":
        return ' data-assignment="J"'
    if (letter in "MV" and not folds) or (letter == "U" and angle != 0):
        return f' data-assignment="{letter}" data-foldAngle="{angle + 0.0:.9g}"'
    return ""
