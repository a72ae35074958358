"""The family of fourth creases of one vertex: what its flap angle decides, all around the circle.

As the flap angle turns, the new crease runs along a closed curve of the unit sphere: the arcs from
it to the two old creases a and b add up to k, so the curve is a spherical ellipse around both (S1).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from solver.arcs import united
from solver.errors import InvalidValue, require_count
from solver.front import Front
from solver.vectors import FloatArray, cross, dot, full_turn, norm, points, unit
from solver.vertex import (
    continuation_flap_angles,
    design_angles,
    even_flap_angles,
    flat_foldable_flap_angles,
    growth_direction,
    locked_flap_angles,
)

__all__ = ["SPECIAL", "VertexFamily", "fold_angle", "special_flap_angles", "vertex_family"]

# The choices of S2 by name.
SPECIAL = (
    "continuation",
    "reflection",
    "flat-foldable",
    "equal angles",
    "locked left",
    "locked right",
)


@dataclass(frozen=True)
class VertexFamily:
    """One vertex at q flap angles. Arrays are read-only.

    Attributes
    ----------
    a, b, c : unit vectors along the old creases, shape (3,): to the previous front vertex, to the
        next one, and back between the old faces.
    beta, k : angle between a and b, and the angle left for the new faces, radians.
    flap_angles : radians, shape (q,).
    directions : of the new crease, shape (q, 3): the curve on the sphere.
    theta1, theta2 : design angles of the new faces, which add up to k, radians, shape (q,).
    fold_angles : of the creases a, b, c and the new one, in this order, radians in (-pi, pi],
        valleys positive, shape (4, q).
    special : flap angles of the choices of S2 by name (`SPECIAL`); only those that exist.
    crossing : flap angles for which new faces cross old ones (S2 B), as disjoint arcs, (n, 2).
    """

    a: FloatArray
    b: FloatArray
    c: FloatArray
    beta: float
    k: float
    flap_angles: FloatArray
    directions: FloatArray
    theta1: FloatArray
    theta2: FloatArray
    fold_angles: FloatArray
    special: Mapping[str, tuple[float, ...]]
    crossing: FloatArray

    def __post_init__(self) -> None:
        for array in vars(self).values():
            if isinstance(array, np.ndarray):
                array.flags.writeable = False


def vertex_family(
    a: FloatArray, b: FloatArray, c: FloatArray, flap_angles: FloatArray | int = 360
) -> VertexFamily:
    """A vertex of three old creases at all flap angles.

    Parameters
    ----------
    a, b, c : directions of the old creases, shape (3,), of any length; a and b are on the front.
    flap_angles : radians, shape (q,), or how many, evenly around the circle.

    Raises `InvalidValue` where a and b are parallel, or k leaves (beta, 2 pi - beta).

    >>> family = vertex_family([-1, 0, 0.4], [1, 0.2, 0.4], [0, -1, 0], 8)
    >>> np.allclose(family.theta1 + family.theta2, family.k)
    True
    >>> len(family.special["continuation"]), len(family.special["locked left"])
    (1, 1)
    """
    if isinstance(flap_angles, int):
        require_count("flap_angles", flap_angles, 1, "Give at least one.")
        trials = 2 * np.pi * np.arange(flap_angles) / flap_angles
    else:
        trials = np.asarray(flap_angles, np.float64)
    a, b, c = (points(name, [u]) for name, u in (("a", a), ("b", b), ("c", c)))
    for name, u in (("a", a), ("b", b), ("c", c)):
        if not norm(u)[0] > 0:
            raise InvalidValue(name, "zero", "have a length", "Give the direction of a crease.")
    a, b, c = unit(a), unit(b), unit(c)
    front = Front.between(np.concatenate([a, 0 * a, b]), np.concatenate([a + c, c, b + c]))
    spread = np.ones((len(trials), 1))
    directions = growth_direction(a * spread, b * spread, trials, np.full(len(trials), front.k[0]))
    theta1, theta2 = design_angles(trials, front.beta[0], front.k[0])
    normals = {
        "left": unit(cross(directions, a)),
        "right": unit(cross(b, directions)),
        "old right": unit(cross(c, b)),
        "old left": unit(cross(a, c)),
    }
    folds = [
        fold_angle(a, normals["old left"], normals["left"]),
        fold_angle(b, normals["right"], normals["old right"]),
        fold_angle(c, normals["old right"], normals["old left"]),
        fold_angle(directions, normals["left"], normals["right"]),
    ]
    special = {
        name: tuple(sorted({float(each[0]) for each in angles if np.isfinite(each[0])}))
        for name, angles in special_flap_angles(front).items()
    }
    return VertexFamily(
        *(a[0], b[0], c[0], float(front.beta[0]), float(front.k[0])),
        *(trials, directions, theta1, theta2),
        np.stack([np.broadcast_to(fold, len(trials)) for fold in folds]),
        {name: angles for name, angles in special.items() if angles},
        united(front.crossing_flap_angles()),
    )


def special_flap_angles(front: Front) -> dict[str, tuple[FloatArray, ...]]:
    """The choices of S2 at every interior vertex of a front with faces behind it, by name.

    Radians in [0, 2 pi), each array of shape (m - 1,), NaN where a vertex has none.
    """
    if front.back is None:
        return {"equal angles": even_flap_angles(front.beta, front.k)}
    a, b, c = -front.edges_direction[:-1], front.edges_direction[1:], front.back
    straight, mirrored = continuation_flap_angles(a, b, c)
    left, right = locked_flap_angles(a, b, c, front.couplings)
    return {
        "continuation": (straight,),
        "reflection": (mirrored,),
        "flat-foldable": flat_foldable_flap_angles(a, b, c),
        "equal angles": tuple(full_turn(each) for each in even_flap_angles(front.beta, front.k)),
        "locked left": (left,),
        "locked right": (right,),
    }


def fold_angle(along: FloatArray, left: FloatArray, right: FloatArray) -> FloatArray:
    """Fold angle of creases between the faces on their left and right, radians, valleys positive.

    along : directions of the creases, seen from which the unit normals left and right are those of
        the faces beside them on the sheet's upper side; shapes that broadcast, (..., 3).
    """
    u = unit(along)
    out: FloatArray = np.arctan2(dot(cross(right, left), u), dot(left, right))
    return out
