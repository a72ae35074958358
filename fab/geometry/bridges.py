"""Bridges across a region of the plane with islands, which divide it into simple polygons."""

from __future__ import annotations

import numpy as np
import shapely
from scipy.spatial import Delaunay, QhullError

from fab.geometry.constrained_triangles import triangle_sides
from fab.geometry.planar_graph import walks_of
from fab.geometry.planar_regions import points_within, regions_of
from fab.geometry.rings import ring_areas
from solver.graphs import EdgeIndex, labels
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["bridges"]

# Over the region: bridges are so far from other vertices.
_CLEARANCE_REL = 1e-6
# Bridges between all of so few corners, beside so few lines, are tried one by one.
_MOST_TRIED, _MOST_BESIDE = 100, 1000
# With more edges none are looked for.
_MOST_EDGES = 70_000
# Of the shortest bridges so many are tried, then all.
_TRIED = 1000


def bridges(
    vertices_coords: FloatArray, edges_vertices: IntArray, within: BoolArray, obstacles: IntArray
) -> IntArray | None:
    """Pairs of vertices whose connections divide a region into simple polygons, shape (k, 2).

    edges_vertices : all edges around the region, shape (ne, 2). within : shape (ne, 2), whether the
    region is on the left and on the right of each. obstacles : further edges in the region, which
    bridges must not touch. Short bridges are preferred; None where there are too many edges, or
    obstacles and vertices that are too near leave no way.

    Sides of Delaunay triangles come first; then, of few corners, all bridges, and of many the sides
    of triangles that keep to all edges, which suffice wherever nothing is in the way.
    """
    lines = np.concatenate([edges_vertices, obstacles])
    if len(lines) > _MOST_EDGES:
        return None
    used, own = np.unique(lines, return_inverse=True)  # a region is a small part of a sheet
    edges, obstacles = np.split(own.reshape(-1, 2), [len(edges_vertices)])
    coords = vertices_coords[used]
    corners = np.unique(edges)
    pairs = _clear(coords, edges, within, obstacles, _delaunay(corners, coords[corners]))
    found = _least(coords, edges, within, pairs)
    if found is None:
        found = _shortest(coords, edges, within, obstacles)
    if found is None:
        pairs = _between_triangles(coords, edges, within, obstacles)
        found = _least(coords, edges, within, pairs)
    if found is None:
        pairs = _in_what_is_left(coords, edges, within, obstacles, pairs)
        found = _least(coords, edges, within, pairs)
    return None if found is None else used[found]


def _clear(
    coords: FloatArray, edges: IntArray, within: BoolArray, obstacles: IntArray, pairs: IntArray
) -> IntArray:
    """The pairs that see each other within the region, short ones first."""
    pairs = pairs[_visible(coords, edges, obstacles, pairs)]
    pairs = pairs[_inside(coords, edges, within, pairs)]
    span = np.diff(coords[pairs], axis=1)[:, 0]
    return pairs[np.lexsort((pairs[:, 1], pairs[:, 0], np.round(np.hypot(*span.T), 9)))]


def _between_triangles(
    coords: FloatArray, edges: IntArray, within: BoolArray, obstacles: IntArray
) -> IntArray:
    """Sides of triangles that all edges are sides of, where they may be bridges."""
    pairs = triangle_sides(coords, np.concatenate([edges, obstacles]))
    corner = np.zeros(len(coords), bool)
    corner[edges] = True
    pairs = pairs[corner[pairs].all(axis=1)]
    pairs = pairs[EdgeIndex.of(edges, len(coords)).find(pairs) < 0]
    return _clear(coords, edges, within, obstacles, pairs)


def _in_what_is_left(
    coords: FloatArray, edges: IntArray, within: BoolArray, obstacles: IntArray, pairs: IntArray
) -> IntArray:
    """Further bridges in the parts that these leave with islands, as far as they are found."""
    lines = np.concatenate([edges, pairs])
    regions = regions_of(coords, lines)
    inside = np.concatenate([within, np.ones((len(pairs), 2), bool)])
    place = points_within(coords[obstacles].mean(axis=1), coords, regions)
    found = [pairs]
    for part in np.intersect1d(regions.broken(), regions.sides[inside]).tolist():
        own = regions.sides == part
        around = np.flatnonzero(own.any(axis=1))
        some = _shortest(coords, lines[around], own[around], obstacles[place == part])
        if some is not None:
            found.append(some)
    return np.concatenate(found)


