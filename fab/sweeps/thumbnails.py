"""Thumbnails: small pictures of folded forms, and all of a sweep on one sheet."""

from __future__ import annotations

import io
from collections.abc import Sequence

import numpy as np

from fab.viewing.camera import fitted
from fab.viewing.painting import painted
from fab.viewing.scene import Scene
from fab.viewing.shapes import sheet_shapes, sheet_triangles
from fab.viewing.view_choice import best_view

__all__ = ["contact_sheet_bytes", "thumbnail_bytes"]

_WIDTH, _HEIGHT, _MARGIN = 240, 180, 6
_COLUMNS, _TEXT = 8, 16
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
    """A PNG of up to 400 thumbnails in rows of eight, each over its caption."""
    from PIL import Image, ImageDraw, ImageFont

    shown = pictures[:_MOST]
    columns = min(_COLUMNS, len(shown))
    rows = -(-len(shown) // columns)
    whole = Image.new("RGB", (columns * _WIDTH, rows * (_HEIGHT + _TEXT)), "white")
    pen, font = ImageDraw.Draw(whole), ImageFont.load_default(11)
    for number, (caption, data) in enumerate(shown):
        row, column = divmod(number, columns)
        left, top = column * _WIDTH, row * (_HEIGHT + _TEXT)
        whole.paste(Image.open(io.BytesIO(data)).convert("RGB"), (left, top))
        while caption and pen.textlength(caption, font) > _WIDTH - 8:
            caption = caption[:-1]
        pen.text((left + 4, top + _HEIGHT), caption, fill="black", font=font)
    stream = io.BytesIO()
    whole.save(stream, "PNG", optimize=True)
    return stream.getvalue()
