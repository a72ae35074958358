"""Rays of the creases of a new strip, and how long these can be before neighbours meet.

Source: supplementary information of "An additive algorithm for origami design", S1 (S20, S21).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from solver.errors import InvalidValue, require_within
from solver.vectors import FloatArray, full_turn, numbers

__all__ = ["Rays", "boundary_ray", "length_bounds", "loop_bounds", "meeting_distances"]


@dataclass(frozen=True)
class Rays:
    """The creases of a new strip: its row is `x + length * direction`. Arrays are read-only.

    Attributes
    ----------
    vertices_coords : the front, shape (m + 1, 3).
    directions : unit vectors, shape (m + 1, 3).
    half_flaps : sine and cosine of half the flap angles of the interior vertices, (m - 1,) each.
    length_bounds : each length must be below it; inf where neighbouring rays do not meet
        (equations S20, S21), shape (m + 1,).
    closing_error : of a loop, by how much the flap angle at its first vertex misses itself after
        once around, radians; the last quad is planar only where this is rounding.
    """

    vertices_coords: FloatArray
    directions: FloatArray
    half_flaps: tuple[FloatArray, FloatArray]
    length_bounds: FloatArray
    closing_error: float = 0.0

    def __post_init__(self) -> None:
        for array in (self.vertices_coords, self.directions, *self.half_flaps, self.length_bounds):
            array.flags.writeable = False

    @property
    def flap_angles(self) -> FloatArray:
        """Flap angles of the interior vertices, radians in [0, 2 pi), shape (m - 1,)."""
        return full_turn(2 * np.arctan2(*self.half_flaps))

    def each(self, lengths: FloatArray | float) -> FloatArray:
        """`lengths`, one for all or one each, as one for each vertex, shape (m + 1,)."""
        given, size = numbers("lengths", lengths), len(self.directions)
        if given.shape not in ((), (size,)):
            raise InvalidValue(
                "lengths",
                f"array of shape {given.shape}",
                f"be a number or have shape ({size},)",
                "Give one length for all creases, or one for each front vertex.",
            )
        return given if given.ndim else np.full(size, given)

    def row(self, lengths: FloatArray | float) -> FloatArray:
        """Vertices of the new row, shape (m + 1, 3); `lengths` is one for all or one each."""
        return self.vertices_coords + self.each(lengths)[:, None] * self.directions

    def between(self, first: int, last: int) -> Rays:
        """The rays of the vertices first to last - 1; the flap angles of all are kept."""
        part = slice(first, last)
        return replace(
            self,
            vertices_coords=self.vertices_coords[part],
            directions=self.directions[part],
            length_bounds=self.length_bounds[part],
        )


def boundary_ray(
    edge: FloatArray, inner: FloatArray, angle: float, which: str
) -> tuple[FloatArray, tuple[float, float]]:
    """Direction at an end of the front in the plane of its quad, with cosine and sine to `edge`.

    edge : unit vector into the front; inner : the neighbouring ray, which fixes the plane.
    """
    across = inner - (edge @ inner) * edge
    height = float(np.sqrt(across @ across))
    require_within(
        f"boundary angle ({which})", angle, 0.0, np.pi, "Leave it out for parallel.", angle=True
    )
    cosine, sine = float(np.cos(angle)), float(np.sin(angle))
    return cosine * edge + sine / height * across, (cosine, sine)


def loop_bounds(
    length: FloatArray,
    left: tuple[FloatArray, FloatArray],
    right: tuple[FloatArray, FloatArray],
) -> FloatArray:
    """As `length_bounds` for a loop: edge i runs from vertex i to the next; shape (N,)."""
    ahead = np.roll(right[0], -1), np.roll(right[1], -1)
    open_bounds = meeting_distances(length, left, ahead)
    return np.minimum(open_bounds[0], np.roll(open_bounds[1], 1))


def length_bounds(length: FloatArray, left: FloatArray, right: FloatArray) -> FloatArray:
    """Distance at which each ray meets a neighbour (S20, S21); left, right: (cos, sin), (2, m)."""
    start, end = meeting_distances(length, (left[0], left[1]), (right[0], right[1]))
    bounds = np.empty(len(length) + 1)
    bounds[-1] = np.inf
    bounds[:-1] = start
    np.minimum(bounds[1:], end, out=bounds[1:])
    return bounds


def meeting_distances(
    length: FloatArray,
    left: tuple[FloatArray, FloatArray],
    right: tuple[FloatArray, FloatArray],
) -> tuple[FloatArray, FloatArray]:
    """Distances at which the rays from both ends of each edge meet: along the left, the right one.

    left, right : cosine and sine of the angles between ray and edge. inf where they do not meet.
    """
    # sum of the two base angles below pi: the rays meet. Parallel ones, up to rounding, do not.
    meet = left[1] * right[0] + left[0] * right[1]
    meets = meet > 8 * np.finfo(float).eps
    base = np.divide(length, meet, out=np.full_like(length, np.inf), where=meets)
    return base * right[1], base * left[1]
