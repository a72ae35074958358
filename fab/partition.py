"""Into which pieces is a flat sheet divided, so that each lies on the bed and overlaps nowhere?

A piece is a set of faces joined over their edges. Sets are cut from the sheet as runs of faces in
the order of a field: a coordinate of the plane, or the distance through the sheet from its far end.
Runs are as long as they may be, so that few are needed, and then made even.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
import shapely
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components, dijkstra

from fab.crease import CreasePattern
from fab.development import overlapping_faces
from fab.polygons import ring_areas
from solver.errors import InvalidValue
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["Sheet", "extent", "partition", "upright"]

# Rounding must not refuse a piece that is exactly as large as the bed.
_SLACK_REL = 1e-9
# Directions tried for a box besides those of the hull's sides, which are the best for area.
_TURNS = np.arange(180) * (np.pi / 180)
_MOST_SIDES = 400
# Runs may be larger than even by these shares, where that saves a piece.
_UNEVEN = (0.0, 0.03, 0.1, 0.25)
# Neighbours are cut anew where the smaller has less than this share of the larger's area, which
# must lose some of its own by it.
_EVEN_ENOUGH = 0.8
_GAIN = 0.95
_ROUNDS = 4


@dataclass(frozen=True)
class Sheet:
    """A pattern, and what its pieces must keep.

    Attributes
    ----------
    pattern : the whole pattern.
    joined : which edges join their two faces, shape (ne,).
    reach : the outer corners of the widest tab at each edge, on the second face's side and on the
        first face's: shape (ne, 2, 2, 2): edge, side that carries the tab, end, coordinate.
    glued : boundary edges that are to get a tab, shape (ne,).
    room_mm : what a piece has room in, width and height.
    """

    pattern: CreasePattern
    joined: BoolArray
    reach: FloatArray
    glued: BoolArray
    room_mm: tuple[float, float]


class _Faces:
    """Faces of a sheet with their neighbours, areas, and those that must not come together."""

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
        one, two = pattern.edges_faces[sheet.joined].T
        length = np.hypot(*(self.centres[one] - self.centres[two]).T)
        length = np.maximum(length, 1e-12 * max(sheet.room_mm))
        pairs = (np.concatenate([one, two]), np.concatenate([two, one]))
        shape = (self.count, self.count)
        self.graph = csr_array((np.concatenate([length, length]), pairs), shape=shape)
        self.overlaps = overlapping_faces(
            pattern.vertices_coords, pattern.faces_vertices, pattern.faces_offsets, pattern.edges
        )

    def components(self, faces: IntArray) -> list[IntArray]:
        """Parts of a set that are joined over edges; each part rises."""
        faces = np.sort(faces)
        count, part = connected_components(self.graph[faces][:, faces], directed=False)
        order = np.argsort(part, kind="stable")
        return np.split(faces[order], np.searchsorted(part[order], np.arange(1, count)))

    def overlap(self, faces: IntArray) -> bool:
        """Whether two faces of the set overlap."""
        if not len(self.overlaps):
            return False
        return bool(_mask(faces, self.count)[self.overlaps].all(axis=1).any())

    def valid(self, faces: IntArray) -> bool:
        """Whether a set that is joined fits the bed and does not overlap itself."""
        if self.overlap(faces):
            return False
        return self.small(faces) or upright(extent(self.sheet, faces), self.sheet.room_mm)[1]

    def small(self, faces: IntArray) -> bool:
        """Whether a set fits, tabs and all, however it is turned."""
        span = self.high[faces].max(axis=0) - self.low[faces].min(axis=0) + 2 * self.tab
        return bool(np.hypot(*span) <= min(self.sheet.room_mm))

    def valid_parts(self, faces: IntArray) -> bool:
        """Whether each part of the set is valid."""
        return all(self.valid(part) for part in self.components(faces))

    def pinched(self, faces: IntArray) -> IntArray:
        """Vertices in which the set's outline touches itself."""
        edges, side = _outline(self.sheet, faces)
        starts = self.sheet.pattern.edges_vertices[edges, side]
        vertices, times = np.unique(starts, return_counts=True)
        out: IntArray = vertices[times > 1]
        return out


