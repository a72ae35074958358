"""Rigid folded states, with all faces flat, near to simulated ones that bend them."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array, csc_array

from fab.folding.bar_hinge_model import Framework
from fab.folding.damped import DampedSystems
from fab.folding.folding_path import Closure
from fab.folding.rotation_predictor import RotationPredictor
from solver.hinge_angles import hinge_angles
from solver.vectors import FloatArray, IntArray

__all__ = ["crease_jacobian", "rigid_coords", "rigid_coords_at"]

_STEPS = 20
_CLOSED_RAD = 1e-12
# Below this, an error that no longer falls is rounding.
_NEARLY_RAD = 1e-9
# Redundant vertices leave singular systems: added to the diagonal, relative to its mean.
_DAMPING = 1e-12
# A state in which a hinge has turned by more, over all steps, is not nearby.
_FARTHEST_RAD = np.radians(15.0)


def rigid_coords(
    frame: Framework, closure: Closure, predictor: RotationPredictor, coords: FloatArray
) -> FloatArray | None:
    """The vertices of a rigid state near to `coords`; None where no such state is nearby.

    Both have shape (nv, 3), relative to the framework's size. All vertices close and no face is
    bent; holes need not close. closure, predictor : of the framework, by `hinges_around` and
    `rotation_predictor`.
    """
    turned = hinge_angles(coords, frame.hinges_vertices)
    return rigid_coords_at(frame, closure, predictor, np.where(frame.hinges_edge >= 0, turned, 0.0))


def rigid_coords_at(
    frame: Framework, closure: Closure, predictor: RotationPredictor, begin: FloatArray
) -> FloatArray | None:
    """The same near to angles of all hinges, radians, shape (nh,), 0 for those within faces.

    Newton's method on the angles of the creases, each step the shortest that closes to first order;
    for the condition see belcastro and Hull (2002).
    """
    creases = np.flatnonzero(frame.hinges_edge >= 0)
    column = np.full(len(frame.hinges_edge), -1)
    column[creases] = np.arange(len(creases))
    angles = begin.copy()
    if not len(closure.hinges):
        return predictor.coords(angles)
    before, systems = np.inf, DampedSystems()
    for _ in range(_STEPS):
        missed, slopes = closure.errors(angles[None])
        worst = float(np.abs(missed).max(initial=0.0))
        if worst <= _CLOSED_RAD or (worst <= _NEARLY_RAD and worst >= before):
            return predictor.coords(angles)
        before = worst
        jacobian = crease_jacobian(closure.hinges, slopes[0], column)
        normal = (jacobian @ jacobian.T).tocsc()
        angles[creases] -= jacobian.T @ systems.factorised(normal, _DAMPING)(missed.ravel())
        if not np.abs(angles - begin).max() <= _FARTHEST_RAD:
            return None
    return None


def crease_jacobian(hinges: IntArray, slopes: FloatArray, column: IntArray) -> csc_array:
    """Of the errors around all vertices by the angles of the k creases, shape (3 m, k).

    column : shape (nh,), that of each hinge, -1 for facet creases.
    """
    columns = np.broadcast_to(column[hinges][:, :, None], slopes.shape)
    rows = 3 * np.arange(len(hinges))[:, None, None] + np.arange(3)
    rows = np.broadcast_to(rows, slopes.shape)
    own = (columns >= 0) & (slopes != 0)
    shape = (3 * len(hinges), int(column.max(initial=-1)) + 1)
    return coo_array((slopes[own], (rows[own], columns[own])), shape=shape).tocsc()
