"""At which thicknesses and sizes do all panels of a sheet stand, and how far can it fold?"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from fab.panels.bevelled_panels import MOST_THICKNESS_MM, PanelSettings
from fab.panels.feasibility import Standing, least_thickness_mm
from fab.panels.hinges import HingeSettings
from fab.panels.inset_limits import rounded_down, rounded_up
from fab.pattern.crease_pattern import CreasePattern

__all__ = ["Row", "Window", "feasible_window"]

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
    clear_max_mm : the largest of these at which no panels overlap at the target, 0 where they do at
        every one; None where this was not looked for, or no target is known.
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
    clear_max_mm: float | None
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
            *self._collisions(),
            f"  at this thickness with {size(self.scale_min)}",
            f"  at both with {most('fold_limit_deg', self.fold_max_deg)} (the creases fold by up "
            f"to {self.fold_deg:.4g})",
            f"{'thickness_mm':<14}{'panels':<14}all of them with",
            *table,
        ]

    def _collisions(self) -> list[str]:
        if self.clear_max_mm is None or self.clear_max_mm == self.thickness_max_mm:
            return []
        if self.clear_max_mm == 0.0:
            return ["    but panels overlap at the target at every thickness: raise gap_mm"]
        return [
            "    but without overlap of panels at the target only with thickness_mm at most "
            f"{rounded_down(self.clear_max_mm)}, at this gap_mm"
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
    clear: Callable[[float], float | None] | None = None,
) -> Window:
    """The feasible window of a sheet, by panels alone, or with `clear` by pairs of them too.

    clear : up to which thickness, at most the given one, in mm, no panels overlap at the target
    (`fab.collisions`); None where they overlap at every one.
    """
    standing = Standing(pattern, panel, hinge)
    given = panel.thickness_mm
    most = standing.largest_thickness_mm()
    apart = None
    if clear is not None and most is not None:
        apart = clear(most) or 0.0
    least = least_thickness_mm(panel, hinge)
    return Window(
        pattern.face_count,
        int(standing().sum()),
        float(np.ptp(pattern.vertices_coords, axis=0).max()),
        given,
        most,
        apart,
        standing.least_scale(),
        float(np.abs(pattern.edges_foldAngle).max(initial=0.0)),
        standing.largest_limit_deg(),
        tuple(
            Row(thickness, int(standing(thickness).sum()), standing.least_scale(thickness))
            for thickness in (round(share * given, 4) for share in _SHARES)
            if least <= thickness <= MOST_THICKNESS_MM
        ),
    )
