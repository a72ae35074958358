"""Entities of a DXF file as polygonal lines."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from ezdxf.math import arc_angle_span_deg

from solver.vectors import FloatArray

__all__ = ["DRAWN", "flattened", "is_curved", "is_mesh", "weight"]

# Points, shape (n, 3), at parameters, shape (n,).
_Curve = Callable[[FloatArray], FloatArray]
# Entities that are lines or curves.
DRAWN = frozenset(["LINE", "LWPOLYLINE", "POLYLINE", "ARC", "CIRCLE", "ELLIPSE", "SPLINE"])
_SPLINE_FRAME = 16
_LEAST_PER_TURN = 8
_MOST_PER_ARC = 100_000
_MOST_HALVINGS = 20
_MOST_FIT_POINTS = 500
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


def is_mesh(entity: Any) -> bool:
    """Whether it is a mesh of faces, which is a kind of POLYLINE."""
    return entity.dxftype() == "POLYLINE" and bool(
        entity.is_poly_face_mesh or entity.is_polygon_mesh
    )


def weight(entity: Any) -> int:
    """How many lines an entity becomes at least, without its being flattened."""
    kind = entity.dxftype()
    if kind == "LWPOLYLINE":
        return max(len(entity) - 1, 1)
    if kind == "POLYLINE":
        return max(len(entity.vertices) - 1, 1)
    if kind == "SPLINE":  # one for each span between knots, of which few are passed over
        return max(int(entity.control_point_count()) - int(entity.dxf.degree), 1)
    return 1


def flattened(entity: Any, tolerance: float) -> FloatArray:
    """Points along a drawn entity, shape (n, 3), first and last alike where it is closed.

    tolerance : greatest distance from the curve, in units of the drawing.

    Raises whatever ezdxf does for entities whose numbers make no curve.
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
    curve, parameters = _ellipse(entity) if kind == "ELLIPSE" else _spline(entity)
    return _straightened(_along(curve, parameters, tolerance))


def _ellipse(entity: Any) -> tuple[_Curve, FloatArray]:
    """An ellipse as a function of its parameter, and parameters along it."""
    centre = np.array(entity.dxf.center, float)
    major, minor = np.array(entity.dxf.major_axis, float), np.array(entity.minor_axis, float)
    start, end = float(entity.dxf.start_param), float(entity.dxf.end_param)
    span = (end - start) % math.tau or math.tau
    count = max(2, math.ceil(span / math.tau * _LEAST_PER_TURN)) + 1

    def at(t: FloatArray) -> FloatArray:
        out: FloatArray = centre + np.outer(np.cos(t), major) + np.outer(np.sin(t), minor)
        return out

    return at, start + np.linspace(0.0, span, count)


def _spline(entity: Any) -> tuple[_Curve, FloatArray]:
    """A spline as a function of its parameter, and its knots with three parameters between."""
    from scipy.interpolate import BSpline

    if not entity.control_point_count() and len(entity.fit_points) > _MOST_FIT_POINTS:
        raise ValueError("a spline of fit points alone, too many to be solved for")
    tool = entity.construction_tool()
    points = np.array([tuple(p) for p in tool.control_points], float)
    weights = np.array(tool.weights() or np.ones(len(points)), float)
    knots = np.array(tool.knots(), float)
    degree = int(tool.order) - 1
    homogeneous = np.column_stack([points * weights[:, None], weights])
    spline = BSpline(knots, homogeneous, degree)

    def at(t: FloatArray) -> FloatArray:
        value = spline(t)
        out: FloatArray = value[:, :3] / value[:, 3:]
        return out

    ends = np.unique(knots[degree : len(points) + 1])
    between = ends[:-1, None] + np.diff(ends)[:, None] * np.arange(4) / 4
    return at, np.append(between.ravel(), ends[-1])


def _along(curve: _Curve, parameters: FloatArray, tolerance: float) -> FloatArray:
    """Points on a curve at some parameters, and at more of them where chords are off it."""
    points = curve(parameters)
    for _ in range(_MOST_HALVINGS):
        step = np.diff(parameters)
        within = [curve(parameters[:-1] + step * share) for share in (0.25, 0.5, 0.75)]
        chord = np.diff(points, axis=0)
        length = np.linalg.norm(chord, axis=1)
        off = np.zeros(len(step))
        for place in within:
            arm = place - points[:-1]
            area = np.linalg.norm(np.cross(arm, chord), axis=1)
            at_end = np.linalg.norm(arm, axis=1)
            off = np.fmax(off, np.where(length > 0, area / np.where(length > 0, length, 1), at_end))
        rough = np.flatnonzero(off > tolerance)
        if not len(rough) or len(points) > _MOST_PER_ARC:
            break
        parameters = np.insert(parameters, rough + 1, parameters[rough] + step[rough] / 2)
        points = np.insert(points, rough + 1, within[1][rough], axis=0)
    return points


def _straightened(points: FloatArray) -> FloatArray:
    """The two ends alone of points that are in line, as of the straight splines of Illustrator."""
    if len(points) < 3 or bool((points[0] == points[-1]).all()):
        return points
    along = points[-1] - points[0]
    places = (points - points[0]) @ along
    offsets = np.linalg.norm(np.cross(points - points[0], along), axis=1)
    straight = offsets.max() <= _STRAIGHT * (along @ along) and (np.diff(places) >= 0).all()
    return points[[0, -1]] if straight else points


def _polyline(entity: Any, tolerance: float) -> FloatArray:
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
