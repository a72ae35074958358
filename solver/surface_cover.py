"""How much of a surface is under a sheet, and how far the sheet is from it."""

from __future__ import annotations

import numpy as np

from solver.targets.mesh_target import MeshTarget
from solver.targets.surface_mesh import SurfaceMesh
from solver.vectors import BoolArray, FloatArray, IntArray, norm

__all__ = ["covered", "surface_samples"]

_SAMPLES = 4000
# Fractions of the plastic number: places that fill a square evenly (M. Roberts, 2018).
_EVEN = np.array([0.7548776662466927, 0.5698402909980532])


def surface_samples(mesh: SurfaceMesh, count: int = _SAMPLES) -> tuple[IntArray, FloatArray]:
    """Places spread over a surface by area: faces (n,), and weights of their corners (n, 3).

    The same ones each time; n is `count`.
    """
    area = norm(mesh.doubled_areas)
    upto = np.cumsum(area) / area.sum()
    face = np.searchsorted(upto, (np.arange(count) + 0.5) / count)
    face = np.minimum(face, len(area) - 1)
    s, t = (np.arange(1, count + 1)[:, None] * _EVEN % 1).T
    over = s + t > 1
    s, t = np.where(over, 1 - s, s), np.where(over, 1 - t, t)
    return face, np.column_stack([1 - s - t, s, t])


def covered(
    target: MeshTarget, sheets: list[tuple[FloatArray, IntArray]], reach: float
) -> BoolArray:
    """Which of the `surface_samples` have a sheet above or below them within `reach`, shape (n,).

    sheets : vertices (nv, 3) and faces (nf, 4) of each.
    """
    import igl

    face, weights = surface_samples(target.mesh)
    points = (
        weights[..., None] * target.mesh.vertices_coords[target.mesh.faces_vertices[face]]
    ).sum(axis=1)
    normals = target.normal_at(face, weights)
    out = np.zeros(len(points), bool)
    # lengths in reaches: libigl lets rays pass through triangles whose area is below about 1e-6
    points = points / reach
    for coords, faces in sheets:
        coords = np.ascontiguousarray(coords / reach)
        triangles = np.concatenate([faces[:, [0, 1, 2]], faces[:, [0, 2, 3]]])
        tree = igl.AABB()
        tree.init(coords, triangles)
        for way in (normals, -normals):
            hit, far, _ = tree.intersect_ray_first(
                coords, triangles, points, np.ascontiguousarray(way), np.inf
            )
            out |= (np.asarray(hit).ravel() >= 0) & (np.asarray(far).ravel() <= 1)
    return out
