"""Overlaps of a flat sheet with itself."""

from __future__ import annotations

import numpy as np
import shapely

from fab.geometry.rings import ring_areas
from solver.errors import InvalidValue
from solver.graphs import edge_keys
from solver.mesh import Edges, boundary_loops
from solver.vectors import FloatArray, IntArray

__all__ = ["overlapping_faces"]


# Faces that lie on each other by less than this share of the sheet's diagonal are in contact.
_CONTACT_REL = 1e-9


def overlapping_faces(
    flat: FloatArray, corner: IntArray, offsets: IntArray, edges: Edges
) -> IntArray:
    """Pairs of faces whose interiors overlap in the plane, shape (n, 2).

    Overlaps no deeper than 1e-9 of the sheet's diagonal are contact, not overlap.

    corner, offsets : the faces, one after another, as in `QuadMesh.polygons`.

    A sheet of one piece whose faces all turn the same way and whose outline does not cross itself
    cannot overlap; only where that fails are the faces compared pair by pair.
    """
    try:
        loops = boundary_loops(edges)
    except InvalidValue:  # an outline that touches itself in a vertex proves nothing
        loops = []
    areas = ring_areas(flat[corner], offsets)
    one_winding = len(loops) == 1 and areas.min() > 0
    if one_winding and shapely.is_valid(shapely.polygons(flat[loops[0]])):
        return np.empty((0, 2), np.int64)
    return _overlapping_pairs(flat[corner], offsets)


def _overlapping_pairs(corners: FloatArray, offsets: IntArray) -> IntArray:
    """Faces that cross themselves, each with itself, and pairs that overlap, shape (n, 2)."""
    ring = np.repeat(np.arange(len(offsets) - 1), np.diff(offsets))
    shapes = shapely.polygons(shapely.linearrings(corners, indices=ring))
    valid = shapely.is_valid(shapes)
    crossed = np.flatnonzero(~valid)
    plain = np.flatnonzero(valid)
    # by rounding, neighbours overlap in slivers: a face overlaps what it meets when shrunk.
    # Whether two shapes meet is decided exactly, where their common area may fail to be built.
    contact = _CONTACT_REL * float(np.hypot(*np.ptp(corners, axis=0)))
    shrunk = shapely.buffer(shapes[plain], -contact, join_style="mitre")
    first, second = plain[shapely.STRtree(shapes[plain]).query(shrunk, predicate="intersects")]
    pairs = np.column_stack([first, second])[first != second]
    keys = np.unique(edge_keys(pairs, len(shapes)))
    overlapping = np.column_stack(np.divmod(keys, len(shapes)))
    return np.concatenate([np.column_stack([crossed, crossed]), overlapping]).astype(np.int64)
