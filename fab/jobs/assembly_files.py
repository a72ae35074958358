"""The assembly guide of sheets: from patterns as they are cut and the report to pages."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import shapely

from fab.catalogue import with_thickness
from fab.drawings.cut_paths import Layer, Operation
from fab.errors import Finding, Severity, counted, mass_text
from fab.folding.rigid_motion import RigidVerdict, rigid_motion
from fab.layout.nesting import Placements
from fab.pattern.closing_edges import folded_by_angles
from fab.pattern.crease_pattern import CreasePattern
from fab.pattern.kinematics import unknown_angles
from fab.sheets.cut_pieces import CutPattern, PatternCopies
from fab.sheets.cut_wishes import TabKind
from fab.sheets.labels import number_text
from fab.sheets.materials import Machine
from fab.sheets.piece_patterns import Piece
from fab.sheets.rim_points import rim_points
from fab.sheets.seams import Seam
from fab.sheets.sheet_drawings import SheetDrawings
from fab.sheets.sheet_request import SheetRequest
from fab.viewing.assembly.guide import assembly_guide
from fab.viewing.assembly.parts import (
    Assembly,
    CutPiece,
    CutSheet,
    Hold,
    Joint,
    Model,
    Motion,
    Point,
)
from fab.viewing.drawing import size_text
from fab.viewing.leaflet import Leaflet
from solver.errors import OrigamiError
from solver.vectors import FloatArray

__all__ = ["caution", "guide_of"]

# What bounds a piece: its outline and its holes.
_OUTLINES = (Operation.HOLE, Operation.CUT)
# Placements that differ by less are alike, mm and of turns.
_DECIMALS = 6
# Of more creases it is not sought whether they fold rigidly, which may take seconds.
_MOST_CREASES = 2_000
_FOLDED_FLAT_DEG = 179.0


def guide_of(
    patterns: Sequence[PatternCopies],
    name: str,
    request: SheetRequest,
    made: SheetDrawings,
    *,
    made_by: str,
    findings: Sequence[Finding] = (),
    upright: bool = False,
) -> Leaflet:
    """How the pieces of some patterns, which are cut together, are put together.

    made : their sheets. made_by : the command, such as "quadfold fabricate". findings : of all that
    is made. upright : whether z is up in their folded forms.
    """
    models = []
    first, total = 0, sum(len(cut.pieces.pieces) for cut in made.cut)
    points = 0
    for wanted, cut in zip(patterns, made.cut, strict=True):
        copies = wanted.copies * request.copies
        models.append(_model(wanted, cut, request, copies, (first, total, points), upright))
        first += len(cut.pieces.pieces)
        points += 0 if cut.meeting is None else len(cut.meeting.vertices)
    sheets = _cut_sheets(request, made.placements, made.report)
    facts = tuple(_facts(request, made.report))
    cutting = tuple(_cutting(request, made.report))
    face_down = request.wishes.mirror
    return assembly_guide(
        Assembly(name, made_by, tuple(models), sheets, facts, cutting, face_down, caution(findings))
    )


def caution(findings: Sequence[Finding]) -> str:
    """What is to be read first where findings are errors."""
    errors = [finding for finding in findings if finding.severity is Severity.ERROR]
    if not errors:
        return ""
    codes = ", ".join(dict.fromkeys(finding.code for finding in errors))
    return f"Do not make it as it is: the report has {counted(len(errors), 'error')} ({codes})."


def _cutting(request: SheetRequest, report: Mapping[str, Any]) -> list[str]:
    """What is to be done when the sheets are cut."""
    out = []
    turn = report["sheets"][0].get("turn")
    if turn is not None:
        out.append(turn)
    if request.wishes.bridges:
        bridges = counted(request.wishes.bridges, "bridge")
        out.append(f"Each piece hangs in its sheet by {bridges}: cut through them with a knife.")
    return out


def _model(
    wanted: PatternCopies,
    cut: CutPattern,
    request: SheetRequest,
    copies: int,
    before: tuple[int, int, int],
    upright: bool,
) -> Model:
    """One pattern; before : pieces of those before it, of all, and points of those before it."""
    pattern = wanted.pattern
    first, total, points = before
    pieces = tuple(
        _cut_piece(pattern, piece, own)
        for piece, own in zip(cut.pieces.pieces, cut.layers, strict=True)
    )
    joints = tuple(
        Joint(
            seam.label,
            number_text(seam.label),
            seam.edges,
            seam.pieces,
            seam.length_mm,
            seam.fold_angle_deg,
            _hold(seam, request.wishes.tabs),
            None if seam.tab is None else seam.pieces[seam.tab],
            seam.stitches,
        )
        for seam in cut.pieces.seams
    )
    formed: CreasePattern | None = pattern
    if pattern.folded_coords is None:
        by_angles = folded_by_angles(pattern)
        formed = None if by_angles is None else by_angles.pattern
    return Model(
        wanted.name,
        pattern,
        formed,
        upright,
        pieces,
        joints,
        _points(pattern, cut, points),
        tuple(_model_facts(pattern, formed, request, pieces, len(joints), copies)),
        copies,
        first,
        total,
        _motion(pattern),
    )


# What a seam that has a tab is held by.
_HOLDS = {"one side": Hold.TAB, "both sides": Hold.TABS, "slots": Hold.TONGUE}


def _hold(seam: Seam, tabs: TabKind) -> Hold:
    """What holds a seam together: tape where there is no room for anything else."""
    if seam.stitches:
        return Hold.STITCHES
    return Hold.TAPE if seam.tab is None else _HOLDS[tabs]


def _motion(pattern: CreasePattern) -> Motion:
    """How its faces move, as far as that is found quickly.

    Of sheets that are folded flat, or to angles that are not known, states between are sought,
    which takes seconds.
    """
    joining = pattern.edges_joining
    over = np.abs(pattern.edges_foldAngle[joining]).max(initial=0.0) >= _FOLDED_FLAT_DEG
    if int(joining.sum()) > _MOST_CREASES or over or unknown_angles(pattern)[joining].any():
        return Motion.UNKNOWN
    try:
        found = rigid_motion(pattern)
    except OrigamiError:
        return Motion.UNKNOWN
    if found.verdict is RigidVerdict.BENDS:
        return Motion.BENDS
    if found.verdict is not RigidVerdict.FOLDS or found.freedom is None:
        return Motion.UNKNOWN
    return Motion.TOGETHER if found.freedom.count == 1 else Motion.RIGID


def _points(pattern: CreasePattern, cut: CutPattern, before: int) -> tuple[Point, ...]:
    """The points at which rims are glued, with what is engraved beside them."""
    if cut.meeting is None:
        return ()
    seams = cut.pieces.seams
    closing = [seam.edges for seam in seams if seam.edges[0] != seam.edges[1]]
    ends = pattern.edges_vertices[np.array(closing, np.int64).reshape(-1, 2)]
    known = rim_points(cut.meeting, "p" if seams else "", ends, before)
    count = len(cut.meeting.edges)
    engraved = dict(zip(known.edges.tolist(), known.texts, strict=True))
    texts = [engraved.get(edge) for edge in cut.meeting.edges[:, 0].tolist()]
    assert len(texts) == count
    return tuple(
        Point(text.rstrip("."), (a, b))
        for text, (a, b) in zip(texts, cut.meeting.vertices.tolist(), strict=True)
        if text is not None
    )


def _cut_piece(pattern: CreasePattern, piece: Piece, layers: Sequence[Layer]) -> CutPiece:
    rings = tuple(
        ring for layer in layers if layer.operation in _OUTLINES for ring in layer.outlines
    )
    own = piece.pattern
    count = int((piece.faces >= 0).sum())
    faces = piece.faces[:count]
    chosen = np.repeat(
        np.isin(np.arange(pattern.face_count), faces), np.diff(pattern.faces_offsets)
    )
    place = pattern.vertices_coords[pattern.faces_vertices[chosen]]
    source = own.vertices_coords[own.faces_vertices[: own.faces_offsets[count]]]
    corners = own.vertices_coords[own.faces_vertices[own.faces_offsets[count] :]]
    carried = _carried(source, place, corners)
    starts = own.faces_offsets[count:] - own.faces_offsets[count]
    tabs = tuple(carried[a:b] for a, b in pairwise(starts.tolist()))
    return CutPiece(piece.name, faces, tabs, rings, piece.name not in piece.unwritten)


def _carried(source: FloatArray, place: FloatArray, points: FloatArray) -> FloatArray:
    """Points of a plane, moved as `source` is moved to `place`, without mirroring; (n, 2)."""
    middle, there = source.mean(axis=0), place.mean(axis=0)
    first, second = (source - middle) @ [1, 1j], (place - there) @ [1, 1j]
    turn = (first.conj() * second).sum()
    turned = ((points - middle) @ [1, 1j]) * turn / abs(turn)
    out: FloatArray = np.column_stack([turned.real, turned.imag]) + there
    return out


def _cut_sheets(
    request: SheetRequest, placements: Placements, report: Mapping[str, Any]
) -> tuple[CutSheet, ...]:
    """All sheets, alike ones together."""
    mirrored = request.wishes.mirror
    flip = np.diag([-1.0 if mirrored else 1.0, 1.0])
    over = np.array([request.machine.bed_mm[0] if mirrored else 0.0, 0.0])
    alike: dict[tuple[Any, ...], list[int]] = {}
    lying = []
    for number in range(len(placements.used)):
        items = [item for item in placements.items if item.sheet == number]
        lying.append(
            tuple((item.piece, flip @ item.turn, flip @ item.shift + over) for item in items)
        )
        key = tuple(
            (item.piece, *item.turn.round(_DECIMALS).ravel(), *item.shift.round(_DECIMALS))
            for item in items
        )
        alike.setdefault(key, []).append(number)
    return tuple(
        CutSheet(
            tuple(number + 1 for number in numbers),
            request.machine.bed_mm,
            lying[numbers[0]],
            float(report["sheets"][numbers[0]]["minutes"]),
        )
        for numbers in alike.values()
    )


def _facts(request: SheetRequest, report: Mapping[str, Any]) -> list[tuple[str, str]]:
    """What is stated of all sheets."""
    material, machine = request.material, request.machine
    width, depth = machine.bed_mm
    minutes = sum(float(sheet["minutes"]) for sheet in report["sheets"])
    grams = material.grams_per_m2 * width * depth / 1e6
    settings = _kerf_text(machine)
    if request.registration is not None:
        settings += ", creases scored from both sides"
    return [
        ("Material", with_thickness(material.description, material.thickness_mm)),
        ("Machine", machine.description),
        ("Settings", settings),
        ("Sheets", f"{len(report['sheets'])} of {width:g} x {depth:g} mm, {mass_text(grams)} each"),
        ("Cutting time", f"about {minutes:.1f} min in all"),
    ]


def _kerf_text(machine: Machine) -> str:
    """Such as "kerf 0.1 x 0.2 mm, allowed for in the drawings"."""
    widths = machine.kerf_mm if isinstance(machine.kerf_mm, tuple) else (machine.kerf_mm,)
    if not any(widths):
        return "no kerf"
    return f"kerf {' x '.join(f'{width:g}' for width in widths)} mm, allowed for in the drawings"


def _model_facts(
    pattern: CreasePattern,
    formed: CreasePattern | None,
    request: SheetRequest,
    pieces: Sequence[CutPiece],
    seams: int,
    copies: int,
) -> list[tuple[str, str]]:
    """What is stated of a model."""
    counts = pattern.counts()
    grams = request.material.grams_per_m2 * sum(map(_area_mm2, pieces)) / 1e6
    size = size_text("flat", pattern.vertices_coords)
    if formed is not None and formed.folded_coords is not None:
        size += f", {size_text('folded', formed.folded_coords)}"
    return [
        ("Copies", str(copies)),
        ("Pieces", f"{len(pieces)}, {counted(seams, 'seam')}" if seams else str(len(pieces))),
        ("Size", size),
        ("Creases", f"{counted(counts['M'], 'mountain')}, {counted(counts['V'], 'valley')}"),
        ("Mass", mass_text(grams)),
    ]


def _area_mm2(piece: CutPiece) -> float:
    """Area of a piece with its tabs, without its holes."""
    areas = sorted(float(shapely.Polygon(ring).area) for ring in piece.outline)
    return areas[-1] - sum(areas[:-1]) if areas else 0.0
