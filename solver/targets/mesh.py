"""Surfaces of triangle and quad meshes, continued beyond their rim and over their holes."""

from __future__ import annotations

import io
import itertools
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from solver.errors import InvalidState, InvalidValue, require_count, require_length
from solver.graphs import edge_keys, labels
from solver.targets.frame import Frame, vector
from solver.targets.triangles import (
    TriangleTree,
    barycentric,
    corner_angles,
    least_heights,
    quads_cut,
    triangle_edges,
)
from solver.vectors import LARGEST, BoolArray, FloatArray, IntArray, cross, dot, norm, unit

__all__ = ["MeshSurface", "mesh_arrays"]

_FORMATS = ("glb", "obj", "off", "ply", "stl")
# Vertices closer than this are one, triangles flatter than this have no area, in sizes of the mesh.
_SAME = 1e-9
_FLAT = 1e-12
# How far from the origin a mesh may be, in sizes of it: growth loses as many digits.
_FARTHEST = 1000.0
# Feet whose barycentric coordinate is below this are on the opposite edge.
_ON_EDGE = 1e-9
# Width of the skirt in diagonals of the mesh, and how far the rim may lean over.
_SKIRT = 0.5
_OVERHANG = -0.1
# Rings of quads in the skirt: where it is twisted, smaller triangles meet at blunter edges.
_RINGS = 8
# How far, in radians about the middle, the teeth of a ragged rim may turn back.
_BACK = 0.2


