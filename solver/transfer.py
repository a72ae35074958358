"""How does one flap angle decide all others along a strip?

In half-angle tangents the flap-angle map of a vertex is a Moebius transformation (the half-angle
form of equations S44 to S49 of the supplementary information): with alpha' the flap angle of the
face right of the new crease,

    tan(alpha/2) tan(alpha'/2) = C = sin((k - beta)/2) / sin((k + beta)/2)  > 0
    alpha[i+1] = alpha'[i] + delta[i]

so that with (s, c) = (sin, cos)(alpha/2) one vertex costs a swap, a scale and a rotation:

    (s, c) -> rotate((C c, s), delta/2)

`half_angles` walks that chain vertex after vertex, which keeps every new quad planar to rounding.
`prefix_products` gives all flap angles at once as functions of the first: for searching.
"""

from __future__ import annotations

import math

import numpy as np

from solver.vectors import FloatArray, full_turn

__all__ = ["coupling", "half_angles", "prefix_products", "transform"]

# A chain is normalised before the logarithm of its length can have changed by more than this.
_LOG_RANGE = 300.0


def coupling(beta: FloatArray, k: FloatArray) -> FloatArray:
    """The constant C of each vertex; beta, k in radians, shape (n,)."""
    out: FloatArray = np.sin((k - beta) / 2) / np.sin((k + beta) / 2)
    return out


def half_angles(
    couplings: FloatArray, deltas: FloatArray, flap_angle: float, at: int = 0
) -> tuple[FloatArray, FloatArray]:
    """Sine and cosine of half of every flap angle of a strip, each of shape (n,).

    Parameters
    ----------
    couplings : C of every vertex, shape (n,).
    deltas : angle between the beta planes of vertices i and i + 1, radians, shape (n - 1,).
    flap_angle : radians, of vertex number `at` (0 to n - 1).
    """
    # one step, with the coupling spread evenly (determinant -1) so that products stay in range:
    # (s, c) -> (p s + q c, r s - t c), and backwards (s, c) -> (t s + q c, r s - p c)
    root = np.sqrt(couplings)
    cos_half, sin_half = np.cos(deltas / 2), np.sin(deltas / 2)
    p, q = sin_half / root[:-1], cos_half * root[:-1]
    r, t = cos_half / root[:-1], sin_half * root[:-1]
    start = math.sin(flap_angle / 2), math.cos(flap_angle / 2)
    # a step stretches by at most sqrt(C) or its inverse: normalise before numbers overflow
    stretch = max(float(root.max()), 1 / float(root.min()), 1.1)
    stride = max(1, int(_LOG_RANGE / math.log(stretch)))
    ahead = _walk(p[at:], q[at:], r[at:], t[at:], start, stride)
    behind = _walk(t[:at][::-1], q[:at][::-1], r[:at][::-1], p[:at][::-1], start, stride)
    s, c = np.concatenate([behind[:, ::-1], np.array(start)[:, None], ahead], axis=1)
    size = np.hypot(s, c)
    return s / size, c / size


def _walk(
    p: FloatArray,
    q: FloatArray,
    r: FloatArray,
    t: FloatArray,
    start: tuple[float, float],
    stride: int,
) -> FloatArray:
    """Images of `start` under one step after another, up to a factor each, shape (2, n).

    stride : steps between two normalisations.
    """
    s, c = start
    sines: list[float] = []
    cosines: list[float] = []
    steps = p.tolist(), q.tolist(), r.tolist(), t.tolist()
    for begin in range(0, len(p), stride):
        for a, b, d, e in zip(*(step[begin : begin + stride] for step in steps), strict=True):
            s, c = a * s + b * c, d * s - e * c
            sines.append(s)
            cosines.append(c)
        scale = 1.0 / math.hypot(s, c)
        s, c = s * scale, c * scale
    return np.array([sines, cosines])


def prefix_products(couplings: FloatArray, deltas: FloatArray) -> FloatArray:
    """Matrices M[i], shape (n, 2, 2), that take (s, c) of vertex 0 to vertex i up to a factor.

    Each product is normalised to a largest entry of one; M[0] is the identity.
    """
    size = len(couplings)
    out = np.empty((size, 2, 2))
    out[0] = np.eye(2)
    for i in range(size - 1):
        turn_c, turn_s = math.cos(deltas[i] / 2), math.sin(deltas[i] / 2)
        step = np.array([[turn_s, couplings[i] * turn_c], [turn_c, -couplings[i] * turn_s]])
        product = step @ out[i]
        out[i + 1] = product / np.abs(product).max()
    return out


def transform(matrices: FloatArray, flap_angles: FloatArray) -> FloatArray:
    """Images in [0, 2 pi) of `flap_angles` (shape (q,)) under `matrices` (shape (n, 2, 2)).

    Returns shape (n, q).
    """
    start = np.stack([np.sin(flap_angles / 2), np.cos(flap_angles / 2)])
    image = matrices @ start
    return full_turn(2 * np.arctan2(image[:, 0], image[:, 1]))
