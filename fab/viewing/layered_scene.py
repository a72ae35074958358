"""Scenes of sheets that are folded flat, their layers a little apart."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fab.layers.layer_orders import LayerOrders
from fab.pattern.crease_pattern import CreasePattern
from fab.viewing.scene import Scene, Values
from solver.polygons import face_normals
from solver.vectors import FloatArray, IntArray

__all__ = ["layered"]

# Layers are so far apart over the diagonal of the flat sheet, and all of them together no farther.
_STEP_REL, _ALL_REL = 4e-4, 8e-3


def layered(scene: Scene, layers: LayerOrders | None) -> Scene:
    """The scene with the faces of its last state above one another in their order.

    layers : of the pattern of the scene, or of the one whose cuts it opened; the scene stays as it
    is where they have no order. Faces have vertices of their own there; faces and edges keep their
    numbers.
    """
    if layers is None or layers.heights is None or scene.state_count < 2:
        return scene
    pattern = scene.pattern
    corners = pattern.faces_vertices
    heights = layers.heights - (layers.heights.min() + layers.heights.max()) / 2
    diagonal = float(np.hypot(*np.ptp(pattern.vertices_coords, axis=0)))
    step = min(_STEP_REL, _ALL_REL / max(float(np.ptp(heights)), 1.0)) * diagonal
    face = np.repeat(np.arange(pattern.face_count), np.diff(pattern.faces_offsets))
    last = scene.states_coords[-1]
    normals = face_normals(last, corners, pattern.faces_offsets)
    up = np.where(layers.faces_turned[:, None], -normals, normals)
    lift = np.nan_to_num(up)[face] * (step * heights)[:, None]
    source, edges = _own_vertices(pattern, face, heights)
    lift = np.concatenate([lift, np.zeros((len(source) - len(lift), 3))])
    states = scene.states_coords[:, source]
    states[-1] += lift
    folded = pattern.folded_coords
    own = replace(
        pattern,
        vertices_coords=pattern.vertices_coords[source],
        edges_vertices=edges,
        faces_vertices=np.arange(len(corners)),
        folded_coords=None if folded is None else folded[source],
    )
    values = scene.values
    if values is not None and values.of_vertices:
        values = Values(values.values[:, source], values.scale, of_vertices=True)
    return replace(
        scene, pattern=own, states_coords=states, values=values, lift_mm=lift, layer_mm=step
    )


def _own_vertices(
    pattern: CreasePattern, face: IntArray, heights: FloatArray
) -> tuple[IntArray, IntArray]:
    """The vertex that each corner is of, then those of no corner; and the edges by these.

    Edges are at the corners of that of their faces that is farther out, from where they are seen.
    """
    corners, count = pattern.faces_vertices, len(pattern.vertices_coords)
    keys = face * count + corners
    order = np.argsort(keys, kind="stable")
    places = []
    for side in pattern.edges_faces.T:
        wanted = side[:, None] * count + pattern.edges_vertices
        at = order[np.searchsorted(keys[order], wanted).clip(max=len(keys) - 1)]
        places.append(np.where(keys[at] == wanted, at, -1))
    outer = [
        np.where((each >= 0).all(axis=1), np.abs(heights[each]).max(axis=1), -1.0)
        for each in places
    ]
    ends = np.where((outer[0] >= outer[1])[:, None], *places)
    missing = np.flatnonzero(ends.ravel() < 0)
    edges = ends.ravel().copy()
    edges[missing] = len(corners) + np.arange(len(missing))
    source = np.concatenate([corners, pattern.edges_vertices.ravel()[missing]])
    return source, edges.reshape(-1, 2)
