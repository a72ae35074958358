"""Vertices of a sheet that users choose: by number, by place in the flat or in the folded sheet."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fab.errors import InvalidJob
from fab.pattern.crease_pattern import CreasePattern
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["chosen_vertices"]

# Vertices within this share of the height of the folded sheet are as low as the lowest.
_LEVEL = 1e-3
# Regions reach beyond their bounds by this share of the sheet.
_ROUNDING = 1e-9
# The corners at both ends of each edge: left bottom, right bottom, right top, left top.
_EDGES = {"bottom edge": 0, "right edge": 1, "top edge": 2, "left edge": 3}


def chosen_vertices(
    pattern: CreasePattern,
    numbers: IntArray,
    folded: FloatArray,
    down: FloatArray,
    choices: Sequence[str | int | Sequence[float]],
    key: str,
) -> BoolArray:
    """Which vertices of a sheet are among some choices (`fab.folding.loads.load_settings`).

    Parameters
    ----------
    pattern : the sheet. numbers : shape (nv,), the user's number of each of its vertices; -1 for
        those that the user has none for.
    folded : shape (nv, 3), the folded sheet. down : shape (3,), which way is down in it.
    key : what the choices are called in messages.

    Raises `InvalidJob` for a number that the sheet does not have, and a region without vertices.
    """
    out = np.zeros(len(numbers), bool)
    for choice in choices:
        if isinstance(choice, str):
            found = _named(pattern, folded, down, choice)
        elif isinstance(choice, int):
            found = numbers == choice
            if not found.any():
                raise InvalidJob(
                    f"{key} = {choice}: the sheet has no such vertex, they are numbered from 0 to "
                    f"{int(numbers.max())}. The FOLD file lists them."
                )
        else:
            found = _within(pattern.vertices_coords, choice)
            if not found.any():
                low, high = pattern.vertices_coords.min(axis=0), pattern.vertices_coords.max(axis=0)
                box = ", ".join(f"{value:.6g}" for value in (*low, *high))
                raise InvalidJob(
                    f"{key} = {list(choice)}: no vertex is in this region. The flat sheet is in "
                    f"[{box}] mm."
                )
        out |= found
    return out


def _within(flat: FloatArray, region: Sequence[float]) -> BoolArray:
    """Vertices in a rectangle [x from, y from, x to, y to] of the flat sheet."""
    ends = np.asarray(region, float).reshape(2, 2)
    low, high = ends.min(axis=0), ends.max(axis=0)
    slack = _ROUNDING * float(np.ptp(flat, axis=0).max())
    return np.asarray(((flat >= low - slack) & (flat <= high + slack)).all(axis=1))


def _named(pattern: CreasePattern, folded: FloatArray, down: FloatArray, name: str) -> BoolArray:
    if name in ("lowest", "highest"):
        height = -(folded @ down) if name == "lowest" else folded @ down
        return np.asarray(height <= height.min() + _LEVEL * np.ptp(folded, axis=0).max())
    out = np.zeros(len(folded), bool)
    if name == "border":
        border = pattern.edges_faces[:, 1] < 0
        out[pattern.edges_vertices[border].ravel()] = True
        return out
    for ring in _outer_rings(pattern):
        places = _corner_places(pattern.vertices_coords[ring])
        if name == "corners":
            out[ring[places]] = True
        else:
            begin, end = places[_EDGES[name]], places[(_EDGES[name] + 1) % 4]
            count = (end - begin) % len(ring)
            out[ring[(begin + np.arange(count + 1)) % len(ring)]] = True
    return out


def _outer_rings(pattern: CreasePattern) -> list[IntArray]:
    """Vertices around each piece of the sheet, counterclockwise, the longest ring of each."""
    border = np.flatnonzero(pattern.edges_faces[:, 1] < 0)
    after: dict[int, list[tuple[int, int]]] = {}
    for (start, end), face in zip(
        pattern.edges_vertices[border].tolist(),
        pattern.edges_faces[border, 0].tolist(),
        strict=True,
    ):
        after.setdefault(start, []).append((end, face))
    longest: dict[int, tuple[float, list[int]]] = {}
    for first in sorted(after):
        while after[first]:
            ring, vertex, piece = [], first, 0
            while after[vertex]:
                ring.append(vertex)
                vertex, face = after[vertex].pop(0)
                piece = int(pattern.faces_piece[face])
            extent = float(np.ptp(pattern.vertices_coords[ring], axis=0).sum())
            if extent > longest.get(piece, (-1.0, []))[0]:
                longest[piece] = (extent, ring)
    return [np.array(ring) for _, (_, ring) in sorted(longest.items())]


def _corner_places(flat: FloatArray) -> IntArray:
    """Places on a ring that are nearest to the corners of its box, counterclockwise."""
    low, high = flat.min(axis=0), flat.max(axis=0)
    corners = np.array([low, [high[0], low[1]], high, [low[0], high[1]]])
    distance = np.hypot(*(flat[:, None] - corners).transpose(2, 0, 1))
    return np.asarray(distance.argmin(axis=0), np.int64)
