"""Parameters u and v of a surface that has none: a box in space, seen along one axis."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from solver.errors import InvalidValue
from solver.vectors import FloatArray, cross, norm, unit

__all__ = ["Frame", "vector"]

# Two boxes are equally tight where their areas differ by less than this share.
_TIE = 1e-3


@dataclass(frozen=True)
class Frame:
    """A box whose first two coordinates, from -1 to 1, are the parameters u and v.

    Of several sheets of a surface one above another the uppermost along the third axis counts.

    Attributes
    ----------
    origin : the middle of the box, shape (3,).
    axes : unit vectors along u, v and upwards as rows, right-handed, shape (3, 3).
    half_widths : of the box along the three axes, shape (3,).
    """

    origin: FloatArray
    axes: FloatArray
    half_widths: FloatArray

    def __post_init__(self) -> None:
        for name, shape in (("origin", (3,)), ("axes", (3, 3)), ("half_widths", (3,))):
            value = np.array(getattr(self, name), np.float64)
            if value.shape != shape or not np.isfinite(value).all():
                raise InvalidValue(name, value, f"be finite, of shape {shape}", "Give numbers.")
            value.setflags(write=False)
            object.__setattr__(self, name, value)
        if np.abs(self.axes @ self.axes.T - np.eye(3)).max() > 1e-9 or np.linalg.det(self.axes) < 0:
            cure = "Frame.along makes them from one or two directions."
            raise InvalidValue("axes", self.axes.tolist(), "be orthonormal, right-handed", cure)
        if not (self.half_widths > 0).all():
            cure = "A box has a width along every axis."
            raise InvalidValue("half_widths", self.half_widths.tolist(), "be greater than 0", cure)

    @classmethod
    def along(
        cls,
        up: ArrayLike,
        rows: ArrayLike | None = None,
        *,
        origin: ArrayLike = (0.0, 0.0, 0.0),
        half_widths: ArrayLike = (1.0, 1.0, 1.0),
    ) -> Frame:
        """The box with the third axis `up`; v runs along `rows`, made perpendicular to it.

        Without `rows`, u runs along the coordinate axis that is the most perpendicular to `up`,
        the first of those that nearly tie: up = z gives u = x and v = y.

        >>> frame = Frame.along([0, 0, 2], half_widths=(2.0, 1.0, 0.5))
        >>> frame.coordinates(np.array([1.0, 1.0, 0.25])).tolist()
        [0.5, 1.0, 0.5]
        """
        third = vector("up", up)
        if rows is None:
            first = np.eye(3)[int(np.argmin(np.round(np.abs(third), 1)))]
            first = unit(first - (first @ third) * third)
        else:
            along = cross(vector("rows", rows), third)
            if norm(along) < 1e-6:
                cure = "Rows run across the direction from which the surface is seen."
                raise InvalidValue("rows", rows, "not be parallel to up", cure)
            first = unit(along)
        return cls(
            np.asarray(origin, np.float64),
            np.stack([first, cross(third, first), third]),
            np.asarray(half_widths, np.float64),
        )

    @classmethod
    def around(cls, points: FloatArray, up: ArrayLike, rows: ArrayLike | None = None) -> Frame:
        """The box around points (n, 3) with the third axis `up`; v runs along `rows`.

        Without `rows` the box is the one of least base, rows run along its shorter side; among
        equal ones u runs as near to a coordinate axis as can be.
        """
        frame = cls.along(up, rows)
        local = points @ frame.axes.T
        if rows is None:
            turn = _tightest(local[:, :2])
            plane = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
            axes = np.vstack([plane @ frame.axes[:2], frame.axes[2]])
            local = points @ axes.T
        else:
            axes = frame.axes
        low, high = local.min(axis=0), local.max(axis=0)
        widths = (high - low) / 2
        if not (widths[:2] > 1e-9 * widths.max()).all():
            cure = "Seen along `up` the surface is a line: give another `up`."
            raise InvalidValue("half_widths", widths.tolist(), "be greater than 0", cure)
        widths[2] = max(widths[2], 1e-9 * float(widths[:2].max()))  # a plane has no height
        return cls((low + high) / 2 @ axes, axes, widths)

    def coordinates(self, points: FloatArray) -> FloatArray:
        """Points (..., 3) measured in the box, all three from -1 to 1 within it, shape (..., 3)."""
        return (points - self.origin) @ self.axes.T / self.half_widths

    def points(self, coordinates: FloatArray) -> FloatArray:
        """The points with such coordinates, both of shape (..., 3)."""
        return self.origin + (coordinates * self.half_widths) @ self.axes


def vector(name: str, value: ArrayLike) -> FloatArray:
    """A direction as a unit vector of shape (3,); refuses zero and what is not finite."""
    given = np.asarray(value, np.float64)
    if given.shape != (3,) or not np.isfinite(given).all() or not given.any():
        raise InvalidValue(name, value, "be a finite vector of length > 0", "Give three numbers.")
    return unit(given)


def _tightest(points: FloatArray) -> float:
    """Angle of u in the rectangle of least area around plane points, in (-pi/2, pi/2]."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        hull = points[ConvexHull(points).vertices]
    except QhullError:  # all on a line: so is the rectangle
        hull = points
    # a rectangle of least area has a side along one of the hull's (Freeman and Shapira 1975)
    side = np.roll(hull, -1, axis=0) - hull
    angle = np.append(np.arctan2(side[:, 1], side[:, 0]) % (np.pi / 2), 0.0)
    along = np.column_stack([np.cos(angle), np.sin(angle)])
    across = np.column_stack([-np.sin(angle), np.cos(angle)])
    length, width = np.ptp(hull @ along.T, axis=0), np.ptp(hull @ across.T, axis=0)
    tie = length * width <= (1 + _TIE) * (length * width).min()
    off = np.minimum(angle, np.pi / 2 - angle)
    best = int(np.flatnonzero(tie)[np.argmin(off[tie])])
    turn = float(angle[best]) if off[best] > 1e-12 else 0.0
    if width[best] > (1 + _TIE) * length[best]:
        turn += np.pi / 2
    return turn - np.pi if turn > np.pi / 2 else turn
