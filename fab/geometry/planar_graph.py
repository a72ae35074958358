"""Planar graphs: the faces that lines enclose, and lines that cross or lie on each other."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components, depth_first_order

from fab.geometry.rings import ring_areas
from solver.graphs import weighted_graph
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = [
    "enclosed_faces",
    "first_abutting",
    "first_crossing",
    "walks_of",
    "without_dangling",
]

_CHUNK = 100_000


def without_dangling(edges_vertices: IntArray) -> BoolArray:
    """Which edges are left when edges with a free end are removed, again and again, (ne,)."""
    if not len(edges_vertices):
        return np.zeros(0, bool)
    ends = edges_vertices.ravel()
    degree = np.bincount(ends)
    # of a vertex with one edge left, the exclusive or of its edges is that edge
    rest = np.zeros(len(degree), np.int64)
    np.bitwise_xor.at(rest, ends, np.repeat(np.arange(len(edges_vertices)), 2))
    kept = np.ones(len(edges_vertices), bool)
    free = np.flatnonzero(degree == 1).tolist()
    while free:
        vertex = free.pop()
        if degree[vertex] != 1:
            continue
        edge = rest[vertex]
        kept[edge] = False
        for end in edges_vertices[edge].tolist():
            degree[end] -= 1
            rest[end] ^= edge
            if degree[end] == 1:
                free.append(end)
    return kept


def walks_of(
    vertices_coords: FloatArray, edges_vertices: IntArray
) -> tuple[IntArray, IntArray, IntArray]:
    """Walks along all edges of a planar graph: corners and offsets, and the walk of each side.

    Each edge is walked once in either direction; at its end the walk goes on along the next edge
    clockwise from the one it came by, so that a face stays on its left (Muller and Preparata
    1978, doubly connected edge lists). Walks around a whole component run clockwise.

    The walk on the left of edge e is the third array's entry e, that on its right entry ne + e.
    Edges must not cross; edges with a free end make a walk pass its vertices twice.
    """
    start = edges_vertices.T.ravel()
    end = edges_vertices[:, ::-1].T.ravel()
    count = len(start)
    if not count:
        return np.empty(0, np.int64), np.zeros(1, np.int64), np.empty(0, np.int64)
    twin = np.roll(np.arange(count), count // 2)
    along = vertices_coords[end] - vertices_coords[start]
    order = np.lexsort((np.arctan2(along[:, 1], along[:, 0]), start))
    place = np.empty(count, np.int64)
    place[order] = np.arange(count)
    first = np.searchsorted(start[order], np.arange(len(vertices_coords)))
    last = np.searchsorted(start[order], np.arange(len(vertices_coords)), "right") - 1
    back = place[twin]  # of the half edge that runs back, among those that begin at the end
    following = order[np.where(back == first[end], last[end], back - 1)]
    steps, offsets, walk = _cycles(following)
    return start[steps], offsets, walk


def _cycles(following: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Cycles of a permutation, each from its least number on, by these; and the cycle of each.

    The cycles are members and offsets, as rings are.
    """
    count = len(following)
    number = np.arange(count)
    cycle = connected_components(_graph(following), connection="strong")[1]
    head = np.empty(int(cycle.max()) + 1, np.int64)
    head[cycle[::-1]] = number[::-1]
    head = head[cycle]
    first = head == number
    cycle = np.cumsum(first)[head] - 1
    offsets = np.concatenate([[0], np.cumsum(np.bincount(cycle))])
    # where a cycle closes it goes on with the next one: a single path through all of them
    path = following.copy()
    last = np.flatnonzero(following == head)
    path[last] = np.append(np.flatnonzero(first), 0)[cycle[last] + 1]
    members = depth_first_order(_graph(path), 0, return_predecessors=False)
    return np.asarray(members, np.int64), offsets, cycle


def _graph(following: IntArray) -> csr_array:
    """One directed edge from each number."""
    count = len(following)
    return weighted_graph(np.ones(count), np.column_stack([np.arange(count), following]), count)


def enclosed_faces(
    vertices_coords: FloatArray, edges_vertices: IntArray
) -> tuple[IntArray, IntArray]:
    """All bounded faces of a planar graph, counterclockwise: corners and offsets.

    See `walks_of`; walks around a whole component are left out.

    >>> square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    >>> lines = np.array([[0, 1], [1, 2], [2, 3], [3, 0], [0, 2]])
    >>> corners, offsets = enclosed_faces(square, lines)
    >>> corners.tolist(), offsets.tolist()
    ([0, 1, 2, 2, 3, 0], [0, 3, 6])
    """
    corners, bounds, _ = walks_of(vertices_coords, edges_vertices)
    bounded = ring_areas(vertices_coords[corners], bounds) > 0
    sizes = np.diff(bounds)
    return corners[np.repeat(bounded, sizes)], np.concatenate([[0], np.cumsum(sizes[bounded])])


