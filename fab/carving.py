"""What is left of a body when others are cut away from it, or when it alone of them is kept?

What comes out has its planar sides told apart again, each in one piece.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import shapely
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from fab.bodies import TriangleMesh, stacked
from solver.vectors import FloatArray, IntArray

if TYPE_CHECKING:
    from manifold3d import Manifold

__all__ = ["carved", "common", "prism", "section", "shadow"]

# Plane figures of bodies are told on a grid, so that their sides meet.
_GRID_MM = 1e-6


def prism(ring: FloatArray, low_mm: float, high_mm: float) -> TriangleMesh:
    """The upright solid over a plain counterclockwise polygon, shape (n, 2)."""
    rings = np.stack([ring, ring], axis=1)
    return stacked(rings, np.array([0, len(ring)]), np.array([low_mm, high_mm])).mesh(0)


def carved(body: TriangleMesh, cutters: Sequence[TriangleMesh]) -> TriangleMesh:
    """The body without what lies in any of the cutters."""
    from manifold3d import Manifold, OpType

    solids = [_solid(mesh) for mesh in (body, *cutters)]
    return _mesh(Manifold.batch_boolean(solids, OpType.Subtract))


def common(one: TriangleMesh, two: TriangleMesh) -> TriangleMesh:
    """What lies in both bodies."""
    return _mesh(_solid(one) ^ _solid(two))


def section(body: TriangleMesh, z_mm: float) -> shapely.Geometry:
    """The plane figure in which a body is cut at a height."""
    rings = _solid(body).slice(z_mm).to_polygons()
    # rings inside others are holes
    return shapely.symmetric_difference_all([shapely.Polygon(r) for r in rings if len(r) > 2])


def shadow(body: TriangleMesh) -> shapely.Geometry:
    """The plane figure over which a body stands, to `_GRID_MM`."""
    corners = body.vertices_coords[body.triangles][:, :, :2]
    return shapely.union_all(shapely.polygons(corners), grid_size=_GRID_MM)


def _solid(mesh: TriangleMesh) -> Manifold:
    """A body whose triangles know their planar side."""
    from manifold3d import Manifold, Mesh64

    return Manifold(
        Mesh64(
            np.ascontiguousarray(mesh.vertices_coords),
            mesh.triangles.astype(np.uint64),
            face_id=mesh.triangles_plane.astype(np.uint64),
        )
    )


def _mesh(solid: Manifold) -> TriangleMesh:
    mesh = solid.to_mesh64()
    triangles = np.asarray(mesh.tri_verts, np.int64).reshape(-1, 3)
    # where the triangles of each of the bodies that it was made from begin
    begin = np.searchsorted(mesh.run_index, 3 * np.arange(len(triangles)), "right") - 1
    run = np.asarray(mesh.run_original_id, np.int64)[begin]
    side = np.column_stack([run, np.asarray(mesh.face_id, np.int64)])
    coords = np.array(mesh.vert_properties[:, :3], np.float64)
    return TriangleMesh(coords, triangles, _pieces_of_sides(triangles, side))


def _pieces_of_sides(triangles: IntArray, side: IntArray) -> IntArray:
    """Equal numbers for triangles of one side, shape (nt, k), that hang together over edges."""
    ends = np.concatenate([triangles[:, [k, (k + 1) % 3]] for k in range(3)])
    owner = np.tile(np.arange(len(triangles)), 3)
    low, high = ends.min(axis=1), ends.max(axis=1)
    order = np.lexsort((high, low))
    one, two = owner[order[::2]], owner[order[1::2]]  # every edge of a closed surface has two
    same = (side[one] == side[two]).all(axis=1)
    pairs = (np.ones(int(same.sum())), (one[same], two[same]))
    graph = coo_array(pairs, shape=(len(triangles),) * 2)
    return np.asarray(connected_components(graph, directed=False)[1], np.int64)
