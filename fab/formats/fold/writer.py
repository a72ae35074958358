"""The bytes of a FOLD file."""

from __future__ import annotations

import json
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from fab.formats.fold.face_orders import face_orders
from fab.formats.fold.frames import SEAM_KEY, STATE_KEY
from fab.formats.pattern_file import State
from fab.pattern.crease_pattern import CreasePattern, fold_angles_deg
from fab.pattern.meeting_rims import meeting_rims
from solver.errors import InvalidState, InvalidValue
from solver.vectors import FloatArray, IntArray

__all__ = ["fold_bytes"]


def fold_bytes(
    pattern: CreasePattern,
    title: str,
    states: Sequence[State] = (),
    orders: IntArray | None = None,
) -> bytes:
    """The FOLD file: the crease pattern as key frame, then the folded form and other states.

    states : titles and points (nv, 3), mm, each with the fold angles that it has (cuts have none).
        Raises `InvalidValue` for points that do not fit, or faces without area.
    orders : rows of faceOrders of the folded form, shape (n, 3), of all faces that overlap; where
        left out, those that `face_orders` knows. Without a folded form the sheet has them.

    Coordinates are written with all digits, so that reading gives the same arrays back. A folded
    form in a plane has `faceOrders`. Where rims of several sheets meet, vertices that are glued
    together have the same number in `quadfold:vertices_seam`; others have 0.
    """
    flat = np.column_stack([pattern.vertices_coords, np.zeros(len(pattern.vertices_coords))])
    corners = pattern.faces_vertices.tolist()
    bounds = pattern.faces_offsets.tolist()
    document: dict[str, Any] = {
        "file_spec": 1.2,
        "file_creator": "quadfold",
        "file_title": title,
        "file_classes": ["animation"] if states else ["singleModel"],
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
    meeting = meeting_rims(pattern)
    if pattern.folded_coords is None and orders is not None and len(orders):
        document["faceOrders"] = orders.tolist()
    if meeting is not None:
        document[SEAM_KEY] = meeting.vertices_seam(len(flat)).tolist()
    frames = []
    if pattern.folded_coords is not None:
        frame = _folded_frame("folded form", pattern.folded_coords)
        orders = face_orders(pattern) if orders is None else orders
        frames.append({**frame, "faceOrders": orders.tolist()} if len(orders) else frame)
    for name, coords in states:
        _require_points(name, coords, len(flat))
        angles = _angles_of(pattern, coords).tolist()
        frames.append({**_folded_frame(name, coords), STATE_KEY: True, "edges_foldAngle": angles})
    if frames:
        document["file_frames"] = frames
    lines = [f"{json.dumps(key)}: {_value(value)}" for key, value in document.items()]
    return ("{\n" + ",\n".join(lines) + "\n}\n").encode()


def _folded_frame(title: str, coords: FloatArray) -> dict[str, Any]:
    return {
        "frame_title": title,
        "frame_classes": ["foldedForm"],
        "frame_attributes": ["3D"],
        "frame_unit": "mm",
        "frame_parent": 0,
        "frame_inherit": True,
        "vertices_coords": coords.tolist(),
    }


def _require_points(title: str, coords: FloatArray, count: int) -> None:
    if coords.shape != (count, 3):
        cure = "Give a point for each vertex of the pattern."
        raise InvalidValue(f"state {title!r}", coords.shape, f"have the shape ({count}, 3)", cure)
    bad = np.flatnonzero(~np.isfinite(coords).all(axis=1))
    if len(bad):
        cure = "Leave states out that did not come to rest."
        raise InvalidState("coords", f"vertex {bad[0]} of state {title!r} is not finite", cure)


def _angles_of(pattern: CreasePattern, coords: FloatArray) -> FloatArray:
    """Fold angles of a state, with the signs of the letters where it is folded flat."""
    letters = pattern.edges_assignment
    angles = fold_angles_deg(coords, pattern.edges, pattern.faces_vertices, pattern.faces_offsets)
    angles[(letters == "M") & (angles == 180.0)] = -180.0
    angles[letters == "C"] = 0.0
    return angles


def _value(value: object) -> str:
    return json.dumps(value, separators=(",", ":"), allow_nan=False)
