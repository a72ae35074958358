"""Rotations of many bodies at once, as unit quaternions, shape (4, n): x, y, z and w.

One component after another, so that products of many run several times as fast as those of
`scipy.spatial.transform.Rotation`. A quaternion and its negative are the same rotation.
"""

from __future__ import annotations

import numpy as np

from solver.vectors import FloatArray

__all__ = ["inverse", "matrices", "of_vectors", "product", "turned", "vectors_of"]

# Below this sine of half the angle, the rotation vector is twice the axis part.
_SMALL = 1e-8


def of_vectors(vectors: FloatArray) -> FloatArray:
    """Rotations about vectors, shape (3, n), by their lengths, radians.

    >>> of_vectors(np.array([[0.0], [0.0], [np.pi]])).ravel().round(15).tolist()
    [0.0, 0.0, 1.0, 0.0]
    """
    half = np.sqrt((vectors * vectors).sum(axis=0)) / 2
    return np.concatenate([vectors * (np.sinc(half / np.pi) / 2), np.cos(half)[None]])


def vectors_of(rotations: FloatArray) -> FloatArray:
    """Rotation vectors, shape (3, n), of at most half a turn.

    >>> vectors_of(of_vectors(np.array([[0.5], [-0.25], [1e-12]]))).ravel().round(15).tolist()
    [0.5, -0.25, 1e-12]
    """
    near = np.where(rotations[3] < 0, -rotations, rotations)
    sine = np.sqrt((near[:3] * near[:3]).sum(axis=0))
    angle = 2 * np.arctan2(sine, near[3])
    small = sine < _SMALL
    return np.asarray(near[:3] * np.where(small, 2.0, angle / np.where(small, 1.0, sine)))


def product(first: FloatArray, second: FloatArray) -> FloatArray:
    """The rotations `second` followed by `first`.

    >>> quarter, little = (of_vectors(np.array([[0.0], [0.0], [x]])) for x in (np.pi / 2, 0.25))
    >>> bool(np.isclose(vectors_of(product(quarter, little))[2, 0], np.pi / 2 + 0.25))
    True
    """
    a, b, c, d = first
    x, y, z, w = second
    return np.stack(
        [
            d * x + a * w + b * z - c * y,
            d * y - a * z + b * w + c * x,
            d * z + a * y - b * x + c * w,
            d * w - a * x - b * y - c * z,
        ]
    )


def inverse(rotations: FloatArray) -> FloatArray:
    """The opposite rotations."""
    out: FloatArray = rotations * np.array([[-1.0], [-1.0], [-1.0], [1.0]])
    return out


def turned(rotations: FloatArray, vectors: FloatArray) -> FloatArray:
    """Vectors, shape (3, n), each turned by a rotation.

    >>> quarter = of_vectors(np.array([[0.0], [0.0], [np.pi / 2]]))
    >>> turned(quarter, np.array([[1.0], [0.0], [2.0]])).ravel().round(15).tolist()
    [0.0, 1.0, 2.0]
    """
    twice = 2 * _cross(rotations[:3], vectors)
    return np.asarray(vectors + rotations[3] * twice + _cross(rotations[:3], twice))


def matrices(rotations: FloatArray) -> FloatArray:
    """The same as matrices, shape (n, 3, 3)."""
    x, y, z, w = rotations
    entries = [
        1 - 2 * (y * y + z * z),
        2 * (x * y - z * w),
        2 * (x * z + y * w),
        2 * (x * y + z * w),
        1 - 2 * (x * x + z * z),
        2 * (y * z - x * w),
        2 * (x * z - y * w),
        2 * (y * z + x * w),
        1 - 2 * (x * x + y * y),
    ]
    return np.stack(entries, axis=1).reshape(-1, 3, 3)


def _cross(u: FloatArray, v: FloatArray) -> FloatArray:
    a, b, c = u
    x, y, z = v
    return np.stack([b * z - c * y, c * x - a * z, a * y - b * x])
