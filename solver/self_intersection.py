"""Self-intersection of a folded sheet: the pairs of faces that cross.

Two faces A and B cross where a segment of the line in which their planes meet runs inside both.
Seen from the front, with B's plane edge-on along the line:

      +---------+              A+  the parts of the line that have A just above them
      |    A    |              A-  the parts that have A just below them
    --+-----+---+-----> line
            |   |              A goes through B's plane where A+ and A- hold together
            +---+

and the faces cross where A+, A-, B+ and B- hold together. Each of the four begins or ends where a
side of the polygon leaves its own half of the drawing, so that faces of any number of corners,
convex or not, are taken as they are, without triangles.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from solver.polygons import face_normals, next_corner
from solver.vectors import BoolArray, FloatArray, IntArray, cross, dot, norm, unit

__all__ = ["CONTACT_REL", "crossing_faces"]

# Faces that reach into each other by less than this share of the sheet's diagonal are in contact.
CONTACT_REL = 1e-9
# Corners known to 1e-12 of the diagonal tilt a plane by that over the face's width; over its length
# this makes 8e-12 for each unit of (distance of a corner from the middle)^2 / area.
_TILT_REL = 1e-11
# Faces whose boxes are looked up at a time: this bounds the memory, not the answer.
_FACES_AT_ONCE = 4096


@dataclass(frozen=True)
class _Faces:
    """Polygons in space with their planes; face f holds corners[offsets[f]:offsets[f + 1]].

    slack : how thick each face is taken to be: the contact length, how far its own corners lie
        off its plane, and how far a needle's plane may tilt by the last digits of its corners.
    """

    corners: FloatArray
    offsets: IntArray
    centres: FloatArray
    normals: FloatArray
    slack: FloatArray


def crossing_faces(
    folded_coords: FloatArray, faces_vertices: IntArray, faces_offsets: IntArray
) -> IntArray:
    """Pairs of faces whose interiors cross in space, lower number first, sorted, shape (n, 2).

    Parameters
    ----------
    folded_coords : shape (nv, 3), in any unit.
    faces_vertices, faces_offsets : plane polygons of any size, see `fab.pattern.crease_pattern`.

    Faces that touch do not cross, whether in a shared vertex or edge, in a point, along a line or
    face on face, as in a sheet folded flat. They cross where each reaches through the other's plane
    by more than `CONTACT_REL` of the diagonal of the sheet's box, along a segment longer than that.
    A face that is not plane counts as thicker by as much as its corners lie off its plane, a needle
    by how far its plane tilts with the twelfth digit of its corners (1e-9 of the diagonal at a
    length of 400 widths, 1e-6 at 400 000). A face without area crosses nothing. Where one part of
    the sheet runs exactly along a crease of another no two interiors cross: this is not reported.

    Cost: O(n log n) for a sheet that is spread out, more where many faces lie above one another.

    An upright square that passes through a flat one:

    >>> flat = np.array([[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]])
    >>> upright = np.array([[1, 1, -1], [1, 3, -1], [1, 3, 1], [1, 1, 1]])
    >>> crossing_faces(np.vstack([flat, upright]) * 1.0, np.arange(8), np.array([0, 4, 8])).tolist()
    [[0, 1]]
    """
    import shapely  # not needed where a sheet is only grown

    faces, diagonal = _faces(folded_coords, faces_vertices, faces_offsets)
    found = [np.empty((0, 2), np.int64)]
    boxes, low, high = _boxes(faces)
    if float(np.ptp(np.concatenate([low, high]))) <= CONTACT_REL * diagonal:
        return found[0]  # folded flat: no face has room to pass through another
    tree = shapely.STRtree(boxes)
    for start in range(0, len(boxes), _FACES_AT_ONCE):
        first, second = tree.query(boxes[start : start + _FACES_AT_ONCE])
        first = first + start
        near = (first < second) & (low[first] <= high[second]) & (low[second] <= high[first])
        first, second = first[near], second[near]
        for swap in (False, True):
            through = _reaches_through(faces, *((second, first) if swap else (first, second)))
            first, second = first[through], second[through]
        cut = _meet_inside(faces, first, second)
        found.append(np.column_stack([first[cut], second[cut]]))
    pairs = np.concatenate(found)
    return pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]


def _faces(coords: FloatArray, faces_vertices: IntArray, offsets: IntArray) -> tuple[_Faces, float]:
    """The faces about the middle of their box, and the diagonal of that box."""
    corners = coords[faces_vertices]
    low, high = corners.min(axis=0), corners.max(axis=0)
    diagonal = float(norm(high - low))
    corners = corners - (low + high) / 2
    sizes = np.diff(offsets)
    centres = np.add.reduceat(corners, offsets[:-1]) / sizes[:, None]
    normals = face_normals(coords, faces_vertices, offsets)
    arms = corners - np.repeat(centres, sizes, 0)
    upright = np.repeat(normals, sizes, 0)
    areas = np.add.reduceat(dot(cross(arms, arms[next_corner(offsets)]), upright), offsets[:-1]) / 2
    needles = np.maximum.reduceat(dot(arms, arms), offsets[:-1]) / areas
    off = np.maximum.reduceat(np.abs(dot(arms, upright)), offsets[:-1])
    slack = (CONTACT_REL + _TILT_REL * needles) * diagonal + off
    return _Faces(corners, offsets, centres, normals, slack), diagonal


def _boxes(faces: _Faces) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Boxes of the faces over the plane that the sheet spans best, and their ends across it."""
    import shapely

    _, axes = np.linalg.eigh(faces.corners.T @ faces.corners)
    turned = faces.corners @ axes  # the first axis is the one of least extent
    low = np.minimum.reduceat(turned, faces.offsets[:-1])
    high = np.maximum.reduceat(turned, faces.offsets[:-1])
    return shapely.box(low[:, 1], low[:, 2], high[:, 1], high[:, 2]), low[:, 0], high[:, 0]


