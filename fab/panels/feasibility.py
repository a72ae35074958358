"""Faces that can have a panel and creases that can have a hinge, at which thickness and size."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cached_property

import numpy as np

from fab.geometry.bodies import bodies_of
from fab.geometry.rings import are_convex, ring_areas
from fab.panels.bevelled_panels import (
    LEAST_RADIUS_MM,
    MOST_THICKNESS_MM,
    Panels,
    PanelSettings,
    lost_sides,
    make_panels,
)
from fab.panels.hinge_room import crease_sides
from fab.panels.hinges import (
    HingeSettings,
    crease_kinds,
    heights_and_setbacks,
    hinges_fit,
    least_thickness_mm,
)
from fab.panels.inset_limits import inradii, largest_where, scale_bounds
from fab.panels.knuckles import knuckles_turn, make_knuckles
from fab.panels.panel_widths import panel_widths_mm
from fab.panels.setbacks import Setbacks, sides_of
from fab.panels.webs import make_webs
from fab.pattern.crease_pattern import CreasePattern, scaled
from solver.graphs import labels
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["SLIVERS_REL", "Feasibility"]

# Faces that together have no larger share of the area of a sheet are slivers of it.
SLIVERS_REL = 0.01
# A sheet that must be larger by more than this factor has no size.
_MOST_TIMES = 1e6
# What has no room on a sheet so many times as large has none on any.
_AS_LARGE, _HALFWAY_DEG = 1e4, 90.0
# Fold limits are looked for down to this.
_LEAST_LIMIT_DEG = 1e-3
# Bounds by hinges are exact to this share of themselves: they take longer than those by panels.
_EXACT_HINGES = 1e-5


class Feasibility:
    """Which faces of a pattern can have a panel, at any thickness, scale and fold limit.

    A panel that is feasible is so at every smaller thickness and fold limit, and at every larger
    scale.

    least_width_mm : panels are as wide as this at their bottom and their top, at least.
    """

    def __init__(
        self,
        pattern: CreasePattern,
        panel: PanelSettings,
        hinge: HingeSettings,
        least_width_mm: float = 0.0,
    ) -> None:
        self.pattern, self.panel, self.hinge = pattern, panel, hinge
        self._width, self._radius = least_width_mm, max(LEAST_RADIUS_MM, least_width_mm / 2)
        self._sides = sides_of(pattern)
        self._convex = are_convex(self._sides.start, self._sides.offsets)
        area = np.abs(ring_areas(self._sides.start, self._sides.offsets))
        self.faces_share: FloatArray = area / area.sum()

    def faces_feasible(
        self,
        thickness_mm: float | None = None,
        *,
        scale: float = 1.0,
        limit_deg: float | None = None,
    ) -> BoolArray:
        """Whether each face has a panel, shape (nf,).

        thickness_mm, limit_deg : those of the settings where left out. scale : of the pattern.
        """
        return self._room(thickness_mm, scale, limit_deg).faces_has_panel

    def hingeless(
        self,
        thickness_mm: float | None = None,
        *,
        scale: float = 1.0,
        limit_deg: float | None = None,
    ) -> IntArray:
        """Edges beside panels, without room for their hinge or for the side of a panel.

        Those that have none on any sheet, however large, are left out.
        """
        panels = self._room(thickness_mm, scale, limit_deg)
        return np.setdiff1d(self._without(panels), self._never)

    def whole(
        self,
        thickness_mm: float | None = None,
        *,
        scale: float = 1.0,
        limit_deg: float | None = None,
    ) -> bool:
        """Whether all faces have a panel, and no edge is `hingeless`."""
        panels = self._room(thickness_mm, scale, limit_deg)
        if not panels.faces_has_panel.all():
            return False
        return not len(np.setdiff1d(self._without(panels), self._never))

    def parts(self, limit_deg: float) -> int:
        """Number of bodies that panels make with their hinges, at a fold limit."""
        panels = self._room(None, 1.0, limit_deg)
        held, _ = self._hinged(panels)
        pairs = np.searchsorted(panels.faces, self.pattern.edges_faces[held])
        return 1 + int(labels(pairs, len(panels.faces)).max(initial=-1))

    def gaps_kept(self, limit_deg: float, most_mm: float) -> bool:
        """Whether clearance makes no gap wider than this, or than its hinge needs."""
        _, back = self._limits(limit_deg=limit_deg)
        panel = self.panel.model_copy(update={"fold_limit_deg": limit_deg, "clearance_mm": 0.0})
        _, least = heights_and_setbacks(self.pattern, panel, self.hinge)
        return bool((2 * back.axis_mm <= np.maximum(2 * least.axis_mm, most_mm)).all())

    def largest_thickness_mm(
        self, faces: IntArray | None = None, *, spare_rel: float = 0.0, hinges: bool = False
    ) -> float | None:
        """The largest thickness, mm, at which some faces, or all, have a panel.

        At least what panels of such an axis and such hinges need, at most 1000 mm; None where no
        thickness between these helps. spare_rel : share of the sheet's area that may be without.
        hinges : whether no edge is `hingeless`, too.
        """
        chosen = self._chosen(faces)

        def holds(thickness_mm: float) -> bool:
            panel = self.panel.model_copy(update={"thickness_mm": thickness_mm})
            return hinges_fit(panel, self.hinge) and self._suffice(
                self.faces_feasible(thickness_mm), chosen, spare_rel
            )

        least = least_thickness_mm(self.panel, self.hinge)
        most = largest_where(holds, least, MOST_THICKNESS_MM)
        if not hinges or most is None:
            return most
        return _also_where(holds, lambda t: not len(self.hingeless(t)), least, most)

    def largest_limit_deg(
        self,
        faces: IntArray | None = None,
        *,
        spare_rel: float = 0.0,
        hinges: bool = False,
        widest_mm: float | None = None,
    ) -> float | None:
        """The largest fold limit, degrees, at which some faces, or all, have a panel, or None.

        All creases with knuckles, where there are any, turn as far. spare_rel, hinges : as in
        `largest_thickness_mm`. widest_mm : of gaps that clearance makes (`gaps_kept`).
        """
        chosen = self._chosen(faces)
        knuckled = crease_kinds(self.pattern, self.hinge) == "knuckle"

        def holds(limit: float) -> bool:
            panels = self._room(None, 1.0, limit)
            turns = knuckles_turn(panels.setbacks, self.hinge)[knuckled].all()
            return bool(turns) and self._suffice(panels.faces_has_panel, chosen, spare_rel)

        most = largest_where(holds, _LEAST_LIMIT_DEG, 180.0)
        if most is not None and widest_mm is not None:
            most = _also_where(
                holds, lambda limit: self.gaps_kept(limit, widest_mm), _LEAST_LIMIT_DEG, most
            )
        if not hinges or most is None:
            return most
        return _also_where(
            holds, lambda limit: not len(self.hingeless(limit_deg=limit)), _LEAST_LIMIT_DEG, most
        )

    def least_scale(
        self,
        thickness_mm: float | None = None,
        faces: IntArray | None = None,
        *,
        spare_rel: float = 0.0,
        hinges: bool = False,
    ) -> float | None:
        """The smallest scale at which some faces, or all, have a panel, or None.

        spare_rel, hinges : as in `largest_thickness_mm`.
        """
        chosen = self._chosen(faces)

        def holds(shrunk: float) -> bool:
            fits = self.faces_feasible(thickness_mm, scale=1 / shrunk)
            return self._suffice(fits, chosen, spare_rel)

        if self._convex[chosen].all():
            scale = self._scale_of(self.scales(thickness_mm)[chosen], chosen, spare_rel)
        else:
            shrunk = largest_where(holds, 1 / _MOST_TIMES, _MOST_TIMES)
            scale = None if shrunk is None else 1 / shrunk
        if scale is None or not hinges or not len(self.hingeless(thickness_mm, scale=scale)):
            return scale
        shrunk = largest_where(
            lambda x: not len(self.hingeless(thickness_mm, scale=1 / x)) and holds(x),
            1 / _MOST_TIMES,
            1 / scale,
            _EXACT_HINGES,
        )
        return None if shrunk is None else 1 / shrunk

    def _scale_of(self, scales: FloatArray, chosen: BoolArray, spare_rel: float) -> float | None:
        """The smallest scale at which chosen convex faces, but for a share, have a panel."""
        order = np.argsort(scales, kind="stable")
        from_there_on = np.cumsum(self.faces_share[chosen][order][::-1])[::-1]
        scale = float(scales[order][from_there_on > spare_rel].max(initial=0.0))
        return None if scale > _MOST_TIMES else scale

    def scales(self, thickness_mm: float | None = None) -> FloatArray:
        """The smallest scale for each convex face, shape (nf,); infinite where no size helps."""
        heights, back = self._limits(thickness_mm)
        out = scale_bounds(self._sides, back, heights, self._radius)
        return np.where(out > _MOST_TIMES, np.inf, out)

    def overfolded(self, faces: IntArray) -> IntArray:
        """Creases of some faces that fold too far for any setback to leave room, rising."""
        heights, back = self._limits()
        far = np.maximum(*(back.at(z) for z in heights))
        own = np.isin(self._sides.faces, faces)
        longest = self._sides.length_mm[own].max(initial=0.0)
        edges = np.unique(self._sides.edges[own])
        over: IntArray = edges[far[edges] > _MOST_TIMES * longest]
        return over

    def lifted(self) -> Feasibility:
        """The same panels above their axes, by half of their clearance, without hinges."""
        below = {"axis": "offset", "axis_mm": -self.panel.clearance_mm / 2}
        panel = self.panel.model_copy(update=below)
        return Feasibility(self.pattern, panel, HingeSettings(kind="none"), self._width)

    def _chosen(self, faces: IntArray | None) -> BoolArray:
        chosen = np.full(len(self._convex), faces is None)
        if faces is not None:
            chosen[faces] = True
        return chosen

    def _suffice(self, fits: BoolArray, chosen: BoolArray, spare_rel: float) -> bool:
        """Whether chosen faces without a panel have no larger share of the area."""
        without = chosen & ~fits
        return not without.any() or bool(self.faces_share[without].sum() <= spare_rel)

    def _room(self, thickness_mm: float | None, scale: float, limit_deg: float | None) -> Panels:
        """The panels that are feasible, without their bodies."""
        heights, back = self._limits(thickness_mm, limit_deg)
        start = scale * self._sides.start
        sides = replace(self._sides, start=start, length_mm=scale * self._sides.length_mm)
        radii = [inradii(sides, back.at(z)) for z in heights]
        fits: BoolArray = np.minimum(*radii) >= self._radius
        if not self._convex.all():
            panels, _ = make_panels(scaled(self.pattern, factor=scale), heights, back)
            wide = panels.faces[panel_widths_mm(panels) >= self._width]
            fits[~self._convex] = np.isin(np.flatnonzero(~self._convex), wide)
        return Panels(bodies_of([]), np.flatnonzero(fits), heights, sides, back)

    @cached_property
    def _never(self) -> IntArray:
        """Edges without room for their hinge or a side of their panel, however large the sheet."""
        limit = min(self.panel.fold_limit_deg, _HALFWAY_DEG)  # at which all creases have setbacks
        return self._without(self._room(None, _AS_LARGE, limit))

    def _without(self, panels: Panels) -> IntArray:
        return np.union1d(self._hinged(panels)[1], lost_sides(panels))

    def _hinged(self, panels: Panels) -> tuple[IntArray, IntArray]:
        """Creases between two panels with a hinge, and those without room for the one they need."""
        kinds = crease_kinds(self.pattern, self.hinge)
        first, second = crease_sides(self.pattern, panels)
        between = np.flatnonzero((first >= 0) & (second >= 0) & (kinds != "none"))
        held = [between[kinds[between] == "film"]]
        if "web" in self.hinge.kinds:
            held.append(make_webs(self.pattern, panels, self.hinge)[0].creases)
        if "knuckle" in self.hinge.kinds:
            held.append(make_knuckles(self.pattern, panels, self.hinge)[0].creases)
        with_hinge = np.sort(np.concatenate(held))
        return with_hinge, np.setdiff1d(between, with_hinge)

    def _limits(
        self, thickness_mm: float | None = None, limit_deg: float | None = None
    ) -> tuple[tuple[float, float], Setbacks]:
        given = {"thickness_mm": thickness_mm, "fold_limit_deg": limit_deg}
        changes = {key: value for key, value in given.items() if value is not None}
        return heights_and_setbacks(self.pattern, self.panel.model_copy(update=changes), self.hinge)


def _also_where(
    holds: Callable[[float], bool], also: Callable[[float], bool], low: float, most: float
) -> float | None:
    """The largest value up to `most`, at which one thing holds, at which another does too."""
    if also(most):
        return most
    return largest_where(lambda x: also(x) and holds(x), low, most, _EXACT_HINGES)
