"""Symmetric sparse systems: factors of a matrix whose sparsity is analysed once, and solutions.

`Triangle` is the sparsity of a symmetric matrix, `SymmetricSystem` its analysis, of which any
number of matrices with that sparsity are factorised, positive definite or not:

>>> triangle, slots = Triangle.of(2, np.array([0, 1, 1]), np.array([0, 0, 1]))
>>> factors = SymmetricSystem(triangle).factorised(np.array([2.0, 1.0, -3.0]))
>>> solution = factors.solve(np.array([3.0, -2.0]))
>>> solution.x.round(12).tolist(), solution.good
([1.0, 1.0], True)

Factors are those of rslab (L D L', Bunch and Kaufman 1977, supernodal, the same bits with any
number of threads). Every solution is checked by its backward error; where rslab is missing, fails
or is not exact enough, SuperLU (`scipy.sparse.linalg.splu`) takes its place.
"""

from __future__ import annotations

import warnings
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Protocol

import numpy as np
from scipy.sparse import csc_array
from scipy.sparse.linalg import MatrixRankWarning, splu

from solver.errors import InvalidValue
from solver.vectors import FloatArray, IntArray

if TYPE_CHECKING:
    import rslab

__all__ = ["Factors", "Solution", "SymmetricSystem", "Triangle"]

# Backward errors: of a solution that counts, and of one that needs no refinement.
_GOOD = 1e-10
_ROUNDING = 4e-16
_REFINEMENTS = 2
# Matrices of so many entries take over half a second: the interrupt of a user is seen so often.
_LONG = 1_000_000
_POLL_S = 0.2


@dataclass(frozen=True)
class Triangle:
    """Where the lower triangle of a symmetric matrix has entries, column after column.

    Every diagonal entry is one of them, and the first of its column.

    Attributes
    ----------
    size : number of rows. bounds : where each column begins, shape (size + 1,).
    rows : of the entries, shape (n,), rising within each column.
    """

    size: int
    bounds: IntArray
    rows: IntArray

    @classmethod
    def of(cls, size: int, rows: IntArray, columns: IntArray) -> tuple[Triangle, IntArray]:
        """The triangle that holds the entries (rows, columns), and the slot of each of them.

        rows, columns : shape (m,), in either triangle; entries may repeat. A row or a column -1 is
        of no entry: its slot is n, one beyond the last.

        >>> triangle, slots = Triangle.of(3, np.array([2, 0, -1]), np.array([0, 2, 1]))
        >>> triangle.rows.tolist(), triangle.bounds.tolist(), slots.tolist()
        ([0, 2, 1, 2], [0, 2, 3, 4], [1, 1, 4])
        """
        low, high = np.minimum(rows, columns), np.maximum(rows, columns)
        there = low >= 0
        keys = low[there].astype(np.int64) * size + high[there]
        diagonal = np.arange(size, dtype=np.int64) * (size + 1)
        unique, places = np.unique(np.concatenate([diagonal, keys]), return_inverse=True)
        slots = np.full(len(low), len(unique))
        slots[there] = places[size:]
        bounds = np.searchsorted(unique, np.arange(size + 1) * size)
        return cls(size, bounds, unique % size), slots

    @property
    def diagonal(self) -> IntArray:
        """Slots of the diagonal entries, shape (size,)."""
        return self.bounds[:-1]

    def summed(self, slots: IntArray, values: FloatArray) -> FloatArray:
        """Entries of a matrix, shape (n,): the sum of the values in each slot."""
        count = len(self.rows)
        return np.asarray(np.bincount(slots, values, count + 1)[:count])

    def lower(self, data: FloatArray) -> csc_array:
        """The lower triangle as a matrix; data : shape (n,)."""
        return csc_array((data, self.rows, self.bounds), shape=(self.size, self.size))


@dataclass(frozen=True)
class Solution:
    """The solution of a system.

    Attributes
    ----------
    x : shape (size,). error : normwise backward error, |A x - b| / (|A| |x| + |b|) by largest
        entries and row sums: about 1e-16 where x is as exact as rounding allows.
    solver : whose factors it is from, "rslab" or "SuperLU"; "none" where neither has any.
    """

    x: FloatArray
    error: float
    solver: str

    @property
    def good(self) -> bool:
        """Whether the solution counts: its backward error is at most 1e-10."""
        return self.error <= _GOOD


class _Solver(Protocol):
    def solve(self, right: FloatArray, /) -> FloatArray: ...


