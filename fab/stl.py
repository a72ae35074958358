"""How do bodies become STL files that need no repair?"""

from __future__ import annotations

import numpy as np

from fab.bodies import TriangleMesh
from fab.package import zip_bytes
from fab.thick import ThickSheet
from solver.vectors import FloatArray, cross, norm

__all__ = ["body_stls", "stl_bytes"]

_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def stl_bytes(mesh: TriangleMesh) -> bytes:
    """Binary STL. Normals are those of the corners as the file has them, in single precision."""
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
    """A zip archive of an STL file for each body, by its name, all in their common place."""
    meshes = (sheet.bodies.mesh(i) for i in range(len(sheet.bodies)))
    return zip_bytes(
        {f"{name}.stl": stl_bytes(mesh) for name, mesh in zip(sheet.names, meshes, strict=True)}
    )
