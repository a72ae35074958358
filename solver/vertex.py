"""The single degree-4 vertex: direction and flap angle of its fourth crease.

At a front vertex the two old creases point along the unit vectors `a` (towards the previous front
vertex) and `b` (towards the next one), at the angle beta; the two old faces leave the angle
k = 2 pi - theta3 - theta4 for the two new ones.

                 r                  n = unit(a x b)    normal of the beta plane
       theta1   |   theta2          p = n x a          in the beta plane, on b's side
       a _______|_______ b          flap angle alpha: about a, from p towards n,
       theta4   |   theta3          of the new face between a and r
                 c

Source: Dudte, Choi and Mahadevan, "An additive algorithm for origami design", PNAS 118 (2021),
supplementary information S1, equation (S13).
"""

from __future__ import annotations

import numpy as np

from solver.errors import InvalidValue, require_within
from solver.vectors import BoolArray, FloatArray, cross, dot, full_turn, unit

__all__ = [
    "continuation_flap_angles",
    "design_angles",
    "even_flap_angles",
    "flap_angle_of",
    "flat_foldable_flap_angles",
    "growth_direction",
    "locked_flap_angles",
    "require_foldable",
    "self_intersects",
]

# A vertex has room to fold where its angles are this far inside their bounds, radians.
_ROOM = 2e-12


def require_foldable(beta: FloatArray, k: FloatArray) -> None:
    """Raise `InvalidValue` for the first vertex without 0 < beta < pi, beta < k < 2 pi - beta.

    beta, k : radians, shape (n,). The ends are refused with a margin of 2e-12: nearer to them the
    angles of rounded points are noise.
    """
    for i in np.flatnonzero(~((beta > _ROOM) & (beta < np.pi - _ROOM))):
        require_within(
            f"beta[{i}]",
            float(beta[i]),
            _ROOM,
            np.pi - _ROOM,
            "Front vertices must turn: move the vertex off the line through its neighbours.",
            angle=True,
        )
    for i in np.flatnonzero(~((k > beta + _ROOM) & (k < 2 * np.pi - beta - _ROOM))):
        require_within(
            f"k[{i}]",
            float(k[i]),
            float(beta[i] + _ROOM),
            float(2 * np.pi - beta[i] - _ROOM),
            "The sectors left at a vertex must leave room to fold: choose k inside, "
            "or change the front's angle beta.",
            angle=True,
        )


