"""Partition of a flat sheet into pieces, each of which fits the bed and overlaps nowhere.

A piece is a set of faces joined over their edges. Sets are cut from the sheet as runs of faces in
the order of a field: a coordinate of the plane, or the distance through the sheet from its far end.
Runs are as long as they may be, so that few are needed, and then balanced.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from heapq import heapify, heappop, heappush

import numpy as np
import shapely
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from fab.geometry.rings import ring_areas
from fab.pattern.crease_pattern import CreasePattern
from fab.pattern.overlap import overlapping_faces
from fab.progress import Steps, no_steps
from solver.errors import InvalidValue
from solver.graphs import labels
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["Sheet", "extent", "outer_corners", "partition", "upright"]

# Rounding must not refuse a piece that is exactly as large as the bed.
_SLACK_REL = 1e-9
# Directions tried for a box besides those of the hull's sides, one of which has the least area.
_TURNS = np.arange(180) * (np.pi / 180)
# About this many sides of the hull are tried.
_MOST_SIDES = 400
# Runs may be larger than equal shares by these amounts, where that saves a piece.
_UNEVEN = (0.0, 0.03, 0.1, 0.25)
# Neighbours are cut anew where the smaller has less than the first share of the larger's area, if
# that leaves the larger with less than the second share of its own; in a few rounds.
_EVEN_ENOUGH = 0.8
_GAIN = 0.95
_ROUNDS = 4
# Number of faces tried as the first run.
_FIRST_RUN = 64


@dataclass(frozen=True)
class Sheet:
    """A sheet to be divided, and the bounds of its pieces.

    Attributes
    ----------
    pattern : the whole pattern.
    joined : which edges join their two faces, shape (ne,).
    reach : the outer corners of the widest tab at each edge, on the second face's side and on the
        first face's: shape (ne, 2, 2, 2): edge, side that carries the tab, end, coordinate.
    glued : boundary edges that are to get a tab, shape (ne,).
    room_mm : width and height of the rectangle that a piece must fit with its tabs.
    room_text : what that rectangle is, for messages.
    reach_text : what `reach` is of, and the setting that bounds it, for messages.
    """

    pattern: CreasePattern
    joined: BoolArray
    reach: FloatArray
    glued: BoolArray
    room_mm: tuple[float, float]
    room_text: str = "the room of a piece"
    reach_text: tuple[str, str] = ("tabs", "tab_mm")

    @cached_property
    def sides(self) -> _Ragged:
        """The sides of each face: 2 * edge on the edge's first face, 2 * edge + 1 on its second."""
        face = self.pattern.edges_faces.ravel()
        side = np.flatnonzero(face >= 0)
        return _Ragged.of(face[side], side, self.pattern.face_count)


@dataclass(frozen=True)
class _Ragged:
    """A ragged array: row i is values[starts[i]:starts[i + 1]]."""

    values: IntArray
    starts: IntArray

    @classmethod
    def of(cls, rows: IntArray, values: IntArray, count: int) -> _Ragged:
        """An array of `count` rows; rows : that of each value. Values of a row keep their order."""
        order = np.argsort(rows, kind="stable")
        return cls(values[order], np.searchsorted(rows[order], np.arange(count + 1)))

    def at(self, rows: IntArray) -> tuple[IntArray, IntArray]:
        """The values of some rows one after another, and the place of each one's row in `rows`."""
        sizes = self.starts[rows + 1] - self.starts[rows]
        place = np.repeat(np.arange(len(rows)), sizes)
        before = np.cumsum(sizes) - sizes
        return self.values[(self.starts[rows] - before)[place] + np.arange(len(place))], place


