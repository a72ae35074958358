"""Pareto fronts: rows that no other row is better than in every goal."""

from __future__ import annotations

import numpy as np

from solver.vectors import BoolArray, FloatArray

__all__ = ["pareto_front"]


def pareto_front(values: FloatArray) -> BoolArray:
    """Which rows no other row beats: is as low in all columns, and lower in one.

    values : shape (rows, goals), all to be low. Of rows that are equal, all are on the front.

    >>> pareto_front(np.array([[1.0, 3.0], [2.0, 2.0], [2.0, 3.0], [3.0, 1.0]])).tolist()
    [True, True, False, True]
    """
    on_front = np.ones(len(values), bool)
    for number, row in enumerate(values):
        beats = (values <= row).all(axis=1) & (values < row).any(axis=1)
        on_front[number] = not beats.any()
    return on_front
