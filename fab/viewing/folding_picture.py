"""Pictures of a sheet that folds: its states side by side, and one after another."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from fab.progress import Steps, no_steps
from fab.viewing.camera import Camera, fitted
from fab.viewing.canvas import Box, Canvas
from fab.viewing.drawing import draw_form, drawing_box, size_text
from fab.viewing.movie_files import gif_bytes, there_and_back
from fab.viewing.painting import Shapes
from fab.viewing.scene import Scene
from fab.viewing.shapes import Triangles, sheet_shapes, sheet_triangles, valued_shapes
from fab.viewing.view_choice import best_view
from solver.vectors import FloatArray

__all__ = ["folding_gif_bytes", "folding_images", "states_png_bytes"]

_CELL_WIDTH, _CELL_HEIGHT, _TITLE = 640, 540, 60
_MOST_STATES, _COLUMNS = 6, 3
_MOVIE, _MOST_FRAMES = 800, 60


def states_png_bytes(scene: Scene) -> bytes:
    """A PNG file of up to six states, evenly over all, each as large as fits, with its size.

    Faces have the colours of the scene's values, strain for one, on a scale that is the same for
    all sheets; all states are seen from where most of the last one shows.
    """
    states = _sampled(scene.state_count, _MOST_STATES)
    columns = min(_COLUMNS, len(states))
    rows = -(-len(states) // columns)
    width, height = max(2, columns) * _CELL_WIDTH, rows * _CELL_HEIGHT + _TITLE
    canvas = Canvas(width, height)
    canvas.text(scene.name, 40, _TITLE / 2, size=15, room=width / 2)
    triangles, axes = _view(scene)
    boxes = [
        box
        for row in Box(0, _TITLE, width, height - _TITLE).down(rows)
        for box in row.across(columns)
    ]
    if scene.values is not None:
        canvas.colour_bar(Box(0, 0, width - 40, _TITLE - 4), scene.values.scale)
    for state, box in zip(states, boxes, strict=False):
        shapes = [_shapes(scene, triangles, state)]
        draw_form(canvas, box, shapes, _title(scene, state), _size(scene, state), axes=axes)
    return canvas.png_bytes()


def folding_gif_bytes(scene: Scene, progress: Steps = no_steps) -> bytes:
    """An endless GIF of the states there and back, 800 x 800 pixels, all at one scale.

    It shows all states up to 60; of more, 60 evenly over all. progress : called with (states drawn,
    states in all).
    """
    images = folding_images(scene, progress)
    return gif_bytes(images, *there_and_back(len(images)))


def folding_images(scene: Scene, progress: Steps = no_steps) -> list[Any]:
    """Pillow images of the states, 800 x 800 pixels, as `folding_gif_bytes` shows them."""
    triangles, axes = _view(scene)
    states = _sampled(scene.state_count, _MOST_FRAMES)
    box = Box(0, 0, _MOVIE, _MOVIE)
    scale = None if scene.values is None else scene.values.scale
    camera = _camera(scene, axes, drawing_box(box, coloured=scale is not None))
    images = []
    for done, state in enumerate(states):
        progress(done, len(states))
        canvas = Canvas(_MOVIE, _MOVIE)
        shapes = [_shapes(scene, triangles, state)]
        title = f"{scene.name}: {_title(scene, state)}"
        draw_form(canvas, box, shapes, title, _size(scene, state), camera=camera, scale=scale)
        images.append(canvas.image())
    progress(len(states), len(states))
    return images


def _camera(scene: Scene, axes: FloatArray, box: Box) -> Camera:
    """The camera that shows all states of a scene."""
    return fitted(axes, scene.states_coords.reshape(-1, 3), box.width, box.height, 1)


def _view(scene: Scene) -> tuple[Triangles, FloatArray]:
    triangles = sheet_triangles(scene.pattern)
    last = scene.state_count - 1
    forms = [scene.states_coords[state][triangles.vertices] for state in {0, last // 2, last}]
    return triangles, best_view(forms, triangles.faces, upright=scene.upright)


def _size(scene: Scene, state: int) -> str:
    """The size of a state, that of the flat sheet as it lies."""
    if scene.shares[state] == 0:
        return size_text("flat", scene.pattern.vertices_coords)
    coords = scene.states_coords[state]
    if scene.lift_mm is not None and state == scene.state_count - 1:
        coords = coords - scene.lift_mm
    return size_text("", coords).strip()


def _shapes(scene: Scene, triangles: Triangles, state: int) -> Shapes:
    coords = scene.states_coords[state]
    if scene.values is None:
        shapes = sheet_shapes(coords, triangles)
    else:
        shapes = valued_shapes(coords, triangles, scene.values, state)
    return replace(shapes, layered=scene.lift_mm is not None and state == scene.state_count - 1)


def _sampled(count: int, most: int) -> list[int]:
    """Up to `most` states, the first and the last among them."""
    return sorted({round(float(place)) for place in np.linspace(0, count - 1, most)})


def _title(scene: Scene, state: int) -> str:
    """Such as "40 % of the fold, strain up to 0.02 %"."""
    share = f"{100 * scene.shares[state]:.3g} % of the fold"
    if scene.values is None:
        return share
    scale, largest = scene.values.scale, float(scene.values.in_state(state).max(initial=0.0))
    written = f"{largest:.2g}" if largest >= 1e-3 else "0"
    return f"{share}, {scale.name} up to {written} {scale.unit}"
