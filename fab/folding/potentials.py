"""What may be added to the elastic energy of a sheet: contact, weight, pressure, pulls.

A `Potential` has an energy that depends on the vertices, with its gradient and a curvature that is
positive semidefinite: such as the Hessian without its negative part. `fab.folding.rest` brings the
sheet to rest under all of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from fab.folding.bar_hinge_model import Energy, Framework
from solver.assembly import Blocks
from solver.vectors import FloatArray

__all__ = ["Potential", "energy_of", "free_share"]


class Potential(Protocol):
    """An energy besides that of bars and hinges, in the units of `Energy`.

    Coordinates have shape (nv, 3), relative to the framework's `size_mm`.
    """

    def energy(self, coords: FloatArray) -> float:
        """Energy at coords, in any range; inf where the sheet must not be."""

    def linearised(self, coords: FloatArray) -> tuple[FloatArray, Sequence[Blocks]]:
        """Gradient, shape (nv, 3), and curvature, which may join other vertices at each call."""

    def longest_step(self, coords: FloatArray, step: FloatArray) -> float:
        """The share of a step, 0 to 1, that may be taken; 1 where nothing hinders it."""


def energy_of(
    frame: Framework,
    coords: FloatArray,
    target: FloatArray,
    potentials: Sequence[Potential] = (),
) -> Energy:
    """Energy of a sheet under potentials, with its hinges driven to `target`, shape (nh,)."""
    elastic = frame.energy(coords, target)
    if not potentials:
        return elastic
    return Energy(elastic.bars, elastic.hinges, tuple(each.energy(coords) for each in potentials))


def free_share(potentials: Sequence[Potential], coords: FloatArray, step: FloatArray) -> float:
    """The share of a step that all potentials allow."""
    return min((each.longest_step(coords, step) for each in potentials), default=1.0)
