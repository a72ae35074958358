"""The few regions that already cannot be put in order, whatever the rest of the sheet does."""

from __future__ import annotations

import numpy as np

from fab.layers.conditions import Conditions
from fab.layers.satisfaction import Clock, SatSolver, solver_of
from fab.layers.solution import Circles, transitive_clauses
from solver.vectors import IntArray

__all__ = ["unordered_regions"]

# Triples that are added at a time until there is no order.
_TRIPLES = 5000


def unordered_regions(
    conditions: Conditions, count: int, clock: Clock, true: IntArray | None = None
) -> IntArray | None:
    """Regions without an order of their own, none of which can be left out, rising.

    count : of all regions. true : literals that are true besides. None where time was over before
    any were found; where it is over later, some of them may be superfluous.
    """
    known = conditions.known if true is None else np.concatenate([conditions.known, true])
    number = len(conditions.pairs)
    regions, rows = np.arange(count), np.empty((0, 3), np.int64)
    circles = Circles(conditions)
    with solver_of(_guarded(conditions, known, regions, rows), clock) as solver:
        while (found := solver.solve((number + 1 + regions).tolist())) is not False:
            if found is None:
                return None
            above = np.ones(number, bool)
            own = np.array(solver.model(), np.int64)
            own = own[np.abs(own) <= number]
            above[np.abs(own) - 1] = own > 0
            more = circles.found(above, _TRIPLES)
            if not len(more):
                return None
            rows = np.concatenate([rows, more])
            solver.add(_triples(conditions, more))
        core = _core(solver, number)
    either = [
        _minimal(conditions, known, order, rows, clock) for order in (core, core[::-1].copy())
    ]
    return np.sort(min(either, key=len))


def _minimal(
    conditions: Conditions, known: IntArray, regions: IntArray, rows: IntArray, clock: Clock
) -> IntArray:
    """Regions of which each is needed, found by leaving out one after another.

    rows : the triples of which it is known that they have no circle.
    """
    number = len(conditions.pairs)
    kept = regions
    with solver_of(_guarded(conditions, known, regions, rows), clock) as solver:
        for region in regions.tolist():
            if region not in kept:
                continue
            found = solver.solve((number + 1 + kept[kept != region]).tolist())
            if found is None:
                break
            if not found:
                kept = _core(solver, number)
    return kept


def _core(solver: SatSolver, number: int) -> IntArray:
    """The regions that were assumed and have no order, rising."""
    return np.sort(np.array(solver.core(), np.int64) - number - 1)


def _guarded(
    conditions: Conditions, known: IntArray, regions: IntArray, triples: IntArray
) -> list[list[int]]:
    """Conditions among some regions, each of which holds where all its regions are taken."""
    number = len(conditions.pairs)
    rows: list[list[int]] = []
    own = np.isin(conditions.equal_regions, regions).all(axis=1)
    equal = conditions.equal[own]
    both = np.concatenate([equal * [1, -1], equal * [-1, 1]])
    rows += _with_guards(both, np.tile(conditions.equal_regions[own], (2, 1)), number)
    own = np.isin(conditions.clauses_regions, regions).all(axis=1)
    rows += _with_guards(conditions.clauses[own], conditions.clauses_regions[own], number)
    pairs = conditions.pairs[np.abs(known) - 1]
    own = np.isin(pairs, regions).all(axis=1)
    rows += _with_guards(known[own][:, None], pairs[own], number)
    return rows + _triples(conditions, triples[np.isin(triples, regions).all(axis=1)])


def _triples(conditions: Conditions, rows: IntArray) -> list[list[int]]:
    number = len(conditions.pairs)
    return _with_guards(transitive_clauses(conditions, rows), np.tile(rows, (2, 1)), number)


def _with_guards(clauses: IntArray, regions: IntArray, number: int) -> list[list[int]]:
    out: list[list[int]] = np.concatenate([clauses, -(number + 1 + regions)], axis=1).tolist()
    return out
