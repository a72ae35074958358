"""Thumbnails: small pictures of folded forms, and all of a sweep on one sheet."""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence

import numpy as np

from fab.viewing.camera import fitted
from fab.viewing.painting import painted
from fab.viewing.scene import Scene
from fab.viewing.shapes import sheet_shapes, sheet_triangles
from fab.viewing.view_choice import best_view

__all__ = ["contact_sheet_bytes", "thumbnail_bytes"]

_WIDTH, _HEIGHT, _MARGIN = 240, 180, 6
_COLUMNS, _LINE, _LINES = 8, 14, 2
# More pictures make a contact sheet that nobody can look at.
_MOST = 400
_COLOURS = 64


def thumbnail_bytes(scene: Scene) -> bytes:
    """A PNG of 240 x 180 pixels of the last state of a scene, from where most of it shows."""
    from PIL import Image

    coords = scene.states_coords[-1]
    triangles = sheet_triangles(scene.pattern)
    shapes = sheet_shapes(coords, triangles)
    axes = best_view([shapes.corners], triangles.faces, upright=scene.upright)
    camera = fitted(axes, coords, _WIDTH, _HEIGHT, _MARGIN)
    pixels = (255 * painted(camera, [shapes])).round().astype(np.uint8)
    image = Image.fromarray(pixels).quantize(_COLOURS)
    stream = io.BytesIO()
    image.save(stream, "PNG", optimize=True)
    return stream.getvalue()


def contact_sheet_bytes(pictures: Sequence[tuple[str, bytes]]) -> bytes:
    """A PNG of up to 400 thumbnails in rows of eight, each over its caption, of up to two lines."""
    from PIL import Image, ImageDraw, ImageFont

    shown = pictures[:_MOST]
    columns = min(_COLUMNS, len(shown))
    rows = -(-len(shown) // columns)
    pen, font = ImageDraw.Draw(Image.new("RGB", (1, 1))), ImageFont.load_default(11)
    texts = [
        _wrapped(caption, lambda text: pen.textlength(text, font) <= _WIDTH - 8)
        for caption, _ in shown
    ]
    high = _HEIGHT + 2 + _LINE * max(map(len, texts))
    whole = Image.new("RGB", (columns * _WIDTH, rows * high), "white")
    pen = ImageDraw.Draw(whole)
    for number, ((_, data), lines) in enumerate(zip(shown, texts, strict=True)):
        row, column = divmod(number, columns)
        left, top = column * _WIDTH, row * high
        whole.paste(Image.open(io.BytesIO(data)).convert("RGB"), (left, top))
        for place, line in enumerate(lines):
            pen.text((left + 4, top + _HEIGHT + place * _LINE), line, fill="black", font=font)
    stream = io.BytesIO()
    whole.save(stream, "PNG", optimize=True)
    return stream.getvalue()


def _wrapped(text: str, fits: Callable[[str], bool]) -> list[str]:
    """Up to two lines of a text, broken between words; what does not fit is left out.

    >>> _wrapped("0: rows 4, columns 12, fold 30", lambda text: len(text) <= 12)
    ['0: rows 4,', 'columns 12,']
    """
    lines = [""]
    for word in text.split():
        longer = f"{lines[-1]} {word}".strip()
        if fits(longer):
            lines[-1] = longer
        elif len(lines) < _LINES and lines[-1]:
            lines.append(word)
        else:
            break
    while not fits(lines[-1]):
        lines[-1] = lines[-1][:-1]
    return lines
