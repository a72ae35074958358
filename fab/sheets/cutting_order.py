"""In which order and direction are the lines of a sheet cut, and how long does that take?

The order of the work is that of the operations. Within one, a tour starts at the line nearest to
the head, goes on to the nearest that is left, and is then improved by 2-opt and Or-opt moves.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import hypot

import numpy as np
import shapely
from scipy.spatial import KDTree

from fab.drawings.cut_paths import CutPaths, Layer, Operation
from fab.sheets.materials import Speeds
from solver.vectors import FloatArray, IntArray

__all__ = ["Estimate", "estimate", "tour"]

# Points looked at around each end of a line, itself among them.
_NEIGHBOURS = 10
# Longest run of lines that a move reverses or passes by, and looks at a line on average.
_LONGEST_RUN = 50_000
_LOOKS = 40
# A move must gain so much, in mm: rounding must not send the head in circles.
_GAIN_MM = 1e-9
# Rounds of choosing the start of each outline anew.
_ROUNDS = 4


@dataclass(frozen=True)
class Estimate:
    """What a machine does with one sheet, for the order in which its lines stand.

    Attributes
    ----------
    pierces : lines and outlines cut through; engraved ones need none.
    cut_mm, perforate_mm, engrave_mm : length of the work. travel_mm : from the origin to the first
        line and from line to line, without the way home.
    minutes : all lengths at their speeds, and the pierces.
    """

    pierces: int
    cut_mm: float
    perforate_mm: float
    engrave_mm: float
    travel_mm: float
    minutes: float


def tour(paths: CutPaths) -> CutPaths:
    """The same lines in an order and direction that keep the travel short, from the origin on.

    Operations follow each other in the order of the work, in each the segments before the
    outlines. CUT outlines go inside-out: those that lie deepest within others come first, so that
    nothing is cut in a piece that is free already, and the outermost are freed last. Segments may
    be reversed; outlines may start at any of their vertices. From where the head comes from, the
    travel of each group is no longer than in the order given, or by nearest neighbours alone.
    """
    head = np.zeros(2)
    layers = []
    for layer in sorted(paths.layers, key=lambda layer: list(Operation).index(layer.operation)):
        segments = _segments_tour(layer.segments, head)
        head = segments[-1, 1] if len(segments) else head
        outlines: list[FloatArray] = []
        for group in _groups(layer):
            outlines += _outlines_tour(group, head)
            head = outlines[-1][0]
        layers.append(replace(layer, segments=segments, outlines=tuple(outlines)))
    return replace(paths, layers=tuple(layers))


def estimate(paths: CutPaths, speeds: Speeds) -> Estimate:
    """Lengths and time for the lines in the order in which they stand; see `Estimate`."""
    pierces = 0
    cut = perforate = engrave = 0.0
    stops = [np.zeros((1, 2))]
    for layer in paths.layers:
        length = _lengths(layer.segments).sum()
        length += sum(_lengths(_sides(outline)).sum() for outline in layer.outlines)
        lines = len(layer.segments) + len(layer.outlines)
        if layer.operation is Operation.ENGRAVE:
            engrave += float(length)
        else:
            pierces += lines
            if layer.operation in (Operation.MOUNTAIN, Operation.VALLEY):
                perforate += float(length)
            else:
                cut += float(length)
        stops.append(layer.segments.reshape(-1, 2))
        stops += [outline[[0, 0]] for outline in layer.outlines]
    travel = travel_mm(np.concatenate(stops)[1:].reshape(-1, 2, 2), stops[0][0])
    seconds = (
        cut / speeds.cut_mm_s
        + perforate / speeds.perforate_mm_s
        + engrave / speeds.engrave_mm_s
        + travel / speeds.travel_mm_s
        + pierces * speeds.pierce_s
    )
    return Estimate(pierces, cut, perforate, engrave, travel, seconds / 60)


def travel_mm(lines: FloatArray, head: FloatArray) -> float:
    """Length of the way from `head` to the first line and from line to line, (n, 2, 2)."""
    before = np.concatenate([head[None], lines[:, 1]])[: len(lines)]
    return float(_lengths(np.stack([before, lines[:, 0]], axis=1)).sum())


def _lengths(segments: FloatArray) -> FloatArray:
    out: FloatArray = np.hypot(*(segments[:, 1] - segments[:, 0]).T)
    return out


def _sides(outline: FloatArray) -> FloatArray:
    return np.stack([outline, np.roll(outline, -1, axis=0)], axis=1)


def _groups(layer: Layer) -> Iterator[list[FloatArray]]:
    """Outlines that may be cut in any order; CUT outlines by depth, the deepest first."""
    outlines = layer.outlines
    if not outlines:
        return
    if layer.operation is not Operation.CUT:
        yield list(outlines)
        return
    depth = _depths(outlines)
    for level in range(depth.max(), -1, -1):
        yield [outlines[i] for i in np.flatnonzero(depth == level)]


def _depths(outlines: tuple[FloatArray, ...]) -> IntArray:
    """How many other outlines each one lies within, shape (n,)."""
    shapes = np.array([shapely.Polygon(outline) for outline in outlines])
    area = shapely.area(shapes)
    # outlines do not cross: a point of the smaller one tells, and touching does no harm
    points = shapely.point_on_surface(shapes)
    inside, around = shapely.STRtree(shapes).query(points, predicate="intersects")
    return np.bincount(inside[area[inside] < area[around]], minlength=len(outlines))


def _segments_tour(segments: FloatArray, head: FloatArray) -> FloatArray:
    """The segments in order and direction, shape (n, 2, 2)."""
    if not len(segments):
        return segments
    ends = segments.reshape(-1, 2)
    number = np.arange(len(ends))
    entries = nearest_neighbours(ends, number // 2, number ^ 1, head)
    if travel_mm(segments, head) <= travel_mm(_directed(ends, entries), head):
        entries = number[::2]
    entries = _Tour(ends, entries, head).improved()
    return _directed(ends, entries)


def _directed(ends: FloatArray, entries: IntArray) -> FloatArray:
    return np.stack([ends[entries], ends[entries ^ 1]], axis=1)


def _outlines_tour(outlines: list[FloatArray], head: FloatArray) -> list[FloatArray]:
    """The outlines in order, each from the vertex where its cut starts and ends."""
    vertices = np.concatenate(outlines)
    sizes = [len(outline) for outline in outlines]
    first = np.cumsum([0, *sizes[:-1]])
    owner = np.repeat(np.arange(len(outlines)), sizes)
    start = nearest_neighbours(vertices, owner, np.arange(len(vertices)), head)
    given = vertices[first]
    if travel_mm(given[:, None].repeat(2, 1), head) <= travel_mm(
        vertices[start][:, None].repeat(2, 1), head
    ):
        start = first
    for _ in range(_ROUNDS):
        # an outline is a line that ends where it starts
        lines = vertices[start].repeat(2, axis=0)
        start = start[_Tour(lines, 2 * np.arange(len(start)), head).improved() // 2]
        order = owner[start]
        better = first[order] + _best_starts(outlines, order, start - first[order], head)
        if np.array_equal(better, start):
            break
        start = better
    return [
        np.roll(outlines[number], first[number] - at, axis=0)
        for number, at in zip(owner[start].tolist(), start.tolist(), strict=True)
    ]


def _best_starts(
    outlines: list[FloatArray], order: IntArray, chosen: IntArray, head: FloatArray
) -> IntArray:
    """For each outline in turn the vertex of the shortest detour between its neighbours."""
    chosen = chosen.copy()
    before = head
    for i, number in enumerate(order.tolist()):
        corner = outlines[number]
        way = np.hypot(*(corner - before).T)
        if i + 1 < len(order):
            following = outlines[order[i + 1]][chosen[i + 1]]
            way += np.hypot(*(corner - following).T)
        if way.min() < way[chosen[i]] - _GAIN_MM:
            chosen[i] = np.argmin(way)
        before = corner[chosen[i]]
    return chosen


def nearest_neighbours(
    points: FloatArray, owner: IntArray, leave: IntArray, head: FloatArray
) -> IntArray:
    """Where each line is entered: always the nearest point of a line not yet cut, shape (n,).

    Parameters
    ----------
    points : where lines can be entered, shape (m, 2); owner : the line of each, shape (m,), from
        0 to n - 1.
    leave : the point where a line that was entered here is left, shape (m,).
    """
    count = int(owner.max()) + 1
    tree = KDTree(points)
    near = tree.query(points, min(_NEIGHBOURS, len(points)))[1].reshape(len(points), -1)
    near_of, owned, left = near.tolist(), owner.tolist(), leave.tolist()
    alive = np.arange(len(points))
    done = bytearray(count)
    entries = []
    at = int(tree.query(head)[1])
    while True:
        entries.append(at)
        done[owned[at]] = 1
        if len(entries) == count:
            return np.array(entries)
        here = left[at]
        for point in near_of[here]:
            if not done[owned[point]]:
                at = point
                break
        else:
            if len(alive) > 8 and 2 * (count - len(entries)) * len(points) < len(alive) * count:
                alive = alive[~np.frombuffer(done, bool)[owner[alive]]]
                tree = KDTree(points[alive])
            at = _nearest_left(tree, points[here], alive, owned, done)


def _nearest_left(
    tree: KDTree, point: FloatArray, alive: IntArray, owned: list[int], done: bytearray
) -> int:
    """The nearest point in the tree whose line is not done; there is one."""
    k = 2 * _NEIGHBOURS
    while True:
        found = np.atleast_1d(tree.query(point, min(k, len(alive)))[1])
        for at in alive[found].tolist():
            if not done[owned[at]]:
                return int(at)
        k *= 4


class _Tour:
    """Lines in the order and direction in which the head passes them, and moves that shorten it.

    Line i has the ends 2 i and 2 i + 1, and end ^ 1 is the other end of its line. The line at
    place j is entered at entry[j]; link j leads to it; the way is open behind the last line:

        link          0        1        2
               head ~ place 0 ~ place 1 ~ place 2
    """

    def __init__(self, ends: FloatArray, entries: IntArray, head: FloatArray) -> None:
        count = len(entries)
        self.count = count
        self.entries = entries.astype(np.int64)
        self.places = np.empty(count, np.int64)
        self.places[self.entries >> 1] = np.arange(count)
        # numbers are read through views, which is faster than from the arrays
        self.entry, self.place = self.entries.data, self.places.data
        # two ends more: the head, and one for the open end, at no distance from anything
        self.head, self.none = 2 * count, 2 * count + 1
        self.x, self.y = ends[:, 0].tolist(), ends[:, 1].tolist()
        self.x.append(float(head[0]))
        self.y.append(float(head[1]))
        self.near = KDTree(ends).query(ends, min(_NEIGHBOURS, len(ends)))[1].tolist()

    def improved(self) -> IntArray:
        """The entries after 2-opt and Or-opt moves, until none gains or the effort is spent."""
        queue = deque(np.column_stack([self.entries, self.entries ^ 1]).ravel().tolist())
        waiting = bytearray(b"\1") * (2 * self.count)
        for _ in range(_LOOKS * self.count):
            if not queue:
                break
            end = queue.popleft()
            waiting[end] = 0
            for moved in self._move(end):
                if moved < self.head and not waiting[moved]:
                    waiting[moved] = 1
                    queue.append(moved)
        return self.entries

    def _distance(self, one: int, two: int) -> float:
        if one == self.none or two == self.none:
            return 0.0
        return hypot(self.x[one] - self.x[two], self.y[one] - self.y[two])

    def _before(self, link: int) -> int:
        """The end from which a link leads."""
        return self.entry[link - 1] ^ 1 if link else self.head

    def _behind(self, link: int) -> int:
        """The end to which a link leads."""
        return self.entry[link] if link < self.count else self.none

    def _move(self, end: int) -> tuple[int, ...]:
        """Make one move that joins `end` to a nearer end; the ends whose links it changed."""
        place = self.place[end >> 1]
        enters = self.entry[place] == end
        link = place if enters else place + 1
        other = self._before(link) if enters else self._behind(link)
        length = self._distance(end, other)
        for near in self.near[end]:
            saved = length - self._distance(end, near)
            if saved <= _GAIN_MM:
                break
            if near >> 1 == end >> 1:
                continue
            at = self.place[near >> 1]
            same = (self.entry[at] == near) == enters
            far = at if self.entry[at] == near else at + 1
            beyond = self._before(far) if self.entry[at] == near else self._behind(far)
            saved += self._distance(near, beyond)
            if same and saved - self._distance(other, beyond) > _GAIN_MM:
                low, high = min(link, far), max(link, far)
                if high - low <= _LONGEST_RUN:
                    self._lay(low, high, self.entries[low:high][::-1] ^ 1)
                    return end, other, near, beyond
            for size in range(3):
                first, last = (place, place + size) if enters else (place - size, place)
                if first < 0 or last >= self.count or first <= far <= last + 1:
                    break
                # the run from first to last leaves its links, and lies between near and beyond
                back = self.entry[last] ^ 1 if enters else self.entry[first]
                next_to = self._behind(last + 1) if enters else self._before(first)
                gain = (
                    saved
                    + self._distance(back, next_to)
                    - self._distance(other, next_to)
                    - self._distance(back, beyond)
                )
                if gain > _GAIN_MM and abs(far - place) <= _LONGEST_RUN:
                    self._carry(first, last + 1, far, same)
                    return end, other, near, beyond, back, next_to
        return ()

    def _carry(self, first: int, stop: int, link: int, turned: bool) -> None:
        """Lines from `first` to before `stop` go where `link` was, turned round if asked."""
        run = self.entries[first:stop]
        run = run[::-1] ^ 1 if turned else run
        if link > stop:
            self._lay(first, link, np.concatenate([self.entries[stop:link], run]))
        else:
            self._lay(link, stop, np.concatenate([run, self.entries[link:first]]))

    def _lay(self, low: int, high: int, entries: IntArray) -> None:
        self.entries[low:high] = entries
        self.places[self.entries[low:high] >> 1] = np.arange(low, high)
