"""Labels of a piece: its name where there is most room, and a number beside each of its seams."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from fab.geometry.boxes import smallest_box
from fab.pattern.crease_pattern import CreasePattern
from fab.sheets.labels import Label, LabelPlaces, fitted, highest
from solver.vectors import FloatArray, IntArray

__all__ = ["READABLE_MM", "EdgeTexts", "number_labels", "piece_labels"]

# Smaller letters cannot be read.
READABLE_MM = 1.0
# Up to this many of the largest faces are tried for the name of a piece.
_MOST_TRIED = 24
# Kept free on both sides of lines that end within a face.
_BESIDE_MM = 0.1
# Height of the name, in heights of the numbers.
_NAME_HEIGHT = 2.0


@dataclass(frozen=True)
class EdgeTexts:
    """Numbers that are to be engraved beside lines.

    Attributes
    ----------
    texts : n of them.
    faces : the face that each is engraved on, shape (n,).
    lines : the line that it is read along, with its face to the left, mm, shape (n, 2, 2).
    """

    texts: tuple[str, ...]
    faces: IntArray
    lines: FloatArray


def piece_labels(
    pattern: CreasePattern,
    name: str,
    face_count: int,
    seams: EdgeTexts,
    label_mm: float,
    openings: Sequence[FloatArray] = (),
) -> tuple[Label | None, ...]:
    """The label of a piece's name, and one for each seam's number; None where there is no room.

    No label crosses a crease, and none is lower than `READABLE_MM`.

    Parameters
    ----------
    pattern : the piece.
    face_count : its first faces, on which the name may be; those after them are tabs.
    label_mm : greatest height of the numbers; the name may be twice as high.
    openings : in its faces, each of shape (m, 2), which labels keep clear of.
    """
    rooms = _without(_rooms(pattern), openings)
    widest, middle, slant = _place_for(name, rooms[:face_count], seams.faces)
    direction = seams.lines[:, 1] - seams.lines[:, 0]
    height = np.full(1 + len(seams.texts), label_mm)
    height[0] *= _NAME_HEIGHT
    hang = np.ones(len(height))
    hang[0] = 0.0
    places = LabelPlaces(
        [name, *seams.texts],
        np.concatenate([middle[None], seams.lines.mean(axis=1)]),
        np.concatenate([[slant], np.arctan2(direction[:, 1], direction[:, 0])]),
        [rooms[face] for face in [widest, *seams.faces.tolist()]],
        height,
        hang,
    )
    return fitted(places, READABLE_MM)


def number_labels(
    pattern: CreasePattern, seams: EdgeTexts, label_mm: float
) -> tuple[Label | None, ...]:
    """Labels of numbers alone, at most `label_mm` high; as `piece_labels` without a name."""
    rooms = _rooms(pattern)
    direction = seams.lines[:, 1] - seams.lines[:, 0]
    places = LabelPlaces(
        seams.texts,
        seams.lines.mean(axis=1),
        np.arctan2(direction[:, 1], direction[:, 0]),
        [rooms[face] for face in seams.faces.tolist()],
        np.full(len(seams.texts), label_mm),
        np.ones(len(seams.texts)),
    )
    return fitted(places, READABLE_MM)


def _rooms(pattern: CreasePattern) -> list[shapely.Polygon]:
    """The faces of a pattern, without what is beside the lines that end within them."""
    rooms = [
        shapely.polygons(pattern.vertices_coords[pattern.faces_vertices[i:j]])
        for i, j in zip(pattern.faces_offsets[:-1], pattern.faces_offsets[1:], strict=True)
    ]
    first, second = pattern.edges_faces.T
    within = np.flatnonzero(first == second)
    for face in np.unique(first[within]).tolist():
        ends = pattern.edges_vertices[within[first[within] == face]]
        lines = shapely.multilinestrings([shapely.linestrings(pattern.vertices_coords[ends])])
        free = shapely.get_parts(shapely.difference(rooms[face], lines[0].buffer(_BESIDE_MM)))
        if len(free):
            rooms[face] = max(free, key=lambda part: part.area)
    return rooms


def _without(rooms: list[shapely.Polygon], openings: Sequence[FloatArray]) -> list[shapely.Polygon]:
    """Rooms without openings and what is beside them; of several parts the largest."""
    if not openings:
        return rooms
    holes = shapely.buffer([shapely.Polygon(ring) for ring in openings], _BESIDE_MM)
    hole, room = shapely.STRtree(rooms).query(holes, predicate="intersects")
    out = list(rooms)
    for number in np.unique(room).tolist():
        left = out[number].difference(shapely.union_all(holes[hole[room == number]]))
        parts = shapely.get_parts(left)
        if len(parts):
            out[number] = max(parts, key=lambda part: part.area)
    return out


def _place_for(
    text: str, rooms: list[shapely.Polygon], beside_seams: IntArray
) -> tuple[int, FloatArray, float]:
    """The face on which a text may be highest, the text's middle, and its slant in radians.

    Faces without seams are preferred, unless letters on them are less than half as high.
    """
    shapes = np.asarray(rooms)
    areas = shapely.area(shapes)
    large = np.argsort(-areas, kind="stable")[:_MOST_TRIED]
    large = large[areas[large] > 0]  # some may be taken by openings whole
    if not len(large):
        return 0, np.zeros(2), 0.0
    near = 0.1 * shapely.area(shapes[large]) / shapely.length(shapes[large])
    disks = shapely.maximum_inscribed_circle(shapes[large], tolerance=near)
    middles = shapely.get_coordinates(disks)[::2]
    best = (0.0, int(large[0]), middles[0], 0.0)
    for face, middle in zip(large.tolist(), middles, strict=True):
        sides = np.diff(smallest_box(shapes[face]), axis=0)
        along = sides[np.argmax(np.hypot(*sides.T))]
        for slant in (0.0, float(np.arctan(along[1] / along[0])) if along[0] else np.pi / 2):
            height = highest(text, middle, slant, shapes[face])
            if face in beside_seams:
                height /= 2
            if height > best[0] * (1 + 1e-9):
                best = (height, face, middle, slant)
    return best[1:]
