"""Projection onto the hard terms: shortest steps of Gauss-Newton, down to rounding.

With the residuals h and their Jacobian J over coordinates in steps, each step x is the shortest
with J x = -h, from the indefinite system of Karush, Kuhn and Tucker

    [ 1    J'  ] [ x ]   [  0 ]
    [ J  -eps  ] [ y ] = [ -h ]

whose small eps keeps it regular where constraints depend on each other. It has as many negative
eigenvalues as there are constraints. The residual after a step is of the order of its square.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from solver.relaxation.terms import Term, largest
from solver.sparse import SymmetricSystem, Triangle
from solver.vectors import FloatArray, IntArray

__all__ = ["Projection", "projected"]

_EXACT = 1e-13
_REGULAR = 1e-14
_MOST_STEPS = 30
# Steps that together gain less than half have come down to rounding, or lead nowhere.
_PATIENCE = 3


@dataclass(frozen=True)
class Projection:
    """Coordinates that meet the hard terms as well as can be.

    Attributes
    ----------
    coords : shape (nv, 3). residuals : the largest hard residual at first and after each step
        that lowered it; the last is that of `coords`.
    """

    coords: FloatArray
    residuals: tuple[float, ...]


def projected(coords: FloatArray, hard: Sequence[Term], step: float) -> Projection:
    """The nearest coordinates, about, that meet the hard terms.

    coords : shape (nv, 3); step : a length of the size of a face's sides. Ends where no residual
    exceeds 1e-13, or where steps gain no more.
    """
    if not sum(len(term.vertices) for term in hard):
        return Projection(coords, (0.0,))
    unknowns = coords.size
    triangle, slots = _sparsity(unknowns, hard)
    system = SymmetricSystem(triangle)
    residuals: list[float] = []
    best, idle = coords, 0
    with np.errstate(all="ignore"):  # what fails is NaN and ends the search
        for _ in range(_MOST_STEPS + 1):
            linears = [term.linearised(coords) for term in hard]
            values = np.concatenate([linear.values for linear in linears])
            worst = largest(values)
            if not np.isfinite(worst):
                break
            if not residuals or worst < residuals[-1]:
                idle = 0 if not residuals or worst < residuals[-1] / 2 else idle + 1
                residuals.append(worst)
                best = coords
            else:
                idle += 1
            if residuals[-1] <= _EXACT or idle >= _PATIENCE:
                break
            slopes = np.concatenate([step * linear.gradients.ravel() for linear in linears])
            entries = np.concatenate([np.ones(unknowns), np.full(len(values), -_REGULAR), slopes])
            right = np.concatenate([np.zeros(unknowns), -values])
            solution = system.factorised(triangle.summed(slots, entries)).solve(right)
            if not solution.good:
                break
            coords = coords + step * solution.x[:unknowns].reshape(-1, 3)
    return Projection(best, tuple(residuals) or (np.inf,))


def _sparsity(unknowns: int, hard: Sequence[Term]) -> tuple[Triangle, IntArray]:
    """That of the system, and the slots of its diagonal and then of all gradients."""
    rows, columns = [], []
    begin = unknowns
    for term in hard:
        count, width = term.vertices.shape
        there = term.vertices[:, :, None] >= 0
        unknown = np.where(there, 3 * term.vertices[:, :, None] + np.arange(3), -1)
        rows.append(np.repeat(begin + np.arange(count), 3 * width))
        columns.append(unknown.ravel())
        begin += count
    diagonal = np.arange(begin)
    return Triangle.of(
        begin, np.concatenate([diagonal, *rows]), np.concatenate([diagonal, *columns])
    )
