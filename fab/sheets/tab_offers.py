"""Tabs that may be chosen for seams: on both sides of each, of several heights.

A tab is a trapezoid beside an edge, whose mitres leave the room of its neighbours free.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from fab.layout.face_sets import outer_corners
from fab.pattern.crease_pattern import CreasePattern
from fab.sheets.seams import SeamSides
from solver.polygons import next_corner
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["FaceSet", "TabOffers", "corner_angles", "tab_clashes", "tab_offers"]

# A lower tab cannot be glued.
_LEAST_MM = 1.0
# Heights tried, as shares of the greatest.
_SHARES = np.array([1.0, 0.7, 0.5, 0.35])
# A tab's outer side keeps this share of its base.
_LEAST_TOP = 0.3
# Kept free between a tab and its neighbours: angle at a common corner, distance elsewhere.
_FREE_DEG = 1.0
_FREE_MM = 0.3
_LEAST_MITRE_DEG = 8.0
_CONTACT_MM = 1e-6

Shapes = NDArray[np.object_]


def corner_angles(coords: FloatArray, corners: IntArray, offsets: IntArray) -> FloatArray:
    """Angle inside each counterclockwise face at each of its corners, radians, shape (total,).

    Face i has the vertices corners[offsets[i]:offsets[i + 1]] of `coords`, shape (nv, 2).

    >>> square = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]])
    >>> np.degrees(corner_angles(square, np.arange(4), np.array([0, 4]))).tolist()
    [90.0, 90.0, 90.0, 90.0]
    """
    following = next_corner(offsets)
    ahead = coords[corners[following]] - coords[corners]
    back = np.empty_like(ahead)
    back[following] = -ahead
    out: FloatArray = np.mod(
        np.arctan2(back[:, 1], back[:, 0]) - np.arctan2(ahead[:, 1], ahead[:, 0]), 2 * np.pi
    )
    return out


@dataclass(frozen=True)
class FaceSet:
    """The faces of a pattern, each in its piece, with what is looked up of their corners.

    Attributes
    ----------
    polygons, piece : shape (nf,).
    corners_key : face * vertex_count + vertex of all faces' corners, sorted, shape (total,);
        corners_angle : the angle inside the face at each of them, radians.
    pieces_key : piece * vertex_count + vertex of all pieces' corners, sorted; pieces_angle : the
        sum of the angles inside the piece's faces at each of them, radians.
    """

    polygons: Shapes
    piece: IntArray
    corners_key: IntArray
    corners_angle: FloatArray
    pieces_key: IntArray
    pieces_angle: FloatArray
    vertex_count: int

    @classmethod
    def of(cls, pattern: CreasePattern, faces_piece: IntArray) -> FaceSet:
        coords, corners = pattern.vertices_coords, pattern.faces_vertices
        count = len(coords)
        angles = corner_angles(coords, corners, pattern.faces_offsets)
        face = np.repeat(np.arange(pattern.face_count), np.diff(pattern.faces_offsets))
        key = face * count + corners
        order = np.argsort(key)
        pieces_key, group = np.unique(faces_piece[face] * count + corners, return_inverse=True)
        return cls(
            shapely.polygons(shapely.linearrings(coords[corners], indices=face)),
            faces_piece,
            key[order],
            angles[order],
            pieces_key,
            np.asarray(np.bincount(group, angles), np.float64),
            count,
        )

    def angles_in_faces(self, faces: IntArray, vertices: IntArray) -> FloatArray:
        """Angles inside faces at corners of them, radians."""
        place = np.searchsorted(self.corners_key, faces * self.vertex_count + vertices)
        return self.corners_angle[place]

    def angles_in_pieces(self, pieces: IntArray, vertices: IntArray) -> FloatArray:
        """Angles inside pieces at corners of them, radians."""
        place = np.searchsorted(self.pieces_key, pieces * self.vertex_count + vertices)
        return self.pieces_angle[place]

    def are_corners(self, faces: IntArray, vertices: IntArray) -> BoolArray:
        """Whether vertices are corners of faces."""
        key = faces * self.vertex_count + vertices
        place = np.minimum(np.searchsorted(self.corners_key, key), len(self.corners_key) - 1)
        out: BoolArray = self.corners_key[place] == key
        return out


@dataclass(frozen=True)
class TabOffers:
    """Tabs that may be chosen; several of different heights on a side of a seam.

    Attributes
    ----------
    row : 2 * seam + side, rising, shape (m,).
    height_mm, piece : shape (m,). corners : vertices at the tab's foot, shape (m, 2).
    tops : outer corners, shape (m, 2, 2). polygons : the tabs, shape (m,).
    """

    row: IntArray
    height_mm: FloatArray
    piece: IntArray
    corners: IntArray
    tops: FloatArray
    polygons: Shapes

    def chosen(self, which: BoolArray) -> TabOffers:
        """Some of them."""
        return TabOffers(*(getattr(self, name)[which] for name in self.__dataclass_fields__))

    @property
    def shrunk(self) -> Shapes:
        """The tabs less what only touches them."""
        out: Shapes = shapely.buffer(self.polygons, -_CONTACT_MM, join_style="mitre")
        return out

    @property
    def grown(self) -> Shapes:
        """The tabs and what is kept free around them."""
        out: Shapes = shapely.buffer(self.polygons, _FREE_MM, join_style="mitre")
        return out


def tab_offers(
    pattern: CreasePattern,
    faces_piece: IntArray,
    sides: SeamSides,
    tab_mm: float,
    angle_deg: float,
    *,
    alike: bool = False,
) -> TabOffers:
    """Tabs of several heights on both sides of all seams.

    They overlap no face of their piece, and lie within the face beyond their seam.

    Parameters
    ----------
    faces_piece : number of the piece that each face is in, shape (nf,).
    tab_mm : greatest height; angle_deg : greatest angle at the foot of a tab, up to 90.
    alike : whether both tabs of a seam are mirror images, to be laid onto each other.
    """
    faces = FaceSet.of(pattern, faces_piece)
    ends = pattern.vertices_coords[sides.vertices].reshape(-1, 2, 2)  # row 2 * seam + side
    mitre = _mitres(faces, sides, angle_deg)
    if alike:  # the first end of a side is the second of the other
        both = mitre.reshape(-1, 2, 2)
        mitre = np.minimum(both, both[:, ::-1, ::-1]).reshape(-1, 2)
    length = np.hypot(*(ends[:, 1] - ends[:, 0]).T)
    possible = (mitre >= np.radians(_LEAST_MITRE_DEG)).all(axis=1)
    mitre[~possible] = np.pi / 4
    most = np.minimum(tab_mm, (1 - _LEAST_TOP) * length / (1 / np.tan(mitre)).sum(axis=1))
    row = np.flatnonzero(possible).repeat(len(_SHARES))
    height = most[row] * np.tile(_SHARES, int(possible.sum()))
    tall = height >= _LEAST_MM
    row, height = row[tall], height[tall]
    tops = outer_corners(ends[row], height, mitre[row])
    polygons = shapely.polygons(np.concatenate([ends[row][:, ::-1], tops], axis=1))
    beyond = _faces_beyond(pattern, faces, sides)
    room = shapely.buffer(beyond, _CONTACT_MM, join_style="mitre")
    within = shapely.covers(room[row], polygons)
    row = row[within]
    offers = TabOffers(
        row,
        height[within],
        sides.pieces.reshape(-1)[row],
        sides.vertices.reshape(-1, 2)[row],
        tops[within],
        polygons[within],
    )
    return offers.chosen(~_touch_faces(offers, faces))


def _mitres(faces: FaceSet, sides: SeamSides, angle_deg: float) -> FloatArray:
    """Greatest angle at both ends of a tab's foot, radians, shape (2 n, 2).

    A tab takes at most half of the gap beside its piece, and stays within the face beyond.
    """
    free = np.radians(_FREE_DEG)
    inside = faces.angles_in_pieces(sides.pieces[:, :, None], sides.vertices)
    gaps = np.asarray(2 * np.pi - inside, np.float64)
    beyond = faces.angles_in_faces(sides.faces[:, ::-1, None], sides.vertices[:, ::-1, ::-1])
    mitre = np.minimum(np.radians(angle_deg), gaps.reshape(-1, 2) / 2 - free)
    out: FloatArray = np.minimum(mitre, beyond.reshape(-1, 2) - free)
    return out


def _faces_beyond(pattern: CreasePattern, faces: FaceSet, sides: SeamSides) -> Shapes:
    """The face of the other side, laid beside the edge of each side, shape (2 n,)."""
    ends = pattern.vertices_coords[sides.vertices]
    first = np.asarray(ends[:, 0] @ [1, 1j], np.complex128)
    second = np.asarray(ends[:, 1, ::-1] @ [1, 1j], np.complex128)
    beyond = np.stack(
        [
            _moved(faces.polygons[sides.faces[:, 1]], second, first),
            _moved(faces.polygons[sides.faces[:, 0]], first[:, ::-1], second[:, ::-1]),
        ],
        axis=1,
    )
    return beyond.reshape(-1)


def _moved(polygons: Shapes, start: NDArray[np.complex128], goal: NDArray[np.complex128]) -> Shapes:
    """Polygons moved rigidly, each so that its complex edge `start` (n, 2) comes onto `goal`."""
    turn = np.diff(goal)[:, 0] / np.diff(start)[:, 0]
    turn /= np.abs(turn)
    shift = goal.mean(axis=1) - turn * start.mean(axis=1)
    points, index = shapely.get_coordinates(polygons, return_index=True)
    z = (points @ [1, 1j]) * turn[index] + shift[index]
    rings = shapely.linearrings(np.column_stack([z.real, z.imag]), indices=index)
    out: Shapes = shapely.polygons(rings)
    return out


def _touch_faces(offers: TabOffers, faces: FaceSet) -> BoolArray:
    """Which tabs have a face of their piece within them, or close by without a common corner."""
    tab, face = shapely.STRtree(faces.polygons).query(offers.grown, predicate="intersects")
    same = faces.piece[face] == offers.piece[tab]
    tab, face = tab[same], face[same]
    near = faces.are_corners(face[:, None], offers.corners[tab]).any(axis=1)
    hit = ~near | shapely.intersects(offers.shrunk[tab], faces.polygons[face])
    out: BoolArray = np.zeros(len(offers.row), bool)
    out[tab[hit]] = True
    return out


def tab_clashes(offers: TabOffers) -> list[set[int]]:
    """For each tab the numbers of those on its piece, of other seams, that are too near to it."""
    a, b = shapely.STRtree(offers.grown).query(offers.polygons, predicate="intersects")
    apart = offers.row[a] // 2 != offers.row[b] // 2
    rivals = (offers.piece[a] == offers.piece[b]) & apart
    a, b = a[rivals], b[rivals]
    corners = offers.corners
    near = (corners[a][:, :, None] == corners[b][:, None]).any(axis=(1, 2))
    hit = ~near | shapely.intersects(offers.shrunk[a], offers.polygons[b])
    against: list[set[int]] = [set() for _ in range(len(offers.row))]
    for i, j in np.column_stack([a[hit], b[hit]]).tolist():
        against[i].add(j)
        against[j].add(i)
    return against