def first_crossing(
    vertices_coords: FloatArray,
    edges_vertices: IntArray,
    tolerance: float,
    may_touch: BoolArray,
) -> tuple[int, int, FloatArray] | None:
    """Two edges that meet elsewhere than in a common vertex, and a point where; None if none do.

    tolerance : an end this near to an edge lies on it. may_touch : shape (ne,); of two such edges,
    ends may lie on the other edge, or both on each other (the lips of a slit); they must not cross.
    """
    ends = vertices_coords[edges_vertices]
    for first, second in _near(ends, tolerance):
        found = _meeting(ends, edges_vertices, first, second, tolerance, may_touch)
        if found is not None:
            return found
    return None


def first_abutting(
    vertices_coords: FloatArray,
    edges_vertices: IntArray,
    tolerance: float,
    may_touch: BoolArray,
) -> tuple[int, int, FloatArray] | None:
    """Two edges that run along each other in opposite directions, and a point where; None if none.

    Of faces that are counterclockwise, and wind these edges, one lies on either side. Edges that
    turn away from each other, or meet end to end, do not abut.

    tolerance : an end this near to an edge lies on it. may_touch : shape (ne,); two such edges may
    abut.
    """
    ends = vertices_coords[edges_vertices]
    for first, second in _near(ends, tolerance):
        checked = ~(may_touch[first] & may_touch[second])
        first, second = first[checked], second[checked]
        (a, b), (c, d) = ends[first].swapaxes(0, 1), ends[second].swapaxes(0, 1)
        length = np.hypot(*(b - a).T)
        along = (b - a) / length[:, None]
        level = np.abs([_off(a, b, c), _off(a, b, d)]).max(axis=0) <= tolerance
        level |= np.abs([_off(c, d, a), _off(c, d, b)]).max(axis=0) <= tolerance
        # where the second edge begins and ends along the first, in length; it runs back
        start, end = ((c - a) * along).sum(axis=1), ((d - a) * along).sum(axis=1)
        low = np.maximum(end, 0)
        common = np.minimum(start, length) - low
        found = np.flatnonzero(level & (common > tolerance))
        if len(found):
            k = int(found[0])
            middle = low[k] + common[k] / 2
            return int(first[k]), int(second[k]), a[k] + middle * along[k]
    return None


def _near(ends: FloatArray, tolerance: float) -> Iterator[tuple[IntArray, IntArray]]:
    """Pairs of edges whose boxes come nearer than the tolerance, in batches, first < second."""
    import shapely

    tree = shapely.STRtree(shapely.linestrings(ends))
    boxes = shapely.box(*(ends.min(axis=1) - tolerance).T, *(ends.max(axis=1) + tolerance).T)
    for begin in range(0, len(ends), _CHUNK):
        first, second = tree.query(boxes[begin : begin + _CHUNK])
        first = first + begin
        yield first[first < second], second[first < second]


def _meeting(
    ends: FloatArray,
    edges_vertices: IntArray,
    first: IntArray,
    second: IntArray,
    tolerance: float,
    may_touch: BoolArray,
) -> tuple[int, int, FloatArray] | None:
    a, b = ends[first].swapaxes(0, 1)
    c, d = ends[second].swapaxes(0, 1)
    sides = [_off(a, b, c), _off(a, b, d), _off(c, d, a), _off(c, d, b)]
    apart = np.min([np.abs(side) for side in sides], axis=0) > tolerance
    crosses = apart & (sides[0] * sides[1] < 0) & (sides[2] * sides[3] < 0)
    touching = ~(may_touch[first] & may_touch[second])
    for (p, q), others, ours, point in (
        ((a, b), edges_vertices[first], edges_vertices[second, 0], c),
        ((a, b), edges_vertices[first], edges_vertices[second, 1], d),
        ((c, d), edges_vertices[second], edges_vertices[first, 0], a),
        ((c, d), edges_vertices[second], edges_vertices[first, 1], b),
    ):
        shared = (others == ours[:, None]).any(axis=1)
        on = touching & ~shared & (np.abs(_off(p, q, point)) <= tolerance)
        span = q - p
        length = np.hypot(*span.T)
        along = ((point - p) * span).sum(axis=1) / length
        on &= (along >= -tolerance) & (along <= length + tolerance)
        if on.any():
            k = int(np.argmax(on))
            return int(first[k]), int(second[k]), point[k]
    if crosses.any():
        k = int(np.argmax(crosses))
        share = sides[2][k] / (sides[2][k] - sides[3][k])
        return int(first[k]), int(second[k]), a[k] + share * (b[k] - a[k])
    return None


def _off(p: FloatArray, q: FloatArray, points: FloatArray) -> FloatArray:
    """Signed distance of points from the lines through p and q, positive on the left."""
    span, to = q - p, points - p
    out: FloatArray = (span[:, 0] * to[:, 1] - span[:, 1] * to[:, 0]) / np.hypot(*span.T)
    return out
