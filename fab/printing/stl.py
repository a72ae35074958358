"""STL files of bodies, and whether they need repair."""

from __future__ import annotations

import numpy as np

from fab.errors import Finding, Severity, counted
from fab.geometry.bodies import TriangleMesh
from fab.outputs import zip_bytes
from fab.panels.thick_sheet import ThickSheet
from solver.graphs import edge_keys
from solver.vectors import FloatArray, cross, norm

__all__ = ["body_stls", "inspect_stl", "stl_bytes"]

_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def stl_bytes(mesh: TriangleMesh) -> bytes:
    """Binary STL of a surface in mm.

    Normals are those of the corners as the file has them, in single precision.
    """
    corners = mesh.vertices_coords.astype(np.float32)[mesh.triangles]
    rows = np.zeros(len(corners), _TRIANGLE)
    rows["normal"] = _normals(corners.astype(np.float64))
    rows["corners"] = corners
    head = bytes(80) + len(rows).to_bytes(4, "little")
    return head + rows.tobytes()


def _normals(corners: FloatArray) -> FloatArray:
    area = cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    size = norm(area)[:, None]
    return np.where(size > 0, area / np.where(size > 0, size, 1.0), 0.0)


def body_stls(sheet: ThickSheet) -> bytes:
    """A zip archive of an STL file for each body, by its name, in the coordinates of the sheet."""
    meshes = (sheet.bodies.mesh(i) for i in range(len(sheet.bodies)))
    return zip_bytes(
        {f"{name}.stl": stl_bytes(mesh) for name, mesh in zip(sheet.names, meshes, strict=True)}
    )


def inspect_stl(mesh: TriangleMesh) -> list[Finding]:
    """A finding where the surface, in the single precision of STL files, needs repair.

    Readers merge corners that are equal. Then each edge must be between exactly two triangles, and
    no triangle may have two equal corners.
    """
    corners = mesh.vertices_coords.astype(np.float32)[mesh.triangles].reshape(-1, 3)
    _, number = np.unique(corners, axis=0, return_inverse=True)
    triangles = number.reshape(-1, 3)
    whole = (triangles != np.roll(triangles, -1, axis=1)).all(axis=1)
    collapsed = int((~whole).sum())
    start = triangles[whole].ravel()
    end = np.roll(triangles[whole], -1, axis=1).ravel()
    keys = edge_keys(np.column_stack([start, end]), len(corners))
    _, edge, times = np.unique(keys, return_inverse=True, return_counts=True)
    balance = np.bincount(edge, np.sign(end - start), len(times))
    unpaired = int(((times != 2) | (balance != 0)).sum())
    if not collapsed and not unpaired:
        return []
    return [
        Finding(
            "stl-not-closed",
            Severity.ERROR,
            "in the single precision of STL files "
            f"{counted(unpaired, 'edge of the surface is', 'edges of the surface are')} not "
            f"between two triangles, and {counted(collapsed, 'triangle has', 'triangles have')} no "
            "area: slicers must repair it. Print the 3MF file, or enlarge the gaps.",
        )
    ]
