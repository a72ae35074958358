"""Panels with their barrels, arms and pins, each in one closed surface.

The walls of a panel are opened where arms meet them, and the corners of the arms become corners of
the sides around.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import shapely

from fab.geometry.bodies import Bodies
from fab.geometry.extrusion import circle
from fab.geometry.half_edges import HalfEdges, bodies_from, half_edges, triangles_within
from fab.panels.barrels import IN_TOP, Barrels, barrel_rows, solid_barrels
from fab.panels.bevelled_panels import Panels
from fab.panels.hinge_room import crease_sides
from fab.panels.hinges import ROUND_SIDES, HingeSettings
from fab.panels.knuckles import Knuckles
from fab.pattern.crease_pattern import CreasePattern
from solver.vectors import FloatArray, IntArray, norm

__all__ = ["barrels_of", "with_knuckles"]

# Walls are where their setbacks put them, but for rounding.
_ON_WALL_MM = 1e-6


def with_knuckles(
    pattern: CreasePattern, panels: Panels, knuckles: Knuckles, settings: HingeSettings
) -> Bodies:
    """Every panel in one piece with its barrels, arms and pins, where it has any.

    An arm meets the wall of its panel over its full height. The wall is left out there, and the
    corners of the arm become corners of the sides around it.
    """
    barrels = barrels_of(pattern, panels, knuckles)
    body = np.searchsorted(panels.faces, panels.sides.faces[barrels.sides])
    edges = half_edges(panels.bodies)
    bottoms, tops = edges.bottoms_and_tops(len(panels.bodies))
    pin = settings.pin_mm / 2
    rings = [
        shapely.get_coordinates(circle(np.zeros(2), radius, ROUND_SIDES, around=around))[:-1]
        for radius, around in ((pin, False), (pin + settings.play_mm, True))
    ]
    coords, owners = [panels.bodies.vertices_coords], [panels.bodies.vertices_body]
    triangles, planes = [], []
    vertex, plane = len(coords[0]), len(edges.bodies)
    on_wall = np.empty((len(body), 2, 3), np.int64)
    for row in solid_barrels(
        barrels, panels.sides, panels.setbacks, panels.heights_mm[1], rings[0], rings[1]
    ):
        panel = body[row.barrels]
        owner = panel[row.owner]
        coords.append(row.coords.reshape(-1, 3))
        owners.append(np.repeat(panel, row.coords.shape[1]))
        triangles.append(row.triangles + vertex)
        level = np.where(row.planes == IN_TOP, tops[owner], bottoms[owner])
        planes.append(np.where(row.planes < 0, level, row.planes + plane))
        on_wall[row.barrels] = row.corners + vertex
        vertex += len(coords[-1])
        plane += int(row.planes.max()) + 1
    vertices = np.concatenate(coords)
    walls = _opened(edges, panels, barrels, body, on_wall, vertices)
    covers, side = triangles_within(walls, vertices)
    return bodies_from(
        vertices,
        np.concatenate(owners),
        np.concatenate([covers, *triangles]),
        np.concatenate([side, *planes]),
    )


def barrels_of(pattern: CreasePattern, panels: Panels, knuckles: Knuckles) -> Barrels:
    """The barrels of all hinges, one after another."""
    both = np.column_stack(crease_sides(pattern, panels))[knuckles.creases]
    return barrel_rows(
        knuckles.creases,
        both,
        panels.sides.length_mm[both[:, 0]],
        knuckles.ends,
        knuckles.counts,
        knuckles.play_mm,
    )


def _opened(
    edges: HalfEdges,
    panels: Panels,
    barrels: Barrels,
    body: IntArray,
    on_wall: IntArray,
    coords: FloatArray,
) -> HalfEdges:
    """The half edges of panels with corners at their barrels, their walls left out there.

    body : the panel of each barrel. on_wall : shape (n, 2, 3), vertices of each barrel, at both of
    its ends, at the bottom, axis and top of the wall.
    """
    met = [
        _along_walls(edges, panels, barrels, body, coords, z)
        for z in (panels.heights_mm[0], 0.0, panels.heights_mm[1])
    ]
    is_level = np.zeros(len(edges.bodies), bool)  # bottoms and tops
    for sides in edges.bottoms_and_tops(len(panels.bodies)):
        is_level[sides] = True
    split = np.concatenate([edge for edge, _ in met])
    number = np.concatenate([barrel for _, barrel in met])
    level = np.repeat(np.arange(3), [len(edge) for edge, _ in met])
    # every edge that is split begins at its own start, then follow both ends of each barrel
    cut = np.unique(split)
    edge = np.concatenate([cut, np.repeat(split, 2)])
    barrel = np.concatenate([np.full(len(cut), -1), np.repeat(number, 2)])
    start = np.concatenate([edges.start[cut], on_wall[number, :, level].ravel()])
    order = np.lexsort((norm(coords[start] - coords[edges.start[edge]]), edge))
    edge, barrel, start = edge[order], barrel[order], start[order]
    goes_on = np.append(edge[1:] == edge[:-1], False)
    end = np.where(goes_on, np.roll(start, -1), edges.end[edge])
    within = goes_on & (barrel >= 0) & (barrel == np.roll(barrel, -1))
    kept = ~within | is_level[edges.sides[edge]]
    # walls end at the barrels: upwards at the near end of each, downwards at its far end
    wall = np.empty((len(body), 2), np.int64)
    for column, (half, at) in enumerate((met[0], met[2])):
        upright = ~is_level[edges.sides[half]]
        wall[at[upright], column] = edges.sides[half[upright]]
    near, far = on_wall[:, 0], on_wall[:, 1]
    whole = np.ones(len(edges.start), bool)
    whole[cut] = False
    return replace(
        edges,
        start=np.concatenate(
            [edges.start[whole], start[kept], near[:, :2].ravel(), far[:, 1:].ravel()]
        ),
        end=np.concatenate([edges.end[whole], end[kept], near[:, 1:].ravel(), far[:, :2].ravel()]),
        sides=np.concatenate(
            [edges.sides[whole], edges.sides[edge[kept]], wall.ravel(), wall.ravel()]
        ),
    )


def _along_walls(
    edges: HalfEdges,
    panels: Panels,
    barrels: Barrels,
    body: IntArray,
    coords: FloatArray,
    z_mm: float,
) -> tuple[IntArray, IntArray]:
    """Half edges at a height along the wall behind a barrel, and that barrel, shape (k,) each."""
    level = np.abs(coords[:, 2] - z_mm) <= _ON_WALL_MM
    at_level = np.flatnonzero(level[edges.start] & level[edges.end])
    owner = edges.bodies[edges.sides[at_level]]  # rising
    first = np.searchsorted(owner, body)
    counts = np.searchsorted(owner, body, "right") - first
    barrel = np.repeat(np.arange(len(body)), counts)
    nth = np.arange(len(barrel)) + np.repeat(first + counts - np.cumsum(counts), counts)
    edge = at_level[nth]
    side = barrels.sides[barrel]
    ends = coords[np.column_stack([edges.start[edge], edges.end[edge]]), :2]
    ends = ends - panels.sides.start[side][:, None]
    inward = (ends * panels.sides.inward[side][:, None]).sum(axis=2)
    along = (ends * panels.sides.along[side][:, None]).sum(axis=2)
    off = np.abs(inward - panels.setbacks.at(z_mm)[barrels.creases[barrel], None]).max(axis=1)
    covers = (along.min(axis=1) <= barrels.runs[barrel, 0]) & (
        along.max(axis=1) >= barrels.runs[barrel, 1]
    )
    fits = (off <= _ON_WALL_MM) & covers
    return edge[fits], barrel[fits]
