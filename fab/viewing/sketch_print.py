"""Sketches drawn on a page of paper, by reportlab."""

from __future__ import annotations

from typing import Any

import numpy as np

from fab.viewing.print_fonts import BOLD, PLAIN, printable, text_width_mm
from fab.viewing.sketch import Area, Image, Lines, Sketch, Words
from solver.vectors import FloatArray

__all__ = ["draw_sketch"]

# Height of capitals over the size of the font, and of what is behind a line of text.
_CAPITALS, _BACKING = 0.729, 0.95
_AROUND = 0.14
# Decimals of coordinates in points: a hundredth is finer than any printer.
_DECIMALS = 2


def draw_sketch(canvas: Any, sketch: Sketch, left: float, low: float) -> None:
    """Draw a sketch with its lower left corner at a place of the page, in points."""
    from reportlab.lib.units import mm

    canvas.saveState()
    canvas.setLineJoin(1)
    for mark in sketch.marks:
        if isinstance(mark, Area):
            _area(canvas, mark, left, low, mm)
        elif isinstance(mark, Lines):
            _lines(canvas, mark, left, low, mm)
        elif isinstance(mark, Words):
            _words(canvas, mark, left, low, mm)
        else:
            _image(canvas, mark, left, low, mm)
    canvas.restoreState()


def _placed(points: FloatArray, left: float, low: float, mm: float) -> list[list[float]]:
    out: list[list[float]] = np.round(points * mm + [left, low], _DECIMALS).tolist()
    return out


def _area(canvas: Any, area: Area, left: float, low: float, mm: float) -> None:
    path = canvas.beginPath()
    for ring in area.rings:
        points = _placed(ring, left, low, mm)
        path.moveTo(*points[0])
        for point in points[1:]:
            path.lineTo(*point)
        path.close()
    if area.fill is not None:
        canvas.setFillColor(area.fill)
    if area.edge is not None:
        canvas.setStrokeColor(area.edge)
        canvas.setLineWidth(area.edge_mm * mm)
        canvas.setDash()
    canvas.drawPath(
        path, stroke=int(area.edge is not None), fill=int(area.fill is not None), fillMode=0
    )


def _lines(canvas: Any, lines: Lines, left: float, low: float, mm: float) -> None:
    if not len(lines.segments):
        return
    canvas.setStrokeColor(lines.colour)
    canvas.setLineWidth(lines.width_mm * mm)
    canvas.setDash([length * mm for length in lines.dashes])
    canvas.setLineCap(0 if lines.dashes else 1)
    ends = np.round(lines.segments.reshape(-1, 4) * mm + [left, low] * 2, _DECIMALS)
    canvas.lines(ends.tolist())


def _words(canvas: Any, words: Words, left: float, low: float, mm: float) -> None:
    text, font = printable(words.text), BOLD if words.bold else PLAIN
    width = text_width_mm(text, words.size_mm, font)
    x = words.at[0] - (width / 2 if words.across == "middle" else 0.0)
    y = words.at[1] - _CAPITALS * words.size_mm / 2
    if words.backing is not None:
        around, high = _AROUND * words.size_mm, _BACKING * words.size_mm
        canvas.setFillColor(words.backing)
        canvas.roundRect(
            left + (x - around) * mm,
            low + (words.at[1] - high / 2) * mm,
            (width + 2 * around) * mm,
            high * mm,
            around * mm,
            stroke=0,
            fill=1,
        )
    canvas.setFillColor(words.colour)
    canvas.setFont(font, words.size_mm * mm)
    canvas.drawString(left + x * mm, low + y * mm, text)


def _image(canvas: Any, image: Image, left: float, low: float, mm: float) -> None:
    from PIL import Image as Pictures
    from reportlab.lib.utils import ImageReader

    (x, y), (width, height) = image.corner, image.size_mm
    picture = ImageReader(Pictures.fromarray(image.pixels))
    canvas.drawImage(picture, left + x * mm, low + y * mm, width * mm, height * mm)
