"""How does a crease pattern become sheets that a machine cuts?

pattern -> pieces with tabs and labels -> perforation, relief, kerf -> placed on beds
-> order of the work, estimate -> DXF, SVG and PDF of each sheet, report
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections.abc import Callable, Sequence
from dataclasses import replace
from enum import StrEnum
from functools import partial
from typing import Any

import numpy as np
import shapely
from pydantic import ValidationError

from fab.crease import CreasePattern
from fab.errors import Finding, InvalidJob
from fab.labels import engraved
from fab.make import Made
from fab.materials import Machine, Material, Speeds, perforation_for
from fab.nesting import nest, sheets
from fab.paths import CutPaths, Layer, Operation
from fab.perforation import PerforationSettings, cut_layers
from fab.pieces import Piece, Pieces, SheetSplit, split
from fab.relief import ReliefSettings
from fab.tour import estimate, tour
from solver.errors import InvalidValue, require_count, require_positive

__all__ = ["SheetFormat", "coupon_files", "fabricate", "scaled"]

# Between two pieces on a sheet, in mm, and at least in kerfs.
_GAP_MM = 2.0
_GAP_KERFS = 4.0
# By so many kerfs the mitres of sharp corners may stand out from a piece.
_CORNER_KERFS = 5.0
# Lower tabs hold no glue.
_LEAST_TAB_MM = 1.0
# More pieces than this take hours to place, to put in order and to write.
_MOST_PLACED = 10_000

Progress = Callable[[str, int, int], None]


class SheetFormat(StrEnum):
    """The kinds of files of a sheet, named by their endings."""

    DXF = "dxf"
    SVG = "svg"
    PDF = "pdf"


def scaled(
    pattern: CreasePattern, *, width_mm: float | None = None, factor: float | None = None
) -> CreasePattern:
    """The pattern with its longer side `width_mm` long, or `factor` times as large."""
    if width_mm is not None and factor is not None:
        raise InvalidJob(f"width {width_mm:g} mm and scale {factor:g}: give one of them.")
    if width_mm is not None:
        require_positive("width_mm", width_mm)
        factor = width_mm / float(np.ptp(pattern.vertices_coords, axis=0).max())
    if factor is None:
        return pattern
    require_positive("scale", factor)
    folded = pattern.folded_coords
    return replace(
        pattern,
        vertices_coords=pattern.vertices_coords * factor,
        folded_coords=None if folded is None else folded * factor,
    )


def fabricate(
    pattern: CreasePattern,
    name: str,
    material: Material,
    machine: Machine,
    *,
    copies: int = 1,
    formats: Sequence[SheetFormat] = tuple(SheetFormat),
    findings: Sequence[Finding] = (),
    progress: Progress | None = None,
) -> Made:
    """Files of all sheets on which `copies` of a pattern lie, and report.json.

    pattern : in millimetres; findings : of its reader, told again in the report.
    progress : called with (stage, steps done, steps in the stage).

    The report lists sheets (file names, pierces, lengths in mm, minutes, share of the bed in use),
    pieces, and the seams in the order in which they are glued. Raises `InvalidValue` and
    `InvalidJob` where a face is larger than the bed, or a style does not suit the kerf.
    """
    require_count("copies", copies, 1, "Ask for one copy or more.")
    tell = progress if progress is not None else lambda *_: None
    told = list(findings)
    style = _perforation(machine, material)
    tell("split", 0, 1)
    room = SheetSplit(
        margin_mm=machine.margin_mm,
        mitre_mm=_CORNER_KERFS * machine.kerf_mm,
        tab_mm=max(material.tab_mm, _LEAST_TAB_MM),
    )
    pieces, found = split(pattern, room, machine.bed_mm)
    told += found
    if copies * len(pieces.pieces) > _MOST_PLACED:
        raise InvalidValue(
            "copies",
            f"{copies}, {copies * len(pieces.pieces)} pieces in all",
            f"make at most {_MOST_PLACED} pieces",
            "Make several runs.",
        )
    layers = []
    for number, piece in enumerate(pieces.pieces):
        tell("perforate", number, len(pieces.pieces))
        drawn, found = cut_layers(piece.pattern, style, machine.kerf_mm)
        told += found if len(pieces.pieces) == 1 else _of_piece(piece, found)
        layers.append((*drawn, engraved(piece.labels)) if pieces.labelled else drawn)
    gap = max(_GAP_MM, _GAP_KERFS * machine.kerf_mm)
    outlines = [_outline(drawn) for drawn in layers]
    tell("nest", 0, copies * len(outlines))
    placements = nest(
        outlines, machine.bed_mm, gap, copies, machine.margin_mm, partial(tell, "nest")
    )
    paths = []
    drawn_sheets = sheets(layers, placements, machine.bed_mm)
    for number, sheet in enumerate(drawn_sheets):
        tell("order", number, len(drawn_sheets))
        paths.append(tour(sheet))
    files: dict[str, bytes] = {}
    listed = []
    for number, sheet in enumerate(paths):
        tell("write", number, len(paths))
        own = _sheet_files(sheet, f"{name}_{number + 1}", machine, formats)
        files |= own
        work = estimate(sheet, _speeds(machine, material))
        listed.append(
            {
                "files": list(own),
                "pieces": [
                    pieces.pieces[item.piece].name
                    for item in placements.items
                    if item.sheet == number
                ],
                "used": round(float(placements.used[number]), 4),
                **{key: _round(value) for key, value in dataclasses.asdict(work).items()},
            }
        )
    report = _report(name, material, machine, copies, pieces, listed, files, told)
    files["report.json"] = (json.dumps(report, indent=2, allow_nan=False) + "\n").encode()
    tell("write", 1, 1)
    return Made(files, report, tuple(told))


def coupon_files(
    paths: CutPaths, name: str, machine: Machine, formats: Sequence[SheetFormat]
) -> dict[str, bytes]:
    """Files of one drawing, such as a test card, for a machine."""
    return _sheet_files(tour(paths), name, machine, formats)


def _perforation(machine: Machine, material: Material) -> PerforationSettings:
    """The material's styles, as the machine wants them; relief holes where it asks for them."""
    document = perforation_for(machine, material).model_dump()
    relief = None
    try:
        if material.relief_mm > 0:
            relief = ReliefSettings(web_mm=material.web_mm, radius_mm=material.relief_mm / 2)
        return PerforationSettings.model_validate({**document, "relief": relief})
    except ValidationError as error:
        raise InvalidJob(f"perforation of {material.description}: {error}") from error


