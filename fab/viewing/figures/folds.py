"""A sheet on its way from flat to folded."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from fab.viewing.figures.canvas import Drawing, Movie, new_figure, plain
from fab.viewing.figures.sheets import paint
from fab.viewing.movie_files import there_and_back
from fab.viewing.scene import Scene
from fab.viewing.shapes import sheet_triangles
from fab.viewing.view_choice import best_view
from solver.vectors import FloatArray

__all__ = ["folding_movie", "states_figure"]


def states_figure(scene: Scene, most: int = 6) -> Drawing:
    """Up to `most` states of a fold, evenly, all at one scale."""
    chosen = np.unique(np.linspace(0, scene.state_count - 1, most).round().astype(int)).tolist()
    columns = min(3, len(chosen))
    rows = -(-len(chosen) // columns)
    figure = new_figure(460 * columns, 380 * rows + 40)
    view = _view_of(scene)
    top = 1 - 40 / (380 * rows + 40)
    for number, state in enumerate(chosen):
        row, column = divmod(number, columns)
        place = (column / columns, top * (1 - (row + 1) / rows), 1 / columns, 0.9 * top / rows)
        axes = plain(figure, place, f"{scene.shares[state]:.0%} folded")
        _draw_state(axes, scene, state, view)
    figure.text(0.5, 1 - 0.4 * (1 - top), scene.name, ha="center", va="center", fontsize=12)
    return Drawing(figure)


def folding_movie(scene: Scene) -> Movie:
    """The fold from flat to its end, and back."""
    view = _view_of(scene)

    def frame(state: int) -> Drawing:
        figure = new_figure(760, 600)
        _draw_state(plain(figure, (0.0, 0.0, 1.0, 0.92)), scene, state, view)
        words = f"{scene.name}: {scene.shares[state]:.0%} folded"
        figure.text(0.5, 0.95, words, ha="center", fontsize=12)
        return Drawing(figure)

    order, times = there_and_back(scene.state_count)
    return Movie([partial(frame, at) for at in range(scene.state_count)], order, times)


def _view_of(scene: Scene) -> FloatArray:
    """Axes of the camera from which most of the first, middle and last states shows."""
    triangles = sheet_triangles(scene.pattern)
    chosen = sorted({0, scene.state_count // 2, scene.state_count - 1})
    corners = [scene.states_coords[state][triangles.vertices] for state in chosen]
    return best_view(corners, triangles.faces, upright=scene.upright)


def _draw_state(axes: Any, scene: Scene, state: int, view: FloatArray) -> None:
    extent = scene.states_coords.reshape(-1, 3)
    paint(axes, view, scene.states_coords[state], sheet_triangles(scene.pattern), extent)
