"""How does a crease pattern become sheets that a machine cuts?

pattern -> pieces with tabs and labels -> perforation, relief, kerf -> placed on beds
-> front and back, if asked for -> order of the work, estimate
-> DXF, SVG and PDF of each sheet, report
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import asdict, replace
from functools import partial
from typing import Any

import shapely

from fab.drawings.cut_paths import CutPaths, Layer, Operation, joined
from fab.drawings.drawing_files import SheetFormat, drawing_files
from fab.errors import Finding
from fab.layout.nesting import Placements, nest
from fab.outputs import Made, with_report
from fab.pattern.crease_pattern import CreasePattern, scaled
from fab.progress import Progress
from fab.sheets.cutting_order import estimate, tour
from fab.sheets.feature_size import narrow_faces
from fab.sheets.labels import engraved
from fab.sheets.materials import Machine, Material, Speeds, perforation_for
from fab.sheets.perforation import crease_findings, cut_piece
from fab.sheets.pieces import Piece, Pieces, SheetSplit, split
from fab.sheets.registration import Registration, how_to_turn, two_sided
from solver.errors import InvalidState, InvalidValue, require_count

__all__ = ["fabricate", "scaled", "sheet_names", "sheets"]

# Between two pieces on a sheet, in mm, and at least in kerfs.
_GAP_MM = 2.0
_GAP_KERFS = 4.0
# By so many kerfs the mitres of sharp corners may stand out from a piece.
_CORNER_KERFS = 5.0
# Lower tabs hold no glue.
_LEAST_TAB_MM = 1.0
# More pieces than this take hours to place, to put in order and to write.
_MOST_PLACED = 10_000


def fabricate(
    pattern: CreasePattern,
    name: str,
    material: Material,
    machine: Machine,
    *,
    copies: int = 1,
    registration: Registration | None = None,
    formats: Sequence[SheetFormat] = tuple(SheetFormat),
    findings: Sequence[Finding] = (),
    progress: Progress | None = None,
) -> Made:
    """Files of all sheets on which `copies` of a pattern lie, and a report.

    pattern : in millimetres; findings : of its reader, told again in the report.
    registration : where given, creases are scored on the side that they open, and each sheet has a
        front and a back (`fab.two_sided`); the stock is as large as the bed.
    progress : called with (stage, steps done, steps in the stage).

    The report is the file `name`_report.json, so that it may lie beside the report of the job that
    made the pattern. It lists sheets (file names, pierces, lengths in mm, minutes, share of the bed
    in use; of two-sided ones each side, and how to turn them), pieces, and the seams in the order
    in which they are glued. A seam has its number, length and fold angle, both pieces, which of
    them (0 or 1) carries the tab, and of each the sheet and the middle of the edge there: of the
    first copy, on the front.

    Raises `InvalidValue` where a face is larger than the bed, or a style does not suit the kerf.
    """
    require_count("copies", copies, 1, "Ask for one copy or more.")
    tell = progress if progress is not None else lambda *_: None
    told = [*findings, *narrow_faces(pattern, machine.kerf_mm)]
    style = perforation_for(machine, material, scored=registration is not None)
    margin_mm = machine.margin_mm + (registration.border_mm if registration is not None else 0.0)
    tell("split", 0, 1)
    room = SheetSplit(
        margin_mm=margin_mm,
        mitre_mm=_CORNER_KERFS * machine.kerf_mm,
        tab_mm=max(material.tab_mm, _LEAST_TAB_MM),
    )
    pieces, found = split(pattern, room, machine.bed_mm, partial(tell, "split"))
    told += found
    if copies * len(pieces.pieces) > _MOST_PLACED:
        raise InvalidValue(
            "copies",
            f"{copies}, {copies * len(pieces.pieces)} pieces in all",
            f"make at most {_MOST_PLACED} pieces",
            "Make several runs.",
        )
    layers, creases = [], []
    for number, piece in enumerate(pieces.pieces):
        tell("perforate", number, len(pieces.pieces))
        drawn, became, found = cut_piece(piece.pattern, style, machine.kerf_mm)
        creases.append(replace(became, numbers=piece.edges[became.numbers]))
        told += _of_piece(piece, found, alone=len(pieces.pieces) == 1)
        layers.append((*drawn, engraved(piece.labels)) if pieces.labelled else drawn)
    told += crease_findings(creases, style.margin_mm, machine.kerf_mm)
    gap = max(_GAP_MM, _GAP_KERFS * machine.kerf_mm)
    outlines = [_outline(drawn) for drawn in layers]
    tell("nest", 0, copies * len(outlines))
    placements = nest(outlines, machine.bed_mm, gap, copies, margin_mm, partial(tell, "nest"))
    files: dict[str, bytes] = {}
    listed: list[dict[str, Any]] = []
    drawn_sheets = sheets(layers, placements, machine.bed_mm)
    for number, sheet in enumerate(drawn_sheets):
        tell("order", number, len(drawn_sheets))
        own, work = _sheet(sheet, f"{name}_{number + 1}", material, machine, registration, formats)
        files |= own
        listed.append(
            {
                "files": list(own),
                "pieces": [
                    pieces.pieces[item.piece].name
                    for item in placements.items
                    if item.sheet == number
                ],
                "used": round(float(placements.used[number]), 4),
                **work,
            }
        )
    report = _report(name, material, machine, copies, pieces, placements, listed)
    tell("write", 1, 1)
    return with_report(files, f"{name}_report.json", report, told)


def sheet_names(name: str) -> re.Pattern[str]:
    """What the sheets of a pattern are called."""
    return re.compile(rf"{re.escape(name)}_\d+(_front|_back)?\.({'|'.join(SheetFormat)})")


def _sheet(
    sheet: CutPaths,
    name: str,
    material: Material,
    machine: Machine,
    registration: Registration | None,
    formats: Sequence[SheetFormat],
) -> tuple[dict[str, bytes], dict[str, Any]]:
    """Files of one sheet, and what the report says of the work on it."""
    if registration is None:
        return _side(sheet, name, material, machine, formats)
    files: dict[str, bytes] = {}
    sides = []
    drawn = two_sided(sheet, registration, machine.margin_mm, machine.kerf_mm)
    for side, paths in zip(("front", "back"), drawn, strict=True):
        own, work = _side(paths, f"{name}_{side}", material, machine, formats)
        files |= own
        sides.append({"side": side, "files": list(own), **work})
    work = {key: _round(sum(side[key] for side in sides)) for key in work}
    turn = how_to_turn(name, registration, machine.bed_mm)
    return files, {**work, "sides": sides, "turn": turn}


def _side(
    paths: CutPaths,
    name: str,
    material: Material,
    machine: Machine,
    formats: Sequence[SheetFormat],
) -> tuple[dict[str, bytes], dict[str, Any]]:
    """Files of one drawing, and figures of the work, in the order of the tour."""
    ordered = tour(paths)
    work = asdict(estimate(ordered, _speeds(machine, material)))
    files = drawing_files(ordered, name, formats, machine.colours, machine.dxf_version)
    return files, {key: _round(value) for key, value in work.items()}


def _of_piece(piece: Piece, findings: Sequence[Finding], *, alone: bool) -> list[Finding]:
    """Findings of a piece, named unless it is alone, with edges numbered as in the pattern."""
    return [
        replace(
            finding,
            text=finding.text if alone else f"piece {piece.name}: {finding.text}",
            creases=tuple(int(piece.edges[e]) for e in finding.creases if piece.edges[e] >= 0),
        )
        for finding in findings
    ]


def _outline(layers: Sequence[Layer]) -> shapely.Polygon:
    """The outer outline of a piece as it is cut; what lies in its holes stays free."""
    rings = [
        ring for layer in layers if layer.operation is Operation.CUT for ring in layer.outlines
    ]
    if not rings:
        raise InvalidState("sheet", "the sheet is narrower than the kerf", "Enlarge it.")
    return max((shapely.Polygon(ring) for ring in rings), key=lambda polygon: polygon.area)


def _speeds(machine: Machine, material: Material) -> Speeds:
    ratio = material.cut_speed_ratio
    speeds = machine.speeds
    return speeds.model_copy(
        update={
            "cut_mm_s": speeds.cut_mm_s * ratio,
            "perforate_mm_s": speeds.perforate_mm_s * ratio,
        }
    )


def _report(
    name: str,
    material: Material,
    machine: Machine,
    copies: int,
    pieces: Pieces,
    placements: Placements,
    listed: list[dict[str, Any]],
) -> dict[str, Any]:
    return {
        "name": name,
        "material": material.model_dump(mode="json"),
        "machine": machine.model_dump(mode="json"),
        "copies": copies,
        "sheets": listed,
        "pieces": [
            {"name": piece.name, "faces": int((piece.faces >= 0).sum())} for piece in pieces.pieces
        ],
        "glue_up": _glue_up(pieces, placements),
    }


def _glue_up(pieces: Pieces, placements: Placements) -> list[dict[str, Any]]:
    """One row for each seam, in the order of assembling."""
    placed = {item.piece: item for item in placements.items if item.copy == 0}
    rows = []
    for seam in pieces.seams:
        at = []
        for number, edge in zip(seam.pieces, seam.piece_edges, strict=True):
            own, item = pieces.pieces[number].pattern, placed[number]
            middle = own.vertices_coords[own.edges_vertices[edge]].mean(axis=0)
            at.append([_round(x) for x in item.turn @ middle + item.shift])
        rows.append(
            {
                "label": seam.label,
                "length_mm": _round(seam.length_mm),
                "fold_angle_deg": _round(seam.fold_angle_deg),
                "pieces": [pieces.pieces[number].name for number in seam.pieces],
                "tab": seam.tab,
                "sheets": [placed[number].sheet + 1 for number in seam.pieces],
                "at_mm": at,
            }
        )
    return rows


def _round(value: float) -> float:
    return value if isinstance(value, int) else round(float(value), 4)


def sheets(
    pieces: Sequence[Sequence[Layer]], placements: Placements, bed_mm: tuple[float, float]
) -> list[CutPaths]:
    """The cut paths of every sheet: the layers of its pieces, moved and joined by operation.

    `size_mm` is the bed, not the used area: the drawing's origin is the machine's, so that the
    margin is where it was asked for, and every sheet of a job lies on the bed alike.
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
        )
        for sheet in range(len(placements.used))
    ]