@dataclass(frozen=True)
class MeshSurface:
    """The surface of a triangle mesh, with exact distances; `from_faces` and `read` check it.

    Places are (u, v, x, y, z, number of the triangle). Beyond its rim the mesh goes on as a skirt
    of triangles, straight in the tangent planes there, and holes are covered by fans.

    Attributes
    ----------
    vertices_coords : shape (n, 3).
    triangles : vertices counterclockwise seen from the normals' side, shape (m, 3).
    own : how many of the triangles are the mesh itself; the first ones, skirt and covers follow.
    frame : the box in which u and v are measured. Of several sheets the uppermost has them.
    """

    vertices_coords: FloatArray
    triangles: IntArray
    own: int
    frame: Frame

    @classmethod
    def read(
        cls, path: str | Path, *, up: ArrayLike | None = None, rows: ArrayLike | None = None
    ) -> MeshSurface:
        """The mesh in a GLB, OBJ, OFF, PLY or STL file, read by trimesh.

        `up` and `rows` are as in `from_faces`. trimesh cuts every quad from its first to its third
        corner. Where a file holds nothing but quads that is undone here, and the shorter diagonal
        taken.
        """
        mesh = mesh_arrays(path)
        return cls.from_faces(mesh["vertices_coords"], mesh["faces"], up=up, rows=rows)

    @classmethod
    def from_faces(
        cls,
        vertices_coords: FloatArray,
        faces: IntArray,
        *,
        up: ArrayLike | None = None,
        rows: ArrayLike | None = None,
        half_widths: tuple[float, float] | None = None,
    ) -> MeshSurface:
        """The surface of a mesh of at most a million triangles, or of quads.

        Repaired: vertices that coincide, vertices of no face, faces without area, repeated faces,
        faces wound against their neighbours. Refused, with `InvalidValue`: edges
        of three faces, one-sided meshes, several pieces, rims along which no skirt can be laid.

        faces : (m, 3), or (m, 4): quads, cut along their shorter diagonals.
        up : direction from which the surface is seen; its normals turn to that side (those of a
            closed mesh outwards). Default: the mean normal, which a closed mesh does not have.
        rows : direction of v. Default: the shorter side of the tightest rectangle around the mesh.
        half_widths : of the domain along u and v, about the middle; default: around all of the
            mesh.

        >>> corners = np.array([[0, 0, 0], [4, 0, 0], [4, 3, 0], [0, 3, 0]])
        >>> surface = MeshSurface.from_faces(corners, np.array([[0, 1, 2, 3]]))
        >>> point = np.array([[1.0, 2.0, 0.7]])
        >>> distance, gradient, places = surface.distance(point, point)
        >>> distance.tolist(), places[0, 2:5].round(9).tolist()
        ([0.7], [1.0, 2.0, 0.0])
        """
        coords, triangles = _checked(vertices_coords, faces)
        coords, triangles = _merged(coords, triangles)
        triangles = _oriented(triangles)
        ring = _rim(triangles, len(coords))
        doubled = cross(*(coords[triangles[:, i]] - coords[triangles[:, 0]] for i in (1, 2)))
        closed = not len(ring)
        if up is None:
            mean = doubled.sum(axis=0)
            if norm(mean) < 1e-6 * norm(doubled).sum():
                cure = "It is closed: cut it to the part to be followed, or give `up`."
                raise InvalidValue("up", None, "be given where normals cancel out", cure)
            up = unit(mean)
        third = vector("up", up)
        inwards = dot(coords[triangles[:, 0]], doubled).sum() < 0
        if inwards if closed else doubled.sum(axis=0) @ third < 0:
            triangles = triangles[:, ::-1].copy()
            ring = ring[:, ::-1]
        frame = Frame.around(coords, third, rows)
        if half_widths is not None:
            frame = Frame(frame.origin, frame.axes, np.array([*half_widths, frame.half_widths[2]]))
        size = float(np.linalg.norm(np.ptp(coords, axis=0)))
        own = triangles[least_heights(coords, triangles) > _FLAT * size]
        bare = cls(coords, own, len(own), frame)
        if closed:
            return bare
        every, extra = _continued(bare, ring, _SKIRT * size)
        return cls(every, np.vstack([own, extra]), len(own), frame)

    def places(self, uv: FloatArray) -> FloatArray:
        """Places (n, 6) with the parameters `uv`, on the uppermost sheet.

        NaN but for u and v where the line upwards misses even the skirt.
        """
        import shapely

        query, triangle = self._seen.query(shapely.points(uv), predicate="intersects")
        flat = self.frame.coordinates(self.vertices_coords)[self.triangles[triangle]]
        plane = np.concatenate([flat[..., :2], np.zeros((len(flat), 3, 1))], axis=-1)
        weights = barycentric(plane, np.pad(uv[query], ((0, 0), (0, 1))))
        # triangles seen from their edges have none, but then their neighbours are hit too
        good = np.flatnonzero(np.isfinite(weights[:, 0]))
        query, triangle, weights, flat = (x[good] for x in (query, triangle, weights, flat))
        order = np.lexsort((dot(weights, flat[..., 2]), query))
        last = np.searchsorted(query[order], np.arange(len(uv)), side="right") - 1
        hit = np.bincount(query, minlength=len(uv)) > 0
        best = order[last[hit]]
        corners = self.vertices_coords[self.triangles[triangle[best]]]
        places = np.column_stack([uv, np.full((len(uv), 4), np.nan)])
        places[hit, 2:5] = (weights[best][..., None] * corners).sum(axis=1)
        places[hit, 5] = triangle[best]
        return places

    def point(self, places: FloatArray) -> FloatArray:
        """Points of the surface, shape (n, 3)."""
        return places[:, 2:5]

    def normal(self, places: FloatArray) -> FloatArray:
        """Unit normals, the vertices' ones interpolated, so that they turn steadily, (n, 3)."""
        number = np.where(np.isnan(places[:, 5]), 0.0, places[:, 5]).astype(np.int64)
        corners, weights = self._feet(number, places[:, 2:5])
        return unit((weights[..., None] * self._vertex_normals[corners]).sum(axis=1))

    def distance(
        self,
        points: FloatArray,
        guess: FloatArray,  # noqa: ARG002  the nearest triangle of all needs none
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Signed distances (n,), their gradients (n, 3) and the nearest places (n, 6) of points.

        Exact: the nearest of all triangles. In a face's interior the gradient is its normal, else
        the direction from the foot to the point; signs by the pseudonormals of faces, edges and
        vertices (Baerentzen and Aanaes, IEEE TVCG 11, 2005), right for any angle of the faces.
        Points that are not finite stay so.
        """
        finite = np.logical_and.reduce(np.isfinite(points), axis=1)
        asked = np.where(finite[:, None], points, self.frame.origin)
        away, number, foot = self._tree.nearest(asked)
        corners, weights = self._feet(number, foot)
        flat = self._normals[number]
        zero = weights < _ON_EDGE
        edge, vertex = zero.sum(axis=1) == 1, zero.sum(axis=1) > 1
        pseudo = flat.copy()
        pseudo[edge] = self._edge_normals[number[edge], np.argmax(zero[edge], axis=1)]
        at = corners[vertex, np.argmax(weights[vertex], axis=1)]
        pseudo[vertex] = self._vertex_normals[at]
        off = asked - foot
        sign = np.where(dot(off, pseudo) < 0, -1.0, 1.0)
        inner = ~(edge | vertex)
        close = norm(off) <= _SAME * norm(self.frame.half_widths)
        gradient = np.where((inner | close)[:, None], flat, sign[:, None] * unit(off))
        gap = np.where(inner, dot(off, flat), sign * away)
        places = np.column_stack([self.frame.coordinates(foot)[:, :2], foot, number])
        for out in (gap, gradient, places):
            out[~finite] = np.nan
        return gap, gradient, places

    def inside(self, places: FloatArray) -> BoolArray:
        """Whether places are on the mesh itself and in the square of the parameters, (n,)."""
        within = np.abs(places[:, :2]).max(axis=1) <= 1 + 1e-9
        inside: BoolArray = within & (places[:, 5] < self.own)
        return inside

    def _feet(self, number: IntArray, foot: FloatArray) -> tuple[IntArray, FloatArray]:
        """Corners and barycentric coordinates of points in their triangles, each (n, 3)."""
        corners = self.triangles[number]
        return corners, barycentric(self.vertices_coords[corners], foot)

    @cached_property
    def _tree(self) -> TriangleTree:
        return TriangleTree.of(self.vertices_coords, self.triangles)

    @cached_property
    def _seen(self) -> Any:
        """Tree of the triangles as they are seen along the third axis."""
        import shapely

        flat = self.frame.coordinates(self.vertices_coords)[self.triangles][..., :2]
        return shapely.STRtree(shapely.polygons(flat))

    @cached_property
    def _normals(self) -> FloatArray:
        p = self.vertices_coords[self.triangles]
        return unit(cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]))

    @cached_property
    def _vertex_normals(self) -> FloatArray:
        """Sums of the faces' normals, weighted by their angles, unit, shape (n, 3)."""
        angles = corner_angles(self.vertices_coords, self.triangles)
        weighted = angles[..., None] * self._normals[:, None]
        out = np.zeros_like(self.vertices_coords)
        np.add.at(out, self.triangles, weighted)
        out[~out.any(axis=1)] = self.frame.axes[2]  # vertices of no triangle with an area
        return unit(out)

    @cached_property
    def _edge_normals(self) -> FloatArray:
        """Sum of the normals on both sides of the edge opposite each corner, shape (m, 3, 3)."""
        edges, number = triangle_edges(self.triangles, len(self.vertices_coords))
        total = np.zeros((len(edges), 3))
        np.add.at(total, number, self._normals[:, None])
        return total[np.roll(number, -1, axis=1)]


def _checked(vertices_coords: FloatArray, faces: IntArray) -> tuple[FloatArray, IntArray]:
    """Finite vertices and triangles that name them; quads cut."""
    coords, numbers = np.asarray(vertices_coords, np.float64), np.asarray(faces)
    _require_mesh(coords, numbers)
    require_count("triangles", len(numbers) * (numbers.shape[1] - 2), 1, "Make the mesh coarser.")
    lost = ~(np.abs(coords) <= LARGEST).all(axis=1)
    if lost.any():
        vertex = int(np.flatnonzero(lost)[0])
        cure = f"It is vertex {vertex}: export the mesh again."
        bound = f"be finite and within {LARGEST:g}"
        raise InvalidValue("vertices_coords", coords[vertex].tolist(), bound, cure)
    triangles = numbers.astype(np.int64)
    if triangles.shape[1] == 4:
        triangles = quads_cut(coords, triangles)
    return coords, triangles


def _require_mesh(coords: FloatArray, numbers: IntArray) -> None:
    """Raise `InvalidValue` unless these are points in space, and faces that name them."""
    if coords.ndim != 2 or coords.shape[1] != 3:
        raise InvalidValue("vertices_coords", coords.shape, "have the shape (n, 3)", "Give points.")
    if numbers.ndim != 2 or numbers.shape[1] not in (3, 4) or numbers.dtype.kind not in "iu":
        cure = "Cut larger faces into triangles."
        bound = "be whole numbers of shape (m, 3) or (m, 4)"
        raise InvalidValue("faces", f"{numbers.dtype} {numbers.shape}", bound, cure)
    if not len(numbers):
        raise InvalidValue("triangles", 0, "be 1 or more", "Export the mesh with its faces.")
    if numbers.min() < 0 or numbers.max() >= len(coords):
        bad = int(numbers.min() if numbers.min() < 0 else numbers.max())
        bound = f"name vertices, from 0 to {len(coords) - 1}"
        raise InvalidValue("faces", bad, bound, "The mesh is damaged: export it again.")


def mesh_arrays(path: str | Path) -> dict[str, Any]:
    """Vertices and faces of a GLB, OBJ, OFF, PLY or STL file, as `MeshSurface.read` takes them.

    Their names are "vertices_coords", shape (n, 3), and "faces", triangles or quads. Raises
    `InvalidValue` for what is no mesh.
    """
    file = Path(path)
    ending = file.suffix.lower().removeprefix(".")
    if ending not in _FORMATS:
        cure = "Export the mesh as one of these."
        raise InvalidValue("path", str(path), f"end in .{', .'.join(_FORMATS)}", cure)
    if not file.is_file():
        raise InvalidValue("path", str(path), "name a file", "Look at its spelling.")
    import trimesh

    try:
        data = io.BytesIO(file.read_bytes())  # without a path no other files are looked for
        mesh = trimesh.load_mesh(data, file_type=ending, process=False)
    except Exception as error:  # readers of foreign files raise all kinds
        reason = " ".join(str(error).split())[:200].rstrip(".") or "it is damaged"
        cure = f"trimesh reports: {reason}. Export it again."
        raise InvalidValue("path", str(path), f"be a readable {ending} file", cure) from error
    triangles = np.asarray(getattr(mesh, "faces", np.empty((0, 3))), np.int64)
    if not len(triangles):
        cure = "It is empty, cut off, or holds points and lines alone: export the mesh again."
        raise InvalidState("path", f"{path} must hold at least one face", cure)
    coords = np.asarray(mesh.vertices, np.float64)
    _require_mesh(coords, triangles)
    quads = None if ending == "stl" else _quads_again(triangles)
    return {"vertices_coords": coords, "faces": triangles if quads is None else quads}


def _quads_again(triangles: IntArray) -> IntArray | None:
    """The quads (m, 4) that trimesh cut into first halves abc, then second halves cda; or None."""
    half, odd = divmod(len(triangles), 2)
    first, second = triangles[:half], triangles[half:]
    if odd or not np.array_equal(first[:, [2, 0]], second[:, [0, 2]]):
        return None
    return np.column_stack([first, second[:, 1]])


def _merged(coords: FloatArray, triangles: IntArray) -> tuple[FloatArray, IntArray]:
    """Coinciding vertices made one; unused ones, lines and repeated triangles dropped."""
    used = np.unique(triangles)
    size = float(np.linalg.norm(np.ptp(coords[used], axis=0)))
    require_length("size of the mesh", size)
    far = float(norm((coords[used].min(axis=0) + coords[used].max(axis=0)) / 2)) / size
    if far > _FARTHEST:
        name = "distance of the mesh from the origin"
        bound = f"be at most {_FARTHEST:g} of its sizes"
        cure = "Coordinates so far out have too few digits for growth: move it nearer."
        raise InvalidValue(name, f"{far:.6g} of its sizes", bound, cure)
    pairs = cKDTree(coords[used]).query_pairs(_SAME * size, output_type="ndarray")
    group = labels(pairs, len(used))
    _, first = np.unique(group, return_index=True)
    place = np.empty(len(coords), np.int64)
    place[used] = group
    triangles = place[triangles]
    triangles = triangles[(triangles != np.roll(triangles, 1, axis=1)).all(axis=1)]
    _, first_use = np.unique(np.sort(triangles, axis=1), axis=0, return_index=True)
    triangles = triangles[np.sort(first_use)]
    coords = coords[used][first]
    if not (least_heights(coords, triangles) > _FLAT * size).any():
        cure = "All of its faces are lines or points."
        raise InvalidValue("area of the mesh", 0.0, "be greater than 0", cure)
    kept, numbers = np.unique(triangles, return_inverse=True)
    return coords[kept], numbers.reshape(-1, 3)


def _oriented(triangles: IntArray) -> IntArray:
    """Triangles in one winding; refuses edges of three faces, one-sided meshes, several pieces."""
    count = int(triangles.max()) + 1
    edges, number = triangle_edges(triangles, count)
    uses = np.bincount(number.ravel())
    if uses.max() > 2:
        edge = int(uses.argmax())
        cure = f"It is the edge at vertices {edges[edge].tolist()}: take the faces there apart."
        raise InvalidValue("faces at an edge", int(uses[edge]), "be 1 or 2", cure)
    face = np.argsort(number.ravel(), kind="stable") // 3
    begin = np.concatenate([[0], np.cumsum(uses)[:-1]])[uses == 2]
    sizes = np.bincount(labels(np.column_stack([face[begin], face[begin + 1]]), len(triangles)))
    if len(sizes) > 1:
        sizes = np.sort(sizes)[::-1]
        cure = f"They have {', '.join(map(str, sizes[:5]))} triangles: keep one, or join them."
        raise InvalidValue("pieces of the mesh", len(sizes), "be 1", cure)
    import igl

    turned = np.asarray(igl.bfs_orient(triangles)[0], np.int64)
    ahead = np.stack([turned, np.roll(turned, -1, axis=1)], axis=-1)
    if len(np.unique(edge_keys(ahead, count, directed=True))) < turned.size:
        raise InvalidState(
            "mesh", "the mesh has one side only, like a Moebius strip", "Cut it open."
        )
    return turned


def _rim(triangles: IntArray, count: int) -> IntArray:
    """Edges (e, 2) with a face on one side, in its direction; each vertex begins one at most."""
    ends = np.column_stack([triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()])
    ahead, back = (edge_keys(pairs, count, directed=True) for pairs in (ends, ends[:, ::-1]))
    rim = ends[~np.isin(ahead, back)]
    uses = np.bincount(rim[:, 0], minlength=1)
    if uses.max() > 1:
        cure = f"Parts of the mesh touch at vertex {int(uses.argmax())} alone: take them apart."
        raise InvalidValue("rims at a vertex", int(uses.max()), "be 0 or 1", cure)
    return rim


def _loops(rim: IntArray) -> list[IntArray]:
    """The closed loops of vertices that rim edges form."""
    following = dict(rim.tolist())
    loops = []
    while following:
        vertex, after = following.popitem()
        loop = [vertex]
        while after != loop[0]:
            loop.append(after)
            after = following.pop(after)
        loops.append(np.array(loop, np.int64))
    return loops


def _continued(bare: MeshSurface, rim: IntArray, width: float) -> tuple[FloatArray, IntArray]:
    """All vertices, and the triangles of the skirt around the outer rim and of covers over holes.

    The skirt leaves the rim away from the middle, seen along the third axis, in the tangent planes
    of the vertices: neighbours never cross where the rim goes once around the middle. Where teeth
    of the rim turn back a little, the skirt passes over or under them.
    """
    flat = bare.frame.coordinates(bare.vertices_coords)[:, :2] * bare.frame.half_widths[:2]
    added: list[FloatArray] = []
    extra: list[IntArray] = []
    count = len(bare.vertices_coords)
    loops = sorted(_loops(rim), key=lambda loop: int(loop.min()))
    outer = [_turn(flat[loop], flat[np.roll(loop, -1)]).sum() > 0 for loop in loops]
    if sum(outer) > 1:
        cure = "Cut the mesh to the part to be followed, or look at it from another side (`up`)."
        raise InvalidValue("outer rims", sum(outer), "be 1, seen along the third axis", cure)
    for loop, is_outer in zip(loops, outer, strict=True):
        after = np.roll(loop, -1)
        if is_outer:
            points = _skirt(bare, flat, loop, width)
            rings = np.vstack([loop, count + np.arange(len(points)).reshape(_RINGS, -1)])
            for ring, out in itertools.pairwise(rings):
                on, out_on = np.roll(ring, -1), np.roll(out, -1)
                extra += [np.column_stack([on, ring, out]), np.column_stack([out, out_on, on])]
        else:
            points = bare.vertices_coords[loop].mean(axis=0)[None]
            middle = flat[loop].mean(axis=0)
            if not (_turn(flat[loop] - middle, flat[after] - middle) < 0).all():
                raise InvalidState(
                    "mesh",
                    f"the hole of {len(loop)} sides at vertex {int(loop.min())} is not star-shaped",
                    "Fill it in the mesh.",
                )
            extra.append(np.column_stack([after, loop, np.full(len(loop), count)]))
        added.append(points)
        count += len(points)
    every = np.vstack([bare.vertices_coords, *added])
    triangles = np.vstack(extra)
    return every, triangles[least_heights(every, triangles) > _FLAT * width]


def _skirt(bare: MeshSurface, flat: FloatArray, loop: IntArray, width: float) -> FloatArray:
    """Vertices of the skirt, ring after ring, each parallel to the outer rim, shape (k n, 3)."""
    third = bare.frame.axes[2]
    normal = bare._vertex_normals[loop]
    steep = normal @ third
    if steep.min() < _OVERHANG:
        cure = "The mesh bends back under itself at its rim: cut it off above."
        raise InvalidValue("upward normal at the rim", float(steep.min()), "be above -0.1", cure)
    angle = np.unwrap(np.arctan2(flat[loop, 1], flat[loop, 0]))
    around = np.concatenate([angle - 2 * np.pi, angle, angle + 2 * np.pi])
    ahead = np.maximum.accumulate(around)[len(loop) : -len(loop)]
    behind = np.minimum.accumulate(around[::-1])[::-1][len(loop) : -len(loop)]
    step = np.diff(angle, append=angle[0] + 2 * np.pi)
    back = float((ahead - behind).max()) if np.abs(step).max() < np.pi else np.inf
    if back > _BACK:
        cure = "Cut the mesh to a rounder outline, or look at it from another side (`up`)."
        bound = f"be below {_BACK}: it goes once around the middle"
        raise InvalidValue("angle by which the outer rim turns back", back, bound, cure)
    onwards = (ahead + behind) / 2  # both rise steadily, so that the skirt does not cross itself
    outwards = np.column_stack([np.cos(onwards), np.sin(onwards)]) @ bare.frame.axes[:2]
    sideways = cross(np.broadcast_to(third, outwards.shape), outwards)
    steps = np.linspace(0.0, width, _RINGS + 1)[1:, None, None] * unit(cross(sideways, normal))
    return (bare.vertices_coords[loop] + steps).reshape(-1, 3)


def _turn(first: FloatArray, second: FloatArray) -> FloatArray:
    """Twice the signed areas of plane triangles (0, first, second), shape (n,)."""
    out: FloatArray = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
    return out
