"""Views of thick bodies, flat and folded, each part of them in its colour."""

from __future__ import annotations

import numpy as np

from fab.viewing.assembly.parts import Model
from fab.viewing.assembly.piece_colours import paler
from fab.viewing.camera import fitted
from fab.viewing.painting import Shapes, painted
from fab.viewing.scene import Scene
from fab.viewing.shapes import body_shapes
from fab.viewing.sketch import Image, Sketch
from fab.viewing.view_choice import best_view
from solver.vectors import FloatArray

__all__ = ["body_views"]

_PIXELS_PER_MM = 5.0
_LOWER_PALE = 0.6
# Sides of bodies that look down when they lie flat.
_DOWN = -0.999


def body_views(
    scene: Scene, model: Model, state: int, most_mm: tuple[float, float]
) -> tuple[Sketch, Sketch]:
    """The bodies of a scene in one of its states, from two opposite sides."""
    bodies = scene.bodies
    assert bodies is not None  # it is a scene of a thick sheet
    coords = bodies.coords_in(state)
    shapes = body_shapes(bodies, coords)
    if not model.alone:
        shapes = _by_parts(scene, model, coords, shapes)
    owner = bodies.faces[bodies.bodies.triangles_body]
    corners = coords[bodies.bodies.triangles]
    panels = (owner >= 0) & np.isfinite(corners).all(axis=(1, 2))
    right, up, toward = best_view([corners[panels]], owner[panels], upright=scene.upright)
    name = bodies.state_names[state]
    front = _view(np.stack([right, up, toward]), shapes, most_mm, f"{name.capitalize()}.")
    behind = np.stack([-right, up, -toward])
    return front, _view(behind, shapes, most_mm, "The same from behind.")


def _by_parts(scene: Scene, model: Model, coords: FloatArray, shapes: Shapes) -> Shapes:
    """The shapes with panels in the colours of the parts that they belong to."""
    bodies = scene.bodies
    assert bodies is not None
    owner = bodies.bodies.triangles_body
    corners = coords[bodies.bodies.triangles]
    known = np.isfinite(corners).all(axis=(1, 2))
    face = bodies.faces[owner]
    part = np.where(face >= 0, model.faces_piece[face], -1)
    flat = bodies.bodies.vertices_coords[bodies.bodies.triangles]
    normal = np.cross(flat[:, 1] - flat[:, 0], flat[:, 2] - flat[:, 0])
    down = normal[:, 2] < _DOWN * np.linalg.norm(normal, axis=1)
    colours = np.where(
        (part >= 0)[:, None],
        np.where(down[:, None], paler(model.colours[part], _LOWER_PALE), model.colours[part]),
        bodies.colours[owner],
    )[known]
    return Shapes(shapes.corners, colours, colours, shapes.groups, closed=True)


def _view(axes: FloatArray, shapes: Shapes, most_mm: tuple[float, float], caption: str) -> Sketch:
    points = shapes.corners.reshape(-1, 3)
    span = np.maximum(np.ptp(points @ axes[:2].T, axis=0), 1e-9)
    room = np.array(most_mm) * _PIXELS_PER_MM
    scale = float((room / span).min())
    width, height = (max(8, int(side)) for side in np.ceil(span * scale).tolist())
    camera = fitted(axes, points, width, height, 1)
    picture = np.round(255 * painted(camera, [shapes])).astype(np.uint8)
    paper = (width / _PIXELS_PER_MM, height / _PIXELS_PER_MM)
    return Sketch(paper, (Image(picture, (0.0, 0.0), paper),), caption)
