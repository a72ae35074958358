"""Files of the sheets that a machine cuts a crease pattern from.

pattern -> pieces with tabs and labels -> perforation, relief, kerf -> placed on beds
-> front and back, if asked for -> order of the work, estimate
-> drawings of each sheet, result page, report
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import partial
from typing import Any

import numpy as np
import shapely

from fab.drawings.cut_paths import CutPaths, Layer, Operation, joined
from fab.drawings.drawing_files import SheetFormat, drawing_files
from fab.errors import Finding, Severity, counted
from fab.jobs.file_names import SHEETS
from fab.layout.nesting import Placements, nest
from fab.outputs import Made, with_report
from fab.pattern.crease_pattern import CreasePattern
from fab.progress import Progress, silent
from fab.sheets.crease_cuts import require_dashes
from fab.sheets.crease_findings import crease_findings
from fab.sheets.cutting_order import tour
from fab.sheets.feature_size import narrow_faces
from fab.sheets.labels import engraved
from fab.sheets.perforation import cut_piece
from fab.sheets.piece_patterns import Piece
from fab.sheets.pieces import Pieces, split
from fab.sheets.registration import how_to_turn, two_sided
from fab.sheets.sheet_report import estimate_report, sheet_report, sides_report
from fab.sheets.sheet_request import SheetRequest
from fab.sheets.work_estimate import estimate
from solver.errors import InvalidState, InvalidValue

__all__ = ["FabricatedFormat", "fabricate", "sheets"]

# More pieces than this take hours to place, to put in order and to write.
_MOST_PLACED = 10_000


class FabricatedFormat(StrEnum):
    """The kinds of files of `fabricate`: those of drawings, and the result page."""

    DXF = "dxf"
    SVG = "svg"
    PDF = "pdf"
    LBRN2 = "lbrn2"
    PLT = "plt"
    GCODE = "gcode"
    HTML = "html"


def fabricate(
    pattern: CreasePattern,
    name: str,
    request: SheetRequest,
    *,
    findings: Sequence[Finding] = (),
    progress: Progress = silent,
) -> Made:
    """Files of all sheets that the copies of a pattern take, and a report.

    Parameters
    ----------
    pattern : in millimetres.
    name : what the files are named after.
    findings : of the pattern's reader, which go into the report as well.
    progress : called with (stage, steps done, steps in the stage).

    The report is the file `name`_sheets_report.json, which may be beside that of the job that
    made the pattern. It lists sheets (file names, pierces, lengths in mm, minutes, share of the bed
    in use; of two-sided ones each side, and how to turn them), pieces, and the seams in the order
    in which they are glued. A seam has its number, length and fold angle, both pieces, which of
    them (0 or 1) carries the tab, and of each the sheet and the middle of the edge on it: of the
    first copy, on the front.

    Raises `InvalidValue` where a face is larger than the bed, a style does not suit the kerf, or
    all copies of all pieces have more than 5 million dashes; `InvalidState` where G-code has an
    operation whose power the machine does not have.
    """
    progress("split", 0, 1)
    pieces, split_findings = split(
        pattern, request.split, request.machine.bed_mm, partial(progress, "split")
    )
    _require_placeable(request.copies * len(pieces.pieces), request.copies)
    layers, cut_findings = _cut_pieces(pieces, request, progress)
    placements = _placed(layers, request, progress)
    drawn = []
    cut = sheets(layers, placements, request.machine.bed_mm)
    for number, sheet in enumerate(cut):
        progress("order", number, len(cut))
        drawn.append(_drawn_sheet(sheet, f"{name}_{number + 1}", request))
    files = {file: data for sheet in drawn for file, data in sheet.files.items()}
    listed = [{"files": list(sheet.files), **sheet.work} for sheet in drawn]
    report = sheet_report(name, request, pieces, placements, listed)
    every = [
        *findings,
        *narrow_faces(pattern, request.machine.kerf_mm),
        *split_findings,
        *cut_findings,
        *_short_stock(len(cut), request),
        *_unset_powers(drawn, request),
    ]
    if request.page:
        drawings = {title: paths for sheet in drawn for title, paths in sheet.paths.items()}
        files[f"{name}_sheets.html"] = _page(pattern, name, request, report, every, files, drawings)
    progress("write", 1, 1)
    return with_report(files, SHEETS.report_name(name), report, every)


def _short_stock(needed: int, request: SheetRequest) -> list[Finding]:
    """A warning where more sheets are needed than are at hand."""
    there = request.stock_sheets
    if there is None or needed <= there:
        return []
    text = (
        f"{counted(needed, 'sheet')} are needed, cutter.sheets = {there} at hand: get "
        f"{needed - there} more, or ask for fewer copies or a smaller sheet."
    )
    return [Finding("sheets-short", Severity.WARNING, text)]


def _unset_powers(drawn: Sequence[_Drawn], request: SheetRequest) -> list[Finding]:
    """A note where a project for LightBurn has layers without power."""
    every = {layer.operation for sheet in drawn for p in sheet.paths.values() for layer in p.layers}
    settings = request.cut_settings
    unset = [key for key in settings if key in every and settings[key].power_percent is None]
    if SheetFormat.LBRN2 not in request.formats or not unset:
        return []
    text = (
        f"the machine has no power for {', '.join(unset)}: .lbrn2 leaves them at the power that "
        "LightBurn gives to new layers. Set it there, or give it in [powers] of a machine of your "
        "own"
    )
    return [Finding("power-unset", Severity.NOTE, text)]


def sheets(
    pieces: Sequence[Sequence[Layer]], placements: Placements, bed_mm: tuple[float, float]
) -> list[CutPaths]:
    """The cut paths of every sheet: the layers of its pieces, moved and joined by operation.

    `size_mm` is the bed, not the used area: the drawing's origin is the machine's, so that the
    margin is where it was asked for, and every sheet of a job has the same place on the bed.
    """
    return [
        CutPaths(
            joined(
                [
                    layer.moved(item.turn, item.shift)
                    for item in placements.items
                    if item.sheet == sheet
                    for layer in pieces[item.piece]
                ]
            ),
            bed_mm,
            on_bed=True,
        )
        for sheet in range(len(placements.used))
    ]


def _require_placeable(count: int, copies: int) -> None:
    """Raise `InvalidValue` for more pieces than can be placed."""
    if count > _MOST_PLACED:
        raise InvalidValue(
            "copies",
            f"{copies}, {count} pieces in all",
            f"make at most {_MOST_PLACED} pieces",
            "Make several runs.",
        )


def _cut_pieces(
    pieces: Pieces, request: SheetRequest, progress: Progress
) -> tuple[list[tuple[Layer, ...]], list[Finding]]:
    """The layers of each piece, and what is found while they are made."""
    style, kerf_mm = request.perforation, request.machine.kerf_mm
    alone = len(pieces.pieces) == 1
    layers, creases, findings = [], [], []
    dashes = 0
    for number, piece in enumerate(pieces.pieces):
        progress("perforate", number, len(pieces.pieces))
        cut = cut_piece(piece.pattern, style, kerf_mm)
        dashes += request.copies * int(cut.creases.cuts.sum())
        require_dashes(dashes)
        creases.append(replace(cut.creases, numbers=piece.edges[cut.creases.numbers]))
        findings += [_of_piece(piece, finding, alone=alone) for finding in cut.findings]
        layers.append((*cut.layers, engraved(piece.labels)) if pieces.labelled else cut.layers)
    return layers, [*findings, *crease_findings(creases, style.margin_mm, kerf_mm)]


def _of_piece(piece: Piece, finding: Finding, *, alone: bool) -> Finding:
    """A finding of a piece, which is named unless it is alone, with the pattern's edge numbers."""
    return replace(
        finding,
        text=finding.text if alone else f"piece {piece.name}: {finding.text}",
        creases=tuple(int(piece.edges[e]) for e in finding.creases if piece.edges[e] >= 0),
    )


