"""Triangle meshes with shorter edges, their surface unchanged."""

from __future__ import annotations

import numpy as np

from solver.errors import require_count, require_positive
from solver.targets.surface_mesh import SurfaceMesh
from solver.vectors import BoolArray, FloatArray, IntArray, norm

__all__ = ["refined"]

# Triangles for a face with 0 to 3 halved edges; 3, 4, 5 are the middles of the edges after 0, 1, 2.
_PARTS = (
    ((0, 1, 2),),
    ((0, 3, 2), (3, 1, 2)),
    ((3, 1, 4), (0, 3, 4), (0, 4, 2)),
    ((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5)),
)
_MOST_PASSES = 40


def refined(mesh: SurfaceMesh, longest: float, most: int) -> SurfaceMesh:
    """The same surface with edges of hardly more than `longest`, and up to `most` triangles.

    Faces with three longer edges are cut into four; longer edges of those that are left, needles,
    are divided evenly and joined across. What would make more than `most` triangles is not begun.
    CAD programs write a cylinder as strips as long as it is, with all vertices on its rims: maps
    need some in between.

    >>> corners = np.array([[0.0, 0, 0], [4, 0, 0], [4, 1, 0], [0, 1, 0]])
    >>> strip = SurfaceMesh.of(corners, np.array([[0, 1, 2], [0, 2, 3]]))
    >>> fine = refined(strip, 1.1, 1000)
    >>> len(fine.faces_vertices), fine.area
    (14, 4.0)
    """
    require_positive("longest", longest)
    require_count("most", most, 1, "Allow at least the triangles of the mesh.")
    for _ in range(_MOST_PASSES):
        lengths = _lengths(mesh)
        wide = lengths[mesh.faces_edges].min(axis=1) > longest
        halved = np.zeros(len(lengths), bool)
        halved[mesh.faces_edges[wide]] = True
        added = int(halved[mesh.faces_edges].sum())
        if not added or len(mesh.faces_vertices) + added > most:
            break
        mesh = _halved(mesh, halved)
    parts = np.ceil(_lengths(mesh) / longest)
    if wide.any() or len(mesh.faces_vertices) + (parts - 1)[mesh.faces_edges].sum() > most:
        return mesh
    return _divided(mesh, parts.astype(np.int64))


def _lengths(mesh: SurfaceMesh) -> FloatArray:
    ends = mesh.vertices_coords[mesh.edges_vertices]
    return norm(ends[:, 1] - ends[:, 0])


def _halved(mesh: SurfaceMesh, halved: BoolArray) -> SurfaceMesh:
    """The mesh with a vertex in the middle of each edge that is `halved`, shape (ne,).

    Faces are turned so that of three edges the first, the first two, or all are.
    """
    cuts = halved[mesh.faces_edges]
    middle = np.full(len(halved), -1)
    middle[halved] = len(mesh.vertices_coords) + np.arange(int(halved.sum()))
    coords = mesh.vertices_coords[mesh.edges_vertices[halved]].mean(axis=1)
    count = cuts.sum(axis=1)
    first = np.where(count == 1, cuts.argmax(axis=1), (cuts.argmin(axis=1) + 1) % 3)
    turn = (first[:, None] + np.arange(3)) % 3
    corners = np.take_along_axis(mesh.faces_vertices, turn, axis=1)
    points = middle[np.take_along_axis(mesh.faces_edges, turn, axis=1)]
    names = np.column_stack([corners, points])
    faces = [names[count == n][:, part] for n, parts in enumerate(_PARTS) for part in parts]
    return SurfaceMesh(np.concatenate([mesh.vertices_coords, coords]), np.concatenate(faces))


def _divided(mesh: SurfaceMesh, parts: IntArray) -> SurfaceMesh:
    """The mesh with each edge in as many equal `parts`, shape (ne,); each face has one of 1."""
    begin = len(mesh.vertices_coords) + np.concatenate([[0], np.cumsum(parts - 1)])
    share = np.arange(begin[-1] - begin[0]) - np.repeat(begin[:-1] - begin[0], parts - 1) + 1.0
    share /= np.repeat(parts, parts - 1)
    start, end = (np.repeat(mesh.edges_vertices[:, k], parts - 1) for k in (0, 1))
    coords = mesh.vertices_coords[start] * (1 - share)[:, None]
    coords += mesh.vertices_coords[end] * share[:, None]
    kept = (parts[mesh.faces_edges] == 1).all(axis=1)
    cut = np.flatnonzero(~kept)
    base = parts[mesh.faces_edges[cut]].argmin(axis=1)
    faces = [mesh.faces_vertices[kept]]
    for face, at in zip(cut.tolist(), base.tolist(), strict=True):
        corners = np.roll(mesh.faces_vertices[face], -at).tolist()
        edges = np.roll(mesh.faces_edges[face], -at).tolist()
        chains = []
        for corner, edge in ((corners[0], edges[2]), (corners[1], edges[1])):
            inner = list(range(begin[edge], begin[edge + 1]))
            rising = mesh.edges_vertices[edge, 0] == corner
            chains.append([corner, *(inner if rising else inner[::-1]), corners[2]])
        faces.append(_joined(*chains))
    return SurfaceMesh(np.concatenate([mesh.vertices_coords, coords]), np.concatenate(faces))


def _joined(left: list[int], right: list[int]) -> IntArray:
    """Triangles between two chains of vertices from the base of a needle to its tip."""
    out = []
    i, j = 0, 0
    while i < len(left) - 1 or j < len(right) - 1:
        if j + 1 < len(right) and (j + 1) * (len(left) - 1) <= (i + 1) * (len(right) - 1):
            out.append((left[i], right[j], right[j + 1]))
            j += 1
        else:
            out.append((left[i], right[j], left[i + 1]))
            i += 1
    return np.array([face for face in out if len(set(face)) == 3], np.int64).reshape(-1, 3)
