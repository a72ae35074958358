"""Partition of a flat sheet into pieces, each of which fits the bed and overlaps nowhere.

A piece is a set of faces joined over their edges. Sets are cut from the sheet as runs of faces in
the order of a field: a coordinate of the plane, or the distance through the sheet from its far end.
Runs are as long as they may be, so that few are needed, and then balanced.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from heapq import heapify, heappop, heappush

import numpy as np
from scipy.sparse.csgraph import dijkstra

from fab.layout.face_sets import SLACK_REL, FaceSets, SheetToDivide, extent
from fab.progress import Steps, no_steps
from solver.errors import InvalidState, InvalidValue
from solver.vectors import FloatArray, IntArray

__all__ = ["partition"]

# Runs may be larger than equal shares by these amounts, where that saves a piece.
_UNEVEN = (0.0, 0.03, 0.1, 0.25)
# Neighbours are cut anew where the smaller has less than the first share of the larger's area, if
# that leaves the larger with less than the second share of its own; in a few rounds.
_EVEN_ENOUGH = 0.8
_GAIN = 0.95
_ROUNDS = 4
# Number of faces tried as the first run.
_FIRST_RUN = 64


def partition(sheet: SheetToDivide, progress: Steps = no_steps) -> list[IntArray]:
    """Sets of faces, each connected, free of overlaps and within the room; the faces of each rise.

    A set may have holes, but its outline nowhere touches itself in a vertex. As few sets as the
    search finds, then of areas as equal as it finds; in the order of their first faces.

    progress : called with the number of faces divided so far, and of all.

    Raises `InvalidValue` for a face without area, one that overlaps itself, and one that does not
    fit the room.
    """
    faces = FaceSets(sheet)
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


def _require_room(faces: FaceSets, part: IntArray) -> None:
    """Raise `InvalidValue` for the first face that cannot be a piece of its own."""
    width, height = faces.sheet.room_mm
    reach, key = faces.sheet.reach_text
    crossed = faces.overlaps[faces.overlaps[:, 0] == faces.overlaps[:, 1], 0]
    if len(crossed):
        raise InvalidState(
            "faces",
            f"the outline of face {crossed[0]} crosses itself",
            "Split the face where its sides cross.",
        )
    span = faces.high[part] - faces.low[part] + 2 * faces.tab
    for face in part[np.hypot(*span.T) > min(width, height)].tolist():
        points = extent(faces.sheet, np.array([face]))
        turn, fits = faces.sheet.upright(points)
        if not fits:
            box = np.ptp(points @ turn.T, axis=0)
            raise InvalidValue(
                f"size of face {face} with its {reach}",
                f"{box[0]:.6g} x {box[1]:.6g} mm",
                f"fit {width:.6g} x {height:.6g} mm, {faces.sheet.room_text}",
                f"Make the sheet smaller, lower {key} or margin_mm, or use a larger bed.",
            )


def _divided(
    faces: FaceSets, part: IntArray, report: Callable[[float], None] = lambda _: None
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


def _divisions(faces: FaceSets, part: IntArray) -> list[Callable[[], list[IntArray]]]:
    """Divisions to try: columns across the sheet, each cut into rows; or runs from its far end."""
    turn, _ = faces.sheet.upright(extent(faces.sheet, part))

    def in_columns(axis: FloatArray, along: FloatArray, width: float) -> list[IntArray]:
        def narrow(run: IntArray) -> bool:
            return bool(np.ptp(extent(faces.sheet, run) @ axis) <= width * (1 + SLACK_REL))

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


def _valid_runs(faces: FaceSets, part: IntArray, field: FloatArray) -> list[IntArray]:
    """Connected parts of the runs of a field, each valid."""
    if faces.valid(part):
        return [part]
    most = faces.sheet.room_mm[0] * faces.sheet.room_mm[1]
    runs = _runs(faces, part, field, faces.valid_parts, most)
    return [piece for run in runs for piece in faces.components(run)]


def _distances(faces: FaceSets, part: IntArray) -> FloatArray:
    """Distance of each face, from centre to centre, from the face at the far end of the part."""
    graph = faces.graph[part][:, part]
    first = dijkstra(graph, directed=False, indices=0)
    out: FloatArray = dijkstra(graph, directed=False, indices=int(first.argmax()))
    return out


def _runs(
    faces: FaceSets,
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
            end = int(np.searchsorted(area, area[begin] + most * (1 + SLACK_REL), "right")) - 1
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


def _merged(faces: FaceSets, pieces: list[IntArray]) -> list[IntArray]:
    """Neighbours joined, smallest first, as long as any two are valid together."""
    parts = dict(enumerate(pieces))
    owner = _owners(faces, pieces)
    beside: dict[int, set[int]] = {number: set() for number in parts}
    for first, second in _beside(faces, owner).tolist():
        beside[first].add(second)
        beside[second].add(first)
    size = {number: float(faces.areas[piece].sum()) for number, piece in parts.items()}
    box = {n: (faces.low[p].min(axis=0), faces.high[p].max(axis=0)) for n, p in parts.items()}
    most = faces.sheet.room_mm[0] * faces.sheet.room_mm[1] * (1 + SLACK_REL)
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


def _owners(faces: FaceSets, pieces: list[IntArray]) -> IntArray:
    """The piece of each face, -1 where there is none, shape (nf + 1,): the last is for face -1."""
    owner = np.full(faces.count + 1, -1)
    for number, piece in enumerate(pieces):
        owner[piece] = number
    return owner


def _beside(faces: FaceSets, owner: IntArray) -> IntArray:
    """Pairs of different pieces that are joined over an edge, the smaller number first, (n, 2)."""
    pattern = faces.sheet.pattern
    pairs = np.sort(owner[pattern.edges_faces[faces.sheet.joined]], axis=1)
    pairs = pairs[(pairs[:, 0] >= 0) & (pairs[:, 0] != pairs[:, 1])]
    out: IntArray = np.unique(pairs, axis=0)
    return out


def _unpinched(faces: FaceSets, pieces: list[IntArray]) -> list[IntArray]:
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
            around = piece[faces.have_vertex(piece, int(pinched[0]))]
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


def _evened(faces: FaceSets, pieces: list[IntArray]) -> list[IntArray]:
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


def _halves(faces: FaceSets, first: IntArray, second: IntArray) -> list[IntArray]:
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
