"""Where is a panel drilled, to be aligned by?"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import shapely

from fab.bodies import TriangleMesh, bodies_of
from fab.carving import carved
from fab.errors import Finding, Severity
from fab.extrusion import circle, extruded
from fab.hinges import ROUND_SIDES
from fab.panels import Panels

__all__ = ["drilled"]


def drilled(panels: Panels, hole_mm: float, wall_mm: float) -> tuple[Panels, list[Finding]]:
    """The panels with a hole through each, where it is farthest from their sides at all heights.

    Panels in which it would leave less than a wall beside it stay whole, and are named.
    """
    low, high = panels.heights_mm
    meshes = [panels.bodies.mesh(i) for i in range(len(panels.bodies))]
    least = hole_mm / 2 / np.cos(np.pi / ROUND_SIDES) + wall_mm
    narrow, widest = [], 0.0
    for i, mesh in enumerate(meshes):
        free = _side_at(mesh, low) & _side_at(mesh, high)
        across = shapely.maximum_inscribed_circle(free, tolerance=least / 100)
        if across.length < least:
            narrow.append(int(panels.faces[i]))
            widest = max(widest, across.length)
            continue
        centre = shapely.get_coordinates(across)[0]
        drill = extruded(circle(centre, hole_mm / 2, ROUND_SIDES, around=True), low - 1, high + 1)
        meshes[i] = carved(mesh, [drill])
    out = replace(panels, bodies=bodies_of(meshes))
    if not narrow:
        return out, []
    text = (
        f"{len(narrow)} panels have no hole: hole_mm = {hole_mm:g} with wall_mm = {wall_mm:g} "
        f"beside it needs {2 * least:.4g} mm between their sides at all heights; the widest of "
        f"them has {2 * widest:.4g}. Lower hole_mm or wall_mm, or enlarge the sheet."
    )
    return out, [Finding("hole-missing", Severity.WARNING, text, panels=tuple(narrow[:20]))]


def _side_at(mesh: TriangleMesh, z_mm: float) -> shapely.Geometry:
    """The horizontal side of a body at a height."""
    at = mesh.vertices_coords[mesh.triangles]
    flat = (at[:, :, 2] == z_mm).all(axis=1)
    return shapely.union_all(shapely.polygons(at[flat][:, :, :2]))
