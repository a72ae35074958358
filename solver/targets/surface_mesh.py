"""Triangle meshes with known topology: edges, rim loops, sides, genus, kind.

Edge k of a face runs from its corner k to the next one.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property

import numpy as np

from solver.errors import InvalidState, InvalidValue
from solver.graphs import labels
from solver.targets.triangles import triangle_edges
from solver.vectors import BoolArray, FloatArray, IntArray, cross, norm, points

__all__ = [
    "MeshKind",
    "SurfaceMesh",
    "corner_labels",
    "corner_pairs",
    "side_labels",
]


class MeshKind(StrEnum):
    """What a surface is, however it is bent."""

    DISC = "disc"
    RING = "ring"
    DISC_WITH_HOLES = "disc_with_holes"
    SPHERE = "sphere"
    TORUS = "torus"
    MOEBIUS = "moebius"
    OTHER = "other"


@dataclass(frozen=True)
class SurfaceMesh:
    """A connected surface of triangles, each edge with one or two of them; `of` checks it.

    Attributes
    ----------
    vertices_coords : shape (nv, 3), each vertex in a face. faces_vertices : shape (nf, 3),
        counterclockwise seen from the normals' side. On a one-sided mesh the windings of neighbours
        differ along a seam.

    >>> corners = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    >>> mesh = SurfaceMesh.of(corners, np.array([[0, 1, 2], [0, 2, 3]]))
    >>> mesh.kind, mesh.boundary_loops[0].tolist(), mesh.area
    (<MeshKind.DISC: 'disc'>, [0, 1, 2, 3], 1.0)
    """

    vertices_coords: FloatArray
    faces_vertices: IntArray

    def __post_init__(self) -> None:
        for array in (self.vertices_coords, self.faces_vertices):
            array.flags.writeable = False

    @classmethod
    def of(cls, vertices_coords: FloatArray, faces_vertices: IntArray) -> SurfaceMesh:
        """The mesh of these arrays, which are copied; numbers of vertices and faces stay.

        Raises `InvalidValue` for other shapes and `InvalidState` for what is no connected surface
        with all vertices used and, where it has two sides, with one winding.
        """
        coords = points("vertices_coords", vertices_coords).copy()
        faces = np.array(faces_vertices)
        if faces.ndim != 2 or faces.shape[1] != 3 or faces.dtype.kind not in "iu" or not len(faces):
            given = f"array of {faces.dtype}, shape {faces.shape}"
            bound = "be whole numbers of shape (nf, 3), nf > 0"
            raise InvalidValue("faces_vertices", given, bound, "Cut faces into triangles.")
        if faces.min() < 0 or faces.max() >= len(coords):
            bad = int(faces.min() if faces.min() < 0 else faces.max())
            bound = f"name vertices, from 0 to {len(coords) - 1}"
            raise InvalidValue("faces_vertices", bad, bound, "Number vertices from 0.")
        mesh = cls(coords, faces.astype(np.int64))
        mesh._require_surface()
        return mesh

    def _require_surface(self) -> None:
        cure = "Repair the mesh first."
        faces, count = self.faces_vertices, len(self.vertices_coords)
        unused = np.bincount(faces.ravel(), minlength=count) == 0
        if unused.any():
            vertex = int(np.flatnonzero(unused)[0])
            raise InvalidState("mesh", f"vertex {vertex} belongs to no face", "Leave it out.")
        if (faces == np.roll(faces, 1, axis=1)).any():
            raise InvalidState("mesh", "a face names a vertex twice", cure)
        uses = np.bincount(self.faces_edges.ravel())
        if uses.max() > 2:
            ends = self.edges_vertices[int(uses.argmax())].tolist()
            raise InvalidState("mesh", f"edge {ends} has {int(uses.max())} faces", cure)
        if labels(self.edges_faces[self.edges_faces[:, 1] >= 0], len(faces)).max() > 0:
            raise InvalidState("mesh", "the mesh has several pieces", cure)
        group = corner_labels(faces, self.edges_halves[~self.rim_edges])
        if group.max() >= count:
            _, first = np.unique(group, return_index=True)
            vertices = np.bincount(faces.ravel()[first], minlength=count)
            vertex = int(vertices.argmax())
            raise InvalidState("mesh", f"faces touch at vertex {vertex} alone", cure)
        if self.orientable and not self.wound.all():
            raise InvalidState("mesh", "faces are wound against their neighbours", cure)

    @cached_property
    def _edges(self) -> tuple[IntArray, IntArray]:
        return triangle_edges(self.faces_vertices, len(self.vertices_coords))

    @property
    def edges_vertices(self) -> IntArray:
        """Ends of each edge, rising, shape (ne, 2)."""
        return self._edges[0]

    @property
    def faces_edges(self) -> IntArray:
        """The edge after each corner of a face, shape (nf, 3)."""
        return self._edges[1]

    @cached_property
    def edges_halves(self) -> IntArray:
        """The half-edges of each edge, -1 for none, shape (ne, 2): 3 face + corner it begins at."""
        half = np.argsort(self.faces_edges.ravel(), kind="stable")
        edge = self.faces_edges.ravel()[half]
        first = np.ones(len(edge), bool)
        first[1:] = edge[1:] != edge[:-1]
        out = np.full((len(self.edges_vertices), 2), -1)
        out[edge[first], 0] = half[first]
        out[edge[~first], 1] = half[~first]
        return out

    @property
    def edges_faces(self) -> IntArray:
        """The one or two faces of each edge, -1 for none, shape (ne, 2)."""
        return self.edges_halves // 3

    @cached_property
    def wound(self) -> BoolArray:
        """Whether the faces of each inner edge agree in winding; true for rim edges, (ne,)."""
        start = self.faces_vertices.ravel()
        rising = start < np.roll(self.faces_vertices, -1, axis=1).ravel()
        sum_of = np.bincount(self.faces_edges.ravel(), np.where(rising, 1.0, -1.0))
        agrees: BoolArray = (sum_of == 0) | (self.edges_faces[:, 1] < 0)
        return agrees

    @cached_property
    def rim_edges(self) -> BoolArray:
        """Which edges have one face alone, shape (ne,)."""
        alone: BoolArray = self.edges_faces[:, 1] < 0
        return alone

    @cached_property
    def boundary_loops(self) -> tuple[IntArray, ...]:
        """Vertices along each loop of the rim, faces on the left; the longest loop first.

        On a one-sided mesh each loop has one of its two directions.
        """
        half = np.flatnonzero(self.rim_edges[self.faces_edges].ravel())
        start = self.faces_vertices.ravel()[half].tolist()
        end = np.roll(self.faces_vertices, -1, axis=1).ravel()[half].tolist()
        beside: dict[int, list[int]] = {}
        for a, b in zip(start, end, strict=True):
            beside.setdefault(a, []).append(b)
            beside.setdefault(b, []).append(a)
        loops, done = [], set[int]()
        for a, b in zip(start, end, strict=True):
            if a in done:
                continue
            loop, following = [a], b
            while following != a:
                loop.append(following)
                first, second = beside[following]
                following = second if first == loop[-2] else first
            done.update(loop)
            loops.append(np.array(loop, np.int64))
        lengths = [self.loop_length(loop) for loop in loops]
        order = sorted(range(len(loops)), key=lambda i: -lengths[i])
        return tuple(loops[i] for i in order)

    def loop_length(self, loop: IntArray) -> float:
        """Length of a closed loop of vertices."""
        corners = self.vertices_coords[loop]
        return float(norm(corners - np.roll(corners, -1, axis=0)).sum())

    @cached_property
    def sides(self) -> IntArray:
        """Labels of both sides of each face, shape (nf, 2): see `side_labels`."""
        inner = ~self.rim_edges
        return side_labels(self.edges_faces[inner], self.wound[inner], len(self.faces_vertices))

    @property
    def orientable(self) -> bool:
        """Whether the surface has two sides."""
        return bool(self.sides[0, 0] != self.sides[0, 1])

    @property
    def euler_characteristic(self) -> int:
        """Vertices less edges plus faces."""
        return len(self.vertices_coords) - len(self.edges_vertices) + len(self.faces_vertices)

    @property
    def genus(self) -> int:
        """Number of handles; on a one-sided surface of crosscaps (one for a Moebius band)."""
        missing = 2 - self.euler_characteristic - len(self.boundary_loops)
        return missing // 2 if self.orientable else missing

    @property
    def kind(self) -> MeshKind:
        """What the surface is. A disc with a single hole is a ring, as a tube is."""
        loops = len(self.boundary_loops)
        if not self.orientable:
            return MeshKind.MOEBIUS if (self.genus, loops) == (1, 1) else MeshKind.OTHER
        if self.genus == 0:
            few = (MeshKind.SPHERE, MeshKind.DISC, MeshKind.RING)
            return few[loops] if loops < len(few) else MeshKind.DISC_WITH_HOLES
        return MeshKind.TORUS if (self.genus, loops) == (1, 0) else MeshKind.OTHER

    @cached_property
    def doubled_areas(self) -> FloatArray:
        """Normals of the faces, as long as twice their areas, shape (nf, 3)."""
        first, second, third = (self.vertices_coords[self.faces_vertices[:, k]] for k in range(3))
        return cross(second - first, third - first)

    @property
    def area(self) -> float:
        """Area of all faces."""
        return float(norm(self.doubled_areas).sum() / 2)

    @cached_property
    def size(self) -> float:
        """Diagonal of the box around the mesh, along the coordinate axes."""
        return float(norm(np.ptp(self.vertices_coords, axis=0)))


def corner_pairs(triangles: IntArray, halves: IntArray) -> IntArray:
    """Corners that faces share along edges of two faces, shape (2 n, 2), of 3 nf corners.

    halves : half-edges of each of n edges, numbered as the corners where they begin, shape (n, 2).
    The pairs at one end of each edge come first, those at the other end follow.
    """
    first, second = halves.T
    flat = triangles.ravel()
    after, beyond = (corner - corner % 3 + (corner + 1) % 3 for corner in (first, second))
    same = flat[first] == flat[second]
    here = np.column_stack([first, np.where(same, second, beyond)])
    there = np.column_stack([after, np.where(same, beyond, second)])
    return np.concatenate([here, there])


def corner_labels(triangles: IntArray, halves: IntArray) -> IntArray:
    """Labels (3 nf,) of the corners of all faces: alike where faces meet along edges.

    halves : as for `corner_pairs`. Where vertices are numbered by the labels, faces come apart
    that touch at a vertex alone, or along an edge that is not among those given.
    """
    return labels(corner_pairs(triangles, halves), triangles.size)


def side_labels(neighbours: IntArray, agree: BoolArray, count: int) -> IntArray:
    """Labels (count, 2) of the sides that faces have: alike where one passes to the other.

    neighbours : faces at each inner edge, shape (n, 2). agree : whether they are wound alike.
    The first of a face's sides is that from which it is counterclockwise. A piece has one label
    where it is one-sided, else two.
    """
    first, second = neighbours.T
    across = np.where(agree, 0, 1)
    pairs = [np.column_stack([2 * first + s, 2 * second + (s ^ across)]) for s in (0, 1)]
    return labels(np.concatenate(pairs), 2 * count).reshape(-1, 2)
