"""How does a crease pattern get from the file of one program into that of another?"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from fab.errors import Finding, InvalidFile, InvalidJob, Severity
from fab.formats.fold_frames import Frames
from fab.formats.fold_reader import PatternFile, pattern_of, read_pattern_file
from fab.formats.fold_writer import fold_bytes
from fab.formats.obj import obj_bytes, read_obj
from fab.formats.simulator_svg import simulator_svg_bytes
from fab.outputs import Made, plain_title
from fab.pattern.crease_pattern import CreasePattern
from fab.pattern.inspection import inspect_closure
from solver.vectors import FloatArray

__all__ = ["convert", "read_any"]

_FLAT, _FOLD = "_flat", "_fold"


def read_any(files: Sequence[Path], *, strict: bool = False) -> PatternFile:
    """The pattern in a FOLD file, or in a pair of OBJ files: the flat sheet and its folded form.

    Of one OBJ file the other is found by name: sheet_flat.obj and sheet_fold.obj. Both list the
    same vertices. A unit of theirs is a millimetre.

    Raises `InvalidFile` as `read_pattern_file` does, and `InvalidJob` for other files.
    """
    endings = [file.suffix.lower() for file in files]
    if endings == [".fold"]:
        return read_pattern_file(files[0], strict=strict)
    if endings == [".obj"]:
        return read_any(_pair(files[0]), strict=strict)
    if endings != [".obj", ".obj"]:
        given = " ".join(str(file) for file in files) or "no file"
        raise InvalidJob(
            f"{given}: give one FOLD file, or two OBJ files (flat and folded), to read from."
        )
    flat, folded = (read_obj(file) for file in files)
    if len(flat.vertices_coords) != len(folded.vertices_coords):
        raise InvalidFile(
            f"{files[1]}: {len(folded.vertices_coords)} vertices, but {files[0].name} has "
            f"{len(flat.vertices_coords)}. Both must list the same ones."
        )
    sheet = {
        "vertices_coords": flat.vertices_coords.tolist(),
        "faces_vertices": flat.faces_vertices,
    }
    shape = {"vertices_coords": folded.vertices_coords.tolist(), "frame_title": "folded form"}
    title = files[0].stem.removesuffix(_FLAT)
    return pattern_of(files[0], Frames(title, sheet, shape, ()), strict=strict)


def _pair(file: Path) -> tuple[Path, Path]:
    """Both files of a pair, the flat one first."""
    for ending in (_FLAT, _FOLD):
        if file.stem.endswith(ending):
            name = file.stem.removesuffix(ending)
            pair = (
                file.with_name(f"{name}{_FLAT}{file.suffix}"),
                file.with_name(f"{name}{_FOLD}{file.suffix}"),
            )
            for one in pair:
                if not one.is_file():
                    raise InvalidFile(f"{one}: missing; {file.name} is one of a pair with it.")
            return pair
    raise InvalidFile(
        f"{file}: one OBJ file is half of a sheet. Give the flat and the folded file, or name them "
        f"sheet{_FLAT}.obj and sheet{_FOLD}.obj."
    )


def convert(read: PatternFile, target: Path) -> Made:
    """What was read as the files that `target` names by its ending: .fold, .svg or .obj.

    For sheet.obj the pair sheet_flat.obj and sheet_fold.obj. Raises `InvalidJob` for another
    ending, and `InvalidFile` for a pair without a folded form.
    """
    pattern, title = read.pattern, plain_title(read.title or target.stem)
    findings = [*read.findings, *inspect_closure(pattern)]
    ending = target.suffix.lower()
    if ending == ".fold":
        files = {target.name: fold_bytes(pattern, title, read.states)}
    elif ending == ".svg":
        files = {target.name: simulator_svg_bytes(pattern, title)}
    elif ending == ".obj":
        files = _obj_pair(pattern, target, title)
        findings += _lost(pattern)
    else:
        raise InvalidJob(f"{target}: must end in .fold, .svg or .obj.")
    return Made(files, {}, tuple(findings))


def _obj_pair(pattern: CreasePattern, target: Path, title: str) -> dict[str, bytes]:
    if pattern.folded_coords is None:
        raise InvalidFile(
            f"{target}: there is no folded form to write. Read a file with a frame of class "
            "foldedForm, or write .fold or .svg."
        )
    name = target.stem.removesuffix(_FLAT).removesuffix(_FOLD)
    flat: FloatArray = np.pad(pattern.vertices_coords, ((0, 0), (0, 1)))
    shapes = {f"{name}{_FLAT}": flat, f"{name}{_FOLD}": pattern.folded_coords}
    faces, offsets = pattern.faces_vertices, pattern.faces_offsets
    return {
        f"{stem}{target.suffix}": obj_bytes(coords, faces, offsets, title)
        for stem, coords in shapes.items()
    }


def _lost(pattern: CreasePattern) -> list[Finding]:
    """What meshes have no place for."""
    one, two = pattern.edges_faces.T
    lost = np.flatnonzero(np.isin(pattern.edges_assignment, ["U", "C", "J"]) | (one == two))
    if not len(lost):
        return []
    text = (
        f"{len(lost)} cuts, joins, unassigned creases or creases that end within a face are not "
        "told in OBJ files. Keep the FOLD file."
    )
    creases = tuple(lost[:20].tolist())
    return [Finding("lost-in-obj", Severity.WARNING, text, creases=creases)]
