"""Landscapes of the flap angle: what it costs, and where it is forbidden (S13, S15)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from fab.viewing.figures.canvas import Drawing, new_figure, plain, shaded
from fab.viewing.figures.circles import draw_circle
from solver.arcs import united
from solver.flap_landscape import FlapLandscape
from solver.front import Front
from solver.vectors import FloatArray

__all__ = ["intervals_figure", "landscapes_figure"]


def landscapes_figure(
    landscapes: Sequence[tuple[str, FlapLandscape]], taken: Sequence[float] = ()
) -> Drawing:
    """Cost and C_con over the flap angle, a panel for each landscape with its name.

    taken : the flap angle that growth took in each, radians.
    """
    columns = 2 if len(landscapes) > 1 else 1
    rows = -(-len(landscapes) // columns)
    figure = new_figure(620 * columns, 270 * rows + 70)
    figure.subplots_adjust(0.07, 60 / (270 * rows + 70), 0.94, 0.9, wspace=0.36, hspace=0.45)
    for number, (name, landscape) in enumerate(landscapes):
        axes = figure.add_subplot(rows, columns, number + 1)
        x = np.degrees(landscape.flap_angles)
        axes.plot(x, landscape.cost, color="#0b6e99", lw=1.8)
        axes.set_ylabel("cost", color="#0b6e99", fontsize=9)
        axes.set_title(name, fontsize=10)
        axes.set_xlim(0, 360)
        axes.set_xticks(range(0, 361, 60))
        axes.tick_params(labelsize=8)
        broken = axes.twinx()
        broken.fill_between(x, landscape.constraint, step="mid", color="#d62020", alpha=0.2, lw=0)
        broken.set_ylim(0, 1.1 * max(1, int(landscape.constraint.max())))
        broken.set_ylabel("$C_{con}$", color="#d62020", fontsize=9)
        broken.tick_params(labelsize=8)
        shaded(axes, landscape.free, "#3a8a3a", 0.12)
        if np.isfinite(landscape.best):
            axes.plot(np.degrees(landscape.best), landscape.best_cost, "o", color="#202020", ms=6)
        if number < len(taken):
            axes.axvline(np.degrees(taken[number]), color="#202020", lw=1, ls=(0, (4, 2)))
        if number >= len(landscapes) - columns:
            axes.set_xlabel(r"flap angle $\alpha_1$, degrees", fontsize=9)
    words = (
        "Cost (blue) and broken constraints (red) over the flap angle; green: free; "
        "dot: least free cost; dashed: taken by growth"
    )
    figure.text(0.5, 0.965, words, ha="center", fontsize=10)
    return Drawing(figure)


def intervals_figure(front: Front, taken: float | None = None) -> Drawing:
    """Flap angles at which faces cross, vertex by vertex, their union, and what it leaves free.

    taken : the flap angle of the strip that was grown on the front, radians.
    """
    crossing, free = front.crossing_flap_angles(), front.free_flap_angles()
    figure = new_figure(1200, 560)
    axes = figure.add_axes((0.07, 0.1, 0.5, 0.78))
    count = len(crossing)
    for row, arcs in enumerate(crossing):
        _bar(axes, arcs, row, "#d62020", 0.5)
    union = united(crossing.reshape(-1, 2))
    _bar(axes, union, count + 0.6, "#8a1010", 0.9)
    _bar(axes, free, count + 1.8, "#3a8a3a", 0.9)
    if taken is not None:
        axes.axvline(np.degrees(taken), color="#202020", lw=1.2, ls=(0, (4, 2)))
    step = max(1, count // 10)
    ticks = list(range(0, count, step))
    axes.set_yticks(
        [*ticks, count + 0.6, count + 1.8], [*(str(n + 1) for n in ticks), "union", "free"]
    )
    axes.set_ylim(-0.7, count + 2.5)
    axes.set_xlim(0, 360)
    axes.set_xticks(range(0, 361, 60))
    axes.set_xlabel(r"flap angle $\alpha_1$ of vertex 1, degrees", fontsize=9)
    axes.set_ylabel("front vertex", fontsize=9)
    circle = plain(figure, (0.6, 0.04, 0.4, 0.84))
    draw_circle(circle, [("", arcs) for arcs in crossing] + [("", union)], {}, taken)
    words = "Flap angles at which new faces cross old ones at a vertex, and their union"
    figure.text(0.5, 0.94, words, ha="center", fontsize=12)
    return Drawing(figure)


def _bar(axes: Any, arcs: FloatArray, row: float, colour: str, alpha: float) -> None:
    for start, end in np.degrees(arcs).reshape(-1, 2).tolist():
        spans = [(start, end)] if start < end else [(start, 360.0), (0.0, end)]
        bars = [(low, high - low) for low, high in spans]
        axes.broken_barh(bars, (row - 0.4, 0.8), color=colour, alpha=alpha, lw=0)
