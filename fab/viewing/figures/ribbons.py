"""Ribbons along walks in space: folded, flat, and their angles and lengths within bounds (S17)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fab.viewing.figures.canvas import Drawing, new_figure, plain
from fab.viewing.figures.sheets import ShownSheet, draw_flat, draw_folded
from solver.growth_order import GrownStrip

__all__ = ["ribbons_figure"]

# Points of longer ribbons are drawn without lines between them.
_MOST_LINED = 60


def ribbons_figure(ribbons: Sequence[tuple[ShownSheet, GrownStrip]]) -> Drawing:
    """A row for each ribbon: folded, flat, beta < k < 2 pi - beta, and lengths below their bounds.

    Each is a sheet of one strip on a curve, and that strip.
    """
    rows = len(ribbons)
    figure = new_figure(1500, 330 * rows + 50)
    top = 1 - 50 / (330 * rows + 50)
    for number, (sheet, strip) in enumerate(ribbons):
        tall = top / rows
        bottom = top - (number + 1) * tall
        draw_folded(plain(figure, (0.0, bottom, 0.22, 0.86 * tall), sheet.name), sheet)
        draw_flat(plain(figure, (0.23, bottom, 0.22, 0.86 * tall)), sheet)
        angles = figure.add_axes((0.5, bottom + 0.17 * tall, 0.22, 0.68 * tall))
        beta, k = np.degrees(strip.front.beta), np.degrees(strip.front.k)
        place = np.arange(1, len(k) + 1)
        lined = "-" if len(k) <= _MOST_LINED else ""
        size = 3 if lined else float(np.clip(120 / len(k), 0.3, 1.5))
        for values, colour, label in (
            (beta, "#0b6e99", r"$\beta$"),
            (360 - beta, "#d1642a", r"$2\pi-\beta$"),
            (k, "#202020", "k"),
        ):
            angles.plot(place, values, f"o{lined}", color=colour, ms=size, lw=0.8, label=label)
        angles.set_ylim(0, 360)
        angles.set_yticks([0, 90, 180, 270, 360])
        angles.set_ylabel("degrees", fontsize=9)
        lengths = figure.add_axes((0.76, bottom + 0.17 * tall, 0.22, 0.68 * tall))
        finite = np.where(np.isfinite(strip.rays.length_bounds), strip.rays.length_bounds, np.nan)
        vertex = np.arange(len(finite))
        lengths.semilogy(vertex, finite, "v", color="#d1642a", ms=size, label="bound")
        lengths.semilogy(vertex, strip.lengths, "o", color="#0b6e99", ms=size, label="length")
        for axes in (angles, lengths):
            axes.tick_params(labelsize=8)
            axes.set_xlabel("vertex of the walk", fontsize=9)
            axes.legend(loc="upper right", fontsize=8, markerscale=3 / size)
    words = "Random walks that lie flat on a circle: k within its bounds, lengths below theirs"
    figure.text(0.5, 1 - 25 / (330 * rows + 50), words, ha="center", va="center", fontsize=12)
    return Drawing(figure)
