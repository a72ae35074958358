"""Setbacks: the distance that a panel keeps from each of its creases, at every height.

The hinge axes lie at height z = 0. At a crease that folds by rho, a panel is set back by

    s(z) = s0 + max(0, z tan(rho / 2))      valleys, rho > 0: they close above their axis
    s(z) = s0 + max(0, -z tan(|rho| / 2))   mountains: they close below it

so that in the folded state the two bevels are parallel, 2 s0 cos(rho / 2) apart. s0 is the largest
of what the flat gap, the clearance at the target and the hinge need. Edges of the boundary that
come together when folded, as those of a ring that is cut open, are set back as a crease is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fab.pattern.closing_edges import closing_edges, closing_edges_by_angles
from fab.pattern.crease_pattern import CreasePattern
from fab.pattern.open_cuts import edges_between
from solver.polygons import next_corner
from solver.vectors import FloatArray, IntArray

__all__ = ["Setbacks", "Sides", "setbacks", "setbacks_of_folds", "sides_of"]


@dataclass(frozen=True)
class Setbacks:
    """Setbacks of both panels from every edge, mm; none at the outline where it does not close.

    Attributes
    ----------
    axis_mm : shape (ne,), s0: at the height of the axis.
    above, below : shape (ne,), growth of the setback with height above and with depth below.
    clearance_mm : shape (ne,), the least distance of the two panels at the target; NaN where there
        are not two.
    """

    axis_mm: FloatArray
    above: FloatArray
    below: FloatArray
    clearance_mm: FloatArray

    def at(self, z_mm: float) -> FloatArray:
        """Setback from every edge at a height, shape (ne,)."""
        slope = self.above if z_mm > 0 else self.below
        return self.axis_mm + abs(z_mm) * slope


def setbacks(
    pattern: CreasePattern,
    heights_mm: tuple[float, float],
    *,
    gap_mm: float,
    clearance_mm: float,
    hinge_mm: FloatArray,
    limit_deg: float = 180.0,
) -> Setbacks:
    """Setbacks from the fold angles of a pattern.

    heights_mm : bottom and top of the panels, over the axes. gap_mm : least gap when flat.
    clearance_mm : least gap at the target, between panels with a common crease.
    hinge_mm : shape (ne,), the setback that the hinge of each crease needs. limit_deg : creases
    that fold further count as folded by that angle.

    Borders that meet each other in the folded form, by its coordinates or else by the fold angles,
    are set back as creases of that angle are.
    Infinite where the angle leaves no clearance at any setback: at 180 degrees, unless the axis is
    outside of the panels on the side that opens.
    """
    shared = pattern.edges_faces[:, 1] >= 0
    angle = pattern.edges_foldAngle.copy()
    if np.abs(angle).max(initial=0.0) <= limit_deg:  # else borders do not meet
        known = pattern.folded_coords is not None
        closing, closing_angle = (closing_edges if known else closing_edges_by_angles)(pattern)
        shared[closing], angle[closing] = True, closing_angle[:, None]
    back = setbacks_of_folds(
        np.clip(angle, -limit_deg, limit_deg),
        heights_mm,
        gap_mm=gap_mm,
        clearance_mm=clearance_mm,
        hinge_mm=hinge_mm,
    )
    return Setbacks(
        np.where(shared, back.axis_mm, 0.0),
        np.where(shared, back.above, 0.0),
        np.where(shared, back.below, 0.0),
        np.where(shared, back.clearance_mm, np.nan),
    )


def setbacks_of_folds(
    angle_deg: FloatArray,
    heights_mm: tuple[float, float],
    *,
    gap_mm: float,
    clearance_mm: float,
    hinge_mm: FloatArray,
) -> Setbacks:
    """Setbacks from creases that fold by these angles, degrees, shape (ne,); see `setbacks`."""
    half = np.radians(angle_deg) / 2
    slope = np.tan(np.minimum(np.abs(half), np.pi / 2))
    valley = half > 0
    low, high = heights_mm
    # panels that lie off their axis come nearest to each other with the corner next to it
    off = np.where(valley, max(0.0, -high), max(0.0, low))
    cosine, sine = np.cos(half), np.sin(np.abs(half))
    cosine[np.abs(cosine) < 1e-12] = 0.0
    with np.errstate(divide="ignore", invalid="ignore"):
        needed = (clearance_mm / 2 - off * sine) / cosine
    needed[np.isnan(needed)] = 0.0
    axis = np.maximum(np.maximum(gap_mm / 2, needed), hinge_mm)
    with np.errstate(invalid="ignore"):
        clearance = 2 * (axis * cosine + off * sine)
    return Setbacks(axis, np.where(valley, slope, 0.0), np.where(valley, 0.0, slope), clearance)


@dataclass(frozen=True)
class Sides:
    """Every side of every face, numbered as in `faces_vertices`: from that corner to the next.

    Attributes
    ----------
    start, along, inward : shape (total, 2): corner, unit direction, unit normal into the face.
    length_mm : shape (total,).
    edges : shape (total,), the edge under each side.
    offsets : face i has the sides offsets[i]:offsets[i + 1].
    """

    start: FloatArray
    along: FloatArray
    inward: FloatArray
    length_mm: FloatArray
    edges: IntArray
    offsets: IntArray

    @property
    def faces(self) -> IntArray:
        """The face of every side, shape (total,)."""
        return np.repeat(np.arange(len(self.offsets) - 1), np.diff(self.offsets))


def sides_of(pattern: CreasePattern) -> Sides:
    """The sides of all faces of a pattern."""
    corners, offsets = pattern.faces_vertices, pattern.faces_offsets
    following = corners[next_corner(offsets)]
    start = pattern.vertices_coords[corners]
    side = pattern.vertices_coords[following] - start
    length = np.hypot(*side.T)
    with np.errstate(invalid="ignore", divide="ignore"):
        along = side / length[:, None]
    edges = edges_between(pattern, np.column_stack([corners, following]))
    inward = np.column_stack([-along[:, 1], along[:, 0]])
    return Sides(start, along, inward, length, edges, offsets)
