"""Clauses solved by python-sat (Ignatiev, Morgado and Marques-Silva 2018), within a time."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

__all__ = ["Clock", "SatSolver", "solver_of"]

# Solves the same way every time, and may be asked to stop after some conflicts.
_NAME = "glucose4"
_CONFLICTS = 2000


class Clock:
    """A time that is not to be exceeded, seconds."""

    def __init__(self, seconds: float) -> None:
        self._end = time.monotonic() + seconds

    @property
    def over(self) -> bool:
        """Whether the time has passed."""
        return time.monotonic() > self._end


class SatSolver:
    """A solver of clauses that keeps what it has learned."""

    def __init__(self, clauses: Iterable[Sequence[int]], clock: Clock) -> None:
        from pysat.solvers import Solver

        self._solver: Any = Solver(_NAME)
        self._clock = clock
        self.add(clauses)

    def add(self, clauses: Iterable[Sequence[int]]) -> None:
        """More clauses, of literals other than 0."""
        for number, clause in enumerate(clauses):
            self._solver.add_clause(clause)
            if number % 10000 == 0 and self._clock.over:
                return

    def solve(self, assumptions: Sequence[int] = ()) -> bool | None:
        """Whether all clauses can be true; None where the time was over before."""
        while not self._clock.over:
            self._solver.conf_budget(_CONFLICTS)
            found = self._solver.solve_limited(list(assumptions))
            if found is not None:
                return bool(found)
        return None

    def model(self) -> list[int]:
        """The literals that are true in the solution."""
        return list(self._solver.get_model() or [])

    def core(self) -> list[int]:
        """Those of the assumptions that contradict the clauses."""
        return list(self._solver.get_core() or [])

    def close(self) -> None:
        """Give its memory back."""
        self._solver.delete()


@contextmanager
def solver_of(clauses: Iterable[Sequence[int]], clock: Clock) -> Iterator[SatSolver]:
    """A solver of clauses. Raises `ImportError` where python-sat is not installed."""
    solver = SatSolver(clauses, clock)
    try:
        yield solver
    finally:
        solver.close()
