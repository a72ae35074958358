"""Conditions made small: equal variables are one, and what follows step by step is known.

Literals are numbers: v + 1 for variable v, -(v + 1) for its opposite; rows of clauses are filled up
with zeros.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from solver.graphs import labels
from solver.vectors import IntArray

__all__ = ["Classes", "classes_of", "distinct_clauses", "propagated"]


@dataclass(frozen=True)
class Classes:
    """Classes of variables that are equal or opposite.

    Attributes
    ----------
    literals : shape (n,), the class of each variable, as a literal of it; class number 1 is true.
    count : number of classes, the true one included.
    contradicts : whether a variable is equal to its opposite.
    """

    literals: IntArray
    count: int
    contradicts: bool

    def of(self, literals: IntArray) -> IntArray:
        """Literals of classes, from literals of variables, none of which is 0."""
        return np.asarray(np.sign(literals) * self.literals[np.abs(literals) - 1])


def classes_of(count: int, equal: IntArray, true: IntArray) -> Classes:
    """Classes of `count` variables.

    equal : shape (m, 2), literals that are equal; true : shape (k,), literals that are true.

    >>> classes_of(3, np.array([[1, -3]]), np.array([2])).literals.tolist()
    [2, 1, -2]
    """
    one = count + 1  # a variable that is true
    rows = np.concatenate([equal, np.column_stack([true, np.full(len(true), one)])])
    node = 2 * (np.abs(rows) - 1) + (rows < 0)
    label = labels(np.concatenate([node, node ^ 1]), 2 * one)
    positive, negative = label[0::2], label[1::2]
    contradicts = bool((positive == negative).any())
    least = np.minimum(positive, negative)
    # the true one first
    order = np.concatenate([least[-1:], least[:-1]])
    _, first, number = np.unique(order, return_index=True, return_inverse=True)
    rank = np.empty(len(first), np.int64)
    rank[np.argsort(first)] = np.arange(1, len(first) + 1)
    upright = np.concatenate([positive[-1:], positive[:-1]]) == order
    literals = rank[number] * np.where(upright, 1, -1)
    literals[np.abs(literals) == 1] *= literals[0]
    return Classes(literals[1:], len(first), contradicts)


def distinct_clauses(clauses: IntArray) -> IntArray:
    """Clauses without repeated literals, those that are always true, and repeated rows.

    >>> distinct_clauses(np.array([[2, 2, -3], [-3, 2, 2], [4, -4, 2]])).tolist()
    [[-3, 2, 0]]
    """
    a, b, c = np.sort(clauses, axis=1).T
    b = np.where(b == a, 0, b)
    c = np.where((c == a) | (c == b), 0, c)
    always = ((a == -b) & (a != 0)) | ((a == -c) & (a != 0)) | ((b == -c) & (b != 0))
    rows = np.column_stack([a, b, c])[~always]
    rows = np.take_along_axis(rows, np.argsort(rows == 0, axis=1, kind="stable"), axis=1)
    most = int(np.abs(rows).max(initial=0)) + 1
    wide = 2 * most
    keys = np.unique(((rows[:, 0] + most) * wide + rows[:, 1] + most) * wide + rows[:, 2] + most)
    keys, last = np.divmod(keys, wide)
    return np.column_stack([*np.divmod(keys, wide), last]) - most


def propagated(clauses: IntArray, values: IntArray) -> tuple[IntArray, bool]:
    """Clauses that are left when single literals are true; whether there is no contradiction.

    values : shape (count + 1,), of variables from 1: 1, -1, or 0 where not known; it is completed.
    """
    while True:
        clauses, units = _valued(clauses, values)
        if units is None:
            return clauses, False
        if not len(units):
            return clauses, True
        values[np.abs(units)] = np.sign(units)
        if (values[np.abs(units)] != np.sign(units)).any():
            return clauses, False


def _valued(clauses: IntArray, values: IntArray) -> tuple[IntArray, IntArray | None]:
    """Clauses of two literals or more that values leave, and the single ones; None where a clause
    has no literal left.
    """
    of = np.sign(clauses) * values[np.abs(clauses)]
    kept = ~(of > 0).any(axis=1)
    clauses, of = clauses[kept], of[kept]
    clauses = np.where(of < 0, 0, clauses)
    left = (clauses != 0).sum(axis=1)
    if (left == 0).any():
        return clauses, None
    units = clauses[left == 1].sum(axis=1)
    return clauses[left > 1], np.unique(units)
