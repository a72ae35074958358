"""How are solids united and cut so that their planar sides are still known?"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from fab.bodies import TriangleMesh
from solver.vectors import IntArray

if TYPE_CHECKING:
    from manifold3d import Manifold

__all__ = ["carved_mesh", "manifold_with_sides"]


def manifold_with_sides(mesh: TriangleMesh, names: IntArray) -> Manifold:
    """A closed surface as a manifold3d solid whose triangles keep names, shape (nt,)."""
    from manifold3d import Manifold, Mesh64

    return Manifold(
        Mesh64(
            np.ascontiguousarray(mesh.vertices_coords),
            mesh.triangles.astype(np.uint64),
            face_id=names.astype(np.uint64),
        )
    )


def carved_mesh(solid: Manifold) -> TriangleMesh:
    """The surface of what became of such solids.

    Triangles of one name that hang together by their edges are one planar side: what was one side
    may be cut to several.
    """
    mesh = solid.to_mesh64()
    triangles = np.asarray(mesh.tri_verts, np.int64)
    names = np.asarray(mesh.face_id, np.int64)
    count = len(triangles)
    ends = np.sort(np.concatenate([triangles[:, [k, (k + 1) % 3]] for k in range(3)]), axis=1)
    owner = np.tile(np.arange(count), 3)
    order = np.lexsort((ends[:, 1], ends[:, 0]))
    one, two = owner[order[:-1]], owner[order[1:]]
    joint = (ends[order[:-1]] == ends[order[1:]]).all(axis=1) & (names[one] == names[two])
    graph = coo_array((np.ones(joint.sum()), (one[joint], two[joint])), shape=(count, count))
    plane = connected_components(graph, directed=False)[1].astype(np.int64)
    coords = np.array(mesh.vert_properties[:, :3], np.float64)
    return TriangleMesh(coords, triangles, plane)
