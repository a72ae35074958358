"""Faces and creases in space, drawn from the furthest to the nearest.

Faces are divided into cells and creases into pieces before they are put in order, so that each
hides what is behind it, also where faces pass through each other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from solver.vectors import FloatArray, cross, norm, unit

__all__ = [
    "LOWER",
    "UPPER",
    "Bundle",
    "draw_bundle",
    "framed",
    "principal_view",
]

UPPER, LOWER = (0.96, 0.84, 0.62), (0.62, 0.74, 0.86)
# In the frame of the viewer: from the upper left.
_LIGHT = unit(np.array([-0.35, 0.55, 0.75]))
# Cells across the whole drawing, at most.
_CELLS = 40


@dataclass(frozen=True)
class Bundle:
    """What is drawn in space together.

    Attributes
    ----------
    faces : corners of convex faces, counterclockwise seen from their upper side, (n, 3) each.
    colours : of their upper and lower sides, two RGB triples each.
    lines : points of lines, (n, 3) each; inks : colour of each; widths : in points.
    """

    faces: Sequence[FloatArray] = ()
    colours: Sequence[tuple[Sequence[float], Sequence[float]]] = ()
    lines: Sequence[FloatArray] = ()
    inks: Sequence[str] = ()
    widths: Sequence[float] = ()


def principal_view(coords: FloatArray, view: FloatArray) -> FloatArray:
    """A camera that sees points as `view` would, were their longest directions those of x and y."""
    _, vectors = np.linalg.eigh(np.cov((coords - coords.mean(axis=0)).T))
    axes: FloatArray = vectors.T[::-1].copy()
    for axis in axes[:2]:
        axis *= np.sign(axis[np.argmax(np.abs(axis))])
    axes[2] = cross(axes[0], axes[1])
    return view @ axes


def framed(axes: Any, view: FloatArray, coords: FloatArray, margin: float = 0.05) -> None:
    """Set the limits of axes so that all these points are seen."""
    seen = coords.reshape(-1, 3) @ view.T
    low, high = np.nanmin(seen, axis=0), np.nanmax(seen, axis=0)
    space = margin * max(float((high - low)[:2].max()), 1e-9)
    axes.set_xlim(low[0] - space, high[0] + space)
    axes.set_ylim(low[1] - space, high[1] + space)


def draw_bundle(axes: Any, view: FloatArray, bundle: Bundle, *, outline: float = 0.0) -> None:
    """Draw faces and lines, what is nearer over what is further.

    outline : width in points of the sides of faces; none at 0.
    """
    from matplotlib.collections import PolyCollection
    from matplotlib.colors import to_rgba_array

    corners = [np.asarray(face, np.float64) for face in bundle.faces]
    lines = [np.asarray(line, np.float64) for line in bundle.lines]
    inks, widths = list(bundle.inks), list(bundle.widths)
    if outline > 0:
        lines += [np.concatenate([face, face[:1]]) for face in corners]
        inks += ["#303030"] * len(corners)
        widths += [outline] * len(corners)
    if not corners and not lines:
        return
    size = float(norm(np.ptp(np.concatenate([*corners, *lines]), axis=0))) / _CELLS
    cells = [_cells(face, size) for face in corners]
    pieces = [_pieces(line, size) for line in lines]
    of_cell = np.repeat(np.arange(len(cells)), [len(each) for each in cells])
    of_piece = np.repeat(np.arange(len(pieces)), [len(each) for each in pieces])
    seen = np.concatenate([*cells, *pieces]) @ view.T
    depth = seen[:, :, 2].mean(axis=1)
    depth[len(of_cell) :] += size  # a crease is on the faces beside it: nearer by a cell
    fills = np.zeros((len(seen), 4))
    edges = np.zeros((len(seen), 4))
    thick = np.full(len(seen), 0.4)  # as much as closes the gaps between cells
    if corners:
        lit = _lit(corners, view, bundle.colours)
        fills[: len(of_cell)] = edges[: len(of_cell)] = lit[of_cell]
    if lines:
        edges[len(of_cell) :] = to_rgba_array(inks)[of_piece]
        thick[len(of_cell) :] = np.asarray(widths)[of_piece]
    order = np.argsort(depth, kind="stable")
    axes.add_collection(
        PolyCollection(
            list(seen[order][:, :, :2]),
            closed=False,
            facecolors=fills[order],
            edgecolors=edges[order],
            linewidths=thick[order],
            capstyle="round",
        )
    )


def _lit(
    corners: Sequence[FloatArray],
    view: FloatArray,
    colours: Sequence[tuple[Sequence[float], Sequence[float]]],
) -> FloatArray:
    """The colour of each face as it is seen and lit, shape (n, 4)."""
    areas = [cross(face, np.roll(face, -1, axis=0)).sum(axis=0) for face in corners]
    normals = np.nan_to_num(unit(np.array(areas))) @ view.T
    sides = np.array([[upper, lower] for upper, lower in colours], np.float64)
    colour = np.where(normals[:, 2:] >= 0, sides[:, 0], sides[:, 1])
    light = 0.62 + 0.38 * np.abs(normals @ _LIGHT)
    return np.column_stack([np.clip(colour * light[:, None], 0, 1), np.ones(len(normals))])


def _cells(face: FloatArray, size: float) -> FloatArray:
    """Parts of a convex face that are hardly larger than `size`, shape (n, 4, 3)."""
    if len(face) > 4:
        middle = face.mean(axis=0)
        fan = zip(face, np.roll(face, -1, axis=0), strict=True)
        return np.concatenate([_cells(np.stack([p, q, middle]), size) for p, q in fan])
    a, b, c, d = face if len(face) == 4 else (*face, face[2])
    across = max(float(norm(b - a)), float(norm(c - d)))
    along = max(float(norm(d - a)), float(norm(c - b)))
    if max(across, along) <= 2 * size:
        return np.stack([a, b, c, d])[None]
    s = np.linspace(0, 1, max(1, round(across / size)) + 1)[:, None, None]
    t = np.linspace(0, 1, max(1, round(along / size)) + 1)[None, :, None]
    grid = (1 - s) * (1 - t) * a + s * (1 - t) * b + s * t * c + (1 - s) * t * d
    cells = np.stack([grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]], axis=2)
    return np.asarray(cells.reshape(-1, 4, 3))


def _pieces(line: FloatArray, size: float) -> FloatArray:
    """Parts of a line that are hardly longer than `size`, there and back, shape (n, 4, 3)."""
    out = []
    for start, end in pairwise(line):
        count = max(1, round(float(norm(end - start)) / size))
        points = start + np.linspace(0, 1, count + 1)[:, None] * (end - start)
        out.append(np.stack([points[:-1], points[1:], points[1:], points[:-1]], axis=1))
    return np.concatenate(out)
