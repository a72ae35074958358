"""Boxes around plane figures, turned to be as small as they may be."""

from __future__ import annotations

import numpy as np
import shapely

from solver.vectors import FloatArray

__all__ = ["smallest_box"]


def smallest_box(figure: shapely.Geometry) -> FloatArray:
    """Corners of the box of least area around a figure, the first one repeated, shape (5, 2).

    Around points on a line it is their segment, shape (2, 2).

    >>> ring = smallest_box(shapely.LinearRing([(0, 0), (2, 2), (1, 3), (-1, 1)]))
    >>> sorted(np.round(np.hypot(*np.diff(ring, axis=0).T) ** 2).tolist())
    [2.0, 2.0, 8.0, 8.0]
    """
    return np.asarray(shapely.get_coordinates(shapely.oriented_envelope(figure)), np.float64)
