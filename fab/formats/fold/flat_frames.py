"""Flat sheets in any plane of space, seen so that they are patterns in the plane."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fab.geometry.rings import ring_areas
from solver.polygons import next_corner
from solver.vectors import FloatArray, IntArray, cross

__all__ = ["FlatSheet", "flat_sheet", "is_open"]

# Of the size: points nearer to a plane are in it; files have their coordinates with some digits.
_PLANE_REL = 1e-6
_AXES = "xyz"


@dataclass(frozen=True)
class FlatSheet:
    """Points of a sheet in its plane.

    Attributes
    ----------
    coords : shape (nv, 2), seen from the upper side.
    plane : what is reported of the plane; empty for that of x and y.
    side_assumed : whether nothing in the file says which side of the plane is the upper one.
    """

    coords: FloatArray
    plane: str
    side_assumed: bool


def flat_sheet(coords: FloatArray, faces: tuple[IntArray, IntArray] | None) -> FlatSheet | None:
    """The sheet of points, shape (nv, 3), that are in one plane; None where they are not.

    faces : corners and offsets; the upper side is the one on which they are counterclockwise, and
    without them that towards which the plane's axis points. In the plane of x and y the upper side
    is that of z, whatever the faces are.
    """
    size = float(np.ptp(coords, axis=0).max())
    span = np.ptp(coords, axis=0)
    if span[2] <= _PLANE_REL * size:
        return FlatSheet(np.ascontiguousarray(coords[:, :2]), "", False)
    area = np.zeros(3)
    if faces is not None:
        corners, offsets = faces
        first = np.repeat(corners[offsets[:-1]], np.diff(offsets))
        arm = coords[corners] - coords[first]
        area = cross(arm, arm[next_corner(offsets)]).sum(axis=0)
    assumed = faces is None or float(np.abs(area).max()) <= _PLANE_REL * size**2
    for axis in (1, 0):
        if span[axis] <= _PLANE_REL * size:
            above = assumed or area[axis] > 0
            flat = coords[:, [0, 2]] if axis == 1 else coords[:, [1, 2]]
            # right-handed: x, -z seen from y; y, z seen from x
            flat = (
                flat * ([1, -1] if above else [1, 1])
                if axis == 1
                else flat * ([1, 1] if above else [-1, 1])
            )
            plane = f"the sheet is in the plane of {'yz' if axis == 0 else 'xz'}"
            seen = f"{'+' if above else '-'}{_AXES[axis]}"
            return FlatSheet(flat + 0.0, f"{plane}: seen from {seen}.", assumed)
    local = (coords - coords.mean(axis=0)) / size
    _, _, rows = np.linalg.svd(local, full_matrices=False)
    normal = rows[2]
    if np.abs(local @ normal).max() > _PLANE_REL:
        return None
    up = normal[np.argmax(np.abs(normal))] if assumed else area @ normal
    normal = normal if up > 0 else -normal
    along = np.eye(3)[0 if abs(normal[0]) < 0.9 else 1]
    u = along - (along @ normal) * normal
    u /= np.sqrt(u @ u)
    v = cross(normal[None], u[None])[0]
    x, y, z = np.round(normal, 4) + 0.0
    text = f"the sheet is in a tilted plane: seen from ({x:g}, {y:g}, {z:g})."
    return FlatSheet(coords @ np.column_stack([u, v]), text, assumed)


def is_open(coords: FloatArray, faces: tuple[IntArray, IntArray] | None, pairs: IntArray) -> bool:
    """Whether a sheet in the plane, shape (nv, 2), is unfolded rather than folded flat.

    All its faces turn the same way; without faces, its edges meet in common vertices alone.
    """
    if faces is not None:
        areas = ring_areas(coords[faces[0]], faces[1])
        return bool((areas >= 0).all() or (areas <= 0).all())
    from fab.geometry.planar_graph import first_crossing

    ends = coords[pairs]
    pairs = pairs[(ends[:, 0] != ends[:, 1]).any(axis=1)]
    near = _PLANE_REL * float(np.hypot(*np.ptp(coords, axis=0)))
    return bool(
        len(pairs) and first_crossing(coords, pairs, near, np.zeros(len(pairs), bool)) is None
    )