class _Faces:
    """Faces of a sheet, with their areas, boxes and neighbours, and the pairs that overlap."""

    def __init__(self, sheet: Sheet) -> None:
        pattern = sheet.pattern
        self.sheet = sheet
        self.count = pattern.face_count
        corners = pattern.vertices_coords[pattern.faces_vertices]
        starts = pattern.faces_offsets[:-1]
        self.areas = ring_areas(corners, pattern.faces_offsets)
        self.low = np.minimum.reduceat(corners, starts)
        self.high = np.maximum.reduceat(corners, starts)
        ends = pattern.vertices_coords[pattern.edges_vertices]
        self.tab = float(np.hypot(*(sheet.reach - ends[:, None]).reshape(-1, 2).T).max())
        self.centres = np.add.reduceat(corners, starts) / np.diff(pattern.faces_offsets)[:, None]
        first, second = pattern.edges_faces[sheet.joined].T
        length = np.hypot(*(self.centres[first] - self.centres[second]).T)
        length = np.maximum(length, 1e-12 * max(sheet.room_mm))
        pairs = (np.concatenate([first, second]), np.concatenate([second, first]))
        shape = (self.count, self.count)
        self.graph = csr_array((np.concatenate([length, length]), pairs), shape=shape)
        self.neighbours = _Ragged(self.graph.indices, self.graph.indptr)
        self.overlaps = overlapping_faces(
            pattern.vertices_coords, pattern.faces_vertices, pattern.faces_offsets, pattern.edges
        )
        self.overlapping = _Ragged.of(self.overlaps[:, 0], self.overlaps[:, 1], self.count)

    def components(self, faces: IntArray) -> list[IntArray]:
        """Connected parts of a set of faces; the faces of each part rise."""
        return np.split(*self._parts(faces))

    def _parts(self, faces: IntArray) -> tuple[IntArray, IntArray]:
        """Connected parts of a set one after another, and where all but the first begin."""
        faces = np.sort(faces)
        beside, row = self.neighbours.at(faces)
        column = _place(faces, beside)
        pairs = np.column_stack([row, column])[column >= 0]
        part = labels(pairs, len(faces))
        order = np.argsort(part, kind="stable")
        return faces[order], np.searchsorted(part[order], np.arange(1, part.max(initial=0) + 1))

    def overlap(self, faces: IntArray) -> bool:
        """Whether two faces of the set overlap."""
        if not len(self.overlaps):
            return False
        faces = np.sort(faces)
        return bool((_place(faces, self.overlapping.at(faces)[0]) >= 0).any())

    def valid(self, faces: IntArray) -> bool:
        """Whether a connected set fits the bed and does not overlap itself."""
        return not self.overlap(faces) and self.fits(faces)

    def fits(self, faces: IntArray) -> bool:
        """Whether a set fits the bed, tabs and all."""
        low, high = self.low[faces].min(axis=0), self.high[faces].max(axis=0)
        if self.small(low, high):
            return True
        room = self.sheet.room_mm
        if (high - low).max() > np.hypot(*room) * (1 + _SLACK_REL):
            return False
        return upright(extent(self.sheet, faces), room)[1]

    def small(self, low: FloatArray, high: FloatArray) -> BoolArray:
        """Whether what lies in boxes, corners of shape (..., 2), fits with tabs in any rotation."""
        span = high - low + 2 * self.tab
        out: BoolArray = np.hypot(span[..., 0], span[..., 1]) <= min(self.sheet.room_mm)
        return out

    def valid_parts(self, faces: IntArray) -> bool:
        """Whether each part of the set is valid."""
        if self.valid(faces):  # then every part is valid too
            return True
        ordered, ends = self._parts(faces)
        starts = np.concatenate([[0], ends])
        small = self.small(
            np.minimum.reduceat(self.low[ordered], starts),
            np.maximum.reduceat(self.high[ordered], starts),
        )
        parts = np.split(ordered, ends)
        if len(self.overlaps) and any(map(self.overlap, parts)):
            return False
        return all(self.fits(parts[number]) for number in np.flatnonzero(~small).tolist())

    def pinched(self, faces: IntArray) -> IntArray:
        """Vertices in which the set's outline touches itself."""
        edges, side = _outline(self.sheet, faces)
        starts = self.sheet.pattern.edges_vertices[edges, side]
        vertices, times = np.unique(starts, return_counts=True)
        out: IntArray = vertices[times > 1]
        return out


def _place(rising: IntArray, numbers: IntArray) -> IntArray:
    """The places of numbers in a rising array, -1 for those that are not in it."""
    if not len(rising):
        return np.full(len(numbers), -1)
    place = np.minimum(np.searchsorted(rising, numbers), len(rising) - 1)
    return np.where(rising[place] == numbers, place, -1)


def _outline(sheet: Sheet, faces: IntArray) -> tuple[IntArray, IntArray]:
    """Edges with the set on one side only, and the side: 0 for that of the first face."""
    faces = np.sort(faces)
    sides = sheet.sides.at(faces)[0]
    outer = sides[_place(faces, sheet.pattern.edges_faces.ravel()[sides ^ 1]) < 0]
    return outer // 2, outer % 2


