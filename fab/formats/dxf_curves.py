"""Entities of a DXF file as polygonal lines."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from ezdxf.math import arc_angle_span_deg

from solver.vectors import FloatArray

__all__ = ["DRAWN", "flattened", "is_curved", "weight"]

# Entities that are lines or curves.
DRAWN = frozenset(["LINE", "LWPOLYLINE", "POLYLINE", "ARC", "CIRCLE", "ELLIPSE", "SPLINE"])
_SPLINE_FRAME = 16
_LEAST_PER_TURN = 8
_MOST_PER_ARC = 100_000
# Over the length of a chord: points nearer to it are on it.
_STRAIGHT = 1e-9


def is_curved(entity: Any) -> bool:
    """Whether the entity has to be approximated."""
    kind = entity.dxftype()
    if kind == "LWPOLYLINE":
        return bool(entity.has_arc)
    if kind == "POLYLINE":
        return bool(entity.is_2d_polyline and entity.has_arc)
    return bool(kind != "LINE")


def weight(entity: Any) -> int:
    """About how many lines an entity becomes, without its being flattened."""
    kind = entity.dxftype()
    if kind == "LWPOLYLINE":
        return len(entity) + 1
    if kind == "POLYLINE":
        return len(entity.vertices) + 1
    if kind == "SPLINE":
        return 4 * (int(entity.control_point_count()) + len(entity.fit_points)) + 1
    return 1


def flattened(entity: Any, tolerance: float) -> FloatArray:
    """Points along a drawn entity, shape (n, 3), first and last alike where it is closed.

    tolerance : greatest distance from the curve, in units of the drawing.

    Empty for a mesh of faces (a kind of POLYLINE). Raises whatever ezdxf does for entities whose
    numbers make no curve.
    """
    kind = entity.dxftype()
    if kind == "LINE":
        return np.array([entity.dxf.start, entity.dxf.end], float)
    if kind == "LWPOLYLINE":
        rows = np.array(entity.get_points("xyb"), float).reshape(-1, 3)
        flat = _with_bulges(rows, bool(entity.closed), tolerance)
        return _from_ocs(entity, flat, float(entity.dxf.elevation))
    if kind == "POLYLINE":
        return _polyline(entity, tolerance)
    if kind in ("ARC", "CIRCLE"):
        start, span = 0.0, 360.0
        if kind == "ARC":
            start = float(entity.dxf.start_angle)
            span = arc_angle_span_deg(start, float(entity.dxf.end_angle))
        x, y, z = entity.dxf.center
        radius = abs(float(entity.dxf.radius))
        flat = _arc(x, y, radius, math.radians(start), math.radians(span), tolerance)
        if span == 360.0:
            flat[-1] = flat[0]
        return _from_ocs(entity, flat, z)
    coarse = _LEAST_PER_TURN if kind == "ELLIPSE" else 4
    points = np.array([tuple(p) for p in entity.flattening(tolerance, coarse)], float)
    return _straightened(points.reshape(-1, 3))


def _straightened(points: FloatArray) -> FloatArray:
    """The two ends alone of points that are in line, as of the straight splines of Illustrator."""
    if len(points) < 3:
        return points
    along = points[-1] - points[0]
    places = (points - points[0]) @ along
    offsets = np.linalg.norm(np.cross(points - points[0], along), axis=1)
    straight = offsets.max() <= _STRAIGHT * (along @ along) and (np.diff(places) >= 0).all()
    return points[[0, -1]] if straight else points


def _polyline(entity: Any, tolerance: float) -> FloatArray:
    if entity.is_poly_face_mesh or entity.is_polygon_mesh:
        return np.zeros((0, 3))
    vertices = [v for v in entity.vertices if not v.dxf.flags & _SPLINE_FRAME]
    places = np.array([tuple(v.dxf.location) for v in vertices], float).reshape(-1, 3)
    if entity.is_3d_polyline:
        return np.vstack([places, places[:1]]) if entity.is_closed else places
    bulges = [float(v.dxf.bulge) for v in vertices]
    rows = np.column_stack([places[:, :2], bulges])
    flat = _with_bulges(rows, bool(entity.is_closed), tolerance)
    elevation = entity.dxf.elevation.z if entity.dxf.hasattr("elevation") else 0.0
    return _from_ocs(entity, flat, float(elevation))


def _with_bulges(rows: FloatArray, closed: bool, tolerance: float) -> FloatArray:
    """Points of a polyline whose rows are x, y and the bulge of the arc to the next point.

    A bulge is the tangent of a quarter of the arc's angle, positive where it turns left.
    """
    if closed and len(rows):
        rows = np.vstack([rows, rows[:1]])
    places, bulges = rows[:, :2], rows[:-1, 2]
    if not bulges.any():
        return places
    out = [places[:1]]
    for start, end, bulge in zip(places[:-1], places[1:], bulges.tolist(), strict=True):
        out.append(_bulge(start, end, bulge, tolerance)[1:] if bulge else end[None])
    return np.vstack(out)


def _bulge(start: FloatArray, end: FloatArray, bulge: float, tolerance: float) -> FloatArray:
    chord = end - start
    length = float(np.hypot(*chord))
    if length == 0.0:
        return np.array([start, end])
    span = 4 * math.atan(bulge)
    radius = length * (1 + bulge * bulge) / (4 * abs(bulge))
    left = np.array([-chord[1], chord[0]])
    centre = (start + end) / 2 + left * (1 - bulge * bulge) / (4 * bulge)
    first = math.atan2(start[1] - centre[1], start[0] - centre[0])
    flat = _arc(float(centre[0]), float(centre[1]), radius, first, span, tolerance)
    flat[0], flat[-1] = start, end
    return flat


def _arc(
    x: float, y: float, radius: float, first: float, span: float, tolerance: float
) -> FloatArray:
    """Points on an arc, whose chords are off it by up to `tolerance`, shape (n, 2)."""
    part = min(tolerance / (2 * radius), 0.5) if radius > 0 else 0.5
    step = max(4 * math.asin(math.sqrt(part)), 1e-12)
    most = max(abs(span) / step, abs(span) / math.tau * _LEAST_PER_TURN, 1.0)
    angles = first + np.linspace(0.0, span, min(math.ceil(most), _MOST_PER_ARC) + 1)
    return np.column_stack([x + radius * np.cos(angles), y + radius * np.sin(angles)])


def _from_ocs(entity: Any, flat: FloatArray, elevation: float) -> FloatArray:
    """Points of the entity's own plane in the coordinates of the drawing."""
    points = np.column_stack([flat, np.full(len(flat), elevation)])
    ocs = entity.ocs()
    if not ocs.transform:
        return points
    axes = np.array([tuple(axis) for axis in (ocs.ux, ocs.uy, ocs.uz)], float)
    out: FloatArray = points @ axes
    return out
