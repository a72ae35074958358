"""Soft terms: offsets from a surface, its rim, side lengths, least distances, fold angles."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from solver.hinge_angles import hinge_angles, hinge_gradients
from solver.quad_hinges import hinges
from solver.relaxation.terms import Linear
from solver.targets.base import Target
from solver.vectors import FloatArray, IntArray, dot, norm

__all__ = [
    "FoldBounds",
    "LeastDistances",
    "RimReach",
    "SideLengths",
    "SurfaceOffsets",
]


@dataclass(frozen=True)
class SurfaceOffsets:
    """Signed distances of vertices from a surface, less the wanted ones, in steps.

    The gradient is the surface's unit normal at the nearest point.

    Attributes
    ----------
    target : the surface. vertices : shape (n, 1), vertices that it holds; others are free of it.
    offsets : wanted distances on the normals' side, shape (n,). step : unit of the residuals.
    places : near the nearest ones, shape (n, d).
    """

    target: Target
    vertices: IntArray
    offsets: FloatArray
    step: float
    places: FloatArray

    def linearised(self, coords: FloatArray) -> Linear:
        """Residuals and gradients, see `Term`; NaN where no nearest point is found."""
        held = coords[self.vertices[:, 0]]
        distances, normals, places = self.target.distance(held, self.places)
        values = (distances - self.offsets) / self.step
        return Linear(values, normals[:, None] / self.step, replace(self, places=places))


@dataclass(frozen=True)
class RimReach:
    """By how much vertices fall short of planes, in steps, negative; 0 beyond them.

    With planes across a surface's rim, a sheet goes on covering it: else pleats close wherever the
    surface is narrower than the sheet is wide, and the sheet draws back over it.

    Attributes
    ----------
    vertices : shape (n, 1), a vertex may repeat. directions : unit normals of the planes, outwards,
        shape (n, 3). points : of the planes, shape (n, 3). step : unit of the residuals.

    >>> rim = RimReach(np.array([[0]]), np.array([[1.0, 0, 0]]), np.array([[2.0, 0, 0]]), 0.5)
    >>> short, beyond = (np.array([[x, 7.0, 7.0]]) for x in (1.0, 3.0))
    >>> rim.linearised(short).values.tolist(), rim.linearised(beyond).values.tolist()
    ([-2.0], [0.0])
    """

    vertices: IntArray
    directions: FloatArray
    points: FloatArray
    step: float

    def linearised(self, coords: FloatArray) -> Linear:
        """Residuals and gradients, see `Term`."""
        reach = dot(coords[self.vertices[:, 0]] - self.points, self.directions) / self.step
        short = reach < 0
        slopes = (self.directions * short[:, None] / self.step)[:, None]
        return Linear(np.where(short, reach, 0.0), slopes, self)


@dataclass(frozen=True)
class SideLengths:
    """Distances of pairs of vertices over the wanted ones, less 1.

    Attributes
    ----------
    vertices : shape (n, 2). lengths : wanted, shape (n,).

    >>> pair = SideLengths(np.array([[0, 1]]), np.array([2.0]))
    >>> pair.linearised(np.array([[0.0, 0, 0], [0, 3, 0]])).values.tolist()
    [0.5]
    """

    vertices: IntArray
    lengths: FloatArray

    def linearised(self, coords: FloatArray) -> Linear:
        """Residuals and gradients, see `Term`."""
        return Linear(*_length_ratios(coords, self.vertices, self.lengths), self)


@dataclass(frozen=True)
class LeastDistances:
    """Distances of pairs of vertices over the least ones, less 1, where that is negative; else 0.

    Pairs two apart along a grid line: pleats then do not close, nor do faces cross.

    Attributes
    ----------
    vertices : shape (n, 2). lengths : least, shape (n,).

    >>> pair = LeastDistances(np.array([[0, 1]]), np.array([2.0]))
    >>> near, far = (np.array([[0.0, 0, 0], [0, y, 0]]) for y in (1.0, 3.0))
    >>> pair.linearised(near).values.tolist(), pair.linearised(far).values.tolist()
    ([-0.5], [0.0])
    """

    vertices: IntArray
    lengths: FloatArray

    def linearised(self, coords: FloatArray) -> Linear:
        """Residuals and gradients, see `Term`."""
        values, gradients = _length_ratios(coords, self.vertices, self.lengths)
        near = values < 0
        return Linear(np.where(near, values, 0.0), gradients * near[:, None, None], self)


@dataclass(frozen=True)
class FoldBounds:
    """Fold angles beyond a bound, either way, radians; 0 within it.

    Angles are followed from round to round without a jump of a whole turn, so that one that has
    passed 180 degrees, where faces cross, is beyond 180 and not near -180.

    Attributes
    ----------
    vertices : hinges, shape (n, 4), see `quad_hinges.hinges`. angles : radians, shape (n,); the
        next ones are within half a turn of them. most : largest angle, radians.
    """

    vertices: IntArray
    angles: FloatArray
    most: float

    @classmethod
    def of(cls, faces_vertices: IntArray, coords: FloatArray, most: float) -> FoldBounds:
        """That of all inner edges, followed from the angles that they have at `coords`."""
        inner = hinges(faces_vertices)
        return cls(inner, hinge_angles(coords, inner), most)

    def linearised(self, coords: FloatArray) -> Linear:
        """Residuals and gradients, see `Term`."""
        turned = hinge_angles(coords, self.vertices) - self.angles
        angles = self.angles + turned - 2 * np.pi * np.round(turned / (2 * np.pi))
        over = np.abs(angles) > self.most
        slope = (np.sign(angles) * over)[:, None, None] * hinge_gradients(coords, self.vertices)
        values = np.where(over, np.abs(angles) - self.most, 0.0)
        return Linear(values, slope, replace(self, angles=angles))


def _length_ratios(
    coords: FloatArray, pairs: IntArray, lengths: FloatArray
) -> tuple[FloatArray, FloatArray]:
    side = coords[pairs[:, 1]] - coords[pairs[:, 0]]
    size = norm(side)
    slope = side / (size * lengths)[:, None]
    return size / lengths - 1, np.stack([-slope, slope], axis=1)
