"""Many sheets at once: each folded over its crease pattern."""

from __future__ import annotations

from collections.abc import Sequence

from fab.viewing.figures.canvas import Drawing, new_figure, plain
from fab.viewing.figures.sheets import ShownSheet, draw_flat, draw_folded

__all__ = ["gallery_figure"]

_WIDTH, _HEIGHT, _HEAD = 340, 480, 46


def gallery_figure(sheets: Sequence[ShownSheet], title: str, columns: int = 4) -> Drawing:
    """Sheets in rows, each with its name, its folded form and its crease pattern below."""
    columns = max(1, min(columns, len(sheets)))
    rows = -(-len(sheets) // columns)
    height = rows * _HEIGHT + _HEAD
    figure = new_figure(columns * _WIDTH, height)
    for number, sheet in enumerate(sheets):
        row, column = divmod(number, columns)
        bottom = (rows - row - 1) * _HEIGHT / height
        left, wide = (column + 0.03) / columns, 0.94 / columns
        tall = _HEIGHT / height
        name = f"{sheet.name}: {sheet.pattern.face_count} quads"
        folded = plain(figure, (left, bottom + 0.46 * tall, wide, 0.46 * tall), name)
        draw_folded(folded, sheet, finer=2)
        draw_flat(plain(figure, (left, bottom + 0.03 * tall, wide, 0.4 * tall)), sheet)
    figure.text(0.5, 1 - 0.5 * _HEAD / height, title, ha="center", va="center", fontsize=13)
    return Drawing(figure)
