"""Solutions of the conditions on layers: whether there is one, how many, and one of them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from fab.layers.conditions import Conditions, triples
from fab.layers.reduction import Classes, classes_of, distinct_clauses, propagated
from fab.layers.satisfaction import Clock, SatSolver, solver_of
from fab.layers.state_count import Count, count_solutions
from solver.graphs import labels
from solver.vectors import BoolArray, IntArray

__all__ = ["Circles", "Solution", "solved", "transitive_clauses"]

# Triples up to so many are all written down; of more, only those that a solution violates.
_MOST_TRIPLES = 12_000_000
_AT_ONCE = 500_000
_NONE = np.empty(0, np.int64)
# About so many violated triples are added at a time, and of one stack.
_MOST_VIOLATED, _OF_STACK = 20_000, 500
# Counting ends after decisions on so many clauses, of one component and of all.
_WORK, _WORK_ALL = 4_000_000, 12_000_000
# Where it ends before it is done, so many solutions are written down.
_WRITTEN = 10_000


@dataclass(frozen=True)
class Solution:
    """What was found of conditions.

    Attributes
    ----------
    exists : whether there is an order of layers; None where that was not decided in time.
    values : shape (n,), of each pair, 1 where its second region is above, -1 below; None without an
        order.
    counts : number of orders of each independent part that has several, the largest last; they
        multiply.
    """

    exists: bool | None
    values: IntArray | None = None
    counts: tuple[Count, ...] = ()


def solved(
    conditions: Conditions, clock: Clock, true: IntArray = _NONE, *, count: bool = True
) -> Solution:
    """A solution of the conditions, and how many there are.

    true : literals that are true besides. count : without it only one solution is sought.
    """
    known = np.concatenate([conditions.known, true])
    classes = classes_of(len(conditions.pairs), conditions.equal, known)
    if classes.contradicts:
        return Solution(False)
    values = np.zeros(classes.count + 1, np.int64)
    values[1] = 1
    clauses = distinct_clauses(classes.of(conditions.clauses))
    clauses, fine = propagated(clauses, values)
    if not fine:
        return Solution(False)
    if conditions.triple_count > _MOST_TRIPLES:
        return _by_violation(conditions, classes, clauses, values, clock)
    parts = [clauses]
    for rows in _in_chunks(conditions.stacks):
        if clock.over:
            return Solution(None)
        left = classes.of(transitive_clauses(conditions, rows))
        met = (np.sign(left) * values[np.abs(left)] > 0).any(axis=1)
        parts.append(distinct_clauses(left[~met]))
    clauses, fine = propagated(distinct_clauses(np.concatenate(parts)), values)
    if not fine:
        return Solution(False)
    return _by_components(classes, distinct_clauses(clauses), values, clock, count=count)


def transitive_clauses(conditions: Conditions, rows: IntArray) -> IntArray:
    """Two clauses for each triple of regions, shape (2 n, 3): they are above one another in no
    circle.
    """
    a, b, c = rows.T
    circle = np.column_stack(
        [conditions.above(a, b), conditions.above(b, c), conditions.above(c, a)]
    )
    return np.concatenate([circle, -circle])


class Circles:
    """The search for regions over one cell that are above one another in a circle."""

    def __init__(self, conditions: Conditions) -> None:
        self._stacks = [stack for stack in conditions.stacks if len(stack) > 2]
        self._places = []
        for stack in self._stacks:
            first, second = np.triu_indices(len(stack), 1)
            place = conditions.index.find(np.column_stack([stack[first], stack[second]]))
            self._places.append(place)

    def found(self, above: BoolArray, most: int = _MOST_VIOLATED) -> IntArray:
        """Triples of regions in a circle, rising, shape (n, 3): about `most` of them, or all.

        above : shape (pairs,), whether the second region of each is above the first.
        """
        out = [np.empty((0, 3), np.int64)]
        total = 0
        for stack, place in zip(self._stacks, self._places, strict=True):
            size = len(stack)
            first, second = np.triu_indices(size, 1)
            up = above[place]
            under = np.zeros((size, size), bool)  # under[i, j]: i is under j
            under[first, second] = up
            under[second, first] = ~up
            wins = under.sum(axis=0)
            if np.bincount(wins, minlength=size).max() == 1:
                continue
            # what is above i, and above no more than i is, is in a circle with it
            low, high = np.nonzero(under & (wins[None, :] <= wins[:, None]))
            step = max(1, len(low) // _OF_STACK)
            low, high = low[::step], high[::step]
            third = (under[high] & under[:, low].T).argmax(axis=1)
            out.append(np.sort(stack[np.column_stack([low, high, third])], axis=1))
            total += len(low)
            if total > most:
                break
        return np.unique(np.concatenate(out), axis=0)


def _in_chunks(stacks: Sequence[IntArray]) -> Iterator[IntArray]:
    """The triples of all stacks, in arrays that are not too large."""
    waiting: list[IntArray] = []
    size = 0
    for stack in stacks:
        if len(stack) < 3:
            continue
        rows = triples(stack)
        waiting.append(rows)
        size += len(rows)
        if size > _AT_ONCE:
            yield np.concatenate(waiting)
            waiting, size = [], 0
    if waiting:
        yield np.concatenate(waiting)


def _by_components(
    classes: Classes, clauses: IntArray, values: IntArray, clock: Clock, *, count: bool
) -> Solution:
    """Each set of clauses that has variables of its own is solved and counted alone."""
    size = classes.count + 1
    used = clauses != 0
    row, _ = np.nonzero(used)
    variables = np.abs(clauses[used])
    first = np.abs(clauses[:, 0])
    label = labels(np.column_stack([first[row], variables]), size)
    part = label[first]
    order = np.argsort(part, kind="stable")
    bounds = np.flatnonzero(np.diff(part[order], prepend=-1, append=-1)).tolist()
    values = values.copy()
    counts: list[Count] = []
    left = _WORK_ALL
    undecided = False
    for begin, end in pairwise(bounds):
        rows = clauses[order[begin:end]]
        literals = [[each for each in clause if each] for clause in rows.tolist()]
        with solver_of(literals, clock) as solver:
            found = solver.solve()
            if found is False:
                return Solution(False)
            if found is None:
                undecided = True
                continue
            model = np.array(solver.model(), np.int64)
            own = np.unique(np.abs(rows[rows != 0]))
            values[own] = np.sign(model[own - 1])
            if count:
                number, spent = count_solutions(literals, len(own), min(_WORK, left))
                left -= spent
                counts.append(number if number.exact else _written(solver, own, number))
    if undecided:
        return Solution(None)
    free = np.flatnonzero(values[1:] == 0) + 1
    values[free] = 1
    counts += [Count(2, True)] * len(free)
    literals_of = classes.of(np.arange(len(classes.literals)) + 1)
    decided = np.sign(literals_of) * values[np.abs(literals_of)]
    several = [each for each in counts if each.number > 1 or not each.exact]
    several.sort(key=lambda each: each.number)
    return Solution(True, decided, tuple(several))


def _written(solver: SatSolver, variables: IntArray, counted: Count) -> Count:
    """The number of solutions by writing down one after another, or the one that was counted."""
    model = np.array(solver.model(), np.int64)
    for number in range(1, _WRITTEN):
        solver.add([(-model[variables - 1]).tolist()])
        found = solver.solve()
        if not found:
            return Count(max(number, counted.number), found is False)
        model = np.array(solver.model(), np.int64)
    return Count(max(_WRITTEN, counted.number), False)


def _by_violation(
    conditions: Conditions, classes: Classes, clauses: IntArray, values: IntArray, clock: Clock
) -> Solution:
    """A solution where triples are too many: those that a solution violates are added to it."""
    literals = [[each for each in clause if each] for clause in clauses.tolist()]
    assigned = np.flatnonzero(values[1:]) + 1
    literals += [[int(each)] for each in (assigned * values[assigned]).tolist()]
    of, circles = classes.literals, Circles(conditions)
    with solver_of(literals, clock) as solver:
        while True:
            found = solver.solve()
            if not found:
                return Solution(found)
            true = _model_values(solver, classes.count)
            above = np.sign(of) * true[np.abs(of)] > 0
            rows = circles.found(above)
            if not len(rows):
                return Solution(True, np.where(above, 1, -1), (Count(1, False),))
            more = distinct_clauses(classes.of(transitive_clauses(conditions, rows)))
            solver.add([each for each in clause if each] for clause in more.tolist())


def _model_values(solver: SatSolver, count: int) -> IntArray:
    """1 or -1 of each class by its number from 1; those that no clause names are 1."""
    out = np.ones(count + 1, np.int64)
    model = np.array(solver.model(), np.int64)
    model = model[np.abs(model) <= count]
    out[np.abs(model)] = np.sign(model)
    return out
