"""Loads of a sheet as potentials: dead forces such as weight, pressure, and tension of its bars."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fab.folding.bar_hinge_model import Framework
from solver.assembly import Blocks
from solver.vectors import FloatArray, IntArray, cross, norm, scattered

__all__ = ["BarTension", "DeadForces", "Pressure", "rim_forces"]


@dataclass(frozen=True)
class DeadForces:
    """Forces on vertices that keep their direction: weight, and pulled vertices.

    Attributes
    ----------
    forces : shape (nv, 3), newtons; the energy is in newtons times the size of the sheet.
    """

    forces: FloatArray

    def energy(self, coords: FloatArray) -> float:
        """Less the work of the forces."""
        return -float(np.vdot(self.forces, coords))

    def linearised(self, coords: FloatArray) -> tuple[FloatArray, list[Blocks]]:  # noqa: ARG002
        """Gradient; there is no curvature."""
        return -self.forces, []

    def longest_step(self, coords: FloatArray, step: FloatArray) -> float:  # noqa: ARG002
        """Nothing hinders a step."""
        return 1.0


@dataclass(frozen=True)
class Pressure:
    """Pressure that pushes triangles along the normals of their upper sides.

    Its energy is less the pressure times the volume between the triangles and the origin. Where
    they are closed, or their rim is held, its gradient is that of pressure on each triangle; at a
    free rim `rim_forces` is to be added. Its curvature is left out: it is not positive, and of the
    triangles around a vertex most of it cancels.

    Attributes
    ----------
    triangles : shape (n, 3). pressure : in pascals times the square of the size of the sheet in
        metres: newtons.
    """

    triangles: IntArray
    pressure: float

    def energy(self, coords: FloatArray) -> float:
        """Less the work of the pressure."""
        a, b, c = (coords[self.triangles[:, k]] for k in range(3))
        return -self.pressure / 6 * float(np.vecdot(a, cross(b, c)).sum())

    def linearised(self, coords: FloatArray) -> tuple[FloatArray, list[Blocks]]:
        """Gradient; no curvature."""
        a, b, c = (coords[self.triangles[:, k]] for k in range(3))
        pulls = -self.pressure / 6 * np.stack([cross(b, c), cross(c, a), cross(a, b)], axis=1)
        return scattered(self.triangles.ravel(), pulls.reshape(-1, 3), len(coords)), []

    def longest_step(self, coords: FloatArray, step: FloatArray) -> float:  # noqa: ARG002
        """Nothing hinders a step."""
        return 1.0


def rim_forces(coords: FloatArray, triangles: IntArray, pressure: float) -> FloatArray:
    """What the gradient of `Pressure` lacks at the rim of its triangles, as forces, shape (nv, 3).

    There the volume to the origin is bounded by triangles that carry no pressure.
    """
    sides = np.concatenate([triangles[:, [k, (k + 1) % 3]] for k in range(3)])
    keys = sides[:, 0] * len(coords) + sides[:, 1]
    back = sides[:, 1] * len(coords) + sides[:, 0]
    rim = sides[~np.isin(back, keys)]
    pull = pressure / 6 * cross(coords[rim[:, 0]], coords[rim[:, 1]])
    return scattered(rim.ravel(), np.repeat(pull, 2, axis=0), len(coords))


@dataclass(frozen=True)
class BarTension:
    """What tension adds to the curvature of a framework's energy; no energy of its own.

    Bars that are pulled resist a step across them, as a string does. The Gauss-Newton matrix of a
    framework leaves that out, which is right near a state without strain; a sheet that hangs is
    held by it. Pressed bars are left out here too: the matrix stays positive.
    """

    frame: Framework

    def energy(self, coords: FloatArray) -> float:  # noqa: ARG002
        """None."""
        return 0.0

    def linearised(self, coords: FloatArray) -> tuple[FloatArray, list[Blocks]]:
        """No gradient; curvature of the bars that are pulled."""
        bars = self.frame.bars_vertices
        side = coords[bars[:, 1]] - coords[bars[:, 0]]
        length = norm(side)
        tension = self.frame.bars_stiffness * (length - self.frame.bars_length)
        pulled = np.flatnonzero(tension > 0)
        along = side[pulled] / length[pulled, None]
        across = np.eye(3) - along[:, :, None] * along[:, None, :]
        across *= (tension[pulled] / length[pulled])[:, None, None]
        matrices = np.block([[across, -across], [-across, across]]).reshape(-1, 6, 6)
        return np.zeros_like(coords), [Blocks(bars[pulled], matrices)]

    def longest_step(self, coords: FloatArray, step: FloatArray) -> float:  # noqa: ARG002
        """Nothing hinders a step."""
        return 1.0
