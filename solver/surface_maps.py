"""Maps of surfaces to the plane, stretched little: where the cells of a sheet are laid.

Discs are mapped so that no triangle turns over and the largest and smallest stretches stay near 1
(M. Rabinovich, R. Poranne, D. Panozzo and O. Sorkine-Hornung, "Scalable locally injective
mappings", ACM Transactions on Graphics 36 (2017)), from the least-squares conformal map (B. Levy
and others, "Least squares conformal maps", ACM Transactions on Graphics 21 (2002)). Rings are
mapped to a cylinder by a harmonic function and its conjugate. libigl does both.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
from scipy.sparse import csc_array
from scipy.sparse.linalg import splu

from solver.errors import InvalidState
from solver.graphs import edge_keys, labels, weighted_graph
from solver.targets.surface_mesh import MeshKind, SurfaceMesh
from solver.vectors import FloatArray, IntArray, cross, dot, norm, unit

__all__ = ["cylinder_map", "disc_map", "principal_turn"]

# Steps towards the least stretch; more change nothing that a sheet would notice.
_STEPS = 12
# Rounds in which a cylinder map is evened.
_EVENINGS = 40
# Places along a cylinder at which its girths are measured.
_STATIONS = 64


def disc_map(mesh: SurfaceMesh) -> FloatArray:
    """Flat coordinates of the corners of all faces, shape (nf, 3, 2), in the mesh's own lengths.

    Faces keep their winding; holes stay holes. Raises `InvalidState` for a mesh that is no disc,
    and for one with holes whose conformal map folds over.

    >>> corners = np.array([[0.0, 0, 0], [2, 0, 0], [2, 0, 1], [0, 0, 1]])
    >>> flat = disc_map(SurfaceMesh.of(corners, np.array([[0, 1, 2], [0, 2, 3]])))
    >>> sides = flat[:, [1, 2, 0]] - flat
    >>> np.hypot(sides[0, :, 0], sides[0, :, 1]).round(6).tolist()
    [2.0, 1.0, 2.236068]
    """
    import igl

    if mesh.kind not in (MeshKind.DISC, MeshKind.RING, MeshKind.DISC_WITH_HOLES):
        raise InvalidState("mesh", f"the mesh is a {mesh.kind}, not a disc", "Cut it open first.")
    coords, faces = np.array(mesh.vertices_coords), np.array(mesh.faces_vertices)
    size = np.sqrt(mesh.area)
    coords = (coords - coords.mean(axis=0)) / size
    start = _conformal(coords, faces, mesh.boundary_loops[0])
    if not (_turned(start[faces]) > 0).all():
        if mesh.kind is not MeshKind.DISC:
            raise InvalidState("mesh", "the mesh cannot be laid flat", "Fill its holes, or cut it.")
        start = _barycentric(coords, faces, mesh.boundary_loops[0])
    none = np.zeros(0, np.int32), np.asfortranarray(np.zeros((0, 2)))
    data = igl.slim_precompute(
        np.asfortranarray(coords),
        np.asfortranarray(faces.astype(np.int32)),
        np.asfortranarray(start),
        igl.MappingEnergyType.SYMMETRIC_DIRICHLET,
        *none,
        0.0,
    )
    flat = np.ascontiguousarray(igl.slim_solve(data, _STEPS)[:, :2])
    if not np.isfinite(flat).all():
        flat = start
    return np.asarray(size * flat[faces])


def cylinder_map(mesh: SurfaceMesh) -> tuple[FloatArray, float]:
    """Coordinates around and along a ring, shape (nf, 3, 2), and the period around it.

    Along it, the longer rim lies at 0 and the other one at the mean length of the way between
    them. Around it, the period is the mean girth. Within these, triangles keep their own shapes as
    well as they can. Each face's corners are near one another, their mean within one period.
    Raises `InvalidState` for other meshes.
    """
    import igl

    if mesh.kind is not MeshKind.RING:
        raise InvalidState("mesh", f"the mesh is a {mesh.kind}, not a ring", "Cut it open first.")
    coords, faces = np.array(mesh.vertices_coords), np.array(mesh.faces_vertices)
    size = np.sqrt(mesh.area)
    coords = (coords - coords.mean(axis=0)) / size
    stiff = csc_array(-igl.cotmatrix(coords, faces))
    first, last = mesh.boundary_loops
    ends = np.concatenate([first, last])
    height = _dirichlet(stiff, ends, np.repeat([0.0, 1.0], [len(first), len(last)])[:, None])[:, 0]
    flux = float(height @ (stiff @ height))
    later = _beyond_cut(mesh, first, last)
    angle = _conjugate(stiff, coords, faces, height, flux * later) / flux
    along, girth = _stations(coords, faces, height)
    across = np.interp(height, np.linspace(0, 1, len(along)), along)
    flat = np.column_stack([girth * angle, across])
    jumps = np.stack([girth * later, np.zeros_like(later)], axis=-1)
    if (_turned(flat[faces] + jumps) < 0).mean() > 0.5:  # around the other way: windings are kept
        flat, jumps = flat * [-1.0, 1.0], -jumps
    flat = _evened(stiff, coords, faces, flat, jumps, ends)
    corners = flat[faces] + jumps
    corners[:, :, 0] -= girth * np.floor(corners[:, :, 0].mean(axis=1) / girth)[:, None]
    return size * corners, size * girth


def principal_turn(corners_uv: FloatArray) -> float:
    """Direction of the longest extent of a map, radians in (-pi/2, pi/2], from its u axis.

    corners_uv : shape (nf, 3, 2); weights are the areas of the faces.
    """
    area = np.abs(_turned(corners_uv))
    middle = corners_uv.mean(axis=1)
    centroid = (area[:, None] * middle).sum(axis=0) / area.sum()
    # three corners and nine times the middle have the second moments of a triangle
    arms = np.concatenate([corners_uv, 3 * (middle - centroid)[:, None] + centroid], axis=1)
    arms = arms - centroid
    spread = np.einsum("f,fki,fkj->ij", area, arms, arms)
    if np.hypot(spread[0, 0] - spread[1, 1], 2 * spread[0, 1]) <= 1e-6 * np.trace(spread):
        return 0.0  # as long as wide
    return float(np.arctan2(2 * spread[0, 1], spread[0, 0] - spread[1, 1]) / 2)


def _conformal(coords: FloatArray, faces: IntArray, loop: IntArray) -> FloatArray:
    """Least-squares conformal map, of as much area as the mesh, wound like it."""
    import igl

    far = loop[int(np.argmax(norm(coords[loop] - coords[loop[0]])))]
    pinned = np.array([loop[0], far], np.int64)
    places = np.array([[0.0, 0.0], [float(norm(coords[far] - coords[loop[0]])), 0.0]])
    flat = np.asarray(igl.lscm(coords, faces, pinned, places)[0])
    total = float(_turned(flat[faces]).sum())
    if not np.isfinite(total) or total == 0:
        return np.full((len(coords), 2), np.nan)
    if total < 0:
        flat = flat * [1.0, -1.0]
    return np.asarray(flat * np.sqrt(2 / abs(total)))


def _barycentric(coords: FloatArray, faces: IntArray, loop: IntArray) -> FloatArray:
    """Map whose rim is a circle and whose other vertices are means of their neighbours.

    No face turns over: W. T. Tutte, "How to draw a graph", Proceedings of the London Mathematical
    Society 13 (1963).
    """
    ends = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    i, j = np.concatenate([ends, ends[:, ::-1]]).T
    count = len(coords)
    near = csc_array((np.ones(len(i)), (i, j)), shape=(count, count))
    near.data[:] = 1.0
    degree = np.asarray(near.sum(axis=1)).ravel()
    graph = csc_array((degree, (np.arange(count), np.arange(count))), shape=(count, count)) - near
    lengths = norm(coords[np.roll(loop, -1)] - coords[loop])
    angle = 2 * np.pi * np.concatenate([[0.0], np.cumsum(lengths)[:-1]]) / lengths.sum()
    rim = np.column_stack([np.cos(angle), np.sin(angle)]) / np.sqrt(np.pi)
    return _dirichlet(graph, loop, rim)


def _dirichlet(stiff: Any, fixed: IntArray, values: FloatArray) -> FloatArray:
    """The harmonic functions with these values, shape (n, k), at the vertices `fixed`."""
    count = stiff.shape[0]
    out = np.zeros((count, values.shape[1]))
    out[fixed] = values
    free = np.setdiff1d(np.arange(count), fixed)
    if len(free):
        stiff = csc_array(stiff)
        right = -(stiff[free][:, fixed] @ values)
        out[free] = splu(csc_array(stiff[free][:, free])).solve(right)
    return out


def _beyond_cut(mesh: SurfaceMesh, first: IntArray, last: IntArray) -> FloatArray:
    """Which corners of faces lie beyond a cut between the rims, 0 or 1, shape (nf, 3).

    The cut is a shortest way along edges. Corners on it count as beyond it in the faces that touch
    it from its right.
    """
    from scipy.sparse.csgraph import dijkstra

    coords, faces, ends = mesh.vertices_coords, mesh.faces_vertices, mesh.edges_vertices
    lengths = norm(coords[ends[:, 1]] - coords[ends[:, 0]])
    graph = weighted_graph(lengths, ends, len(coords))
    distance, before, _ = dijkstra(
        graph, directed=False, indices=np.sort(first), return_predecessors=True, min_only=True
    )
    vertex = int(last[np.argmin(distance[last])])
    way = [vertex]
    while before[way[-1]] >= 0:
        way.append(int(before[way[-1]]))
    on_way = np.zeros(len(coords), bool)
    on_way[way] = True
    steps = np.array(list(pairwise(way)), np.int64).reshape(-1, 2)
    count = len(coords)
    walls = np.isin(edge_keys(ends, count), edge_keys(steps, count))
    # faces around the way, joined where they share an edge that is not on it
    touching = np.flatnonzero(on_way[faces].any(axis=1))
    rank = np.full(len(faces), -1)
    rank[touching] = np.arange(len(touching))
    inner = ~walls & ~mesh.rim_edges & on_way[ends].any(axis=1)
    beside = rank[mesh.edges_faces[inner]]
    group = labels(beside[(beside >= 0).all(axis=1)], len(touching))
    halves = np.stack([faces[touching], np.roll(faces[touching], -1, axis=1)], axis=-1)
    back = edge_keys(steps[:, ::-1], count, directed=True)
    against = np.isin(edge_keys(halves, count, directed=True), back).reshape(-1, 3).any(axis=1)
    right = np.isin(group, group[against])
    out = np.zeros(faces.shape)
    out[touching] = on_way[faces[touching]] & right[:, None]
    return out


def _conjugate(
    stiff: Any, coords: FloatArray, faces: IntArray, height: FloatArray, jumps: FloatArray
) -> FloatArray:
    """The function whose gradient is that of `height`, turned by 90 degrees, as near as can be.

    jumps : what is added to its values at corners, shape (nf, 3).
    """
    normal, doubled, hats = _hats(coords[faces])
    slope = (height[faces][:, :, None] * hats).sum(axis=1)
    wanted = np.cross(normal, slope) - (jumps[:, :, None] * hats).sum(axis=1)
    pull = doubled[:, None] / 2 * dot(hats, wanted[:, None])
    right = np.bincount(faces.ravel(), pull.ravel(), len(coords))
    out = np.zeros(len(coords))
    out[1:] = splu(csc_array(stiff[1:][:, 1:])).solve(right[1:])
    return out


def _evened(
    stiff: Any,
    coords: FloatArray,
    faces: IntArray,
    flat: FloatArray,
    jumps: FloatArray,
    ends: IntArray,
) -> FloatArray:
    """A map with triangles as near to their own shapes as can be, rims at their heights.

    Local and global steps in turn: L. Liu and others, "A local/global approach to mesh
    parameterization", Computer Graphics Forum 27 (2008). jumps : see `_conjugate`, (nf, 3, 2).
    """
    corners = coords[faces]
    first = unit(corners[:, 1] - corners[:, 0])
    arm = corners[:, 2] - corners[:, 0]
    side = dot(arm, first)
    local = np.zeros((len(faces), 3, 2))
    local[:, 1, 0] = norm(corners[:, 1] - corners[:, 0])
    local[:, 2, 0], local[:, 2, 1] = side, norm(arm - side[:, None] * first)
    begin, end = np.roll(local, -1, axis=1), np.roll(local, 1, axis=1)
    far, near = begin - local, end - local
    turned = far[..., 0] * near[..., 1] - far[..., 1] * near[..., 0]
    weight = ((far * near).sum(axis=2) / turned / 2)[..., None]  # of the side opposite a corner
    rest = end - begin
    free = np.setdiff1d(np.arange(len(coords)), ends)
    around = splu(csc_array(stiff[1:][:, 1:]))
    across = splu(csc_array(stiff[free][:, free])) if len(free) else None
    pull = np.roll(jumps, -1, axis=1) - np.roll(jumps, 1, axis=1)
    for _ in range(_EVENINGS):
        placed = flat[faces] + jumps
        now = np.roll(placed, 1, axis=1) - np.roll(placed, -1, axis=1)
        moment = (weight * now)[..., :, None] * rest[..., None, :]
        spin = moment.sum(axis=1)
        angle = np.arctan2(spin[:, 1, 0] - spin[:, 0, 1], spin[:, 0, 0] + spin[:, 1, 1])
        c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
        wanted = np.stack(
            [c * rest[..., 0] - s * rest[..., 1], s * rest[..., 0] + c * rest[..., 1]], axis=-1
        )
        part = weight * (wanted + pull)
        right = np.stack(
            [
                np.bincount(np.roll(faces, 1, axis=1).ravel(), part[..., k].ravel(), len(coords))
                - np.bincount(np.roll(faces, -1, axis=1).ravel(), part[..., k].ravel(), len(coords))
                for k in (0, 1)
            ],
            axis=-1,
        )
        new = flat.copy()
        new[0, 0] = 0.0
        new[1:, 0] = around.solve(right[1:, 0])
        if across is not None:
            known = stiff[free][:, ends] @ flat[ends, 1]
            new[free, 1] = across.solve(right[free, 1] - known)
        if not (_turned(new[faces] + jumps) > 0).all():
            break
        flat = new
    return flat


def _stations(coords: FloatArray, faces: IntArray, height: FloatArray) -> tuple[FloatArray, float]:
    """Mean lengths along a ring up to evenly spaced heights from 0 to 1, and the mean girth."""
    _, doubled, hats = _hats(coords[faces])
    steep = norm((height[faces][:, :, None] * hats).sum(axis=1))
    low, middle, high = np.sort(height[faces], axis=1).T
    widest = np.divide(doubled * steep, high - low, out=np.zeros_like(low), where=high > low)
    girth, thick = np.zeros(_STATIONS), np.zeros(_STATIONS)
    for k, level in enumerate((np.arange(_STATIONS) + 0.5) / _STATIONS):
        across = np.flatnonzero((low < level) & (level < high))
        # the level's line through a triangle is longest at its middle corner
        below = level <= middle[across]
        end = np.where(below, low[across], high[across])
        length = widest[across] * (level - end) / (middle[across] - end)
        girth[k] = length.sum()
        thick[k] = (length / steep[across]).sum() / _STATIONS / girth[k]
    along = np.concatenate([[0.0], np.cumsum(thick)])
    return along, float((girth * thick).sum() / along[-1])


def _hats(corners: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Unit normals (nf, 3), doubled areas (nf,), and gradients of the functions that are 1 at one
    corner and 0 at both others, (nf, 3, 3): the side opposite, turned, over the doubled area.

    corners : of triangles in space, shape (nf, 3, 3).
    """
    normal = cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    doubled = norm(normal)
    normal = normal / doubled[:, None]
    opposite = np.roll(corners, 1, axis=1) - np.roll(corners, -1, axis=1)
    return normal, doubled, cross(normal[:, None], opposite) / doubled[:, None, None]


def _turned(corners: FloatArray) -> FloatArray:
    """Twice the signed areas of flat triangles, shape (nf, 3, 2)."""
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
