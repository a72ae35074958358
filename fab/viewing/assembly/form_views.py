"""Views of the folded form, each piece in its colour and with its letters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy import ndimage

from fab.pattern.crease_pattern import CreasePattern
from fab.viewing.assembly.parts import Model
from fab.viewing.assembly.piece_colours import paler
from fab.viewing.camera import Camera, fitted
from fab.viewing.painting import Painting, Shapes, painting
from fab.viewing.shapes import sheet_triangles
from fab.viewing.sketch import Image, Mark, Sketch, Words
from fab.viewing.view_choice import best_view
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["FormViews"]

# Pixels for a millimetre of paper: 127 for an inch.
_PIXELS_PER_MM = 5.0
_LOWER_PALE = 0.6
_FRONT = "Folded form, not to scale. The lower side is paler."
# Sizes of the font of letters, mm; smaller ones are left out, and in radii of their room.
_LETTERS, _ROOM = (1.9, 7.0), 1.15
_BEST_TRIANGLES = 6_000
# Up to so many seams are numbered, in this size of font; they are seen where nothing is nearer by
# this many fine pixels.
_MOST_NUMBERS, _NUMBER, _NEAR_PIXELS = 40, 2.2, 6.0


class FormViews:
    """Views of a model whose folded form is known; the view is chosen once."""

    def __init__(self, model: Model, formed: CreasePattern, coords: FloatArray) -> None:
        """Coords : of the vertices of `formed`, z upwards; shape (nv, 3)."""
        self.model = model
        triangles = sheet_triangles(formed)
        same = len(coords) == len(model.pattern.vertices_coords)
        self._coords = coords if same else None  # else cuts are open
        self._faces = triangles.faces
        self._corners = coords[triangles.vertices]
        every = max(1, len(self._faces) // _BEST_TRIANGLES)
        self._axes = best_view(
            [self._corners[::every]], self._faces[::every], upright=model.upright
        )
        self._front: Sketch | None = None

    def both(self, most_mm: tuple[float, float]) -> tuple[Sketch, Sketch]:
        """The whole form from two opposite sides."""
        labels = [joint.label for joint in self.model.joints]
        labels = labels if len(labels) <= _MOST_NUMBERS else []
        front = self.view(most_mm, labels=labels, caption=_FRONT)
        self._front = front
        behind = self.view(most_mm, labels=labels, behind=True, caption="The same from behind.")
        return front, behind

    def view(
        self,
        most_mm: tuple[float, float],
        pieces: Sequence[int] | None = None,
        *,
        labels: Sequence[int] = (),
        behind: bool = False,
        caption: str = "",
    ) -> Sketch:
        """Some pieces of the form, all of them where none are named.

        labels : of the seams whose numbers are written where they are seen.
        """
        every = pieces is not None and len(set(pieces)) == len(self.model.pieces)
        if every and self._front is not None and not behind:
            return replace(_fitting(self._front, most_mm), caption=caption)
        right, up, toward = self._axes
        axes = np.stack([-right, up, -toward]) if behind else self._axes
        size = [round(side * _PIXELS_PER_MM) for side in most_mm]
        chosen = slice(None) if pieces is None else self._of(pieces)
        points = self._corners[chosen].reshape(-1, 3)
        seen = points @ axes[:2].T
        low, high = seen.min(axis=0), seen.max(axis=0)
        span = np.maximum(high - low, 1e-9 * float((high - low).max() or 1.0))
        scale = float((np.array(size) / span).min())
        width, height = (max(8, int(side)) for side in np.ceil(span * scale).tolist())
        camera = fitted(axes, points, min(width, size[0]), min(height, size[1]), 1)
        piece = self.model.faces_piece[self._faces[chosen]]
        upper = self.model.colours[piece]
        shown = painting(
            camera,
            [Shapes(self._corners[chosen], upper, paler(upper, _LOWER_PALE), self._faces[chosen])],
        )
        owners = np.full(shown.groups.shape, -1)
        drawn = shown.groups >= 0
        owners[drawn] = self.model.faces_piece[shown.groups[drawn]]
        picture = _with_rims(shown, owners)
        paper = (camera.width / _PIXELS_PER_MM, camera.height / _PIXELS_PER_MM)
        marks: list[Mark] = [Image(np.round(255 * picture).astype(np.uint8), (0.0, 0.0), paper)]
        if not self.model.alone:
            marks += self._letters(owners[:: shown.finer, :: shown.finer], paper[1])
        marks += self._numbers(camera, shown, labels)
        return Sketch(paper, tuple(marks), caption)

    def _of(self, pieces: Sequence[int]) -> BoolArray:
        return np.isin(self.model.faces_piece[self._faces], np.array(pieces))

    def _letters(self, labels: IntArray, height_mm: float) -> list[Words]:
        """The letters of each piece where most of it is seen."""
        padded = np.pad(labels, 1, constant_values=-1)
        rim = np.zeros(padded.shape, bool)
        for axis in (0, 1):
            for step in (1, -1):
                rim |= padded != np.roll(padded, step, axis)
        room = ndimage.distance_transform_edt(~rim)[1:-1, 1:-1]
        seen = np.unique(labels[labels >= 0])
        places = ndimage.maximum_position(room, labels, seen)
        out = []
        for number, (row, column) in zip(seen.tolist(), places, strict=True):
            name = self.model.pieces[number].name
            size = _ROOM * room[row, column] / _PIXELS_PER_MM / max(1.0, 0.6 * len(name))
            if size >= _LETTERS[0]:
                x = (column + 0.5) / _PIXELS_PER_MM
                y = height_mm - (row + 0.5) / _PIXELS_PER_MM
                out.append(Words(name, (x, y), min(size, _LETTERS[1]), bold=True))
        return out

    def _numbers(self, camera: Camera, shown: Painting, labels: Sequence[int]) -> list[Words]:
        """Numbers of seams in the middle of those that are seen."""
        wanted = set(labels)
        joints = [joint for joint in self.model.joints if joint.label in wanted]
        if self._coords is None or not joints:
            return []
        edges = np.array([joint.edges[0] for joint in joints])
        middles = self._coords[self.model.pattern.edges_vertices[edges]].mean(axis=1)
        x, y, height = camera.finer(shown.finer).pixels(middles).T
        rows, columns = shown.heights.shape
        row = np.clip(y.astype(int), 0, rows - 1)
        column = np.clip(x.astype(int), 0, columns - 1)
        around = np.stack(
            [
                shown.heights[
                    np.clip(row + down, 0, rows - 1), np.clip(column + across, 0, columns - 1)
                ]
                for down in (-1, 0, 1)
                for across in (-1, 0, 1)
            ]
        )
        seen = (around <= height + _NEAR_PIXELS).any(axis=0) & np.isfinite(around).any(axis=0)
        fine = _PIXELS_PER_MM * shown.finer
        return [
            Words(
                str(joint.label),
                (float(left / fine), float((rows - top) / fine)),
                _NUMBER,
                bold=True,
                backing="#ffffff",
            )
            for joint, left, top, there in zip(joints, x, y, seen, strict=True)
            if there
        ]


def _fitting(sketch: Sketch, most_mm: tuple[float, float]) -> Sketch:
    """The same sketch of a picture and words, as large as fits."""
    width, height = sketch.size_mm
    factor = min(most_mm[0] / width, most_mm[1] / height)
    marks: list[Mark] = []
    for mark in sketch.marks:
        if isinstance(mark, Image):
            size = (mark.size_mm[0] * factor, mark.size_mm[1] * factor)
            marks.append(replace(mark, size_mm=size))
        elif isinstance(mark, Words):
            at = (mark.at[0] * factor, mark.at[1] * factor)
            marks.append(replace(mark, at=at, size_mm=max(mark.size_mm * factor, _LETTERS[0])))
    return Sketch((width * factor, height * factor), tuple(marks))


def _with_rims(shown: Painting, labels: IntArray) -> FloatArray:
    """The picture with dark lines where one piece, or the form, ends."""
    rim = np.zeros(labels.shape, bool)
    across, down = labels[:, :-1] != labels[:, 1:], labels[:-1] != labels[1:]
    rim[:, :-1] |= across
    rim[:, 1:] |= across
    rim[:-1] |= down
    rim[1:] |= down
    k = shown.finer
    height, width = labels.shape
    dark = rim.reshape(height // k, k, width // k, k).mean(axis=(1, 3))
    return np.asarray(shown.picture * (1 - 0.85 * dark)[..., None])
