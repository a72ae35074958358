"""At which thicknesses and sizes do all panels of a sheet stand, and how far can it fold?"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fab.crease import CreasePattern, scaled
from fab.errors import InvalidJob
from fab.feasible import inradii, rounded_down, rounded_up, scale_bounds
from fab.hinges import HingeSettings, heights_over_axes_mm
from fab.panels import LEAST_RADIUS_MM, LEAST_THICKNESS_MM, PanelSettings, make_panels
from fab.polygons import are_convex
from fab.setbacks import Setbacks, sides_of
from fab.thick import heights_and_setbacks
from solver.vectors import BoolArray

__all__ = ["Row", "Window", "feasible_window"]

# Bounds are found to this share of themselves.
_EXACT = 1e-9
_MOST_MM = 1000.0
_MOST_TIMES = 1e6
# The table of sizes has these shares of the given thickness.
_SHARES = (0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0)


@dataclass(frozen=True)
class Row:
    """At one thickness: how many panels stand, and how large the sheet must be for all of them.

    scale : times the size of the sheet; None where no size helps.
    """

    thickness_mm: float
    panels: int
    scale: float | None


@dataclass(frozen=True)
class Window:
    """What is feasible for a sheet.

    Attributes
    ----------
    faces : number of faces; panels : how many of them have a panel as given.
    width_mm : longer side of the flat sheet.
    thickness_mm : as given.
    thickness_max_mm : the largest at which all panels stand at this size; None where none is.
    scale_min : the smallest scale of the sheet at which all stand at this thickness, or None.
    fold_deg : how far the sheet's creases fold at most.
    fold_max_deg : the largest fold_limit_deg with which all stand as given, at most 180, or None.
    rows : the same for several thicknesses, rising.
    """

    faces: int
    panels: int
    width_mm: float
    thickness_mm: float
    thickness_max_mm: float | None
    scale_min: float | None
    fold_deg: float
    fold_max_deg: float | None
    rows: tuple[Row, ...]

    def lines(self) -> list[str]:
        """The window in words, one line each; bounds are rounded to the safe side."""

        def size(scale: float | None) -> str:
            if scale is None:
                return "no size"
            return f"width_mm at least {rounded_up(scale * self.width_mm)} ({rounded_up(scale)} x)"

        def most(key: str, bound: float | None) -> str:
            return f"no {key}" if bound is None else f"{key} at most {rounded_down(bound)}"

        table = [f"{row.thickness_mm:<14.4g}{row.panels:<14}{size(row.scale)}" for row in self.rows]
        return [
            f"{self.panels} of {self.faces} faces have a panel, at width_mm = {self.width_mm:.6g} "
            f"and thickness_mm = {self.thickness_mm:g}",
            "all of them have one",
            f"  at this size with {most('thickness_mm', self.thickness_max_mm)}",
            f"  at this thickness with {size(self.scale_min)}",
            f"  at both with {most('fold_limit_deg', self.fold_max_deg)} (the creases fold by up "
            f"to {self.fold_deg:.4g})",
            f"{'thickness_mm':<14}{'panels':<14}all of them with",
            *table,
        ]

    def report(self) -> dict[str, Any]:
        """The window as tables for a report."""
        out = dict(vars(self))
        out["rows"] = [dict(vars(row)) for row in self.rows]
        return out


def feasible_window(
    pattern: CreasePattern,
    panel: PanelSettings,
    hinge: HingeSettings,
    collides: Callable[[float], bool] | None = None,
) -> Window:
    """The feasible window of a sheet, by panels alone, or with `collides` by pairs of them too.

    collides : whether panels of a given thickness, in mm, collide at the target, of faces without a
    common crease. If they do, thicker ones must too.
    """
    standing = _Standing(pattern, panel, hinge)

    def all_stand(thickness_mm: float) -> bool:
        clear = collides is None or not collides(thickness_mm)
        return clear and bool(standing(thickness_mm).all())

    given = panel.thickness_mm
    least = _least_thickness_mm(panel, hinge)
    return Window(
        pattern.face_count,
        int(standing(given).sum()),
        float(np.ptp(pattern.vertices_coords, axis=0).max()),
        given,
        _last(all_stand, least, _MOST_MM),
        standing.least_scale(given),
        float(np.abs(pattern.edges_foldAngle).max(initial=0.0)),
        _last(lambda limit: bool(standing(given, limit_deg=limit).all()), 1e-3, 180.0),
        tuple(
            Row(thickness, int(standing(thickness).sum()), standing.least_scale(thickness))
            for thickness in (round(share * given, 4) for share in _SHARES)
            if least <= thickness <= _MOST_MM
        ),
    )


def _least_thickness_mm(panel: PanelSettings, hinge: HingeSettings) -> float:
    """The least thickness at which panels reach up to their axes, and can have such hinges.

    Raises `InvalidJob` where they cannot have them as given.
    """
    heights_over_axes_mm(panel, hinge)

    def fits(inverse: float) -> bool:
        try:
            heights_over_axes_mm(panel.model_copy(update={"thickness_mm": 1 / inverse}), hinge)
        except InvalidJob:
            return False
        return True

    thinnest = _last(fits, 1 / panel.thickness_mm, 1 / LEAST_THICKNESS_MM)
    return max(1 / thinnest if thinnest else panel.thickness_mm, panel.axis_mm or 0.0)


class _Standing:
    """Which faces of a pattern have a panel, at any thickness and scale."""

    def __init__(self, pattern: CreasePattern, panel: PanelSettings, hinge: HingeSettings) -> None:
        self._pattern, self._panel, self._hinge = pattern, panel, hinge
        self._sides = sides_of(pattern)
        self._convex = are_convex(self._sides.start, self._sides.offsets)

    def __call__(
        self, thickness_mm: float, scale: float = 1.0, limit_deg: float | None = None
    ) -> BoolArray:
        """Whether each face has a panel, shape (nf,)."""
        heights, back = self._limits(thickness_mm, limit_deg)
        start = scale * self._sides.start
        sides = replace(self._sides, start=start, length_mm=scale * self._sides.length_mm)
        radii = [inradii(sides, back.at(z)) for z in heights]
        fits: BoolArray = np.minimum(*radii) >= LEAST_RADIUS_MM
        if not self._convex.all():
            panels, _ = make_panels(scaled(self._pattern, factor=scale), heights, back)
            fits[~self._convex] = np.isin(np.flatnonzero(~self._convex), panels.faces)
        return fits

    def least_scale(self, thickness_mm: float) -> float | None:
        """The smallest scale at which all faces have one; None where no size helps."""
        heights, back = self._limits(thickness_mm)
        bounds = scale_bounds(self._sides, back, heights, LEAST_RADIUS_MM)
        scale = float(bounds[self._convex].max(initial=0.0))
        if self._convex.all() or not np.isfinite(scale):
            return scale if np.isfinite(scale) else None
        # what stands at a scale stands at every larger one
        small = _last(lambda x: bool(self(thickness_mm, 1 / x).all()), 1 / _MOST_TIMES, _MOST_TIMES)
        return None if small is None else 1 / small

    def _limits(
        self, thickness_mm: float, limit_deg: float | None = None
    ) -> tuple[tuple[float, float], Setbacks]:
        limit = self._panel.fold_limit_deg if limit_deg is None else limit_deg
        changes = {"thickness_mm": thickness_mm, "fold_limit_deg": limit}
        return heights_and_setbacks(
            self._pattern, self._panel.model_copy(update=changes), self._hinge
        )


def _last(holds: Callable[[float], bool], low: float, high: float) -> float | None:
    """The largest value between two bounds at which something holds; it holds below that as well.

    Found by halves; None where it does not even hold at the lower bound.
    """
    if not holds(low):
        return None
    if holds(high):
        return high
    while high > low * (1 + _EXACT):
        # in proportion while the bounds are orders of magnitude apart
        middle = (low * high) ** 0.5 if high > 2 * low else (low + high) / 2
        low, high = (middle, high) if holds(middle) else (low, middle)
    return low
