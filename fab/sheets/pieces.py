"""Pieces of a sheet that is too large for the bed or overlaps itself, each a pattern of its own.

pattern -> sets of faces -> seams -> tabs -> pieces with labels
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from fab.errors import Finding, Severity, counted, first_few
from fab.layout.assembly_order import assembly_order, piece_name
from fab.layout.face_sets import Sheet, extent, outer_corners, upright
from fab.layout.partition import partition
from fab.pattern.closing_edges import closing_edges
from fab.pattern.crease_pattern import CreasePattern, face_normals
from fab.progress import Steps, no_steps
from fab.settings import Settings
from fab.sheets.glue_tabs import Tabs, glue_tabs
from fab.sheets.labels import Label, number_text
from fab.sheets.piece_labels import READABLE_MM, SeamNumbers, piece_labels
from fab.sheets.seams import Seam, SeamSides, numbered_seams, places_of, seam_sides
from solver.errors import InvalidValue, require_positive
from solver.graphs import EdgeIndex
from solver.mesh import Edges, edges_of
from solver.vectors import FloatArray, IntArray, cross, unit

__all__ = ["Piece", "Pieces", "SheetSplit", "split"]


class SheetSplit(Settings):
    """How a sheet that is too large, or that overlaps itself, is cut into pieces."""

    margin_mm: float = Field(default=5.0, ge=0, le=1000, description="kept free around the bed")
    mitre_mm: float = Field(
        default=0.0, ge=0, le=1000, description="room for mitres of the cut, inside the margin"
    )
    tabs: bool = Field(default=True, description="whether seams get glue tabs")
    tab_mm: float = Field(
        default=8.0, ge=1, le=1000, description="greatest height of a tab; lower on short edges"
    )
    tab_angle_deg: float = Field(
        default=45.0, ge=10, le=90, description="greatest angle at the foot of a tab"
    )
    label_mm: float = Field(default=4.0, ge=1, le=1000, description="greatest height of letters")

    @property
    def border_mm(self) -> float:
        """Width of the strip around the bed in which no piece is drawn."""
        return self.margin_mm + self.mitre_mm

    @property
    def border_text(self) -> str:
        """What the border is made up of, for messages."""
        mitres = f", mitres of the cut {self.mitre_mm:g} mm" if self.mitre_mm else ""
        return f"margin {self.margin_mm:g} mm{mitres}"


@dataclass(frozen=True)
class Piece:
    """A part of the sheet with its tabs, its best box upright at the origin.

    Attributes
    ----------
    name : "A", "B", ... "Z", "AA", ...
    pattern : the piece as a pattern of its own. Its faces are faces of the whole pattern, rising,
        and after them the tabs; the crease of a tab is folded as its seam is.
    faces, edges : numbers in the whole pattern, -1 for tabs and their sides.
    labels : text to be engraved: the piece's name, then those of its seams. None crosses a crease.
    unwritten : the texts for which there is no room.
    """

    name: str
    pattern: CreasePattern
    faces: IntArray
    edges: IntArray
    labels: tuple[Label, ...]
    unwritten: tuple[str, ...]


@dataclass(frozen=True)
class Pieces:
    """All pieces, and the seams in the order in which they are glued.

    A piece's seams to those assembled before it come one after another.
    """

    pieces: tuple[Piece, ...]
    seams: tuple[Seam, ...]

    @property
    def labelled(self) -> bool:
        """Whether labels are of any use: those of one piece without seams are not."""
        return len(self.pieces) > 1 or len(self.seams) > 0


def split(
    pattern: CreasePattern,
    settings: SheetSplit,
    bed_mm: tuple[float, float],
    progress: Steps = no_steps,
) -> tuple[Pieces, list[Finding]]:
    """Pieces that fit the bed and overlap nowhere, with tabs and labels.

    A pattern that fits is one piece. Otherwise it is cut along its inner edges, those of assignment
    F too, into as few pieces as the search finds. Edges of the boundary that come together when
    folded (a ring cut open) are seams as well, where the pattern knows its folded form.

    bed_mm : width and height. progress : each face is set apart, then drawn, a step each.

    Raises `InvalidValue` for a bed smaller than a face with its tabs, or a face without area.
    """
    _require_bed(settings, bed_mm)
    if pattern.face_count == 0:
        raise InvalidValue("faces", 0, "be at least 1", "Give a pattern with faces.")
    closing, closing_angle = closing_edges(pattern)
    sheet = _sheet(pattern, settings, bed_mm, closing)
    steps = 2 * pattern.face_count
    sets, faces_piece = _assembled(
        sheet, partition(sheet, lambda done, _: progress(done, steps)), closing
    )
    sides = seam_sides(pattern, faces_piece, sheet.joined, closing, closing_angle)
    tabs = (
        glue_tabs(pattern, faces_piece, sides, settings.tab_mm, settings.tab_angle_deg)
        if settings.tabs
        else Tabs.none(len(sides))
    )
    division = _Division(sheet, sides, tabs, settings.label_mm)
    pieces: list[Piece] = []
    drawn = pattern.face_count
    for number, faces in enumerate(sets):
        pieces.append(division.piece(number, faces))
        drawn += len(faces)
        progress(drawn, steps)
    seams = numbered_seams(pattern, [piece.edges for piece in pieces], sides, tabs.side)
    made = Pieces(tuple(pieces), seams)
    return made, _findings(made, settings)


def _require_bed(settings: SheetSplit, bed_mm: tuple[float, float]) -> None:
    """Raise `InvalidValue` for a bed that its border covers."""
    border = settings.border_mm
    for name, length in zip(("bed width", "bed height"), bed_mm, strict=True):
        require_positive(name, length, "Give the size of the bed in mm.")
        if length <= 2 * border:
            bound = f"be greater than 2 x {border:g} mm, what is kept free ({settings.border_text})"
            raise InvalidValue(name, f"{length:g} mm", bound, "Lower margin_mm.")


def _sheet(
    pattern: CreasePattern, settings: SheetSplit, bed_mm: tuple[float, float], closing: IntArray
) -> Sheet:
    """The pattern, and what its pieces must keep to: the room on the bed, with their tabs."""
    border = settings.border_mm
    joined = (pattern.edges_faces[:, 1] >= 0) & (pattern.edges_assignment != "C")
    glued = np.zeros(len(joined), bool)
    glued[closing.ravel()] = True
    room = (bed_mm[0] - 2 * border, bed_mm[1] - 2 * border)
    room_text = (
        f"the bed of {bed_mm[0]:g} x {bed_mm[1]:g} mm less {border:g} mm on each side "
        f"({settings.border_text})"
    )
    return Sheet(pattern, joined, _reach(pattern, settings), glued, room, room_text)


def _reach(pattern: CreasePattern, settings: SheetSplit) -> FloatArray:
    """Outer corners of the widest tabs on both sides of all edges; the ends where there are none.

    The tab on the first side is that of the first face, across the edge from it.
    """
    ends = pattern.vertices_coords[pattern.edges_vertices]
    if not settings.tabs:
        return np.stack([ends, ends], axis=1)
    both = np.stack([ends, ends[:, ::-1]], axis=1).reshape(-1, 2, 2)
    steep = np.full((len(both), 2), np.pi / 2)
    high = np.full(len(both), settings.tab_mm)
    return outer_corners(both, high, steep).reshape(-1, 2, 2, 2)


def _assembled(
    sheet: Sheet, sets: Sequence[IntArray], closing: IntArray
) -> tuple[list[IntArray], IntArray]:
    """The sets of faces in the order of assembling, and the number of each face's set, (nf,)."""
    pattern = sheet.pattern
    faces_set = np.empty(pattern.face_count, np.int64)
    for number, faces in enumerate(sets):
        faces_set[faces] = number
    neighbours = [pattern.edges_faces[sheet.joined], pattern.edges_faces[closing, 0]]
    order, rank = assembly_order(faces_set[np.concatenate(neighbours)], len(sets))
    return [sets[number] for number in order.tolist()], rank[faces_set]


