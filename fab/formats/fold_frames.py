"""How is a crease pattern written to the FOLD format, and which frames does a FOLD file have?

Specification: https://github.com/edemaine/fold/blob/main/doc/spec.md (version 1.2).
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fab.errors import InvalidFile
from solver.vectors import FloatArray, IntArray

__all__ = [
    "Frames",
    "State",
    "flat_coords",
    "frame_coords",
    "frame_faces",
    "frame_list",
    "read_frames",
]

# A folded shape by its title and points, shape (nv, 3), mm.
State = tuple[str, FloatArray]

# A file over this is refused before it is parsed: it would not fit into memory several times.
_LARGEST_BYTES = 2_000_000_000
# Tells a simulated state from the folded form; keys with a colon are left to programs.
_STATE = "quadfold:state"


@dataclass(frozen=True)
class Frames:
    """Frames of a file, each with what it inherits.

    Attributes
    ----------
    title : of the file; empty where it has none.
    flat, folded : frames of the flat sheet, and of the folded form where there is one.
    states : other folded frames, in the order of the file.
    """

    title: str
    flat: dict[str, Any]
    folded: dict[str, Any] | None
    states: tuple[dict[str, Any], ...]


def read_frames(path: Path) -> Frames:
    """The frames of a file: the flat sheet is the first of class creasePattern, or else the first
    one with points that is no folded form; the folded form is the first of class foldedForm.

    Raises `InvalidFile` for what is no FOLD file, and one without a flat sheet.
    """
    document = _load(path)
    frames = _resolved(path, [document, *frame_list(path, document, "file_frames", [])])
    title = document.get("file_title")
    folded = [frame for frame in frames if _is(frame, "foldedForm")]
    sheets = [frame for frame in frames if _is(frame, "creasePattern")]
    if not sheets:
        sheets = [f for f in frames if not _is(f, "foldedForm") and "vertices_coords" in f]
    if not sheets and folded:
        raise InvalidFile(
            f"{path}: no flat frame: every frame is a folded form. Give a frame of class "
            "creasePattern with flat coordinates."
        )
    flat = sheets[0] if sheets else frames[0]
    folded = [frame for frame in folded if frame is not flat]
    final = next((frame for frame in folded if _STATE not in frame), None)
    states = tuple(frame for frame in folded if frame is not final)
    return Frames(title if isinstance(title, str) else "", flat, final, states)


def _is(frame: dict[str, Any], wanted: str) -> bool:
    return wanted in frame.get("frame_classes", [])


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
