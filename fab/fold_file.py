"""How is a crease pattern written to, and read from, the FOLD format?

Specification: https://github.com/edemaine/fold/blob/main/doc/spec.md (version 1.2).
"""

from __future__ import annotations

import json
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from fab.crease import CreasePattern, assignments, fold_angles_deg
from fab.errors import InvalidFile
from fab.polygons import ring_areas
from solver.errors import InvalidValue
from solver.mesh import edges_of
from solver.vectors import FloatArray, IntArray

__all__ = [
    "FULLY_FOLDED",
    "flat_coords",
    "fold_bytes",
    "frame_coords",
    "frame_faces",
    "frame_list",
    "read_fold",
    "read_frames",
]

# A file over this is refused before it is parsed: it would not fit into memory several times.
_LARGEST_BYTES = 2_000_000_000


# What a crease without an angle (null) folds by, degrees, by its letter.
FULLY_FOLDED = {"M": -180.0, "V": 180.0}


def fold_bytes(pattern: CreasePattern, title: str) -> bytes:
    """The FOLD file: the crease pattern as key frame, the folded form as second frame.

    Coordinates are written with all digits, so that reading gives the same arrays back.
    """
    flat = np.column_stack([pattern.vertices_coords, np.zeros(len(pattern.vertices_coords))])
    corners = pattern.faces_vertices.tolist()
    bounds = pattern.faces_offsets.tolist()
    document: dict[str, Any] = {
        "file_spec": 1.2,
        "file_creator": "quadfold",
        "file_title": title,
        "file_classes": ["singleModel"],
        "frame_title": "crease pattern",
        "frame_classes": ["creasePattern"],
        "frame_attributes": ["2D"],
        "frame_unit": "mm",
        "vertices_coords": flat.tolist(),
        "edges_vertices": pattern.edges_vertices.tolist(),
        "edges_assignment": pattern.edges_assignment.tolist(),
        "edges_foldAngle": pattern.edges_foldAngle.tolist(),
        "faces_vertices": [corners[i:j] for i, j in pairwise(bounds)],
    }
    if pattern.folded_coords is not None:
        document["file_frames"] = [
            {
                "frame_title": "folded form",
                "frame_classes": ["foldedForm"],
                "frame_attributes": ["3D"],
                "frame_unit": "mm",
                "frame_parent": 0,
                "frame_inherit": True,
                "vertices_coords": pattern.folded_coords.tolist(),
            }
        ]
    lines = [f"{json.dumps(key)}: {_value(value)}" for key, value in document.items()]
    return ("{\n" + ",\n".join(lines) + "\n}\n").encode()


def _value(value: object) -> str:
    return json.dumps(value, separators=(",", ":"), allow_nan=False)


def read_fold(path: Path) -> CreasePattern:
    """Read a FOLD file with a flat frame, faces, and (where there is one) a folded frame.

    The key frame, or the first frame of class creasePattern, is the flat sheet; the first frame of
    class foldedForm is the folded form. Without `edges_foldAngle` the angles are those of the
    folded form. Raises `InvalidFile` with the place and the cure.
    """
    flat, folded = read_frames(path)
    coords = flat_coords(path, flat)
    if "faces_vertices" not in flat:
        raise InvalidFile(f"{path}: faces_vertices is missing. Export the file with its faces.")
    corners, offsets = frame_faces(path, flat["faces_vertices"], len(coords))
    corners = _counterclockwise(path, coords, corners, offsets)
    try:
        edges = edges_of(corners, offsets)
        folded_coords = None if folded is None else frame_coords(path, folded, "folded form")
        if folded_coords is not None and len(folded_coords) != len(coords):
            raise InvalidFile(
                f"{path}: the folded form has {len(folded_coords)} vertices, the crease pattern "
                f"{len(coords)}. Both frames must name the same vertices."
            )
        angle = _stored_angles(path, flat, edges.edges_vertices)
        if angle is None:
            if folded_coords is None:
                raise InvalidFile(
                    f"{path}: neither edges_foldAngle nor a folded form. Add one of them."
                )
            angle = fold_angles_deg(folded_coords, edges, corners, offsets)
    except InvalidValue as error:
        raise InvalidFile(f"{path}: {error}") from error
    return CreasePattern(
        np.ascontiguousarray(coords[:, :2]),
        edges.edges_vertices,
        edges.edges_faces,
        assignments(angle, edges),
        angle,
        corners,
        offsets,
        folded_coords,
    )


