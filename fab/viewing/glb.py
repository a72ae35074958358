"""GLB files (binary glTF 2.0) of a sheet and of its thick bodies, with the animation of their fold.

glTF has metres and y upwards; scenes have millimetres and z upwards. The folded form is one mesh
whose morph targets are the states after the flat one. Of thick sheets every rigid body is a node of
its own that moves; webs bend, and are one mesh with morph targets. Viewers without animations show
the last state.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fab.geometry.bodies import TriangleMesh
from fab.pattern.crease_pattern import CreasePattern
from fab.viewing.face_triangles import face_corner_triangles
from fab.viewing.scene import Scene, SceneBodies
from solver.errors import InvalidState
from solver.polygons import face_normals
from solver.vectors import FloatArray, IntArray, cross, unit

if TYPE_CHECKING:
    from fab.viewing.gltf_document import Channels, GltfDocument

__all__ = ["bodies_glb_bytes", "sheet_glb_bytes"]

# Columns of coordinates in glTF, x, z and -y, from those of a scene.
_AXES = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
_METRES_PER_MM = 1e-3
_UP = np.array([0.0, 1.0, 0.0])
_SECONDS = 4.0
_APART_REL = 2e-4
# To which coordinates of panels are rounded, so that panels that are alike are so to the last bit;
# off the middle between two steps, where coordinates of few digits often are.
_DECIMALS_MM = 5
_OFF_MIDDLE = 0.1180339887
# Linear red, green, blue and opacity.
_UPPER, _LOWER = (0.91, 0.67, 0.34, 1.0), (0.34, 0.5, 0.71, 1.0)
_LINES = {
    "B": (0.01, 0.01, 0.01, 1.0),
    "M": (0.67, 0.01, 0.01, 1.0),
    "V": (0.01, 0.08, 0.67, 1.0),
    "F": (0.4, 0.4, 0.4, 1.0),
    "U": (0.6, 0.05, 0.6, 1.0),
    "C": (0.02, 0.4, 0.05, 1.0),
    "J": (0.6, 0.6, 0.6, 1.0),
}
_LINES_MODE = 1


def sheet_glb_bytes(scene: Scene) -> bytes:
    """The sheet of a scene: upper and lower sides, creases by assignment, and its fold.

    Sides are two primitives that look away from each other, each face flat; creases are lines. The
    lower side is under the upper one by 1/5000 of the sheet's diagonal, as programs that trace rays
    otherwise show both in patches. All states after the flat one are morph targets, named by the
    share of the fold, which the animation "fold" goes through in 4 seconds.
    """
    from pygltflib import Attributes, Primitive

    from fab.viewing.gltf_document import GltfDocument

    pattern = scene.pattern
    document = GltfDocument()
    states = _in_metres(scene.states_coords)
    corners = pattern.faces_vertices
    triangles, _ = face_corner_triangles(pattern)
    normals = np.stack([_corner_normals(pattern, coords) for coords in states])
    diagonal_mm = float(np.hypot(*np.ptp(pattern.vertices_coords, axis=0)))
    apart_mm = _APART_REL * diagonal_mm
    if scene.layer_mm:  # no side reaches the next layer
        apart_mm = min(apart_mm, scene.layer_mm / 3)
    apart = _METRES_PER_MM * apart_mm
    sides = (("upper side", _UPPER, 1.0, 0.0), ("lower side", _LOWER, -1.0, apart))
    primitives = []
    for name, colour, sign, under in sides:
        places = _changes(states[:, corners] - under * normals)
        first, *others = [
            Attributes(
                POSITION=document.positions(place), NORMAL=document.directions(sign * normal)
            )
            for place, normal in zip(places, _changes(normals), strict=True)
        ]
        primitives.append(
            Primitive(
                attributes=first,
                indices=document.numbers(triangles if sign > 0 else triangles[:, ::-1]),
                material=document.material(name, colour),
                targets=others,
            )
        )
    first, *others = [Attributes(POSITION=document.positions(rows)) for rows in _changes(states)]
    for letter, colour in _LINES.items():
        edges = pattern.edges_vertices[pattern.edges_assignment == letter]
        if len(edges):
            primitives.append(
                Primitive(
                    attributes=first,
                    indices=document.numbers(edges),
                    material=document.material(f"edges {letter}", colour),
                    mode=_LINES_MODE,
                    targets=others,
                )
            )
    targets = [f"{share:.4g}" for share in scene.shares[1:].tolist()]
    node = document.node(scene.name, document.mesh(scene.name, primitives, targets))
    if targets:
        document.animate("fold", _times(len(states)), {node: _weights(len(states))})
    return document.glb_bytes()


def bodies_glb_bytes(scene: Scene) -> bytes:
    """The thick bodies of a scene: a node for each rigid one, one mesh for all that bend.

    Nodes turn about the middle of their body. Webs bend from state to state as morph targets, each
    half with the panel on its side. Bodies that lie under many panels, as films do, are left out.
    Raises `InvalidState` for a scene without bodies.
    """
    from fab.viewing.gltf_document import GltfDocument

    bodies = scene.bodies
    if bodies is None:
        raise InvalidState("scene", "it has no thick bodies", "Thicken the sheet first.")
    document = GltfDocument()
    rigid = np.flatnonzero(bodies.faces >= 0)
    bending = np.flatnonzero((bodies.faces < 0) & (bodies.creases >= 0))
    shown = np.concatenate([rigid, bending])
    colours, of_shown = np.unique(bodies.colours[shown], axis=0, return_inverse=True)
    materials = [
        document.material(f"bodies {number + 1}", (*_linear(colour).tolist(), 1.0))
        for number, colour in enumerate(colours)
    ]
    material = np.full(len(bodies.faces), -1)
    material[shown] = np.array(materials)[of_shown.ravel()]
    channels: dict[int, Channels] = {}
    alike: dict[bytes, TriangleMesh] = {}
    for body in rigid.tolist():
        channels |= _rigid_node(document, bodies, body, int(material[body]), alike)
    if len(bending):
        channels |= _bending_node(document, bodies, bending, material)
    count = len(bodies.turns)
    if count > 1:
        document.animate("fold", _times(count), channels)
    return document.glb_bytes()


def _rigid_node(
    document: GltfDocument,
    bodies: SceneBodies,
    body: int,
    material: int,
    alike: dict[bytes, TriangleMesh],
) -> dict[int, Channels]:
    """A node for a rigid body, at its last pose, and how it moves.

    alike : bodies before it around their middles, by their vertices: one that has the same takes
    the triangles of that, which rounding may have cut in another way. It is added to.
    """
    from pygltflib import Attributes, Primitive
    from scipy.spatial.transform import Rotation

    mesh, face, name = bodies.bodies.mesh(body), int(bodies.faces[body]), bodies.names[body]
    middle = (mesh.vertices_coords.min(axis=0) + mesh.vertices_coords.max(axis=0)) / 2
    turns, shifts = bodies.turns[:, face], bodies.shifts[:, face]
    places = _in_metres(turns @ middle + shifts)
    quaternions = _without_jumps(Rotation.from_matrix(_AXES @ turns @ _AXES.T).as_quat())
    local = _stepped(mesh.vertices_coords - middle)
    mesh = alike.setdefault(
        local.tobytes(), TriangleMesh(local, mesh.triangles, mesh.triangles_plane)
    )
    triangles, vertices, plane = _unshared(mesh.triangles, mesh.triangles_plane)
    coords = _in_metres(local[vertices])
    primitive = Primitive(
        attributes=Attributes(
            POSITION=document.positions(coords),
            NORMAL=document.directions(_plane_normals(coords, triangles, plane)),
        ),
        indices=document.numbers(triangles),
        material=material,
    )
    number = document.node(
        name, document.mesh(name, [primitive]), places[-1].tolist(), quaternions[-1].tolist()
    )
    return {number: {"translation": places, "rotation": quaternions}}


def _stepped(coords: FloatArray) -> FloatArray:
    """Coordinates on steps of 1e-5 mm, at most 0.62 of one away, without negative zeros."""
    steps = np.floor(coords * 10.0**_DECIMALS_MM + (0.5 + _OFF_MIDDLE))
    return np.asarray(np.round(steps / 10.0**_DECIMALS_MM, _DECIMALS_MM) + 0.0)


def _bending_node(
    document: GltfDocument, bodies: SceneBodies, numbers: IntArray, material: IntArray
) -> dict[int, Channels]:
    """One node for all bodies that bend, with a primitive for each material.

    Their sides bend too, so that they have no normals: viewers then show every triangle flat.
    """
    from pygltflib import Attributes, Primitive

    owner = bodies.bodies.triangles_body
    states = np.stack([_in_metres(bodies.coords_in(k)) for k in range(len(bodies.turns))])
    primitives = []
    for each in np.unique(material[numbers]).tolist():
        chosen = np.isin(owner, numbers[material[numbers] == each])
        vertices, triangles = np.unique(bodies.bodies.triangles[chosen], return_inverse=True)
        first, *others = [
            Attributes(POSITION=document.positions(rows)) for rows in _changes(states[:, vertices])
        ]
        primitives.append(
            Primitive(
                attributes=first,
                indices=document.numbers(triangles),
                material=each,
                targets=others,
            )
        )
    mesh = document.mesh("hinges", primitives, bodies.state_names[1:])
    return {document.node("hinges", mesh): _weights(len(states))}


def _in_metres(coords: FloatArray) -> FloatArray:
    """Coordinates of glTF from those of a scene, shapes (..., 3)."""
    return np.asarray(coords @ _AXES.T * _METRES_PER_MM)


def _linear(colour: FloatArray) -> FloatArray:
    """A colour of screens (sRGB), each part 0 to 1, in linear light."""
    return np.asarray(
        np.where(colour <= 0.04045, colour / 12.92, ((colour + 0.055) / 1.055) ** 2.4)
    )


def _changes(states: FloatArray) -> list[FloatArray]:
    """The first state, then how the others differ from it, shape (n, ...)."""
    return [states[0], *(states[1:] - states[0])]


def _times(count: int) -> FloatArray:
    return np.linspace(0.0, _SECONDS, count)


def _weights(count: int) -> Channels:
    """Of the morph targets of `count` states: none at the first time, then one after another."""
    return {"weights": np.eye(count)[:, 1:].ravel()}


def _without_jumps(quaternions: FloatArray) -> FloatArray:
    """Quaternions (n, 4) of the same rotations, each on the side of the one before."""
    sides = np.sign((quaternions[1:] * quaternions[:-1]).sum(axis=1))
    sides[sides == 0] = 1.0
    return quaternions * np.cumprod([1.0, *sides])[:, None]


def _corner_normals(pattern: CreasePattern, coords: FloatArray) -> FloatArray:
    """The unit normal of the face of every entry of `faces_vertices`; upwards without an area."""
    with np.errstate(invalid="ignore", divide="ignore"):
        normals = face_normals(coords, pattern.faces_vertices, pattern.faces_offsets)
    normals[~np.isfinite(normals).all(axis=1)] = _UP
    return np.repeat(normals, np.diff(pattern.faces_offsets), axis=0)


def _unshared(triangles: IntArray, plane: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Triangles (nt, 3) that share no vertices across planes, and of which vertices theirs are.

    Also the plane of each triangle, numbered from 0.
    """
    _, plane = np.unique(plane, return_inverse=True)
    count = int(triangles.max(initial=0)) + 1
    keys, place = np.unique(plane.reshape(-1, 1) * count + triangles, return_inverse=True)
    return place.reshape(-1, 3), keys % count, plane.ravel()


def _plane_normals(coords: FloatArray, triangles: IntArray, plane: IntArray) -> FloatArray:
    """The unit normal of the plane of every vertex, upwards where it has no area, shape (nv, 3)."""
    a, b, c = coords[triangles].swapaxes(0, 1)
    areas = cross(b - a, c - a)
    sums = np.zeros((int(plane.max()) + 1, 3))
    np.add.at(sums, plane, areas)
    with np.errstate(invalid="ignore", divide="ignore"):
        normals = unit(sums)
    normals[~np.isfinite(normals).all(axis=1)] = _UP
    out = np.empty_like(coords)
    out[triangles] = normals[plane][:, None]
    return out
