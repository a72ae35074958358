"""A sheet on its way from flat to folded."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from fab.viewing.figures.canvas import Drawing, Movie, new_figure, plain
from fab.viewing.figures.forms import camera, draw_sheet, framed
from fab.viewing.scene import Scene

__all__ = ["folding_movie", "states_figure"]

_VIEW = camera(35, -62)


def states_figure(scene: Scene, most: int = 6) -> Drawing:
    """Up to `most` states of a fold, evenly, all at one scale."""
    chosen = np.unique(np.linspace(0, scene.state_count - 1, most).round().astype(int)).tolist()
    columns = min(3, len(chosen))
    rows = -(-len(chosen) // columns)
    figure = new_figure(460 * columns, 380 * rows + 40)
    top = 1 - 40 / (380 * rows + 40)
    for number, state in enumerate(chosen):
        row, column = divmod(number, columns)
        place = (column / columns, top * (1 - (row + 1) / rows), 1 / columns, 0.9 * top / rows)
        _draw_state(plain(figure, place, f"{scene.shares[state]:.0%} folded"), scene, state)
    figure.text(0.5, 1 - 0.4 * (1 - top), scene.name, ha="center", va="center", fontsize=12)
    return Drawing(figure)


def folding_movie(scene: Scene) -> Movie:
    """The fold from flat to its end, and back."""

    def frame(state: int) -> Drawing:
        figure = new_figure(760, 600)
        _draw_state(plain(figure, (0.0, 0.0, 1.0, 0.92)), scene, state)
        words = f"{scene.name}: {scene.shares[state]:.0%} folded"
        figure.text(0.5, 0.95, words, ha="center", fontsize=12)
        return Drawing(figure)

    there = list(range(scene.state_count))
    return Movie([partial(frame, at) for at in [*there, *there[-2:0:-1]]], frame_ms=120)


def _draw_state(axes: Any, scene: Scene, state: int) -> None:
    pattern, coords = scene.pattern, scene.states_coords[state]
    draw_sheet(axes, _VIEW, coords, (pattern.faces_vertices, pattern.faces_offsets))
    framed(axes, _VIEW, scene.states_coords)
