"""The feasible window of a sheet: thicknesses, sizes and fold angles at which it has all panels.

Where hinges count, all panels, hinges and walls: what is suggested then has no finding of these.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fab.errors import counted
from fab.panels.bevelled_panels import MOST_THICKNESS_MM, PanelSettings
from fab.panels.feasibility import SLIVERS_REL, Feasibility
from fab.panels.fold_limit import reachable_limit_deg, widest_gap_mm
from fab.panels.hinges import (
    HingeSettings,
    hinges_fit,
    least_thickness_mm,
    require_fitting_hinges,
)
from fab.panels.inset_limits import rounded_down, rounded_up
from fab.pattern.crease_pattern import CreasePattern, scaled

__all__ = ["Least", "Row", "Sparing", "Window", "feasible_window", "workable_limit_deg"]

# Thicknesses of the table of sizes, as shares of the given one.
_SHARES = (0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0)
# A fold limit that works at no size up to this many times the given one is none.
_WORKABLE_TIMES = 10.0
# Sizes at which panels do not overlap are sought in such steps, up to so many times the first.
_STEP, _MOST_STEPS, _EXACT_TIMES = 1.5, 6, 1.01
# Bounds are tried in steps of this factor, up to so many.
_SETTLING, _MOST_SETTLING = 1.01, 40
# Thicknesses without slivers are told where they are larger by this factor.
_BETTER = 1.1


@dataclass(frozen=True)
class Least:
    """What a sheet needs besides its panels.

    Attributes
    ----------
    width_mm : of panels at their bottom and top. hinges : whether all hinges must have room.
    free : whether no panels overlap at the target, by thickness, mm, and scale; none where this
        does not count.
    """

    width_mm: float = 0.0
    hinges: bool = False
    free: Callable[[float, float], bool] | None = None


_PANELS_ALONE = Least()


@dataclass(frozen=True)
class Sparing:
    """Without slivers: the thickness that is possible then, their number and share of the area."""

    thickness_mm: float
    faces: int
    share: float


@dataclass(frozen=True)
class Row:
    """At one thickness: how many faces have a panel, and how large the sheet must be for all.

    scale : factor by which the sheet is larger then; None where no size helps. overlap : whether
    that is because panels overlap at the target.
    """

    thickness_mm: float
    panels: int
    scale: float | None
    overlap: bool = False


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
    hingeless : number of creases without room for their hinge as given.
    panels_max_mm : thickness_max_mm of panels alone, where their hinges have room at none.
    sparing : what is possible without slivers, where it is better.
    overlap : whether there is no scale_min because panels overlap at the target at every size.
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
    hingeless: int = 0
    panels_max_mm: float | None = None
    sparing: Sparing | None = None
    overlap: bool = False
    given: Window | None = None

    @property
    def hopeless(self) -> bool:
        """Whether faces are without a panel at every thickness and every size."""
        return all(row.scale is None for row in self.rows) and not (
            self.thickness_max_mm or self.scale_min
        )

    def lines(self) -> list[str]:
        """The window in words, one line each; bounds are rounded to the safe side."""

        def size(scale: float | None, overlap: bool) -> str:
            if scale is None:
                return "no size: panels overlap at the target" if overlap else "no size"
            return f"width_mm at least {rounded_up(scale * self.width_mm)} ({rounded_up(scale)} x)"

        def most(key: str, bound: float | None) -> str:
            return f"no {key}" if bound is None else f"{key} at most {rounded_down(bound)}"

        table = [
            f"{row.thickness_mm:<14.4g}{row.panels:<14}{size(row.scale, row.overlap)}"
            for row in self.rows
        ]
        return [
            *self._beyond(),
            f"{self.panels} of {counted(self.faces, 'face has', 'faces have')} a panel, at "
            f"width_mm = {self.width_mm:.6g} and thickness_mm = {self.thickness_mm:g}"
            f"{self._without_hinges()}",
            "all of them have one",
            f"  at this size with {most('thickness_mm', self.thickness_max_mm)}",
            *self._collisions(),
            *self._alone(),
            *self._without_slivers(),
            f"  at this thickness with {size(self.scale_min, self.overlap)}",
            f"  at both with {most('fold_limit_deg', self.fold_max_deg)} (the creases fold by up "
            f"to {self.fold_deg:.4g})",
            f"{'thickness_mm':<14}{'panels':<14}all of them with",
            *table,
        ]

    def _without_hinges(self) -> str:
        if not self.hingeless:
            return ""
        return f", {counted(self.hingeless, 'crease is', 'creases are')} too short for its hinge"

    def _alone(self) -> list[str]:
        if self.panels_max_mm is None:
            return []
        return [
            "    as creases are too short for their hinges: lower gap_mm or relief_mm (panels "
            f"alone with thickness_mm at most {rounded_down(self.panels_max_mm)})"
        ]

    def _without_slivers(self) -> list[str]:
        if self.sparing is None:
            return []
        spared = self.sparing
        slivers = counted(spared.faces, "sliver", "slivers")
        return [
            f"    without {slivers}, {100 * spared.share:.2g} % of the area, with thickness_mm at "
            f"most {rounded_down(spared.thickness_mm)}"
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
            return [
                "    but panels overlap at the target at every thickness: lower fold_limit_deg, or "
                "raise gap_mm"
            ]
        return [
            "    but without overlap of panels at the target only with thickness_mm at most "
            f"{rounded_down(self.clear_max_mm)}, at this gap_mm"
        ]


def feasible_window(
    pattern: CreasePattern,
    panel: PanelSettings,
    hinge: HingeSettings,
    clear: Callable[[float], float | None] | None = None,
    least: Least = _PANELS_ALONE,
) -> Window:
    """The feasible window of a sheet, by panels alone, or with `clear` by pairs of them too.

    clear : the largest thickness, at most the given one, in mm, at which no panels overlap at the
    target (`fab.clearance.thickness_limit.collisions`); None where they overlap at every one.

    Raises `InvalidJob` where panels cannot have such hinges.
    """
    require_fitting_hinges(panel, hinge)
    feasibility = Feasibility(pattern, panel, hinge, least.width_mm)
    given, hinges = panel.thickness_mm, least.hinges
    width = float(np.ptp(pattern.vertices_coords, axis=0).max())
    most = feasibility.largest_thickness_mm(hinges=hinges)
    if most is not None and hinges:
        most = _settled(most, 1 / _SETTLING, lambda t: feasibility.whole(float(rounded_down(t))))
    alone = feasibility.largest_thickness_mm() if most is None and hinges else None
    apart = None
    if clear is not None and most is not None:
        apart = clear(most) or 0.0
    thinnest = least_thickness_mm(panel, hinge)
    thicknesses = [
        thickness
        for thickness in (round(share * given, 4) for share in _SHARES)
        if thinnest <= thickness <= MOST_THICKNESS_MM
        and hinges_fit(panel.model_copy(update={"thickness_mm": thickness}), hinge)
    ]

    overlapping = [np.inf]  # thicker panels overlap at every size as well

    def row(thickness_mm: float) -> Row:
        panels = int(feasibility.faces_feasible(thickness_mm).sum())
        found = feasibility.least_scale(thickness_mm, hinges=hinges)
        if found is not None and hinges:
            found = _settled(
                found,
                _SETTLING,
                lambda scale: all(
                    feasibility.whole(thickness_mm, scale=each)
                    for each in (float(rounded_up(scale)), float(rounded_up(scale * width)) / width)
                ),
            )
        if found is None or thickness_mm >= overlapping[-1]:
            return Row(thickness_mm, panels, None, found is not None)
        free = _free_scale(least, thickness_mm, found)
        if free is None:
            overlapping.append(thickness_mm)
        return Row(thickness_mm, panels, free, free is None)

    widest = widest_gap_mm(panel) if hinges else None
    limit = feasibility.largest_limit_deg(hinges=hinges, widest_mm=widest)
    if limit is not None and hinges:
        limit = _settled(
            limit, 1 / _SETTLING, lambda deg: feasibility.whole(limit_deg=float(rounded_down(deg)))
        )
    here = row(given)
    return Window(
        pattern.face_count,
        here.panels,
        width,
        given,
        most,
        apart,
        here.scale,
        float(np.abs(pattern.edges_foldAngle).max(initial=0.0)),
        limit,
        tuple(here if thickness == given else row(thickness) for thickness in thicknesses),
        panel.fold_limit_deg,
        len(feasibility.hingeless()) if hinges else 0,
        alone,
        _sparing(feasibility, most) if hinges else None,
        here.overlap,
    )


def _settled(bound: float, times: float, holds: Callable[[float], bool]) -> float | None:
    """A bound at which something holds in the digits that are told: the next of those tried.

    Hinges lose room where larger panels keep one more side, so that it may not hold beyond a bound.
    """
    tried = (bound * times**step for step in range(_MOST_SETTLING))
    return next((each for each in tried if holds(each)), None)


def _free_scale(least: Least, thickness_mm: float, scale: float) -> float | None:
    """The least scale from a given one on at which no panels overlap, to 1 %, or None."""
    if least.free is None or least.free(thickness_mm, scale):
        return scale
    tried = (scale * _STEP**step for step in range(1, _MOST_STEPS))
    high = next((each for each in tried if least.free(thickness_mm, each)), None)
    if high is None:
        return None
    low = high / _STEP
    while high > low * _EXACT_TIMES:
        middle = (low + high) / 2
        low, high = (low, middle) if least.free(thickness_mm, middle) else (middle, high)
    return high


def _sparing(feasibility: Feasibility, most_mm: float | None) -> Sparing | None:
    """What is possible without slivers, whose panels others hold together; None where no better."""
    spared = feasibility.largest_thickness_mm(spare_rel=SLIVERS_REL)
    if spared is None or spared <= _BETTER * (most_mm or 0.0):
        return None
    lost = ~feasibility.faces_feasible(spared)
    if not lost.any():  # the others are bound by their hinges
        return None
    return Sparing(spared, int(lost.sum()), float(feasibility.faces_share[lost].sum()))


def workable_limit_deg(
    pattern: CreasePattern, panel: PanelSettings, hinge: HingeSettings, least_width_mm: float = 0.0
) -> float | None:
    """The largest fold limit that works, rounded down to four digits (`reachable_limit_deg`).

    At this thickness and size, or where there is none, on a sheet up to 10 times as large. None
    where no limit helps.
    """
    limit = reachable_limit_deg(Feasibility(pattern, panel, hinge, least_width_mm))
    if limit is None:
        larger = scaled(pattern, factor=_WORKABLE_TIMES)
        limit = reachable_limit_deg(Feasibility(larger, panel, hinge, least_width_mm))
    return limit
