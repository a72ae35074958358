"""Flap angles for which the creases of a strip mirror those of the strip behind, in a surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from solver.arcs import contain
from solver.front import Front
from solver.vectors import FloatArray, dot, unit

__all__ = ["Mirror", "is_free"]

# Flap angles tried all around the circle.
_TRIALS = 1441


def is_free(free: FloatArray, angle: float) -> bool:
    """Whether a flap angle, in radians of any turn, is within one of the free arcs."""
    return bool(contain(free, np.array([angle % (2 * np.pi)]))[0])


@dataclass(frozen=True)
class Mirror:
    """How far the creases of a strip are from the mirror images of those behind.

    Creases are combinations of the vertices' frames, flap angles images of the first one.

    Attributes
    ----------
    along_a, along_inner, along_normal : the wanted directions in the frames, shape (n, 1).
    front : the front, its vertices' numbers in columns.
    """

    along_a: FloatArray
    along_inner: FloatArray
    along_normal: FloatArray
    front: Front

    @classmethod
    def of(cls, front: Front, normal: FloatArray) -> Mirror:
        """Normal : of the target at the front's interior vertices, shape (n, 3)."""
        assert front.back is not None  # the seed has faces
        onward = -front.back
        wanted = unit(onward - 2 * dot(onward, normal)[:, None] * normal)
        frame = (-front.edges_direction[:-1], front.inner, front.normals)
        along = [dot(wanted, axis)[:, None] for axis in frame]
        return cls(along[0], along[1], along[2], front)

    def _parts(self, trials: FloatArray) -> tuple[FloatArray, ...]:
        f = self.front
        image = f.transfer_matrices @ np.stack([np.sin(trials / 2), np.cos(trials / 2)])
        squares = image * image
        size = squares[:, 0] + squares[:, 1]
        cosine = (squares[:, 1] - squares[:, 0]) / size
        sine = 2 * image[:, 0] * image[:, 1] / size
        level = (f.run + f.sin_beta)[:, None] - f.sin_beta[:, None] * cosine
        return size, cosine, sine, level, np.hypot(f.rise[:, None], level)

    def cost(self, trials: FloatArray) -> FloatArray:
        """Sum over the creases of 1 - cosine to the wanted direction, shape (q,)."""
        _, cosine, sine, level, length = self._parts(trials)
        across = self.along_inner * cosine + self.along_normal * sine
        match = (self.along_a * level + self.front.rise[:, None] * across) / length
        out: FloatArray = (1 - match).sum(axis=0)
        return out

    def slope(self, trial: float) -> float:
        """Derivative of the cost with respect to the first flap angle, exact."""
        f = self.front
        size, cosine, sine, level, length = self._parts(np.array([trial]))
        rise = f.rise[:, None]
        across = self.along_inner * cosine + self.along_normal * sine
        turned = self.along_normal * cosine - self.along_inner * sine
        opening = -rise * f.sin_beta[:, None] * sine / length**2  # d theta1 / d alpha
        match = opening * (level * across - rise * self.along_a) / length + rise * turned / length
        speed = np.linalg.det(f.transfer_matrices)[:, None] / size  # d alpha / d alpha of the first
        return -float((match * speed).sum())

    def minimum(self, low: float, high: float) -> float | None:
        """A flap angle between two others at which the cost is least; None where it falls out."""
        if not self.slope(low) < 0 < self.slope(high):
            return None
        return float(brentq(self.slope, low, high, xtol=1e-13))

    def best_of(self, free: FloatArray) -> float:
        """The free flap angle of least cost all around: the best of many trials, then polished."""
        trials = np.linspace(0.0, 2 * np.pi, _TRIALS, endpoint=False)
        inside = contain(free, trials)
        if not inside.any():  # arcs narrower than the trials' distance
            trials, inside = _middles(free), np.ones(len(free), bool)
        best = float(trials[np.argmin(np.where(inside, self.cost(trials), np.inf))])
        spread = 2 * np.pi / _TRIALS
        polished = self.minimum(best - spread, best + spread)
        return best if polished is None or not is_free(free, polished) else polished


def _middles(arcs: FloatArray) -> FloatArray:
    start, end = arcs.T
    out: FloatArray = (start + ((end - start) % (2 * np.pi)) / 2) % (2 * np.pi)
    return out
