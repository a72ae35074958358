"""Closest points of a vertex and a triangle, and of two segments.

Both kinds of pairs have four points. The vector between the closest points is their sum with
weights that add up to 0, and the gradient of the distance by each point is its weight times the
unit vector: so both kinds are treated alike from there on. After Ericson (2005), "Real-time
collision detection", section 5.1.
"""

from __future__ import annotations

import numpy as np

from solver.vectors import FloatArray, dot

__all__ = ["segment_weights", "separations", "triangle_weights"]

# The square of the sine between segments, below which rounding decides where lines are closest.
_PARALLEL = 1e-10


def triangle_weights(points: FloatArray) -> FloatArray:
    """Weights of a vertex and of the corners of a triangle, shape (n, 4).

    points : shape (n, 4, 3), the vertex first. The vector leads from the triangle to the vertex.

    >>> corners = [[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]
    >>> points = np.array([[[0.25, 0.5, 3.0], *corners], [[2.0, 0, 1], *corners]])
    >>> (triangle_weights(points) + 0.0).tolist()
    [[1.0, -0.25, -0.25, -0.5], [1.0, 0.0, -1.0, 0.0]]
    """
    vertex, first, second, third = points.swapaxes(0, 1)
    ab, ac, ap = second - first, third - first, vertex - first
    bb, bc, cc = dot(ab, ab), dot(ab, ac), dot(ac, ac)
    d1, d2 = dot(ab, ap), dot(ac, ap)
    d3, d4, d5, d6 = d1 - bb, d2 - bc, d1 - bc, d2 - cc
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    zero, one = np.zeros(len(points)), np.ones(len(points))
    with np.errstate(divide="ignore", invalid="ignore"):
        on_ab, on_ac = d1 / (d1 - d3), d2 / (d2 - d6)
        on_bc = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        inside = va + vb + vc
        regions = [
            (d1 <= 0) & (d2 <= 0),
            (d3 >= 0) & (d4 <= d3),
            (d6 >= 0) & (d5 <= d6),
            (vc <= 0) & (d1 >= 0) & (d3 <= 0),
            (vb <= 0) & (d2 >= 0) & (d6 <= 0),
            (va <= 0) & (d4 >= d3) & (d5 >= d6),
        ]
        b, c = vb / inside, vc / inside
    for region, at_b, at_c in zip(
        reversed(regions),
        (1 - on_bc, zero, on_ab, zero, one, zero),
        (on_bc, on_ac, zero, one, zero, zero),
        strict=True,
    ):
        b, c = np.where(region, at_b, b), np.where(region, at_c, c)
    return np.stack([one, b + c - 1, -b, -c], axis=1)


def segment_weights(points: FloatArray) -> FloatArray:
    """Weights of the ends of two segments, shape (n, 4).

    points : shape (n, 4, 3), the ends of the first segment, then those of the second. The vector
    leads from the second to the first.

    >>> cross = np.array([[[-1.0, 0, 1], [1, 0, 1], [0, -1, 0], [0, 3, 0]]])
    >>> segment_weights(cross).tolist()
    [[0.5, 0.5, -0.75, -0.25]]
    """
    along, other = points[:, 1] - points[:, 0], points[:, 3] - points[:, 2]
    between = points[:, 0] - points[:, 2]
    a, e, b = dot(along, along), dot(other, other), dot(along, other)
    c, f = dot(along, between), dot(other, between)
    sine = a * e - b * b
    with np.errstate(divide="ignore", invalid="ignore"):
        s, t = _ends_met(np.clip((b * f - c * e) / sine, 0.0, 1.0), a, b, c, e, f)
        near = np.flatnonzero(~(sine > _PARALLEL * a * e))
        if len(near):  # along an overlap they are closest at one of its ends
            some = points[near]
            sums = (a[near], b[near], c[near], e[near], f[near])
            ends = [_ends_met(np.full(len(near), share), *sums) for share in (0.0, 1.0)]
            ends += [
                (_clipped_ratio(sums[2], sums[0], share * sums[1]), np.full(len(near), share))
                for share in (0.0, 1.0)
            ]
            tried = np.stack([_weights(*each) for each in ends])
            far = separations(
                np.broadcast_to(some, (4, *some.shape)).reshape(-1, 4, 3), tried.reshape(-1, 4)
            )[0]
            best = far.reshape(4, -1).argmin(axis=0)
            s[near], t[near] = (
                np.stack([each[k] for each in ends])[best, np.arange(len(near))] for k in (0, 1)
            )
    return _weights(s, t)


def _weights(s: FloatArray, t: FloatArray) -> FloatArray:
    return np.stack([1 - s, s, t - 1, -t], axis=1)


def _clipped_ratio(c: FloatArray, a: FloatArray, shift: FloatArray) -> FloatArray:
    """Where the first segment is closest to a point of the second one."""
    out: FloatArray = np.clip((shift - c) / a, 0.0, 1.0)
    return out


def _ends_met(
    s: FloatArray, a: FloatArray, b: FloatArray, c: FloatArray, e: FloatArray, f: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Shares of both segments, from that of the first one as long as its closest point allows."""
    t = (b * s + f) / e
    s = np.where(t < 0, _clipped_ratio(c, a, np.zeros_like(b)), s)
    s = np.where(t > 1, _clipped_ratio(c, a, b), s)
    return s, np.clip(t, 0.0, 1.0)


def separations(points: FloatArray, weights: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Distances of closest points, shape (n,), and the unit vectors between them, shape (n, 3)."""
    vector = np.einsum("ni,nix->nx", weights, points)
    distance = np.sqrt(dot(vector, vector))
    with np.errstate(divide="ignore", invalid="ignore"):
        return distance, vector / distance[:, None]
