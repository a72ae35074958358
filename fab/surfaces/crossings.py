"""Whether a mesh passes through itself."""

from __future__ import annotations

import numpy as np

from fab.errors import Finding, Severity, counted
from fab.surfaces.soup import place_text
from solver.errors import InvalidState
from solver.self_intersection import crossing_faces
from solver.targets.smoothing import edge_length, smoothed
from solver.targets.surface_mesh import SurfaceMesh
from solver.vectors import IntArray

__all__ = ["inspect_crossings"]

_NOISE_EDGES = 8.0


def inspect_crossings(mesh: SurfaceMesh) -> list[Finding]:
    """A warning where a mesh passes through itself.

    Where it does so no more once it is smoothed by 8 of its edges, the crossings are those of
    neighbours that noise, or decimation, has moved: a note. The cost is that of
    `solver.self_intersection.crossing_faces`, about a second for 100 000 triangles.
    """
    pairs = _crossings(mesh)
    if not len(pairs):
        return []
    where = place_text(mesh.vertices_coords[mesh.faces_vertices[pairs[0]]].mean(axis=(0, 1)))
    try:
        smooth = smoothed(mesh, _NOISE_EDGES * edge_length(mesh)).mesh
    except InvalidState:  # it collapses
        smooth = mesh
    if not len(_crossings(smooth)):
        text = (
            f"{counted(len(pairs), 'pair')} of neighbouring triangles cross, the first at {where}: "
            "noise, which smoothing takes away."
        )
        return [Finding("mesh-neighbours-cross", Severity.NOTE, text)]
    text = (
        f"The surface passes through itself: {counted(len(pairs), 'pair')} of triangles cross, the "
        f"first at {where}. A sheet that follows it does so too: cut the surface apart there."
    )
    return [Finding("mesh-crosses-itself", Severity.WARNING, text)]


def _crossings(mesh: SurfaceMesh) -> IntArray:
    """Pairs of triangles that cross, shape (n, 2)."""
    offsets = 3 * np.arange(len(mesh.faces_vertices) + 1)
    return crossing_faces(mesh.vertices_coords, mesh.faces_vertices.ravel(), offsets)
