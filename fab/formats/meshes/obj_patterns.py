"""Crease patterns in OBJ files: a flat mesh, a folded one that unfolds, or a pair of both."""

from __future__ import annotations

from pathlib import Path

from fab.errors import Finding, InvalidFile, Severity
from fab.formats.fold.frames import frames_of_shapes
from fab.formats.fold.reader import pattern_of
from fab.formats.meshes.obj import ObjMesh, read_obj
from fab.formats.pattern_file import PatternFile
from fab.formats.read_options import ReadOptions
from fab.outputs import plain_title

__all__ = ["FLAT", "FOLD", "read_obj_pair", "read_obj_pattern"]

# Endings of the names of a pair.
FLAT, FOLD = "_flat", "_fold"


def read_obj_pattern(path: Path, options: ReadOptions) -> PatternFile:
    """The pattern of a mesh, and of its other half where that is beside it.

    Halves are found by name: sheet_flat.obj and sheet_fold.obj. A flat mesh alone, in any plane, is
    a pattern without angles; a folded one is unfolded. A unit is a millimetre unless `options` say
    otherwise.

    Raises `InvalidFile` for meshes that do not unfold, with the vertices that are not flat.
    """
    for ending, other in ((FLAT, FOLD), (FOLD, FLAT)):
        if path.stem.endswith(ending):
            name = path.stem.removesuffix(ending)
            partner = path.with_name(f"{name}{other}{path.suffix}")
            if partner.is_file():
                pair = (path, partner) if ending == FLAT else (partner, path)
                return read_obj_pair(*pair, options)
            text = f"there is no {plain_title(partner.name)} beside it: it is read alone."
            return _alone(path, name, options, [Finding("half-missing", Severity.NOTE, text)])
    return _alone(path, path.stem, options, [])


def _alone(path: Path, name: str, options: ReadOptions, findings: list[Finding]) -> PatternFile:
    frame = _frame(read_obj(path))
    return pattern_of(
        path, frames_of_shapes(path, plain_title(name), frame, None, findings), options
    )


def read_obj_pair(flat: Path, folded: Path, options: ReadOptions) -> PatternFile:
    """The pattern of a flat mesh and its folded form, which list the same vertices."""
    sheet, shape = read_obj(flat), read_obj(folded)
    if len(sheet.vertices_coords) != len(shape.vertices_coords):
        raise InvalidFile(
            f"{folded}: {len(shape.vertices_coords)} vertices, but {flat.name} has "
            f"{len(sheet.vertices_coords)}. Both must list the same ones."
        )
    title = plain_title(flat.stem.removesuffix(FLAT))
    form = {"vertices_coords": shape.vertices_coords.tolist(), "frame_title": "folded form"}
    return pattern_of(flat, frames_of_shapes(flat, title, _frame(sheet), form, []), options)


def _frame(mesh: ObjMesh) -> dict[str, object]:
    return {
        "vertices_coords": mesh.vertices_coords.tolist(),
        "faces_vertices": mesh.faces_vertices,
    }
