"""Patterns of pieces: a set of faces with its tabs, laid upright, and what is engraved on it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fab.layout.assembly_order import piece_name
from fab.layout.face_sets import SheetToDivide, extent
from fab.pattern.crease_pattern import CreasePattern
from fab.sheets.glue_tabs import Tabs
from fab.sheets.labels import Label, number_text
from fab.sheets.openings import Openings
from fab.sheets.piece_labels import EdgeTexts, piece_labels
from fab.sheets.rim_points import RimPoints
from fab.sheets.seams import SeamSides, places_of
from solver.graphs import EdgeIndex
from solver.mesh import Edges, edges_of
from solver.polygons import face_normals
from solver.vectors import FloatArray, IntArray, cross, unit

__all__ = ["Before", "Division", "Piece"]


@dataclass(frozen=True)
class Piece:
    """A part of the sheet with its tabs, its best box upright at the origin.

    Attributes
    ----------
    name : "A", "B", ... "Z", "AA", ...
    pattern : the piece as a pattern of its own. Its faces are faces of the whole pattern, rising,
        and after them the tabs; the crease of a tab is folded as its seam is. Edges that end within
        one of the faces come last.
    faces, edges : numbers in the whole pattern, -1 for tabs and their sides.
    openings : slots and stitching holes in its faces, clockwise, each of shape (m, 2).
    labels : text to be engraved: the piece's name, then those of its seams. None crosses a crease.
    unwritten : the texts for which there is no room.
    """

    name: str
    pattern: CreasePattern
    faces: IntArray
    edges: IntArray
    openings: tuple[FloatArray, ...]
    labels: tuple[Label, ...]
    unwritten: tuple[str, ...]


@dataclass(frozen=True)
class Before:
    """What other patterns have that are cut with one.

    Attributes
    ----------
    pieces, seams, points : how many are named already; points are those where rims meet.
    placed, dashes : how many pieces and dashes all copies of the others have.
    """

    pieces: int = 0
    seams: int = 0
    points: int = 0
    placed: int = 0
    dashes: int = 0


@dataclass(frozen=True)
class Division:
    """A sheet, and how its pieces are joined again.

    Attributes
    ----------
    sheet : the whole pattern, and the room that each piece must fit.
    sides : the seams between pieces, whose numbers rise in the order of assembling.
    tabs, openings : of the seams.
    label_mm : greatest height of numbers.
    points : where rims of the sheet meet, by edges of the whole pattern.
    before : what others have that are cut with it.
    """

    sheet: SheetToDivide
    sides: SeamSides
    tabs: Tabs
    openings: Openings
    label_mm: float
    points: RimPoints
    before: Before

    def piece(self, number: int, faces: IntArray) -> Piece:
        """The pattern of a set of faces and its tabs, laid upright, and what is engraved on it."""
        whole, sides = self.sheet.pattern, self.sides
        tabs = np.flatnonzero(sides.pieces[self.tabs.seam, self.tabs.side] == number)
        seam, side = self.tabs.seam[tabs], self.tabs.side[tabs]
        tops = self.tabs.tops[tabs]
        foot = sides.vertices[seam, side]
        loose = _ending_within(whole, faces)
        used, corners, offsets = _faces_and_tabs(whole, faces, foot, loose, tops.shape[1])
        coords = np.concatenate([whole.vertices_coords[used], tops.reshape(-1, 2)])
        rings = self.openings.of(faces)
        laid = self._laid_upright(np.concatenate([coords, *rings]), faces)
        coords, *openings = np.split(laid, np.cumsum([len(coords), *map(len, rings)])[:-1])
        edges = edges_of(corners, offsets)
        whole_edges = _edges_in_whole(whole, faces, used, edges, len(coords))
        tab_edges = places_of(sides.edges[seam, side], whole_edges)
        angle, letter = _folds(whole, whole_edges, edges, len(faces))
        angle[tab_edges] = self.tabs.foldAngle[tabs]
        letter[tab_edges] = np.where(
            angle[tab_edges] > 0, "V", np.where(angle[tab_edges] < 0, "M", "F")
        )
        folded = whole.folded_coords
        if folded is not None:
            folded = np.concatenate([folded[used], self._folded_tops(folded, tabs)])
        within = np.searchsorted(faces, whole.edges_faces[loose])
        pattern = CreasePattern(
            coords,
            np.concatenate(
                [edges.edges_vertices, np.searchsorted(used, whole.edges_vertices[loose])]
            ),
            np.concatenate([edges.edges_faces, within]),
            np.concatenate([letter, whole.edges_assignment[loose]]),
            np.concatenate([angle, whole.edges_foldAngle[loose]]),
            corners,
            offsets,
            folded,
        )
        whole_edges = np.concatenate([whole_edges, loose])
        name = piece_name(self.before.pieces + number)
        texts, labels = self._labels(pattern, number, len(faces), whole_edges, tabs, openings)
        return Piece(
            name,
            pattern,
            np.concatenate([faces, np.full(len(tabs), -1)]),
            whole_edges,
            tuple(openings),
            tuple(label for label in labels if label is not None),
            tuple(
                text
                for text, label in zip(texts, labels[: len(texts)], strict=True)
                if label is None
            ),
        )

    def _laid_upright(self, coords: FloatArray, faces: IntArray) -> FloatArray:
        """Points of a piece turned so that they fit the bed, their box at the origin.

        Where rotations are bounded it is left to nesting to turn it.
        """
        if self.sheet.rotations_deg is None:
            turn, fits = self.sheet.upright(coords)
            if not fits:  # the turn that the partition found, with room for all tabs
                turn, _ = self.sheet.upright(extent(self.sheet, faces))
            coords = coords @ turn.T
        out: FloatArray = coords - coords.min(axis=0)
        return out

    def _folded_tops(self, folded: FloatArray, tabs: IntArray) -> FloatArray:
        """Folded corners of tabs, each folded against the face that it is on, shape (k n, 3)."""
        whole, sides = self.sheet.pattern, self.sides
        seam, side = self.tabs.seam[tabs], self.tabs.side[tabs]
        ends = sides.vertices[seam, side]
        flat_a, flat_b = whole.vertices_coords[ends].swapaxes(0, 1)
        a, b = folded[ends].swapaxes(0, 1)
        normals = face_normals(folded, whole.faces_vertices, whole.faces_offsets)
        normal = normals[sides.faces[seam, side]]
        angle = np.radians(self.tabs.foldAngle[tabs])[:, None]
        span = flat_b - flat_a
        u = span / np.hypot(*span.T)[:, None]
        arm = self.tabs.tops[tabs] - flat_a[:, None]
        along = (arm * u[:, None]).sum(axis=2)
        out = (arm * np.column_stack([u[:, 1], -u[:, 0]])[:, None]).sum(axis=2)
        x = unit(b - a)
        y = np.cos(angle) * cross(x, normal) + np.sin(angle) * normal  # away from the face
        points = a[:, None] + along[..., None] * x[:, None] + out[..., None] * y[:, None]
        flat: FloatArray = points.reshape(-1, 3)
        return flat

    def _labels(
        self,
        pattern: CreasePattern,
        number: int,
        face_count: int,
        whole_edges: IntArray,
        tabs: IntArray,
        openings: Sequence[FloatArray],
    ) -> tuple[list[str], tuple[Label | None, ...]]:
        """Texts of a piece's name, seams and rim, and their labels; then those on its tabs.

        Each number is beside its edge; on a tab it is below the seam.
        """
        seam, side = np.nonzero(self.sides.pieces == number)
        edges = places_of(self.sides.edges[seam, side], whole_edges)
        tab_seam = self.tabs.seam[tabs]
        tab_edges = places_of(self.sides.edges[tab_seam, self.tabs.side[tabs]], whole_edges)
        points = self.points.chosen(np.isin(self.points.edges, whole_edges))
        rim = places_of(points.edges, whole_edges)

        def ends(own: IntArray) -> FloatArray:
            out: FloatArray = pattern.vertices_coords[pattern.edges_vertices[own]]
            return out

        def numbers(seams: IntArray) -> list[str]:
            return [number_text(self.before.seams + 1 + seam) for seam in seams.tolist()]

        name = piece_name(self.before.pieces + number)
        beside = [*numbers(seam), *points.texts]
        every = EdgeTexts(
            (*beside, *numbers(tab_seam)),
            np.concatenate(
                [
                    pattern.edges_faces[edges, 0],
                    pattern.edges_faces[rim, 0],
                    face_count + np.arange(len(tabs)),
                ]
            ),
            np.concatenate(
                [
                    ends(edges) + self._beyond_openings(seam, side, ends(edges)),
                    points.lines(ends(rim)),
                    ends(tab_edges)[:, ::-1],
                ]
            ),
        )
        return [name, *beside], piece_labels(
            pattern, name, face_count, every, self.label_mm, openings
        )

    def _beyond_openings(self, seam: IntArray, side: IntArray, ends: FloatArray) -> FloatArray:
        """By how much numbers beside edges are moved into their faces, past openings, (n, 1, 2)."""
        if not self.openings.rings:
            return np.zeros((len(seam), 1, 2))
        whole, sides = self.sheet.pattern.vertices_coords, self.sides
        reach = [
            self.openings.reach_mm(s, int(sides.faces[s, k]), whole[sides.vertices[s, k]])
            for s, k in zip(seam.tolist(), side.tolist(), strict=True)
        ]
        span = ends[:, 1] - ends[:, 0]
        left = np.column_stack([-span[:, 1], span[:, 0]]) / np.hypot(*span.T)[:, None]
        out: FloatArray = (np.array(reach)[:, None] * left)[:, None]
        return out


def _ending_within(whole: CreasePattern, faces: IntArray) -> IntArray:
    """Edges that end within one of some faces, which they have twice."""
    first, second = whole.edges_faces.T
    return np.flatnonzero((first == second) & np.isin(first, faces))


def _faces_and_tabs(
    whole: CreasePattern, faces: IntArray, foot: IntArray, loose: IntArray, tops: int
) -> tuple[IntArray, IntArray, IntArray]:
    """The vertices of some faces, rising, and the polygons of the faces and of their tabs.

    foot : ends of the edges that carry tabs, shape (n, 2). The outer corners of tab i, of which
    each has as many as `tops`, get the numbers from k + tops i on after the k vertices.
    loose : edges that end within these faces, whose vertices are among the k.
    """
    sizes = np.diff(whole.faces_offsets)
    chosen = np.zeros(whole.face_count, bool)
    chosen[faces] = True
    corners = whole.faces_vertices[np.repeat(chosen, sizes)]
    used = np.union1d(corners, whole.edges_vertices[loose])
    corners = np.searchsorted(used, corners)
    a, b = np.searchsorted(used, foot).reshape(-1, 2).T
    outer = len(used) + np.arange(tops * len(foot)).reshape(-1, tops)
    corners = np.concatenate([corners, np.column_stack([b, a, outer]).ravel()])
    offsets = np.cumsum(np.concatenate([[0], sizes[faces], np.full(len(foot), 2 + tops)]))
    return used, corners, offsets


def _edges_in_whole(
    whole: CreasePattern, faces: IntArray, used: IntArray, edges: Edges, vertex_count: int
) -> IntArray:
    """Numbers in the whole pattern of a piece's edges, -1 for the sides of tabs.

    used : number in the whole pattern of each of the piece's first vertices, of `vertex_count`.
    """
    chosen = np.zeros(whole.face_count + 1, bool)  # the last one for edges without a second face
    chosen[faces] = True
    near = np.flatnonzero(chosen[whole.edges_faces].any(axis=1))
    ends = np.searchsorted(used, whole.edges_vertices[near])
    found = EdgeIndex.of(ends, vertex_count).find(edges.edges_vertices)
    return np.where(found < 0, -1, near[found])


def _folds(
    whole: CreasePattern, whole_edges: IntArray, edges: Edges, face_count: int
) -> tuple[FloatArray, NDArray[np.str_]]:
    """Fold angles and assignments of a piece's edges, as in the whole pattern between its faces."""
    letter = np.where(edges.edges_faces[:, 1] < 0, "B", "F")
    angle = np.zeros(len(whole_edges))
    inner = (edges.edges_faces[:, 1] >= 0) & (edges.edges_faces[:, 1] < face_count)
    letter[inner] = whole.edges_assignment[whole_edges[inner]]
    angle[inner] = whole.edges_foldAngle[whole_edges[inner]]
    return angle, letter
