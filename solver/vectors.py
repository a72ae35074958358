"""How long, which way, at what angle: arrays of vectors in space, shape (..., 3)."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "full_turn",
    "BoolArray",
    "ComplexArray",
    "FloatArray",
    "IntArray",
    "angle_between",
    "cross",
    "dot",
    "norm",
    "unit",
]

FloatArray: TypeAlias = NDArray[np.float64]
IntArray: TypeAlias = NDArray[np.int64]
BoolArray: TypeAlias = NDArray[np.bool_]
ComplexArray: TypeAlias = NDArray[np.complex128]


def dot(u: FloatArray, v: FloatArray) -> FloatArray:
    """Inner product over the last axis."""
    out: FloatArray = np.einsum("...i,...i->...", u, v)
    return out


def cross(u: FloatArray, v: FloatArray) -> FloatArray:
    """Cross product over the last axis (a few times faster than `numpy.cross`)."""
    u, v = np.broadcast_arrays(u, v)
    out = np.empty_like(u)
    np.subtract(u[..., 1] * v[..., 2], u[..., 2] * v[..., 1], out=out[..., 0])
    np.subtract(u[..., 2] * v[..., 0], u[..., 0] * v[..., 2], out=out[..., 1])
    np.subtract(u[..., 0] * v[..., 1], u[..., 1] * v[..., 0], out=out[..., 2])
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
    """Angle in [0, pi] by atan2(|u x v|, u.v): accurate near 0 and pi, where arccos is not."""
    out: FloatArray = np.arctan2(norm(cross(u, v)), dot(u, v))
    return out


def full_turn(angle: FloatArray) -> FloatArray:
    """Angles brought into [0, 2 pi), radians; rounding never gives 2 pi itself."""
    turned = np.mod(angle, 2 * np.pi)
    return np.where(turned >= 2 * np.pi, 0.0, turned)
