"""Pieces of crease patterns as they are cut: tabs and labels, perforated creases, kerf."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import shapely

from fab.drawings.beam import Beam
from fab.drawings.closed_slots import closed_slots
from fab.drawings.cut_paths import Layer, Operation, joined
from fab.errors import Finding
from fab.pattern.crease_pattern import CreasePattern
from fab.pattern.meeting_rims import MeetingRims, meeting_rims
from fab.progress import Progress, silent
from fab.sheets.crease_cuts import require_dashes
from fab.sheets.crease_findings import crease_findings
from fab.sheets.feature_size import narrow_faces
from fab.sheets.labels import engraved
from fab.sheets.perforation import CutPiece, cut_piece, opening_cuts
from fab.sheets.piece_patterns import Before, Piece
from fab.sheets.pieces import Pieces, split
from fab.sheets.sheet_request import SheetRequest
from solver.errors import InvalidState, InvalidValue, require_count

__all__ = [
    "CutPattern",
    "PatternCopies",
    "cut_layers_of",
    "cut_pattern",
    "finding_of_piece",
    "outline",
]


# More pieces than this take hours to place, to put in order and to write.
_MOST_PLACED = 10_000


@dataclass(frozen=True)
class PatternCopies:
    """A crease pattern, what it is called, and how many of it each copy of the request has.

    findings : of the pattern's reader. Raises `InvalidValue` for copies that are no such number.
    """

    name: str
    pattern: CreasePattern
    copies: int = 1
    findings: tuple[Finding, ...] = ()

    def __post_init__(self) -> None:
        require_count("copies", self.copies, 1, "Ask for one copy or more.")


@dataclass(frozen=True)
class CutPattern:
    """A pattern as it is cut.

    Attributes
    ----------
    pieces : its pieces and seams.
    layers : of each piece, where the piece is.
    labelled : whether labels are engraved.
    meeting : where rims of its sheets meet, if any do.
    after : what it has, and all before it.
    findings : of all that is done to it; but for a beam that is wider along an axis, of all before
        it is cut (`fab.sheets.turned_cuts`).
    """

    pieces: Pieces
    layers: tuple[tuple[Layer, ...], ...]
    labelled: bool
    meeting: MeetingRims | None
    after: Before
    findings: tuple[Finding, ...]


def cut_pattern(
    pattern: CreasePattern,
    request: SheetRequest,
    progress: Progress = silent,
    *,
    copies: int = 1,
    before: Before = Before(),  # noqa: B008 (it is frozen)
    alone: bool = True,
) -> CutPattern:
    """The pieces of a pattern, with the lines along which they are cut.

    copies : of the pattern in all. before : what others have that are cut with it, after which its
    pieces and seams are named. alone : whether there are no others.

    Raises as `fab.sheets.pieces.split` and `fab.sheets.perforation.cut_piece`, and `InvalidValue`
    for more pieces or dashes in all than can be placed and cut.
    """
    progress("split", 0, 1)
    meeting = meeting_rims(pattern)
    pieces, split_findings = split(
        pattern,
        request.split,
        request.machine.bed_mm,
        partial(progress, "split"),
        meeting=meeting,
        before=before,
    )
    style = request.perforation
    # room for the widest cut; a beam that is wider along an axis cuts anew when pieces are placed
    beam = Beam.of(request.machine.beam.widest_mm)
    placed = before.placed + copies * len(pieces.pieces)
    _require_placeable(placed, copies)
    only = alone and len(pieces.pieces) == 1
    labelled = pieces.labelled or not alone
    layers, creases, findings = [], [], []
    dashes = before.dashes
    for number, piece in enumerate(pieces.pieces):
        progress("perforate", number, len(pieces.pieces))
        cut, drawn = cut_layers_of(piece, request, beam, labelled=labelled)
        dashes += copies * int(cut.creases.cuts.sum())
        require_dashes(dashes)
        creases.append(replace(cut.creases, numbers=piece.edges[cut.creases.numbers]))
        findings += [finding_of_piece(piece, finding, alone=only) for finding in cut.findings]
        layers.append(drawn)
    every = [*narrow_faces(pattern, beam.x_mm), *split_findings]
    if request.machine.beam.is_round:
        every += [*findings, *crease_findings(creases, style.margin_mm, beam)]
    after = Before(
        before.pieces + len(pieces.pieces),
        before.seams + len(pieces.seams),
        before.points + (0 if meeting is None else len(meeting.vertices)),
        placed,
        dashes,
    )
    return CutPattern(pieces, tuple(layers), labelled, meeting, after, tuple(every))


def cut_layers_of(
    piece: Piece, request: SheetRequest, beam: Beam, *, labelled: bool
) -> tuple[CutPiece, tuple[Layer, ...]]:
    """A piece as it is cut, and all its layers, as closed slots where these are asked for.

    beam : as it is where the piece is. labelled : whether its labels are engraved.
    """
    cut = cut_piece(piece.pattern, request.perforation, beam)
    wishes, layers = request.wishes, cut.layers
    if piece.openings:
        layers = joined([*layers, opening_cuts(piece.openings, beam)])
    if wishes.closed_slots:
        layers = closed_slots(layers, wishes.slot_mm, beam)
    if labelled:
        layers = (*layers, engraved(piece.labels, mirrored=wishes.mirror))
    return cut, layers


def _require_placeable(count: int, copies: int) -> None:
    """Raise `InvalidValue` for more pieces than can be placed."""
    if count > _MOST_PLACED:
        raise InvalidValue(
            "copies",
            f"{copies}, {count} pieces in all",
            f"make at most {_MOST_PLACED} pieces",
            "Make several runs.",
        )


def finding_of_piece(piece: Piece, finding: Finding, *, alone: bool) -> Finding:
    """A finding of a piece, which is named unless it is alone, with the pattern's edge numbers."""
    return replace(
        finding,
        text=finding.text if alone else f"piece {piece.name}: {finding.text}",
        creases=tuple(int(piece.edges[e]) for e in finding.creases if piece.edges[e] >= 0),
    )


def outline(layers: Sequence[Layer]) -> shapely.Polygon:
    """The outline of a piece as it is cut, with its holes, which have room for other pieces.

    Raises `InvalidState` for a piece that is narrower than the kerf.
    """
    cut = (Operation.HOLE, Operation.CUT)
    rings = [ring for layer in layers if layer.operation in cut for ring in layer.outlines]
    if not rings:
        raise InvalidState("sheet", "the sheet is narrower than the kerf", "Enlarge it.")
    figures = np.array([shapely.Polygon(ring) for ring in rings])
    largest = int(np.argmax(shapely.area(figures)))
    around = figures[largest]
    holes = [ring for number, ring in enumerate(rings) if number != largest]
    whole = shapely.Polygon(rings[largest], holes) if holes else around
    return whole if whole.is_valid else around
