"""Surfaces in files: meshes, and faces of CAD models."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from fab.errors import InvalidFile
from fab.files import require_file, shown_path
from fab.formats.meshes.own_process import Bounds, in_own_process
from fab.formats.meshes.spline_face import SplineFace
from solver.errors import InvalidValue
from solver.targets.base import Target
from solver.targets.mesh import MeshSurface
from solver.targets.parametric import ParametricSurface

__all__ = [
    "LARGEST_BYTES",
    "LARGE_MESH_BYTES",
    "MEMORY_MB",
    "MEMORY_MB_PER_MB",
    "SECONDS",
    "SECONDS_PER_MB",
    "read_surface",
    "reading_bounds",
    "require_surface",
]

_MESHES = (".obj", ".ply", ".stl")
_MODELS = (".step", ".stp")
# Larger meshes are read in a process of their own.
LARGE_MESH_BYTES = 5_000_000
# Larger files are refused.
LARGEST_BYTES = 500_000_000
# What such a process may take at least, and for each MB of the file: far more than sound files
# need.
SECONDS, SECONDS_PER_MB = 30, 10
MEMORY_MB, MEMORY_MB_PER_MB = 2000, 100


def require_surface(path: Path, endings: Sequence[str]) -> int:
    """The size in bytes of a file with one of these endings, in lower case.

    Raises `InvalidFile` for another ending, where there is no file that can be read, and for one
    of over 500 MB.
    """
    if path.suffix.lower() not in endings:
        named = ", ".join(endings)
        raise InvalidFile(f"{shown_path(path)}: surfaces are read from files that end in {named}.")
    size = require_file(path, InvalidFile, "Check the path of the surface.")
    if size > LARGEST_BYTES:
        raise InvalidFile(
            f"{shown_path(path)}: {size} bytes are over the bound of {LARGEST_BYTES}. Export the "
            "surface alone, or as a simpler mesh."
        )
    return size


def read_surface(
    path: str | Path,
    face: int | None = None,
    up: Sequence[float] | None = None,
) -> Target:
    """The surface in an STL, OBJ, PLY, STEP or STP file, as a target of surface fitting.

    face : number of the face of a STEP file, from 0; may be left out where there is one alone.
    up : direction from which a mesh is seen (see `MeshSurface.from_faces`).
    Lengths of STEP files are in millimetres, whatever unit they were written in. Raises
    `InvalidFile` or `InvalidValue`.

    STEP files, and meshes over 5 MB, are read in a process of their own, since damaged ones make
    their readers crash, or keep them busy without end. It has 30 seconds and 2 GB of memory, and
    10 seconds and 100 MB more for each MB of the file. Its start takes about 0.3 seconds; that of
    the CAD library, some 2 seconds, would be needed without it as well.
    """
    file = Path(path)
    size = require_surface(file, _MESHES + _MODELS)
    if file.suffix.lower() in _MESHES:
        if face is not None:
            cure = "Faces are chosen in STEP files; a mesh is followed as a whole."
            raise InvalidValue("face", face, "be None for a mesh", cure)
        if size <= LARGE_MESH_BYTES:
            return MeshSurface.read(file, up=up)
        task = "solver.targets.mesh:mesh_arrays"
        mesh = in_own_process(task, file, {"path": str(file)}, reading_bounds(size))
        return MeshSurface.from_faces(mesh["vertices_coords"], mesh["faces"], up=up)
    if up is not None:
        cure = "The side of a face of a STEP file is the one on which its normals stand."
        raise InvalidValue("up", up, "be None for a STEP file", cure)
    if face is not None and (isinstance(face, bool) or not isinstance(face, int)):
        raise InvalidValue("face", face, "be a whole number", "Faces are numbered from 0.")
    given = {"path": str(file), "face": face}
    found = in_own_process(
        "fab.formats.meshes.step_faces:step_face", file, given, reading_bounds(size)
    )
    spline = SplineFace.of(found)
    return ParametricSurface(spline.position, spline.derivatives, spline.within)


def reading_bounds(size: int) -> Bounds:
    """What the reading of a file of this many bytes may take."""
    megabytes = size / 1e6
    return Bounds(SECONDS + SECONDS_PER_MB * megabytes, MEMORY_MB + MEMORY_MB_PER_MB * megabytes)
