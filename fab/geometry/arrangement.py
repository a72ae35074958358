"""The planar graph of straight lines that cross, overlap, repeat, and miss each other by a little.

Ends that are nearer than a tolerance become one vertex, ends that miss a line by less are moved
onto it, lines are split where they cross, and what is on each other becomes one edge. Moving an
end may lead to new crossings: all steps are repeated until nothing changes.

Lines are sorted by their coordinates first, so that neither their order nor their direction
changes the result.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import shapely
from scipy.spatial import cKDTree

from fab.geometry.distinct_points import distinct_points
from solver.errors import InvalidState
from solver.graphs import labels
from solver.polygons import next_corner
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["Arrangement", "arrangement"]

# Points nearer than this share of the drawing, or of their coordinates, are one in any case.
_ROUNDING_REL, _ROUNDING_ABS = 1e-12, 1e-14
# Over the drawing: what is off a line by less was written with few digits. Vertices are not moved
# for it, and needles that are narrower are none. No more than a share of what ends reach: two ends
# of a narrow triangle that are too far apart to be one would else be put onto each other's sides
# in turn.
_DIGITS_REL, _DIGITS_OF_REACH = 3e-6, 0.1
# Sines: lines of a joint that meet another line at less than this are needles; ends of lines that
# begin on that line, and part from it by less, are on it.
_NEEDLE, _DOUBLE = 0.1, 0.02
# An end goes on along its own line up to this many tolerances; beyond, straight to the other one.
_FARTHEST = 2.0
# A vertex is moved this often at most; then lines are bent to it.
_MOST_MOVES = 3
_MOST_ROUNDS = 40
# More crossings, or lines beside each other's boxes, do not fit into memory and time.
_MOST_CROSSINGS = 500_000
_MOST_NEAR = 50_000_000
# Ends that are on other lines, at most: so many, and so many more for each edge.
_MOST_BESIDE, _BESIDE_EACH = 300_000, 20
# Lines of which the crossings of all are estimated.
_SAMPLE = 200
# Pairs of edges that are looked at together.
_PAIRS = 2_000_000
# Later rounds change little; lines that grow to so many times their pieces of the first one go in
# circles.
_MOST_GROWTH = 20
# Points with more neighbours than this are joined to the nearest ones first.
_CROWD, _NEAREST = 40, 8


@dataclass(frozen=True)
class Arrangement:
    """A planar graph, and the lines that each of its edges is a part of.

    Attributes
    ----------
    vertices_coords : shape (nv, 2); in the order in which the ends of the lines name them, then
        crossings. Ends that were not moved keep their coordinates exactly.
    edges_vertices : shape (ne, 2), unique; in the order of the lines and along them.
    edges_lines, edges_offsets : edge e is part of the lines
        edges_lines[edges_offsets[e]:edges_offsets[e + 1]], rising.
    lines_coords : the lines, shape (n, 2, 2).
    ends_vertex : shape (n, 2), vertices at the ends of each line; -1 where lines without length
        are alone.
    settled : whether no more changes were needed when the rounds came to an end.
    """

    vertices_coords: FloatArray
    edges_vertices: IntArray
    edges_lines: IntArray
    edges_offsets: IntArray
    lines_coords: FloatArray
    ends_vertex: IntArray
    settled: bool

    @property
    def ends_moved(self) -> FloatArray:
        """How far both ends of each line were moved, shape (n, 2)."""
        out = np.zeros(self.ends_vertex.shape)
        named = self.ends_vertex >= 0
        moved = self.lines_coords[named] - self.vertices_coords[self.ends_vertex[named]]
        out[named] = np.hypot(*moved.T)
        return out

    @property
    def edges_count(self) -> IntArray:
        """How many lines each edge is a part of, shape (ne,)."""
        return np.diff(self.edges_offsets)

    @property
    def line_pairs(self) -> tuple[IntArray, IntArray]:
        """Lines and edges, a row for each edge of each line, in the order of the edges."""
        return self.edges_lines, np.repeat(np.arange(len(self.edges_count)), self.edges_count)

    def passes(self) -> tuple[IntArray, IntArray]:
        """Vertices at which lines go on, and those lines: a row for each such pair."""
        line, edge = self.line_pairs
        several = np.bincount(line, minlength=len(self.lines_coords))[line] > 1
        line, vertex = np.repeat(line[several], 2), self.edges_vertices[edge[several]].ravel()
        inner = (self.ends_vertex[line] != vertex[:, None]).all(axis=1)
        count = max(len(self.vertices_coords), 1)
        line, vertex = np.divmod(_distinct(line[inner] * count + vertex[inner]), count)
        return vertex, line

    def crossings(self) -> tuple[IntArray, IntArray]:
        """Vertices where lines cross, and those where others end on them (T-joints)."""
        vertex, _ = self.passes()
        through = np.bincount(vertex, minlength=len(self.vertices_coords))
        ends = self.ends_vertex[self.ends_vertex[:, 0] != self.ends_vertex[:, 1]]
        ending = np.bincount(ends[ends >= 0], minlength=len(self.vertices_coords))
        # lines on each other pass their vertices together: that is no crossing
        degree = np.bincount(self.edges_vertices.ravel(), minlength=len(self.vertices_coords))
        crossing = (through > 1) & (ending == 0) & (degree > 2)
        joint = (through > 0) & (ending > 0)
        return np.flatnonzero(crossing), np.flatnonzero(joint)

    def repeated(self) -> BoolArray:
        """Which lines are on earlier ones from end to end, shape (n,)."""
        line, _ = self.line_pairs
        first = np.ones(len(line), bool)
        first[1:] = np.diff(np.repeat(np.arange(len(self.edges_count)), self.edges_count)) > 0
        own = np.zeros(len(self.lines_coords), bool)
        own[line[first]] = True
        return ~own & (np.bincount(line, minlength=len(own)) > 0)


@dataclass(frozen=True)
class _Web:
    """What the rounds change: points, and lines as chains of pieces between them.

    Attributes
    ----------
    points, reach, moves : of each vertex; shapes (m, 2), (m,), (m,).
    line, ends : of each piece: its line and both vertices; in the order of and along the lines.
    lines_ends : shape (n, 2).
    """

    points: FloatArray
    reach: FloatArray
    moves: IntArray
    line: IntArray
    ends: IntArray
    lines_ends: IntArray

    def edges(self) -> tuple[IntArray, IntArray]:
        """Unique edges, lower vertex first, shape (ne, 2), and the edge of each piece."""
        low, high = self.ends.min(axis=1), self.ends.max(axis=1)
        keys, which = np.unique(low * len(self.points) + high, return_inverse=True)
        return np.column_stack(np.divmod(keys, len(self.points))), which


def arrangement(
    lines_coords: FloatArray, tolerance: float | FloatArray, *, needles: bool = True
) -> Arrangement:
    """The planar graph of lines.

    lines_coords : shape (n, 2, 2), both ends of each. tolerance : so far an end reaches for other
    ends and for lines; for all, or of each, shape (n, 2). needles : whether narrow triangles are
    meant, as in drawings; without, a vertex is put onto a line also where its own lines run beside
    that.

    Ends of no more reach than rounding are joined and split exactly. Raises `InvalidState` for
    lines with too many crossings.
    """
    lines_coords = np.asarray(lines_coords, np.float64).reshape(-1, 2, 2) + 0.0
    if not len(lines_coords):
        none = np.empty((0, 2), np.int64)
        return Arrangement(
            np.empty((0, 2)), none, none[:, 0], np.zeros(1, np.int64), lines_coords, none, True
        )
    flat = lines_coords.reshape(-1, 2)
    size = float(np.hypot(*np.ptp(flat, axis=0)))
    rounding = _ROUNDING_REL * size + _ROUNDING_ABS * float(np.abs(flat).max())
    reach = np.maximum(np.broadcast_to(tolerance, (len(lines_coords), 2)), rounding).ravel()
    web, turned, place = _sorted(flat, reach)
    digits = max(_DIGITS_REL * size, rounding)
    settled = False
    _require_few_crossings(lines_coords)
    web, _ = _merged(web)
    most = 0
    for _ in range(_MOST_ROUNDS):
        web, snapped = _snapped(web, digits, rounding, needles)
        web, joined = _merged(web)
        web, crossed = _crossed(web)
        web, met = _merged(web)
        settled = not (snapped or joined or crossed or met)
        if settled or 0 < most < len(web.ends):
            break
        most = most or _MOST_GROWTH * len(web.ends)
    return _assembled(web, lines_coords, turned, place, settled)


def _require_few_crossings(lines_coords: FloatArray) -> None:
    """Raise `InvalidState` where a sample says that lines cross too often."""
    count = len(lines_coords)
    if count * count <= _MOST_CROSSINGS:
        return
    shapes = shapely.linestrings(lines_coords)
    tree = shapely.STRtree(shapes)
    step = -(-count // _SAMPLE)
    sample = shapes[::step]
    share = count / len(sample) / 2
    row, other = tree.query(sample)
    near = len(row) * share
    crossing = near
    if near <= _MOST_NEAR:
        row = row * step
        crossing = share * int(_over(lines_coords[row], lines_coords[other]).sum())
    if crossing > _MOST_CROSSINGS:
        raise InvalidState(
            "lines",
            f"{count} lines have about {crossing:.2g} crossings and "
            f"{near:.2g} pairs near to each other, over the bounds of "
            f"{_MOST_CROSSINGS:g} and {_MOST_NEAR:g}",
            "Draw creases from crossing to crossing, or leave out hatchings.",
        )


def _sorted(flat: FloatArray, reach: FloatArray) -> tuple[_Web, BoolArray, IntArray]:
    """Distinct lines by their coordinates; which lines were turned, and the place of each."""
    points, number = distinct_points(flat)
    count = len(points)
    least = np.full(count, np.inf)
    np.minimum.at(least, number, reach)
    ends = number.reshape(-1, 2)
    turned = ends[:, 0] > ends[:, 1]
    keys, place = np.unique(ends.min(axis=1) * count + ends.max(axis=1), return_inverse=True)
    chains = np.column_stack(np.divmod(keys, count))
    line = np.arange(len(chains))
    real = chains[:, 0] != chains[:, 1]
    moves = np.zeros(count, np.int64)
    return _Web(points, least, moves, line[real], chains[real], chains), turned, place


def _merged(web: _Web) -> tuple[_Web, bool]:
    """Vertices within reach of each other become that of most lines; whether there were any."""
    alive = _marked(len(web.points), web.ends, web.lines_ends)
    points, reach = web.points[alive], web.reach[alive]
    pairs = _near_pairs(points, float(reach.max()))
    apart = np.hypot(*(points[pairs[:, 0]] - points[pairs[:, 1]]).T)
    pairs = pairs[apart <= reach[pairs].min(axis=1)]
    if not len(pairs):
        return web, False
    group = labels(pairs, len(alive))
    lines = len(web.lines_ends)
    keys = _distinct(web.ends.T.ravel() * lines + np.tile(web.line, 2))
    weight = np.bincount(keys // lines, minlength=len(web.points))[alive]
    order = np.lexsort((points[:, 1], points[:, 0], -weight, group))
    _, first = np.unique(group[order], return_index=True)
    merged_into = np.arange(len(web.points))
    merged_into[alive] = alive[order[first]][group]
    ends = merged_into[web.ends]
    real = ends[:, 0] != ends[:, 1]
    return replace(
        web, line=web.line[real], ends=ends[real], lines_ends=merged_into[web.lines_ends]
    ), True


def _near_pairs(points: FloatArray, reach: float) -> IntArray:
    """Pairs of points within reach; of crowded ones those with the nearest others."""
    tree = cKDTree(points)
    if tree.count_neighbors(tree, reach) <= _CROWD * len(points):
        return np.asarray(tree.query_pairs(reach, output_type="ndarray"), np.int64)
    apart, other = tree.query(points, _NEAREST + 1, distance_upper_bound=reach)
    row, column = np.nonzero(np.isfinite(apart))
    pairs = np.column_stack([row, other[row, column]])
    return np.asarray(np.unique(np.sort(pairs[pairs[:, 0] != pairs[:, 1]], axis=1), axis=0))


def _snapped(web: _Web, digits: float, rounding: float, needles: bool) -> tuple[_Web, bool]:
    """Edges split at vertices that are on them, some of which are moved there; whether any are."""
    if not len(web.ends):
        return web, False
    edges, _ = web.edges()
    vertex, edge = _beside(web, edges, _marked(len(web.points), edges))
    start, span = web.points[edges[edge, 0]], np.diff(web.points[edges[edge]], axis=1)[:, 0]
    length = np.hypot(*span.T)
    arm = web.points[vertex] - start
    share = (arm * span).sum(axis=1) / length**2
    off = np.abs(_cross(span, arm)) / length
    within = (share > 0) & (share < 1) & (off <= web.reach[vertex])
    far = off > np.clip(_DIGITS_OF_REACH * web.reach[vertex], rounding, digits)
    rows = np.flatnonzero(within)
    if needles:
        rows = rows[~_needles(web, edges, vertex[rows], edge[rows], far[rows])]
    if not len(rows):
        return web, False
    order = rows[np.lexsort((edge[rows], off[rows], vertex[rows]))]
    nearest = np.ones(len(order), bool)
    nearest[1:] = vertex[order][1:] != vertex[order][:-1]
    own = order[nearest]
    moving = own[far[own] & (web.moves[vertex[own]] < _MOST_MOVES)]
    points, moves = web.points.copy(), web.moves.copy()
    points[vertex[moving]] = _places(web, edges, vertex[moving], edge[moving])
    moves[vertex[moving]] += 1
    still = np.setdiff1d(order[~nearest & (off[order] <= rounding)], moving)
    still = still[~np.isin(vertex[still], vertex[moving])]
    splits = np.concatenate([own, still])
    web = replace(web, points=points, moves=moves)
    return _split(web, edge[splits], vertex[splits]), True


def _beside(web: _Web, edges: IntArray, vertices: IntArray) -> tuple[IntArray, IntArray]:
    """Vertices and the edges within their reach that do not end in them, a row for each pair."""
    tree = shapely.STRtree(shapely.linestrings(web.points[edges]))
    most = _MOST_BESIDE + _BESIDE_EACH * len(edges)
    found = [np.empty((2, 0), np.int64)]
    begin, rows, total = 0, 1000, 0
    while begin < len(vertices):
        some = vertices[begin : begin + rows]
        at = shapely.points(web.points[some])
        row, edge = tree.query(at, predicate="dwithin", distance=web.reach[some])
        per_row = len(row) / rows
        begin += rows
        rows = int(np.clip(_PAIRS / max(per_row, 1.0), 10, 2 * rows))
        free = (edges[edge] != some[row][:, None]).all(axis=1)
        found.append(np.stack([some[row[free]], edge[free]]))
        total += int(free.sum())
        if total > most:
            raise InvalidState(
                "lines",
                f"ends and crossings of {len(web.lines_ends)} lines are on other lines more than "
                f"{most} times",
                "Draw each crease once.",
            )
    vertex, edge = np.concatenate(found, axis=1)
    return vertex, edge


def _needles(
    web: _Web,
    edges: IntArray,
    vertex: IntArray,
    edge: IntArray,
    off_it: BoolArray,
) -> BoolArray:
    """Which vertices are near to an edge because their own edges run beside it, shape (n,).

    off_it : which of them are off the edge by more than the digits of the file.
    """
    out = np.zeros(len(vertex), bool)
    far = np.flatnonzero(off_it)
    if not len(far):
        return out
    start = np.concatenate([edges[:, 0], edges[:, 1]])
    end = np.concatenate([edges[:, 1], edges[:, 0]])
    order = np.argsort(start, kind="stable")
    first = np.searchsorted(start[order], vertex[far])
    degree = np.searchsorted(start[order], vertex[far], "right") - first
    row = np.repeat(np.arange(len(far)), degree)
    place = np.arange(len(row)) - np.repeat(np.cumsum(degree) - degree, degree) + first[row]
    other = end[order][place]
    arm = web.points[other] - web.points[vertex[far]][row]
    span = np.diff(web.points[edges[edge[far]]], axis=1)[:, 0][row]
    sine = np.abs(_cross(arm, span)) / (np.hypot(*arm.T) * np.hypot(*span.T))
    adjacent = (edges[edge[far]][row] == other[:, None]).any(axis=1)
    single = degree[row] == 1
    beside = np.where(single, adjacent & (sine > _DOUBLE), adjacent | (sine < _NEEDLE))
    out[far] = np.bincount(row, beside, minlength=len(far)) > 0
    return out


def _places(web: _Web, edges: IntArray, vertex: IntArray, edge: IntArray) -> FloatArray:
    """Where vertices come to be on an edge: on along their only line, or straight."""
    start, span = web.points[edges[edge, 0]], np.diff(web.points[edges[edge]], axis=1)[:, 0]
    points = web.points[vertex]
    foot = (
        start
        + ((points - start) * span).sum(axis=1)[:, None] / (span**2).sum(axis=1)[:, None] * span
    )
    degree = np.bincount(edges.ravel(), minlength=len(web.points))
    total = np.zeros(len(web.points), np.int64)
    np.add.at(total, edges[:, 0], edges[:, 1])
    np.add.at(total, edges[:, 1], edges[:, 0])
    ends = np.flatnonzero(degree[vertex] == 1)
    along = points[ends] - web.points[total[vertex[ends]]]
    along /= np.hypot(*along.T)[:, None]
    sine = _cross(along, span[ends])
    with np.errstate(divide="ignore", invalid="ignore"):
        travel = _cross(start[ends] - points[ends], span[ends]) / sine
        onward = points[ends] + travel[:, None] * along
        share = ((onward - start[ends]) * span[ends]).sum(axis=1) / (span[ends] ** 2).sum(axis=1)
        good = (np.abs(travel) <= _FARTHEST * web.reach[vertex[ends]]) & (share > 0) & (share < 1)
    foot[ends[good]] = onward[good]
    return np.asarray(foot, np.float64)


def _crossed(web: _Web) -> tuple[_Web, bool]:
    """Edges split where they cross others; whether any do."""
    if not len(web.ends):
        return web, False
    edges, _ = web.edges()
    first, second = _crossing_pairs(web.points, edges)
    if not len(first):
        return web, False
    start, span = web.points[edges[first, 0]], np.diff(web.points[edges[first]], axis=1)[:, 0]
    c, d = web.points[edges[second]].swapaxes(0, 1)
    left, right = _cross(c - start, d - c), _cross(span, d - c)
    meeting = right != 0  # else they are on one line, but for rounding
    if not meeting.all():
        first, second = first[meeting], second[meeting]
        start, span, left, right = start[meeting], span[meeting], left[meeting], right[meeting]
        if not len(first):
            return web, False
    crossing = start + (left / right)[:, None] * span
    number = len(web.points) + np.arange(len(first))
    reach = np.minimum(web.reach[edges[first]].max(axis=1), web.reach[edges[second]].max(axis=1))
    web = replace(
        web,
        points=np.concatenate([web.points, crossing]),
        reach=np.concatenate([web.reach, reach]),
        moves=np.concatenate([web.moves, np.zeros(len(first), np.int64)]),
    )
    return _split(web, np.concatenate([first, second]), np.tile(number, 2)), True


def _crossing_pairs(points: FloatArray, edges: IntArray) -> tuple[IntArray, IntArray]:
    """Pairs of edges that cross between their ends."""
    ends = points[edges]
    shapes = shapely.linestrings(ends)
    tree = shapely.STRtree(shapes)
    found = [np.empty((2, 0), np.int64)]
    begin, rows = 0, 1000
    while begin < len(edges):
        pairs = tree.query(shapes[begin : begin + rows])
        per_row = pairs.shape[1] / rows
        pairs[0] += begin
        begin += rows
        rows = int(np.clip(_PAIRS / max(per_row, 1.0), 10, 2 * rows))
        pairs = pairs[:, pairs[0] < pairs[1]]
        one, other = edges[pairs[0]], edges[pairs[1]]
        apart = (one[:, :1] != other).all(axis=1) & (one[:, 1:] != other).all(axis=1)
        pairs = pairs[:, apart]
        found.append(pairs[:, _over(ends[pairs[0]], ends[pairs[1]])])
    first, second = np.concatenate(found, axis=1)
    return first, second


def _split(web: _Web, edge: IntArray, vertex: IntArray) -> _Web:
    """Pieces along some edges split at vertices, a row of `edge` and `vertex` for each."""
    edges, which = web.edges()
    start, span = web.points[edges[edge, 0]], np.diff(web.points[edges[edge]], axis=1)[:, 0]
    share = ((web.points[vertex] - start) * span).sum(axis=1)
    order = np.lexsort((vertex, share, edge))
    edge, vertex = edge[order], vertex[order]
    counts = np.bincount(edge, minlength=len(edges))
    first = np.cumsum(counts) - counts
    more = counts[which]
    piece = np.repeat(np.arange(len(which)), more + 1)
    offsets = np.concatenate([[0], np.cumsum(more + 1)])
    along = np.arange(len(piece)) - offsets[piece]
    backward = web.ends[:, 0] != edges[which, 0]
    # the vertex that each new piece begins at, unless it is the first of its old one
    rank = np.where(backward[piece], more[piece] - along, along - 1)
    inner = along > 0
    begin = web.ends[piece, 0]
    begin[inner] = vertex[(first[which[piece]] + rank)[inner]]
    end = np.empty_like(begin)
    following = next_corner(offsets) if len(piece) else piece
    end = begin[following]
    last = offsets[1:] - 1
    end[last] = web.ends[:, 1]
    ends = np.column_stack([begin, end])
    real = begin != end
    return replace(web, line=web.line[piece][real], ends=ends[real])


def _assembled(
    web: _Web, lines_coords: FloatArray, turned: BoolArray, place: IntArray, settled: bool
) -> Arrangement:
    """The graph with edges and vertices in the order of the lines as they were given."""
    count = len(lines_coords)
    edges, which = web.edges() if len(web.ends) else (np.empty((0, 2), np.int64), web.line)
    # a row for each piece of each line as given, along it
    pieces = np.bincount(web.line, minlength=len(web.lines_ends))
    first = np.cumsum(pieces) - pieces
    sizes = pieces[place]
    line = np.repeat(np.arange(count), sizes)
    along = np.arange(len(line)) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    back = turned[line]
    piece = first[place[line]] + np.where(back, sizes[line] - 1 - along, along)
    ends = np.where(back[:, None], web.ends[piece][:, ::-1], web.ends[piece])
    edge = which[piece]
    _, begin = np.unique(edge, return_index=True)
    begin = np.sort(begin)
    number = np.empty(len(edges), np.int64)
    number[edge[begin]] = np.arange(len(begin))
    keys = _distinct(number[edge] * count + line)
    edges_lines = keys % count
    offsets = np.searchsorted(keys // count, np.arange(len(begin) + 1))
    lines_ends = web.lines_ends[place]
    lines_ends[turned] = lines_ends[turned][:, ::-1]
    named = np.concatenate([lines_ends.ravel(), ends[begin].ravel()])
    used = np.zeros(len(web.points), bool)
    used[ends] = True
    named = named[used[named]]
    vertices, at = np.unique(named, return_index=True)
    vertices = vertices[np.argsort(at)]
    new = np.full(len(web.points), -1)
    new[vertices] = np.arange(len(vertices))
    return Arrangement(
        web.points[vertices],
        new[ends[begin]],
        edges_lines,
        offsets,
        lines_coords,
        new[lines_ends],
        settled,
    )


def _marked(count: int, *numbers: IntArray) -> IntArray:
    """The numbers below `count` that occur, rising."""
    out = np.zeros(count, bool)
    for each in numbers:
        out[each] = True
    return np.flatnonzero(out)


def _distinct(keys: IntArray) -> IntArray:
    """As `numpy.unique`, whose hash tables are slow for keys that are evenly spaced."""
    keys = np.sort(keys)
    new = np.ones(len(keys), bool)
    new[1:] = keys[1:] != keys[:-1]
    out: IntArray = keys[new]
    return out


def _over(first: FloatArray, second: FloatArray) -> BoolArray:
    """Which lines cross the others between the ends of both, shapes (n, 2, 2)."""
    (a, b), (c, d) = first.swapaxes(0, 1), second.swapaxes(0, 1)
    out: BoolArray = _cross(b - a, c - a) * _cross(b - a, d - a) < 0
    out &= _cross(d - c, a - c) * _cross(d - c, b - c) < 0
    return out


def _cross(first: FloatArray, second: FloatArray) -> FloatArray:
    out: FloatArray = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
    return out
