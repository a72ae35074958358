"""Crease patterns from the files of one program into those of another."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fab.errors import Finding, InvalidJob, Severity, counted, did_you_mean, first_few
from fab.formats.fold.writer import fold_bytes
from fab.formats.meshes.obj import obj_bytes
from fab.formats.meshes.obj_patterns import FLAT, FOLD
from fab.formats.oripa.cp import cp_bytes, lost_in_cp
from fab.formats.pattern_file import PatternFile
from fab.formats.svg.writer import simulator_svg_bytes
from fab.layers.layer_findings import inspect_layers
from fab.layers.layer_orders import FoldsFlat, layer_orders
from fab.outputs import Made, plain_title
from fab.pattern.crease_pattern import CreasePattern
from fab.pattern.inspection import inspect_closure
from fab.viewing.reading_picture import reading_png_bytes
from solver.vectors import FloatArray, IntArray

__all__ = ["WRITTEN", "convert"]


# Endings of files that are written.
WRITTEN = (".fold", ".svg", ".dxf", ".cp", ".obj", ".png")
_DRAWINGS = (".svg", ".dxf", ".cp")
_WITHOUT_LAYERS = (*_DRAWINGS, ".obj")
# The order of layers is sought for so long.
_LAYERS_S = 20.0


def convert(read: PatternFile, target: Path) -> Made:
    """What was read as the files that `target` names by its ending, one of `WRITTEN`.

    For sheet.obj the pair sheet_flat.obj and sheet_fold.obj, or sheet.obj itself, the flat mesh,
    where there is no folded form; for sheet.png a picture of what was understood. Findings are
    those of `read`, of angles that do not close, and of what the format has no place for. Raises
    `InvalidJob` for another ending.
    """
    pattern, title = read.pattern, plain_title(read.title or target.stem)
    findings = [*read.findings, *inspect_closure(pattern)]
    ending = target.suffix.lower()
    if ending not in WRITTEN:
        *others, last = WRITTEN
        hint = did_you_mean(ending, WRITTEN)
        raise InvalidJob(f"{target}: must end in {', '.join(others)} or {last}.{hint}")
    if ending in _WITHOUT_LAYERS:
        findings += _lost_layers(read, ending)
    if ending == ".obj":
        findings += _lost(pattern)
        made = _obj_sheet if pattern.folded_coords is None else _obj_pair
        return Made(made(pattern, target, title), {}, tuple(findings))
    if ending == ".fold":
        orders, found = _orders(read)
        findings += found
        data = fold_bytes(pattern, title, read.states, orders)
    elif ending == ".svg":
        data = simulator_svg_bytes(pattern, title)
    elif ending == ".png":
        data = reading_png_bytes(read, title)
    elif ending == ".dxf":
        from fab.formats.dxf.writer import angles_lost_in_dxf, dxf_bytes

        data = dxf_bytes(pattern, title)
        findings += angles_lost_in_dxf(pattern)
    else:
        data = cp_bytes(pattern)
        findings += lost_in_cp(pattern)
    if ending in _DRAWINGS:
        findings += _lost_in_drawing(read)
    return Made({target.name: data}, {}, tuple(findings))


def _lost_layers(read: PatternFile, ending: str) -> list[Finding]:
    """The order of layers that the file has, and other formats have no place for."""
    rows = read.face_orders[read.face_orders[:, 2] != 0]
    if not len(rows):
        return []
    text = (
        f"{ending[1:].upper()} files have no place for the order of layers, the faceOrders of "
        f"{counted(len(rows), 'pair')} of faces. Keep the FOLD file."
    )
    faces = np.unique(rows[:, :2])
    return [Finding("layers-lost", Severity.WARNING, text, panels=first_few(faces))]


def _lost_in_drawing(read: PatternFile) -> list[Finding]:
    """What lines alone cannot say: which of the faces that lie over each other they belong to."""
    over = next((finding for finding in read.findings if finding.code == "sheet-overlaps"), None)
    if over is None:
        return []
    text = (
        "the drawing has the lines of faces that lie over each other in one place, and cannot say "
        "which face they belong to: it is no pattern to cut or to read again. Keep the FOLD file, "
        "which fabricate cuts into pieces."
    )
    return [Finding("faces-lost-in-drawing", Severity.WARNING, text, panels=over.panels)]


def _orders(read: PatternFile) -> tuple[IntArray | None, list[Finding]]:
    """Rows of faceOrders, of all faces that overlap where the sheet is folded flat, and findings.

    Those of the file where other angles than 180 degrees or undecided layers leave them unjudged,
    and where there is no folded form and a sheet can have them; None where no order is known.
    """
    pattern = read.pattern
    given = read.face_orders if len(read.face_orders) else None
    has_form = pattern.folded_coords is not None
    if not has_form and given is None:
        return None, []
    layers = layer_orders(pattern, given, _LAYERS_S)
    if layers is None:
        return given, []
    found = inspect_layers(layers)
    if layers.folds_flat is FoldsFlat.UNDECIDED:
        return given, found
    if not has_form:
        return (None if found else given), found  # rows of 0 say nothing that could be wrong
    return (layers.orders if len(layers.orders) else None), found


def _obj_sheet(pattern: CreasePattern, target: Path, title: str) -> dict[str, bytes]:
    """The flat mesh alone."""
    faces, offsets = pattern.faces_vertices, pattern.faces_offsets
    return {target.name: obj_bytes(_flat(pattern), faces, offsets, title)}


def _flat(pattern: CreasePattern) -> FloatArray:
    flat: FloatArray = np.pad(pattern.vertices_coords, ((0, 0), (0, 1)))
    return flat


def _obj_pair(pattern: CreasePattern, target: Path, title: str) -> dict[str, bytes]:
    assert pattern.folded_coords is not None
    name = target.stem.removesuffix(FLAT).removesuffix(FOLD)
    shapes = {f"{name}{FLAT}": _flat(pattern), f"{name}{FOLD}": pattern.folded_coords}
    faces, offsets = pattern.faces_vertices, pattern.faces_offsets
    return {
        f"{stem}{target.suffix}": obj_bytes(coords, faces, offsets, title)
        for stem, coords in shapes.items()
    }


def _lost(pattern: CreasePattern) -> list[Finding]:
    """What meshes have no place for."""
    out = []
    folds = np.flatnonzero(np.isin(pattern.edges_assignment, ["M", "V"]))
    if pattern.folded_coords is None and len(folds):
        text = (
            "there is no folded form: the OBJ file is the flat sheet alone, without its "
            f"{counted(len(folds), 'mountain or valley', 'mountains and valleys')}. Keep the FOLD "
            "file, or convert the one that simulate writes, which has folded forms."
        )
        out.append(Finding("folds-lost-in-obj", Severity.WARNING, text, creases=first_few(folds)))
    first, second = pattern.edges_faces.T
    lost = np.flatnonzero(np.isin(pattern.edges_assignment, ["U", "C", "J"]) | (first == second))
    if not len(lost):
        return out
    text = (
        f"OBJ files have no place for {len(lost)} cuts, joins, unassigned creases or creases that "
        "end within a face. Keep the FOLD file."
    )
    return [*out, Finding("lost-in-obj", Severity.WARNING, text, creases=first_few(lost))]
