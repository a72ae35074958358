"""Meshes of polygons in OBJ files."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from fab.errors import InvalidFile
from fab.formats.source_files import source_bytes
from fab.outputs import plain_title
from solver.vectors import FloatArray, IntArray

__all__ = ["LARGEST_BYTES", "ObjMesh", "obj_bytes", "read_obj"]


# About 2 million vertices.
LARGEST_BYTES = 200_000_000


@dataclass(frozen=True)
class ObjMesh:
    """Points and faces of an OBJ file; its normals, textures, groups and lines are passed over.

    Attributes
    ----------
    vertices_coords : shape (nv, 3).
    faces_vertices : corners of each face, from 0.
    """

    vertices_coords: FloatArray
    faces_vertices: list[list[int]]


def read_obj(path: Path) -> ObjMesh:
    """Read an OBJ file with all its polygons as they are.

    Raises `InvalidFile` with the line for what cannot be read, and for points that are not finite.
    """
    text = source_bytes(path, LARGEST_BYTES).decode("utf-8-sig", "replace")
    points: list[list[float]] = []
    faces: list[list[int]] = []
    for number, line in _whole_lines(text):
        key, *words = line.split() or [""]
        try:
            if key == "v":
                points.append([float(word) for word in words[:3]])
                if len(points[-1]) != 3 or not np.isfinite(points[-1]).all():
                    raise ValueError
            elif key == "f":
                faces.append([_corner(word, len(points)) for word in words])
        except ValueError:
            what = {"v": "a point needs 3 finite numbers", "f": "a face needs numbers of points"}
            raise InvalidFile(
                f"{path}: line {number}: {what[key]}, not {line.strip()[:60]!r}. Export it again."
            ) from None
    if not faces:
        raise InvalidFile(f"{path}: no faces. Export the mesh with its faces (lines f).")
    return ObjMesh(np.array(points).reshape(-1, 3), faces)


def _whole_lines(text: str) -> Iterator[tuple[int, str]]:
    """Lines and where they begin: one that ends in a backslash goes on in the next, as of Rhino.

    Comments do not: folders of Windows end in one.
    """
    begun: list[str] = []
    for number, line in enumerate(text.splitlines(), 1):
        if line.endswith("\\") and not line.startswith("#"):
            begun.append(line[:-1])
            continue
        yield number - len(begun), " ".join([*begun, line])
        begun.clear()
    if begun:
        yield number - len(begun) + 1, " ".join(begun)


def _corner(word: str, count: int) -> int:
    """Vertex from 0 of such as 3, 3/1, 3//2 or -1, the last one so far."""
    number = int(word.partition("/")[0])
    if number == 0:
        raise ValueError(word)
    return number - 1 if number > 0 else count + number


def obj_bytes(
    vertices_coords: FloatArray, faces_vertices: IntArray, faces_offsets: IntArray, title: str
) -> bytes:
    """The OBJ file, all digits of the points, shape (nv, 3), and polygons of any size."""
    lines = [f"# {plain_title(title)}"]
    lines += ["v " + " ".join(map(repr, point)) for point in vertices_coords.tolist()]
    corners = (faces_vertices + 1).tolist()
    lines += ["f " + " ".join(map(str, corners[i:j])) for i, j in pairwise(faces_offsets.tolist())]
    return ("\n".join(lines) + "\n").encode()
