"""A picture of pixels, with text, lines and scale bars at exact places of it."""

from __future__ import annotations

import io
import textwrap
import warnings
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Self

import numpy as np

from fab.outputs import plain_title
from fab.viewing.scales import Scale, ScaleKind
from solver.vectors import FloatArray

__all__ = ["BAR_SHARE", "Box", "Canvas", "bar_length_mm", "colour_map", "line_width"]

_DPI = 100
_INK = 0.15
_BAR_PIXELS, _TICK_PIXELS = 3, 9
# A scale bar is no longer than this share of the width of what it belongs to.
BAR_SHARE = 0.3
_STRIP_PIXELS = 14
# Width of a letter over the size of its font, about.
_LETTER = 0.62
_MAPS = {False: "YlOrRd", True: "coolwarm"}
_COLOURS = 256


@dataclass(frozen=True)
class Box:
    """A rectangle of a picture: pixels from the left and from the top, and its sides."""

    left: int
    top: int
    width: int
    height: int

    def without(self, top: int = 0, bottom: int = 0) -> Box:
        """The box without a strip above and one below."""
        return Box(self.left, self.top + top, self.width, self.height - top - bottom)

    def across(self, count: int) -> list[Box]:
        """It in `count` boxes from left to right."""
        ends = [self.left + self.width * k // count for k in range(count + 1)]
        return [Box(a, self.top, b - a, self.height) for a, b in pairwise(ends)]

    def down(self, count: int) -> list[Box]:
        """It in `count` boxes from top to bottom."""
        ends = [self.top + self.height * k // count for k in range(count + 1)]
        return [Box(self.left, a, self.width, b - a) for a, b in pairwise(ends)]


class Canvas:
    """A white picture on which things are put one after another, and that becomes a PNG file."""

    def __init__(self, width: int, height: int) -> None:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        self.width, self.height = width, height
        self._pixels = np.ones((height, width, 3))
        self._figure: Any = Figure(figsize=(width / _DPI, height / _DPI), dpi=_DPI)
        FigureCanvasAgg(self._figure)

    def paste(self, image: FloatArray, box: Box) -> Self:
        """Put an image (height, width, 3), from 0 to 1, of the size of a box into it."""
        self._pixels[box.top : box.top + box.height, box.left : box.left + box.width] = image
        return self

    def text(
        self,
        text: str,
        left: float,
        top: float,
        *,
        size: float = 11.0,
        across: str = "left",
        colour: str = "black",
        weight: str = "normal",
        room: float | None = None,
    ) -> Self:
        """Write a line, its middle `top` pixels from the top.

        across : "left", "center" or "right": what of the line is at `left`. room : pixels that it
        may be long, shortened where it is not.
        """
        text = plain_title(text)
        if room is not None:
            most = max(8, int(room / line_width("m", size)))
            if len(text) > most:
                text = textwrap.shorten(text, most, placeholder=" ...")
                text = text if len(text) > 4 else ""
        self._figure.text(
            left / self.width,
            1 - top / self.height,
            text,
            size=size,
            ha=across,
            va="center_baseline",
            color=colour,
            weight=weight,
            parse_math=False,
        )
        return self

    def lines(self, pixels: FloatArray, colour: str, width: float) -> Self:
        """Draw straight lines, shape (n, 2, 2), pixels from the left and from the top."""
        from matplotlib.collections import LineCollection

        at = pixels / [self.width, self.height]
        at[..., 1] = 1 - at[..., 1]
        self._figure.add_artist(
            LineCollection(
                list(at), colors=colour, linewidths=width, transform=self._figure.transFigure
            )
        )
        return self

    def scale_bar(self, box: Box, pixels_per_mm: float) -> Self:
        """A bar of a round length at the lower left of a box, its length beside it."""
        length = bar_length_mm(BAR_SHARE * box.width / pixels_per_mm)
        pixels = round(length * pixels_per_mm)
        low = box.top + box.height
        self._pixels[low - _BAR_PIXELS : low, box.left : box.left + pixels] = _INK
        for left in (box.left, box.left + pixels - _BAR_PIXELS):
            self._pixels[low - _TICK_PIXELS : low, left : left + _BAR_PIXELS] = _INK
        return self.text(f"{length:g} mm", box.left + pixels + 8, low - 6, size=10)

    def colour_bar(self, box: Box, scale: Scale) -> Self:
        """The colours of a scale at the lower right of a box, with its name, values and unit."""
        width = min(300, box.width // 2)
        left, low = box.left + box.width - width, box.top + box.height - 20
        colours = colour_map(scale)[np.arange(width) * _COLOURS // width]
        self._pixels[low - _STRIP_PIXELS : low, left : left + width] = colours
        for value in _ticks(scale):
            at = left + float(scale.shares(np.array([value]))[0]) * width
            self.text(f"{value:g}", at, low + 11, size=9, across="center")
        name = f"{scale.name}, {scale.unit}"
        return self.text(name, left + width / 2, low - _STRIP_PIXELS - 11, across="center", size=10)

    def image(self) -> Any:
        """The picture as an image of the Pillow library."""
        from PIL import Image

        self._drawn()
        return Image.fromarray(np.asarray(self._figure.canvas.buffer_rgba())[..., :3].copy())

    def png_bytes(self) -> bytes:
        """The picture as a PNG file; the same picture gives the same bytes."""
        stream = io.BytesIO()
        self._place_pixels()
        with warnings.catch_warnings():  # letters that the font has not are boxes
            warnings.filterwarnings("ignore", message="Glyph")
            self._figure.savefig(stream, format="png", metadata={"Software": "quadfold"})
        return stream.getvalue()

    def _drawn(self) -> None:
        self._place_pixels()
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", message="Glyph")
            self._figure.canvas.draw()

    def _place_pixels(self) -> None:
        image = np.round(self._pixels * 255).astype(np.uint8)
        self._figure.figimage(image, 0, 0, origin="upper", zorder=-1)


def line_width(text: str, size: float) -> float:
    """About how many pixels long a line is."""
    return len(text) * size * _LETTER * _DPI / 72


def bar_length_mm(most_mm: float) -> float:
    """The largest of 1, 2, 5, 10, 20, 50 ... mm, or of their tenths and so on, up to a length.

    >>> bar_length_mm(73.0), bar_length_mm(0.3), bar_length_mm(20.0)
    (50.0, 0.2, 20.0)
    """
    power = int(np.floor(np.log10(most_mm)))
    lengths = [float(f"{step}e{p}") for p in (power - 1, power) for step in (1, 2, 5)]
    return max(length for length in lengths if length <= most_mm * (1 + 1e-9))


def colour_map(scale: Scale) -> FloatArray:
    """Colours of a scale from its low to its high end, shape (256, 3), from 0 to 1."""
    from matplotlib import colormaps

    return np.asarray(colormaps[_MAPS[scale.signed]](np.arange(_COLOURS))[:, :3])


def _ticks(scale: Scale) -> list[float]:
    if scale.kind is ScaleKind.LOGARITHMIC:
        low, high = np.log10(scale.low), np.log10(scale.high)
        return [float(f"1e{k}") for k in range(int(np.ceil(low - 1e-9)), int(high + 1e-9) + 1)]
    return [scale.low, (scale.low + scale.high) / 2, scale.high]
