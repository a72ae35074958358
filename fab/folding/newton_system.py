"""The linear systems of Newton steps of a sheet: assembled and factorised, analysed once.

The sparsity is that of bars and hinges. Where the curvature of a potential joins further vertices,
it grows by these and is analysed again; it never shrinks, so that contacts that come and go do not
cost an analysis each time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fab.folding.bar_hinge_model import Framework
from fab.folding.potentials import Potential
from solver.assembly import NormalAssembly
from solver.sparse import SymmetricSystem
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["Linearised", "NewtonSystem"]


@dataclass(frozen=True)
class Linearised:
    """The energy of a sheet to second order, at some coordinates.

    Attributes
    ----------
    gradient : shape (nv, 3), 0 at fixed vertices.
    entries : of the matrix in the sparsity of `system`: rows and columns of the identity, times
        `stiffness`, at fixed vertices.
    stiffness : mean of the diagonal over the unknowns that are free.
    trace : the sum of this diagonal.
    pull : the part of the gradient that is of potentials, shape (nv, 3).
    """

    gradient: FloatArray
    entries: FloatArray
    system: SymmetricSystem
    stiffness: float
    trace: float
    pull: FloatArray

    @property
    def pulled(self) -> bool:
        """Whether potentials pull at any vertex that is free."""
        return bool(np.any(self.pull != 0))

    def step(self, damping: float) -> FloatArray | None:
        """The step to the minimum, shape (nv, 3); None where it is not found.

        damping : added to the diagonal, relative to `stiffness`.
        """
        damped = self.entries.copy()
        damped[self.system.triangle.diagonal] += damping * self.stiffness
        solution = self.system.factorised(damped).solve(-self.gradient.ravel())
        return solution.x.reshape(-1, 3) if solution.good else None


class NewtonSystem:
    """The systems of one framework, under any potentials.

    fixed : vertices that do not move, shape (nv,); none where left out.
    """

    def __init__(self, frame: Framework, fixed: BoolArray | None = None) -> None:
        self._frame = frame
        self._fixed = None if fixed is None or not fixed.any() else np.repeat(fixed, 3)
        self._use(frame.assembly, frame.system)

    def _use(self, assembly: NormalAssembly, system: SymmetricSystem) -> None:
        self._assembly, self._system = assembly, system
        if self._fixed is not None:
            triangle = assembly.triangle
            columns = np.repeat(np.arange(triangle.size), np.diff(triangle.bounds))
            self._held = self._fixed[triangle.rows] | self._fixed[columns]

    @property
    def joined(self) -> IntArray:
        """All pairs of two vertices in the sparsity, shape (n, 2)."""
        return self._assembly.joined

    def join(self, vertices: Sequence[IntArray]) -> None:
        """Let the sparsity grow by further vertices, shape (n, k) each, joined in each row."""
        new = [each for each in vertices if not self._assembly.covers(each)]
        if new:
            assembly = self._assembly.extended(new)
            self._use(assembly, SymmetricSystem(assembly.triangle))

    def linearised(
        self, coords: FloatArray, target: FloatArray, potentials: Sequence[Potential] = ()
    ) -> Linearised:
        """The energy at coords, shape (nv, 3), with the hinges driven to `target`, shape (nh,)."""
        here = self._frame.derivatives(coords, target)
        others = [each.linearised(coords) for each in potentials]
        blocks = [block for _, curvature in others for block in curvature]
        self.join([block.vertices for block in blocks])
        gradient = self._assembly.gradient(here.gradients, here.weights, here.values)
        pull = sum((slope for slope, _ in others), np.zeros_like(gradient))
        entries = self._assembly.matrix(here.gradients, here.weights, blocks)
        diagonal = entries[self._system.triangle.diagonal]
        if self._fixed is not None:
            held = self._fixed.reshape(-1, 3)
            gradient[held] = pull[held] = 0.0
            diagonal = diagonal[~self._fixed]
        trace = float(diagonal.sum())
        stiffness = trace / len(diagonal) if len(diagonal) else 1.0
        if self._fixed is not None:
            entries[self._held] = 0.0
            entries[self._system.triangle.diagonal[self._fixed]] = stiffness
        return Linearised(gradient + pull, entries, self._system, stiffness, trace, pull)
