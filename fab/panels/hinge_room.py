"""Room for hinges: the panels beside each crease, their runs along it, and corners at its vertices.

A hinge joins two sides of panels. It has room where both run beside their crease at all of its
heights, and stays away from the corners of panels around the vertices at its ends.
"""

from __future__ import annotations

import numpy as np

from fab.panels.bevelled_panels import Panels
from fab.panels.inset_sides import inset, spans
from fab.pattern.crease_pattern import CreasePattern
from solver.vectors import FloatArray, IntArray

__all__ = ["crease_runs", "crease_sides", "vertex_distances"]


def crease_sides(pattern: CreasePattern, panels: Panels) -> tuple[IntArray, IntArray]:
    """For every crease its side in the first and in the second face, shapes (ne,).

    Sides are numbered as in `panels.sides`; -1 where the face has no panel. Cuts (C) are no
    creases.
    """
    first = np.full(len(pattern.edges_vertices), -1)
    second = np.full(len(pattern.edges_vertices), -1)
    edge, face = panels.sides.edges, panels.sides.faces
    side = np.flatnonzero(pattern.edges_joining[edge] & panels.faces_has_panel[face])
    is_first = pattern.edges_faces[edge[side], 0] == face[side]
    first[edge[side[is_first]]] = side[is_first]
    second[edge[side[~is_first]]] = side[~is_first]
    return first, second


def crease_runs(
    panels: Panels, first: IntArray, second: IntArray, levels_mm: FloatArray, up_to_axis: bool
) -> FloatArray:
    """Where both panels run beside some creases at all levels, start and end, mm, shape (k, 2).

    first, second : shapes (k,), sides of the creases in their first and second faces. levels_mm :
    heights over the axes. up_to_axis : whether there must be room from the panels up to the axis,
    between the setbacks of their other creases. Distances are measured along the first side.
    """
    length = panels.sides.length_mm[first]
    low, high = np.zeros(len(first)), length.copy()  # hinges stay between the ends of their crease
    for z in levels_mm.tolist():
        own = panels.setbacks.at(z)[panels.sides.edges[first]]
        for across in (own, np.zeros(len(first))) if up_to_axis else (own,):
            # the first face runs along its crease, the second one against it
            start, end = spans(panels.sides, panels.setbacks, z, first, across)
            low, high = np.maximum(low, start), np.minimum(high, end)
            start, end = spans(panels.sides, panels.setbacks, z, second, across)
            low, high = np.maximum(low, length - end), np.minimum(high, length - start)
    return np.column_stack([low, high])


def vertex_distances(
    pattern: CreasePattern, panels: Panels, levels_mm: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Least and largest distance of panel corners from their vertex, mm, shapes (nv,).

    levels_mm : heights over the axes at which corners count.

    At a corner of angle a between setbacks s1 and s2: sqrt(s1^2 + s2^2 + 2 s1 s2 cos a) / sin a.
    Of panels that keep all sides; infinite and 0 at vertices without one.
    """
    sides, back = panels.sides, panels.setbacks
    least = np.full(len(pattern.vertices_coords), np.inf)
    largest = np.zeros(len(pattern.vertices_coords))
    for z in levels_mm.tolist():
        moved, kept = inset(sides.start, sides.offsets, back.at(z)[sides.edges])
        chosen = np.repeat(kept & panels.faces_has_panel, np.diff(sides.offsets))
        far = np.hypot(*(moved - sides.start)[chosen].T)
        np.maximum.at(largest, pattern.faces_vertices[chosen], far)
        np.minimum.at(least, pattern.faces_vertices[chosen], far)
    return least, largest