def _of_piece(piece: Piece, findings: Sequence[Finding]) -> list[Finding]:
    """Findings of a piece, with edges numbered as in the whole pattern."""
    return [
        replace(
            finding,
            text=f"piece {piece.name}: {finding.text}",
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
        raise InvalidValue("sheet", "narrower than the kerf", "be wider", "Enlarge it.")
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


def _sheet_files(
    paths: CutPaths, name: str, machine: Machine, formats: Sequence[SheetFormat]
) -> dict[str, bytes]:
    files = {}
    if SheetFormat.DXF in formats:
        from fab.dxf import dxf_bytes

        files[f"{name}.dxf"] = dxf_bytes(paths, machine.colours, machine.dxf_version)
    if SheetFormat.SVG in formats:
        from fab.svg import svg_bytes

        files[f"{name}.svg"] = svg_bytes(paths, name, machine.colours)
    if SheetFormat.PDF in formats:
        from fab.pdf import pdf_bytes

        files[f"{name}.pdf"] = pdf_bytes(paths, name, machine.colours)
    return files


def _report(
    name: str,
    material: Material,
    machine: Machine,
    copies: int,
    pieces: Pieces,
    listed: list[dict[str, Any]],
    files: dict[str, bytes],
    findings: Sequence[Finding],
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
        "glue_up": [
            {"label": label, "pieces": [one, two], "length_mm": _round(length)}
            for label, one, two, length in pieces.glue_up()
        ],
        "outputs": [
            {"file": file, "bytes": len(data), "sha256": hashlib.sha256(data).hexdigest()}
            for file, data in files.items()
        ],
        "findings": [dataclasses.asdict(finding) for finding in findings],
    }


def _round(value: float) -> float:
    return value if isinstance(value, int) else round(float(value), 4)