@dataclass(frozen=True)
class _Division:
    """A sheet, how it is divided, and how its pieces are joined again."""

    sheet: Sheet
    sides: SeamSides
    tabs: Tabs
    label_mm: float

    def piece(self, number: int, faces: IntArray) -> Piece:
        """The pattern of a set of faces and its tabs, laid upright, and what is engraved on it."""
        whole, sides = self.sheet.pattern, self.sides
        every = np.arange(len(sides))
        tabs = np.flatnonzero(
            (self.tabs.side >= 0) & (sides.pieces[every, self.tabs.side] == number)
        )
        foot = sides.vertices[tabs, self.tabs.side[tabs]]
        used, corners, offsets = _faces_and_tabs(whole, faces, foot)
        tops = self.tabs.tops[tabs]
        coords = np.concatenate([whole.vertices_coords[used], tops.reshape(-1, 2)])
        coords = self._laid_upright(coords, faces)
        edges = edges_of(corners, offsets)
        whole_edges = _edges_in_whole(whole, faces, used, edges, len(coords))
        tab_edges = places_of(sides.edges[tabs, self.tabs.side[tabs]], whole_edges)
        angle, letter = _folds(whole, whole_edges, edges, len(faces))
        angle[tab_edges] = sides.foldAngle[tabs]
        letter[tab_edges] = np.where(
            angle[tab_edges] > 0, "V", np.where(angle[tab_edges] < 0, "M", "F")
        )
        folded = whole.folded_coords
        if folded is not None:
            folded = np.concatenate([folded[used], self._folded_tops(folded, tabs)])
        pattern = CreasePattern(
            coords, edges.edges_vertices, edges.edges_faces, letter, angle, corners, offsets, folded
        )
        name = piece_name(number)
        texts, labels = self._labels(pattern, number, len(faces), whole_edges, tabs)
        return Piece(
            name,
            pattern,
            np.concatenate([faces, np.full(len(tabs), -1)]),
            whole_edges,
            tuple(label for label in labels if label is not None),
            tuple(
                text
                for text, label in zip(texts, labels[: len(texts)], strict=True)
                if label is None
            ),
        )

    def _laid_upright(self, coords: FloatArray, faces: IntArray) -> FloatArray:
        """Points of a piece turned so that they fit the bed, their box at the origin."""
        turn, fits = upright(coords, self.sheet.room_mm)
        if not fits:  # the turn that the partition found, with room for all tabs
            turn, _ = upright(extent(self.sheet, faces), self.sheet.room_mm)
        coords = coords @ turn.T
        out: FloatArray = coords - coords.min(axis=0)
        return out

    def _folded_tops(self, folded: FloatArray, tabs: IntArray) -> FloatArray:
        """Folded corners of tabs, each in the plane of the face it is glued to, shape (2 n, 3)."""
        whole, sides = self.sheet.pattern, self.sides
        side = self.tabs.side[tabs]
        ends = sides.vertices[tabs, side]
        flat_a, flat_b = whole.vertices_coords[ends].swapaxes(0, 1)
        a, b = folded[ends].swapaxes(0, 1)
        normals = face_normals(folded, whole.faces_vertices, whole.faces_offsets)
        normal = normals[sides.faces[tabs, 1 - side]]
        span = flat_b - flat_a
        u = span / np.hypot(*span.T)[:, None]
        arm = self.tabs.tops[tabs] - flat_a[:, None]
        along = (arm * u[:, None]).sum(axis=2)
        out = (arm * np.column_stack([u[:, 1], -u[:, 0]])[:, None]).sum(axis=2)
        x = unit(b - a)
        y = cross(x, normal)  # away from the piece, in the other face
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
    ) -> tuple[list[str], tuple[Label | None, ...]]:
        """Texts of a piece's name and of all its seams, and their labels; then those on its tabs.

        Each number is beside its edge; on a tab it is below the seam.
        """
        seam, side = np.nonzero(self.sides.pieces == number)
        edges = places_of(self.sides.edges[seam, side], whole_edges)
        tab_edges = places_of(self.sides.edges[tabs, self.tabs.side[tabs]], whole_edges)
        ends = pattern.vertices_coords[pattern.edges_vertices[edges]]
        tab_ends = pattern.vertices_coords[pattern.edges_vertices[tab_edges]][:, ::-1]
        seams = SeamNumbers(
            np.concatenate([seam, tabs]) + 1,
            np.concatenate([pattern.edges_faces[edges, 0], face_count + np.arange(len(tabs))]),
            np.concatenate([ends, tab_ends]),
        )
        name = piece_name(number)
        texts = [name, *(number_text(s + 1) for s in seam.tolist())]
        return texts, piece_labels(pattern, name, face_count, seams, self.label_mm)