def read_frames(path: Path) -> tuple[dict[str, Any], dict[str, Any] | None]:
    """The frame of the flat sheet, and that of the folded form where there is one."""
    document = _load(path)
    frames = [document, *frame_list(path, document, "file_frames", [])]
    resolved = _resolved(path, frames)
    flat = _first(resolved, "creasePattern") or resolved[0]
    folded = _first(resolved, "foldedForm")
    return flat, None if folded is flat else folded


def flat_coords(path: Path, flat: dict[str, Any]) -> FloatArray:
    """Points of the flat sheet with z = 0 or nearly so, shape (nv, 3)."""
    coords = frame_coords(path, flat, "crease pattern")
    if np.ptp(coords[:, 2]) > 1e-9 * np.ptp(coords, axis=0).max():
        raise InvalidFile(
            f"{path}: no flat frame: the crease pattern's z runs over {np.ptp(coords[:, 2]):.6g}. "
            "Give a frame of class creasePattern with flat coordinates."
        )
    return coords


def _load(path: Path) -> dict[str, Any]:
    try:
        if path.exists() and not path.is_file():
            raise InvalidFile(f"{path}: not a file. Give the path of a FOLD file.")
        size = path.stat().st_size
        if size > _LARGEST_BYTES:
            raise InvalidFile(
                f"{path}: {size} bytes is over the bound of {_LARGEST_BYTES}. Split the model."
            )
        document = json.loads(path.read_text(encoding="utf-8-sig"))
    except InvalidFile:
        raise
    except OSError as error:
        raise InvalidFile(f"{path}: cannot be read: {error.strerror}. Check the path.") from error
    except (ValueError, RecursionError) as error:  # not JSON, not UTF-8, or endless digits
        raise InvalidFile(f"{path}: not a JSON file: {error}.") from error
    if not isinstance(document, dict):
        raise InvalidFile(f"{path}: a FOLD file is one JSON object, this is not.")
    return document


def frame_list(path: Path, frame: dict[str, Any], key: str, default: list[Any]) -> list[Any]:
    """A list of a frame by its key. Raises `InvalidFile` where it is something else."""
    value = frame.get(key, default)
    if not isinstance(value, list):
        raise InvalidFile(f"{path}: {key} must be a list.")
    return value


def _resolved(path: Path, frames: list[Any]) -> list[dict[str, Any]]:
    """All frames with what they inherit from their parents laid below them."""
    done: dict[int, dict[str, Any]] = {}
    for start in range(len(frames)):
        chain = []
        index = start
        while index not in done:
            frame = frames[index]
            if not isinstance(frame, dict):
                raise InvalidFile(f"{path}: frame {index} must be an object.")
            classes = frame.get("frame_classes", [])
            if not isinstance(classes, list):
                raise InvalidFile(f"{path}: frame_classes of frame {index} must be a list.")
            chain.append(index)
            if index == 0 or not frame.get("frame_inherit"):
                break
            parent = frame.get("frame_parent", 0)
            if type(parent) is not int or not 0 <= parent < len(frames) or parent in chain:
                raise InvalidFile(f"{path}: frame_parent {parent} does not name another frame.")
            index = parent
        for index in reversed(chain):
            own = {key: value for key, value in frames[index].items() if key != "file_frames"}
            inherits = index != 0 and frames[index].get("frame_inherit")
            above = done[frames[index].get("frame_parent", 0)] if inherits else {}
            done[index] = {**above, **own}
    return [done[index] for index in range(len(frames))]


def _first(frames: list[dict[str, Any]], wanted: str) -> dict[str, Any] | None:
    return next((frame for frame in frames if wanted in frame.get("frame_classes", [])), None)


