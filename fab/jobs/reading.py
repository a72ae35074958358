"""Crease patterns in files of any program, read with all that the user says of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from fab.errors import Finding, InvalidFile, InvalidJob
from fab.formats.coordinate_bounds import require_sheet_size
from fab.formats.meshes.obj_patterns import read_obj_pair
from fab.formats.pattern_file import PatternFile, resized
from fab.formats.read_options import ReadOptions
from fab.formats.reading import read_pattern_file
from fab.formats.strictness import require_no_repairs
from fab.formats.units import sheet_small
from fab.pattern.crease_pattern import CreasePattern
from solver.errors import InvalidValue

__all__ = ["read_any", "read_pattern", "read_sheet"]

_FULLY_FOLDED_DEG = 180.0


def read_any(files: Sequence[Path], options: ReadOptions | None = None) -> PatternFile:
    """The pattern in a file, or in a pair of OBJ files: the flat sheet and its folded form.

    With `options.rigid` its fold angles are those of a rigid fold.

    Raises `InvalidFile` as `read_pattern_file` does, and `InvalidJob` for another number of files.
    """
    options = ReadOptions() if options is None else options
    if not options.rigid:
        return _read(files, options)
    from fab.folding.rigid_angles import rigid_angles

    full = _FULLY_FOLDED_DEG if options.fold_deg is None else options.fold_deg
    read = _read(files, replace(options, fold_deg=full))
    try:
        pattern, found = rigid_angles(read.pattern, full)
    except InvalidValue as error:
        raise InvalidFile(f"{files[0]}: {error}") from error
    require_no_repairs(files[0], found, options)
    states = read.states if pattern is read.pattern else ()
    return replace(read, pattern=pattern, states=states, findings=(*read.findings, *found))


def _read(files: Sequence[Path], options: ReadOptions) -> PatternFile:
    if len(files) == 1:
        return read_pattern_file(files[0], options)
    if [file.suffix.lower() for file in files] != [".obj", ".obj"]:
        given = " ".join(str(file) for file in files) or "no file"
        raise InvalidJob(
            f"{given}: give one file, or two OBJ files (flat and folded), to read from."
        )
    return read_obj_pair(files[0], files[1], options)


def read_pattern(
    path: str | Path, options: ReadOptions | None = None
) -> tuple[CreasePattern, tuple[Finding, ...]]:
    """The crease pattern in a file (FOLD, SVG, DXF, CP, OPX, ORI, ORH or OBJ), and what was found.

    In millimetres, its lower left corner at the origin. Raises `InvalidFile` with the place and the
    cure for what cannot be read.
    """
    read = read_any([Path(path)], options)
    return read.pattern, read.findings


def read_sheet(
    path: Path,
    options: ReadOptions | None = None,
    *,
    width_mm: float | None = None,
    factor: float | None = None,
) -> PatternFile:
    """The pattern in a file in the size asked for: to make things of.

    A sheet that is small because its file names no unit is reported as "sheet-small".

    Raises `InvalidFile` for sizes that nothing can be made of, `InvalidJob` for two sizes.
    """
    read = resized(read_any([path], options), width_mm=width_mm, factor=factor)
    require_sheet_size(path, read.pattern)
    if width_mm is not None or factor is not None:
        return read
    small = sheet_small(read.findings, read.pattern)
    return replace(read, findings=(*read.findings, *small))
