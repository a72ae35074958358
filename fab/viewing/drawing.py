"""Drawings of forms and patterns in boxes of a picture, each with its size and a scale bar."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from fab.pattern.crease_pattern import CreasePattern
from fab.viewing.camera import Camera, fitted
from fab.viewing.canvas import BAR_SHARE, Box, Canvas, line_width
from fab.viewing.painting import Shapes, painted
from fab.viewing.scales import Scale
from solver.vectors import FloatArray

__all__ = [
    "CREASE_INK",
    "FlatPlace",
    "divided",
    "draw_form",
    "draw_pattern",
    "drawing_box",
    "size_text",
]

# Colours of creases by their letter, in the order in which they are drawn.
CREASE_INK = {
    "F": "#b0b0b0",
    "J": "#20a0a8",
    "U": "#d030c0",
    "M": "#d62020",
    "V": "#2050d6",
    "C": "#20a040",
    "B": "#202020",
}
# Pixels around a drawing, and above and below it: its title; its scale bar and size.
_MARGIN, _TITLE, _CAPTION, _COLOURS = 24, 40, 30, 34
# Shares of a picture that its folded forms may have.
_SHARES = (0.5, 0.45, 0.55, 0.4, 0.6)
# Sides of a box that are smaller than this share of its longest one are rounding.
_FLAT = 1e-4


@dataclass(frozen=True)
class FlatPlace:
    """Where a flat sheet is drawn in a picture.

    Attributes
    ----------
    middle : shape (2,), mm, of the sheet; centre : shape (2,), the pixel where that is.
    pixels_per_mm : its scale.
    """

    middle: FloatArray
    centre: FloatArray
    pixels_per_mm: float

    def pixels(self, coords: FloatArray) -> FloatArray:
        """Pixels from the left and from the top of points (..., 2), mm."""
        scale = self.pixels_per_mm
        return np.asarray((coords - self.middle) * [scale, -scale] + self.centre)


def drawing_box(box: Box, *, coloured: bool = False) -> Box:
    """The part of a box that a drawing may fill, between its title and its caption.

    coloured : whether there is a scale of colours below it.
    """
    inner = box.without(_TITLE, _MARGIN + _CAPTION + coloured * _COLOURS)
    return Box(inner.left + _MARGIN, inner.top, inner.width - 2 * _MARGIN, inner.height)


def draw_form(
    canvas: Canvas,
    box: Box,
    shapes: Sequence[Shapes],
    title: str,
    size: str,
    *,
    axes: FloatArray | None = None,
    camera: Camera | None = None,
    scale: Scale | None = None,
) -> None:
    """Draw a form as large as fits into a box, with a title, its size and a scale bar.

    axes : of a camera that shows all of it; or the camera itself. scale : of its colours.
    """
    inner = drawing_box(box, coloured=scale is not None)
    if camera is None:
        assert axes is not None  # one of the two is given
        points = np.concatenate([each.corners.reshape(-1, 3) for each in shapes])
        camera = fitted(axes, points, inner.width, inner.height, 1)
    canvas.paste(painted(camera, shapes), inner)
    _write(canvas, box, title, size, camera.pixels_per_mm, scale)


def draw_pattern(
    canvas: Canvas,
    box: Box,
    pattern: CreasePattern,
    title: str,
    size: str,
    ink: Mapping[str, str] = CREASE_INK,
) -> FlatPlace:
    """Draw the crease pattern as large as fits into a box, with a title, its size and a scale bar.

    ink : colours of letters, in the order in which they are drawn. Returns where it is drawn.
    """
    inner = drawing_box(box)
    coords = pattern.vertices_coords
    low, high = coords.min(axis=0), coords.max(axis=0)
    span = np.maximum(high - low, 1e-9 * (float((high - low).max()) or 1.0))
    scale = float(min((inner.width - 4) / span[0], (inner.height - 4) / span[1]))
    centre = np.array([inner.left + inner.width / 2, inner.top + inner.height / 2])
    place = FlatPlace((low + high) / 2, centre, scale)
    at = place.pixels(coords)
    count = len(pattern.edges_vertices)
    # lines are as wide as leaves room between them
    room = np.sqrt((span * scale).prod() / count)
    width = float(np.clip(room / 16, 0.25, 1.3))
    for letter, colour in ink.items():
        chosen = pattern.edges_assignment == letter
        if chosen.any():
            canvas.lines(at[pattern.edges_vertices[chosen]], colour, width)
    _write(canvas, box, title, size, scale, None)
    return place


def divided(
    whole: Box,
    forms: int,
    seen: FloatArray,
    flat: FloatArray,
    shares: Sequence[float] = _SHARES,
) -> tuple[list[Box], Box]:
    """Boxes for the forms and for the pattern, beside or above each other: what is larger.

    seen : shape (n, 2), mm, the form as it is seen; flat : shape (n, 2). shares : of the whole that
    the forms may have.
    """
    best: tuple[list[Box], Box] | None = None
    most = -1.0
    for stacked, share in product((False, True), shares):
        if stacked:
            cut = round(whole.height * share)
            first = Box(whole.left, whole.top, whole.width, cut)
            second = whole.without(cut)
            rows = [first.across(forms)]
        else:
            cut = round(whole.width * share)
            first = Box(whole.left, whole.top, cut, whole.height)
            second = Box(whole.left + cut, whole.top, whole.width - cut, whole.height)
            rows = [first.across(forms), first.down(forms)]
        for boxes in rows:
            area = forms * _pixels(boxes[-1], seen) * _pixels(second, flat)
            if area > most * 1.02:
                best, most = (boxes, second), area
    assert best is not None  # areas are positive
    return best


def _pixels(box: Box, points: FloatArray) -> float:
    """Pixels of the rectangle around points, as large as fits into the drawing in a box."""
    inner = drawing_box(box, coloured=True)
    sides = np.ptp(points, axis=0)
    width, height = np.maximum(sides / (float(sides.max()) or 1.0), 1e-9)
    scale = max(0.0, min(inner.width / width, inner.height / height))
    return float(scale**2 * width * height)


def size_text(what: str, coords: FloatArray) -> str:
    """Such as "flat 200 x 142 mm": the sides of the box around points, (n, 2) or (n, 3), mm.

    >>> size_text("folded", np.array([[0.0, 0, 0], [120.04, 80, 12.345]]))
    'folded 120 x 80 x 12.3 mm'
    """
    finite = coords[np.isfinite(coords).all(axis=1)]
    sides = np.ptp(finite, axis=0) if len(finite) else np.zeros(coords.shape[1])
    sides[sides < _FLAT * sides.max(initial=0.0)] = 0.0
    written = [f"{side:.3g}" if side < 999.5 else f"{side:.0f}" for side in sides.tolist()]
    return f"{what} {' x '.join(written)} mm"


def _write(
    canvas: Canvas, box: Box, title: str, size: str, pixels_per_mm: float, scale: Scale | None
) -> None:
    middle, room = box.left + box.width / 2, box.width - 2 * _MARGIN
    canvas.text(title, middle, box.top + _TITLE / 2, size=12, across="center", room=room)
    foot = Box(box.left + _MARGIN, box.top, room, box.height - _MARGIN // 2)
    canvas.scale_bar(foot, pixels_per_mm)
    right = foot.left + foot.width
    bar = BAR_SHARE * room + line_width("  500 mm  ", 10)
    if scale is None and bar + line_width(size, 10) <= room:
        canvas.text(size, right, foot.top + foot.height - 6, size=10, across="right")
    else:
        canvas.text(size, foot.left, foot.top + foot.height - 26, size=10)
    if scale is not None:
        canvas.colour_bar(foot, scale)
