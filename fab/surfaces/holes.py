"""Small holes of a mesh filled, large ones kept."""

from __future__ import annotations

import numpy as np

from fab.errors import Finding, Severity, counted
from fab.surfaces.soup import place_text
from solver.graphs import EdgeIndex
from solver.targets.surface_mesh import SurfaceMesh
from solver.vectors import BoolArray, FloatArray, IntArray, cross, dot, norm

__all__ = ["filled"]

# A hole is small where its rim is no longer than this, in square roots of the surface's area: on a
# square, a round hole 5 % as wide as the square is.
_SMALL = 0.16
# The sides that a hole may have: the time grows with their third power.
_MOST_SIDES = 400
# Twice the area of a flat triangle, and what short sides weigh beside it, in squares of its sides.
_FLAT = 1e-6
_SHORT = 0.01


def filled(mesh: SurfaceMesh) -> tuple[SurfaceMesh, list[Finding]]:
    """The mesh without its small holes, each closed by a cover of the least area.

    Small are rims up to 0.16 times the square root of the surface's area, of up to 400 sides; the
    outer rim of a disc is longer unless the disc is nearly closed, as a balloon is.
    """
    bound = _SMALL * float(np.sqrt(mesh.area))
    loops = [loop for loop in mesh.boundary_loops if mesh.loop_length(loop) <= bound]
    index = EdgeIndex.of(mesh.edges_vertices, len(mesh.vertices_coords))
    covers, left = [], 0
    for loop in loops:
        cover = None
        if len(loop) <= _MOST_SIDES:
            cover = _least_cover(mesh.vertices_coords[loop], _taken(index, loop))
        if cover is None:
            left += 1
        else:
            covers.append((loop, cover))
    findings = []
    if covers:
        longest = max(mesh.loop_length(loop) for loop, _ in covers)
        where = place_text(mesh.vertices_coords[covers[0][0]].mean(axis=0))
        text = (
            f"{counted(len(covers), 'hole')} filled, with rims up to {longest:.3g} long, the "
            f"largest at {where}: holes with rims up to {bound:.3g} are."
        )
        findings.append(Finding("mesh-holes-filled", Severity.NOTE, text))
        # a loop has its faces on the left, so a cover's triangles run against it
        added = [loop[cover[:, ::-1]] for loop, cover in covers]
        faces = np.concatenate([mesh.faces_vertices, *added])
        mesh = SurfaceMesh.of(mesh.vertices_coords, faces)
    if left:
        text = (
            f"{counted(left, 'small hole')} kept: of more than {_MOST_SIDES} sides, or with "
            "corners that are joined already. Fill them in a mesh editor."
        )
        findings.append(Finding("mesh-small-holes", Severity.NOTE, text))
    return mesh, findings


def _taken(index: EdgeIndex, loop: IntArray) -> BoolArray:
    """Which corners of a loop are joined by an edge of the mesh already, shape (n, n)."""
    count = len(loop)
    first, second = (part.ravel() for part in np.meshgrid(loop, loop, indexing="ij"))
    taken: BoolArray = index.find(np.column_stack([first, second])).reshape(count, count) >= 0
    return taken


def _least_cover(corners: FloatArray, taken: BoolArray) -> IntArray | None:
    """Triangles (n - 2, 3) that close a loop of points (n, 3), in its direction, of the least area.

    Of covers of nearly one area that with the shortest sides is taken; none of its triangles is
    flat. taken : pairs of corners that triangles may not join, shape (n, n); sides do not count.
    None where there is no such cover. G. Barequet and M. Sharir, "Filling gaps in the boundary of a
    polyhedron", Computer Aided Geometric Design 12 (1995).
    """
    count = len(corners)
    least = np.zeros((count, count))
    split = np.zeros((count, count), np.int64)
    for width in range(2, count):
        for first in range(count - width):
            last = first + width
            if taken[first, last] and width < count - 1:
                least[first, last] = np.inf
                continue
            between = np.arange(first + 1, last)
            arms = corners[between] - corners[first]
            sides = corners[last] - corners[between]
            areas = norm(cross(arms, sides))
            squares = dot(arms, arms) + dot(sides, sides)
            flat = areas <= _FLAT * squares
            sums = least[first, between] + least[between, last] + areas + _SHORT * squares
            sums[flat] = np.inf
            best = int(sums.argmin())
            least[first, last], split[first, last] = sums[best], between[best]
    if not np.isfinite(least[0, -1]):
        return None
    out, open_parts = [], [(0, count - 1)]
    while open_parts:
        first, last = open_parts.pop()
        if last - first > 1:
            middle = int(split[first, last])
            out.append((first, middle, last))
            open_parts += [(first, middle), (middle, last)]
    return np.array(out, np.int64)
