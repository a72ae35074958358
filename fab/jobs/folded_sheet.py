"""A folded sheet with its crease pattern, and all that is set of what is made of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fab.errors import Finding
from fab.jobs.job import SheetSettings
from fab.pattern.crease_pattern import CreasePattern
from solver import Growth, QuadMesh
from solver.targets.base import Target
from solver.targets.surface_mesh import SurfaceMesh
from solver.vectors import IntArray

if TYPE_CHECKING:
    from fab.viewing.scene import Scene

__all__ = ["FoldedSheet"]


@dataclass(frozen=True)
class FoldedSheet:
    """A folded sheet, its crease pattern, and how it is made.

    Attributes
    ----------
    mesh : folded, in units of its own; cut open along a seam where it was a ring or a tube.
    pattern : in millimetres.
    settings : name, outputs, tolerance and the tables of a job.
    overlaps : pairs of faces that overlap when flat, shape (n, 2).
    growth : how the mesh was grown; None for a mesh of another origin.
    findings : of files that were read for it.
    target : the surface that it follows, in the units of the mesh.
    """

    mesh: QuadMesh
    pattern: CreasePattern
    settings: SheetSettings
    overlaps: IntArray
    growth: Growth | None = None
    findings: tuple[Finding, ...] = ()
    target: Target | SurfaceMesh | None = None

    @property
    def upright(self) -> bool:
        """Whether z is up: of sheets that follow a surface."""
        return self.target is not None

    @property
    def mm_per_unit(self) -> float:
        """Millimetres of the pattern for each unit of the mesh."""
        folded = self.pattern.folded_coords
        assert folded is not None  # the mesh is the folded form
        return float(np.ptp(folded, axis=0).max() / np.ptp(self.mesh.vertices_coords, axis=0).max())

    def scene(self) -> Scene:
        """What pictures show of it: flat and folded, over the surface that it follows."""
        from fab.viewing.scene_builders import over_surface, pattern_scene

        scene = pattern_scene(self.pattern, self.settings.name, upright=self.upright)
        if self.target is None:
            return scene
        from solver.relaxed_fit import sampled

        surface = self.target if isinstance(self.target, SurfaceMesh) else sampled(self.target)
        factor = self.mm_per_unit
        return over_surface(
            scene, SurfaceMesh(surface.vertices_coords * factor, surface.faces_vertices)
        )
