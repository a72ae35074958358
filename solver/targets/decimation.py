"""Triangle meshes with fewer triangles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from solver.errors import InvalidState, require_count
from solver.targets.surface_mesh import SurfaceMesh
from solver.targets.triangles import TriangleTree, least_heights
from solver.vectors import FloatArray

__all__ = ["Decimation", "decimated"]

_FLAT = 1e-9


@dataclass(frozen=True)
class Decimation:
    """A mesh with fewer triangles.

    Attributes
    ----------
    mesh : of the same topology. distances : of the vertices that it had from it, shape (nv,).
    """

    mesh: SurfaceMesh
    distances: FloatArray


def decimated(mesh: SurfaceMesh, most: int) -> Decimation:
    """The mesh with at most `most` triangles, by edges collapsed where that moves it least.

    Each collapse keeps the topology, and puts its vertex where the sum of squared distances from
    the planes of the triangles around is least (Garland and Heckbert, "Surface simplification using
    quadric error metrics", SIGGRAPH 1997), by libigl. A mesh of no more triangles is returned as it
    is. Raises `InvalidState` for larger one-sided meshes, for which libigl has no collapses, and
    where so few triangles cannot have the same topology without flat ones.

    >>> x, y = np.mgrid[:9, :9].reshape(2, -1).astype(float)
    >>> number = np.arange(81).reshape(9, 9)
    >>> a, b, c, d = (k.ravel() for k in (number[:-1, :-1], number[1:, :-1],
    ...                                   number[1:, 1:], number[:-1, 1:]))
    >>> faces = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    >>> few = decimated(SurfaceMesh.of(np.column_stack([x, y, 0 * x]), faces), 40)
    >>> len(few.mesh.faces_vertices) <= 40, round(few.mesh.area, 5), few.distances.max() < 1e-6
    (True, 64.0, np.True_)
    """
    require_count("most", most, 4, "A closed surface has 4 triangles at least.")
    if len(mesh.faces_vertices) <= most:
        return Decimation(mesh, np.zeros(len(mesh.vertices_coords)))
    if not mesh.orientable:
        raise InvalidState("mesh", "a one-sided mesh cannot be decimated", "Make it coarser.")
    import igl

    middle = mesh.vertices_coords.mean(axis=0)
    scaled = (mesh.vertices_coords - middle) / mesh.size
    coords, faces, *_ = igl.qslim(scaled, mesh.faces_vertices.astype(np.int32), most)
    coords, faces = np.asarray(coords, np.float64), np.asarray(faces, np.int64)
    used, number = np.unique(faces, return_inverse=True)
    coords, faces = coords[used], number.reshape(-1, 3)
    few = SurfaceMesh.of(coords * mesh.size + middle, faces)
    same = (few.kind, few.genus, len(few.boundary_loops))
    flat = not (least_heights(coords, faces) > _FLAT).all()
    if flat or len(faces) > most or same != (mesh.kind, mesh.genus, len(mesh.boundary_loops)):
        state = f"the mesh of {len(mesh.faces_vertices)} triangles cannot have {most}"
        raise InvalidState("most", state, "Allow more.")
    distances = TriangleTree.of(few.vertices_coords, faces).nearest(mesh.vertices_coords)[0]
    return Decimation(few, distances)
