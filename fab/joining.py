"""What single surface do bodies have that are printed as one?"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fab.bodies import Bodies, TriangleMesh
from solver.vectors import IntArray

if TYPE_CHECKING:
    from manifold3d import Manifold

__all__ = ["joined_mesh", "manifold_of", "manifolds", "told_apart_mm"]


def manifold_of(mesh: TriangleMesh) -> Manifold:
    """A closed surface as a manifold3d solid, in double precision."""
    from manifold3d import Manifold, Mesh64

    coords = np.ascontiguousarray(mesh.vertices_coords)
    return Manifold(Mesh64(coords, mesh.triangles.astype(np.uint64)))


def manifolds(bodies: Bodies) -> list[Manifold]:
    """Each body as a manifold3d solid."""
    return [manifold_of(bodies.mesh(i)) for i in range(len(bodies))]


def joined_mesh(bodies: Bodies) -> TriangleMesh:
    """The union of bodies that reach into each other, standing on z = 0.

    Corners nearer to each other than single precision can tell become one, so that files of that
    precision have no slivers.
    """
    from manifold3d import Manifold, OpType

    whole = Manifold.batch_boolean(manifolds(bodies), OpType.Add)
    # as an original, it forgets between which of the bodies its edges ran
    mesh = whole.as_original().simplify(told_apart_mm(bodies)).to_mesh64()
    coords = np.array(mesh.vert_properties[:, :3], np.float64)
    coords[:, 2] -= coords[:, 2].min(initial=0.0)
    triangles = np.asarray(mesh.tri_verts, np.int64)
    plane: IntArray = np.asarray(mesh.face_id, np.int64)
    return TriangleMesh(coords, triangles, plane)


def told_apart_mm(bodies: Bodies) -> float:
    """A distance that single precision resolves everywhere in the bodies, and no one can print."""
    reach = float(np.abs(bodies.vertices_coords).max(initial=0.0))
    return max(1e-4, 2 * reach * float(np.finfo(np.float32).eps))
