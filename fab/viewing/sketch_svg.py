"""Sketches as SVG elements for pages of a browser."""

from __future__ import annotations

import base64
import io
from html import escape

import numpy as np

from fab.outputs import plain_title
from fab.viewing.sketch import Area, Image, Lines, Sketch, Words

__all__ = ["sketch_svg"]

# Height of capitals, and of a line of text, in sizes of the font; width of a letter, about.
_CAPITALS, _LINE, _LETTER = 0.72, 1.15, 0.64
_PICTURE_COLOURS = 64
# Of browsers, for a millimetre.
_PIXELS = 96 / 25.4


def sketch_svg(sketch: Sketch, title: str) -> str:
    """The sketch on white paper, as large as it is on paper; y runs down in SVG."""
    width, height = sketch.size_mm
    parts = [f'<rect width="{width:.6g}" height="{height:.6g}" fill="#ffffff"/>']
    for mark in sketch.marks:
        if isinstance(mark, Area):
            parts.append(_area(mark, height))
        elif isinstance(mark, Lines):
            parts.append(_lines(mark, height))
        elif isinstance(mark, Words):
            parts.append(_words(mark, height))
        else:
            parts.append(_image(mark, height))
    return (
        f'<svg viewBox="0 0 {width:.6g} {height:.6g}" width="{width * _PIXELS:.6g}" role="img" '
        f'aria-label="{escape(plain_title(title))}">{"".join(parts)}</svg>'
    )


def _area(area: Area, height: float) -> str:
    path = "".join(
        "M" + "L".join(f"{x:g},{y:g}" for x, y in _down(ring, height)) + "Z" for ring in area.rings
    )
    edge = f' stroke="{area.edge}" stroke-width="{area.edge_mm:g}"' if area.edge else ""
    fill = area.fill or "none"
    return f'<path fill="{fill}" fill-rule="evenodd" stroke-linejoin="round"{edge} d="{path}"/>'


def _lines(lines: Lines, height: float) -> str:
    rows = _down(lines.segments.reshape(-1, 2), height)
    path = "".join(
        f"M{x:g},{y:g}L{p:g},{q:g}" for (x, y), (p, q) in zip(rows[::2], rows[1::2], strict=True)
    )
    dashes = " ".join(f"{length:.3g}" for length in lines.dashes)
    dashed = f' stroke-dasharray="{dashes}"' if dashes else ""
    return (
        f'<path fill="none" stroke="{lines.colour}" stroke-width="{lines.width_mm:g}"{dashed} '
        f'd="{path}"/>'
    )


def _words(words: Words, height: float) -> str:
    x, y = words.at[0], height - words.at[1]
    text = plain_title(words.text)
    backing = ""
    if words.backing is not None:
        wide, high = len(text) * _LETTER * words.size_mm, _LINE * words.size_mm * 0.8
        left = x - wide / 2 if words.across == "middle" else x
        backing = (
            f'<rect x="{left:.4g}" y="{y - high / 2:.4g}" width="{wide:.4g}" '
            f'height="{high:.4g}" rx="{high / 5:.3g}" fill="{words.backing}"/>'
        )
    weight = ' font-weight="bold"' if words.bold else ""
    return (
        f'{backing}<text x="{x:.5g}" y="{y + _CAPITALS * words.size_mm / 2:.5g}" '
        f'font-family="DejaVu Sans, Verdana, sans-serif" font-size="{words.size_mm:.4g}"{weight} '
        f'text-anchor="{words.across}" fill="{words.colour}">{escape(text)}</text>'
    )


def _image(image: Image, height: float) -> str:
    from PIL import Image as Pictures

    stream = io.BytesIO()
    picture = Pictures.fromarray(image.pixels)
    picture.quantize(_PICTURE_COLOURS, dither=Pictures.Dither.NONE).save(stream, format="png")
    data = base64.b64encode(stream.getvalue()).decode()
    (x, y), (wide, high) = image.corner, image.size_mm
    return (
        f'<image x="{x:.5g}" y="{height - y - high:.5g}" width="{wide:.5g}" height="{high:.5g}" '
        f'preserveAspectRatio="none" href="data:image/png;base64,{data}"/>'
    )


def _down(points: np.ndarray, height: float) -> list[list[float]]:
    """Points with y downwards, to hundredths of a mm."""
    out: list[list[float]] = (points * [1.0, -1.0] + [0.0, height]).round(2).tolist()
    return out
