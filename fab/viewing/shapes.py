"""Triangles of a scene with their colours: its sheet, its bodies, the surface it follows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fab.geometry.bodies import Bodies
from fab.pattern.crease_pattern import CreasePattern
from fab.viewing.canvas import colour_map
from fab.viewing.face_triangles import face_corner_triangles
from fab.viewing.painting import Shapes, triangle_normals
from fab.viewing.scene import SceneBodies, Surface, Values
from solver.vectors import FloatArray, IntArray

__all__ = [
    "Triangles",
    "body_shapes",
    "sheet_shapes",
    "sheet_triangles",
    "solid_shapes",
    "surface_shapes",
    "valued_shapes",
]

_UPPER, _LOWER = np.array([0.97, 0.86, 0.65]), np.array([0.60, 0.74, 0.88])
_SURFACE = np.array([0.80, 0.80, 0.78])
# Colours that stand for values are lit so evenly that they are recognised.
_DARKEST_VALUE = 0.82
# Sides of a flat body that look down.
_DOWN = -0.999


@dataclass(frozen=True)
class Triangles:
    """Triangles over the faces of a sheet: vertices (n, 3), and the face of each (n,)."""

    vertices: IntArray
    faces: IntArray


def sheet_triangles(pattern: CreasePattern) -> Triangles:
    """Triangles over all faces."""
    entries, faces = face_corner_triangles(pattern)
    return Triangles(pattern.faces_vertices[entries], faces)


def sheet_shapes(coords: FloatArray, triangles: Triangles) -> Shapes:
    """A sheet with its vertices at `coords`, shape (nv, 3): sand above, blue below."""
    count = len(triangles.faces)
    upper, lower = np.tile(_UPPER, (count, 1)), np.tile(_LOWER, (count, 1))
    return Shapes(coords[triangles.vertices], upper, lower, triangles.faces)


def valued_shapes(coords: FloatArray, triangles: Triangles, values: Values, state: int) -> Shapes:
    """The same in the colours that its values have in a state."""
    own = values.in_state(state)
    own = own[triangles.vertices].mean(axis=1) if values.of_vertices else own[triangles.faces]
    colours = colour_map(values.scale)
    number = np.minimum((values.scale.shares(own) * len(colours)).astype(int), len(colours) - 1)
    ink = colours[number]
    return Shapes(coords[triangles.vertices], ink, ink, triangles.faces, darkest=_DARKEST_VALUE)


def surface_shapes(surface: Surface) -> Shapes:
    """A surface in grey, which yields to a sheet that follows it."""
    corners = surface.vertices_coords[surface.triangles]
    grey = np.tile(_SURFACE, (len(corners), 1))
    groups = np.full(len(corners), -1)
    return Shapes(corners, grey, grey, groups, behind_mm=2 * surface.farthest_mm)


def body_shapes(bodies: SceneBodies, coords: FloatArray) -> Shapes:
    """Thick bodies with their vertices at `coords`: panels sand above and blue below, hinges in
    their own colours.

    Those that are not finite are left out.
    """
    owner = bodies.bodies.triangles_body
    down = triangle_normals(bodies.bodies.vertices_coords[bodies.bodies.triangles])[:, 2] < _DOWN
    panel = bodies.faces[owner] >= 0
    colours = np.where(
        panel[:, None], np.where(down[:, None], _LOWER, _UPPER), bodies.colours[owner]
    )
    return _drawn(bodies.bodies, coords, colours)


def solid_shapes(solids: Bodies, colours: FloatArray) -> Shapes:
    """Solids, each in one colour; colours : shape (n, 3)."""
    return _drawn(solids, solids.vertices_coords, colours[solids.triangles_body])


def _drawn(solids: Bodies, coords: FloatArray, colours: FloatArray) -> Shapes:
    corners = coords[solids.triangles]
    known = np.isfinite(corners).all(axis=(1, 2))
    return Shapes(
        corners[known], colours[known], colours[known], solids.triangles_plane[known], closed=True
    )
