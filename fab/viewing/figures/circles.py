"""The circle of flap angles: forbidden arcs, special choices, and the angle that was taken."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from fab.viewing.figures.canvas import PALETTE
from solver.vectors import FloatArray

__all__ = ["draw_circle"]

_FORBIDDEN = "#d62020"
# More rings than these are too narrow for their names.
_NAMED = 4


def draw_circle(
    axes: Any,
    rings: Sequence[tuple[str, FloatArray]],
    special: Mapping[str, Sequence[float]],
    taken: float | None = None,
) -> None:
    """Flap angles counterclockwise from the right, in rings around each other.

    rings : a name and forbidden arcs, shape (n, 2), radians; the first ring is the innermost.
    special : flap angles by name, marked around the rings; taken : one that a hand points at.
    """
    turn = np.linspace(0, 2 * np.pi, 241)
    width = 0.5 / max(len(rings), 1)
    for number, (name, arcs) in enumerate(rings):
        low = 0.5 + number * width
        axes.plot(low * np.cos(turn), low * np.sin(turn), color="#cccccc", lw=0.6)
        for start, end in np.asarray(arcs).reshape(-1, 2).tolist():
            size = (end - start) % (2 * np.pi) or 2 * np.pi
            part = start + np.linspace(0, size, max(8, int(size * 40)))
            inner, outer = low + 0.06 * width, low + 0.94 * width
            ring = np.concatenate([inner * _points(part), outer * _points(part)[::-1]])
            axes.fill(*ring.T, color=_FORBIDDEN, alpha=0.55, lw=0)
        if len(rings) <= _NAMED:
            x, y = (low + width / 2) * np.array([np.cos(2.2), np.sin(2.2)])
            axes.text(x, y, name, ha="center", va="center", fontsize=7, color="#404040")
    axes.plot(np.cos(turn), np.sin(turn), color="#808080", lw=0.8)
    for number, (name, angles) in enumerate(special.items()):
        colour = PALETTE[number % len(PALETTE)]
        seen = [angle for angle in angles if np.isfinite(angle)]
        places = 1.06 * _points(np.array(seen))
        marker = "osD^vP*X"[number % 8]
        axes.plot(*places.T, marker, color=colour, ms=6, label=name, ls="none")
    if taken is not None:
        hand = np.array([0.46, 1.0])
        axes.plot(hand * np.cos(taken), hand * np.sin(taken), color="#202020", lw=2)
    for quarter, word in enumerate(("0°", "90°", "180°", "270°")):
        x, y = 1.22 * _points(np.array([quarter * np.pi / 2]))[0]
        axes.text(x, y, word, ha="center", va="center", fontsize=8)
    if special:
        axes.legend(loc="center", frameon=False, fontsize=7, handletextpad=0.2)
    axes.set_xlim(-1.3, 1.3)
    axes.set_ylim(-1.3, 1.3)


def _points(angles: FloatArray) -> FloatArray:
    return np.stack([np.cos(angles), np.sin(angles)], axis=-1)
