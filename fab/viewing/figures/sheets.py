"""A sheet as figures show it: folded in space, flat with its creases, and the order it grew in."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from fab.pattern.crease_pattern import CreasePattern, crease_pattern
from fab.pattern.development import develop
from fab.viewing.camera import fitted
from fab.viewing.figures.canvas import INK
from fab.viewing.painting import painted
from fab.viewing.scene_builders import laid_flat
from fab.viewing.shapes import Triangles, sheet_shapes, sheet_triangles
from fab.viewing.view_choice import best_view
from solver.growth_order import faces_strip
from solver.mesh import QuadMesh
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["ShownSheet", "draw_flat", "draw_folded", "paint", "shown_sheet"]

_MARGIN = 6


@dataclass(frozen=True)
class ShownSheet:
    """A sheet with what its pictures need.

    Attributes
    ----------
    name : in titles.
    pattern : in design units; closed sheets are cut open.
    steps : the step of growth that made each face, shape (nf,).
    triangles : over its faces.
    view : axes of the camera, shape (3, 3).
    """

    name: str
    pattern: CreasePattern
    steps: IntArray
    triangles: Triangles
    view: FloatArray

    @property
    def folded_coords(self) -> FloatArray:
        """Vertices of the folded form, shape (nv, 3)."""
        assert self.pattern.folded_coords is not None  # `shown_sheet` gives one
        return self.pattern.folded_coords


def shown_sheet(mesh: QuadMesh, name: str, *, upright: bool = False) -> ShownSheet:
    """A grown sheet, seen from where most of it shows.

    upright : whether z is upwards; else its longest directions lie flat. Raises as `develop`.
    """
    steps = faces_strip(mesh)
    opened = mesh.cut_open()
    pattern = crease_pattern(opened, develop(opened), 1.0)
    triangles = sheet_triangles(pattern)
    coords = opened.vertices_coords
    turn = np.eye(3) if upright else laid_flat(pattern, coords)[0]
    corners = (coords @ turn.T)[triangles.vertices]
    view = best_view([corners], triangles.faces, upright=upright) @ turn
    return ShownSheet(name, pattern, steps, triangles, view)


def draw_folded(
    axes: Any, sheet: ShownSheet, shown: BoolArray | None = None, *, finer: int = 1
) -> None:
    """The folded form, in a frame that holds all of it; shown : faces that are drawn, (nf,).

    finer : pixels of its image along a pixel of the figure.
    """
    coords = sheet.folded_coords
    paint(axes, sheet.view, coords, sheet.triangles, coords, shown, finer=finer)


def paint(
    axes: Any,
    view: FloatArray,
    coords: FloatArray,
    triangles: Triangles,
    extent: FloatArray,
    shown: BoolArray | None = None,
    *,
    finer: int = 1,
) -> None:
    """Paint the faces of a sheet as an image that fills axes; what is nearer hides what is further.

    view : axes of a camera, which shows all points of `extent`, shape (n, 3). finer : pixels of the
    image along a pixel of the figure.
    """
    box = axes.bbox
    width, height = (max(1, finer * round(side)) for side in (box.width, box.height))
    view_of_all = fitted(view, extent, width, height, finer * _MARGIN)
    image = np.ones((height, width, 3))
    kept = slice(None) if shown is None else shown[triangles.faces]
    drawn = Triangles(triangles.vertices[kept], triangles.faces[kept])
    if len(drawn.faces):
        image = painted(view_of_all, [sheet_shapes(coords, drawn)])
    axes.imshow(image, interpolation="antialiased", extent=(0, width, 0, height))


def draw_flat(axes: Any, sheet: ShownSheet, shown: BoolArray | None = None) -> None:
    """The crease pattern: mountains red, valleys blue, in a frame that holds all of it."""
    from matplotlib.collections import LineCollection

    pattern = sheet.pattern
    first, second = pattern.edges_faces.T
    drawn = np.ones(pattern.face_count, bool) if shown is None else shown
    beside = np.stack([drawn[first], (second >= 0) & drawn[second]])
    width = float(np.clip(30 / np.sqrt(len(pattern.edges_vertices)), 0.15, 1.2))
    for letter in "FMVB":
        own = pattern.edges_assignment == letter
        creases = own & beside.all(axis=0)
        rim = beside.any(axis=0) & ~beside.all(axis=0) & (own | (letter == "B"))
        for edges, ink in ((creases, INK[letter]), (rim, INK["B"])):
            lines = pattern.vertices_coords[pattern.edges_vertices[edges]]
            axes.add_collection(LineCollection(lines, colors=ink, linewidths=width))
    low, high = pattern.vertices_coords.min(axis=0), pattern.vertices_coords.max(axis=0)
    space = 0.03 * float((high - low).max())
    axes.set_xlim(low[0] - space, high[0] + space)
    axes.set_ylim(low[1] - space, high[1] + space)
