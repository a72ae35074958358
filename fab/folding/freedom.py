"""Degrees of freedom of a state with rigid faces: how many ways it moves in, to first order.

They are the null directions of the derivatives of all closures. Around a flat vertex, and around
one that is folded flat, the first order counts too many (all axes are in one plane); between these
two states it counts the motions that there are, or those that go no further.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csc_array

from fab.folding.damped import DampedSystems
from solver.vectors import BoolArray, FloatArray

__all__ = ["Freedom", "freedom_of"]

# Singular values below this, of vertices with axes of length one, are 0: those of states that close
# to 1e-13 and move are below 1e-12, those of sheets that lock above 1e-6 (measured).
_NULL = 1e-9
# Up to so many creases the whole matrix is decomposed.
_DENSE = 300
# Of larger ones, this many of the smallest singular values, and more where all are 0.
_FEW, _MOST = 8, 64
# Rounds of inverse iteration, and the damping of its matrix, relative to its mean diagonal.
_ROUNDS = 4
_DAMPING = 1e-13
# A crease that moves by a smaller share of a motion stands still.
_STILL = 1e-9


@dataclass(frozen=True)
class Freedom:
    """Ways in which a state moves.

    Attributes
    ----------
    count : degrees of freedom; exact : whether there are no more of them.
    moving : the creases that move, shape (k,).
    least_locked : about the smallest singular value that is not 0; 0 where there is none.
    """

    count: int
    exact: bool
    moving: BoolArray
    least_locked: float


def freedom_of(jacobian: csc_array) -> Freedom:
    """That of a state with these derivatives of its closures by k creases, shape (3 m, k)."""
    rows, creases = jacobian.shape
    if not rows or not jacobian.nnz:
        return Freedom(creases, True, np.ones(creases, bool), 0.0)
    if creases <= _DENSE:
        padded = np.zeros((max(rows, creases), creases))
        padded[:rows] = jacobian.toarray()
        _, values, basis = np.linalg.svd(padded, full_matrices=False)
        return _freedom(values, basis.T, exact=True)
    few = _FEW
    while True:
        values, basis = _smallest(jacobian, few)
        if values.max() > _NULL or few == _MOST:
            break
        few = min(2 * few, _MOST)
    return _freedom(values, basis, exact=bool(values.max() > _NULL))


def _smallest(jacobian: csc_array, few: int) -> tuple[FloatArray, FloatArray]:
    """The smallest singular values, shape (few,), and their directions, (k, few)."""
    # inverse iteration on the normal equations; the values are those of the matrix itself, so that
    # their squares may be less than rounding
    solve = DampedSystems().factorised((jacobian.T @ jacobian).tocsc(), _DAMPING)
    basis = np.random.default_rng(0).standard_normal((jacobian.shape[1], few))
    for _ in range(_ROUNDS):
        basis, _ = np.linalg.qr(solve(basis))
    _, values, turn = np.linalg.svd(jacobian @ basis, full_matrices=False)
    return np.asarray(values), np.asarray(basis @ turn.T)


def _freedom(values: FloatArray, basis: FloatArray, *, exact: bool) -> Freedom:
    null = values <= _NULL
    size = np.linalg.norm(basis[:, null], axis=1)
    locked = values[~null]
    return Freedom(
        int(null.sum()),
        exact,
        np.asarray(size > _STILL * size.max(initial=0.0)),
        float(locked.min(initial=np.inf)) if len(locked) else 0.0,
    )
