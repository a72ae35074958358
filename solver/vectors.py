"""Lengths, directions and angles of arrays of vectors in space, shape (..., 3)."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from solver.errors import InvalidState, InvalidValue

__all__ = [
    "LARGEST",
    "SMALLEST",
    "BoolArray",
    "ComplexArray",
    "FloatArray",
    "IntArray",
    "angle_between",
    "cross",
    "dot",
    "full_turn",
    "norm",
    "numbers",
    "points",
    "scattered",
    "unit",
]

# Coordinates and lengths in between keep their fourth powers within the range of floats.
SMALLEST, LARGEST = 1e-50, 1e50

FloatArray: TypeAlias = NDArray[np.float64]
IntArray: TypeAlias = NDArray[np.int64]
BoolArray: TypeAlias = NDArray[np.bool_]
ComplexArray: TypeAlias = NDArray[np.complex128]


def numbers(name: str, value: object) -> FloatArray:
    """`value` as an array of float64; raises `InvalidValue` unless it holds real numbers only."""
    try:
        array = np.asarray(value)
    except ValueError:  # rows of different lengths
        array = np.empty(0, object)
    if array.dtype.kind not in "iuf":
        raise InvalidValue(
            name,
            f"{type(value).__name__} ({array.dtype})",
            "hold real numbers, equally many in every row",
            "Give an array, or lists of one length.",
        )
    return np.asarray(array, np.float64)


def points(name: str, value: object) -> FloatArray:
    """`value` as points in space, shape (n, 3), read-only.

    Raises `InvalidValue` for other shapes and for coordinates that are not finite or over 1e50.
    """
    array = numbers(name, value)
    if array.ndim != 2 or array.shape[1] != 3:
        raise InvalidValue(
            name, f"array of shape {array.shape}", "have shape (n, 3)", "Give x, y, z of each."
        )
    if not np.abs(array).max(initial=0.0) <= LARGEST:
        raise InvalidState(
            name,
            f"{name}: some coordinates are NaN or not from {-LARGEST:g} to {LARGEST:g}",
            "Check where they come from, or scale them.",
        )
    out = array.view()
    out.flags.writeable = False
    return out


def dot(u: FloatArray, v: FloatArray) -> FloatArray:
    """Inner product over the last axis."""
    out: FloatArray = np.vecdot(u, v)
    return out


def cross(u: FloatArray, v: FloatArray) -> FloatArray:
    """Cross product over the last axis (a few times faster than `numpy.cross`)."""
    u0, u1, u2 = u[..., 0], u[..., 1], u[..., 2]
    v0, v1, v2 = v[..., 0], v[..., 1], v[..., 2]
    first = u1 * v2 - u2 * v1
    out = np.empty((*first.shape, 3))
    out[..., 0] = first
    np.subtract(u2 * v0, u0 * v2, out=out[..., 1])
    np.subtract(u0 * v1, u1 * v0, out=out[..., 2])
    return out


def norm(u: FloatArray) -> FloatArray:
    """Euclidean length over the last axis."""
    out: FloatArray = np.sqrt(dot(u, u))
    return out


def unit(u: FloatArray) -> FloatArray:
    """Vectors of length one; a zero vector gives NaN."""
    with np.errstate(invalid="ignore", divide="ignore"):
        return u / norm(u)[..., None]


def angle_between(u: FloatArray, v: FloatArray) -> FloatArray:
    """Angle in [0, pi] by atan2(|u x v|, u.v): accurate near 0 and pi, where arccos is not.

    >>> float(angle_between(np.array([1.0, 0.0, 0.0]), np.array([1.0, 1e-9, 0.0])))
    1e-09
    """
    out: FloatArray = np.arctan2(norm(cross(u, v)), dot(u, v))
    return out


def full_turn(angle: FloatArray) -> FloatArray:
    """Angles brought into [0, 2 pi), radians; rounding never gives 2 pi itself."""
    turned = np.mod(angle, 2 * np.pi)
    return np.where(turned >= 2 * np.pi, 0.0, turned)


def scattered(places: IntArray, vectors: FloatArray, count: int) -> FloatArray:
    """Sums of the vectors, shape (n, k), that go to each of `count` places, shape (count, k).

    >>> scattered(np.array([0, 2, 0]), np.array([[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]]), 3)
    array([[6., 8.],
           [0., 0.],
           [3., 4.]])
    """
    return np.stack([np.bincount(places, column, count) for column in vectors.T], axis=1)
