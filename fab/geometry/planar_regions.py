"""Regions into which lines that meet in their ends alone divide the plane."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fab.geometry.planar_graph import walks_of
from fab.geometry.rings import ring_areas
from solver.graphs import labels
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["Regions", "points_within", "regions_of", "walls_passed"]

OUTSIDE = -1


@dataclass(frozen=True)
class Regions:
    """Bounded regions, and what is on either side of each edge.

    Attributes
    ----------
    corners, offsets : walks around the regions, counterclockwise, as `enclosed_faces` gives them.
    sides : shape (ne, 2), region on the left and on the right of each edge; -1 outside of all.
    islands : regions that hold connected lines within them, one for each such part, in any order.
    outer : shape (ne,), whether an edge is next to the outside of all.
    """

    corners: IntArray
    offsets: IntArray
    sides: IntArray
    islands: IntArray

    @property
    def count(self) -> int:
        """Number of bounded regions."""
        return len(self.offsets) - 1

    @property
    def outer(self) -> BoolArray:
        """Which edges have the outside on one side, shape (ne,)."""
        found: BoolArray = (self.sides == OUTSIDE).any(axis=1)
        return found

    def broken(self) -> IntArray:
        """Regions that are no simple polygons: with islands, or that touch themselves; rising."""
        own = np.repeat(np.arange(self.count), np.diff(self.offsets))
        span = int(self.corners.max(initial=-1)) + 1
        keys = np.sort(own * span + self.corners)
        touching = keys[1:][np.diff(keys) == 0] // max(span, 1)
        return np.unique(np.concatenate([touching, self.islands]))


def regions_of(vertices_coords: FloatArray, edges_vertices: IntArray) -> Regions:
    """Regions between edges that do not cross, none of them with a free end."""
    import shapely

    corners, offsets, walk = walks_of(vertices_coords, edges_vertices)
    count = len(edges_vertices)
    bounded = ring_areas(vertices_coords[corners], offsets) > 0
    sizes = np.diff(offsets)
    region = np.where(bounded, np.cumsum(bounded) - 1, OUTSIDE)
    ring, bounds = corners[np.repeat(bounded, sizes)], np.cumsum(sizes[bounded])
    bounds = np.concatenate([[0], bounds]).astype(np.int64)
    around = np.flatnonzero(~bounded)
    islands = np.empty(0, np.int64)
    if len(around) > 1:  # walks around connected parts, some of which are within regions
        own = np.repeat(np.arange(len(bounds) - 1), np.diff(bounds))
        shapes = shapely.polygons(shapely.linearrings(vertices_coords[ring], indices=own))
        part = labels(edges_vertices, len(vertices_coords))
        first = corners[offsets[around]]
        point, inside = shapely.STRtree(shapes).query(
            shapely.points(vertices_coords[first]), "within"
        )
        other = part[first[point]] != part[ring[bounds[inside]]]
        point, inside = point[other], inside[other]
        area = ring_areas(vertices_coords[ring], bounds)
        order = np.lexsort((inside, area[inside], point))
        point, inside = point[order], inside[order]
        least = np.ones(len(point), bool)
        least[1:] = point[1:] != point[:-1]
        islands = inside[least]
        region[around[point[least]]] = islands
    sides = np.column_stack([region[walk[:count]], region[walk[count:]]])
    return Regions(ring, bounds, sides, islands)


def walls_passed(regions: Regions, walls: BoolArray) -> IntArray:
    """How many walls there are at least between each region and the outside of all, shape (n,).

    walls : shape (ne,), which edges are walls; others are passed freely.
    """
    nodes = np.where(regions.sides == OUTSIDE, regions.count, regions.sides)
    group = labels(nodes[~walls], regions.count + 1)
    pairs = group[nodes[walls]]
    depth = np.full(int(group.max()) + 1, -1)
    front = group[[regions.count]]
    level = 0
    while len(front):
        depth[front] = level
        level += 1
        near = np.concatenate([pairs[np.isin(pairs[:, k], front), 1 - k] for k in (0, 1)])
        front = np.unique(near[depth[near] < 0])
    out: IntArray = depth[group[:-1]]
    return out


def points_within(points: FloatArray, coords: FloatArray, regions: Regions) -> IntArray:
    """The region that each point is in, shape (n,); -1 outside of all.

    coords : vertices of the regions. Of regions around each other it is the innermost.
    """
    import shapely

    out = np.full(len(points), OUTSIDE)
    if not len(points) or not regions.count:
        return out
    own = np.repeat(np.arange(regions.count), np.diff(regions.offsets))
    ring = coords[regions.corners]
    shapes = shapely.polygons(shapely.linearrings(ring, indices=own))
    point, region = shapely.STRtree(shapes).query(shapely.points(points), "intersects")
    area = ring_areas(ring, regions.offsets)
    order = np.lexsort((-region, -area[region], point))  # the last of each point is the least
    out[point[order]] = region[order]
    return out
