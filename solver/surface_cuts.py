"""Surfaces cut by a plane: into parts, or open along one line, where one sheet does not reach."""

from __future__ import annotations

import numpy as np

from solver.graphs import labels
from solver.targets.surface_mesh import MeshKind, SurfaceMesh, corner_labels
from solver.targets.triangles import triangle_edges
from solver.vectors import FloatArray, IntArray, cross, norm

__all__ = ["halves", "opened"]

# Vertices nearer to the plane than this share of the mesh's size are moved onto it.
_ON_PLANE = 1e-3
# Parts below this share of the area are crumbs of the cut.
_CRUMB = 1e-3
# Moments that differ by less than this share of the largest are equal.
_EQUAL = 1e-6
# More would not move the plane.
_BISECTIONS = 50


def halves(mesh: SurfaceMesh) -> list[SurfaceMesh]:
    """The parts on both sides of a plane through the middle of a surface, largest first.

    The plane is across the direction in which the surface reaches furthest, or for a closed one,
    the least far, so that its halves are as shallow as can be. Parts have a straight rim there.
    """
    axes = _principal_axes(mesh)
    axis = axes[0] if mesh.boundary_loops else axes[2]
    return _pieces(*_sliced(mesh, axis)[:3])


def opened(mesh: SurfaceMesh) -> SurfaceMesh | None:
    """A torus cut to a tube, or a one-sided band cut to a strip, along one line; None if not.

    Of the lines in which planes through the middle meet the surface, the shortest after which the
    surface is in one piece and two-sided.
    """
    wanted = {MeshKind.TORUS: MeshKind.RING, MeshKind.MOEBIUS: MeshKind.DISC}.get(mesh.kind)
    if wanted is None:
        return None
    found: list[tuple[float, SurfaceMesh]] = []
    for axis in _principal_axes(mesh):
        coords, faces, side, on = _sliced(mesh, axis)
        lines = _lines(coords, faces, on)
        for line in np.unique(lines[on]):
            cut = _cut_along(coords, faces, side, on, lines, int(line))
            if cut is not None and cut[1].kind is wanted:
                found.append(cut)
    return min(found, key=lambda pair: pair[0])[1] if found else None


def _principal_axes(mesh: SurfaceMesh) -> FloatArray:
    """Directions of the surface's extent by area, the longest first, shape (3, 3)."""
    weight = norm(mesh.doubled_areas)
    middle = mesh.vertices_coords[mesh.faces_vertices].mean(axis=1)
    arm = middle - (weight[:, None] * middle).sum(axis=0) / weight.sum()
    moments, axes = np.linalg.eigh(
        (weight[:, None, None] * arm[:, :, None] * arm[:, None]).sum(axis=0)
    )
    moments, axes = moments[::-1], axes.T[::-1].copy()
    # of equal moments rounding would choose: their axes are those nearest to the coordinate axes
    breaks = np.flatnonzero(moments[:-1] - moments[1:] > _EQUAL * moments[0]) + 1
    for group in np.split(np.arange(3), breaks):
        axes[group] = _nearest_axes(axes[group])
    # the sign that makes the largest entry positive, so that the same surface is cut the same way
    largest = axes[np.arange(3), np.abs(axes).argmax(axis=1)]
    return np.asarray(axes * np.where(largest < 0, -1.0, 1.0)[:, None])


def _nearest_axes(span: FloatArray) -> FloatArray:
    """An orthonormal basis of a span, shape (k, 3), of projections of coordinate axes."""
    left = span.T @ span
    basis = []
    for _ in span:
        length = np.sqrt(np.maximum(np.diag(left), 0.0))
        longest = int(np.flatnonzero(length >= (1 - _EQUAL) * length.max())[0])
        basis.append(left[longest] / length[longest])
        left = left - np.outer(basis[-1], basis[-1])
    return np.array(basis)


def _median_height(heights: FloatArray, areas: FloatArray) -> float:
    """The height below which half of the area of triangles is, these with heights (nf, 3)."""
    low, middle, high = np.sort(heights, axis=1).T
    under, over = float(low.min()), float(high.max())
    for _ in range(_BISECTIONS):
        level = (under + over) / 2
        share = (level >= high).astype(float)
        rising = (low < level) & (level < middle)
        falling = (middle <= level) & (level < high)
        low_r, high_r = low[rising], high[rising]
        share[rising] = (level - low_r) ** 2 / ((high_r - low_r) * (middle[rising] - low_r))
        low_f, high_f = low[falling], high[falling]
        share[falling] = 1 - (high_f - level) ** 2 / ((high_f - low_f) * (high_f - middle[falling]))
        if areas @ share < areas.sum() / 2:
            under = level
        else:
            over = level
    return (under + over) / 2


