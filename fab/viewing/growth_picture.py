"""Pictures of a sheet as it grows, strip by strip."""

from __future__ import annotations

from typing import Any

import numpy as np

from fab.progress import Steps, no_steps
from fab.viewing.camera import fitted
from fab.viewing.canvas import Box, Canvas
from fab.viewing.drawing import draw_form, drawing_box, size_text
from fab.viewing.scene import Scene
from fab.viewing.shapes import Triangles, sheet_shapes, sheet_triangles
from fab.viewing.view_choice import best_view
from solver.errors import InvalidValue
from solver.vectors import IntArray

__all__ = ["growth_images"]

_SIDE, _MOST_FRAMES = 800, 90


def growth_images(scene: Scene, faces_step: IntArray, progress: Steps = no_steps) -> list[Any]:
    """Pillow images of the last state of a scene, 800 x 800 pixels, with more faces in each.

    faces_step : shape (nf,), the step of growth that makes each face, from 0 without gaps
    (`solver.growth_order.faces_strip`). All steps are shown up to 90; of more, 90 evenly. progress
    : called with (images drawn, images in all).

    Raises `InvalidValue` for steps that are not one for each face.
    """
    if faces_step.shape != (scene.pattern.face_count,):
        bound = f"be ({scene.pattern.face_count},)"
        raise InvalidValue("faces_step.shape", faces_step.shape, bound, "Give a step to each face.")
    coords = scene.states_coords[-1]
    triangles = sheet_triangles(scene.pattern)
    axes = best_view([coords[triangles.vertices]], triangles.faces, upright=scene.upright)
    box = Box(0, 0, _SIDE, _SIDE)
    inner = drawing_box(box)
    camera = fitted(axes, coords, inner.width, inner.height, 1)
    steps = int(faces_step.max(initial=0)) + 1
    shown = sorted({round(float(step)) for step in np.linspace(0, steps - 1, _MOST_FRAMES)})
    images = []
    for done, step in enumerate(shown):
        progress(done, len(shown))
        kept = faces_step[triangles.faces] <= step
        part = Triangles(triangles.vertices[kept], triangles.faces[kept])
        grown = coords[np.unique(part.vertices)]
        canvas = Canvas(_SIDE, _SIDE)
        title = f"{scene.name}: strip {step + 1} of {steps}"
        shapes = [sheet_shapes(coords, part)]
        draw_form(canvas, box, shapes, title, size_text("", grown).strip(), camera=camera)
        images.append(canvas.image())
    progress(len(shown), len(shown))
    return images
