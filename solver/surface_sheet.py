"""One sheet on a surface: what it is, and whether it can be made and follows its part."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from solver.measure import developability
from solver.mesh import QuadMesh
from solver.relaxation.laying import Pleats
from solver.relaxation.method import RelaxationStatus
from solver.targets.surface_mesh import SurfaceMesh
from solver.vectors import FloatArray, angle_between

__all__ = ["OFF", "SurfaceSheet", "least_sector"]

# What a good sheet covers and how far at most it is off its offsets, in steps.
_COVERED = 0.99
OFF = 0.15
# Radians by which the sectors around a vertex of an exact sheet differ from a full turn.
_EXCESS = 1e-9


@dataclass(frozen=True)
class SurfaceSheet:
    """One sheet on its part of the surface.

    Attributes
    ----------
    mesh : the sheet. part : the surface that it was made for.
    status, advice : how relaxation ended. rounds : of it.
    deviations : signed distances of vertices from their offsets, in the surface's units, shape
        (n,); positive on the side of its normals.
    coverage : share of the part that has the sheet above or below it. crossings : pairs of faces.
    least_sector : smallest sector angle, radians.
    missed : by how much goals are missed, shares of their bounds summed up. far : whether by so
        much that sheets of other cells are hardly nearer.
    step : unit of the cell. pleats, turn : what was chosen.
    distance : the largest one of a vertex from the surface, in its units.
    """

    mesh: QuadMesh
    part: SurfaceMesh
    status: RelaxationStatus
    advice: str
    rounds: int
    deviations: FloatArray
    coverage: float
    crossings: int
    least_sector: float
    step: float
    pleats: Pleats
    turn: float
    distance: float
    missed: float = 0.0
    far: bool = False

    @property
    def good(self) -> bool:
        """Whether it can be made and follows its surface."""
        return self.faults == 0

    @cached_property
    def exact(self) -> bool:
        """Whether it unfolds: relaxation counts a reflex sector by the angle on its other side."""
        excess = developability(self.mesh.vertices_coords, self.mesh.faces_vertices)
        return float(excess.max(initial=0.0)) <= _EXCESS

    @property
    def faults(self) -> float:
        """How much is wrong with it: 0 of a good one."""
        return (
            100.0 * (not self.unfolds)
            + self.crossings
            + 100 * max(0.0, _COVERED - self.coverage)
            + 10 * max(0.0, self.off - OFF)
        )

    @property
    def unfolds(self) -> bool:
        """Whether relaxation made it exact."""
        return self.status is RelaxationStatus.RELAXED and self.exact

    @property
    def made(self) -> bool:
        """Whether it can be made, wherever it is."""
        return self.unfolds and not self.crossings

    @property
    def off(self) -> float:
        """How far at most a vertex is off its offset, in steps."""
        return float(np.abs(self.deviations).max(initial=0.0)) / self.step


def least_sector(mesh: QuadMesh) -> float:
    """The smallest sector angle of all faces, radians."""
    corners = mesh.vertices_coords[mesh.faces_vertices]
    ahead = np.roll(corners, -1, axis=1) - corners
    back = np.roll(corners, 1, axis=1) - corners
    return float(angle_between(ahead, back).min())
