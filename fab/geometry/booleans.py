"""Booleans of bodies by manifold3d, which keep track of their planar sides."""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from typing import TYPE_CHECKING

import numpy as np
import shapely

from fab.geometry.bodies import Bodies, TriangleMesh
from solver.graphs import labels
from solver.vectors import FloatArray, IntArray

if TYPE_CHECKING:
    from manifold3d import Manifold

__all__ = [
    "corners_and_triangles",
    "difference",
    "joined",
    "joined_mesh",
    "manifold_of",
    "manifolds",
    "meshes",
    "prism",
    "resolution_mm",
    "section",
    "solid",
]


def solid(mesh: TriangleMesh) -> Manifold:
    """A body as a manifold3d solid whose triangles know their planar side."""
    from manifold3d import Manifold, Mesh64

    return Manifold(
        Mesh64(
            np.ascontiguousarray(mesh.vertices_coords),
            mesh.triangles.astype(np.uint64),
            face_id=mesh.triangles_plane.astype(np.uint64),
        )
    )


def prism(ring: FloatArray, low_mm: float, high_mm: float) -> Manifold:
    """The upright solid over a counterclockwise polygon, shape (n, 2), corners to 1e-8 mm."""
    from manifold3d import CrossSection, Manifold

    flat = CrossSection([np.ascontiguousarray(ring)])
    return Manifold.extrude(flat, high_mm - low_mm).translate((0.0, 0.0, low_mm))


def section(mesh: TriangleMesh, z_mm: float) -> shapely.Geometry:
    """The plane figure in which a body is cut at a height."""
    rings = solid(mesh).slice(z_mm).to_polygons()
    figures = [shapely.Polygon(ring) for ring in rings if len(ring) > 2]
    # rings inside others are holes
    return reduce(shapely.symmetric_difference, figures, shapely.Polygon())


def meshes(solids: Sequence[Manifold]) -> list[TriangleMesh]:
    """The surfaces of solids; a side that was cut into pieces counts as several."""
    coords, triangles, sides = [], [], []
    for number, each in enumerate(solids):
        mesh = each.to_mesh64()
        corners = np.asarray(mesh.tri_verts, np.int64).reshape(-1, 3)
        # where the triangles of each of the bodies that it was made from begin
        begin = np.searchsorted(mesh.run_index, 3 * np.arange(len(corners)), "right") - 1
        run = np.asarray(mesh.run_original_id, np.int64)[begin]
        side = np.column_stack([run, np.asarray(mesh.face_id, np.int64)])
        coords.append(np.array(mesh.vert_properties[:, :3], np.float64))
        triangles.append(corners)
        sides.append(np.column_stack([np.full(len(corners), number), side]))
    if not coords:
        return []
    starts = np.cumsum([0, *map(len, coords)])
    shifted = [t + first for t, first in zip(triangles, starts.tolist(), strict=False)]
    piece = _pieces_of_sides(np.concatenate(shifted), np.concatenate(sides))
    ends = np.cumsum([len(t) for t in triangles])[:-1]
    pieces = np.split(piece, ends)
    return [TriangleMesh(*parts) for parts in zip(coords, triangles, pieces, strict=True)]


def _pieces_of_sides(triangles: IntArray, side: IntArray) -> IntArray:
    """Equal numbers for triangles of one side, shape (nt, k), that hang together over edges."""
    ends = np.concatenate([triangles[:, [k, (k + 1) % 3]] for k in range(3)])
    owner = np.tile(np.arange(len(triangles)), 3)
    low, high = ends.min(axis=1), ends.max(axis=1)
    order = np.lexsort((high, low))
    pairs = owner[order].reshape(-1, 2)  # every edge of a closed surface has two
    same = (side[pairs[:, 0]] == side[pairs[:, 1]]).all(axis=1)
    return labels(pairs[same], len(triangles))


def manifold_of(mesh: TriangleMesh) -> Manifold:
    """A closed surface as a manifold3d solid, in double precision."""
    from manifold3d import Manifold, Mesh64

    coords = np.ascontiguousarray(mesh.vertices_coords)
    return Manifold(Mesh64(coords, mesh.triangles.astype(np.uint64)))


def manifolds(bodies: Bodies) -> list[Manifold]:
    """Each body as a manifold3d solid."""
    return [manifold_of(bodies.mesh(i)) for i in range(len(bodies))]


def joined_mesh(bodies: Bodies) -> TriangleMesh:
    """The union of bodies that reach into each other, moved up or down to stand on z = 0.

    Corners nearer to each other than single precision resolves become one, so that files of that
    precision have no slivers.
    """
    from manifold3d import Manifold, OpType

    whole = Manifold.batch_boolean(manifolds(bodies), OpType.Add)
    # as an original, it forgets between which of the bodies its edges ran
    mesh = whole.as_original().simplify(resolution_mm(bodies)).to_mesh64()
    coords = np.array(mesh.vert_properties[:, :3], np.float64)
    coords[:, 2] -= coords[:, 2].min(initial=0.0)
    triangles = np.asarray(mesh.tri_verts, np.int64)
    plane: IntArray = np.asarray(mesh.face_id, np.int64)
    return TriangleMesh(coords, triangles, plane)


def resolution_mm(bodies: Bodies) -> float:
    """A distance that single precision resolves everywhere in the bodies, too small to print."""
    reach = float(np.abs(bodies.vertices_coords).max(initial=0.0))
    return max(1e-4, 2 * reach * float(np.finfo(np.float32).eps))


def corners_and_triangles(solid: Manifold) -> tuple[FloatArray, IntArray]:
    """Vertices, shape (nv, 3), and triangles, shape (nt, 3), of a manifold3d solid."""
    mesh = solid.to_mesh64()
    coords = np.array(mesh.vert_properties[:, :3], np.float64)
    return coords, np.asarray(mesh.tri_verts, np.int64)


def joined(solids: Sequence[Manifold]) -> Manifold:
    """All of some solids in one."""
    from manifold3d import Manifold, OpType

    return Manifold.batch_boolean(solids, OpType.Add)


def difference(solids: Sequence[Manifold]) -> Manifold:
    """The first of some solids without all others."""
    from manifold3d import Manifold, OpType

    return Manifold.batch_boolean(solids, OpType.Subtract)
