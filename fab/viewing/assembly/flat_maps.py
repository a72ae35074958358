"""Flat maps: the crease pattern, or a few of its pieces, with letters, seams and their numbers.

Mountains, valleys and cuts are distinguished by the style of their lines, for prints in grey.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from fab.geometry.rings import by_size
from fab.viewing.assembly.map_clipping import rings_of, with_area, within_paper
from fab.viewing.assembly.map_styles import (
    DOT,
    DRAWN,
    OUTLINE_MM,
    crease_lines,
    seam_lines,
    tab_lines,
)
from fab.viewing.assembly.parts import Joint, Model
from fab.viewing.assembly.piece_colours import hex_colour, paler
from fab.viewing.assembly.steps import numbers_text
from fab.viewing.sketch import Area, Mark, Plan, Sketch, Words, plan_of, scale_text
from solver.vectors import FloatArray, IntArray

__all__ = ["FlatMaps"]

# Of more creases a map would be all lines.
MOST_LINES = 15_000
_PALE, _FACE_INK = 0.45, "#707070"
# Sizes of the font of numbers and of letters, mm, and of numbers over their distances.
_NUMBERS, _LETTERS, _SPACING, _LETTER = (1.5, 2.6), (2.0, 11.0), 0.62, 0.9
_SIMPLE_MM = 0.02
# Numbers of edges that are apart are so far from them, in sizes of their font.
_BESIDE = 0.62
# Around the seams of a step so much is shown, over their extent.
_AROUND = 0.2
# A step has maps of its own for up to this many pieces; sides of seams are far apart where each is
# a smaller share of both.
_MOST_APART, _FAR = 4, 0.4
# Maps may reach beyond the pattern, over its size, and be so much wider than what they are about.
_BEYOND, _WIDER = 0.01, 1.6
# Pieces lie over each other where this share of them does.
_LAID_OVER = 1e-3
# Up to this many creases have their angles written beside them, in this size.
_MOST_ANGLES, _ANGLE_MM = 60, 1.8
# Numbers nearer than this to each other, over their size, cannot be read.
_CROWDED = 0.7
# Height of a map: at least, and for each of its seams.
_HEIGHTS_MM = (22.0, 2.6)


@dataclass(frozen=True)
class _Own:
    """What a piece has on maps: its region, where its letters go, their room, its lines."""

    region: NDArray[np.object_]
    middle: FloatArray
    radius: float
    creases: dict[str, IntArray]


class FlatMaps:
    """Maps of a model; what they share is found once."""

    def __init__(self, model: Model) -> None:
        self.model = model
        pattern = model.pattern
        faces = np.empty(pattern.face_count, object)
        for own, corners in by_size(pattern.faces_vertices, pattern.faces_offsets):
            faces[own] = shapely.polygons(pattern.vertices_coords[corners])
        creases = self._creases()
        self._own = [
            _own(faces[piece.faces], creases[number]) for number, piece in enumerate(model.pieces)
        ]

    def _creases(self) -> list[dict[str, IntArray]]:
        """Edges within each piece by their letter."""
        pattern, faces_piece = self.model.pattern, self.model.faces_piece
        first, second = pattern.edges_faces.T
        within = np.flatnonzero(second >= 0)
        within = within[faces_piece[first[within]] == faces_piece[second[within]]]
        piece = faces_piece[first[within]]
        order = np.argsort(piece, kind="stable")
        ends = np.searchsorted(piece[order], np.arange(len(self.model.pieces) + 1))
        out = []
        for a, b in pairwise(ends.tolist()):
            edges = within[order[a:b]]
            letters = pattern.edges_assignment[edges]
            out.append({letter: edges[letters == letter] for letter in DRAWN})
        return out

    def whole(self, most_mm: tuple[float, float]) -> Sketch:
        """The whole pattern, all seams numbered, at a usual scale."""
        coords = self.model.pattern.vertices_coords
        tabs = [tab for piece in self.model.pieces for tab in piece.tabs]
        points = np.concatenate([coords, *tabs])
        plan = plan_of(points.min(axis=0), points.max(axis=0), most_mm, 2.0)
        every = range(len(self.model.pieces))
        numbers = [joint.label for joint in self.model.joints]
        marks = self._marks(plan, every, every, numbers)
        lines = sum(len(edges) for own in self._own for edges in own.creases.values())
        note = ""
        if self._crowded(plan, np.array([j.edges[0] for j in self.model.joints], np.int64)):
            marks = tuple(mark for mark in marks if not _is_number(mark))
            note = " Numbers of seams, which are too near each other here, are in the steps."
        regions = np.concatenate([own.region for own in self._own])
        if shapely.union_all(regions).area < (1 - _LAID_OVER) * shapely.area(regions).sum():
            note += " Pieces lie over each other here: the last ones are on top."
        if lines > MOST_LINES:
            note += f" {lines} creases are not drawn here; the drawings have them all."
        caption = f"Upper side, scale {scale_text(plan.scale)}.{note}"
        return Sketch(plan.size_mm, marks, caption)

    def numbered(
        self, edges: IntArray, faces: IntArray, most_mm: tuple[float, float]
    ) -> Sketch | None:
        """The whole pattern with the numbers of some edges and faces; None where they are crowded.

        Faces have theirs in grey, in their middles.
        """
        pattern = self.model.pattern
        coords = pattern.vertices_coords
        plan = plan_of(coords.min(axis=0), coords.max(axis=0), most_mm, 2.0)
        if self._crowded(plan, edges):
            return None
        every = range(len(self.model.pieces))
        marks = [*self._marks(plan, every, every, [], lettered=False)]
        sums = np.add.reduceat(coords[pattern.faces_vertices], pattern.faces_offsets[:-1])
        middles = plan.on_paper(sums / np.diff(pattern.faces_offsets)[:, None])
        at = plan.on_paper(coords[pattern.edges_vertices[edges]].mean(axis=1))
        size = _number_size(np.concatenate([at, middles[faces]]))
        for face in faces.tolist():
            x, y = middles[face].tolist()
            marks.append(Words(str(face), (x, y), 1.1 * size, colour=_FACE_INK))
        for edge, (x, y) in zip(edges.tolist(), at.tolist(), strict=True):
            marks.append(Words(str(edge), (x, y), size, bold=True, backing="#ffffff"))
        return Sketch(plan.size_mm, tuple(marks), f"Upper side, scale {scale_text(plan.scale)}.")

    def _crowded(self, plan: Plan, edges: IntArray) -> bool:
        """Whether most numbers would hide each other."""
        if len(edges) < 2:
            return False
        pattern = self.model.pattern
        at = pattern.vertices_coords[pattern.edges_vertices[edges]].mean(axis=1) * plan.scale
        near, _ = cKDTree(at).query(at, k=2)
        return bool(np.median(near[:, 1]) < _CROWDED * _NUMBERS[0])

    def around(
        self, pieces: Sequence[int], labels: Sequence[int], most_mm: tuple[float, float]
    ) -> tuple[Sketch, ...]:
        """Maps of the seams of a step with their numbers, and of what is near of some pieces.

        One for each piece that the last of the pieces is joined to, if they are few, and one for
        either side of seams that are far apart in the flat pattern.
        """
        joints = self._joints(labels)
        groups: dict[tuple[int, ...], list[Joint]] = {}
        for joint in joints:
            groups.setdefault(tuple(sorted(joint.pieces)), []).append(joint)
        several = list(groups.values()) if len(groups) <= _MOST_APART else [joints]
        views = [
            (group, edges) for group in several for edges in self._views([j.edges for j in group])
        ]
        least, each = _HEIGHTS_MM
        high = [min(least + each * len(group), most_mm[1]) for group, _ in views]
        return tuple(
            self._near(pieces, group, edges, (most_mm[0], tall))
            for (group, edges), tall in zip(views, high, strict=True)
        )

    def _views(self, sides: list[tuple[int, int]]) -> list[IntArray]:
        """All edges of seams, or those on either side where these are far from each other."""
        edges = np.array(sides)
        boxes = [self._box(edges[:, side]) for side in (0, 1)]
        low, high = self._box(edges.ravel())
        own = max(float((b - a).max()) for a, b in boxes)
        if own < _FAR * float((high - low).max()):
            return [edges[:, 0], edges[:, 1]]
        return [edges.ravel()]

    def _box(self, edges: IntArray) -> tuple[FloatArray, FloatArray]:
        pattern = self.model.pattern
        ends = pattern.vertices_coords[pattern.edges_vertices[edges]].reshape(-1, 2)
        return ends.min(axis=0), ends.max(axis=0)

    def _near(
        self,
        pieces: Sequence[int],
        joints: Sequence[Joint],
        edges: IntArray,
        most_mm: tuple[float, float],
    ) -> Sketch:
        """What is near some edges."""
        low, high = self._box(edges)
        around = _AROUND * float((high - low).max())
        coords = self.model.pattern.vertices_coords
        plan = _filling(low - around, high + around, coords, most_mm)
        labels = [joint.label for joint in joints]
        marks = self._marks(plan, pieces, pieces[-1:], labels, clipped=True)
        noun = self.model.seam.capitalize()
        caption = f"{noun if len(labels) == 1 else f'{noun}s'} {numbers_text(labels)}"
        return Sketch(plan.size_mm, within_paper(marks, plan.size_mm), f"{caption}, upper side.")

    def _joints(self, labels: Sequence[int]) -> list[Joint]:
        wanted = set(labels)
        return [joint for joint in self.model.joints if joint.label in wanted]

    def _marks(
        self,
        plan: Plan,
        pieces: Sequence[int],
        strong: Sequence[int],
        labels: Sequence[int],
        *,
        clipped: bool = False,
        lettered: bool = True,
    ) -> tuple[Mark, ...]:
        """Areas, creases, tabs, seams, letters and numbers, in this order."""
        model = self.model
        coords = model.pattern.vertices_coords
        marks: list[Mark] = []
        drawn = sum(len(edges) for k in pieces for edges in self._own[k].creases.values())
        for number in pieces:
            own, colour = self._own[number], model.colours[number]
            fill = colour if number in strong else paler(colour, _PALE)
            for rings in rings_of(own.region, _SIMPLE_MM / plan.scale):
                on_paper = tuple(plan.on_paper(ring) for ring in rings)
                marks.append(Area(on_paper, hex_colour(fill), "#000000", OUTLINE_MM))
        if drawn <= MOST_LINES:
            edges = {
                letter: np.concatenate([self._own[k].creases[letter] for k in pieces])
                for letter in DRAWN
            }
            marks += crease_lines(plan, coords, model.pattern.edges_vertices, edges)
        for number in pieces:
            tabs = [plan.on_paper(tab) for tab in model.pieces[number].tabs]
            if tabs:
                sides = [np.stack([tab, np.roll(tab, -1, axis=0)], axis=1) for tab in tabs]
                marks.append(tab_lines(np.concatenate(sides)))
        joints = self._joints(labels)
        seams = np.array([joint.edges for joint in joints], np.int64).ravel()
        lines = plan.on_paper(coords[model.pattern.edges_vertices[seams]])
        marks.append(seam_lines(lines))
        if drawn <= _MOST_ANGLES and not clipped and lettered:
            marks += self._angles(plan, pieces)
        if lettered:
            marks += self._letters(plan, pieces, clipped=clipped)
        marks += self._numbers(plan, joints)
        marks += self._points(plan, pieces)
        return tuple(marks)

    def _letters(self, plan: Plan, pieces: Sequence[int], *, clipped: bool) -> list[Words]:
        """The letters of pieces, where there are several, in what is seen of them."""
        if self.model.alone:
            return []
        width, height = plan.size_mm
        corners = (np.array([[0.0, 0.0], [width, height]]) - plan.shift) / plan.scale
        out = []
        for number in pieces:
            own, name = self._own[number], self.model.pieces[number].name
            middle, radius = own.middle, own.radius
            if clipped:
                seen = shapely.intersection(own.region, shapely.box(*corners.ravel()))
                parts = with_area(seen)
                if not len(parts):
                    continue
                middle, radius = _room(parts)
            size = _LETTER * radius * plan.scale / max(1.0, 0.7 * len(name))
            size = float(np.clip(size, _LETTERS[0], _LETTERS[1] / (2 if clipped else 1)))
            x, y = plan.on_paper(middle).tolist()
            backing = hex_colour(self.model.colours[number])
            out.append(Words(name, (x, y), size, bold=True, backing=backing))
        return out

    def _angles(self, plan: Plan, pieces: Sequence[int]) -> list[Words]:
        """The fold angle of each crease in its middle, unless all are the same."""
        pattern = self.model.pattern
        every = np.concatenate([self._own[k].creases[key] for k in pieces for key in "MV"])
        whole = np.round(np.abs(pattern.edges_foldAngle[every])).astype(int)
        if len(np.unique(whole)) < 2 or not whole.all():
            return []
        middles = pattern.vertices_coords[pattern.edges_vertices[every]].mean(axis=1)
        piece = self.model.faces_piece[pattern.edges_faces[every, 0]]
        return [
            Words(f"{angle}°", (x, y), _ANGLE_MM, backing=hex_colour(self.model.colours[k]))
            for angle, (x, y), k in zip(
                whole.tolist(), plan.on_paper(middles).tolist(), piece.tolist(), strict=True
            )
        ]

    def _numbers(self, plan: Plan, joints: Sequence[Joint]) -> list[Words]:
        """The number of each seam at its middle, or beside both its edges."""
        pattern = self.model.pattern
        beside = [(joint, edge) for joint in joints for edge in dict.fromkeys(joint.edges)]
        if not beside:
            return []
        edges = np.array([edge for _, edge in beside])
        ends = plan.on_paper(pattern.vertices_coords[pattern.edges_vertices[edges]])
        at = ends.mean(axis=1)
        size = _number_size(at)
        along = ends[:, 1] - ends[:, 0]
        along /= np.maximum(np.hypot(*along.T), 1e-12)[:, None]
        border = pattern.edges_faces[edges, 1] < 0  # its face is to the left
        at[border] += _BESIDE * size * np.column_stack([-along[:, 1], along[:, 0]])[border]
        return [
            Words(str(joint.label), (x, y), size, bold=True, backing="#ffffff")
            for (joint, _), (x, y) in zip(beside, at.tolist(), strict=True)
        ]

    def _points(self, plan: Plan, pieces: Sequence[int]) -> list[Mark]:
        """Dots where rims of sheets are glued, with their numbers."""
        if len(pieces) < len(self.model.pieces) or not self.model.points:
            return []
        vertices = np.array([point.vertices for point in self.model.points]).ravel()
        at = plan.on_paper(self.model.pattern.vertices_coords[vertices])
        size = _number_size(at)
        texts = [point.text for point in self.model.points for _ in range(2)]
        dots = at[:, None] + 0.3 * size * DOT
        marks: list[Mark] = [Area((dot,), "#000000") for dot in dots]
        marks += [
            Words(text, (x + 0.5 * size, y), size, across="start", backing="#ffffff")
            for text, (x, y) in zip(texts, at.tolist(), strict=True)
        ]
        return marks


def _is_number(mark: Mark) -> bool:
    return isinstance(mark, Words) and mark.text.isdigit()


def _number_size(at: FloatArray) -> float:
    """Size of numbers at these places of paper, so that most of them are apart."""
    if len(at) < 2:
        return _NUMBERS[1]
    near, _ = cKDTree(at).query(at, k=2)
    return float(np.clip(_SPACING * np.quantile(near[:, 1], 0.1), *_NUMBERS))


def _own(faces: NDArray[np.object_], creases: dict[str, IntArray]) -> _Own:
    try:
        whole = shapely.coverage_union_all(faces)
        if not whole.is_valid:
            raise shapely.GEOSException("faces that overlap")
    except shapely.GEOSException:
        whole = shapely.union_all(shapely.make_valid(faces))
    parts = with_area(whole)
    return _Own(parts, *_room(parts), creases)


def _room(parts: NDArray[np.object_]) -> tuple[FloatArray, float]:
    """Where in polygons letters have most room, and the radius of that."""
    largest = parts[int(np.argmax(shapely.area(parts)))]
    coarse = 0.05 * float(np.sqrt(largest.area))
    disk = shapely.maximum_inscribed_circle(largest, tolerance=coarse)
    return shapely.get_coordinates(disk)[0], float(shapely.length(disk))


def _filling(
    low: FloatArray, high: FloatArray, coords: FloatArray, most_mm: tuple[float, float]
) -> Plan:
    """A rectangle of a pattern, as large as fits on paper, with what is beside it there."""
    first, last = coords.min(axis=0), coords.max(axis=0)
    beyond = _BEYOND * float((last - first).max())
    first, last = first - beyond, last + beyond
    low, high = np.maximum(low, first), np.minimum(high, last)
    room = np.array(most_mm)
    scale = float((room / np.maximum(high - low, 1e-9)).min())
    span = np.minimum(room / scale, np.maximum(_WIDER * float((high - low).max()), high - low))
    span = np.minimum(span, last - first)
    corner = np.clip((low + high - span) / 2, first, last - span)
    width, height = (span * scale).tolist()
    return Plan(scale, -corner * scale, (width, height))
