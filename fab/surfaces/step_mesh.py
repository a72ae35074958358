"""Faces of STEP files, sewn where they are adjacent, as triangles, by OpenCASCADE.

Damaged files make OpenCASCADE crash, or keep it busy without end: `fab.surfaces.reading` calls this
in a process of its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fab.errors import InvalidFile
from fab.formats.meshes.step_faces import listed_faces
from solver.errors import InvalidValue

if TYPE_CHECKING:
    from build123d import Face

__all__ = ["step_triangles"]

# How far triangles may be from the faces, and edges of neighbours from each other, in diagonals of
# the faces' box.
DEVIATION = 1e-4
_SEWN = 1e-6
# Largest angle between neighbouring sides of the triangles, radians.
_ANGLE = 0.1


def step_triangles(path: str, faces: Sequence[int] | None) -> dict[str, Any]:
    """Triangles of faces of a STEP file, within 1e-4 of their diagonal, mm.

    faces : their numbers, from 0; None for all faces of the file. Their names are
    "vertices_coords", shape (n, 3), "faces", shape (m, 3), counterclockwise seen from outside of
    the body, "count", how many faces of the file they are, and "listed", the faces of the file in
    words. Raises `InvalidFile` or
    `InvalidValue`.
    """
    from build123d import import_step

    every = import_step(Path(path)).faces()
    if not every:
        raise InvalidFile(f"{path}: it holds no faces, or is no STEP file.")
    chosen = range(len(every)) if faces is None else faces
    for number in chosen:
        if not 0 <= number < len(every):
            bound = f"lie from 0 to {len(every) - 1}"
            raise InvalidValue("face", number, bound, listed_faces(every))
    coords, triangles = _meshed([every[number] for number in chosen])
    if not len(triangles):
        raise InvalidFile(f"{path}: OpenCASCADE made no triangles of its faces. Export a mesh.")
    return {
        "vertices_coords": coords,
        "faces": triangles,
        "count": np.array(len(chosen)),
        "listed": np.array(listed_faces(every)),
    }


def _meshed(faces: Sequence[Face]) -> tuple[Any, Any]:
    """Points (n, 3) and triangles (m, 3) of faces, points doubled where faces meet."""
    from OCP.BRep import BRep_Tool
    from OCP.BRepBuilderAPI import BRepBuilderAPI_Sewing
    from OCP.BRepMesh import BRepMesh_IncrementalMesh
    from OCP.TopAbs import TopAbs_FACE, TopAbs_Orientation
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopLoc import TopLoc_Location
    from OCP.TopoDS import TopoDS

    low = np.min([[*face.bounding_box().min] for face in faces], axis=0)
    high = np.max([[*face.bounding_box().max] for face in faces], axis=0)
    diagonal = float(np.linalg.norm(high - low))
    sewing = BRepBuilderAPI_Sewing(_SEWN * diagonal)
    for face in faces:
        sewing.Add(face.wrapped)
    sewing.Perform()
    shape = sewing.SewedShape()
    BRepMesh_IncrementalMesh(shape, DEVIATION * diagonal, False, _ANGLE, False)
    coords, triangles, count = [np.empty((0, 3))], [np.empty((0, 3), np.int64)], 0
    seen = TopExp_Explorer(shape, TopAbs_FACE)
    while seen.More():
        face = TopoDS.Face(seen.Current())
        seen.Next()
        place = TopLoc_Location()
        mesh = BRep_Tool.Triangulation_s(face, place)
        if mesh is None:
            continue
        move = place.Transformation()
        nodes = [mesh.Node(k).Transformed(move).Coord() for k in range(1, mesh.NbNodes() + 1)]
        corners = np.array(
            [mesh.Triangle(k).Get() for k in range(1, mesh.NbTriangles() + 1)], np.int64
        ).reshape(-1, 3)
        if face.Orientation() == TopAbs_Orientation.TopAbs_REVERSED:
            corners = corners[:, ::-1]
        coords.append(np.array(nodes).reshape(-1, 3))
        triangles.append(corners - 1 + count)
        count += len(nodes)
    return np.concatenate(coords), np.concatenate(triangles)
