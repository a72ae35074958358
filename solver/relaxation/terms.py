"""What a term of relaxation is: residuals of a sheet with their gradients."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from solver.vectors import FloatArray, IntArray

__all__ = ["Linear", "Term", "largest", "squares"]


@dataclass(frozen=True)
class Linear:
    """A term at some coordinates.

    Attributes
    ----------
    values : its residuals, shape (n,), dimensionless (angles in radians).
    gradients : of each residual by its vertices, shape (n, k, 3); zero where the vertex is -1.
    term : the term from which the next coordinates are looked at (it may remember where its
        vertices are on a surface).
    """

    values: FloatArray
    gradients: FloatArray
    term: Term


class Term(Protocol):
    """Residuals that relaxation brings to zero (hard terms) or near it (soft terms).

    The vertices of each residual never change; values and gradients do.
    """

    @property
    def vertices(self) -> IntArray:
        """Vertices that each residual depends on, shape (n, k), distinct; -1 for none."""

    def linearised(self, coords: FloatArray) -> Linear:
        """Residuals and gradients at `coords`, shape (nv, 3)."""


def largest(values: FloatArray) -> float:
    """Largest absolute value; 0 of nothing, NaN where one is NaN."""
    return float(np.abs(values).max(initial=0.0))


def squares(values: FloatArray) -> float:
    """Sum of squares, in an order that no number of threads changes."""
    return float(np.sum(values * values))
