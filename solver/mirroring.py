"""Flap angles for which the creases of a strip mirror those of the strip behind, in a surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from solver.flap_costs import FlapCost
from solver.front import Front
from solver.vectors import FloatArray, dot, unit

__all__ = ["Mirror"]


@dataclass(frozen=True)
class Mirror(FlapCost):
    """How far the creases of a strip are from the mirror images of those behind.

    Creases are combinations of the vertices' frames, flap angles images of the first one.

    Attributes
    ----------
    along_a, along_inner, along_normal : the wanted directions in the frames, shape (n, 1).
    """

    along_a: FloatArray
    along_inner: FloatArray
    along_normal: FloatArray

    @classmethod
    def of(cls, front: Front, normal: FloatArray) -> Mirror:
        """Normal : of the target at the front's interior vertices, shape (n, 3)."""
        assert front.back is not None  # the seed has faces
        onward = -front.back
        wanted = unit(onward - 2 * dot(onward, normal)[:, None] * normal)
        frame = (-front.edges_direction[:-1], front.inner, front.normals)
        along = [dot(wanted, axis)[:, None] for axis in frame]
        return cls(front, along[0], along[1], along[2])

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
