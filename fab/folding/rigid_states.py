"""Which folded state near to one with bent faces has all of them flat?"""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array, csc_array

from fab.folding.bar_hinge_model import Framework, hinge_angles
from fab.folding.folding_path import Closure
from fab.folding.quasi_static import damped
from fab.folding.rotation_predictor import Turner
from solver.vectors import FloatArray, IntArray

__all__ = ["rigid_coords"]

_STEPS = 20
_CLOSED_RAD = 1e-12
# Rounding ends the search.
_NEARLY_RAD = 1e-9
# Redundant vertices leave singular systems: as much is added, over the mean of the diagonal.
_DAMPING = 1e-12
# No hinge turns by more, over all steps: beyond, the state is another one.
_FARTHEST_RAD = np.radians(15.0)


def rigid_coords(
    frame: Framework, closure: Closure, turning: Turner, coords: FloatArray
) -> FloatArray | None:
    """Vertices, shape (nv, 3), over the framework's size, where the turns around all vertices
    close with no face bent; None where there is no such state nearby.

    Newton's method on the angles of the creases, each step the shortest that closes to first order
    (belcastro and Hull 2002 for what closes). Holes are not closed.
    """
    creases = np.flatnonzero(frame.hinges_edge >= 0)
    place = np.full(len(frame.hinges_edge), -1)
    place[creases] = np.arange(len(creases))
    begin = np.where(place >= 0, hinge_angles(coords, frame.hinges_vertices), 0.0)
    angles = begin.copy()
    if not len(closure.hinges):
        return turning.coords(angles)
    before = np.inf
    for _ in range(_STEPS):
        missed, slopes = closure.errors(angles[None])
        worst = float(np.abs(missed).max(initial=0.0))
        if worst <= _CLOSED_RAD or (worst <= _NEARLY_RAD and worst >= before):
            return turning.coords(angles)
        before = worst
        jacobian = _jacobian(closure.hinges, slopes[0], place)
        normal = (jacobian @ jacobian.T).tocsc()
        angles[creases] -= jacobian.T @ damped(normal, _DAMPING).solve(missed.ravel())
        if not np.abs(angles - begin).max() <= _FARTHEST_RAD:
            return None
    return None


def _jacobian(hinges: IntArray, slopes: FloatArray, place: IntArray) -> csc_array:
    """Of the errors around all vertices by the angles of the creases, shape (3 m, k)."""
    columns = np.broadcast_to(place[hinges][:, :, None], slopes.shape)
    rows = 3 * np.arange(len(hinges))[:, None, None] + np.arange(3)
    rows = np.broadcast_to(rows, slopes.shape)
    own = (columns >= 0) & (slopes != 0)
    shape = (3 * len(hinges), int(place.max(initial=-1)) + 1)
    return coo_array((slopes[own], (rows[own], columns[own])), shape=shape).tocsc()
