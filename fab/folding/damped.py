"""Damped symmetric systems whose matrices are products of sparse ones, such as J J'."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.sparse import csc_array, tril
from scipy.sparse.linalg import splu

from solver.sparse import SymmetricSystem, Triangle
from solver.vectors import FloatArray

__all__ = ["DampedSystems"]

# Up to so many unknowns SuperLU is as fast.
_SMALL = 3000

Solve = Callable[[FloatArray], FloatArray]


class DampedSystems:
    """Systems one after another, whose sparsity is analysed again only where it changes.

    >>> systems = DampedSystems()
    >>> solve = systems.factorised(csc_array(np.array([[2.0, 1.0], [1.0, 1.0]])), 0.0)
    >>> solve(np.array([3.0, 2.0])).round(12).tolist()
    [1.0, 1.0]
    """

    def __init__(self) -> None:
        self._system: SymmetricSystem | None = None

    def factorised(self, matrix: csc_array, damping: float) -> Solve:
        """What solves the system of a matrix, for right sides of shape (n,) or (n, k).

        damping : times the mean of the diagonal, added to each of its entries.
        """
        diagonal = matrix.diagonal()
        added = damping * diagonal.mean()
        if matrix.shape[0] <= _SMALL:
            matrix = matrix.copy()
            matrix.setdiag(diagonal + added)
            small: Solve = splu(
                matrix,
                permc_spec="MMD_AT_PLUS_A",
                diag_pivot_thresh=0.0,
                options={"SymmetricMode": True},
            ).solve
            return small
        lower = tril(matrix, format="csc")
        lower.setdiag(diagonal + added)
        lower.sort_indices()
        factors = self._analysed(lower).factorised(lower.data)

        def solve(right: FloatArray) -> FloatArray:
            if right.ndim == 1:
                return factors.solve(right).x
            return np.stack([factors.solve(column).x for column in right.T], axis=1)

        return solve

    def _analysed(self, lower: csc_array) -> SymmetricSystem:
        last = self._system
        if last is None or not (
            np.array_equal(last.triangle.bounds, lower.indptr)
            and np.array_equal(last.triangle.rows, lower.indices)
        ):
            bounds, rows = lower.indptr.astype(np.int64), lower.indices.astype(np.int64)
            last = SymmetricSystem(Triangle(lower.shape[0], bounds, rows))
            self._system = last
        return last
