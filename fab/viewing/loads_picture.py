"""Picture of a sheet without load and under load."""

from __future__ import annotations

import numpy as np

from fab.pattern.crease_pattern import CreasePattern
from fab.viewing.canvas import Box, Canvas
from fab.viewing.drawing import draw_form, size_text
from fab.viewing.scales import Scale
from fab.viewing.scene import Values
from fab.viewing.shapes import sheet_triangles, valued_shapes
from fab.viewing.view_choice import best_view
from solver.vectors import FloatArray, norm

__all__ = ["loads_png_bytes"]

_WIDTH, _HEIGHT, _TITLE = 1600, 760, 60
# Smaller displacements have no scale of their own, mm.
_LEAST_MM = 1e-3


def loads_png_bytes(
    pattern: CreasePattern, unloaded: FloatArray, loaded: FloatArray, title: str
) -> bytes:
    """A PNG file of both states, side by side at one scale, coloured by how far vertices move.

    unloaded, loaded : shape (nv, 3), mm, z up.
    """
    moved = norm(loaded - unloaded)
    high = float(f"{max(float(moved.max(initial=0.0)), _LEAST_MM):.2g}")
    scale = Scale("displacement", "mm", 0.0, high)
    values = Values(np.stack([np.zeros_like(moved), moved]), scale, of_vertices=True)
    triangles = sheet_triangles(pattern)
    forms = [unloaded[triangles.vertices], loaded[triangles.vertices]]
    axes = best_view(forms, triangles.faces, upright=True)
    canvas = Canvas(_WIDTH, _HEIGHT)
    canvas.text(title, 40, _TITLE / 2, size=15, room=_WIDTH * 0.7)
    canvas.colour_bar(Box(0, 0, _WIDTH - 40, _TITLE - 4), scale)
    boxes = Box(0, _TITLE, _WIDTH, _HEIGHT - _TITLE).across(2)
    names = ("without load", f"under load, moved by up to {moved.max(initial=0.0):.3g} mm")
    for state, (coords, box, name) in enumerate(zip((unloaded, loaded), boxes, names, strict=True)):
        shapes = [valued_shapes(coords, triangles, values, state)]
        draw_form(canvas, box, shapes, name, size_text("", coords).strip(), axes=axes)
    return canvas.png_bytes()