def _sliced(mesh: SurfaceMesh, axis: FloatArray) -> tuple[FloatArray, IntArray, IntArray, IntArray]:
    """Triangles cut by the plane across `axis` through the median of area.

    Returns vertices, faces, the side of each face (0 or 1), and which vertices are on the plane.
    """
    coords = mesh.vertices_coords.copy()
    height = coords @ axis
    height -= _median_height(height[mesh.faces_vertices], norm(mesh.doubled_areas))
    near = np.abs(height) <= _ON_PLANE * mesh.size
    coords[near] -= height[near, None] * axis
    height[near] = 0.0
    ends, faces_edges = mesh.edges_vertices, mesh.faces_edges
    crossed = height[ends[:, 0]] * height[ends[:, 1]] < 0
    share = height[ends[:, 0]] / np.where(crossed, height[ends[:, 0]] - height[ends[:, 1]], 1.0)
    new = np.full(len(ends), -1)
    new[crossed] = len(coords) + np.arange(int(crossed.sum()))
    between = (1 - share[:, None]) * coords[ends[:, 0]] + share[:, None] * coords[ends[:, 1]]
    coords = np.concatenate([coords, between[crossed]])
    height = np.concatenate([height, np.zeros(int(crossed.sum()))])
    faces, side = [], []
    for corners, edges in zip(mesh.faces_vertices.tolist(), faces_edges.tolist(), strict=True):
        ring = [v for c, e in zip(corners, edges, strict=True) for v in (c, int(new[e])) if v >= 0]
        for sign in (-1.0, 1.0):
            part = [v for v in ring if height[v] * sign >= 0]
            if any(height[v] * sign > 0 for v in part):
                faces += [[part[0], part[k], part[k + 1]] for k in range(1, len(part) - 1)]
                side += [int(sign > 0)] * (len(part) - 2)
    on = np.flatnonzero(height == 0)
    return coords, np.array(faces, np.int64), np.array(side), on


def _lines(coords: FloatArray, faces: IntArray, on: IntArray) -> IntArray:
    """Labels of the lines in which the plane meets the surface, of all vertices."""
    flat = np.zeros(len(coords), bool)
    flat[on] = True
    ends = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    return labels(ends[flat[ends].all(axis=1)], len(coords))


def _cut_along(
    coords: FloatArray, faces: IntArray, side: IntArray, on: IntArray, line: IntArray, which: int
) -> tuple[float, SurfaceMesh] | None:
    """The surface with the vertices of one line doubled, and the line's length."""
    cut = np.zeros(len(coords), bool)
    cut[on] = line[on] == which
    ends = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    along = ends[cut[ends].all(axis=1)]
    if not len(along):
        return None
    length = float(norm(coords[along[:, 1]] - coords[along[:, 0]]).sum()) / 2
    doubled = np.where(cut, len(coords) + np.cumsum(cut) - 1, np.arange(len(coords)))
    moved = np.where((side == 1)[:, None], doubled[faces], faces)
    pieces = _components(np.concatenate([coords, coords[cut]]), moved)
    return (length, pieces[0]) if len(pieces) == 1 else None


def _pieces(coords: FloatArray, faces: IntArray, side: IntArray) -> list[SurfaceMesh]:
    found = [piece for k in (0, 1) for piece in _components(coords, faces[side == k])]
    total = sum(piece.area for piece in found)
    found = [piece for piece in found if piece.area > _CRUMB * total]
    return sorted(found, key=lambda piece: -piece.area)


def _components(coords: FloatArray, faces: IntArray) -> list[SurfaceMesh]:
    """Connected surfaces of triangles, without those of no area; they may touch at vertices."""
    height = norm(
        cross(coords[faces[:, 1]] - coords[faces[:, 0]], coords[faces[:, 2]] - coords[faces[:, 0]])
    )
    faces = faces[height > 1e-12 * height.max()]
    _, faces_edges = triangle_edges(faces, len(coords))
    half = np.argsort(faces_edges.ravel(), kind="stable")
    edge = faces_edges.ravel()[half]
    paired = np.flatnonzero(edge[1:] == edge[:-1])
    halves = np.column_stack([half[paired], half[paired + 1]])
    group = labels(halves // 3, len(faces))
    corners = corner_labels(faces, halves).reshape(-1, 3)
    out = []
    for piece in range(int(group.max()) + 1):
        names, numbers = np.unique(corners[group == piece], return_inverse=True)
        where = np.empty((len(names), 3))
        where[numbers.ravel()] = coords[faces[group == piece].ravel()]
        out.append(SurfaceMesh.of(where, _wound(numbers.reshape(-1, 3), where)))
    return out


def _wound(faces: IntArray, coords: FloatArray) -> IntArray:
    """Faces turned so that neighbours agree, where that can be: as most of them are."""
    mesh = SurfaceMesh(coords.copy(), faces.copy())
    if not mesh.orientable or mesh.wound.all():
        return faces
    flip = mesh.sides[:, 0] != mesh.sides[0, 0]
    if flip.mean() > 0.5:
        flip = ~flip
    return np.where(flip[:, None], faces[:, ::-1], faces)
