"""The picture of a sheet: its folded form, how near it is to its surface, its crease pattern."""

from __future__ import annotations

from fab.errors import counted
from fab.viewing.canvas import Box, Canvas
from fab.viewing.drawing import divided, draw_form, draw_pattern, size_text
from fab.viewing.scene import Scene
from fab.viewing.shapes import sheet_shapes, sheet_triangles, surface_shapes, valued_shapes
from fab.viewing.view_choice import best_view

__all__ = ["sheet_png_bytes"]

_WIDTH, _HEIGHT, _TITLE = 1600, 900, 40


def sheet_png_bytes(scene: Scene) -> bytes:
    """A PNG of 1600 x 900 pixels: the folded form, where it is known, beside the crease pattern.

    The upper side of the sheet is sand, the lower blue; mountains are red, valleys blue. Where the
    sheet follows a surface, it is shown over it too, in the colours of its distance. The form is
    seen from where most of it shows; the pattern is below it where both are larger that way.
    """
    pattern = scene.pattern
    canvas = Canvas(_WIDTH, _HEIGHT)
    whole = Box(0, 0, _WIDTH, _HEIGHT).without(_TITLE)
    canvas.text(scene.name, _WIDTH / 2, _TITLE / 2 + 4, size=15, across="center", room=_WIDTH - 40)
    flat = whole
    folded = scene.folded_coords
    if folded is not None:
        triangles = sheet_triangles(pattern)
        shapes = [[sheet_shapes(folded, triangles)]]
        axes = best_view([shapes[0][0].corners], triangles.faces, upright=scene.upright)
        scale = None
        if scene.surface is not None and scene.values is not None:
            scale = scene.values.scale
            shapes.append(
                [
                    valued_shapes(folded, triangles, scene.values, scene.state_count - 1),
                    surface_shapes(scene.surface),
                ]
            )
        seen = folded @ axes[:2].T
        forms, flat = divided(whole, len(shapes), seen, pattern.vertices_coords)
        own = folded if pattern.folded_coords is None else pattern.folded_coords
        size = size_text("folded", own)
        draw_form(canvas, forms[0], shapes[0], "folded form", size, axes=axes)
        for box, drawn in zip(forms[1:], shapes[1:], strict=True):
            draw_form(canvas, box, drawn, "over its surface", "", axes=axes, scale=scale)
    counts = pattern.counts()
    title = (
        f"crease pattern: {counted(pattern.face_count, 'face')}, "
        f"{counted(counts['M'], 'mountain')} (red), {counted(counts['V'], 'valley')} (blue)"
    )
    draw_pattern(canvas, flat, pattern, title, size_text("flat", pattern.vertices_coords))
    return canvas.png_bytes()