def _heights(
    faces: _Faces, of: IntArray, over: IntArray
) -> tuple[FloatArray, IntArray, IntArray, IntArray]:
    """Heights of the corners of faces `of` over the planes of faces `over`, pair after pair.

    Returns the heights, 0 within the slack of the pair; the corners they are of; the pair that
    each belongs to; and where each pair begins, shape (pairs + 1,).
    """
    sizes = np.diff(faces.offsets)[of]
    starts = np.concatenate([[0], np.cumsum(sizes)])
    pair = np.repeat(np.arange(len(of)), sizes)
    corner = np.arange(starts[-1]) + np.repeat(faces.offsets[of] - starts[:-1], sizes)
    height = dot(faces.corners[corner] - faces.centres[over][pair], faces.normals[over][pair])
    slack = np.maximum(faces.slack[of], faces.slack[over])
    height[~(np.abs(height) > slack[pair])] = 0.0
    return height, corner, pair, starts


def _reaches_through(faces: _Faces, of: IntArray, over: IntArray) -> BoolArray:
    """Whether face `of` has corners on both sides of the plane of face `over`, shape (pairs,)."""
    if len(of) == 0:
        return np.zeros(0, bool)
    height, _, _, starts = _heights(faces, of, over)
    above = np.maximum.reduceat(height, starts[:-1]) > 0
    below = np.minimum.reduceat(height, starts[:-1]) < 0
    out: BoolArray = above & below
    return out


def _meet_inside(faces: _Faces, first: IntArray, second: IntArray) -> BoolArray:
    """Whether A+, A-, B+ and B- of the module's drawing have a segment in common, shape (pairs,).

    Every place where a side of a polygon crosses the line is where one of the four begins or ends.
    """
    if len(first) == 0:
        return np.zeros(0, bool)
    line = unit(cross(faces.normals[first], faces.normals[second]))
    pairs, places, kinds = [], [], []
    for face, (of, over) in enumerate(((first, second), (second, first))):
        height, corner, pair, starts = _heights(faces, of, over)
        following = next_corner(starts)
        along = dot(faces.corners[corner], line[pair])
        for side in (0, 1):
            beyond = height < 0 if side else height > 0
            ends = np.flatnonzero(beyond != beyond[following])
            rest = following[ends]
            share = height[ends] / (height[ends] - height[rest])
            pairs.append(pair[ends])
            places.append(along[ends] + share * (along[rest] - along[ends]))
            kinds.append(np.full(len(ends), 2 * face + side))
    pair, place = np.concatenate(pairs), np.concatenate(places)
    order = np.lexsort((place, pair))
    pair, place = pair[order], place[order]
    begins_or_ends = np.concatenate(kinds)[order][:, None] == np.arange(4)
    # sides cross the line an even number of times, so that no pair leaves anything to the next
    inside = (np.cumsum(begins_or_ends, axis=0) % 2 == 1).all(axis=1)[:-1]
    slack = np.maximum(faces.slack[first], faces.slack[second])
    common = inside & (np.diff(place) > slack[pair[:-1]])
    out = np.zeros(len(first), bool)
    out[pair[:-1][common]] = True
    return out
