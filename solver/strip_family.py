"""The family of strips on one front: what one flap angle decides at all of its vertices.

One flap angle decides those of all vertices (S44 to S49, see `solver.transfer`), and with them the
creases, sectors and folds of the whole strip. This is the strip as a function of it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from solver.errors import require_count
from solver.front import Front
from solver.transfer import inverse_matrices, transfer_each, transfer_flap_angles
from solver.vectors import FloatArray, cross, unit
from solver.vertex import design_angles
from solver.vertex_family import fold_angle, special_flap_angles

__all__ = ["StripFamily", "special_at_first", "strip_family"]


@dataclass(frozen=True)
class StripFamily:
    """A strip of m quads at q flap angles, in radians. Arrays are read-only.

    Attributes
    ----------
    flap_angles : at front vertex 1, shape (q,).
    vertices_flap_angle : at every interior vertex, in [0, 2 pi), shape (m - 1, q).
    theta1, theta2 : design angles there, shape (m - 1, q).
    directions : of the new creases there, unit vectors, shape (m - 1, q, 3).
    front_folds : fold angles of the front's edges, shape (m, q), valleys positive; NaN where the
        front is a curve, without faces behind it.
    crease_folds : fold angles of the new creases at interior vertices, shape (m - 1, q).
    crossing : flap angles for which new faces cross old ones, two arcs for each vertex that has
        faces behind it (`Front.crossing_flap_angles`).
    free : what all of these leave, shape (k, 2).
    """

    flap_angles: FloatArray
    vertices_flap_angle: FloatArray
    theta1: FloatArray
    theta2: FloatArray
    directions: FloatArray
    front_folds: FloatArray
    crease_folds: FloatArray
    crossing: FloatArray
    free: FloatArray

    def __post_init__(self) -> None:
        for array in vars(self).values():
            array.flags.writeable = False


def strip_family(front: Front, flap_angles: FloatArray | int = 360) -> StripFamily:
    """The strips that an open front can grow, at many flap angles.

    flap_angles : at front vertex 1, radians, shape (q,), or how many, evenly around the circle.

    >>> from solver.designs import Miura
    >>> from solver.mesh import Side
    >>> family = strip_family(Front.of(Miura(columns=4, rows=2).grow().mesh, Side.TOP), 6)
    >>> family.front_folds.shape, family.crease_folds.shape
    ((4, 6), (3, 6))
    """
    if isinstance(flap_angles, int):
        require_count("flap_angles", flap_angles, 1, "Give at least one.")
        trials = 2 * np.pi * np.arange(flap_angles) / flap_angles
    else:
        trials = np.asarray(flap_angles, np.float64)
    flaps = transfer_flap_angles(front.transfer_matrices, trials)
    theta1, theta2 = design_angles(flaps, front.beta[:, None], front.k[:, None])
    a = -front.edges_direction[:-1]
    along, across, up = (axis[:, None] for axis in (a, front.inner, front.normals))
    directions = (
        np.cos(theta1)[..., None] * along
        + (np.sin(theta1) * np.cos(flaps))[..., None] * across
        + (np.sin(theta1) * np.sin(flaps))[..., None] * up
    )
    edges = front.edges_direction[:, None]
    beside = np.concatenate([directions[:1], directions])  # a crease in the plane of each face
    new = unit(cross(np.broadcast_to(edges, beside.shape), beside))
    creases = fold_angle(directions, new[:-1], new[1:])
    if front.back is None:
        folds = np.full(new.shape[:2], np.nan)
    else:
        behind = np.concatenate([front.back[:1], front.back])
        old = unit(cross(behind, front.edges_direction))[:, None]
        folds = fold_angle(edges, new, old)
    return StripFamily(
        *(trials, flaps, theta1, theta2, directions, folds, creases),
        front.crossing_flap_angles(),
        front.free_flap_angles(),
    )


def special_at_first(front: Front) -> dict[str, FloatArray]:
    """The choices of S2 at every interior vertex, as flap angles at vertex 1, by name.

    Radians in [0, 2 pi), each array of shape (m - 1, n): n choices of this name at each vertex, NaN
    where it has none.
    """
    matrices = inverse_matrices(front.transfer_matrices)
    return {
        name: transfer_each(matrices, np.column_stack(angles))
        for name, angles in special_flap_angles(front).items()
    }
