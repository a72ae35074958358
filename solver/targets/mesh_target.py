"""Triangle meshes of any topology as targets: interpolated normals, tangents beyond the rim."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from solver.errors import InvalidState, InvalidValue
from solver.graphs import labels
from solver.targets.surface_mesh import SurfaceMesh, corner_pairs
from solver.targets.triangles import TriangleTree, barycentric, corner_angles
from solver.vectors import (
    BoolArray,
    FloatArray,
    IntArray,
    cross,
    dot,
    norm,
    scattered,
    unit,
)

__all__ = ["MeshTarget"]

# Nearest points whose barycentric coordinate is below this are on the opposite edge.
_ON_EDGE = 1e-9
# Tangential distances below this, in sizes of the mesh, are rounding.
_SAME = 1e-9
# Faces narrower than this share of their length have no area in the map.
_FLAT = 1e-12
_X, _FACE, _WEIGHTS, _SIDE, _RIM = slice(2, 5), 5, slice(6, 8), 8, 9
_COLUMNS = 10


@dataclass(frozen=True)
class MeshTarget:
    """The surface of a triangle mesh, followed as a smooth one.

    The normal at a point is interpolated from those of the vertices, so that it turns steadily.
    Beyond the rim the surface goes on as the tangent plane at the nearest point of the rim. On a
    one-sided mesh distances are signed by the side on which the guess is.

    Places are (u, v, x, y, z, face, weights of its second and third corner, side, on the rim):
    the weights give the nearest point of the mesh, x, y, z the nearest one of the surface, which
    differs from it beyond the rim. The side is 1 or -1, and 1 on meshes with two sides.

    Attributes
    ----------
    mesh : the surface. corners_uv : parameters of the corners of each face, shape (nf, 3, 2), as a
        map of the surface has them; None: u and v are NaN, and there are no `places`.
    period : by how much u grows once around the surface; None where the map does not close.

    >>> corners = np.array([[0.0, 0, 0], [4, 0, 0], [4, 3, 0], [0, 3, 0]])
    >>> target = MeshTarget(SurfaceMesh.of(corners, np.array([[0, 1, 2], [0, 2, 3]])))
    >>> points = np.array([[1.0, 2.0, 0.5], [7.0, 2.0, -0.5]])
    >>> distances, normals, places = target.distance(points, target.unknown(2))
    >>> distances.tolist(), target.on_rim(places).tolist(), target.point(places).tolist()
    ([0.5, -0.5], [False, True], [[1.0, 2.0, 0.0], [7.0, 2.0, 0.0]])
    """

    mesh: SurfaceMesh
    corners_uv: FloatArray | None = None
    period: float | None = None

    def __post_init__(self) -> None:
        shape = (len(self.mesh.faces_vertices), 3, 2)
        if self.corners_uv is not None and self.corners_uv.shape != shape:
            cure = "Give u and v of the corners of each face."
            raise InvalidValue("corners_uv", self.corners_uv.shape, f"have shape {shape}", cure)

    @staticmethod
    def unknown(count: int) -> FloatArray:
        """Guesses of places of which nothing is known, shape (count, 10)."""
        return np.full((count, _COLUMNS), np.nan)

    def places(self, uv: FloatArray) -> FloatArray:
        """Places (n, 10) with the parameters `uv`; beyond the map its nearest triangle goes on.

        Raises `InvalidState` on a mesh without a map.
        """
        if self.corners_uv is None:
            raise InvalidState("corners_uv", "the mesh has no map", "Give it parameters.")
        asked = np.pad(uv, ((0, 0), (0, 1)))
        if self.period is not None:
            asked[:, 0] -= self.period * np.floor(asked[:, 0] / self.period)
        faces, corners = self._flat
        _, found, foot = self._map_tree.nearest(asked)
        face, flat = faces[found], corners[found]
        weights = barycentric(flat, foot)
        out = self._place(face, weights, np.ones(len(uv)), self._on_rim(face, weights))
        space = self.mesh.vertices_coords[self.mesh.faces_vertices[face]]
        ahead = (barycentric(flat, asked)[..., None] * space).sum(axis=1) - out[:, _X]
        normal = self.normal(out)
        beyond = out[:, _RIM] > 0
        along = ahead - dot(ahead, normal)[:, None] * normal
        out[beyond, _X] += along[beyond]
        out[:, :2] = uv
        return out

    def point(self, places: FloatArray) -> FloatArray:
        """Points of the surface, shape (n, 3)."""
        return places[:, _X]

    def mesh_point(self, places: FloatArray) -> FloatArray:
        """Points of the mesh, beyond the rim those of the rim, shape (n, 3)."""
        face, weights = _face_and_weights(places)
        corners = self.mesh.vertices_coords[self.mesh.faces_vertices[face]]
        out: FloatArray = (weights[..., None] * corners).sum(axis=1)
        return out

    def normal(self, places: FloatArray) -> FloatArray:
        """Unit normals, interpolated between those of the vertices, shape (n, 3)."""
        face, weights = _face_and_weights(places)
        return places[:, _SIDE, None] * self.normal_at(face, weights)

    def distance(
        self, points: FloatArray, guess: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Signed distances (n,) of points, normals (n, 3), the nearest places (n, 10).

        The nearest of all triangles is found; signs are those of the pseudonormals of faces, edges
        and vertices (Baerentzen and Aanaes, IEEE TVCG 11, 2005). Where the nearest point p is on
        the rim, the distance is (x - p) . n with the normal n there. The normals are interpolated;
        those of the triangles themselves turn in jumps. Points that are not finite give NaN.

        guess : places, used for their sides on a one-sided mesh alone; `unknown` will do.
        """
        finite = np.logical_and.reduce(np.isfinite(points), axis=1)
        asked = np.where(finite[:, None], points, self.mesh.vertices_coords[0])
        gap, face, foot = self._tree.nearest(asked)
        weights = barycentric(self.mesh.vertices_coords[self.mesh.faces_vertices[face]], foot)
        normal = self.normal_at(face, weights)
        rim = self._on_rim(face, weights)
        off = asked - foot
        gap = np.where(dot(off, self._pseudonormal(face, weights)) < 0, -gap, gap)
        gap = np.where(rim, dot(off, normal), gap)
        side = self._side(normal, guess)
        out = self._place(face, weights, side, rim)
        out[rim, _X] = (asked - gap[:, None] * normal)[rim]
        if self.corners_uv is not None:
            corners = self.mesh.vertices_coords[self.mesh.faces_vertices[face[rim]]]
            reach = barycentric(corners, out[rim, _X])[..., None]
            out[rim, :2] = (reach * self.corners_uv[face[rim]]).sum(axis=1)
        gap, normal = side * gap, side[:, None] * normal
        for array in (gap, normal, out):
            array[~finite] = np.nan
        return gap, normal, out

    def on_rim(self, places: FloatArray) -> BoolArray:
        """Whether the nearest point of the mesh is on its rim, shape (n,)."""
        rim: BoolArray = places[:, _RIM] > 0
        return rim

    def inside(self, places: FloatArray) -> BoolArray:
        """Whether places are on the mesh itself, its rim included, shape (n,)."""
        beyond = norm(self.point(places) - self.mesh_point(places))
        inside: BoolArray = beyond <= _SAME * self.mesh.size
        return inside

    def _place(
        self, face: IntArray, weights: FloatArray, side: FloatArray, rim: BoolArray
    ) -> FloatArray:
        """Places on the mesh itself."""
        out = self.unknown(len(face))
        corners = self.mesh.vertices_coords[self.mesh.faces_vertices[face]]
        out[:, _X] = (weights[..., None] * corners).sum(axis=1)
        out[:, _FACE], out[:, _WEIGHTS] = face, weights[:, 1:]
        out[:, _SIDE], out[:, _RIM] = side, rim
        if self.corners_uv is not None:
            out[:, :2] = (weights[..., None] * self.corners_uv[face]).sum(axis=1)
        return out

    def _side(self, normal: FloatArray, guess: FloatArray) -> FloatArray:
        if self.mesh.orientable:
            return np.ones(len(normal))
        known = np.isfinite(guess[:, _SIDE])
        before = self.normal(np.where(known[:, None], guess, 0.0))
        return np.where(known & (dot(before, normal) < 0), -1.0, 1.0)

    def normal_at(self, face: IntArray, weights: FloatArray) -> FloatArray:
        """Interpolated unit normals on the first side of faces, shape (n, 3)."""
        mixed = unit((weights[..., None] * self._corner_normals[face]).sum(axis=1))
        lost = ~np.isfinite(mixed).all(axis=1)
        mixed[lost] = self._normals[face[lost]]
        return mixed

    def _pseudonormal(self, face: IntArray, weights: FloatArray) -> FloatArray:
        """Normals whose sides are those of the mesh, at points of faces, shape (n, 3)."""
        zero = weights < _ON_EDGE
        on = zero.sum(axis=1)
        out = self._normals[face]
        edge, vertex = on == 1, on > 1
        opposite = np.argmax(zero[edge], axis=1)
        out[edge] = self._edge_normals[face[edge], (opposite + 1) % 3]
        out[vertex] = self._corner_normals[face[vertex], np.argmax(weights[vertex], axis=1)]
        return out

    def _on_rim(self, face: IntArray, weights: FloatArray) -> BoolArray:
        """Whether points of faces are on the rim, shape (n,)."""
        zero = weights < _ON_EDGE
        on = zero.sum(axis=1)
        edge = self.mesh.faces_edges[face, (np.argmax(zero, axis=1) + 1) % 3]
        vertex = self.mesh.faces_vertices[face, np.argmax(weights, axis=1)]
        rim: BoolArray = ((on == 1) & self.mesh.rim_edges[edge]) | (
            (on > 1) & self._rim_vertices[vertex]
        )
        return rim

    @cached_property
    def _rim_vertices(self) -> BoolArray:
        out = np.zeros(len(self.mesh.vertices_coords), bool)
        out[self.mesh.edges_vertices[self.mesh.rim_edges]] = True
        return out

    @cached_property
    def _tree(self) -> TriangleTree:
        return TriangleTree.of(self.mesh.vertices_coords, self.mesh.faces_vertices)

    @cached_property
    def _flat(self) -> tuple[IntArray, FloatArray]:
        """Faces, shape (n,), and their corners in the map, with z = 0, shape (n, 3, 3).

        Faces that reach over one end of the period are at its other end as well. Faces without an
        area in the map, such as those of a ring with all corners on one rim, are left out.
        """
        corners = np.pad(np.asarray(self.corners_uv, np.float64), ((0, 0), (0, 0), (0, 1)))
        first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        area = norm(cross(first, second))
        faces = np.flatnonzero(area > _FLAT * np.maximum(dot(first, first), dot(second, second)))
        if not len(faces):
            raise InvalidState("corners_uv", "no face has an area in the map", "Mend the mesh.")
        corners = corners[faces]
        if self.period is None:
            return faces, corners
        u = corners[:, :, 0]
        copied = [np.flatnonzero(u.min(axis=1) < 0), np.flatnonzero(u.max(axis=1) > self.period)]
        moved = [
            corners[which] + np.array([shift, 0.0, 0.0])
            for which, shift in zip(copied, (self.period, -self.period), strict=True)
        ]
        return np.concatenate([faces, *copied]), np.concatenate([corners, *moved])

    @cached_property
    def _map_tree(self) -> TriangleTree:
        _, corners = self._flat
        return TriangleTree.of(corners.reshape(-1, 3), np.arange(corners.size // 3).reshape(-1, 3))

    @cached_property
    def _normals(self) -> FloatArray:
        return unit(self.mesh.doubled_areas)

    @cached_property
    def _edge_normals(self) -> FloatArray:
        """Sum of the normals on both sides of the edge after each corner, shape (nf, 3, 3)."""
        mesh = self.mesh
        other = mesh.edges_faces[mesh.faces_edges].sum(axis=2)
        other -= np.arange(len(other))[:, None]  # -1 beyond the rim
        sign = np.where(mesh.wound[mesh.faces_edges], 1.0, -1.0)
        sign[mesh.rim_edges[mesh.faces_edges]] = 0.0
        out: FloatArray = self._normals[:, None] + sign[..., None] * self._normals[other]
        return out

    @cached_property
    def _corner_normals(self) -> FloatArray:
        """Normals of the vertices on the first side of each face, unit, shape (nf, 3, 3).

        They are sums of the faces' normals, weighted by their angles. On a one-sided mesh each
        vertex has two, one for either side: those of its double cover.
        """
        mesh = self.mesh
        angles = corner_angles(mesh.vertices_coords, mesh.faces_vertices)
        weighted = (angles[..., None] * self._normals[:, None]).reshape(-1, 3)
        if mesh.orientable:
            vertex = mesh.faces_vertices
            sums = scattered(vertex.ravel(), weighted, len(mesh.vertices_coords))
            return unit(sums)[vertex]
        pairs = corner_pairs(mesh.faces_vertices, mesh.edges_halves[~mesh.rim_edges])
        across = np.tile(~mesh.wound[~mesh.rim_edges], 2).astype(np.int64)
        cover = [
            np.column_stack([2 * pairs[:, 0] + s, 2 * pairs[:, 1] + (s ^ across)]) for s in (0, 1)
        ]
        vertex = labels(np.concatenate(cover), 2 * len(weighted))
        both = np.stack([weighted, -weighted], axis=1).reshape(-1, 3)
        sums = scattered(vertex, both, int(vertex.max()) + 1)
        return unit(sums)[vertex[::2]].reshape(-1, 3, 3)


def _face_and_weights(places: FloatArray) -> tuple[IntArray, FloatArray]:
    """Faces (n,) and weights of their corners (n, 3); those of the first face for NaN."""
    known = np.nan_to_num(places[:, _FACE : _WEIGHTS.stop])
    return known[:, 0].astype(np.int64), np.column_stack(
        [1 - known[:, 1] - known[:, 2], known[:, 1:]]
    )
