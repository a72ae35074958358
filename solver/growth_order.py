"""How a patch grew: its strips one after another, each with its front and what was chosen for it.

Vertices are numbered in the order of growth, so a finished mesh tells it all.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from solver.errors import InvalidState, require_count
from solver.front import Front
from solver.mesh import QuadMesh
from solver.rays import Rays
from solver.vectors import FloatArray, IntArray, angle_between, norm
from solver.vertex import flap_angle_of

__all__ = ["GrownStrip", "faces_strip", "grown_strips"]


@dataclass(frozen=True)
class GrownStrip:
    """One strip of a sheet as it was grown.

    Attributes
    ----------
    front : the front that it grew on; row : its new vertices, shape (m + 1, 3), or (N, 3) of loops.
    flap_angle : at front vertex 1 (of a loop: at its first vertex), radians in [0, 2 pi).
    """

    front: Front
    row: FloatArray
    flap_angle: float

    @cached_property
    def rays(self) -> Rays:
        """The creases of the strip, with the bounds of their lengths."""
        if self.front.closed:
            return self.front.rays(self.flap_angle)
        edges, new = self.front.edges_direction, self.row - self.front.row_coords
        left = float(angle_between(edges[0], new[0]))
        right = float(angle_between(-edges[-1], new[-1]))
        return self.front.rays(self.flap_angle, boundary_angles=(left, right))

    @property
    def lengths(self) -> FloatArray:
        """Of the creases, shape (m + 1,), or (N,) of loops."""
        return norm(self.row - self.front.row_coords)


def grown_strips(mesh: QuadMesh, seed_rows: int = 2) -> list[GrownStrip]:
    """The strips of a sheet in the order in which they were grown, those of its seed left out.

    mesh : grown at its top, its bottom, or both; every row from end to end. seed_rows : how many of
    its rows are the seed's; 1 where that is a curve. Raises `InvalidState` for a mesh whose rows
    have ends within it.

    >>> from solver.designs import CurvedFold
    >>> strips = grown_strips(CurvedFold(columns=10, step=0.2, strips=3).grow().mesh, seed_rows=1)
    >>> np.degrees([strip.flap_angle for strip in strips]).round(9).tolist()
    [157.5, 157.5, 157.5]
    """
    require_count("seed_rows", seed_rows, 1, "A seed is a curve, or a strip of two rows.")
    grid = mesh.grid
    if grid.min() < 0:
        raise InvalidState(
            "mesh", "some rows of the sheet end within it", "Give a sheet that was not trimmed."
        )
    order = np.argsort(grid[:, 0], kind="stable")
    coords = mesh.vertices_coords[grid]
    strips: list[GrownStrip] = []
    for row in order[seed_rows:].tolist():
        up = 1 if row > order[0] else -1
        rows = [coords[row - n * up][::up] for n in (0, 1, 2) if 0 <= row - n * up < len(grid)]
        strips.append(_strip(rows, closed=mesh.closed, curve=seed_rows == 1 and len(strips) == 0))
    return strips


def _strip(rows: list[FloatArray], *, closed: bool, curve: bool) -> GrownStrip:
    """A strip from its new row, its front and the row behind that, unless the front is a curve."""
    new, x = rows[:2]
    if curve:
        before, after = np.roll(x, 1, axis=0) - x, np.roll(x, -1, axis=0) - x
        k = angle_between(before, new - x) + angle_between(after, new - x)
        front = Front.on_curve(x, k if closed else k[1:-1], closed=closed)
    else:
        front = Front.between(x, rows[2], closed=closed)
    first = 0 if closed else 1
    a, b = -front.edges_direction[:1], front.edges_direction[1:2]
    flap = flap_angle_of(a, b, (new - x)[first : first + 1])
    return GrownStrip(front, new, float(flap[0]))


def faces_strip(mesh: QuadMesh) -> IntArray:
    """The step of growth that made each face, counted from 0 without gaps, shape (nf,).

    All faces whose last vertex is of the same row of the grid are one step, such as those of a
    strip; where strips grew on the left or right, those of a column too. In a sheet of a single
    strip, or one that grew around a corner, each face is a step. Faces in the order of
    `QuadMesh.polygons`.

    >>> from solver.designs import Miura
    >>> faces_strip(Miura(columns=2, rows=3).grow().mesh).tolist()
    [0, 0, 1, 1, 2, 2]
    """
    grid = mesh.grid
    corners, offsets = mesh.polygons
    last = np.maximum.reduceat(corners, offsets[:-1])
    rows = [line[line >= 0] for line in grid]
    row_of = np.full(len(mesh.vertices_coords), -1)
    for number, line in enumerate(rows):
        row_of[line] = number
    in_one_go = all(np.ptp(line) == len(line) - 1 for line in rows if len(line))
    on_sides = _vertices_strip(mesh) if len(grid) > 2 and not in_one_go else None
    if on_sides is not None:
        by_strip: IntArray = np.unique(
            np.maximum.reduceat(on_sides[corners], offsets[:-1]), return_inverse=True
        )[1]
        return by_strip
    if len(grid) <= 2 or not in_one_go or row_of.min() < 0:
        by_last: IntArray = np.unique(last, return_inverse=True)[1]
        return by_last
    # of two rows the one with the lower numbers is older
    first = np.array([line.min(initial=len(row_of)) for line in rows])
    out: IntArray = np.unique(first[row_of[last]], return_inverse=True)[1]
    return out


def _vertices_strip(mesh: QuadMesh) -> IntArray | None:
    """The strip, counted from 0, that each vertex came with, in a patch grown at any of its sides.

    The last strip is the line of the outline that has the highest numbers, all of them; without it
    the patch is as it was before. None for a patch that did not grow so.
    """
    grid, steps = mesh.grid, np.zeros(len(mesh.vertices_coords), np.int64)
    if mesh.closed or not np.array_equal(np.sort(grid, axis=None), np.arange(len(steps))):
        return None
    lines: list[IntArray] = []
    while len(grid) > 1 and grid.shape[1] > 1:
        for turns in range(4):
            turned = np.rot90(grid, turns)
            if turned[-1].min() == turned.size - turned.shape[1]:
                lines.append(turned[-1])
                grid = np.rot90(turned[:-1], -turns)
                break
        else:
            return None
    for number, line in enumerate(reversed(lines), 1):
        steps[line] = number
    return steps
