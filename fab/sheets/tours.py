"""Tours: orders and directions in which a head passes many lines with little travel.

A tour starts at the line nearest to the head, goes on to the nearest that is left, and is then
improved by 2-opt and Or-opt moves.
"""

from __future__ import annotations

from collections import deque
from math import hypot

import numpy as np
from scipy.spatial import KDTree

from solver.vectors import FloatArray, IntArray

__all__ = ["GAIN_MM", "Tour", "lengths", "nearest_neighbours", "travel_mm"]

# A move must gain more than this, so that rounding cannot send the head in circles.
GAIN_MM = 1e-9
# Points looked at around each end of a line, itself among them.
_NEIGHBOURS = 10
# Longest run of lines that a move reverses or passes by, and looks at a line on average.
_LONGEST_RUN = 50_000
_LOOKS = 40


def lengths(segments: FloatArray) -> FloatArray:
    """Lengths of lines (n, 2, 2), shape (n,).

    >>> lengths(np.array([[[0.0, 0.0], [3.0, 4.0]]])).tolist()
    [5.0]
    """
    out: FloatArray = np.hypot(*(segments[:, 1] - segments[:, 0]).T)
    return out


def travel_mm(lines: FloatArray, head: FloatArray) -> float:
    """Distance from `head` to the first line, and from each line's end to the next line's start.

    lines : shape (n, 2, 2), in order; head : shape (2,).

    >>> travel_mm(np.array([[[3.0, 4.0], [9.0, 9.0]], [[9.0, 7.0], [0.0, 0.0]]]), np.zeros(2))
    7.0
    """
    before = np.concatenate([head[None], lines[:, 1]])[: len(lines)]
    return float(lengths(np.stack([before, lines[:, 0]], axis=1)).sum())


def nearest_neighbours(
    points: FloatArray, owner: IntArray, leave: IntArray, head: FloatArray
) -> IntArray:
    """The point at which each line is entered, in order, shape (n,).

    It is always the nearest one of a line not yet passed.

    Parameters
    ----------
    points : where lines can be entered, shape (m, 2); owner : the line of each, shape (m,), from
        0 to n - 1.
    leave : the point where a line that was entered at each point is left, shape (m,).
    head : where the tour starts, shape (2,).
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
        last = left[at]
        for point in near_of[last]:
            if not done[owned[point]]:
                at = point
                break
        else:
            if len(alive) > 8 and 2 * (count - len(entries)) * len(points) < len(alive) * count:
                alive = alive[~np.frombuffer(done, bool)[owner[alive]]]
                tree = KDTree(points[alive])
            at = _nearest_left(tree, points[last], alive, owned, done)


def _nearest_left(
    tree: KDTree, point: FloatArray, alive: IntArray, owned: list[int], done: bytearray
) -> int:
    """The nearest point in the tree whose line is not done; there is at least one."""
    k = 2 * _NEIGHBOURS
    while True:
        found = np.atleast_1d(tree.query(point, min(k, len(alive)))[1])
        for at in alive[found].tolist():
            if not done[owned[at]]:
                return int(at)
        k *= 4


class Tour:
    """Lines in the order and direction in which the head passes them, and moves that shorten it.

    Line i has the ends 2 i and 2 i + 1, and end ^ 1 is the other end of its line. The line at
    place j is entered at entry[j]; link j leads to it; the tour is open behind the last line:

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
            for moved in self.move(end):
                if moved < self.head and not waiting[moved]:
                    waiting[moved] = 1
                    queue.append(moved)
        return self.entries

    def _distance(self, first: int, second: int) -> float:
        if first == self.none or second == self.none:
            return 0.0
        return hypot(self.x[first] - self.x[second], self.y[first] - self.y[second])

    def _before(self, link: int) -> int:
        """The end from which a link leads."""
        return self.entry[link - 1] ^ 1 if link else self.head

    def _behind(self, link: int) -> int:
        """The end to which a link leads."""
        return self.entry[link] if link < self.count else self.none

    def move(self, end: int) -> tuple[int, ...]:
        """Make a move that joins `end` to a nearer end; the ends whose links it changed.

        There are none where no move is shorter.
        """
        place = self.place[end >> 1]
        enters = self.entry[place] == end
        link = place if enters else place + 1
        other = self._before(link) if enters else self._behind(link)
        length = self._distance(end, other)
        for near in self.near[end]:
            saved = length - self._distance(end, near)
            if saved <= GAIN_MM:
                break
            if near >> 1 == end >> 1:
                continue
            at = self.place[near >> 1]
            same = (self.entry[at] == near) == enters
            far = at if self.entry[at] == near else at + 1
            beyond = self._before(far) if self.entry[at] == near else self._behind(far)
            saved += self._distance(near, beyond)
            if same and saved - self._distance(other, beyond) > GAIN_MM:
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
                if gain > GAIN_MM and abs(far - place) <= _LONGEST_RUN:
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
