"""Curved folds grown from a zigzag along a plane curve (figures 4D and S14)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from solver import seeds
from solver.errors import InvalidValue, require_count, require_length, require_number
from solver.front import Front
from solver.growth import Growth, Strip, grow
from solver.vectors import FloatArray

__all__ = ["CURVES", "CurvedFold"]


def _arc(x: FloatArray, offset: FloatArray) -> tuple[FloatArray, FloatArray]:
    radius = 0.75
    return (radius - offset) * np.sin(x / radius), radius - (radius - offset) * np.cos(x / radius)


def _parabola(x: FloatArray, offset: FloatArray) -> tuple[FloatArray, FloatArray]:
    return x, x**2 + offset


def _wave(x: FloatArray, offset: FloatArray) -> tuple[FloatArray, FloatArray]:
    return x, np.sin(np.pi * x) / 3 + offset


# x and y of the vertices of each curve, moved across it by the offset of the zigzag.
CURVES = {"arc": _arc, "parabola": _parabola, "wave": _wave}


@dataclass(frozen=True)
class CurvedFold:
    """Seed: a curve from x = -1 on with a zigzag, all k alike. Flap angle, length: one.

    Vertex i of the parabola is (-1 + i step, (-1 + i step)^2 + zigzag (-1)^i, 0), as in the model
    of figure 4D. S37 is printed with the zigzag of opposite sign: take zigzag = -0.05 for that.

    Attributes
    ----------
    curve : parabola, y = x^2 (figure 4D); wave, y = sin(pi x) / 3, bends both ways; arc of a circle
        of radius 3/4, along which x is the length.
    columns : number of quads along the curve.
    step : distance of the curve's vertices in x; vertex i lies at x = -1 + i step.
    zigzag : half the swing of the curve's vertices across it, in y, or along the arc's radius.
    k : angle left for the first strip's faces at every vertex of the seed, radians.
    flap_angle : of every strip, at its first interior vertex, radians.
    crease_length : of every crease across a strip.
    strips : how many to grow.
    """

    curve: str = "parabola"
    columns: int = 100
    step: float = 0.02
    zigzag: float = 0.05
    k: float = field(default=1.04 * np.pi, metadata={"angle": True})
    flap_angle: float = field(default=7 * np.pi / 8, metadata={"angle": True})
    crease_length: float = 0.1
    strips: int = 10

    def grow(self, progress: Callable[[int, int], None] | None = None) -> Growth:
        """Grow the sheet. Raises `InvalidValue` for parameters out of bounds."""
        if self.curve not in CURVES:
            raise InvalidValue(
                "curve", self.curve, f"be one of {', '.join(CURVES)}", "parabola is figure 4D."
            )
        require_count("columns", self.columns, 2, "A strip needs an interior crease.")
        require_length("step", self.step)
        require_length("crease_length", self.crease_length)
        require_number("zigzag", self.zigzag)
        require_length("zigzag", abs(self.zigzag))
        i: FloatArray = np.arange(self.columns + 1.0)
        x, y = CURVES[self.curve](-1.0 + i * self.step, self.zigzag * (-1.0) ** i)
        seed = seeds.curve(np.column_stack([x, y, np.zeros_like(x)]))

        def choose(_front: Front, _strip: int) -> Strip:
            return Strip(self.flap_angle, self.crease_length)

        return grow(seed, self.strips, choose, k=self.k, progress=progress)
