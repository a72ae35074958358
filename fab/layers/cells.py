"""The parts that the edges of a flat-folded sheet divide it into, and the faces that cover each."""

from __future__ import annotations

from dataclasses import dataclass
from functools import reduce
from itertools import pairwise
from operator import or_

import numpy as np
from scipy.sparse.csgraph import breadth_first_order
from scipy.spatial import cKDTree

from fab.geometry.arrangement import Arrangement, arrangement
from fab.geometry.planar_graph import walks_of
from fab.geometry.rings import ring_areas
from fab.layers.flat_form import FlatForm
from solver.graphs import labels, weighted_graph
from solver.polygons import next_corner
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["Cells", "cells_of", "members"]

# Cells narrower than so many times the reach of points are none.
_NARROW = 4.0


@dataclass(frozen=True)
class Cells:
    """A planar graph of all edges of a folded sheet, and what covers its faces, the cells.

    Attributes
    ----------
    vertices_coords, edges_vertices : the graph, shapes (nv, 2) and (ne, 2).
    edges_cells : shape (ne, 2), the cells on the left and on the right of each edge.
    corners, offsets : of the cells, counterclockwise; around each component of the graph runs one
        clockwise, which is that of what is outside of it.
    masks : of each cell, the faces of the sheet that cover it, as the bits of a number.
    real : shape (n,), cells with an area that is more than rounding.
    edges_lines, edges_offsets : edge e of the graph is part of the sheet's edges
        edges_lines[edges_offsets[e]:edges_offsets[e + 1]].
    narrow : number of cells that are neither real nor without any area.
    """

    vertices_coords: FloatArray
    edges_vertices: IntArray
    edges_cells: IntArray
    corners: IntArray
    offsets: IntArray
    masks: list[int]
    real: BoolArray
    edges_lines: IntArray
    edges_offsets: IntArray
    narrow: int

    @property
    def all_faces(self) -> int:
        """The faces of the sheet that cover any real cell, as bits."""
        return reduce(or_, (self.masks[cell] for cell in np.flatnonzero(self.real)), 0)

    def faces(self, cell: int) -> IntArray:
        """The faces of the sheet that cover a cell, rising."""
        return members(self.masks[cell])


def members(mask: int) -> IntArray:
    """The numbers of the bits that are set.

    >>> members(0b1001).tolist()
    [0, 3]
    """
    data = np.frombuffer(mask.to_bytes(-(-mask.bit_length() // 8), "little"), np.uint8)
    return np.flatnonzero(np.unpackbits(data, bitorder="little"))


def cells_of(form: FlatForm) -> Cells:
    """The cells of a folded form.

    Points within `reach_mm` are one, and edges that are so near to each other on each other.
    Raises `InvalidState` where edges have too many crossings.
    """
    sheet = form.sheet
    points = _joined(form.coords, form.reach_mm)
    ends = points[sheet.edges_vertices]
    long = np.flatnonzero((ends[:, 0] != ends[:, 1]).any(axis=1))
    graph = arrangement(ends[long], form.reach_mm, needles=False)
    edges_lines, edges_offsets = long[graph.edges_lines], graph.edges_offsets
    corners, offsets, walk = walks_of(graph.vertices_coords, graph.edges_vertices)
    count = len(graph.edges_vertices)
    edges_cells = np.column_stack([walk[:count], walk[count:]])
    toggles = _toggles(sheet.edges_faces, edges_lines, edges_offsets)
    areas = ring_areas(graph.vertices_coords[corners], offsets)
    masks = _masks(graph, edges_cells, toggles, areas)
    sides = graph.vertices_coords[corners]
    lengths = np.hypot(*(sides[next_corner(offsets)] - sides).T)
    around = np.add.reduceat(lengths, offsets[:-1])
    covered = np.array([mask != 0 for mask in masks], bool)
    real = (areas > _NARROW / 2 * form.reach_mm * around) & covered
    narrow = int(((areas > 0) & covered & ~real).sum())
    return Cells(
        graph.vertices_coords,
        graph.edges_vertices,
        edges_cells,
        corners,
        offsets,
        masks,
        real,
        edges_lines,
        edges_offsets,
        narrow,
    )


def _joined(coords: FloatArray, reach: float) -> FloatArray:
    """Points within reach of each other in the place of the first of them."""
    pairs = cKDTree(coords).query_pairs(reach, output_type="ndarray")
    group = labels(pairs, len(coords))
    _, first = np.unique(group, return_index=True)
    return np.asarray(coords[first][group], np.float64)


def _toggles(edges_faces: IntArray, edges_lines: IntArray, offsets: IntArray) -> list[int]:
    """Of each edge of the graph, the faces that are on one of its sides alone, as bits."""
    out = []
    faces = edges_faces.tolist()
    lines, bounds = edges_lines.tolist(), offsets.tolist()
    for begin, end in pairwise(bounds):
        mask = 0
        for line in lines[begin:end]:
            for face in faces[line]:
                if face >= 0:
                    mask ^= 1 << face
        out.append(mask)
    return out


def _masks(
    graph: Arrangement, edges_cells: IntArray, toggles: list[int], areas: FloatArray
) -> list[int]:
    """The faces that cover each cell: those that one has to enter on the way from outside."""
    edges = graph.edges_vertices
    component = labels(edges, len(graph.vertices_coords))[edges[:, 0]]
    count = len(areas)
    left, right = edges_cells.T
    number = np.arange(1, len(edges) + 1)
    both = np.concatenate([left, right]), np.concatenate([right, left])
    # of several edges between two cells, any one is as good
    keys, at = np.unique(both[0] * count + both[1], return_index=True)
    pairs = np.column_stack(np.divmod(keys, count))
    links = weighted_graph(np.tile(number, 2)[at], pairs, count)
    masks = [0] * count
    _, first = np.unique(component, return_index=True)
    for edge in first.tolist():
        own = np.flatnonzero(component == component[edge])
        cells = np.unique(edges_cells[own])
        outer = int(cells[np.argmin(areas[cells])])
        start = _around(graph, component != component[edge], toggles, edges[own])
        order, before = breadth_first_order(links, outer, directed=False)
        masks[outer] = start
        if len(order) == 1:
            continue  # a tree of edges, around which all is outside
        via = np.asarray(links[before[order[1:]], order[1:]]).ravel() - 1
        for cell, parent, over in zip(
            order[1:].tolist(), before[order[1:]].tolist(), via.tolist(), strict=True
        ):
            masks[cell] = masks[parent] ^ toggles[over]
    return masks


def _around(graph: Arrangement, others: BoolArray, toggles: list[int], own: IntArray) -> int:
    """The faces that cover a component of the graph, by a ray from its leftmost vertex."""
    if not others.any():
        return 0
    vertices = np.unique(own)
    coords = graph.vertices_coords
    x, y = coords[vertices[np.argmin(coords[vertices, 0])]]
    edges = np.flatnonzero(others)
    (ax, ay), (bx, by) = coords[graph.edges_vertices[edges]].swapaxes(0, 1).swapaxes(1, 2)
    over = (ay <= y) != (by <= y)
    with np.errstate(divide="ignore", invalid="ignore"):
        at = ax + (y - ay) / (by - ay) * (bx - ax)
    mask = 0
    for edge in edges[over & (at < x)].tolist():
        mask ^= toggles[edge]
    return mask
