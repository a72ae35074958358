"""Which closed surfaces bound the panels and webs, each alone and all joined?"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from scipy.spatial import cKDTree

from fab.hinges import Webs
from fab.panels import Panels, Prisms
from fab.polygons import next_corner
from solver.errors import InvalidValue
from solver.vectors import FloatArray, IntArray

__all__ = ["TriangleMesh", "cap_triangles", "joined_mesh", "prism_meshes"]


@dataclass(frozen=True)
class TriangleMesh:
    """A closed surface: vertices (nv, 3) in mm, triangles (nt, 3) seen from outside."""

    vertices_coords: FloatArray
    triangles: IntArray


def prism_meshes(prisms: Prisms) -> list[TriangleMesh]:
    """One closed mesh for each prism."""
    out: list[TriangleMesh] = [None] * len(prisms)  # type: ignore[list-item]
    sizes = np.diff(prisms.offsets)
    for n in np.unique(sizes).tolist():
        members = np.flatnonzero(sizes == n)
        rows = prisms.offsets[members][:, None] + np.arange(n)
        bottom, top = prisms.bottom[rows], prisms.top[rows]
        low, high = cap_triangles(bottom), cap_triangles(top)
        i = np.arange(n)
        j = (i + 1) % n
        sides = np.concatenate([np.column_stack([i, j, j + n]), np.column_stack([i, j + n, i + n])])
        for place, member in enumerate(members.tolist()):
            height = prisms.heights_mm[member]
            vertices = np.zeros((2 * n, 3))
            vertices[:n, :2] = bottom[place]
            vertices[n:, :2] = top[place]
            vertices[n:, 2] = height
            faces = np.concatenate([low[place][:, ::-1], high[place] + n, sides])
            out[member] = TriangleMesh(vertices, faces)
    return out


def cap_triangles(rings: FloatArray) -> IntArray:
    """Triangles of simple counterclockwise polygons, shape (k, n, 2) -> (k, n - 2, 3).

    Up to four corners a fan from the corner that gives its thinnest triangle most area. Polygons
    with more get their Delaunay triangles, so that corners on a straight side make no slivers.

    Raises `InvalidValue` for polygons that cross or touch themselves.
    """
    n = rings.shape[1]
    if n > 4:
        return np.stack([_delaunay(ring) for ring in rings])
    corners = np.arange(n)
    fans = np.stack(
        [
            np.column_stack([np.full(n - 2, s), (s + k) % n, (s + k + 1) % n])
            for s in corners
            for k in [np.arange(1, n - 1)]
        ]
    )
    points = rings[:, fans]
    one, two = points[..., 1, :] - points[..., 0, :], points[..., 2, :] - points[..., 0, :]
    thinnest = (one[..., 0] * two[..., 1] - one[..., 1] * two[..., 0]).min(axis=2)
    return np.asarray(fans[thinnest.argmax(axis=1)], np.int64)


def _delaunay(ring: FloatArray) -> IntArray:
    """Constrained Delaunay triangles of one polygon, counterclockwise, shape (n - 2, 3)."""
    outline = shapely.Polygon(ring)
    if not outline.is_valid:
        why = shapely.is_valid_reason(outline)
        raise InvalidValue("polygon", why, "neither cross nor touch itself", "Split the face.")
    found = shapely.orient_polygons(shapely.constrained_delaunay_triangles(outline))
    corners = shapely.get_coordinates(found).reshape(-1, 4, 2)[:, :3]
    return np.asarray(cKDTree(ring).query(corners)[1], np.int64)


def joined_mesh(panels: Panels, webs: Webs) -> TriangleMesh:
    """All panels and webs as one closed surface, in the flat state, ready to print.

    Built directly, without boolean operations: each web's four end corners are vertices of the
    panels' walls, so the surfaces meet exactly, and stay closed when rounded to single precision.
    Panels without a web are bodies of their own. Faces must be star-shaped seen from their hub
    (all convex polygons and all quads are).
    """
    prisms = panels.prisms
    total = len(prisms.bottom)
    count = len(prisms)
    following = next_corner(prisms.offsets)
    owner = np.repeat(np.arange(count), np.diff(prisms.offsets))
    height = prisms.heights_mm[owner]
    hubs = _hubs(prisms)

    def at(points: FloatArray, z: FloatArray | float) -> FloatArray:
        return np.column_stack([points, np.broadcast_to(z, len(points))])

    web_bottom = webs.prisms.bottom.reshape(-1, 4, 2)
    web_top = webs.prisms.top.reshape(-1, 4, 2)
    web_height = np.repeat(webs.prisms.heights_mm, 4)
    # vertex numbers: panel corners below and above, hubs below and above, webs below and above
    vertices = np.concatenate(
        [
            at(prisms.bottom, 0.0),
            at(prisms.top, height),
            at(hubs[0], 0.0),
            at(hubs[1], prisms.heights_mm),
            at(web_bottom.reshape(-1, 2), 0.0),
            at(web_top.reshape(-1, 2), web_height),
        ]
    )
    low, high = np.arange(total), np.arange(total) + total
    hub_low, hub_high = 2 * total + owner, 2 * total + count + owner
    web = 2 * total + 2 * count + np.arange(4 * len(webs.prisms)).reshape(-1, 4)
    over = web + 4 * len(webs.prisms)

    # sides with a web: in the direction of the side, corners p then q touch the web
    side = np.concatenate([webs.sides[:, 0], webs.sides[:, 1]])
    p, q = np.concatenate([web[:, 1], web[:, 3]]), np.concatenate([web[:, 0], web[:, 2]])
    p_up, q_up = np.concatenate([over[:, 1], over[:, 3]]), np.concatenate([over[:, 0], over[:, 2]])
    plain = np.ones(total, bool)
    plain[side] = False
    a, b = low[plain], low[following[plain]]
    a_up, b_up = high[plain], high[following[plain]]
    wa, wb = low[side], low[following[side]]
    wa_up, wb_up = high[side], high[following[side]]

    parts = [
        # top and bottom: fans around the hubs; the bottom passes the webs' corners
        (high, high[following], hub_high),
        (b, a, hub_low[plain]),
        (p, wa, hub_low[side]),
        (q, p, hub_low[side]),
        (wb, q, hub_low[side]),
        # walls without a web, and walls around the place where a web touches
        (a, b, b_up),
        (a, b_up, a_up),
        (wa, p, p_up),
        (wa, p_up, wa_up),
        (wa_up, p_up, q_up),
        (wa_up, q_up, wb_up),
        (wb_up, q_up, wb),
        (q_up, q, wb),
        # webs: above, below, and both ends
        (over[:, 0], over[:, 1], over[:, 2]),
        (over[:, 0], over[:, 2], over[:, 3]),
        (web[:, 1], web[:, 0], web[:, 3]),
        (web[:, 1], web[:, 3], web[:, 2]),
        (web[:, 1], web[:, 2], over[:, 2]),
        (web[:, 1], over[:, 2], over[:, 1]),
        (web[:, 3], web[:, 0], over[:, 0]),
        (web[:, 3], over[:, 0], over[:, 3]),
    ]
    triangles = np.concatenate([np.column_stack(part) for part in parts])
    return TriangleMesh(vertices, triangles.astype(np.int64))


def _hubs(prisms: Prisms) -> tuple[FloatArray, FloatArray]:
    """A point of each bottom and top ring from which all its corners are seen."""
    sizes = np.diff(prisms.offsets)
    hubs = []
    for ring in (prisms.bottom, prisms.top):
        hub = np.empty((len(prisms), 2))
        for n in np.unique(sizes).tolist():
            members = np.flatnonzero(sizes == n)
            corners = ring[prisms.offsets[members][:, None] + np.arange(n)]
            hub[members] = corners.mean(axis=1)
            if n == 4:
                # the middle of the inner diagonal sees all corners, also where one is reflex
                rows = np.arange(len(members))
                fan = cap_triangles(corners)
                hub[members] = (corners[rows, fan[:, 0, 0]] + corners[rows, fan[:, 0, 2]]) / 2
        hubs.append(hub)
    return hubs[0], hubs[1]
