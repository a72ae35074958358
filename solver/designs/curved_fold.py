"""Curved folds grown from a zigzag along a parabola (figure 4D)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from solver import seeds
from solver.errors import require_count, require_length, require_number
from solver.front import Front
from solver.growth import Growth, Strip, grow

__all__ = ["CurvedFold"]


@dataclass(frozen=True)
class CurvedFold:
    """Seed: the curve (x, x^2) from x = -1 on with a zigzag, all k alike. Flap angle, length: one.

    Attributes
    ----------
    columns : number of quads along the curve.
    step : distance of the curve's vertices in x; vertex i lies at x = -1 + i step.
    zigzag : half the swing of the curve's vertices across it, in y.
    k : angle left for the first strip's faces at every vertex of the seed, radians.
    flap_angle : of every strip, at its first interior vertex, radians.
    crease_length : of every crease across a strip.
    strips : how many to grow.
    """

    columns: int = 100
    step: float = 0.02
    zigzag: float = 0.05
    k: float = field(default=1.04 * np.pi, metadata={"angle": True})
    flap_angle: float = field(default=7 * np.pi / 8, metadata={"angle": True})
    crease_length: float = 0.1
    strips: int = 10

    def grow(self, progress: Callable[[int, int], None] | None = None) -> Growth:
        """Grow the sheet. Raises `InvalidValue` for parameters out of bounds."""
        require_count("columns", self.columns, 2, "A strip needs an interior crease.")
        require_length("step", self.step)
        require_length("crease_length", self.crease_length)
        require_number("zigzag", self.zigzag)
        require_length("zigzag", abs(self.zigzag))
        i = np.arange(self.columns + 1)
        x = -1 + i * self.step
        y = x**2 + self.zigzag * (-1.0) ** i
        seed = seeds.curve(np.column_stack([x, y, np.zeros_like(x)]))

        def choose(_front: Front, _strip: int) -> Strip:
            return Strip(self.flap_angle, self.crease_length)

        return grow(seed, self.strips, choose, k=self.k, progress=progress)
