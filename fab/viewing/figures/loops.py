"""Closed fronts: for which flap angles the strip around them closes (S1 B.2)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fab.viewing.figures.canvas import Drawing, new_figure, plain
from fab.viewing.figures.sheets import draw_folded, shown_sheet
from solver.front import Front
from solver.mesh import QuadMesh
from solver.transfer import Closing, loop_misses

__all__ = ["loops_figure"]

_SAYS = {
    Closing.PAIR: "closes at two flap angles",
    Closing.CONTINUATION: "closes only as the continuation",
    Closing.FAMILY: "closes at every flap angle",
    Closing.NONE: "closes at none",
}


def loops_figure(loops: Sequence[tuple[str, QuadMesh]], trials: int = 721) -> Drawing:
    """By how much each loop misses itself over its flap angle, and the sheet it is the rim of.

    loops : a name and a closed sheet with faces, whose top is the front.
    """
    count = len(loops)
    figure = new_figure(400 * count, 720)
    flap_angles = np.linspace(0, 2 * np.pi, trials)
    for number, (name, mesh) in enumerate(loops):
        rows = mesh.vertices_coords[mesh.grid]
        front = Front.between(rows[-1], rows[-2], closed=True)
        space = plain(figure, (number / count, 0.5, 1 / count, 0.4), name)
        draw_folded(space, shown_sheet(mesh, name, upright=True))
        axes = figure.add_axes(((number + 0.18) / count, 0.09, 0.77 / count, 0.34))
        deltas = np.append(front.deltas, front.closing_delta)
        misses = np.degrees(loop_misses(front.couplings, deltas, flap_angles))
        misses[np.abs(np.diff(misses, prepend=misses[0])) > 180] = np.nan
        axes.plot(np.degrees(flap_angles), misses, color="#0b6e99", lw=1.8)
        axes.axhline(0, color="#999999", lw=0.7)
        closings = front.closings()
        for angle, marker in zip(np.degrees(closings.flap_angles), "os", strict=False):
            axes.plot(angle, 0, marker, color="#d62020", ms=7)
        axes.set_title(_SAYS[closings.case], fontsize=10)
        axes.set_xlim(0, 360)
        axes.set_xticks(range(0, 361, 90))
        axes.set_ylim(-190, 190)
        axes.set_yticks([-180, -90, 0, 90, 180])
        axes.tick_params(labelsize=8)
        axes.set_xlabel("flap angle of the first vertex, degrees", fontsize=9)
        if number == 0:
            axes.set_ylabel("missed after once around, degrees", fontsize=9)
    words = "Closed fronts: circle, the continuation; square, the one with new folds"
    figure.text(0.5, 0.95, words, ha="center", fontsize=12)
    return Drawing(figure)
