"""Vertices of a sheet that users choose: by number, by place in the flat or in the folded sheet."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial import cKDTree

from fab.errors import InvalidJob
from fab.geometry.rings import is_hole
from fab.pattern.crease_pattern import CreasePattern
from fab.pattern.outlines import SAME_PLACE_MM, outlines_of
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["chosen_vertices"]

# Vertices within this share of the height of the folded sheet are as low as the lowest.
_LEVEL = 1e-3
# Regions reach beyond their bounds by this share of the sheet.
_ROUNDING = 1e-9
# The corners at both ends of each edge: left bottom, right bottom, right top, left top.
_EDGES = {"bottom edge": 0, "right edge": 1, "top edge": 2, "left edge": 3}
# The axis along which each edge is outermost, and in which direction.
_SIDES = {"bottom edge": (1, -1), "right edge": (0, 1), "top edge": (1, 1), "left edge": (0, -1)}
# Outlines reach as far as the outermost within this share of the sheet.
_SAME_SIDE = 1e-6


def chosen_vertices(
    pattern: CreasePattern,
    numbers: IntArray,
    folded: FloatArray,
    down: FloatArray,
    choices: Sequence[str | int | Sequence[float]],
    key: str,
) -> BoolArray:
    """Which vertices of a sheet are among some choices (`fab.folding.loads.load_settings`).

    Edges, corners and border are those of the whole flat sheet: neither cuts within it nor holes
    are among them. Where a chosen vertex is on a cut, those on both sides of it are chosen.

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
    flat = pattern.vertices_coords
    rings = [ring for ring in outlines_of(pattern).rings if not is_hole(ring)]
    if not rings:
        raise InvalidJob(
            f"the flat sheet is smaller than {SAME_PLACE_MM:g} mm, where outlines end: a {name} is "
            "not found. Make it larger, or name vertices by their numbers."
        )
    if name == "border":
        return _at_places(flat, np.concatenate(rings))
    low, high = flat.min(axis=0), flat.max(axis=0)
    if name == "corners":
        outline = np.concatenate(rings)
        return _at_places(flat, outline[_corner_places(outline, low, high)])
    # of several outlines, those that reach the side of the whole sheet
    axis, end = _SIDES[name]
    reach = [float(end * (end * ring[:, axis]).max()) for ring in rings]
    outermost = end * max(end * value for value in reach)
    near = _SAME_SIDE * float(np.ptp(flat, axis=0).max())
    found = np.zeros(len(flat), bool)
    for ring, value in zip(rings, reach, strict=True):
        if abs(value - outermost) <= near:
            found |= _at_places(flat, _side(ring, name))
    return found


def _side(ring: FloatArray, name: str) -> FloatArray:
    """Points of a ring between two corners of its box."""
    places = _corner_places(ring, ring.min(axis=0), ring.max(axis=0))
    begin, end = places[_EDGES[name]], places[(_EDGES[name] + 1) % 4]
    side: FloatArray = ring[(begin + np.arange((end - begin) % len(ring) + 1)) % len(ring)]
    return side


def _at_places(flat: FloatArray, places: FloatArray) -> BoolArray:
    """Which vertices are at some places: at cuts there are several at one."""
    distance, _ = cKDTree(places).query(flat, distance_upper_bound=2 * SAME_PLACE_MM)
    return np.asarray(np.isfinite(distance), bool)


def _corner_places(points: FloatArray, low: FloatArray, high: FloatArray) -> IntArray:
    """Numbers of the points that are nearest to the corners of a box, counterclockwise."""
    corners = np.array([low, [high[0], low[1]], high, [low[0], high[1]]])
    distance = np.hypot(*(points[:, None] - corners).transpose(2, 0, 1))
    return np.asarray(distance.argmin(axis=0), np.int64)
