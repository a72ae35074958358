r"""Where does a glue tab stand on a seam, and how large may it be?

A tab is a trapezoid on one of the two pieces, to be glued under the face across the seam:

        b---------a      edge of the piece, its face above
         \       /
          q-----p        height by setting; both mitres leave the neighbours' room free
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely

from fab.geometry.rings import next_corner
from fab.layout.face_sets import outer_corners
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["Banks", "corner_angles", "placed_tabs"]

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


@dataclass(frozen=True)
class Banks:
    """Both sides of every seam: the edge of a piece, and the face that comes to lie beyond it.

    Attributes
    ----------
    ends : shape (n, 2, 2, 2): seam, side, end, coordinate; the piece's face lies to the left.
    vertices : numbers of the ends, shape (n, 2, 2).
    pieces : shape (n, 2).
    gaps : angle outside of the piece at both ends, radians, shape (n, 2, 2).
    beyond : the face of the other side, laid beside the edge, polygons of shape (n, 2).
    beyond_angles : its angles at both ends, radians, shape (n, 2, 2).
    """

    ends: FloatArray
    vertices: IntArray
    pieces: IntArray
    gaps: FloatArray
    beyond: object
    beyond_angles: FloatArray


def corner_angles(coords: FloatArray, corners: IntArray, offsets: IntArray) -> FloatArray:
    """Angle inside each counterclockwise face at each of its corners, radians, shape (total,)."""
    following = next_corner(offsets)
    ahead = coords[corners[following]] - coords[corners]
    back = np.empty_like(ahead)
    back[following] = -ahead
    out: FloatArray = np.mod(
        np.arctan2(back[:, 1], back[:, 0]) - np.arctan2(ahead[:, 1], ahead[:, 0]), 2 * np.pi
    )
    return out


def placed_tabs(
    banks: Banks,
    tab_mm: float,
    angle_deg: float,
    faces: object,
    faces_piece: IntArray,
    corners_key: IntArray,
    vertex_count: int,
) -> tuple[IntArray, FloatArray]:
    """For each seam the side that carries its tab, -1 for none, and the tab's corners p, q.

    Tabs overlap no face of their piece and no other tab of it, and lie within the face that they
    are glued to. The side with room for the higher tab carries it; of equal ones the piece with
    fewer tabs so far.

    faces : the polygons of the faces; faces_piece : their pieces, shape (nf,); corners_key : sorted
    face * vertex_count + vertex of all faces' corners.
    """
    count = len(banks.ends)
    ends = banks.ends.reshape(-1, 2, 2)  # row 2 * seam + side
    free = np.radians(_FREE_DEG)
    mitre = np.minimum(np.radians(angle_deg), banks.gaps.reshape(-1, 2) / 2 - free)
    mitre = np.minimum(mitre, banks.beyond_angles.reshape(-1, 2) - free)
    length = np.hypot(*(ends[:, 1] - ends[:, 0]).T)
    possible = (mitre >= np.radians(_LEAST_MITRE_DEG)).all(axis=1)
    mitre[~possible] = np.pi / 4
    most = np.minimum(tab_mm, (1 - _LEAST_TOP) * length / (1 / np.tan(mitre)).sum(axis=1))
    rows = np.flatnonzero(possible).repeat(len(_SHARES))
    height = most[rows] * np.tile(_SHARES, int(possible.sum()))
    tall = height >= _LEAST_MM
    rows, height = rows[tall], height[tall]
    tops = outer_corners(ends[rows], height, mitre[rows])
    tabs = shapely.polygons(np.concatenate([ends[rows][:, ::-1], tops], axis=1))
    beyond = np.asarray(banks.beyond).reshape(-1)
    room = shapely.buffer(beyond, _CONTACT_MM, join_style="mitre")
    good = shapely.covers(room[rows], tabs)
    rows, height, tops, tabs = rows[good], height[good], tops[good], tabs[good]
    piece = banks.pieces.reshape(-1)[rows]
    corners = banks.vertices.reshape(-1, 2)[rows]
    shrunk = shapely.buffer(tabs, -_CONTACT_MM, join_style="mitre")
    grown = shapely.buffer(tabs, _FREE_MM, join_style="mitre")

    # no face of the piece lies in a tab, nor close by unless it shares a corner
    tab, face = shapely.STRtree(np.asarray(faces)).query(grown, predicate="intersects")
    same = faces_piece[face] == piece[tab]
    tab, face = tab[same], face[same]
    key = face[:, None] * vertex_count + corners[tab]
    place = np.minimum(np.searchsorted(corners_key, key), len(corners_key) - 1)
    near = (corners_key[place] == key).any(axis=1)
    hit = ~near | shapely.intersects(shrunk[tab], np.asarray(faces)[face])
    good = np.ones(len(rows), bool)
    good[tab[hit]] = False

    one, two = shapely.STRtree(grown).query(tabs, predicate="intersects")
    other = (piece[one] == piece[two]) & (rows[one] // 2 != rows[two] // 2) & good[one] & good[two]
    one, two = one[other], two[other]
    near = (corners[one][:, :, None] == corners[two][:, None]).any(axis=(1, 2))
    hit = ~near | shapely.intersects(shrunk[one], tabs[two])
    return _chosen(rows, height, tops, piece, good, one[hit], two[hit], count)


def _chosen(
    rows: IntArray,
    height: FloatArray,
    tops: FloatArray,
    piece: IntArray,
    good: BoolArray,
    one: IntArray,
    two: IntArray,
    count: int,
) -> tuple[IntArray, FloatArray]:
    """Seam after seam the highest tab that those chosen before leave room for."""
    against: dict[int, set[int]] = {}
    for i, j in zip(one.tolist(), two.tolist(), strict=True):
        against.setdefault(i, set()).add(j)
        against.setdefault(j, set()).add(i)
    offers: list[list[int]] = [[] for _ in range(count)]
    for number in np.flatnonzero(good).tolist():
        offers[rows[number] // 2].append(number)
    side = np.full(count, -1)
    corners = np.full((count, 2, 2), np.nan)
    carried: dict[int, int] = {}
    taken: set[int] = set()
    for seam, offered in enumerate(offers):
        open_to = [number for number in offered if not against.get(number, set()) & taken]
        if open_to:
            best = min(
                open_to,
                key=lambda n: (-round(float(height[n]), 6), carried.get(int(piece[n]), 0), n),
            )
            taken.add(best)
            carried[int(piece[best])] = carried.get(int(piece[best]), 0) + 1
            side[seam] = rows[best] % 2
            corners[seam] = tops[best]
    return side, corners
