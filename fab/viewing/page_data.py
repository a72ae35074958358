"""What the script of a result page draws: arrays of a scene, compressed and in base64, as JSON.

Coordinates are float32, numbers of vertices and faces 16 or 32 bits, little-endian.
"""

from __future__ import annotations

import base64
import zlib
from collections.abc import Sequence
from typing import Any

import numpy as np

from fab.errors import Finding
from fab.viewing.face_triangles import face_corner_triangles
from fab.viewing.scene import Scene, SceneBodies
from solver.vectors import FloatArray, IntArray

# Parts that the scale of values has.
_STEPS = 255

__all__ = ["has_face_values", "packed", "page_data", "state_names"]


def page_data(scene: Scene, findings: Sequence[Finding]) -> dict[str, Any]:
    """All that the script needs, as JSON values.

    findings : of the page, of which creases and panels are numbers in the pattern of the scene.
    """
    pattern = scene.pattern
    triangles, faces = face_corner_triangles(pattern)
    return {
        "states": state_names(scene),
        "shares": scene.shares.tolist(),
        "sheet": {
            "positions": packed(scene.states_coords),
            "triangles": packed(pattern.faces_vertices[triangles]),
            "trianglesFace": packed(faces),
            "edges": packed(pattern.edges_vertices),
            "letters": "".join(pattern.edges_assignment.tolist()),
        },
        "values": _values_data(scene),
        "bodies": None if scene.bodies is None else _bodies_data(scene.bodies),
        "pattern": {
            "coords": packed(pattern.vertices_coords),
            "edges": packed(pattern.edges_vertices),
            "corners": packed(pattern.faces_vertices),
            "offsets": packed(pattern.faces_offsets),
            "height": float(pattern.vertices_coords[:, 1].max()),
        },
        "findings": [
            {
                "creases": [e for e in finding.creases if e < len(pattern.edges_vertices)],
                "panels": [f for f in finding.panels if f < pattern.face_count],
            }
            for finding in findings
        ],
    }


def state_names(scene: Scene) -> list[str]:
    """What the slider calls each state."""
    if scene.bodies is not None:
        return list(scene.bodies.state_names)
    shares = scene.shares.tolist()
    return ["flat" if share == 0 else f"{share:.0%} of the fold" for share in shares]


def has_face_values(scene: Scene) -> bool:
    """Whether the sheet is coloured by values of its faces, from none to large ones."""
    values = scene.values
    return values is not None and not values.of_vertices and not values.scale.signed


def _values_data(scene: Scene) -> dict[str, Any] | None:
    """Where the values of faces are on their scale in all states, in 255 steps."""
    if not has_face_values(scene):
        return None
    values = scene.values
    assert values is not None
    shares = [values.scale.shares(values.in_state(k)) for k in range(scene.state_count)]
    return {"shares": packed(np.rint(_STEPS * np.stack(shares)).astype(np.int64))}


def packed(array: FloatArray | IntArray) -> dict[str, str]:
    r"""An array by zlib and in base64, with the kind of its numbers.

    >>> entry = packed(np.array([1, 2]))
    >>> entry["kind"], zlib.decompress(base64.b64decode(entry["zlib"]))
    ('u16', b'\x01\x00\x02\x00')
    """
    if array.dtype.kind == "f":
        kind = "f32"
    else:
        kind = "u16" if int(array.max(initial=0)) <= np.iinfo(np.uint16).max else "u32"
    data = np.ascontiguousarray(array, dtype=f"<{kind[0]}{int(kind[1:]) // 8}")
    return {"kind": kind, "zlib": base64.b64encode(zlib.compress(data.tobytes(), 9)).decode()}


def _bodies_data(bodies: SceneBodies) -> dict[str, Any]:
    """Bodies that move with a face, or in halves with two; the others stay out.

    Triangles and edges have numbers of the vertices of their own body: many bodies are alike.
    """
    from scipy.spatial.transform import Rotation

    chosen = np.flatnonzero((bodies.faces >= 0) | (bodies.creases >= 0))
    own = bodies.bodies.chosen(chosen)
    vertices = np.isin(bodies.bodies.vertices_body, chosen)
    colours, of_body = np.unique(bodies.colours[chosen], axis=0, return_inverse=True)
    states, faces = bodies.shifts.shape[:2]
    poses = np.empty((states, faces, 7))
    turns = bodies.turns.reshape(-1, 3, 3)
    poses[:, :, :4] = Rotation.from_matrix(turns).as_quat().reshape(states, faces, 4)
    poses[:, :, 4:] = bodies.shifts
    edges = _outlines(own.triangles, own.triangles_plane)
    edges = edges[bodies.faces[chosen][own.vertices_body[edges[:, 0]]] >= 0]  # of panels alone
    edges_body = own.vertices_body[edges[:, 0]]
    return {
        "positions": packed(own.vertices_coords),
        "verticesFace": packed(bodies.vertices_face[vertices]),
        "poses": packed(poses),
        "verticesCount": packed(np.diff(own.vertices_offsets)),
        "triangles": packed(own.triangles - own.vertices_offsets[own.triangles_body][:, None]),
        "trianglesCount": packed(np.diff(own.triangles_offsets)),
        "edges": packed(edges - own.vertices_offsets[edges_body][:, None]),
        "edgesCount": packed(np.bincount(edges_body, minlength=len(own))),
        "panels": bodies.faces[chosen].tolist(),
        "creases": bodies.creases[chosen].tolist(),
        "colours": [_hex(colour) for colour in colours],
        "bodiesColour": of_body.ravel().tolist(),
    }


def _outlines(triangles: IntArray, plane: IntArray) -> IntArray:
    """Edges between planar sides of different planes, shape (k, 2)."""
    pairs = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    owner = np.repeat(plane, 3)
    edges, number = np.unique(pairs, axis=0, return_inverse=True)
    low, high = np.full(len(edges), np.iinfo(np.int64).max), np.full(len(edges), -1)
    np.minimum.at(low, number.ravel(), owner)
    np.maximum.at(high, number.ravel(), owner)
    return np.asarray(edges[low != high])


def _hex(colour: FloatArray) -> str:
    red, green, blue = np.rint(255 * np.clip(colour, 0, 1)).astype(int).tolist()
    return f"#{red:02x}{green:02x}{blue:02x}"
