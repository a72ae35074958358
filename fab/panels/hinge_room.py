"""The room that hinges have: sides, runs and vertex distances of creases."""

from __future__ import annotations

import numpy as np

from fab.panels.bevelled_panels import Panels, inset, spans
from fab.pattern.crease_pattern import CreasePattern
from solver.vectors import FloatArray, IntArray

__all__ = ["crease_runs", "crease_sides", "vertex_distances"]


def crease_sides(pattern: CreasePattern, panels: Panels) -> tuple[IntArray, IntArray]:
    """For every crease its side in the first and in the second face; -1 where no panel stands.

    Cuts (C) are no creases.
    """
    first = np.full(len(pattern.edges_vertices), -1)
    second = np.full(len(pattern.edges_vertices), -1)
    standing = np.zeros(pattern.face_count, bool)
    standing[panels.faces] = True
    edge, face = panels.sides.edges, panels.sides.faces
    side = np.flatnonzero(pattern.edges_joining[edge] & standing[face])
    is_first = pattern.edges_faces[edge[side], 0] == face[side]
    first[edge[side[is_first]]] = side[is_first]
    second[edge[side[~is_first]]] = side[~is_first]
    return first, second


def crease_runs(
    panels: Panels, one: IntArray, two: IntArray, levels_mm: FloatArray, up_to_axis: bool
) -> FloatArray:
    """From where to where both panels stand along some creases at all levels, mm, shape (k, 2).

    one, two : sides of the creases in their first and second faces. up_to_axis : whether there must
    be room from the panels up to the axis, between the setbacks of their other creases.
    """
    length = panels.sides.length_mm[one]
    low, high = np.zeros(len(one)), length.copy()  # hinges stay between the ends of their crease
    for z in levels_mm.tolist():
        own = panels.setbacks.at(z)[panels.sides.edges[one]]
        for across in (own, np.zeros(len(one))) if up_to_axis else (own,):
            # the first face runs along its crease, the second one against it
            start, end = spans(panels.sides, panels.setbacks, z, one, across)
            low, high = np.maximum(low, start), np.minimum(high, end)
            start, end = spans(panels.sides, panels.setbacks, z, two, across)
            low, high = np.maximum(low, length - end), np.minimum(high, length - start)
    return np.column_stack([low, high])


def vertex_distances(
    pattern: CreasePattern, panels: Panels, levels_mm: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Least and largest distance of panel corners from their vertex, mm, shapes (nv,).

    At a corner of angle a between setbacks s1 and s2: sqrt(s1^2 + s2^2 + 2 s1 s2 cos a) / sin a.
    Of panels that keep all sides; infinite and 0 where there is none.
    """
    sides, back = panels.sides, panels.setbacks
    least = np.full(len(pattern.vertices_coords), np.inf)
    largest = np.zeros(len(pattern.vertices_coords))
    standing = np.zeros(pattern.face_count, bool)
    standing[panels.faces] = True
    for z in levels_mm.tolist():
        moved, kept = inset(sides.start, sides.offsets, back.at(z)[sides.edges])
        chosen = np.repeat(kept & standing, np.diff(sides.offsets))
        far = np.hypot(*(moved - sides.start)[chosen].T)
        np.maximum.at(largest, pattern.faces_vertices[chosen], far)
        np.minimum.at(least, pattern.faces_vertices[chosen], far)
    return least, largest
