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
    size = len(couplings)
    c_list = couplings.tolist()
    cos_list = np.cos(deltas / 2).tolist()
    sin_list = np.sin(deltas / 2).tolist()
    sines = [0.0] * size
    cosines = [0.0] * size
    hypot = math.hypot
    sines[at] = s = math.sin(flap_angle / 2)
    cosines[at] = c = math.cos(flap_angle / 2)
    for i in range(at, size - 1):
        s, c = c_list[i] * c, s
        turn_c, turn_s = cos_list[i], sin_list[i]
        s, c = s * turn_c + c * turn_s, c * turn_c - s * turn_s
        scale = 1.0 / hypot(s, c)
        sines[i + 1] = s = s * scale
        cosines[i + 1] = c = c * scale
    s, c = sines[at], cosines[at]
    for i in range(at - 1, -1, -1):
        turn_c, turn_s = cos_list[i], sin_list[i]
        s, c = s * turn_c - c * turn_s, c * turn_c + s * turn_s
        s, c = c_list[i] * c, s
        scale = 1.0 / hypot(s, c)
        sines[i] = s = s * scale
        cosines[i] = c = c * scale
    return np.array(sines), np.array(cosines)


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
