"""Levenberg-Marquardt: the sum of squares of all terms, while the hard ones gain weight.

With residuals h of the hard terms and s of the soft ones, each step goes towards the minimum of

    W |h|^2 + sum w |s|^2 + mu |x - x0|^2 / step^2

by the gradients at x0, and then on, with the same factors, by what the residuals are there beyond
what the gradients promised: constraints are curved, and straight steps along them short (M. K.
Transtrum and J. P. Sethna, "Improvements to the Levenberg-Marquardt algorithm for nonlinear
least-squares minimization", arXiv:1201.5885 (2012)). The damping mu grows until a step lowers the
sum, and shrinks after one that gains what was expected of it; the weight W grows threefold whenever
a step gains less than 2 %.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from solver.assembly import NormalAssembly
from solver.relaxation.terms import Linear, Term, largest, squares
from solver.sparse import SymmetricSystem
from solver.vectors import FloatArray

__all__ = ["Descent", "Soft", "minimised"]

_FIRST_DAMPING = 1e-3
_LEAST_DAMPING, _MOST_DAMPING = 1e-9, 1e6
_RAISED, _LOWERED = 4.0, 5.0
_LITTLE_GAIN = 0.02
# The second part of a step is at most this share of the first one.
_MOST_BEND = 0.75
_HARDER = 3.0
_MOST_WEIGHT = 1e8
# A sum of squares of this size for each vertex is rounding.
_NOTHING = 1e-26


@dataclass(frozen=True)
class Soft:
    """A soft term and the weight of its squares."""

    term: Term
    weight: float = 1.0


@dataclass(frozen=True)
class Descent:
    """Where a search is.

    Attributes
    ----------
    coords : shape (nv, 3). hard, soft : the terms there.
    hard_weight, damping : for the next step.
    settled : whether the last step gained less than 2 %.
    moved : whether the last step lowered the sum: if not, no further one will.
    """

    coords: FloatArray
    hard: tuple[Linear, ...]
    soft: tuple[Linear, ...]
    hard_weight: float = 1.0
    damping: float = _FIRST_DAMPING
    settled: bool = False
    moved: bool = True

    @property
    def residual(self) -> float:
        """Largest residual of the hard terms."""
        return max((largest(linear.values) for linear in self.hard), default=0.0)

    def total(self, hard_weight: float, weights: Sequence[float]) -> float:
        """The sum of squares, without damping; NaN where a residual is."""
        hard = sum(squares(linear.values) for linear in self.hard)
        pairs = zip(weights, self.soft, strict=True)
        return hard_weight * hard + sum(w * squares(linear.values) for w, linear in pairs)


def minimised(
    coords: FloatArray, hard: Sequence[Term], soft: Sequence[Soft], step: float
) -> Iterator[Descent]:
    """The start and then the search after each of its rounds, without end unless it is stuck.

    coords : shape (nv, 3); step : a length of the size of a face's sides.
    """
    weights = [wish.weight for wish in soft]
    terms = [*hard, *(wish.term for wish in soft)]
    assembly = NormalAssembly.of(len(coords), [term.vertices for term in terms])
    system = SymmetricSystem(assembly.triangle)
    here = _linearised(coords, tuple(hard), tuple(wish.term for wish in soft))
    while here.moved:
        yield here
        here = _round(here, weights, assembly, system, step)
    yield here


def _linearised(coords: FloatArray, hard: Sequence[Term], soft: Sequence[Term]) -> Descent:
    return Descent(
        coords,
        tuple(term.linearised(coords) for term in hard),
        tuple(term.linearised(coords) for term in soft),
    )


def _round(
    here: Descent,
    weights: Sequence[float],
    assembly: NormalAssembly,
    system: SymmetricSystem,
    step: float,
) -> Descent:
    """The next place of a search: lower by one step, or the same one where no step is."""
    linears = [*here.hard, *here.soft]
    gradients = [linear.gradients for linear in linears]
    values = [linear.values for linear in linears]
    all_weights = [here.hard_weight] * len(here.hard) + list(weights)
    matrix = assembly.matrix(gradients, all_weights)
    slope = assembly.gradient(gradients, all_weights, values).ravel()
    before = here.total(here.hard_weight, weights)
    if before <= _NOTHING * len(here.coords):
        return replace(here, moved=False)
    hard, soft = ([linear.term for linear in part] for part in (here.hard, here.soft))
    damping, raised = here.damping, _RAISED
    while damping <= _MOST_DAMPING:
        damped = matrix.copy()
        damped[assembly.triangle.diagonal] += damping / step**2
        factors = system.factorised(damped)
        solution = factors.solve(-slope)
        if solution.good:
            move = solution.x
            there = _linearised(here.coords + move.reshape(-1, 3), hard, soft)
            bends = _bends(linears, [*there.hard, *there.soft], move.reshape(-1, 3))
            bend = factors.solve(-assembly.gradient(gradients, all_weights, bends).ravel()).x
            if np.linalg.norm(bend) <= _MOST_BEND * np.linalg.norm(move):
                bent = _linearised(here.coords + (move + bend).reshape(-1, 3), hard, soft)
                there = _lower(bent, there, here.hard_weight, weights)
            gain = before - there.total(here.hard_weight, weights)
            if gain > 0:  # NaN is not
                expected = float(np.sum(move * (damping / step**2 * move - slope)))
                little = gain < _LITTLE_GAIN * before
                weight = here.hard_weight * (_HARDER if little else 1.0)
                return replace(
                    there,
                    hard_weight=min(weight, _MOST_WEIGHT),
                    damping=_next_damping(damping, gain / expected),
                    settled=little,
                )
        damping, raised = raised * damping, 2 * raised
    return replace(here, moved=False)


def _bends(before: Sequence[Linear], after: Sequence[Linear], move: FloatArray) -> list[FloatArray]:
    """By how much residuals differ from what their gradients promise of a move, shape (n,) each."""
    out = []
    for one, other in zip(before, after, strict=True):
        vertices = one.term.vertices
        moves = np.where((vertices >= 0)[:, :, None], move[vertices], 0.0)
        out.append(other.values - one.values - np.einsum("nkc,nkc->n", one.gradients, moves))
    return out


def _lower(
    first: Descent, second: Descent, hard_weight: float, weights: Sequence[float]
) -> Descent:
    """That of two places where the sum is less; the second where the first has none."""
    lower = first.total(hard_weight, weights) < second.total(hard_weight, weights)
    return first if lower or not np.isfinite(second.total(hard_weight, weights)) else second


def _next_damping(damping: float, ratio: float) -> float:
    """Damping after a step that gained `ratio` of what the linear terms let expect.

    After H. B. Nielsen, "Damping parameter in Marquardt's method", IMM-REP-1999-05 (1999): less
    where they held, more where they promised more than twice as much.
    """
    return max(damping * max(1 / _LOWERED, 1 - (2 * min(ratio, 1.0) - 1) ** 3), _LEAST_DAMPING)
