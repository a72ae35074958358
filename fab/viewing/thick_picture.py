"""Pictures of thick sheets: panels and hinges, flat and folded, and the plates of a printer."""

from __future__ import annotations

import numpy as np

from fab.geometry.bodies import Bodies, bodies_of
from fab.printing.plates import Plates
from fab.viewing.camera import Camera, view_axes
from fab.viewing.canvas import Box, Canvas
from fab.viewing.drawing import draw_form, drawing_box, size_text
from fab.viewing.painting import Shapes
from fab.viewing.scene import Scene, SceneBodies
from fab.viewing.shapes import body_shapes, solid_shapes
from fab.viewing.view_choice import best_view
from solver.vectors import FloatArray, IntArray

__all__ = ["thick_png_bytes"]

_WIDTH, _HEIGHT, _TITLE = 1600, 840, 40
_PLATE, _MOST_PLATES, _PLATES_COLUMNS = 400, 12, 4
# Elevation and azimuth from which the flat sheet is seen.
_FLAT_DEG = (55.0, -75.0)
# Colours of parts on plates, which follow one another.
_PARTS = np.array(
    [
        [0.94, 0.78, 0.53],
        [0.58, 0.75, 0.88],
        [0.66, 0.82, 0.60],
        [0.89, 0.64, 0.62],
        [0.77, 0.68, 0.87],
        [0.86, 0.86, 0.55],
    ]
)
_BED = "#808080"


def thick_png_bytes(scene: Scene, plates: Plates | None = None) -> bytes:
    """A PNG file of the bodies in the first state of a scene, flat, and in the last one.

    1600 pixels wide. Panels are sand above and blue below, hinges of mountains red, of valleys
    blue. Webs are drawn straight from panel to panel where they are bent. Sheets that are larger
    than the bed have their plates below, from above, each part in a colour of its own.
    """
    bodies = scene.bodies
    if bodies is None:
        raise ValueError(f"scene {scene.name!r} has no thick bodies: make it with `thick_scene`.")
    shown = 0 if plates is None else min(plates.count, _MOST_PLATES)
    rows = -(-shown // _PLATES_COLUMNS)
    canvas = Canvas(_WIDTH, _TITLE + _HEIGHT + rows * _PLATE)
    count = len(np.unique(bodies.faces[bodies.faces >= 0]))
    title = f"{scene.name}: {count} panels"
    canvas.text(title, _WIDTH / 2, _TITLE / 2 + 4, size=15, across="center", room=_WIDTH - 40)
    last = scene.state_count - 1
    states = [0, last] if last else [0]
    boxes = Box(0, _TITLE, _WIDTH, _HEIGHT).across(len(states))
    for state, box in zip(states, boxes, strict=True):
        if state == 0:
            coords, axes = bodies.bodies.vertices_coords, view_axes(*_FLAT_DEG)
        else:
            coords = bodies.coords_in(state)
            axes = _view(scene, bodies, coords)
        name = bodies.state_names[state]
        size = size_text("", coords).strip()
        draw_form(canvas, box, [body_shapes(bodies, coords)], name, size, axes=axes)
    if plates is not None:
        _draw_plates(canvas, plates, shown)
    return canvas.png_bytes()


def _view(scene: Scene, bodies: SceneBodies, coords: FloatArray) -> FloatArray:
    """The view that shows most of the panels."""
    owner = bodies.faces[bodies.bodies.triangles_body]
    corners = coords[bodies.bodies.triangles]
    panels = (owner >= 0) & np.isfinite(corners).all(axis=(1, 2))
    return best_view([corners[panels]], owner[panels], upright=scene.upright)


def _draw_plates(canvas: Canvas, plates: Plates, shown: int) -> None:
    """The plates in rows, each from above, with the outline of its bed."""
    width, depth = plates.bed_mm
    across = _WIDTH // _PLATES_COLUMNS
    for plate in range(shown):
        row, column = divmod(plate, _PLATES_COLUMNS)
        box = Box(column * across, _TITLE + _HEIGHT + row * _PLATE, across, _PLATE)
        inner = drawing_box(box)
        scale = min((inner.width - 4) / width, (inner.height - 4) / depth)
        middle = np.array([width / 2, depth / 2, 0.0])
        camera = Camera(view_axes(90.0, -90.0), middle, scale, inner.width, inner.height)
        parts = [part for part in plates.parts if part.plate == plate]
        numbers = [number for number, part in enumerate(plates.parts) if part.plate == plate]
        solids = bodies_of([part.mesh for part in parts])
        title = f"plate {plate + 1} of {plates.count}: {', '.join(part.name for part in parts)}"
        shapes = [_part_shapes(solids, np.array(numbers, np.int64))]
        draw_form(canvas, box, shapes, title, f"bed {width:g} x {depth:g} mm", camera=camera)
        bed = np.array([[0, 0, 0], [width, 0, 0], [width, depth, 0], [0, depth, 0]], np.float64)
        corners = camera.pixels(bed)[:, :2] + [inner.left, inner.top]
        canvas.lines(np.stack([corners, np.roll(corners, -1, axis=0)], axis=1), _BED, 1.0)


def _part_shapes(solids: Bodies, numbers: IntArray) -> Shapes:
    return solid_shapes(solids, _PARTS[numbers % len(_PARTS)])
