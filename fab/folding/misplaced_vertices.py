"""Vertices that do not fold flat because of where they are, while their fold angles are right."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fab.pattern.crease_pattern import FLAT_ANGLE_DEG, CreasePattern
from fab.pattern.sectors import sectors_of
from solver.vectors import IntArray

__all__ = ["Misplaced", "misplaced_vertices"]


@dataclass(frozen=True)
class Misplaced:
    """A vertex whose creases fold by 180 degrees, as they must, but whose sectors do not let them.

    Attributes
    ----------
    kawasaki_deg : alternating sum of its sectors.
    distance_mm : by how much it has to move, to first order, to fold flat.
    """

    vertex: int
    kawasaki_deg: float
    distance_mm: float


def misplaced_vertices(pattern: CreasePattern, vertices: IntArray) -> list[Misplaced]:
    """Which of some interior vertices are misplaced, in their order."""
    creases = pattern.edges_joining & (np.abs(pattern.edges_foldAngle) > FLAT_ANGLE_DEG)
    sectors = sectors_of(pattern, creases)
    found = []
    for vertex in vertices.tolist():
        ends = slice(*np.searchsorted(sectors.vertices, [vertex, vertex + 1]))
        edges = sectors.edges[ends]
        flat = np.abs(np.abs(pattern.edges_foldAngle[edges]) - 180) <= FLAT_ANGLE_DEG
        if len(edges) % 2 or not flat.all():
            continue
        sign = np.where(np.arange(len(edges)) % 2, -1.0, 1.0)
        off = float(sign @ sectors.angles[ends])
        start, end = pattern.vertices_coords[pattern.edges_vertices[edges]].swapaxes(0, 1)
        length = np.hypot(*(end - start).T)
        direction = sectors.directions[ends]
        across = np.column_stack([np.sin(direction), -np.cos(direction)]) / length[:, None]
        slope = float(np.hypot(*(2 * sign @ across)))
        distance = abs(off) / slope if slope > 0 else float("inf")
        found.append(Misplaced(vertex, float(np.degrees(abs(off))), distance))
    return found