def _least(
    coords: FloatArray, edges: IntArray, within: BoolArray, pairs: IntArray
) -> IntArray | None:
    """Of bridges that do not cross, few that suffice; None where all of them do not.

    The polygons on both sides of a bridge are joined, longest bridges first, where they have
    nothing but its ends in common.
    """
    count = len(pairs)
    corners, offsets, walk = walks_of(coords, np.concatenate([edges, pairs]))
    sides = np.concatenate([within, np.ones((count, 2), bool)])
    region = np.unique(walk[sides.T.ravel()])
    if (ring_areas(coords[corners], offsets)[region] <= 0).any():
        return None  # an island that no bridge leads to
    inner = np.isin(np.arange(len(offsets) - 1), region)
    own = np.repeat(np.arange(len(inner)), np.diff(offsets))
    keys = np.sort((own * len(coords) + corners)[inner[own]])
    if (keys[1:] == keys[:-1]).any():
        return None  # a polygon that touches itself
    bounds = offsets.tolist()
    rings = corners.tolist()
    members = {
        number: set(rings[bounds[number] : bounds[number + 1]]) for number in region.tolist()
    }
    parent = list(range(len(offsets) - 1))

    def of(number: int) -> int:
        while parent[number] != number:
            parent[number] = parent[parent[number]]
            number = parent[number]
        return number

    left, right = walk[: len(sides)], walk[len(sides) :]
    kept = np.ones(count, bool)
    for bridge in range(count - 1, -1, -1):
        first, second = of(int(left[len(edges) + bridge])), of(int(right[len(edges) + bridge]))
        if len(members[first]) < len(members[second]):
            first, second = second, first
        if first != second and len(members[first] & members[second]) == 2:
            members[first] |= members.pop(second)
            parent[second] = first
            kept[bridge] = False
    return pairs[kept]


def _delaunay(vertices: IntArray, points: FloatArray) -> IntArray:
    """Sides of Delaunay triangles over points, by the numbers of these, shape (n, 2)."""
    if len(points) < 3:
        return np.empty((0, 2), np.int64)
    try:
        triangles = Delaunay(points - points.mean(axis=0)).simplices
    except QhullError:  # all on a line
        return np.empty((0, 2), np.int64)
    sides = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, 1:], triangles[:, ::2]]), 1)
    return np.asarray(vertices[np.unique(sides, axis=0)], np.int64)


def _shortest(
    coords: FloatArray, edges: IntArray, within: BoolArray, obstacles: IntArray
) -> IntArray | None:
    """The shortest of all bridges that suffice; short ones are tried alone.

    None where they do not suffice, or there are more corners or lines than are tried.
    """
    corners = np.unique(edges)
    if len(corners) > _MOST_TRIED or len(edges) + len(obstacles) > _MOST_BESIDE:
        return None
    low, high = np.triu_indices(len(corners), 1)
    pairs = np.column_stack([corners[low], corners[high]])
    span = np.diff(coords[pairs], axis=1)[:, 0]
    pairs = pairs[np.argsort(np.hypot(*span.T), kind="stable")]
    for count in (_TRIED, len(pairs)):
        some = _clear(coords, edges, within, obstacles, pairs[:count])
        found = _one_by_one(coords, edges, within, some)
        if found is not None or count >= len(pairs):
            break
    return found


def _one_by_one(
    coords: FloatArray, edges: IntArray, within: BoolArray, pairs: IntArray
) -> IntArray | None:
    """Of bridges that may cross, the shortest that still helps, until all polygons are simple."""
    chosen = np.empty((0, 2), np.int64)
    count = len(coords)
    while True:
        part = labels(np.concatenate([edges, chosen]), count)
        apart = np.flatnonzero(part[pairs[:, 0]] != part[pairs[:, 1]])
        if len(apart):
            bridge = pairs[apart[:1]]
        elif len(np.unique(part[edges])) > 1:
            return None
        else:
            loop = _first_loop(coords, edges, within, chosen)
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
        pairs = pairs[_visible(coords, bridge, bridge[:0], pairs)]


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
    # nor do they pass a vertex so near that its digits decide on which side
    vertices = np.unique(lines)
    near = _CLEARANCE_REL * float(np.ptp(coords[vertices], axis=0).max(initial=0.0))
    points = shapely.STRtree(shapely.points(coords[vertices]))
    shapes = shapely.linestrings(coords[pairs])
    pair, place = points.query(shapes, predicate="dwithin", distance=near)
    passed = (pairs[pair] != vertices[place][:, None]).all(axis=1)
    out[pair[passed]] = False
    return out


def _inside(coords: FloatArray, edges: IntArray, within: BoolArray, pairs: IntArray) -> BoolArray:
    """Which connections, that cross no edge, run through the region."""
    corners, offsets, walk = walks_of(coords, edges)
    rings = [corners[offsets[i] : offsets[i + 1]] for i in np.unique(walk[within.T.ravel()])]
    # walks along an edge with the region on both sides count twice, and so do not count
    rings = [ring for ring in rings if len(ring) > 2]  # others are single edges
    areas = [float(ring_areas(coords[ring], np.array([0, len(ring)]))[0]) for ring in rings]
    outer = int(np.argmax(areas))
    region = shapely.Polygon(
        coords[rings[outer]], [coords[ring] for i, ring in enumerate(rings) if i != outer]
    )
    shapely.prepare(region)
    inside: BoolArray = shapely.intersects_xy(region, *coords[pairs].mean(axis=1).T)
    return inside


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
