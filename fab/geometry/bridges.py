"""Bridges across a region of the plane with islands, which divide it into simple polygons."""

from __future__ import annotations

import numpy as np
import shapely
from scipy.spatial import cKDTree

from fab.geometry.planar_graph import walks_of
from solver.graphs import labels
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["bridges"]

# Up to this many corners all pairs are tried, beyond it the nearest ones of each.
_ALL_PAIRS = 300
_NEAREST = 12


def bridges(
    vertices_coords: FloatArray, edges_vertices: IntArray, within: BoolArray, obstacles: IntArray
) -> IntArray | None:
    """Pairs of vertices whose connections divide a region into simple polygons, shape (k, 2).

    edges_vertices : all edges around the region, shape (ne, 2). within : shape (ne, 2), whether the
    region is on the left and on the right of each. obstacles : further edges in the region, which
    bridges must not touch. Short bridges are preferred; None where those that were tried do not
    suffice.
    """
    pairs = _candidates(vertices_coords, edges_vertices)
    pairs = pairs[_visible(vertices_coords, edges_vertices, obstacles, pairs)]
    pairs = pairs[_inside(vertices_coords, edges_vertices, within, pairs)]
    span = np.diff(vertices_coords[pairs], axis=1)[:, 0]
    pairs = pairs[np.lexsort((pairs[:, 1], pairs[:, 0], np.round(np.hypot(*span.T), 9)))]
    chosen = np.empty((0, 2), np.int64)
    count = len(vertices_coords)
    while True:
        part = labels(np.concatenate([edges_vertices, chosen]), count)
        apart = np.flatnonzero(part[pairs[:, 0]] != part[pairs[:, 1]])
        if len(apart):
            bridge = pairs[apart[:1]]
        elif len(np.unique(part[edges_vertices])) > 1:
            return None
        else:
            loop = _first_loop(vertices_coords, edges_vertices, within, chosen)
            if loop is None:
                return chosen
            inside, outside = loop
            a, b = pairs.T
            across = (inside[a] & outside[b]) | (inside[b] & outside[a])
            useful = np.flatnonzero(across)
            if not len(useful):
                return None
            bridge = pairs[useful[:1]]
        chosen = np.concatenate([chosen, bridge])
        pairs = pairs[_visible(vertices_coords, bridge, bridge[:0], pairs)]


def _candidates(coords: FloatArray, edges: IntArray) -> IntArray:
    vertices = np.unique(edges)
    if len(vertices) <= _ALL_PAIRS:
        low, high = np.triu_indices(len(vertices), 1)
        return np.column_stack([vertices[low], vertices[high]])
    part = labels(edges, len(coords))[vertices]
    found = []
    for own in np.unique(part).tolist():
        mine, others = vertices[part == own], vertices[part != own]
        others = others if len(others) else mine
        near = min(_NEAREST, len(others))
        _, place = cKDTree(coords[others]).query(coords[mine], k=near)
        found.append(np.column_stack([np.repeat(mine, near), others[place.reshape(-1)]]))
    sample = vertices[:: len(vertices) // _ALL_PAIRS]
    low, high = np.triu_indices(len(sample), 1)
    found.append(np.column_stack([sample[low], sample[high]]))
    pairs = np.unique(np.sort(np.concatenate(found), axis=1), axis=0)
    return np.asarray(pairs[pairs[:, 0] != pairs[:, 1]], np.int64)


def _visible(
    coords: FloatArray, edges: IntArray, obstacles: IntArray, pairs: IntArray
) -> BoolArray:
    """Which pairs see each other: their connection meets edges in its ends alone, if at all."""
    lines = np.concatenate([edges, obstacles])
    tree = shapely.STRtree(shapely.linestrings(coords[lines]))
    pair, line = tree.query(shapely.linestrings(coords[pairs]), predicate="intersects")
    common = (pairs[pair][:, :, None] == lines[line][:, None, :]).any(axis=2)
    blocked = ~common.any(axis=1) | common.all(axis=1)
    # of two that begin in one vertex, one runs along the other
    single = np.flatnonzero(common.sum(axis=1) == 1)
    begin = pairs[pair[single]][common[single]]
    end = pairs[pair[single]].sum(axis=1) - begin
    other = lines[line[single]].sum(axis=1) - begin
    first, second = coords[end] - coords[begin], coords[other] - coords[begin]
    size = np.hypot(*first.T) * np.hypot(*second.T)
    turn = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
    blocked[single] = (np.abs(turn) <= 1e-12 * size) & ((first * second).sum(axis=1) > 0)
    out = np.ones(len(pairs), bool)
    out[pair[blocked]] = False
    return out


def _inside(coords: FloatArray, edges: IntArray, within: BoolArray, pairs: IntArray) -> BoolArray:
    """Which connections run through the region, by the parity of what a ray from them crosses."""
    sides = edges[within[:, 0] != within[:, 1]]
    middles = coords[pairs].mean(axis=1)
    a, b = coords[sides].swapaxes(0, 1)
    out = np.zeros(len(pairs), bool)
    for begin in range(0, len(pairs), 4096):
        x, y = middles[begin : begin + 4096].T[:, :, None]
        over = (a[:, 1] > y) != (b[:, 1] > y)
        with np.errstate(divide="ignore", invalid="ignore"):
            at = a[:, 0] + (y - a[:, 1]) / (b[:, 1] - a[:, 1]) * (b[:, 0] - a[:, 0])
        out[begin : begin + 4096] = (over & (at > x)).sum(axis=1) % 2 == 1
    return out


def _first_loop(
    coords: FloatArray, edges: IntArray, within: BoolArray, chosen: IntArray
) -> tuple[BoolArray, BoolArray] | None:
    """Of a walk that passes a vertex twice: which vertices are between, and which are beyond."""
    corners, offsets, walk = walks_of(coords, np.concatenate([edges, chosen]))
    both = np.concatenate([within, np.ones((len(chosen), 2), bool)])
    for number in np.unique(walk[both.T.ravel()]).tolist():
        ring = corners[offsets[number] : offsets[number + 1]]
        seen: dict[int, int] = {}
        for place, vertex in enumerate(ring.tolist()):
            if vertex in seen:
                inside, outside = np.zeros(len(coords), bool), np.zeros(len(coords), bool)
                inside[ring[seen[vertex] + 1 : place]] = True
                outside[np.concatenate([ring[: seen[vertex]], ring[place + 1 :]])] = True
                return inside & ~outside, outside & ~inside
            seen[vertex] = place
    return None
