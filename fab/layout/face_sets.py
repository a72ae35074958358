"""Sets of faces of a flat sheet: parts, outlines, overlaps, and whether they fit a bed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely

from fab.geometry.rings import ring_areas
from fab.pattern.crease_pattern import CreasePattern
from fab.pattern.overlap import overlapping_faces
from solver.graphs import labels, weighted_graph
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = [
    "SLACK_REL",
    "FaceSets",
    "SheetToDivide",
    "extent",
    "outer_corners",
    "outline",
    "upright",
]

# Rounding must not refuse a piece that is exactly as large as the bed.
SLACK_REL = 1e-9
# Directions tried for a box besides those of the hull's sides, one of which has the least area.
_TURNS = np.arange(180) * (np.pi / 180)
# About this many sides of the hull are tried.
_MOST_SIDES = 400


@dataclass(frozen=True)
class SheetToDivide:
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
    rotations_deg : by which pieces may be turned to fit; None for any.
    """

    pattern: CreasePattern
    joined: BoolArray
    reach: FloatArray
    glued: BoolArray
    room_mm: tuple[float, float]
    room_text: str = "the room of a piece"
    reach_text: tuple[str, str] = ("tabs", "tab_mm")
    rotations_deg: Sequence[float] | None = None

    def upright(self, coords: FloatArray) -> tuple[FloatArray, bool]:
        """As the function of this name, with the room and the rotations of the sheet."""
        return upright(coords, self.room_mm, self.rotations_deg)

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


class FaceSets:
    """Faces of a sheet, with their areas, boxes and neighbours, and the pairs that overlap."""

    def __init__(self, sheet: SheetToDivide) -> None:
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
        pairs = np.column_stack([np.append(first, second), np.append(second, first)])
        self.graph = weighted_graph(np.append(length, length), pairs, self.count)
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
        if (high - low).max() > np.hypot(*room) * (1 + SLACK_REL):
            return False
        return self.sheet.upright(extent(self.sheet, faces))[1]

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
        edges, side = outline(self.sheet, faces)
        starts = self.sheet.pattern.edges_vertices[edges, side]
        vertices, times = np.unique(starts, return_counts=True)
        out: IntArray = vertices[times > 1]
        return out

    def have_vertex(self, faces: IntArray, vertex: int) -> BoolArray:
        """Which faces of a set have a vertex, shape (len(faces),)."""
        pattern = self.sheet.pattern
        corners, place = _Ragged(pattern.faces_vertices, pattern.faces_offsets).at(faces)
        out: BoolArray = np.bincount(place[corners == vertex], minlength=len(faces)) > 0
        return out


def _place(rising: IntArray, numbers: IntArray) -> IntArray:
    """The places of numbers in a rising array, -1 for those that are not in it."""
    if not len(rising):
        return np.full(len(numbers), -1)
    place = np.minimum(np.searchsorted(rising, numbers), len(rising) - 1)
    return np.where(rising[place] == numbers, place, -1)


def outline(sheet: SheetToDivide, faces: IntArray) -> tuple[IntArray, IntArray]:
    """Edges with the set on one side only, and the side: 0 for that of the first face."""
    faces = np.sort(faces)
    sides = sheet.sides.at(faces)[0]
    outer = sides[_place(faces, sheet.pattern.edges_faces.ravel()[sides ^ 1]) < 0]
    return outer // 2, outer % 2


def extent(sheet: SheetToDivide, faces: IntArray) -> FloatArray:
    """Points whose hull contains a set of faces with tabs on all its seams, mm, shape (n, 2)."""
    edges, side = outline(sheet, faces)
    seam = sheet.joined[edges] | sheet.glued[edges]
    ends = sheet.pattern.vertices_coords[sheet.pattern.edges_vertices[edges]]
    return np.concatenate([ends, sheet.reach[edges[seam], side[seam]]]).reshape(-1, 2)


def upright(
    coords: FloatArray,
    room_mm: tuple[float, float],
    rotations_deg: Sequence[float] | None = None,
) -> tuple[FloatArray, bool]:
    """The rotation (2, 2) to the smallest bounding box that fits a room, and whether any fits.

    Where none fits, the rotation to the smallest bounding box of all. Smallest in area.

    coords : shape (n, 2), mm. room_mm : width and height. rotations_deg : the rotations that may
    be taken, counterclockwise; None for any.

    >>> bar = np.array([[0.0, 0.0], [0.0, 30.0], [10.0, 30.0], [10.0, 0.0]])
    >>> turn, fits = upright(bar, (40.0, 20.0))
    >>> fits, np.ptp(bar @ turn.T, axis=0).round(9).tolist()
    (True, [30.0, 10.0])
    """
    hull = shapely.convex_hull(shapely.linestrings(coords))
    ring = shapely.get_coordinates(hull)
    if rotations_deg is None:
        side = np.diff(ring, axis=0)[:: 1 + len(ring) // _MOST_SIDES]
        turns = np.concatenate([np.arctan2(side[:, 1], side[:, 0]), _TURNS])
    else:
        turns = -np.radians(np.asarray(rotations_deg, float))
    c, s = np.cos(turns), np.sin(turns)
    width, height = (np.ptp(ring @ np.stack(axis), axis=0) for axis in ((c, s), (-s, c)))
    if rotations_deg is None:  # a quarter turn further width is height
        c, s = np.concatenate([c, -s]), np.concatenate([s, c])
        width, height = np.concatenate([width, height]), np.concatenate([height, width])
    fits = (width <= room_mm[0] * (1 + SLACK_REL)) & (height <= room_mm[1] * (1 + SLACK_REL))
    area = np.where(fits | ~fits.any(), width * height, np.inf)
    # rounding must not decide between equal boxes
    best = np.flatnonzero(area <= area.min() * (1 + 1e-9))[0]
    return np.array([[c[best], s[best]], [-s[best], c[best]]]), bool(fits.any())


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
