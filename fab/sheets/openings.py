"""Openings in faces along seams: slots for tabs, and holes for a thread."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from solver.vectors import FloatArray, IntArray

__all__ = ["Openings", "beside_seams"]


# What is beside an opening by more than this has passed it.
_PASSED_MM = 0.3


@dataclass(frozen=True)
class Openings:
    """Closed cuts within faces, in the plane of the whole pattern, mm.

    Attributes
    ----------
    rings : n clockwise polylines, each of shape (m, 2).
    faces, seams : the face and the seam of each, shape (n,).
    """

    rings: tuple[FloatArray, ...]
    faces: IntArray
    seams: IntArray

    @classmethod
    def none(cls) -> Openings:
        """No openings."""
        return cls((), np.empty(0, np.int64), np.empty(0, np.int64))

    def of(self, faces: IntArray) -> list[FloatArray]:
        """The rings in some faces."""
        within = np.flatnonzero(np.isin(self.faces, faces))
        return [self.rings[number] for number in within.tolist()]

    def reach_mm(self, seam: int, face: int, ends: FloatArray) -> float:
        """How far from its edge those of a seam in a face are passed, 0 without any.

        ends : of the edge in the plane of the whole pattern, its face to the left, shape (2, 2).
        """
        own = np.flatnonzero((self.seams == seam) & (self.faces == face))
        if not len(own):
            return 0.0
        span = ends[1] - ends[0]
        left = np.array([-span[1], span[0]]) / np.hypot(*span)
        points = np.concatenate([self.rings[number] for number in own.tolist()])
        return float(((points - ends[0]) @ left).max()) + _PASSED_MM


def beside_seams(ends: FloatArray, points: FloatArray) -> FloatArray:
    """Points given by how far along an edge they are, and how far to the left of it, (n, 2).

    ends : of the edge, shape (2, 2).

    >>> edge = np.array([[2.0, 0.0], [2.0, 10.0]])
    >>> beside_seams(edge, np.array([[3.0, 1.0]])).tolist()
    [[1.0, 3.0]]
    """
    span = ends[1] - ends[0]
    u = span / np.hypot(*span)
    out: FloatArray = ends[0] + points @ np.array([u, [-u[1], u[0]]])
    return out