def _faces_and_tabs(
    whole: CreasePattern, faces: IntArray, foot: IntArray
) -> tuple[IntArray, IntArray, IntArray]:
    """The vertices of some faces, rising, and the polygons of the faces and of their tabs.

    foot : ends of the edges that carry tabs, shape (n, 2). The outer corners of tab i get the
    numbers k + 2 i and k + 2 i + 1 after the k vertices.
    """
    sizes = np.diff(whole.faces_offsets)
    chosen = np.zeros(whole.face_count, bool)
    chosen[faces] = True
    used, corners = np.unique(whole.faces_vertices[np.repeat(chosen, sizes)], return_inverse=True)
    a, b = np.searchsorted(used, foot).reshape(-1, 2).T
    p = len(used) + 2 * np.arange(len(foot))
    corners = np.concatenate([corners, np.column_stack([b, a, p, p + 1]).ravel()])
    offsets = np.cumsum(np.concatenate([[0], sizes[faces], np.full(len(foot), 4)]))
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


def _findings(made: Pieces, settings: SheetSplit) -> list[Finding]:
    """What the user should know of pieces, tabs and labels."""
    findings = []
    pieces, seams = counted(len(made.pieces), "piece"), counted(len(made.seams), "seam edge")
    if len(made.pieces) > 1:
        text = (
            f"the sheet is cut into {pieces} with {seams}. Glue them in the order of their labels."
            if made.seams
            else f"the sheet comes apart into {pieces} without seams: there is nothing to glue."
        )
        findings.append(Finding("sheet-split", Severity.NOTE, text))
    bare = [seam.edges[0] for seam in made.seams if seam.tab is None]
    if bare and settings.tabs:
        text = (
            f"{len(bare)} of {seams} {'has' if len(bare) == 1 else 'have'} no room for a tab. Use "
            "tape, lower tab_mm, or enlarge the sheet."
        )
        findings.append(Finding("tab-no-room", Severity.WARNING, text, creases=first_few(bare)))
    missing = sum(len(piece.unwritten) for piece in made.pieces)
    if missing and made.labelled:
        left_out = (
            "1 label is left out: its face has"
            if missing == 1
            else f"{missing} labels are left out: their faces have"
        )
        text = (
            f"{left_out} no room for letters of {READABLE_MM:g} mm. Enlarge the sheet to have all "
            "labels engraved; the report lists the seams of all pieces."
        )
        findings.append(Finding("label-too-small", Severity.WARNING, text))
    return findings
