"""Pictures of the bodies of a thick sheet, flat and folded.

Triangles are drawn into a buffer of depths, pixel by pixel, so that what lies in front hides what
lies behind, also where bodies pass through each other.
"""

from __future__ import annotations

import io
from dataclasses import replace
from itertools import pairwise

import numpy as np

from fab.folding.folded_states import FoldedState
from fab.geometry.bodies import Bodies
from fab.panels.body_colours import body_assignments
from fab.panels.thick_sheet import ThickSheet
from fab.pattern.picture import principal_axes
from solver.vectors import FloatArray, IntArray, cross, unit

__all__ = ["folded_bodies", "rendered", "thick_png_bytes"]

_PIXELS = 800
# Pictures are drawn finer by this factor, then averaged.
_FINER = 2
_MARGIN = 0.04
# Triangles times rows, or pixels, that are worked on at once.
_AT_ONCE = 4_000_000

_UPPER, _LOWER = (0.96, 0.84, 0.62), (0.62, 0.74, 0.86)
_HINGES = {"M": (0.84, 0.13, 0.13), "V": (0.13, 0.31, 0.84)}
_OTHER = (0.6, 0.6, 0.6)
_LIGHT = unit(np.array([-0.3, -0.4, 0.9]))


def thick_png_bytes(sheet: ThickSheet, title: str, state: FoldedState | None = None) -> bytes:
    """The flat bodies on the left, those in a folded state (where one is given) on the right.

    1600 x 840 pixels. Panels are sand above and blue below, hinges of mountains red, of valleys
    blue. Webs are drawn straight from panel to panel where they are bent.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    views = [("flat", rendered(sheet.bodies, _colours(sheet, np.arange(len(sheet.bodies))), 55.0))]
    if state is not None and len(sheet.bodies):
        bodies, numbers = folded_bodies(sheet, state)
        coords = bodies.vertices_coords
        axes = principal_axes(coords)
        if state.turns[:, :, 2].sum(axis=0) @ axes[2] < 0:
            axes[1:] *= -1  # the upper sides of most panels look up
        turned = replace(bodies, vertices_coords=coords @ axes.T)
        views.append((state.name, rendered(turned, _colours(sheet, numbers), 35.0)))
    figure = Figure(figsize=(2 * _PIXELS / 100, _PIXELS / 100 + 0.4), dpi=100, facecolor="white")
    FigureCanvasAgg(figure)
    width, height = 1 / len(views), _PIXELS / (_PIXELS + 40)
    for number, (name, image) in enumerate(views):
        plane = figure.add_axes((number * width, 0, width, height))
        plane.imshow(image, interpolation="nearest")
        plane.set_axis_off()
        words = f"{title}, {name}: {len(sheet.panels.bodies)} panels"
        figure.text((number + 0.5) * width, 1.0 - 0.6 * (1 - height), words, ha="center")
    stream = io.BytesIO()
    figure.savefig(stream, format="png", metadata={"Software": "quadfold"})
    return stream.getvalue()


def folded_bodies(sheet: ThickSheet, state: FoldedState) -> tuple[Bodies, IntArray]:
    """Bodies where a folded state has them, and their numbers in the sheet.

    Bodies of one crease that bend have the half on each side of it moved with the face there; those
    of more are left out.
    """
    numbers = np.flatnonzero((sheet.faces >= 0) | (sheet.creases >= 0))
    bodies = sheet.bodies.chosen(numbers)
    pattern = sheet.pattern
    owner = bodies.vertices_body
    face = sheet.faces[numbers][owner]
    bent = np.flatnonzero(face < 0)
    edge = sheet.creases[numbers][owner[bent]]
    start, end = pattern.vertices_coords[pattern.edges_vertices[edge]].swapaxes(0, 1)
    along, off = end - start, bodies.vertices_coords[bent, :2] - start
    # the first face of an edge is on its left
    left = along[:, 0] * off[:, 1] > along[:, 1] * off[:, 0]
    face[bent] = np.where(left, *pattern.edges_faces[edge].T)
    moved = np.squeeze(state.turns[face] @ bodies.vertices_coords[:, :, None], axis=2)
    moved += state.shifts[face]
    return replace(bodies, vertices_coords=moved), numbers


def _colours(sheet: ThickSheet, numbers: IntArray) -> FloatArray:
    """A colour for every triangle of some bodies, seen in the flat state, shape (nt, 3)."""
    flat = sheet.bodies.chosen(numbers)
    creases, soft = sheet.creases[numbers], sheet.flexible[numbers]
    letters = body_assignments(sheet)
    own = np.array([_HINGES.get(letters[number], _OTHER) for number in numbers.tolist()])
    down = _normals(flat)[:, 2] < -0.999
    panels = np.where(down[:, None], _LOWER, _UPPER)
    is_hinge = (soft | (creases >= 0))[flat.triangles_body]
    return np.where(is_hinge[:, None], own.reshape(-1, 3)[flat.triangles_body], panels)


def _normals(bodies: Bodies) -> FloatArray:
    a, b, c = bodies.vertices_coords[bodies.triangles].swapaxes(0, 1)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.nan_to_num(unit(cross(b - a, c - a)))


def rendered(bodies: Bodies, colours: FloatArray, elevation_deg: float) -> FloatArray:
    """A square picture of bodies from their front left, light from above, shape (n, n, 3).

    colours : of every triangle, shape (nt, 3), from 0 to 1.
    """
    size = _PIXELS * _FINER
    picture = np.ones((size * size, 3))
    if len(bodies):
        view = _camera(elevation_deg)
        seen = bodies.vertices_coords @ view.T
        low, high = seen[:, :2].min(axis=0), seen[:, :2].max(axis=0)
        scale = (1 - 2 * _MARGIN) * size / max(float((high - low).max()), 1e-9)
        place = (seen - [*(low + high) / 2, 0.0]) * scale + [size / 2, size / 2, 0.0]
        place[:, 1] = size - place[:, 1]  # rows run downwards
        normals = _normals(bodies)
        front = np.flatnonzero(normals @ view[2] > 1e-9)
        owner = _nearest(place[bodies.triangles[front]], size)
        drawn = owner >= 0
        shade = 0.45 + 0.55 * np.clip(normals[front] @ _LIGHT, 0, 1)
        shade += 0.1 * np.clip(-(normals[front] @ _LIGHT), 0, 1)
        picture[drawn] = (colours[front] * shade[:, None])[owner[drawn]]
        planes = np.full(size * size, -1)
        planes[drawn] = bodies.triangles_plane[front][owner[drawn]]
        picture[_outlines(planes.reshape(size, size)).ravel()] *= 0.55
    fine = picture.reshape(_PIXELS, _FINER, _PIXELS, _FINER, 3)
    return np.asarray(np.clip(fine.mean(axis=(1, 3)), 0, 1))


def _camera(elevation_deg: float) -> FloatArray:
    """Rows: to the right, upwards and towards the viewer, who stands front left."""
    turn, rise = np.radians(-60.0), np.radians(elevation_deg)
    right = np.array([-np.sin(turn), np.cos(turn), 0.0])
    toward = np.array([np.cos(rise) * np.cos(turn), np.cos(rise) * np.sin(turn), np.sin(rise)])
    return np.stack([right, cross(toward, right), toward])


def _outlines(planes: IntArray) -> IntArray:
    """Pixels whose neighbour to the right or below shows another plane."""
    out = np.zeros(planes.shape, bool)
    out[:, :-1] |= planes[:, :-1] != planes[:, 1:]
    out[:-1] |= planes[:-1] != planes[1:]
    return out


def _nearest(corners: FloatArray, size: int) -> IntArray:
    """The triangle that each pixel shows, -1 where there is none, shape (size * size,).

    corners : shape (n, 3, 3), in pixels, with the height towards the viewer. A pixel is covered
    where its centre is; of triangles at the same height it shows the last.
    """
    depth = np.full(size * size, -np.inf)
    owner = np.full(size * size, -1)
    # height = corner + slope . (x, y): triangles seen from the side have no slope to trust
    normal = cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = np.nan_to_num(-normal[:, :2] / normal[:, 2:])
    level = corners[:, 0, 2] - (slope * corners[:, 0, :2]).sum(axis=1)
    lowest, highest = corners[:, :, 2].min(axis=1), corners[:, :, 2].max(axis=1)
    top = np.maximum(np.ceil(corners[:, :, 1].min(axis=1) - 0.5), 0).astype(np.int64)
    end = np.minimum(np.ceil(corners[:, :, 1].max(axis=1) - 0.5), size).astype(np.int64)
    for chunk in _chunks(end - top):
        triangle, row = _counted(end[chunk] - top[chunk])
        row += top[chunk][triangle]
        triangle += chunk.start
        left, right = _spans(corners[triangle], np.asarray(row + 0.5, np.float64))
        first = np.maximum(np.ceil(left - 0.5), 0).astype(np.int64)
        count = np.minimum(np.ceil(right - 0.5), size).astype(np.int64) - first
        for part in _chunks(count):
            line, column = _counted(count[part])
            line += part.start
            column += first[line]
            shown, y = triangle[line], row[line]
            height = level[shown] + slope[shown, 0] * (column + 0.5) + slope[shown, 1] * (y + 0.5)
            height = np.clip(height, lowest[shown], highest[shown])
            pixel = y * size + column
            np.maximum.at(depth, pixel, height)
            visible = height >= depth[pixel]
            owner[pixel[visible]] = shown[visible]
    return owner


def _chunks(counts: IntArray) -> list[slice]:
    """Runs of items with given counts of parts, each run as large as is worked on at once."""
    total = np.cumsum(np.maximum(counts, 0))
    if not len(total):
        return []
    cuts = np.searchsorted(total, np.arange(_AT_ONCE, total[-1], _AT_ONCE))
    ends = np.unique([0, *cuts, len(counts)]).tolist()
    return [slice(a, b) for a, b in pairwise(ends)]


def _counted(counts: IntArray) -> tuple[IntArray, IntArray]:
    """For items with given counts of parts: the item of every part, and its number in it."""
    counts = np.maximum(counts, 0)
    item = np.repeat(np.arange(len(counts)), counts)
    return item, np.arange(len(item)) - np.repeat(np.cumsum(counts) - counts, counts)


def _spans(corners: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Least and largest x of triangles (n, 3, 3) at the heights y, shapes (n,)."""
    x, height = corners[:, :, 0], corners[:, :, 1]
    left, right = np.full(len(y), np.inf), np.full(len(y), -np.inf)
    for i, j in ((0, 1), (1, 2), (2, 0)):
        a, b = height[:, i], height[:, j]
        crosses = (a <= y) != (b <= y)
        with np.errstate(divide="ignore", invalid="ignore"):
            at = x[:, i] + (x[:, j] - x[:, i]) * (y - a) / (b - a)
        left = np.where(crosses, np.minimum(left, at), left)
        right = np.where(crosses, np.maximum(right, at), right)
    empty = left > right
    return np.where(empty, 0.0, left), np.where(empty, 0.0, right)
