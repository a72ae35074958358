"""Crease patterns from the files of one program into those of another."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from fab.errors import Finding, InvalidFile, InvalidJob, Severity, first_few
from fab.formats.fold_writer import fold_bytes
from fab.formats.obj import obj_bytes
from fab.formats.obj_patterns import FLAT, FOLD, read_obj_pair
from fab.formats.pattern_file import PatternFile
from fab.formats.read_options import ReadOptions
from fab.formats.reading import read_pattern_file
from fab.formats.simulator_svg import simulator_svg_bytes
from fab.outputs import Made, plain_title
from fab.pattern.crease_pattern import CreasePattern
from fab.pattern.inspection import inspect_closure
from solver.vectors import FloatArray

__all__ = ["convert", "read_any"]


def read_any(
    files: Sequence[Path], options: ReadOptions | None = None, *, strict: bool = False
) -> PatternFile:
    """The pattern in a file, or in a pair of OBJ files: the flat sheet and its folded form.

    strict : as in `options`. Raises `InvalidFile` as `read_pattern_file` does, and `InvalidJob` for
    another number of files.
    """
    options = ReadOptions() if options is None else options
    options = replace(options, strict=options.strict or strict)
    if len(files) == 1:
        return read_pattern_file(files[0], options)
    if [file.suffix.lower() for file in files] != [".obj", ".obj"]:
        given = " ".join(str(file) for file in files) or "no file"
        raise InvalidJob(
            f"{given}: give one file, or two OBJ files (flat and folded), to read from."
        )
    return read_obj_pair(files[0], files[1], options)


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
    name = target.stem.removesuffix(FLAT).removesuffix(FOLD)
    flat: FloatArray = np.pad(pattern.vertices_coords, ((0, 0), (0, 1)))
    shapes = {f"{name}{FLAT}": flat, f"{name}{FOLD}": pattern.folded_coords}
    faces, offsets = pattern.faces_vertices, pattern.faces_offsets
    return {
        f"{stem}{target.suffix}": obj_bytes(coords, faces, offsets, title)
        for stem, coords in shapes.items()
    }


def _lost(pattern: CreasePattern) -> list[Finding]:
    """What meshes have no place for."""
    first, second = pattern.edges_faces.T
    lost = np.flatnonzero(np.isin(pattern.edges_assignment, ["U", "C", "J"]) | (first == second))
    if not len(lost):
        return []
    text = (
        f"OBJ files have no place for {len(lost)} cuts, joins, unassigned creases or creases that "
        "end within a face. Keep the FOLD file."
    )
    return [Finding("lost-in-obj", Severity.WARNING, text, creases=first_few(lost))]