def frame_coords(path: Path, frame: dict[str, Any], what: str) -> FloatArray:
    """The points of a frame, shape (nv, 3); z = 0 where they are plane."""
    rows = frame_list(path, frame, "vertices_coords", [])
    try:
        found = np.array(rows)
    except ValueError:
        found = np.array(["ragged"])
    if rows and found.dtype.kind not in "iuf":
        raise InvalidFile(
            f"{path}: vertices_coords of the {what} must be numbers, all points alike in length."
        )
    coords = found.astype(np.float64)
    if coords.ndim != 2 or coords.shape[1] not in (2, 3) or len(coords) < 3:
        raise InvalidFile(
            f"{path}: vertices_coords of the {what} must hold at least 3 points of 2 or 3 numbers."
        )
    if not np.isfinite(coords).all():
        row = int(np.flatnonzero(~np.isfinite(coords).all(axis=1))[0])
        raise InvalidFile(f"{path}: vertex {row} of the {what} is not finite.")
    return coords if coords.shape[1] == 3 else np.pad(coords, ((0, 0), (0, 1)))


def frame_faces(path: Path, faces: Any, count: int) -> tuple[IntArray, IntArray]:
    """Corners and offsets of faces_vertices whose vertices run up to `count`."""
    if not isinstance(faces, list) or not faces:
        raise InvalidFile(f"{path}: faces_vertices must be a list of at least one face.")
    for number, face in enumerate(faces):
        if not isinstance(face, list) or len(face) < 3:
            raise InvalidFile(f"{path}: face {number} must have at least 3 corners.")
        for v in face:
            if not isinstance(v, int) or isinstance(v, bool) or not 0 <= v < count:
                raise InvalidFile(
                    f"{path}: face {number} names vertex {v}; vertices run from 0 to {count - 1}."
                )
        if len(set(face)) != len(face):
            raise InvalidFile(f"{path}: face {number} passes a vertex twice.")
    offsets = np.concatenate([[0], np.cumsum([len(face) for face in faces])])
    return np.array([v for face in faces for v in face], np.int64), offsets.astype(np.int64)


def _counterclockwise(
    path: Path, coords: FloatArray, corners: IntArray, offsets: IntArray
) -> IntArray:
    """Faces wound counterclockwise in the flat frame, turned around where all are clockwise."""
    areas = ring_areas(coords[corners, :2], offsets)
    if (areas > 0).all():
        return corners
    if (areas < 0).all():
        place = np.arange(len(corners))
        sizes = np.diff(offsets)
        first, last = np.repeat(offsets[:-1], sizes), np.repeat(offsets[1:] - 1, sizes)
        turned: IntArray = corners[first + last - place]
        return turned
    face = int(np.flatnonzero(areas <= 0)[0])
    raise InvalidFile(
        f"{path}: face {face} has the area {areas[face]:.6g}; all faces must have area and be "
        "counterclockwise. Turn it around, or remove it."
    )


def _stored_angles(path: Path, frame: dict[str, Any], wanted: IntArray) -> FloatArray | None:
    """The file's own fold angles in the order of `wanted`; None where it stores none."""
    if "edges_foldAngle" not in frame:
        return None
    pairs = frame_list(path, frame, "edges_vertices", [])
    angles = frame_list(path, frame, "edges_foldAngle", [])
    if len(pairs) != len(angles):
        raise InvalidFile(
            f"{path}: {len(angles)} entries of edges_foldAngle for {len(pairs)} edges."
        )
    letters = frame_list(path, frame, "edges_assignment", ["U"] * len(pairs))
    if len(letters) != len(pairs):
        raise InvalidFile(f"{path}: {len(letters)} edges_assignment for {len(pairs)} edges.")
    known: dict[tuple[int, int], float] = {}
    for number, (pair, angle) in enumerate(zip(pairs, angles, strict=True)):
        if not isinstance(pair, list) or len(pair) != 2 or not all(type(v) is int for v in pair):
            raise InvalidFile(f"{path}: edge {number} must have two vertex numbers.")
        value = FULLY_FOLDED.get(str(letters[number]), 0.0) if angle is None else angle
        if (
            isinstance(value, bool)
            or not isinstance(value, int | float)
            or not -180 <= value <= 180
        ):
            raise InvalidFile(
                f"{path}: fold angle {angle} of edge {number} must lie from -180 to 180 degrees."
            )
        known[min(pair), max(pair)] = float(value)
    out = np.empty(len(wanted))
    for i, (one, two) in enumerate(wanted.tolist()):
        if (min(one, two), max(one, two)) not in known:
            raise InvalidFile(f"{path}: edges_vertices lacks the side ({one}, {two}) of a face.")
        out[i] = known[min(one, two), max(one, two)]
    return out
