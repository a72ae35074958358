"""Pieces of a sheet that is too large for the bed or overlaps itself, and their seams.

pattern -> sets of faces -> seams -> tabs -> pieces with labels
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from pydantic import Field

from fab.errors import Finding, Severity, counted, first_few
from fab.layout.assembly_order import assembly_order
from fab.layout.face_sets import SheetToDivide, outer_corners
from fab.layout.partition import partition
from fab.pattern.closing_edges import closing_edges, closing_edges_by_angles
from fab.pattern.crease_pattern import CreasePattern
from fab.pattern.meeting_rims import MeetingRims
from fab.progress import Steps, no_steps
from fab.settings import Settings
from fab.sheets.cut_wishes import TabKind
from fab.sheets.piece_labels import READABLE_MM
from fab.sheets.piece_patterns import Before, Division, Piece
from fab.sheets.rim_points import RimPoints, rim_points
from fab.sheets.seam_joints import JointStyle, seam_joints
from fab.sheets.seams import Seam, numbered_seams, seam_sides
from solver.errors import InvalidValue, require_positive
from solver.vectors import FloatArray, IntArray

__all__ = ["Pieces", "SheetSplit", "split"]


# What is done to pieces, and what there may be no room for at a seam, and the key that helps.
_JOIN: dict[TabKind, str] = {
    "one side": "Glue",
    "both sides": "Glue",
    "slots": "Join",
    "stitches": "Stitch",
    "none": "Tape",
}
_NO_ROOM: dict[TabKind, tuple[str, str]] = {
    "one side": ("a tab", "tab_mm"),
    "both sides": ("two tabs", "tab_mm"),
    "slots": ("a tongue and its slot", "tab_mm"),
    "stitches": ("two stitching holes", "stitch_mm"),
}


class SheetSplit(Settings):
    """How a sheet that is too large, or that overlaps itself, is cut into pieces."""

    margin_mm: float = Field(default=5.0, ge=0, le=1000, description="kept free around the bed")
    mitre_mm: float = Field(
        default=0.0, ge=0, le=1000, description="room for mitres of the cut, inside the margin"
    )
    tabs: TabKind = Field(default="one side", description="how seams are joined")
    tab_mm: float = Field(
        default=8.0, ge=1, le=1000, description="greatest height of a tab; lower on short edges"
    )
    tab_angle_deg: float = Field(
        default=45.0, ge=10, le=90, description="greatest angle at the foot of a tab"
    )
    thickness_mm: float = Field(default=0.3, gt=0, le=100, description="of the material, for slots")
    stitch_mm: float = Field(
        default=5.0, ge=0.5, le=100, description="from one stitching hole to the next"
    )
    stitch_hole_mm: float = Field(
        default=1.0, ge=0.1, le=20, description="diameter of stitching holes"
    )
    rotations_deg: tuple[float, ...] | None = Field(
        default=None, description="of pieces, as the grain allows; any where left out"
    )
    label_mm: float = Field(default=4.0, ge=1, le=1000, description="greatest height of letters")

    @property
    def has_tabs(self) -> bool:
        """Whether anything reaches out from the edges of seams."""
        return self.tabs not in ("stitches", "none")

    @property
    def joints(self) -> JointStyle:
        """How seams are joined."""
        return JointStyle(
            self.tabs,
            self.tab_mm,
            self.tab_angle_deg,
            self.thickness_mm,
            self.stitch_mm,
            self.stitch_hole_mm,
        )

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
    *,
    meeting: MeetingRims | None = None,
    before: Before = Before(),  # noqa: B008 (it is frozen)
) -> tuple[Pieces, list[Finding]]:
    """Pieces that fit the bed and overlap nowhere, with tabs and labels.

    A pattern that fits is one piece. Otherwise it is cut along its inner edges, those of assignment
    F too, into as few pieces as the search finds. Edges of the boundary that come together when
    folded (a ring cut open, the net of a box) are seams as well, by the folded form that the
    pattern knows, or that its fold angles give where they close.

    bed_mm : width and height. progress : each face is set apart, then drawn, a step each.
    meeting : where rims of the pattern meet; these points get numbers, "p1" and so on where
    there are seams too. before : what others have that are cut with it; names and numbers go on.

    Raises `InvalidValue` for a bed smaller than a face with its tabs, or a face without area.
    """
    _require_bed(settings, bed_mm)
    if pattern.face_count == 0:
        raise InvalidValue("faces", 0, "be at least 1", "Give a pattern with faces.")
    known = pattern.folded_coords is not None
    closing, closing_angle = (closing_edges if known else closing_edges_by_angles)(pattern)
    sheet = _sheet(pattern, settings, bed_mm, closing)
    steps = 2 * pattern.face_count
    sets, faces_piece = _assembled(
        sheet, partition(sheet, lambda done, _: progress(done, steps)), closing
    )
    sides = seam_sides(pattern, faces_piece, sheet.joined, closing, closing_angle)
    joints = seam_joints(pattern, faces_piece, sides, settings.joints)
    points = (
        RimPoints.none()
        if meeting is None
        else rim_points(
            meeting, "p" if len(sides) else "", pattern.edges_vertices[closing], before.points
        )
    )
    division = Division(
        sheet, sides, joints.tabs, joints.openings, settings.label_mm, points, before
    )
    pieces: list[Piece] = []
    drawn = pattern.face_count
    for number, faces in enumerate(sets):
        pieces.append(division.piece(number, faces))
        drawn += len(faces)
        progress(drawn, steps)
    seams = numbered_seams(
        pattern,
        [piece.edges for piece in pieces],
        sides,
        joints.tabs.sides_of(len(sides)),
        joints.stitches(len(sides)),
        before.seams,
    )
    made = Pieces(tuple(pieces), seams)
    return made, _findings(made, settings, np.flatnonzero(joints.bare(len(sides))))


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
) -> SheetToDivide:
    """The pattern, and what its pieces must keep to: the room on the bed, with their tabs."""
    border = settings.border_mm
    joined = pattern.edges_joining
    glued = np.zeros(len(joined), bool)
    glued[closing.ravel()] = True
    room = (bed_mm[0] - 2 * border, bed_mm[1] - 2 * border)
    room_text = (
        f"the bed of {bed_mm[0]:g} x {bed_mm[1]:g} mm less {border:g} mm on each side "
        f"({settings.border_text})"
    )
    reach, rotations_deg = _reach(pattern, settings), settings.rotations_deg
    return SheetToDivide(
        pattern, joined, reach, glued, room, room_text, rotations_deg=rotations_deg
    )


def _reach(pattern: CreasePattern, settings: SheetSplit) -> FloatArray:
    """Outer corners of the widest tabs on both sides of all edges; the ends where there are none.

    The tab on the first side is that of the first face, across the edge from it.
    """
    ends = pattern.vertices_coords[pattern.edges_vertices]
    if not settings.has_tabs:
        return np.stack([ends, ends], axis=1)
    both = np.stack([ends, ends[:, ::-1]], axis=1).reshape(-1, 2, 2)
    steep = np.full((len(both), 2), np.pi / 2)
    high = np.full(len(both), settings.tab_mm)
    return outer_corners(both, high, steep).reshape(-1, 2, 2, 2)


def _assembled(
    sheet: SheetToDivide, sets: Sequence[IntArray], closing: IntArray
) -> tuple[list[IntArray], IntArray]:
    """The sets of faces in the order of assembling, and the number of each face's set, (nf,)."""
    pattern = sheet.pattern
    faces_set = np.empty(pattern.face_count, np.int64)
    for number, faces in enumerate(sets):
        faces_set[faces] = number
    neighbours = [pattern.edges_faces[sheet.joined], pattern.edges_faces[closing, 0]]
    order, rank = assembly_order(faces_set[np.concatenate(neighbours)], len(sets))
    return [sets[number] for number in order.tolist()], rank[faces_set]


def _findings(made: Pieces, settings: SheetSplit, bare_seams: IntArray) -> list[Finding]:
    """What the user should know of pieces, tabs and labels.

    bare_seams : numbers of the seams that nothing joins.
    """
    findings = []
    pieces, seams = counted(len(made.pieces), "piece"), counted(len(made.seams), "seam edge")
    if len(made.pieces) > 1:
        text = (
            f"the sheet is cut into {pieces} with {seams}. {_JOIN[settings.tabs]} them in the "
            "order of their labels."
            if made.seams
            else f"the sheet comes apart into {pieces} that share no edge, and have no seams."
        )
        findings.append(Finding("sheet-split", Severity.NOTE, text))
    bare = [made.seams[number].edges[0] for number in bare_seams.tolist()]
    if bare and settings.tabs != "none":
        have, them = ("has", "it") if len(bare) == 1 else ("have", "them")
        what, key = _NO_ROOM[settings.tabs]
        text = (
            f"{len(bare)} of {seams} {have} no room for {what}. Join {them} with tape, lower "
            f"{key}, or enlarge the sheet."
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
