"""Report of sheets: what was asked for, each sheet with its work, all pieces, and the glue-up list.

Lengths are in mm, angles in degrees, rounded to four decimals.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from fab.layout.nesting import Placements
from fab.sheets.pieces import Pieces
from fab.sheets.sheet_request import SheetRequest
from fab.sheets.work_estimate import Estimate

__all__ = ["PatternRow", "estimate_report", "sheet_report", "sides_report"]


@dataclass(frozen=True)
class PatternRow:
    """A pattern in the report: its name, copies in all, and numbers of its pieces and seams."""

    name: str
    copies: int
    pieces: int
    seams: int


def sheet_report(
    name: str,
    request: SheetRequest,
    pieces: Pieces,
    placements: Placements,
    sheets: Sequence[Mapping[str, Any]],
    patterns: Sequence[PatternRow],
) -> dict[str, Any]:
    """The whole report.

    sheets : files and work of each, to which pieces and share are added. patterns : those whose
    pieces these are, one after another.
    """
    owners = [row.name for row in patterns for _ in range(row.pieces)]
    return {
        "name": name,
        "material": request.material.model_dump(mode="json"),
        "machine": request.machine.model_dump(mode="json"),
        "copies": request.copies,
        "sheets": [
            _of_sheet(number, dict(sheet), pieces, placements)
            for number, sheet in enumerate(sheets)
        ],
        "patterns": [asdict(row) for row in patterns],
        "pieces": [
            {"name": piece.name, "pattern": owner, "faces": int((piece.faces >= 0).sum())}
            for piece, owner in zip(pieces.pieces, owners, strict=True)
        ],
        "glue_up": _glue_up(pieces, placements, owners),
    }


def estimate_report(estimate: Estimate) -> dict[str, Any]:
    """Figures of the work on a drawing."""
    return {key: _rounded(value) for key, value in asdict(estimate).items()}


def sides_report(sides: Mapping[str, Mapping[str, Any]], turn: str) -> dict[str, Any]:
    """Figures of a sheet that is worked on from both sides, their sums, and how it is turned over.

    sides : for each side its files and figures.
    """
    figures = [key for key in next(iter(sides.values())) if key != "files"]
    sums = {key: _rounded(sum(side[key] for side in sides.values())) for key in figures}
    listed = [{"side": name, **side} for name, side in sides.items()]
    return {**sums, "sides": listed, "turn": turn}


def _of_sheet(
    number: int, sheet: dict[str, Any], pieces: Pieces, placements: Placements
) -> dict[str, Any]:
    """One sheet: its files, its pieces, the share of the bed in use, then the work."""
    placed = [pieces.pieces[item.piece].name for item in placements.items if item.sheet == number]
    return {
        "files": sheet.pop("files"),
        "pieces": placed,
        "used": round(float(placements.used[number]), 4),
        **sheet,
    }


def _glue_up(pieces: Pieces, placements: Placements, owners: Sequence[str]) -> list[dict[str, Any]]:
    """One row for each seam, in the order of assembling; owners : the pattern of each piece."""
    placed = {item.piece: item for item in placements.items if item.copy == 0}
    rows = []
    for seam in pieces.seams:
        at = []
        for number, edge in zip(seam.pieces, seam.piece_edges, strict=True):
            own, item = pieces.pieces[number].pattern, placed[number]
            middle = own.vertices_coords[own.edges_vertices[edge]].mean(axis=0)
            at.append([_rounded(x) for x in item.turn @ middle + item.shift])
        rows.append(
            {
                "label": seam.label,
                "pattern": owners[seam.pieces[0]],
                "length_mm": _rounded(seam.length_mm),
                "fold_angle_deg": _rounded(seam.fold_angle_deg),
                "pieces": [pieces.pieces[number].name for number in seam.pieces],
                "tab": seam.tab,
                **({"stitches": seam.stitches} if seam.stitches else {}),
                "sheets": [placed[number].sheet + 1 for number in seam.pieces],
                "at_mm": at,
            }
        )
    return rows


def _rounded(value: float) -> float:
    return value if isinstance(value, int) else round(float(value), 4)
