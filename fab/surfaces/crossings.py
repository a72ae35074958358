"""Whether a mesh passes through itself."""

from __future__ import annotations

import numpy as np

from fab.errors import Finding, Severity, counted
from fab.pattern.self_intersection import crossing_faces
from fab.surfaces.soup import place_text
from solver.targets.surface_mesh import SurfaceMesh

__all__ = ["inspect_crossings"]

# Larger meshes are not looked at.
_MOST_FACES = 2_000_000


def inspect_crossings(mesh: SurfaceMesh) -> list[Finding]:
    """A warning where a mesh of up to two million triangles passes through itself."""
    faces = mesh.faces_vertices
    if len(faces) > _MOST_FACES:
        text = f"{len(faces)} triangles are too many to see whether the surface crosses itself."
        return [Finding("mesh-crossings-unknown", Severity.NOTE, text)]
    offsets = 3 * np.arange(len(faces) + 1)
    pairs = crossing_faces(mesh.vertices_coords, faces.ravel(), offsets)
    if not len(pairs):
        return []
    where = place_text(mesh.vertices_coords[faces[pairs[0]]].mean(axis=(0, 1)))
    text = (
        f"The surface passes through itself: {counted(len(pairs), 'pair')} of triangles cross, the "
        f"first at {where}. A sheet that follows it does so too: cut the surface apart there."
    )
    return [Finding("mesh-crosses-itself", Severity.WARNING, text)]
