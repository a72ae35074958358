"""Holes through panels, to align them by."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import shapely
from numpy.typing import NDArray

from fab.errors import Finding, Severity, counted, first_few
from fab.geometry.bodies import Bodies
from fab.geometry.extrusion import circle, walls
from fab.geometry.half_edges import HalfEdges, bodies_from, half_edges, triangles_within
from fab.panels.bevelled_panels import Panels
from fab.panels.hinges import ROUND_SIDES
from solver.vectors import FloatArray, IntArray

__all__ = ["drilled"]


def drilled(panels: Panels, hole_mm: float, wall_mm: float) -> tuple[Panels, list[Finding]]:
    """The panels with a hole through each, where it is farthest from their sides at all heights.

    hole_mm : diameter. wall_mm : least wall beside a hole. Panels without room for both stay whole,
    and a finding names them.
    """
    edges = half_edges(panels.bodies)
    levels = edges.bottoms_and_tops(len(panels.bodies))
    free = shapely.intersection(*(_outlines(panels, edges, sides) for sides in levels))
    least = hole_mm / 2 / np.cos(np.pi / ROUND_SIDES) + wall_mm
    area = shapely.buffer(free, 0.0)  # without what has none, such as where sides only touch
    room = np.flatnonzero(~shapely.is_empty(area))
    across = shapely.maximum_inscribed_circle(area[room], tolerance=least / 100)
    radii = np.zeros(len(free))
    radii[room] = shapely.length(across)
    wide = np.flatnonzero(radii >= least)
    centres = shapely.get_coordinates(shapely.get_point(across[radii[room] >= least], 0))
    out = replace(panels, bodies=_pierced(panels, edges, wide, centres, hole_mm / 2))
    narrow = panels.faces[radii < least]
    widest = float(radii[radii < least].max(initial=0.0))
    if not len(narrow):
        return out, []
    sides = "its sides at all heights; it"
    if len(narrow) > 1:
        sides = "their sides at all heights; the widest of them"
    text = (
        f"{counted(len(narrow), 'panel has', 'panels have')} no hole: hole_mm = {hole_mm:g} with "
        f"wall_mm = {wall_mm:g} beside it needs {2 * least:.4g} mm between {sides} has "
        f"{2 * widest:.4g}. Lower hole_mm or wall_mm, or enlarge the sheet."
    )
    return out, [Finding("hole-missing", Severity.WARNING, text, panels=first_few(narrow))]


def _outlines(panels: Panels, edges: HalfEdges, sides: IntArray) -> NDArray[np.object_]:
    """The polygons of level sides, shape (n,), seen from above; none has a hole."""
    rows = np.flatnonzero(np.isin(edges.sides, sides))
    corners = panels.bodies.vertices_coords[edges.start[rows], :2]
    lines = shapely.linearrings(corners, indices=np.searchsorted(sides, edges.sides[rows]))
    return np.asarray(shapely.polygons(lines))


def _pierced(
    panels: Panels, edges: HalfEdges, chosen: IntArray, centres: FloatArray, radius: float
) -> Bodies:
    """The panels with a hole in the chosen ones, shape (k,), around centres, shape (k, 2)."""
    if not len(chosen):
        return panels.bodies
    bodies, count = panels.bodies, ROUND_SIDES
    ring = shapely.get_coordinates(circle(np.zeros(2), radius, count, around=True))[:-1][::-1]
    places = np.empty((len(chosen), 2, count, 3))
    places[..., :2] = (centres[:, None] + ring)[:, None]
    places[..., 2] = np.array(panels.heights_mm)[:, None]
    coords = np.concatenate([bodies.vertices_coords, places.reshape(-1, 3)])
    first = len(bodies.vertices_coords) + 2 * count * np.arange(len(chosen))[:, None]
    corner = np.arange(count)
    following = np.roll(corner, -1)
    bottoms, tops = (sides[chosen, None] for sides in edges.bottoms_and_tops(len(bodies)))
    # clockwise, seen from outside
    rings = [
        (
            corner + first + count,
            following + first + count,
            np.broadcast_to(tops, places.shape[::2]),
        ),
        (following + first, corner + first, np.broadcast_to(bottoms, places.shape[::2])),
    ]
    start, end, sides = (
        np.concatenate([old, *(ring[k].ravel() for ring in rings)])
        for k, old in enumerate((edges.start, edges.end, edges.sides))
    )
    covers, side = triangles_within(replace(edges, start=start, end=end, sides=sides), coords)
    around = walls(corner, following, count) + first[:, :, None]
    plane = len(edges.bodies) + np.tile(corner, 2) + count * np.arange(len(chosen))[:, None]
    return bodies_from(
        coords,
        np.concatenate([bodies.vertices_body, np.repeat(chosen, 2 * count)]),
        np.concatenate([covers, around.reshape(-1, 3)]),
        np.concatenate([side, plane.ravel()]),
    )