def design_angles(
    flap_angle: FloatArray, beta: FloatArray, k: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Design angles (theta1, theta2) of the new faces, equation (S13).

    Parameters
    ----------
    flap_angle, beta, k : radians, shapes that broadcast. Needs 0 < beta < pi and
        beta < k < 2 pi - beta (`InvalidValue` otherwise).

    Returns
    -------
    theta1 in (0, pi) between a and the new crease, theta2 = k - theta1 between it and b.

    >>> theta1, theta2 = design_angles(np.pi / 3, np.pi / 2, np.pi)
    >>> np.degrees([theta1, theta2]).round(3).tolist()
    [116.565, 63.435]
    """
    alpha, b, s = np.broadcast_arrays(
        np.asarray(flap_angle, float), np.asarray(beta, float), np.asarray(k, float)
    )
    require_foldable(b.ravel(), s.ravel())
    if not np.isfinite(alpha).all():
        wrong = alpha[~np.isfinite(alpha)][0]
        raise InvalidValue("flap_angle", wrong, "be finite", "Give an angle in radians.")
    # cos beta - cos k and sin k - sin beta cos alpha without cancellation where k nears beta
    rise = 2 * np.sin((s + b) / 2) * np.sin((s - b) / 2)
    run = 2 * np.cos((s + b) / 2) * np.sin((s - b) / 2) + 2 * np.sin(b) * np.sin(alpha / 2) ** 2
    theta1 = np.arctan2(rise, run)
    return theta1, s - theta1


def growth_direction(
    a: FloatArray, b: FloatArray, flap_angle: FloatArray, k: FloatArray
) -> FloatArray:
    """Unit direction of the new crease, shape (n, 3).

    a, b : unit directions of the old creases, shape (n, 3); flap_angle, k : radians, shape (n,).
    Raises `InvalidValue` where beta or k leave their interval.

    Two creases at a right angle that leave k = pi to a flap which stands upright on them:

    >>> a, b = np.array([[1.0, 0.0, 0.0]]), np.array([[0.0, 1.0, 0.0]])
    >>> upright = growth_direction(a, b, np.array([np.pi / 2]), np.array([np.pi]))
    >>> np.allclose(upright, [[0.0, 0.0, 1.0]], atol=1e-15)
    True
    >>> flap_angle_of(a, b, upright).round(6)
    array([1.570796])
    """
    ab = cross(a, b)
    beta = np.arctan2(np.sqrt(dot(ab, ab)), dot(a, b))
    theta1, _ = design_angles(flap_angle, beta, k)
    n = unit(ab)
    p = cross(n, a)
    return (
        np.cos(theta1)[..., None] * a
        + (np.sin(theta1) * np.cos(flap_angle))[..., None] * p
        + (np.sin(theta1) * np.sin(flap_angle))[..., None] * n
    )


def flap_angle_of(a: FloatArray, b: FloatArray, direction: FloatArray) -> FloatArray:
    """Flap angle in [0, 2 pi) of the face between `a` and `direction`, inverse of (S13).

    a, b, direction : shape (n, 3), `a` and `b` not parallel; lengths do not matter.
    """
    n = unit(cross(a, b))
    p = cross(n, unit(a))
    return full_turn(np.arctan2(dot(direction, n), dot(direction, p)))


def even_flap_angles(beta: FloatArray, k: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Flap angles that give the two new sectors equal angles k/2 (S2), on both sides.

    The new crease is then over the bisector of the front: cos alpha = tan(beta/2) / tan(k/2).
    beta, k : radians, shape (n,). Radians in [0, 2 pi); the two are mirror images about the beta
    plane.

    >>> first, second = even_flap_angles(np.array([1.2]), np.array([3.0]))
    >>> theta1, theta2 = design_angles(first, np.array([1.2]), np.array([3.0]))
    >>> np.allclose([theta1, theta2], 1.5)
    True
    """
    over = np.arccos(np.tan(beta / 2) / np.tan(k / 2))
    return over, 2 * np.pi - over


def flat_foldable_flap_angles(
    a: FloatArray, b: FloatArray, c: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Flap angles that make opposite sectors add up to pi (S2), on both sides of the beta plane.

    a, b, c : unit directions of the old creases, shape (n, 3). Then theta1 = pi - theta3 and
    theta2 = pi - theta4, and the vertex can fold flat. Radians in [0, 2 pi); NaN where no flap
    angle does it. From (S13) with theta1 known: the spherical triangle a, b, r has sides beta,
    theta1 and theta2.
    """
    ab = cross(a, b)
    sin_beta, cos_beta = np.sqrt(dot(ab, ab)), dot(a, b)
    bc = cross(b, c)
    cos1, sin1, cos2 = -dot(b, c), np.sqrt(dot(bc, bc)), -dot(a, c)
    with np.errstate(invalid="ignore", divide="ignore"):
        over = np.arccos((cos2 - cos1 * cos_beta) / (sin1 * sin_beta))
    return over, full_turn(2 * np.pi - over)


def continuation_flap_angles(
    a: FloatArray, b: FloatArray, c: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Flap angles of the crease that continues c straight on, and of its mirror image (S2).

    The continuation, r = -c, leaves both front creases unfolded; its reflection about the beta
    plane folds them alike. Both always exist. a, b, c : unit directions of the old creases, shape
    (n, 3). Radians in [0, 2 pi), shape (n,).
    """
    straight = flap_angle_of(a, b, -c)
    return straight, full_turn(2 * np.pi - straight)


def locked_flap_angles(
    a: FloatArray, b: FloatArray, c: FloatArray, couplings: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Flap angles that lay a new face onto the old one beside it (S2): locked left and right.

    a, b, c : unit directions of the old creases, shape (n, 3); couplings : see
    `solver.transfer.coupling`, shape (n,). Both in [0, 2 pi), and both in (0, pi) or both in
    (pi, 2 pi): on c's side of the beta plane.
    """
    left = flap_angle_of(a, b, c)
    n = unit(cross(a, b))
    right_flap = np.arctan2(dot(c, n), dot(c, cross(b, n)))  # about b, of the old right face
    right = 2 * np.arctan2(couplings * np.cos(right_flap / 2), np.sin(right_flap / 2))
    return left, full_turn(right)


def self_intersects(flap_angle: FloatArray, left: FloatArray, right: FloatArray) -> BoolArray:
    """Whether the new faces cross the old ones at the vertex (S2 B), shape (n,).

    New creases on the other side of the beta plane than the old crease c never cross. On c's side
    the two pairs of faces are nested, and free, between the two locked flap angles; elsewhere they
    cross. All in radians; left, right : of `locked_flap_angles`. Shapes broadcast.
    """
    alpha = full_turn(flap_angle)
    same_side = (alpha < np.pi) == (left < np.pi)
    between = (alpha > np.minimum(left, right)) & (alpha < np.maximum(left, right))
    out: BoolArray = same_side & ~between
    return out
