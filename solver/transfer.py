"""The flap-angle chain of a strip: how one flap angle decides all others.

In half-angle tangents the flap-angle map of a vertex is a Moebius transformation (the half-angle
form of equations S44 to S49 of the supplementary information): with alpha' the flap angle of the
face right of the new crease,

    tan(alpha/2) tan(alpha'/2) = C = sin((k - beta)/2) / sin((k + beta)/2)  > 0
    alpha[i+1] = alpha'[i] + delta[i]

so that with (s, c) = (sin, cos)(alpha/2) one vertex costs a swap, a scale and a rotation:

    (s, c) -> rotate((C c, s), delta/2)

`half_angles` walks that chain vertex after vertex, which keeps every new quad planar to rounding.
`transfer_matrices` gives all flap angles at once as functions of the first: for searching. Three
vertices with C = 1, at which alpha' = pi - alpha:

>>> couplings, deltas = np.ones(3), np.array([0.3, -0.1])
>>> s, c = half_angles(couplings, deltas, 1.0)
>>> (2 * np.arctan2(s, c)).round(4).tolist()
[1.0, 2.4416, 0.6]
>>> matrices = transfer_matrices(couplings, deltas)
>>> transfer_flap_angles(matrices, np.array([1.0, 2.0])).round(4).tolist()
[[1.0, 2.0], [2.4416, 1.4416], [0.6, 1.6]]
>>> transfer_derivative(matrices, np.array([1.0]))[:, 0].round(4).tolist()
[1.0, -1.0, 1.0]
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from solver.vectors import FloatArray, full_turn

__all__ = [
    "Closing",
    "Closings",
    "coupling",
    "half_angles",
    "inverse_matrices",
    "loop_closings",
    "loop_miss",
    "loop_misses",
    "transfer_derivative",
    "transfer_each",
    "transfer_flap_angles",
    "transfer_matrices",
]

# A chain is normalised before the logarithm of its length can have changed by more than this.
_LOG_RANGE = 300.0

# A loop matrix this near to a multiple of the identity, times its vertices, is one: all close.
_SAME = 1e-12
# Two roots nearer to each other than this are one: rounding alone parts a double root that far.
_DOUBLE = 1e-6


def coupling(beta: FloatArray, k: FloatArray) -> FloatArray:
    """The constant C of each vertex, shape (n,); beta, k : radians, 0 < beta < k < 2 pi - beta."""
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


def transfer_matrices(couplings: FloatArray, deltas: FloatArray) -> FloatArray:
    """Matrices M[i], shape (n, 2, 2), that take (s, c) of vertex 0 to vertex i up to a factor.

    Each product is normalised to a largest entry of one; M[0] is the identity.
    """
    turn_s, turn_c = np.sin(deltas / 2), np.cos(deltas / 2)
    scale = couplings[:-1]
    out = np.empty((len(couplings), 2, 2))
    out[0] = np.eye(2)
    out[1:, 0, 0], out[1:, 0, 1] = turn_s, scale * turn_c
    out[1:, 1, 0], out[1:, 1, 1] = turn_c, -scale * turn_s
    reach = 1
    while reach < len(out):  # each matrix is a product of `reach` steps; double it
        product = out[reach:] @ out[:-reach]
        out[reach:] = product / np.abs(product).max(axis=(1, 2), keepdims=True)
        reach *= 2
    return out


def transfer_flap_angles(matrices: FloatArray, flap_angles: FloatArray) -> FloatArray:
    """Flap angles in [0, 2 pi) at every vertex for q candidates of the first, shape (n, q).

    matrices : of `transfer_matrices`, shape (n, 2, 2); flap_angles : radians, shape (q,).
    """
    start = np.stack([np.sin(flap_angles / 2), np.cos(flap_angles / 2)])
    image = matrices @ start
    return full_turn(2 * np.arctan2(image[:, 0], image[:, 1]))


def inverse_matrices(matrices: FloatArray) -> FloatArray:
    """Matrices of the inverse maps, up to a factor (the adjugates), shape (n, 2, 2).

    They take a flap angle at any location of a strip back to the first one (S1 A.4).
    """
    out = np.empty_like(matrices)
    out[:, 0, 0], out[:, 1, 1] = matrices[:, 1, 1], matrices[:, 0, 0]
    out[:, 0, 1], out[:, 1, 0] = -matrices[:, 0, 1], -matrices[:, 1, 0]
    return out


def transfer_each(matrices: FloatArray, flap_angles: FloatArray) -> FloatArray:
    """Images of row i of `flap_angles`, shape (n, q), under matrix i of (n, 2, 2); shape (n, q)."""
    start = np.stack([np.sin(flap_angles / 2), np.cos(flap_angles / 2)], axis=1)
    image = matrices @ start
    return full_turn(2 * np.arctan2(image[:, 0], image[:, 1]))


def transfer_derivative(matrices: FloatArray, flap_angles: FloatArray) -> FloatArray:
    """Exact derivatives of `transfer_flap_angles` by the first flap angle, shape (n, q).

    A Moebius map of half-angles turns by its determinant over the squared length of the image.
    """
    start = np.stack([np.sin(flap_angles / 2), np.cos(flap_angles / 2)])
    image = matrices @ start
    determinant = np.linalg.det(matrices)
    out: FloatArray = determinant[:, None] / (image[:, 0] ** 2 + image[:, 1] ** 2)
    return out


class Closing(StrEnum):
    """How a closed front can close again; its loop matrix alone decides."""

    PAIR = "pair"
    CONTINUATION = "continuation"
    FAMILY = "family"
    NONE = "none"


@dataclass(frozen=True)
class Closings:
    """The flap angles for which a loop closes.

    Attributes
    ----------
    case : PAIR, two of them; CONTINUATION, a double root; FAMILY, every flap angle; NONE.
    flap_angles : at vertex 0, radians in [0, 2 pi), the continuation first where it is known and
        in rising order elsewhere; empty for FAMILY and NONE.
    start : for each of them the vertex to begin the chain at, and the flap angle there: vertex 0,
        or the last one where walking forwards spreads errors (backwards it contracts them).
    separation : angle between the two roots on the circle, radians (0 for a double root).
    """

    case: Closing
    flap_angles: FloatArray
    start: tuple[tuple[int, float], ...]
    separation: float


def loop_closings(
    couplings: FloatArray, deltas: FloatArray, continuation: float | None = None
) -> Closings:
    """Fixed points of the flap-angle map once around a loop (S1 B.2), without search.

    Parameters
    ----------
    couplings : of all N vertices; deltas : to the next vertex, the last one back to vertex 0, (N,).
    continuation : flap angle at vertex 0 that continues the faces behind the front: always a fixed
        point, and the other one follows from it without cancellation. None where the front is a
        curve: then the quadratic is solved.

    An odd loop closes for two flap angles:

    >>> closings = loop_closings(np.ones(3), np.zeros(3))
    >>> closings.case, np.degrees(closings.flap_angles).round(9).tolist()
    (<Closing.PAIR: 'pair'>, [90.0, 270.0])
    """
    loop = _loop_matrix(couplings, deltas)
    size = float(np.abs(loop).max())
    # before roots are looked for: rounding makes those of a matrix this near complex
    if np.abs(loop - np.trace(loop) / 2 * np.eye(2)).max() <= _SAME * size * len(couplings):
        return Closings(Closing.FAMILY, np.empty(0), (), math.nan)
    if continuation is None:
        first = _fixed_direction(loop)
        if first is None:
            return Closings(Closing.NONE, np.empty(0), (), math.nan)
    else:
        first = np.array([math.sin(continuation / 2), math.cos(continuation / 2)])
    # for a 2x2 matrix with the eigenvector v1, the columns of P - lambda1 I are along the other one
    rest = loop - (first @ loop @ first) * np.eye(2)
    column = rest[:, int(np.argmax(np.abs(rest).max(axis=0)))]
    second = column / math.hypot(*column)
    separation = 2 * math.asin(min(1.0, abs(float(first[0] * second[1] - first[1] * second[0]))))
    case, roots = Closing.PAIR, [first, second]
    if separation <= _DOUBLE:
        case, roots = Closing.CONTINUATION, [first]
    if continuation is None:
        roots.sort(key=lambda root: float(root[1] * np.sign(root[0])), reverse=True)  # by angle
    angles = full_turn(2 * np.arctan2(*np.array(roots).T))
    starts = []
    for root, angle in zip(roots, angles.tolist(), strict=True):
        value = float(root @ loop @ root)
        # the map once around contracts near the direction of the larger eigenvalue
        if abs(value) >= abs(float(np.trace(loop)) - value):
            starts.append((0, angle))
        else:
            before = _before(angle, couplings[-1], deltas[-1])
            starts.append((len(couplings) - 1, before % (2 * math.pi)))
    return Closings(case, angles, tuple(starts), separation)


def _after(flap_angle: float, constant: float, delta: float) -> float:
    """Flap angle of the vertex after one with `flap_angle`: one step forwards, radians."""
    half = flap_angle / 2
    return 2 * math.atan2(constant * math.cos(half), math.sin(half)) + delta


def _before(flap_angle: float, constant: float, delta: float) -> float:
    """Flap angle of the vertex before one with `flap_angle`: one step backwards, radians."""
    back = (flap_angle - delta) / 2
    return 2 * math.atan2(constant * math.cos(back), math.sin(back))


def loop_miss(
    couplings: FloatArray, closing_delta: float, s: FloatArray, c: FloatArray
) -> tuple[float, FloatArray]:
    """By how much a loop misses its first flap angle, and what all deltas must change by.

    closing_delta : from the last vertex back to the first; s, c : of the chain that was walked.

    Returns
    -------
    miss : flap angle after once around minus that at vertex 0, radians in [-pi, pi].
    spread : the change of every delta that makes up for it, to first order, all of one size and
        signed so that they add up (the closing delta keeps its own share), shape (N - 1,).
    """
    reached = float(2 * np.arctan2(s[-1], c[-1]))
    first = float(2 * np.arctan2(s[0], c[0]))
    miss = math.remainder(_after(reached, couplings[-1], closing_delta) - first, 2 * math.pi)
    # slope of each step, and of all steps from behind each one to the end of the loop
    slopes = -couplings / ((couplings * c) ** 2 + s * s)
    with np.errstate(over="ignore"):  # changes too small for floats make up for the miss there
        ahead = np.cumprod(slopes[:0:-1])[::-1]
        total = float(np.abs(ahead).sum()) + 1.0
    spread: FloatArray = -miss * np.sign(ahead) / total
    return miss, spread


def loop_misses(couplings: FloatArray, deltas: FloatArray, flap_angles: FloatArray) -> FloatArray:
    """By how much a loop misses each first flap angle after once around, shape (q,).

    couplings, deltas : as for `loop_closings`; flap_angles : radians, shape (q,). Radians in
    (-pi, pi], 0 where the loop closes: those are the fixed points of `loop_closings`.

    >>> loop_misses(np.ones(3), np.zeros(3), np.radians([90.0, 100.0])).round(6).tolist()
    [0.0, -0.349066]
    """
    start = np.stack([np.sin(flap_angles / 2), np.cos(flap_angles / 2)])
    sine, cosine = _loop_matrix(couplings, deltas) @ start
    turned = 2 * np.arctan2(sine, cosine) - flap_angles
    out: FloatArray = -np.remainder(-turned + np.pi, 2 * np.pi) + np.pi
    return out


def _loop_matrix(couplings: FloatArray, deltas: FloatArray) -> FloatArray:
    """Product of all steps, each of determinant -1, over its largest entry, shape (2, 2)."""
    product = np.eye(2)
    root = np.sqrt(couplings)
    cos_half, sin_half = np.cos(deltas / 2), np.sin(deltas / 2)
    steps = np.stack(
        [sin_half / root, cos_half * root, cos_half / root, -sin_half * root], axis=1
    ).reshape(-1, 2, 2)
    for step in steps:
        product = step @ product
        product /= np.abs(product).max()
    return product


def _fixed_direction(loop: FloatArray) -> FloatArray | None:
    """An eigenvector; None where both eigenvalues are complex."""
    (a, b), (c, d) = loop.tolist()
    half = (a - d) / 2
    root = half * half + b * c
    if root < 0:
        return None
    swing = abs(half) + math.sqrt(root)  # no cancellation
    if swing == 0:
        return np.array([1.0, 0.0] if abs(b) >= abs(c) else [0.0, 1.0])
    vector = np.array([swing, c] if half >= 0 else [b, swing])
    unit: FloatArray = vector / np.hypot(*vector)
    return unit
