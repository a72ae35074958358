"""A sheet as it grows, strip by strip: folded beside flat."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from fab.errors import counted
from fab.viewing.figures.canvas import Drawing, Movie, movie, new_figure, plain
from fab.viewing.figures.sheets import ShownSheet, draw_flat, draw_folded

__all__ = ["growth_figure", "growth_movie"]

_MOST_FRAMES = 60


def growth_figure(sheets: Sequence[ShownSheet], stages: int = 3) -> Drawing:
    """Stages of growth of some sheets, a row of folded forms and a row of flat ones for each."""
    rows = 2 * len(sheets)
    figure = new_figure(340 * stages, 300 * rows + 40)
    top = 1 - 40 / (300 * rows + 40)
    for number, sheet in enumerate(sheets):
        last = int(sheet.steps.max())
        for column, step in enumerate(_sampled(last // stages, last, stages)):
            shown = sheet.steps <= step
            for row, draw in enumerate((draw_folded, draw_flat)):
                bottom = top * (1 - (2 * number + row + 1) / rows)
                place = (column / stages + 0.01, bottom + 0.01, 0.96 / stages, 0.84 * top / rows)
                title = f"{sheet.name}: {counted(int(shown.sum()), 'face')}" if row == 0 else ""
                draw(plain(figure, place, title), sheet, shown)
    return Drawing(figure)


def growth_movie(sheet: ShownSheet) -> Movie:
    """The sheet after each strip, up to 60 of them, folded on the left and flat on the right."""
    strips = int(sheet.steps.max()) + 1

    def frame(step: int) -> Drawing:
        figure = new_figure(960, 520)
        shown = sheet.steps <= step
        draw_folded(plain(figure, (0.01, 0.02, 0.48, 0.86)), sheet, shown)
        draw_flat(plain(figure, (0.51, 0.02, 0.48, 0.86)), sheet, shown)
        words = f"{sheet.name}: step {step + 1} of {strips}, {counted(int(shown.sum()), 'face')}"
        figure.text(0.5, 0.93, words, ha="center", fontsize=12)
        return Drawing(figure)

    steps = _sampled(0, strips - 1, _MOST_FRAMES)
    return movie([partial(frame, step) for step in steps], last_ms=2000)


def _sampled(first: int, last: int, most: int) -> list[int]:
    """Up to `most` whole numbers from `first` to `last`, evenly, both among them."""
    chosen = np.unique(np.linspace(first, last, most).round()).astype(np.int64)
    return [int(number) for number in chosen]
