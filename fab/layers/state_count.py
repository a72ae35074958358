"""Numbers of solutions of small sets of clauses, by search that divides them into components.

As exact model counters do (Bayardo and Pehoushek 2000; Thurley 2006, sharpSAT): after each decision
what is left falls into parts without common variables, whose numbers multiply, and parts that occur
again are not counted again.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

__all__ = ["Count", "count_solutions"]

# Decisions one within another.
_DEEPEST = 200
# Parts of which the number is kept.
_MOST_KEPT = 100_000
# The variable to decide is that of most of so many clauses.
_LOOKED_AT = 200


@dataclass(frozen=True)
class Count:
    """A number of solutions; at least so many where it is not exact."""

    number: int
    exact: bool


def count_solutions(
    clauses: Sequence[Sequence[int]], variables: int, work: int
) -> tuple[Count, int]:
    """Number of solutions of clauses, with `variables` variables in all, and the work it took.

    clauses : of literals, numbers other than 0 of different variables, two or more in each.
    work : search ends when clauses were looked at so often; what was not reached by then counts as
        no solution.

    >>> count_solutions([(1, 2), (-1, 3)], 4, 1000)[0]
    Count(number=8, exact=True)
    """
    place = {v: i for i, v in enumerate(sorted({abs(each) for row in clauses for each in row}))}
    rows = {sum(1 << 2 * place[abs(each)] + (each < 0) for each in row) for row in clauses}
    search = _Search(len(place), work)
    number = search.counted(sorted(rows))
    free = variables - len(place)
    return Count(number << free, search.exact), min(work, work - search.left)


class _Search:
    """A search over clauses, which are the bits of numbers: of variable v, 2 v and 2 v + 1.

    Attributes
    ----------
    exact : whether nothing was left out. left : how often clauses may still be looked at.
    """

    def __init__(self, count: int, work: int) -> None:
        self.left = work
        self.exact = True
        self._even = int("01" * count or "0", 2)
        self._known: dict[frozenset[int], int] = {}

    def opposite(self, bits: int) -> int:
        """The opposites of literals."""
        return ((bits & self._even) << 1) | ((bits >> 1) & self._even)

    def counted(self, clauses: list[int], depth: int = 0) -> int:
        """Number of solutions over the variables of clauses, which have two literals or more."""
        product = 1
        for used, part in self._parts(clauses):
            key = frozenset(part)
            number = self._known.get(key)
            if number is None:
                before, self.exact = self.exact, True
                number = self._decided(used, sorted(key), depth)
                if self.exact and len(self._known) < _MOST_KEPT:
                    self._known[key] = number
                self.exact = self.exact and before
            product *= number
            if not product:
                break
        return product

    def _decided(self, used: int, clauses: list[int], depth: int) -> int:
        """The number of one part, whose variables are `used`, by the value of one of them."""
        if self.left <= 0 or depth > _DEEPEST:
            self.exact = False
            return 0
        literal = self._frequent(clauses)
        total = 0
        for each in (literal, self.opposite(literal)):
            left = self._assigned(clauses, each)
            if left is not None:
                rest, known = left
                free = used & self._even & ~(known | self.opposite(known))
                for clause in rest:
                    free &= ~(clause | self.opposite(clause))
                total += self.counted(rest, depth + 1) << free.bit_count()
        return total

    def _frequent(self, clauses: list[int]) -> int:
        """The literal, positive, of the variable that is most often in some of the clauses."""
        number: dict[int, int] = {}
        for clause in clauses[:: max(1, len(clauses) // _LOOKED_AT)]:
            bits = (clause | clause >> 1) & self._even
            while bits:
                low = bits & -bits
                number[low] = number.get(low, 0) + 1
                bits ^= low
        most = max(number.values())
        return min(bit for bit, times in number.items() if times == most)

    def _assigned(self, clauses: list[int], literal: int) -> tuple[list[int], int] | None:
        """Clauses that a true literal leaves, and all that are true by it; None if it cannot be."""
        true = new = literal
        while new:
            false = self.opposite(new)
            self.left -= len(clauses)
            rest, units = [], 0
            for clause in clauses:
                if clause & new:
                    continue
                if clause & false:
                    clause &= ~false
                    if not clause:
                        return None
                    if not clause & (clause - 1):
                        units |= clause
                        continue
                rest.append(clause)
            if units & self.opposite(units):
                return None
            clauses, new = rest, units
            true |= units
        return clauses, true

    def _parts(self, clauses: list[int]) -> list[tuple[int, list[int]]]:
        """Clauses by the components of their variables, which are given as both their literals."""
        self.left -= len(clauses)
        parts: list[tuple[int, list[int]]] = []
        for clause in clauses:
            used = clause | self.opposite(clause)
            meeting = [part for part in parts if part[0] & used]
            if len(meeting) == 1 and not used & ~meeting[0][0]:
                meeting[0][1].append(clause)
                continue
            own = [clause]
            for part in meeting:
                used |= part[0]
                own = _extended(*sorted((part[1], own), key=len, reverse=True))
            parts = [part for part in parts if not part[0] & used]
            parts.append((used, own))
        return parts


def _extended(rows: list[int], more: list[int]) -> list[int]:
    rows.extend(more)
    return rows
