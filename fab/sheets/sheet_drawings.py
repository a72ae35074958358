"""Sheets of crease patterns: their pieces placed on beds, drawn in every format, and the report.

patterns -> pieces as they are cut -> placed on beds -> front and back, if asked for
-> order of the work, estimate -> drawings of each sheet, report
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from fab.drawings.cut_paths import CutPaths, Layer, joined
from fab.drawings.drawing_files import SheetFormat, drawing_files
from fab.errors import Finding, Severity, counted, did_you_mean
from fab.layout.nesting import Placements, nest
from fab.progress import Progress, silent
from fab.sheets.cut_pieces import CutPattern, PatternCopies, cut_pattern, outline
from fab.sheets.piece_patterns import Before, Piece
from fab.sheets.pieces import Pieces
from fab.sheets.registration import how_to_turn, two_sided
from fab.sheets.seams import Seam
from fab.sheets.shared_cuts import placed_side_to_side
from fab.sheets.sheet_finish import Finished, finish_findings, finished, followed
from fab.sheets.sheet_report import PatternRow, estimate_report, sheet_report, sides_report
from fab.sheets.sheet_request import SheetRequest
from fab.sheets.turned_cuts import cut_as_placed
from fab.sheets.work_estimate import estimate
from solver.errors import InvalidValue
from solver.vectors import FloatArray

__all__ = ["SheetDrawings", "sheet_drawings", "sheets"]


@dataclass(frozen=True)
class SheetDrawings:
    """All sheets of some patterns.

    Attributes
    ----------
    files : the drawings, by name.
    paths : what is drawn in them, by the name of the drawing.
    report : as in `fab.sheets.sheet_report`.
    cut : the patterns as they are cut, in their order.
    placements : where their pieces lie, numbered one pattern after another.
    findings : of all sheets, besides those of each pattern as it is cut.
    """

    files: Mapping[str, bytes]
    paths: Mapping[str, CutPaths]
    report: dict[str, Any]
    cut: tuple[CutPattern, ...]
    placements: Placements
    findings: tuple[Finding, ...]


def sheet_drawings(
    patterns: Sequence[PatternCopies],
    name: str,
    request: SheetRequest,
    progress: Progress = silent,
) -> SheetDrawings:
    """The sheets that the copies of one pattern take, or of several that lie on them together.

    name : of the files, before the number of the sheet.

    Raises as `fab.sheets.cut_pieces.cut_pattern` for each pattern, and `InvalidState` where G-code
    has an operation whose power the machine does not have.
    """
    cut: list[CutPattern] = []
    copies: list[int] = []
    for wanted in patterns:
        many = request.copies * wanted.copies
        made = cut_pattern(
            wanted.pattern,
            request,
            progress,
            copies=many,
            before=cut[-1].after if cut else Before(),
            alone=len(patterns) == 1,
        )
        cut.append(made)
        copies += [many] * len(made.layers)
    layers = [piece for made in cut for piece in made.layers]
    first = _first(patterns, cut, request)
    placements = _placed(cut, copies, first, request, progress)
    lying = placements
    turned: tuple[Finding, ...] = ()
    if not request.machine.beam.is_round:
        layers, lying, turned = cut_as_placed(cut, placements, request)
    drawn = []
    beds = [
        finished(sheet, name, request) for sheet in sheets(layers, lying, request.machine.bed_mm)
    ]
    for number, sheet in enumerate(beds):
        progress("order", number, len(beds))
        drawn.append(_drawn_sheet(sheet.paths, f"{name}_{number + 1}", request))
    listed = [
        {"files": list(one.files), **one.work, **_bridges(sheet, request)}
        for one, sheet in zip(drawn, beds, strict=True)
    ]
    rows = [
        PatternRow(
            wanted.name,
            request.copies * wanted.copies,
            len(made.pieces.pieces),
            len(made.pieces.seams),
        )
        for wanted, made in zip(patterns, cut, strict=True)
    ]
    report = sheet_report(name, request, _together(cut), placements, listed, rows)
    findings = (
        *turned,
        *finish_findings(beds, [ring for sheet in drawn for ring in sheet.bare], request),
        *_short_stock(len(beds), request),
        *_unset_powers(drawn, request),
    )
    return SheetDrawings(
        {file: data for sheet in drawn for file, data in sheet.files.items()},
        {title: paths for sheet in drawn for title, paths in sheet.paths.items()},
        report,
        tuple(cut),
        placements,
        findings,
    )


def _together(cut: Sequence[CutPattern]) -> Pieces:
    """The pieces of all patterns one after another, and their seams."""
    pieces: list[Piece] = []
    seams: list[Seam] = []
    for made in cut:
        first = len(pieces)
        pieces += made.pieces.pieces
        for seam in made.pieces.seams:
            one, other = seam.pieces
            seams.append(replace(seam, pieces=(first + one, first + other)))
    return Pieces(tuple(pieces), tuple(seams))


def _placed(
    cut: Sequence[CutPattern],
    copies: Sequence[int],
    first: Sequence[bool],
    request: SheetRequest,
    progress: Progress,
) -> Placements:
    """Where on which sheet each copy of each piece is."""
    outlines = [outline(piece) for made in cut for piece in made.layers]
    progress("nest", 0, sum(copies))
    if request.shared_cuts:
        patterns = [piece.pattern for made in cut for piece in made.pieces.pieces]
        told = partial(progress, "nest")
        return placed_side_to_side(patterns, outlines, copies, first, request, told)
    return nest(
        outlines,
        request.machine.bed_mm,
        request.gap_mm,
        copies,
        request.margin_mm,
        partial(progress, "nest"),
        rotations_deg=request.rotations_deg,
        first=first,
    )


def _first(
    patterns: Sequence[PatternCopies], cut: Sequence[CutPattern], request: SheetRequest
) -> list[bool]:
    """Whether each piece is to lie on the first sheets. Raises `InvalidValue` for unknown names."""
    names = [
        (piece.name, wanted.name)
        for wanted, made in zip(patterns, cut, strict=True)
        for piece in made.pieces.pieces
    ]
    known = {name for both in names for name in both}
    for name in request.priority:
        if name not in known:
            pieces = f"{names[0][0]} to {names[-1][0]}" if len(names) > 1 else names[0][0]
            raise InvalidValue(
                "cutter.priority",
                repr(name),
                f"name a piece, {pieces}, or a pattern, {', '.join(p.name for p in patterns)}",
                f"The report lists them.{did_you_mean(name, known)}",
            )
    return [not {*both}.isdisjoint(request.priority) for both in names]


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


@dataclass(frozen=True)
class _Drawn:
    """Files of a sheet, or of one side of it, and what the report says of the work on it.

    paths : what is drawn in them, by name. bare : closed cuts that have no lead-in.
    """

    files: dict[str, bytes]
    work: dict[str, Any]
    paths: dict[str, CutPaths]
    bare: tuple[FloatArray, ...]


def _drawn_sheet(sheet: CutPaths, name: str, request: SheetRequest) -> _Drawn:
    """A sheet from one side, or from both where they are registered."""
    registration, machine = request.registration, request.machine
    if registration is None:
        return _drawn(sheet, name, request)
    both = two_sided(sheet, registration, machine.margin_mm, machine.beam.widest_mm)
    sides = {
        side: _drawn(paths, f"{name}_{side}", request, turned_over=side == "back")
        for side, paths in zip(("front", "back"), both, strict=True)
    }
    files = {file: data for side in sides.values() for file, data in side.files.items()}
    listed = {name: {"files": list(side.files), **side.work} for name, side in sides.items()}
    turn = how_to_turn(name, registration, machine.bed_mm)
    paths = {title: drawing for side in sides.values() for title, drawing in side.paths.items()}
    bare = tuple(ring for side in sides.values() for ring in side.bare)
    return _Drawn(files, sides_report(listed, turn), paths, bare)


def _drawn(
    paths: CutPaths, name: str, request: SheetRequest, *, turned_over: bool = False
) -> _Drawn:
    """Files of a drawing, and figures of the work, in the order of the tour."""
    ordered, bare = followed(paths, request, turned_over=turned_over)
    return _Drawn(
        drawing_files(ordered, name, request.formats, request.drawing_style),
        estimate_report(estimate(ordered, request.speeds)),
        {name: ordered},
        bare,
    )


def _bridges(sheet: Finished, request: SheetRequest) -> dict[str, int]:
    """What the report says of the bridges on a sheet, where any are asked for."""
    return {"bridges": sum(sheet.bridges)} if request.wishes.bridges else {}


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
