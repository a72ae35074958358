"""Triangles out of mesh files: GLB, OBJ, OFF, PLY, STL by trimesh, 3MF by lib3mf."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from fab.errors import InvalidFile
from fab.formats.meshes.own_process import in_own_process
from fab.formats.meshes.surface import LARGE_MESH_BYTES, reading_bounds
from fab.surfaces.soup import Soup
from solver.targets.mesh import mesh_arrays
from solver.targets.triangles import quads_cut
from solver.vectors import LARGEST, FloatArray, IntArray

__all__ = ["MESH_ENDINGS", "read_triangles", "triangles_of_3mf"]

MESH_ENDINGS = (".3mf", ".glb", ".obj", ".off", ".ply", ".stl")
# Components of components of a 3MF file.
_DEEPEST = 20


def read_triangles(path: Path, size: int) -> Soup:
    """All triangles in a mesh file of `size` bytes, as they are; 3MF files in millimetres.

    Large files, and those of which a few bytes may say that they hold gigabytes (3MF files, which
    are unpacked, and GLB files), are read in a process of their own: see
    `fab.formats.meshes.surface.read_surface`. Raises `InvalidFile` or `InvalidValue`.
    """
    given = {"path": str(path)}
    ending = path.suffix.lower()
    if ending == ".3mf":
        task = "fab.surfaces.mesh_reader:triangles_of_3mf"
        found = in_own_process(task, path, given, reading_bounds(size))
    elif size > LARGE_MESH_BYTES or ending == ".glb":
        found = in_own_process("solver.targets.mesh:mesh_arrays", path, given, reading_bounds(size))
    else:
        found = mesh_arrays(path)
    coords, faces = found["vertices_coords"], found["faces"]
    if faces.shape[1] == 3:
        return coords, faces
    bounded = bool((np.abs(coords) <= LARGEST).all())  # other vertices are refused as they are used
    return coords, quads_cut(coords if bounded else np.zeros_like(coords), faces)


def triangles_of_3mf(path: str) -> dict[str, Any]:
    """Vertices, shape (n, 3), mm, and triangles of all that a 3MF file would have printed.

    Raises `InvalidFile` for what lib3mf cannot read.
    """
    from lib3mf import Lib3MF

    model = Lib3MF.Wrapper().CreateModel()
    try:
        model.QueryReader("3mf").ReadFromFile(path)
        items = model.GetBuildItems()
        coords, faces = [np.empty((0, 3))], [np.empty((0, 3), np.int64)]
        while items.MoveNext():
            item = items.GetCurrent()
            turn = _turn(item.GetObjectTransform()) if item.HasObjectTransform() else np.eye(4, 3)
            for points, triangles in _meshes(item.GetObjectResource(), turn, 0):
                faces.append(triangles + sum(map(len, coords)))
                coords.append(points)
        unit = _MILLIMETRES[model.GetUnit()]
    except Lib3MF.ELib3MFException as error:
        raise InvalidFile(f"{path}: cannot be read: {error}. Export it again.") from error
    return {"vertices_coords": unit * np.concatenate(coords), "faces": np.concatenate(faces)}


# Micrometre, millimetre, centimetre, inch, foot, metre: the order of lib3mf.
_MILLIMETRES = (1e-3, 1.0, 10.0, 25.4, 304.8, 1000.0)


def _turn(transform: Any) -> FloatArray:
    """A transform of lib3mf: rows for x, y, z and the shift, shape (4, 3)."""
    return np.array([list(row) for row in transform.Fields], np.float64)


def _meshes(item: Any, turn: FloatArray, depth: int) -> list[tuple[FloatArray, IntArray]]:
    """Points and triangles of an object and its components, where `turn` has them."""
    if depth > _DEEPEST:
        raise InvalidFile(f"components over {_DEEPEST} deep. Export it as one mesh.")
    if item.IsMeshObject():
        points = np.array([list(v.Coordinates) for v in item.GetVertices()], np.float64)
        triangles = np.array([list(t.Indices) for t in item.GetTriangleIndices()], np.int64)
        return [(points.reshape(-1, 3) @ turn[:3] + turn[3], triangles.reshape(-1, 3))]
    out = []
    for index in range(item.GetComponentCount()):
        part = item.GetComponent(index)
        inner = _turn(part.GetTransform()) if part.HasTransform() else np.eye(4, 3)
        both = np.concatenate([inner[:3] @ turn[:3], [inner[3] @ turn[:3] + turn[3]]])
        out += _meshes(part.GetObjectResource(), both, depth + 1)
    return out
