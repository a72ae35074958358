"""Room for lattice hinges: where each may begin, and which would meet other lines all the same."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import NDArray

from fab.pattern.crease_pattern import CreasePattern
from fab.pattern.sectors import sectors_of
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["lattice_starts", "meeting_lattices"]


def lattice_starts(
    pattern: CreasePattern, lines: BoolArray, walls: BoolArray, half_mm: FloatArray
) -> FloatArray:
    """How far from each end a band clears the lines beside it, mm, shape (ne, 2).

    A band h to each side clears the bisector of a sector a after h cot(a / 2), and a wall itself
    after h cot(a); beyond a right angle it meets nothing.

    Parameters
    ----------
    lines, walls : which edges anything is drawn along, and which of these are outlines and inner
        cuts, shape (ne,).
    half_mm : half the width of each edge's band, 0 for none, shape (ne,).
    """
    out = np.zeros((len(half_mm), 2))
    if not half_mm.any():
        return out
    sectors = sectors_of(pattern, lines)
    wall = walls[sectors.edges]
    share = np.where(wall[sectors.following], 1.0, 0.5)  # seen from the line before
    after = np.minimum(sectors.angles * share, np.pi / 2)
    before = np.empty_like(after)
    before[sectors.following] = np.minimum(sectors.angles * np.where(wall, 1.0, 0.5), np.pi / 2)
    clear = np.minimum(before, after)
    half = half_mm[sectors.edges]
    with np.errstate(divide="ignore", invalid="ignore"):
        start = np.where(half > 0, half * np.cos(clear) / np.sin(clear), 0.0)
    out[sectors.edges, sectors.ends] = start
    return out


def meeting_lattices(
    pattern: CreasePattern,
    lines: BoolArray,
    trim_mm: FloatArray,
    half_mm: FloatArray,
    margin_mm: float,
    holes: Sequence[FloatArray],
) -> IntArray:
    """Creases whose lattice meets another line, hole or lattice, or the margin of a vertex.

    Parameters
    ----------
    lines : which edges anything is drawn along, shape (ne,).
    trim_mm : what stays free at both ends of each edge, shape (ne, 2).
    half_mm : half the width of each edge's band, 0 for none, shape (ne,).
    margin_mm : kept free around vertices.
    holes : outlines of relief holes, each of shape (m, 2).
    """
    if not half_mm.any():
        return np.empty(0, np.int64)
    edges, ends, along = _trimmed(pattern, np.flatnonzero(lines), trim_mm)
    wide = np.flatnonzero(half_mm[edges] > 0)
    bands = _bands(ends[wide], along[wide], half_mm[edges[wide]])
    shapes = shapely.linestrings(ends)
    shapes[wide] = bands
    rings = [shapely.LinearRing(ring) for ring in holes]
    band, other = shapely.STRtree([*shapes, *rings]).query(bands, predicate="intersects")
    foreign = band[wide[band] != other]
    points = shapely.points(pattern.vertices_coords[np.unique(pattern.edges_vertices)])
    within = margin_mm * (1 - 1e-9)  # a band may begin at the margin of its own vertex
    near, _ = shapely.STRtree(points).query(bands, predicate="dwithin", distance=within)
    met: IntArray = np.unique(edges[wide[np.concatenate([foreign, near])]])
    return met


def _trimmed(
    pattern: CreasePattern, edges: IntArray, trim_mm: FloatArray
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Edges longer than their trim, their ends without it (k, 2, 2), and directions (k, 2)."""
    ends = pattern.vertices_coords[pattern.edges_vertices[edges]]
    span = ends[:, 1] - ends[:, 0]
    length = np.hypot(span[:, 0], span[:, 1])
    trim = trim_mm[edges]
    longer = length - trim.sum(axis=1) > 0
    edges, ends, trim = edges[longer], ends[longer], trim[longer]
    along = span[longer] / length[longer, None]
    low = ends[:, 0] + trim[:, :1] * along
    high = ends[:, 1] - trim[:, 1:] * along
    return edges, np.stack([low, high], axis=1), along


def _bands(ends: FloatArray, along: FloatArray, half_mm: FloatArray) -> NDArray[np.object_]:
    """Rectangles `half_mm` to each side of lines (k, 2, 2) with the directions `along`."""
    low, high = ends.swapaxes(0, 1)
    across = along[:, ::-1] * [-1, 1] * half_mm[:, None]
    corners = [low - across, high - across, high + across, low + across]
    out: NDArray[np.object_] = shapely.polygons(np.stack(corners, axis=1))
    return out
