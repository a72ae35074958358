"""Clean triangle meshes out of files: meshes, and faces of CAD models."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from fab.errors import Finding, InvalidFile, Severity, counted
from fab.files import shown_path
from fab.formats.meshes.own_process import in_own_process
from fab.formats.meshes.surface import reading_bounds, require_surface
from fab.surfaces.clean_mesh import CleanMesh, clean_mesh
from fab.surfaces.mesh_reader import MESH_ENDINGS, read_triangles
from solver.errors import InvalidValue

__all__ = ["read_surface_mesh"]

_MODELS = (".step", ".stp")


def read_surface_mesh(path: str | Path, faces: int | Sequence[int] | None = None) -> CleanMesh:
    """The surface in a 3MF, GLB, OBJ, OFF, PLY, STL, STEP or STP file, as a clean mesh.

    faces : number of a face of a STEP file, from 0, or of several, which are sewn together where
    they are adjacent; None for all of them. Their triangles are within 1e-4 of their diagonal.
    Lengths are those of the file; of STEP and 3MF files millimetres. Raises `InvalidFile` or
    `InvalidValue`. Repairs are findings: see `fab.surfaces.clean_mesh`.
    """
    file = Path(path)
    size = require_surface(file, MESH_ENDINGS + _MODELS)
    findings: list[Finding] = []
    if file.suffix.lower() in _MODELS:
        given = {"path": str(file), "faces": _numbers(faces)}
        task = "fab.surfaces.step_mesh:step_triangles"
        found = in_own_process(task, file, given, reading_bounds(size))
        soup = found["vertices_coords"], found["faces"]
        if faces is None and int(found["count"]) > 1:
            text = (
                f"All {counted(int(found['count']), 'face')} of the model are taken together; "
                f"`face` chooses. {found['listed']}"
            )
            findings.append(Finding("model-faces", Severity.NOTE, text))
    else:
        if faces is not None:
            cure = "Faces are chosen in STEP files; a mesh is followed as a whole."
            name = "face" if isinstance(faces, int) else "faces"
            raise InvalidValue(name, faces, "be None for a mesh", cure)
        soup = read_triangles(file, size)
    try:
        clean = clean_mesh(soup)
    except InvalidFile as error:
        raise InvalidFile(f"{shown_path(file)}: {error}") from error
    return replace(clean, findings=(*findings, *clean.findings))


def _numbers(faces: int | Sequence[int] | None) -> list[int] | None:
    """Numbers of faces, each once."""
    if faces is None:
        return None
    numbers = [faces] if isinstance(faces, int) else list(faces)
    for number in numbers:
        if isinstance(number, bool) or not isinstance(number, int):
            cure = "Faces are numbered from 0."
            raise InvalidValue("face", number, "be a whole number", cure)
    if not numbers:
        raise InvalidValue("faces", "an empty list", "name a face", "Leave it out for all faces.")
    return sorted(set(numbers))