def extent(sheet: Sheet, faces: IntArray) -> FloatArray:
    """Points whose hull contains a set of faces with tabs on all its seams, mm, shape (n, 2)."""
    edges, side = _outline(sheet, faces)
    seam = sheet.joined[edges] | sheet.glued[edges]
    ends = sheet.pattern.vertices_coords[sheet.pattern.edges_vertices[edges]]
    return np.concatenate([ends, sheet.reach[edges[seam], side[seam]]]).reshape(-1, 2)


def upright(coords: FloatArray, room_mm: tuple[float, float]) -> tuple[FloatArray, bool]:
    """The rotation (2, 2) to the smallest bounding box that fits a room, and whether any fits.

    Where none fits, the rotation to the smallest bounding box of all. Smallest in area.

    coords : shape (n, 2), mm. room_mm : width and height.

    >>> bar = np.array([[0.0, 0.0], [0.0, 30.0], [10.0, 30.0], [10.0, 0.0]])
    >>> turn, fits = upright(bar, (40.0, 20.0))
    >>> fits, np.ptp(bar @ turn.T, axis=0).round(9).tolist()
    (True, [30.0, 10.0])
    """
    hull = shapely.convex_hull(shapely.linestrings(coords))
    ring = shapely.get_coordinates(hull)
    side = np.diff(ring, axis=0)[:: 1 + len(ring) // _MOST_SIDES]
    turns = np.concatenate([np.arctan2(side[:, 1], side[:, 0]), _TURNS])
    c, s = np.cos(turns), np.sin(turns)
    spans = [np.ptp(ring @ np.stack(axis), axis=0) for axis in ((c, s), (-s, c))]
    # a quarter turn further width is height
    c, s = np.concatenate([c, -s]), np.concatenate([s, c])
    width, height = np.concatenate(spans), np.concatenate(spans[::-1])
    fits = (width <= room_mm[0] * (1 + _SLACK_REL)) & (height <= room_mm[1] * (1 + _SLACK_REL))
    area = np.where(fits | ~fits.any(), width * height, np.inf)
    # rounding must not decide between equal boxes
    best = np.flatnonzero(area <= area.min() * (1 + 1e-9))[0]
    return np.array([[c[best], s[best]], [-s[best], c[best]]]), bool(fits.any())


def partition(sheet: Sheet, progress: Steps = no_steps) -> list[IntArray]:
    """Sets of faces, each connected, free of overlaps and within the room; the faces of each rise.

    A set may have holes, but its outline nowhere touches itself in a vertex. As few sets as the
    search finds, then of areas as equal as it finds; in the order of their first faces.

    progress : called with the number of faces divided so far, and of all.

    Raises `InvalidValue` for a face without area, one that overlaps itself, and one that does not
    fit the room.
    """
    faces = _Faces(sheet)
    if not (faces.areas > 0).all():
        face = int(np.argmin(faces.areas > 0))
        raise InvalidValue(
            f"area of face {face}",
            f"{faces.areas[face]:g} mm2",
            "be greater than 0, its corners counterclockwise",
            "Remove degenerate faces, and turn those seen from below around.",
        )
    pieces: list[IntArray] = []
    done = 0

    def report(part: IntArray, share: float) -> None:
        progress(done + int(share * len(part)), faces.count)

    for part in faces.components(np.arange(faces.count)):
        if faces.valid(part):
            pieces.append(part)
        else:
            _require_room(faces, part)
            pieces += _divided(faces, part, partial(report, part))
        report(part, 1.0)
        done += len(part)
    pieces = _evened(faces, _unpinched(faces, pieces))
    return sorted(pieces, key=lambda piece: int(piece[0]))


def _require_room(faces: _Faces, part: IntArray) -> None:
    """Raise `InvalidValue` for the first face that cannot be a piece of its own."""
    width, height = faces.sheet.room_mm
    reach, key = faces.sheet.reach_text
    crossed = faces.overlaps[faces.overlaps[:, 0] == faces.overlaps[:, 1], 0]
    if len(crossed):
        raise InvalidValue(
            f"outline of face {crossed[0]}",
            "crossing itself",
            "be a simple polygon",
            "Split the face where its sides cross.",
        )
    span = faces.high[part] - faces.low[part] + 2 * faces.tab
    for face in part[np.hypot(*span.T) > min(width, height)].tolist():
        points = extent(faces.sheet, np.array([face]))
        turn, fits = upright(points, faces.sheet.room_mm)
        if not fits:
            box = np.ptp(points @ turn.T, axis=0)
            raise InvalidValue(
                f"size of face {face} with its {reach}",
                f"{box[0]:.6g} x {box[1]:.6g} mm",
                f"fit {width:.6g} x {height:.6g} mm, {faces.sheet.room_text}",
                f"Make the sheet smaller, lower {key} or margin_mm, or use a larger bed.",
            )


def _divided(
    faces: _Faces, part: IntArray, report: Callable[[float], None] = lambda _: None
) -> list[IntArray]:
    """The best of several divisions of a connected set into valid ones.

    report : called with the share of the divisions that were tried.
    """
    best: list[IntArray] = []
    rank: tuple[float, ...] = ()
    room = faces.sheet.room_mm[0] * faces.sheet.room_mm[1]
    fewest = np.ceil(faces.areas[part].sum() / room)
    divisions = _divisions(faces, part)
    for number, divide in enumerate(divisions, 1):
        sets = divide()
        if len(sets) > fewest:
            sets = _merged(faces, sets)
        areas = np.array([faces.areas[piece].sum() for piece in sets])
        new = (len(sets), float(areas.max() / areas.mean()))
        if not best or new < rank:
            best, rank = sets, new
        report(number / len(divisions))
    return best


def _divisions(faces: _Faces, part: IntArray) -> list[Callable[[], list[IntArray]]]:
    """Divisions to try: columns across the sheet, each cut into rows; or runs from its far end."""
    turn, _ = upright(extent(faces.sheet, part), faces.sheet.room_mm)

    def in_columns(axis: FloatArray, along: FloatArray, width: float) -> list[IntArray]:
        def narrow(run: IntArray) -> bool:
            return bool(np.ptp(extent(faces.sheet, run) @ axis) <= width * (1 + _SLACK_REL))

        columns = _runs(faces, part, faces.centres[part] @ axis, narrow, np.inf)
        return [
            piece
            for run in columns
            for column in faces.components(run)
            for piece in _valid_runs(faces, column, faces.centres[column] @ along)
        ]

    widths = sorted(set(faces.sheet.room_mm), reverse=True)
    return [
        *(
            partial(in_columns, turn[axis], turn[1 - axis], width)
            for axis in (0, 1)
            for width in widths
        ),
        lambda: _valid_runs(faces, part, _distances(faces, part)),
    ]


def _valid_runs(faces: _Faces, part: IntArray, field: FloatArray) -> list[IntArray]:
    """Connected parts of the runs of a field, each valid."""
    if faces.valid(part):
        return [part]
    most = faces.sheet.room_mm[0] * faces.sheet.room_mm[1]
    runs = _runs(faces, part, field, faces.valid_parts, most)
    return [piece for run in runs for piece in faces.components(run)]


def _distances(faces: _Faces, part: IntArray) -> FloatArray:
    """Distance of each face, from centre to centre, from the face at the far end of the part."""
    graph = faces.graph[part][:, part]
    first = dijkstra(graph, directed=False, indices=0)
    out: FloatArray = dijkstra(graph, directed=False, indices=int(first.argmax()))
    return out


def _runs(
    faces: _Faces,
    part: IntArray,
    field: FloatArray,
    fits: Callable[[IntArray], bool],
    most_area: float,
) -> list[IntArray]:
    """Few runs of faces in the order of a field, all of which fit, of about equal areas."""
    span = float(np.ptp(field)) or 1.0
    order = np.argsort(np.round(field / span, 9), kind="stable")
    ordered, place = part[order], field[order]
    area = np.concatenate([[0.0], np.cumsum(faces.areas[ordered])])

    def greedy(most: float, near: int, most_runs: float) -> list[IntArray]:
        runs: list[IntArray] = []
        begin = 0
        while begin < len(ordered):
            end = int(np.searchsorted(area, area[begin] + most * (1 + _SLACK_REL), "right")) - 1
            end = min(max(end, begin + 1), len(ordered))
            guess = 2 * len(runs[-1]) if runs else _FIRST_RUN
            end = begin + _longest(ordered[begin:end], guess, fits)
            if near and end < len(ordered):  # end where the field jumps, between rows of faces
                first = max(begin + 1, end - (end - begin) // near)
                end = first + int(np.argmax(np.diff(place[first - 1 : end + 1])))
            runs.append(ordered[begin:end])
            begin = end
            if len(runs) > most_runs:
                break
        return runs

    fewest = greedy(most_area, 0, np.inf)
    for uneven in _UNEVEN:
        for near in (8, 0):
            most = min(most_area, area[-1] / len(fewest) * (1 + uneven))
            even = greedy(most, near, len(fewest))
            if len(even) <= len(fewest):
                return even
    return fewest


def _longest(run: IntArray, guess: int, fits: Callable[[IntArray], bool]) -> int:
    """How many of a run's first faces fit, at least one; the cost grows with that number."""
    low, high = 1, min(guess, len(run))
    while fits(run[:high]):
        if high == len(run):
            return high
        low, high = high, min(2 * high, len(run))
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if fits(run[:middle]) else (low, middle)
    return low


def _merged(faces: _Faces, pieces: list[IntArray]) -> list[IntArray]:
    """Neighbours joined, smallest first, as long as any two are valid together."""
    parts = dict(enumerate(pieces))
    owner = _owners(faces, pieces)
    beside: dict[int, set[int]] = {number: set() for number in parts}
    for first, second in _beside(faces, owner).tolist():
        beside[first].add(second)
        beside[second].add(first)
    size = {number: float(faces.areas[piece].sum()) for number, piece in parts.items()}
    box = {n: (faces.low[p].min(axis=0), faces.high[p].max(axis=0)) for n, p in parts.items()}
    most = faces.sheet.room_mm[0] * faces.sheet.room_mm[1] * (1 + _SLACK_REL)
    pairs = [(size[i] + size[k], i, k) for i in parts for k in beside[i] if i < k]
    heapify(pairs)
    fresh = len(parts)
    while pairs:
        total, i, k = heappop(pairs)
        if total > most:  # all others are larger still
            break
        if i not in parts or k not in parts:
            continue
        low, high = np.minimum(box[i][0], box[k][0]), np.maximum(box[i][1], box[k][1])
        both = np.concatenate([parts[i], parts[k]])
        if faces.overlap(both) or not (faces.small(low, high) or faces.fits(both)):
            continue
        del parts[i], parts[k]
        parts[fresh], size[fresh], box[fresh] = both, total, (low, high)
        beside[fresh] = (beside.pop(i) | beside.pop(k)) - {i, k}
        for other in beside[fresh]:
            beside[other] -= {i, k}
            beside[other].add(fresh)
            heappush(pairs, (total + size[other], other, fresh))
        fresh += 1
    return [np.sort(piece) for piece in parts.values()]


def _owners(faces: _Faces, pieces: list[IntArray]) -> IntArray:
    """The piece of each face, -1 where there is none, shape (nf + 1,): the last is for face -1."""
    owner = np.full(faces.count + 1, -1)
    for number, piece in enumerate(pieces):
        owner[piece] = number
    return owner


def _beside(faces: _Faces, owner: IntArray) -> IntArray:
    """Pairs of different pieces that are joined over an edge, the smaller number first, (n, 2)."""
    pattern = faces.sheet.pattern
    pairs = np.sort(owner[pattern.edges_faces[faces.sheet.joined]], axis=1)
    pairs = pairs[(pairs[:, 0] >= 0) & (pairs[:, 0] != pairs[:, 1])]
    out: IntArray = np.unique(pairs, axis=0)
    return out


def _unpinched(faces: _Faces, pieces: list[IntArray]) -> list[IntArray]:
    """Pieces whose outlines do not touch themselves in a vertex.

    Where one does, the smallest group of faces around that vertex goes to a neighbour that can take
    it, or becomes a piece of its own.
    """
    queue = list(pieces)
    done: list[IntArray] = []
    owner = np.full(faces.count, -1)  # numbers in `done`
    while queue:
        piece = queue.pop()
        if len(piece) > 1 and not faces.valid(piece):  # a new seam's tabs may need more room
            queue += _divided(faces, piece)
            continue
        pinched = faces.pinched(piece)
        number = len(done)
        if len(pinched):
            around = piece[_have_vertex(faces, piece, int(pinched[0]))]
            fans = faces.components(around)
            fan = min(fans, key=lambda f: (float(faces.areas[f].sum()), int(f[0])))
            queue += faces.components(np.setdiff1d(piece, fan))
            piece = fan
            near = np.unique(owner[faces.neighbours.at(fan)[0]])
            for other in near[near >= 0].tolist():
                both = np.sort(np.concatenate([done[other], fan]))
                if faces.valid(both) and not len(faces.pinched(both)):
                    number, piece = other, both
                    break
        done[number : number + 1] = [piece]
        owner[piece] = number
    return done


def _have_vertex(faces: _Faces, piece: IntArray, vertex: int) -> BoolArray:
    """Which faces of a piece have a vertex."""
    pattern = faces.sheet.pattern
    corners, place = _Ragged(pattern.faces_vertices, pattern.faces_offsets).at(piece)
    out: BoolArray = np.bincount(place[corners == vertex], minlength=len(piece)) > 0
    return out


def _evened(faces: _Faces, pieces: list[IntArray]) -> list[IntArray]:
    """As many pieces of more equal areas: neighbours that differ are cut anew."""
    pieces = list(pieces)
    for _ in range(_ROUNDS):
        beside = _beside(faces, _owners(faces, pieces))
        area = np.array([faces.areas[piece].sum() for piece in pieces])
        unequal = np.argsort(-np.abs(np.diff(area[beside], axis=1)[:, 0]), kind="stable")
        changed: set[int] = set()
        for first, second in beside[unequal].tolist():
            pair = [first, second]
            if changed & {*pair} or area[pair].min() >= _EVEN_ENOUGH * area[pair].max():
                continue
            halves = _halves(faces, pieces[first], pieces[second])
            if halves:
                pieces[first], pieces[second] = halves
                changed |= {*pair}
        if not changed:
            break
    return pieces


def _halves(faces: _Faces, first: IntArray, second: IntArray) -> list[IntArray]:
    """Two neighbours cut anew across the line between their centres; none if it does not help."""
    both = np.sort(np.concatenate([first, second]))
    weight = faces.areas[:, None]
    pair = (first, second)
    centre = [(faces.centres[s] * weight[s]).sum(axis=0) / weight[s].sum() for s in pair]
    sizes = [float(weight[s].sum()) for s in pair]
    order = both[np.argsort(faces.centres[both] @ (centre[1] - centre[0]), kind="stable")]
    area = np.cumsum(faces.areas[order])
    for share in (0.5, 0.25 + 0.5 * sizes[0] / sum(sizes)):
        end = min(int(np.argmin(np.abs(area - share * area[-1]))) + 1, len(order) - 1)
        parts = faces.components(order[:end])
        largest = max(parts, key=lambda part: float(faces.areas[part].sum()))
        halves = [largest, np.setdiff1d(both, largest)]
        if (
            max(float(weight[s].sum()) for s in halves) < _GAIN * max(sizes)
            and len(faces.components(halves[1])) == 1
            and all(faces.valid(s) and not len(faces.pinched(s)) for s in halves)
        ):
            return halves
    return []


def outer_corners(ends: FloatArray, height: FloatArray, mitre: FloatArray) -> FloatArray:
    """The outer corners of tabs to the right of edges, at their first and second ends, (n, 2, 2).

    ends : shape (n, 2, 2), of the edges. height : shape (n,). mitre : shape (n, 2), radians, angles
    of the tab at both ends.

    >>> edge = np.array([[[0.0, 0.0], [10.0, 0.0]]])
    >>> outer_corners(edge, np.array([2.0]), np.radians([[90.0, 45.0]])).round(9).tolist()
    [[[0.0, -2.0], [8.0, -2.0]]]
    """
    span = ends[:, 1] - ends[:, 0]
    u = span / np.hypot(span[:, 0], span[:, 1])[:, None]
    out = np.column_stack([u[:, 1], -u[:, 0]]) * height[:, None]
    inset = height[:, None] / np.tan(mitre)
    return np.stack(
        [ends[:, 0] + out + inset[:, :1] * u, ends[:, 1] + out - inset[:, 1:] * u], axis=1
    )
