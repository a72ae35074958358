"""Stitching holes: rows along both sides of a seam, whose holes come to lie on each other."""

from __future__ import annotations

import numpy as np
import shapely

from fab.pattern.crease_pattern import CreasePattern
from fab.sheets.openings import Openings, beside_seams
from fab.sheets.seams import SeamSides
from solver.vectors import FloatArray

__all__ = ["stitching_holes"]

# Distance of a row from its seam, and least distance of holes from other edges and other holes, as
# material between them, in diameters.
_INSET = 2.0
_LEFT = 0.75
_CORNERS = 16


def stitching_holes(
    pattern: CreasePattern, sides: SeamSides, pitch_mm: float, hole_mm: float
) -> Openings:
    """Holes of the diameter `hole_mm` along both sides of each seam, `pitch_mm` apart.

    Both rows have the same number of holes, at the same distances from the ends of the seam, so
    that a thread through two of them is across it. Rows are symmetrical about the middle of the
    seam, and as long as there is room on both sides. Seams without room for two holes have none.
    """
    rings: list[FloatArray] = []
    faces: list[int] = []
    seams: list[int] = []
    middles: dict[int, FloatArray] = {}
    rooms: dict[int, shapely.Polygon] = {}
    for seam in range(len(sides)):
        both = pattern.vertices_coords[sides.vertices[seam]]
        own = sides.faces[seam].tolist()
        for face in own:
            rooms.setdefault(face, _room(pattern, face, hole_mm))
        length = float(np.hypot(*(both[0, 1] - both[0, 0])))
        for count in range(int(length // pitch_mm) + 1, 1, -1):
            along = length / 2 + pitch_mm * (np.arange(count) - (count - 1) / 2)
            # the row is symmetrical, so it is the same from either end
            rows = [
                beside_seams(ends, np.column_stack([along, np.full(count, _INSET * hole_mm)]))
                for ends in both
            ]
            placed = list(zip(rows, own, strict=True))
            if all(_free(row, rooms[face], middles.get(face), hole_mm) for row, face in placed):
                for row, face in placed:
                    known = middles.get(face, row[:0])
                    middles[face] = np.concatenate([known, row])
                    rings += [_hole(middle, hole_mm) for middle in row]
                    faces += [face] * count
                    seams += [seam] * count
                break
    return Openings(tuple(rings), np.array(faces, np.int64), np.array(seams, np.int64))


def _room(pattern: CreasePattern, face: int, hole_mm: float) -> shapely.Polygon:
    """Where the middles of holes may be in a face."""
    begin, end = pattern.faces_offsets[face : face + 2]
    polygon = shapely.Polygon(pattern.vertices_coords[pattern.faces_vertices[begin:end]])
    return polygon.buffer(-(0.5 + _LEFT) * hole_mm)


def _free(
    row: FloatArray, room: shapely.Polygon, others: FloatArray | None, hole_mm: float
) -> bool:
    """Whether all holes of a row are in their face, and clear of others there."""
    if not shapely.contains_xy(room, row[:, 0], row[:, 1]).all():
        return False
    if others is None:
        return True
    apart = np.hypot(*(row[:, None] - others[None]).transpose(2, 0, 1))
    return bool(apart.min() >= (1 + _LEFT) * hole_mm)


def _hole(middle: FloatArray, hole_mm: float) -> FloatArray:
    """A clockwise polygon around as much as a circle of that diameter."""
    angle = -2 * np.pi * np.arange(_CORNERS) / _CORNERS
    area = _CORNERS / 2 * np.sin(2 * np.pi / _CORNERS)
    radius = hole_mm / 2 * np.sqrt(np.pi / area)
    out: FloatArray = middle + radius * np.column_stack([np.cos(angle), np.sin(angle)])
    return out
