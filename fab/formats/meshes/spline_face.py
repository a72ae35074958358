"""A face of a CAD model as a rational tensor-product spline, and the arrays that describe it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from solver.vectors import BoolArray, FloatArray

__all__ = ["SplineFace"]


@dataclass(frozen=True)
class SplineFace:
    """A face of a CAD model as a rational tensor-product spline, u and v in [-1, 1] around it.

    Exact within the face; beyond, the spline's outermost pieces go on, and where the surface
    closes on itself it goes on all around. Its normals X_u x X_v point out of the model.

    Attributes
    ----------
    spline : `scipy.interpolate.NdBSpline` with values (n, 4): weight times point, and weight.
    middle, half : the spline's parameters are middle + half (u, v), each of shape (2,).
    start, period : parameters are brought into [start, start + period); inf where open, (2,).
    outline : shapely polygon of the face in the spline's parameters, with its holes.
    """

    spline: Any
    middle: FloatArray
    half: FloatArray
    start: FloatArray
    period: FloatArray
    outline: Any

    def position(self, u: FloatArray, v: FloatArray) -> FloatArray:
        """Points X(u, v), shape (n, 3), in the file's units as millimetres."""
        value = self.spline(self._wrapped(u, v))
        out: FloatArray = value[:, :3] / value[:, 3:]
        return out

    def derivatives(self, u: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
        """X_u and X_v, each (n, 3), by the quotient rule."""
        at = self._wrapped(u, v)
        value = self.spline(at)
        weight = value[:, 3:]
        position = value[:, :3] / weight
        by_u, by_v = (
            half * (slope[:, :3] - position * slope[:, 3:]) / weight
            for half, slope in zip(
                self.half.tolist(),
                (self.spline(at, nu=(1, 0)), self.spline(at, nu=(0, 1))),
                strict=True,
            )
        )
        return by_u, by_v

    def within(self, u: FloatArray, v: FloatArray) -> BoolArray:
        """Whether parameters belong to the face, shape (n,).

        Its edges are polygons of 256 sides each: right but for some 1e-4 of an edge's size.
        """
        import shapely

        s, t = (self.middle + self.half * np.column_stack([u, v])).T
        inside: BoolArray = shapely.intersects_xy(self.outline, s, t)
        return inside

    def _wrapped(self, u: FloatArray, v: FloatArray) -> FloatArray:
        at = self.middle + self.half * np.column_stack([u, v])
        closed = np.isfinite(self.period)
        start, period = self.start[closed], self.period[closed]
        at[:, closed] = start + (at[:, closed] - start) % period
        return at

    def arrays(self) -> dict[str, Any]:
        """All that describes the face, as arrays by name, for `of`."""
        import shapely

        return {
            "knots_u": self.spline.t[0],
            "knots_v": self.spline.t[1],
            "coefficients": self.spline.c,
            "degrees": np.array(self.spline.k),
            "middle": self.middle,
            "half": self.half,
            "start": self.start,
            "period": self.period,
            "outline": np.frombuffer(shapely.to_wkb(self.outline), np.uint8),
        }

    @classmethod
    def of(cls, arrays: Mapping[str, Any]) -> SplineFace:
        """The face that its `arrays` describe."""
        import shapely
        from scipy.interpolate import NdBSpline

        outline = shapely.from_wkb(arrays["outline"].tobytes())
        shapely.prepare(outline)
        return cls(
            NdBSpline(
                (arrays["knots_u"], arrays["knots_v"]),
                arrays["coefficients"],
                tuple(arrays["degrees"].tolist()),
                extrapolate=True,
            ),
            arrays["middle"],
            arrays["half"],
            arrays["start"],
            arrays["period"],
            outline,
        )