@dataclass(frozen=True)
class Factors:
    """Factors of one symmetric matrix.

    Attributes
    ----------
    lower : its lower triangle.
    inertia : numbers of positive, negative and zero eigenvalues; None where SuperLU had to factor.
    """

    lower: csc_array
    inertia: tuple[int, int, int] | None
    _first: rslab.Ldlt | None

    def solve(self, right: FloatArray) -> Solution:
        """The solution x of A x = right, shape (size,), by the first factors that are good."""
        best = Solution(np.full(len(right), np.nan), np.inf, "none")
        if self._first is not None:
            best = self._refined(self._first, right, "rslab")
        if not best.good and self._second is not None:
            other = self._refined(self._second, right, "SuperLU")
            best = other if other.error < best.error else best
        return best

    @cached_property
    def _second(self) -> _Solver | None:
        """Factors by SuperLU; None where the matrix is singular."""
        full = self.lower + self.lower.T
        full.setdiag(self.lower.diagonal())
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error", MatrixRankWarning)
                out: _Solver = splu(
                    full.tocsc(), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}
                )
        except (RuntimeError, ValueError, MatrixRankWarning):  # singular, or not finite
            return None
        return out

    @cached_property
    def _norm(self) -> float:
        """Largest sum of absolute values in a row."""
        size = abs(self.lower)
        sums = size.sum(axis=0) + size.sum(axis=1) - size.diagonal()
        return float(np.max(sums, initial=0.0))

    def _product(self, x: FloatArray) -> FloatArray:
        out: FloatArray = self.lower @ x + self.lower.T @ x - self.lower.diagonal() * x
        return out

    def _refined(self, factors: _Solver, right: FloatArray, solver: str) -> Solution:
        """The solution by these factors, refined while that helps."""
        x = factors.solve(right)
        best = Solution(x, np.inf, solver)
        for _ in range(_REFINEMENTS + 1):
            rest = right - self._product(x)
            bound = self._norm * _largest(x) + _largest(right)
            error = _largest(rest) / bound if bound else 0.0
            if not error < best.error:  # NaN too
                break
            best = Solution(x, error, solver)
            if error <= _ROUNDING:
                break
            x = x + factors.solve(rest)
        return best


def _largest(x: FloatArray) -> float:
    return float(np.abs(x).max(initial=0.0))


@dataclass(frozen=True)
class SymmetricSystem:
    """The analysis of a sparsity, of which many matrices are factorised.

    Attributes
    ----------
    triangle : the sparsity of the matrices.
    """

    triangle: Triangle

    def factorised(self, data: FloatArray) -> Factors:
        """Factors of the matrix with the entries `data` in its lower triangle, shape (n,).

        A singular matrix has none that are good: its solutions say so. Raises `InvalidValue` for
        entries of another number.
        """
        if data.shape != self.triangle.rows.shape:
            raise InvalidValue(
                "data",
                f"array of shape {data.shape}",
                f"have shape {self.triangle.rows.shape}",
                "Give one number for each entry of the lower triangle.",
            )
        lower = self.triangle.lower(data)
        if self._analysis is None or not np.isfinite(data).all():
            return Factors(lower, None, None)
        try:
            factors = self._factor(self._analysis, data)
        except RuntimeError:  # a pivot is zero
            return Factors(lower, None, None)
        positive, negative, zero = factors.inertia
        return Factors(lower, (positive, negative, zero), factors)

    def _factor(self, analysis: rslab.LdltSymbolic, data: FloatArray) -> rslab.Ldlt:
        """Factors of rslab; those that take seconds give way to an interrupt."""
        if len(data) < _LONG:
            return analysis.factor(data)
        import rslab

        stop = rslab.Interrupt()
        with ThreadPoolExecutor(1) as thread:
            made = thread.submit(analysis.factor, data, interrupt=stop)
            try:
                while True:
                    with suppress(TimeoutError):
                        return made.result(_POLL_S)
            finally:
                stop.cancel()

    @cached_property
    def _analysis(self) -> rslab.LdltSymbolic | None:
        """The order of elimination; None without rslab."""
        try:
            import rslab
        except ImportError:
            return None
        if not self.triangle.size:
            return None
        pattern = self.triangle.lower(np.ones(len(self.triangle.rows)))
        out: rslab.LdltSymbolic = rslab.analyze(pattern, path="ldlt")
        return out
