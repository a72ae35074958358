"""Triangle meshes with shorter edges, their surface unchanged."""

from __future__ import annotations

import numpy as np

from solver.errors import require_count, require_positive
from solver.targets.surface_mesh import SurfaceMesh
from solver.vectors import FloatArray, IntArray, norm

__all__ = ["refined"]


def refined(mesh: SurfaceMesh, longest: float, most: int) -> SurfaceMesh:
    """The same surface with edges of hardly more than `longest`, and at most `most` triangles.

    Longer edges are divided evenly, into a power of two. A face with an undivided edge, a needle,
    is cut across; others are cut in four at the middles of their edges, and so on. Where that makes
    too many triangles `longest` is doubled until it does not. CAD programs write a cylinder as
    strips as long as it is, with all vertices on its rims: maps need some in between.

    >>> corners = np.array([[0.0, 0, 0], [4, 0, 0], [4, 1, 0], [0, 1, 0]])
    >>> strip = SurfaceMesh.of(corners, np.array([[0, 1, 2], [0, 2, 3]]))
    >>> fine = refined(strip, 1.1, 1000)
    >>> len(fine.faces_vertices), fine.area
    (14, 4.0)
    """
    require_positive("longest", longest)
    require_count("most", most, 1, "Allow at least the triangles of the mesh.")
    ends = mesh.vertices_coords[mesh.edges_vertices]
    lengths = norm(ends[:, 1] - ends[:, 0])
    while True:
        parts = _parts(lengths, longest)
        if parts.max() == 1:
            return mesh
        around = np.sort(parts[mesh.faces_edges], axis=1)
        if (around[:, 0] * (around[:, 1] + around[:, 2] - 1)).sum() <= most:
            return _divided(mesh, parts, longest)
        longest *= 2


def _parts(lengths: FloatArray, longest: float) -> IntArray:
    """Powers of two into which edges are divided so as not to be longer."""
    with np.errstate(divide="ignore"):
        exponents = np.ceil(np.log2(lengths / longest) - 1e-9)
    return 2 ** np.maximum(exponents, 0).astype(np.int64)


def _divided(mesh: SurfaceMesh, parts: IntArray, longest: float) -> SurfaceMesh:
    """The mesh with each edge in as many equal `parts`, shape (ne,)."""
    points = _Points(mesh.vertices_coords, longest)
    chains = {}
    for edge in np.flatnonzero(parts > 1).tolist():
        first, last = mesh.edges_vertices[edge].tolist()
        chains[edge] = points.between(first, last, int(parts[edge]))
    whole = (parts[mesh.faces_edges] == 1).all(axis=1)
    faces: list[tuple[int, int, int]] = []
    for face in np.flatnonzero(~whole).tolist():
        corners = mesh.faces_vertices[face].tolist()
        sides = []
        for corner, after, edge in zip(
            corners, corners[1:] + corners[:1], mesh.faces_edges[face].tolist(), strict=True
        ):
            chain = chains.get(edge) or [*mesh.edges_vertices[edge].tolist()]
            sides.append(chain if chain[0] == corner and chain[-1] == after else chain[::-1])
        faces += _filled(sides, points)
    added = np.array(faces, np.int64).reshape(-1, 3)
    return SurfaceMesh(
        np.concatenate([mesh.vertices_coords, np.reshape(points.added, (-1, 3))]),
        np.concatenate([mesh.faces_vertices[whole], added]),
    )


class _Points:
    """Points of a mesh, and those added between them."""

    def __init__(self, coords: FloatArray, longest: float) -> None:
        self.coords = coords
        self.longest = longest
        self.added: list[FloatArray] = []

    def at(self, vertex: int) -> FloatArray:
        count = len(self.coords)
        point: FloatArray = self.coords[vertex] if vertex < count else self.added[vertex - count]
        return point

    def between(self, first: int, last: int, parts: int = 0) -> list[int]:
        """The chain of vertices from the first to the last, in `parts`; 0: as long as may be."""
        start, end = self.at(first), self.at(last)
        parts = parts or int(_parts(norm(end - start)[None], self.longest)[0])
        number = len(self.coords) + len(self.added)
        self.added += [start + (end - start) * (k / parts) for k in range(1, parts)]
        return [first, *range(number, number + parts - 1), last]


def _filled(sides: list[list[int]], points: _Points) -> list[tuple[int, int, int]]:
    """Triangles of a face, whose sides are chains of vertices, each ending where the next begins.

    points : gets those that are added within.
    """
    counts = [len(side) - 1 for side in sides]
    if min(counts) == 1:
        base = counts.index(1)
        right, left = sides[(base + 1) % 3], sides[(base + 2) % 3]
        return _joined(left[::-1], right)
    middles = [side[len(side) // 2] for side in sides]
    inner = [points.between(middles[k], middles[(k + 1) % 3]) for k in range(3)]
    out = _filled(inner, points)
    for k in range(3):
        begin = sides[k][: counts[k] // 2 + 1]
        end = sides[k - 1][counts[k - 1] // 2 :]
        out += _filled([begin, inner[k - 1][::-1], end], points)
    return out


def _joined(left: list[int], right: list[int]) -> list[tuple[int, int, int]]:
    """Triangles between two chains of vertices from the base of a needle to its tip."""
    out = []
    i, j = 0, 0
    while i < len(left) - 1 or j < len(right) - 1:
        if j + 1 < len(right) and (j + 1) * (len(left) - 1) <= (i + 1) * (len(right) - 1):
            face = (left[i], right[j], right[j + 1])
            j += 1
        else:
            face = (left[i], right[j], left[i + 1])
            i += 1
        if len(set(face)) == 3:  # the two chains end in one vertex
            out.append(face)
    return out