def _mask(faces: IntArray, count: int) -> BoolArray:
    """Which of `count` faces are in the set; one more entry, for the face -1 that is in none."""
    mask = np.zeros(count + 1, bool)
    mask[faces] = True
    return mask


def _outline(sheet: Sheet, faces: IntArray) -> tuple[IntArray, IntArray]:
    """Edges with the set on one side alone, and on which, 0 for the first face's."""
    inside = _mask(faces, sheet.pattern.face_count)[sheet.pattern.edges_faces]
    edges = np.flatnonzero(inside[:, 0] != inside[:, 1])
    return edges, np.where(inside[edges, 0], 0, 1)


def extent(sheet: Sheet, faces: IntArray) -> FloatArray:
    """Points whose hull holds a set of faces with tabs on all its seams, shape (n, 2)."""
    edges, side = _outline(sheet, faces)
    seam = sheet.joined[edges] | sheet.glued[edges]
    ends = sheet.pattern.vertices_coords[sheet.pattern.edges_vertices[edges]]
    return np.concatenate([ends, sheet.reach[edges[seam], side[seam]]]).reshape(-1, 2)


def upright(coords: FloatArray, room_mm: tuple[float, float]) -> tuple[FloatArray, bool]:
    """The turn (2, 2) that lays points into the room in the box of least area, and if it fits.

    Where no box fits, the turn to the box of least area is given.
    """
    hull = shapely.convex_hull(shapely.multipoints(coords))
    ring = shapely.get_coordinates(hull)
    side = np.diff(ring, axis=0)[:: 1 + len(ring) // _MOST_SIDES]
    turns = np.concatenate([np.arctan2(side[:, 1], side[:, 0]), _TURNS])
    turns = np.concatenate([turns, turns + np.pi / 2])
    c, s = np.cos(turns), np.sin(turns)
    width = np.ptp(ring @ np.stack([c, s]), axis=0)
    height = np.ptp(ring @ np.stack([-s, c]), axis=0)
    fits = (width <= room_mm[0] * (1 + _SLACK_REL)) & (height <= room_mm[1] * (1 + _SLACK_REL))
    area = np.where(fits | ~fits.any(), width * height, np.inf)
    # equal boxes must not be told apart by rounding
    best = np.flatnonzero(area <= area.min() * (1 + 1e-9))[0]
    return np.array([[c[best], s[best]], [-s[best], c[best]]]), bool(fits.any())


def partition(sheet: Sheet) -> list[IntArray]:
    """Sets of faces, each joined, free of overlaps and within the room; the faces of each rise.

    A set may have holes, but its outline nowhere touches itself in a vertex. As few sets as the
    search finds, then of areas as even as it finds; in the order of their first faces.

    Raises `InvalidValue` for a face that overlaps itself or that the bed has no room for.
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
    for part in faces.components(np.arange(faces.count)):
        if faces.valid(part):
            pieces.append(part)
            continue
        _require_room(faces, part)
        pieces += _divided(faces, part)
    pieces = _evened(faces, _unpinched(faces, pieces))
    return sorted(pieces, key=lambda piece: int(piece[0]))


def _require_room(faces: _Faces, part: IntArray) -> None:
    """Raise `InvalidValue` for the first face that cannot be a piece of its own."""
    width, height = faces.sheet.room_mm
    crossed = faces.overlaps[faces.overlaps[:, 0] == faces.overlaps[:, 1], 0]
    if len(crossed):
        raise InvalidValue(
            f"outline of face {crossed[0]}",
            "crossing itself",
            "be a plain polygon",
            "Split the face where its sides cross.",
        )
    span = faces.high[part] - faces.low[part] + 2 * faces.tab
    for face in part[np.hypot(*span.T) > min(width, height)].tolist():
        points = extent(faces.sheet, np.array([face]))
        turn, fits = upright(points, faces.sheet.room_mm)
        if not fits:
            box = np.ptp(points @ turn.T, axis=0)
            raise InvalidValue(
                f"size of face {face} with its tabs",
                f"{box[0]:.6g} x {box[1]:.6g} mm",
                f"fit {width:.6g} x {height:.6g} mm, the bed without its margins",
                "Make the sheet smaller, lower tab_mm or margin_mm, or use a larger bed.",
            )


def _divided(faces: _Faces, part: IntArray) -> list[IntArray]:
    """The best of several ways to cut a joined set into valid ones."""
    best: list[IntArray] = []
    rank: tuple[float, ...] = ()
    room = faces.sheet.room_mm[0] * faces.sheet.room_mm[1]
    for way in _ways(faces, part):
        sets = _merged(faces, way) if len(way) > np.ceil(faces.areas[part].sum() / room) else way
        areas = np.array([faces.areas[one].sum() for one in sets])
        new = (len(sets), float(areas.max() / areas.mean()))
        if not best or new < rank:
            best, rank = sets, new
    return best


def _ways(faces: _Faces, part: IntArray) -> Iterator[list[IntArray]]:
    """Columns across the sheet, each cut into rows; or runs away from the sheet's far end."""
    turn, _ = upright(extent(faces.sheet, part), faces.sheet.room_mm)
    for across in (0, 1):
        for limit in sorted(set(faces.sheet.room_mm), reverse=True):

            def narrow(
                run: IntArray, axis: FloatArray = turn[across], width: float = limit
            ) -> bool:
                return bool(np.ptp(extent(faces.sheet, run) @ axis) <= width * (1 + _SLACK_REL))

            columns = _runs(faces, part, faces.centres[part] @ turn[across], narrow, np.inf)
            yield [
                piece
                for run in columns
                for column in faces.components(run)
                for piece in _valid_runs(faces, column, faces.centres[column] @ turn[1 - across])
            ]
    yield _valid_runs(faces, part, _distances(faces, part))


def _valid_runs(faces: _Faces, part: IntArray, field: FloatArray) -> list[IntArray]:
    """Parts of the runs of a field, each valid."""
    if faces.valid(part):
        return [part]
    most = faces.sheet.room_mm[0] * faces.sheet.room_mm[1]
    runs = _runs(faces, part, field, faces.valid_parts, most)
    return [piece for run in runs for piece in faces.components(run)]


def _distances(faces: _Faces, part: IntArray) -> FloatArray:
    """Distance of each face, from centre to centre, from the face that lies farthest off."""
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
    """Few runs of faces in the order of a field, all of them fitting, of about equal areas."""
    span = float(np.ptp(field)) or 1.0
    order = np.argsort(np.round(field / span, 9), kind="stable")
    ordered, place = part[order], field[order]
    area = np.concatenate([[0.0], np.cumsum(faces.areas[ordered])])

    def greedy(most: float, near: int, most_runs: float) -> list[IntArray]:
        runs, begin = [], 0
        while begin < len(ordered):
            end = int(np.searchsorted(area, area[begin] + most * (1 + _SLACK_REL), "right")) - 1
            end = min(max(end, begin + 1), len(ordered))
            if not fits(ordered[begin:end]):
                low, high = begin + 1, end
                while high - low > 1:
                    middle = (low + high) // 2
                    low, high = (middle, high) if fits(ordered[begin:middle]) else (low, middle)
                end = low
            if near and end < len(ordered):  # end where the field leaps, between rows of faces
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


def _merged(faces: _Faces, pieces: list[IntArray]) -> list[IntArray]:
    """Neighbours joined, smallest first, as long as any two are valid together."""
    parts = dict(enumerate(pieces))
    owner = np.full(faces.count + 1, -1)
    for number, piece in parts.items():
        owner[piece] = number
    refused: set[tuple[int, int]] = set()
    fresh = len(parts)
    while True:
        beside = owner[faces.sheet.pattern.edges_faces[faces.sheet.joined]]
        beside = np.unique(np.sort(beside, axis=1), axis=0)
        size = {number: float(faces.areas[piece].sum()) for number, piece in parts.items()}
        pairs = [
            (one, two)
            for one, two in beside.tolist()
            if one >= 0 and one != two and (one, two) not in refused
        ]
        for one, two in sorted(pairs, key=lambda pair: (size[pair[0]] + size[pair[1]], pair)):
            both = np.sort(np.concatenate([parts[one], parts[two]]))
            if faces.valid(both):
                del parts[one], parts[two]
                parts[fresh] = both
                owner[both] = fresh
                fresh += 1
                break
            refused.add((one, two))
        else:
            return list(parts.values())


def _unpinched(faces: _Faces, pieces: list[IntArray]) -> list[IntArray]:
    """Pieces whose outlines touch themselves in no vertex.

    Of the faces around such a vertex the smallest group goes to a neighbour that can take it, or
    becomes a piece of its own.
    """
    queue, done = list(pieces), []
    while queue:
        piece = queue.pop()
        if len(piece) > 1 and not faces.valid(piece):  # a new seam's tabs may need more room
            queue += _divided(faces, piece)
            continue
        pinched = faces.pinched(piece)
        if not len(pinched):
            done.append(piece)
            continue
        around = piece[_have_vertex(faces, piece, int(pinched[0]))]
        fan = min(faces.components(around), key=lambda f: (float(faces.areas[f].sum()), int(f[0])))
        queue += faces.components(np.setdiff1d(piece, fan))
        for number, other in enumerate(done):
            both = np.sort(np.concatenate([other, fan]))
            joined = len(faces.components(both)) == 1
            if joined and faces.valid(both) and not len(faces.pinched(both)):
                done[number] = both
                break
        else:
            done.append(fan)
    return done


def _have_vertex(faces: _Faces, piece: IntArray, vertex: int) -> BoolArray:
    pattern = faces.sheet.pattern
    hit = np.logical_or.reduceat(pattern.faces_vertices == vertex, pattern.faces_offsets[:-1])
    out: BoolArray = hit[piece]
    return out


def _evened(faces: _Faces, pieces: list[IntArray]) -> list[IntArray]:
    """The same number of pieces, neighbours of unequal areas cut anew along another line."""
    pieces = list(pieces)
    owner = np.full(faces.count + 1, -1)
    ends = faces.sheet.pattern.edges_faces[faces.sheet.joined]
    for _ in range(_ROUNDS):
        for number, piece in enumerate(pieces):
            owner[piece] = number
        beside = np.unique(np.sort(owner[ends], axis=1), axis=0)
        area = np.array([faces.areas[piece].sum() for piece in pieces])
        beside = beside[beside[:, 0] != beside[:, 1]]
        unequal = np.argsort(-np.abs(np.diff(area[beside], axis=1)[:, 0]), kind="stable")
        changed: set[int] = set()
        for one, two in beside[unequal].tolist():
            if (
                changed & {one, two}
                or area[[one, two]].min() >= _EVEN_ENOUGH * area[[one, two]].max()
            ):
                continue
            halves = _halves(faces, pieces[one], pieces[two])
            if halves:
                pieces[one], pieces[two] = halves
                changed |= {one, two}
        if not changed:
            break
    return pieces


def _halves(faces: _Faces, one: IntArray, two: IntArray) -> list[IntArray]:
    """Two neighbours cut anew across the line between their centres; none if it does not help."""
    both = np.sort(np.concatenate([one, two]))
    weight = faces.areas[:, None]
    centre = [(faces.centres[s] * weight[s]).sum(axis=0) / weight[s].sum() for s in (one, two)]
    sizes = [float(weight[s].sum()) for s in (one, two)]
    order = both[np.argsort(faces.centres[both] @ (centre[1] - centre[0]), kind="stable")]
    area = np.cumsum(faces.areas[order])
    for share in (0.5, 0.25 + 0.5 * sizes[0] / sum(sizes)):
        end = min(int(np.argmin(np.abs(area - share * area[-1]))) + 1, len(order) - 1)
        parts = faces.components(order[:end])
        first = max(parts, key=lambda part: float(faces.areas[part].sum()))
        halves = [first, np.setdiff1d(both, first)]
        if (
            max(float(weight[s].sum()) for s in halves) < _GAIN * max(sizes)
            and len(faces.components(halves[1])) == 1
            and all(faces.valid(s) and not len(faces.pinched(s)) for s in halves)
        ):
            return halves
    return []
