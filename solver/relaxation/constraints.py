"""Hard terms: planar faces, developable vertices, flat-foldable vertices, vertices that meet.

Planar faces and sectors that sum to 2 pi make a sheet that folds from flat paper; Kawasaki's
condition besides, that the sums of alternate sectors are alike, makes one that folds flat, and a
quad sheet that folds flat and is folded anyhow between folds rigidly (T. Tachi, "Generalization of
rigid foldable quadrilateral mesh origami", Journal of the IASS 50 (2009)).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from solver.relaxation.neighbours import vertex_rings
from solver.relaxation.terms import Linear
from solver.vectors import FloatArray, IntArray, cross, dot, norm

__all__ = ["DevelopableVertices", "FlatFoldableVertices", "MeetingVertices", "PlanarFaces"]


@dataclass(frozen=True)
class PlanarFaces:
    """The volume between the corners of each quad, 4 V / (d1^2 + d2^2)^(3/2) with V a triple
    product of its sides and d1, d2 its diagonals: the distance of the diagonals over twice the
    side where the quad is nearly a square.

    Attributes
    ----------
    vertices : of the faces, shape (nf, 4).

    >>> square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.02]])
    >>> PlanarFaces(np.array([[0, 1, 2, 3]])).linearised(square).values.round(4).tolist()
    [0.01]
    """

    vertices: IntArray

    def linearised(self, coords: FloatArray) -> Linear:
        """Residuals and gradients, see `Term`."""
        a, b, c, d = (coords[self.vertices[:, k]] for k in range(4))
        p, q, r, other = b - a, c - a, d - a, d - b
        by_b, by_c, by_d = cross(q, r), cross(r, p), cross(p, q)
        square = dot(q, q) + dot(other, other)
        size = 4 / square**1.5
        values = size * dot(by_d, r)
        slopes = size[:, None, None] * np.stack([-by_b - by_c - by_d, by_b, by_c, by_d], axis=1)
        shrink = (3 * values / square)[:, None, None]
        return Linear(values, slopes - shrink * np.stack([-q, -other, q, other], axis=1), self)


@dataclass(frozen=True)
class DevelopableVertices:
    """The sum of the sector angles around each interior vertex less 2 pi, radians.

    Attributes
    ----------
    vertices : rings, shape (n, 1 + k): the vertex and its neighbours counterclockwise, -1 beyond
        the last.
    """

    vertices: IntArray

    @classmethod
    def of(cls, faces_vertices: IntArray, count: int) -> DevelopableVertices:
        """That of all interior vertices of a mesh with `count` vertices."""
        return cls(vertex_rings(faces_vertices, count))

    def linearised(self, coords: FloatArray) -> Linear:
        """Residuals and gradients, see `Term`."""
        values, gradients = _sector_sums(coords, self.vertices, np.ones(self.vertices.shape[1] - 1))
        return Linear(values - 2 * np.pi, gradients, self)


@dataclass(frozen=True)
class FlatFoldableVertices:
    """Kawasaki's condition: the sum of the sectors around each interior vertex with alternating
    signs, radians.

    Attributes
    ----------
    vertices : rings of vertices with evenly many faces, as for `DevelopableVertices`.
    """

    vertices: IntArray

    @classmethod
    def of(cls, faces_vertices: IntArray, count: int) -> FlatFoldableVertices:
        """That of the interior vertices of a mesh with `count` vertices.

        A vertex with an odd number of faces never folds flat, and is left out.
        """
        rings = vertex_rings(faces_vertices, count)
        return cls(rings[(rings >= 0).sum(axis=1) % 2 == 1])

    def linearised(self, coords: FloatArray) -> Linear:
        """Residuals and gradients, see `Term`."""
        signs = (-1.0) ** np.arange(self.vertices.shape[1] - 1)
        return Linear(*_sector_sums(coords, self.vertices, signs), self)


@dataclass(frozen=True)
class MeetingVertices:
    """Differences of the coordinates of pairs of vertices, in steps: they are to be one point.

    Attributes
    ----------
    vertices : each pair three times in turn, shape (3 n, 2). step : unit of the residuals.

    >>> term = MeetingVertices.of(np.array([[0, 1]]), 0.5)
    >>> term.linearised(np.array([[0.0, 0, 0], [1, 2, 3]])).values.tolist()
    [2.0, 4.0, 6.0]
    """

    vertices: IntArray
    step: float

    @classmethod
    def of(cls, pairs: IntArray, step: float) -> MeetingVertices:
        """That of pairs (n, 2)."""
        return cls(np.repeat(pairs, 3, axis=0), step)

    def linearised(self, coords: FloatArray) -> Linear:
        """Residuals and gradients, see `Term`."""
        first, second = coords[self.vertices[::3, 0]], coords[self.vertices[::3, 1]]
        axes = np.tile(np.eye(3), (len(first), 1)) / self.step
        return Linear(((second - first) / self.step).ravel(), np.stack([-axes, axes], axis=1), self)


def _sector_sums(
    coords: FloatArray, rings: IntArray, signs: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Sums of the sectors around vertices times `signs`, shape (n,), and gradients, (n, 1 + k, 3).

    A sector between the sides a and b has the gradients -n x a / a^2 and n x b / b^2 by their
    ends, with the unit normal n of the sector; its angle is atan2(|a x b|, a.b).
    """
    ring = rings[:, 1:]
    there = ring >= 0
    valence = there.sum(axis=1)
    place = np.arange(ring.shape[1])
    following = np.where(place + 1 == valence[:, None], 0, np.minimum(place + 1, ring.shape[1] - 1))
    spoke = coords[ring] - coords[rings[:, :1]]
    after = np.take_along_axis(spoke, following[:, :, None], axis=1)
    normal = cross(spoke, after)
    height = norm(normal)
    with np.errstate(invalid="ignore", divide="ignore"):
        normal = normal / height[:, :, None]
    used = signs * there
    values = np.sum(np.arctan2(height, dot(spoke, after)) * used, axis=1)
    turn = cross(normal, spoke) / dot(spoke, spoke)[:, :, None]
    far = cross(normal, after) / dot(after, after)[:, :, None]
    gradients = np.zeros((*rings.shape, 3))
    by_first, by_second = (
        np.where(there[:, :, None], used[:, :, None] * g, 0) for g in (-turn, far)
    )
    rows = np.arange(len(rings))
    for k in place:
        gradients[:, k + 1] += by_first[:, k]
        gradients[rows, following[:, k] + 1] += by_second[:, k]
    gradients[:, 0] = -gradients[:, 1:].sum(axis=1)
    return values, gradients