def _placed(
    layers: Sequence[Sequence[Layer]], request: SheetRequest, progress: Progress
) -> Placements:
    """Where on which sheet each copy of each piece is."""
    outlines = [_outline(piece) for piece in layers]
    progress("nest", 0, request.copies * len(outlines))
    return nest(
        outlines,
        request.machine.bed_mm,
        request.gap_mm,
        request.copies,
        request.margin_mm,
        partial(progress, "nest"),
        rotations_deg=request.material.rotations_deg,
    )


def _outline(layers: Sequence[Layer]) -> shapely.Polygon:
    """The outline of a piece as it is cut, with its holes, which have room for other pieces."""
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


@dataclass(frozen=True)
class _Drawn:
    """Files of a sheet, or of one side of it, and what the report says of the work on it.

    paths : what is drawn in them, by name.
    """

    files: dict[str, bytes]
    work: dict[str, Any]
    paths: dict[str, CutPaths]


def _drawn_sheet(sheet: CutPaths, name: str, request: SheetRequest) -> _Drawn:
    """A sheet from one side, or from both where they are registered."""
    registration, machine = request.registration, request.machine
    if registration is None:
        return _drawn(sheet, name, request)
    both = two_sided(sheet, registration, machine.margin_mm, machine.kerf_mm)
    sides = {
        side: _drawn(paths, f"{name}_{side}", request)
        for side, paths in zip(("front", "back"), both, strict=True)
    }
    files = {file: data for side in sides.values() for file, data in side.files.items()}
    listed = {name: {"files": list(side.files), **side.work} for name, side in sides.items()}
    turn = how_to_turn(name, registration, machine.bed_mm)
    paths = {title: drawing for side in sides.values() for title, drawing in side.paths.items()}
    return _Drawn(files, sides_report(listed, turn), paths)


def _drawn(paths: CutPaths, name: str, request: SheetRequest) -> _Drawn:
    """Files of a drawing, and figures of the work, in the order of the tour."""
    ordered = tour(paths)
    return _Drawn(
        drawing_files(ordered, name, request.formats, request.drawing_style),
        estimate_report(estimate(ordered, request.speeds)),
        {name: ordered},
    )


def _page(
    pattern: CreasePattern,
    name: str,
    request: SheetRequest,
    report: Mapping[str, Any],
    findings: Sequence[Finding],
    files: Mapping[str, bytes],
    drawings: Mapping[str, CutPaths],
) -> bytes:
    """The result page of the sheets."""
    from fab.viewing.page import ResultPage, page_bytes
    from fab.viewing.predicted_fold import predicted_scene

    scene = predicted_scene(pattern, name, findings=findings)
    colours = request.machine.colours
    page = ResultPage(
        name, "quadfold fabricate", scene, report, scene.findings, files, drawings, colours
    )
    return page_bytes(page)
