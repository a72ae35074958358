"""The feasible window of a sheet: thicknesses, sizes and fold angles at which it has all panels."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fab.errors import counted
from fab.panels.bevelled_panels import MOST_THICKNESS_MM, PanelSettings
from fab.panels.feasibility import Feasibility
from fab.panels.hinges import (
    HingeSettings,
    hinges_fit,
    least_thickness_mm,
    require_fitting_hinges,
)
from fab.panels.inset_limits import rounded_down, rounded_up
from fab.pattern.crease_pattern import CreasePattern, scaled

__all__ = ["Row", "Window", "feasible_window", "workable_limit_deg"]

# Thicknesses of the table of sizes, as shares of the given one.
_SHARES = (0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0)
# A fold limit that works at no size up to this many times the given one is none.
_WORKABLE_TIMES = 10.0


@dataclass(frozen=True)
class Row:
    """At one thickness: how many faces have a panel, and how large the sheet must be for all.

    scale : factor by which the sheet is larger then; None where no size helps.
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
    thickness_max_mm : the largest at which all faces have one at this size; None where none is.
    clear_max_mm : the largest of these at which no panels overlap at the target, 0 where they do at
        every one; None where this was not looked for, or no target is known.
    scale_min : the smallest scale of the sheet at which all have one at this thickness, or None.
    fold_deg : how far the sheet's creases fold at most.
    fold_max_deg : the largest fold limit with which all have one as given, at most 180, or None.
    rows : the same for several thicknesses, rising.
    limit_deg : the fold limit of the panels.
    given : the window as given, where no thickness and no size helps at the fold limit there; then
        this one is that of a lower limit. Else None.
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
    limit_deg: float
    given: Window | None = None

    @property
    def hopeless(self) -> bool:
        """Whether faces are without a panel at every thickness and every size."""
        return all(row.scale is None for row in self.rows) and not (
            self.thickness_max_mm or self.scale_min
        )

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
            *self._beyond(),
            f"{self.panels} of {counted(self.faces, 'face has', 'faces have')} a panel, at "
            f"width_mm = {self.width_mm:.6g} and thickness_mm = {self.thickness_mm:g}",
            "all of them have one",
            f"  at this size with {most('thickness_mm', self.thickness_max_mm)}",
            *self._collisions(),
            f"  at this thickness with {size(self.scale_min)}",
            f"  at both with {most('fold_limit_deg', self.fold_max_deg)} (the creases fold by up "
            f"to {self.fold_deg:.4g})",
            f"{'thickness_mm':<14}{'panels':<14}all of them with",
            *table,
        ]

    def _beyond(self) -> list[str]:
        if self.given is None:
            return []
        given = self.given
        return [
            f"{given.panels} of {counted(given.faces, 'face has', 'faces have')} a panel at "
            f"fold_limit_deg = {given.limit_deg:g}, and no thickness and no size helps: the "
            f"creases fold by up to {given.fold_deg:.4g} degrees",
            f"with fold_limit_deg = {self.limit_deg:g}, the largest that works, to which all below "
            "applies:",
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


def feasible_window(
    pattern: CreasePattern,
    panel: PanelSettings,
    hinge: HingeSettings,
    clear: Callable[[float], float | None] | None = None,
) -> Window:
    """The feasible window of a sheet, by panels alone, or with `clear` by pairs of them too.

    clear : the largest thickness, at most the given one, in mm, at which no panels overlap at the
    target (`fab.clearance.thickness_limit.collisions`); None where they overlap at every one.

    Raises `InvalidJob` where panels cannot have such hinges.
    """
    require_fitting_hinges(panel, hinge)
    feasibility = Feasibility(pattern, panel, hinge)
    given = panel.thickness_mm
    most = feasibility.largest_thickness_mm()
    apart = None
    if clear is not None and most is not None:
        apart = clear(most) or 0.0
    least = least_thickness_mm(panel, hinge)
    thicknesses = [
        thickness
        for thickness in (round(share * given, 4) for share in _SHARES)
        if least <= thickness <= MOST_THICKNESS_MM
        and hinges_fit(panel.model_copy(update={"thickness_mm": thickness}), hinge)
    ]
    return Window(
        pattern.face_count,
        int(feasibility.faces_feasible().sum()),
        float(np.ptp(pattern.vertices_coords, axis=0).max()),
        given,
        most,
        apart,
        feasibility.least_scale(),
        float(np.abs(pattern.edges_foldAngle).max(initial=0.0)),
        feasibility.largest_limit_deg(),
        tuple(
            Row(
                thickness,
                int(feasibility.faces_feasible(thickness).sum()),
                feasibility.least_scale(thickness),
            )
            for thickness in thicknesses
        ),
        panel.fold_limit_deg,
    )


def workable_limit_deg(
    pattern: CreasePattern, panel: PanelSettings, hinge: HingeSettings
) -> float | None:
    """The largest fold limit at which all faces have a panel, rounded down to four digits.

    At this thickness and size, or where there is none, on a sheet up to 10 times as large. None
    where no limit helps.
    """
    limit = Feasibility(pattern, panel, hinge).largest_limit_deg()
    if limit is None:
        larger = scaled(pattern, factor=_WORKABLE_TIMES)
        limit = Feasibility(larger, panel, hinge).largest_limit_deg()
    return None if limit is None else float(rounded_down(limit))
