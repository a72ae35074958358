"""Is every body a closed solid in one piece, and are all of them held together?"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from fab.errors import Finding, Severity
from fab.geometry.bodies import Bodies, TriangleMesh
from fab.geometry.booleans import manifold_of
from fab.panels.thick_sheet import ThickSheet
from solver.vectors import IntArray

if TYPE_CHECKING:
    from manifold3d import Manifold

__all__ = ["held_together", "inspect_joined", "inspect_soundness", "parts_of"]

_VOLUME_REL = 1e-9
# Corners too near to each other for single precision become one where bodies are joined.
_JOINED_REL = 1e-6


def inspect_soundness(sheet: ThickSheet, solids: list[Manifold]) -> list[Finding]:
    """A finding for each body that is not closed, in one piece and of positive volume.

    solids : the bodies of the sheet, read by manifold3d, whose volumes must be the same.
    """
    from manifold3d import Error

    findings = []
    volumes = sheet.bodies.volumes_mm3()
    parts = parts_of(sheet.bodies)
    for body, solid in enumerate(solids):
        # NoError speaks of topology alone: the volume must be right as well
        wrong = abs(solid.volume() - volumes[body]) > _VOLUME_REL * volumes[body]
        status = solid.status()
        if status != Error.NoError or wrong or volumes[body] <= 0 or parts[body] != 1:
            panel = sheet.creases[body] < 0 <= sheet.faces[body]
            findings.append(
                Finding(
                    "solid-invalid",
                    Severity.ERROR,
                    f"{sheet.names[body].replace('_', ' ')} is not a valid solid: {status.name}, "
                    f"{parts[body]} parts, volume {solid.volume():.6g} of {volumes[body]:.6g} mm3. "
                    "Report this with the job.",
                    creases=(int(sheet.creases[body]),) if sheet.creases[body] >= 0 else (),
                    panels=(int(sheet.faces[body]),) if panel else (),
                )
            )
    return findings


def inspect_joined(sheet: ThickSheet, joined: TriangleMesh) -> list[Finding]:
    """A finding where the joined surface is not closed, or has not the volume of all bodies."""
    from manifold3d import Error

    whole = manifold_of(joined)
    total = float(sheet.bodies.volumes_mm3().sum())
    if whole.status() == Error.NoError and abs(whole.volume() - total) <= _JOINED_REL * total:
        return []
    return [
        Finding(
            "joined-invalid",
            Severity.ERROR,
            f"The joined body is not a valid solid: {whole.status().name}, volume "
            f"{whole.volume():.6g} of {total:.6g} mm3. Report this with the job.",
        )
    ]


def parts_of(bodies: Bodies) -> IntArray:
    """Number of connected parts of every body, shape (n,)."""
    corners = bodies.triangles
    one, two = corners[:, [0, 1]].ravel(), corners[:, [1, 2]].ravel()
    size = len(bodies.vertices_coords)
    graph = coo_array((np.ones(len(one), bool), (one, two)), shape=(size, size))
    _, label = connected_components(graph, directed=False)
    _, member = np.unique(label, return_index=True)
    return np.bincount(bodies.vertices_body[member], minlength=len(bodies))


def held_together(sheet: ThickSheet) -> int:
    """Number of bodies that the panels make with their hinges of any kind."""
    panels = sheet.panels.faces
    size = len(panels)
    if not size:
        return 0
    pairs = sheet.pattern.edges_faces[sheet.held]
    one, two = np.searchsorted(panels, pairs.T)
    graph = coo_array((np.ones(len(one)), (one, two)), shape=(size, size))
    return int(connected_components(graph, directed=False)[0])
