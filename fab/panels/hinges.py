"""Kinds of hinges, their settings, and the setbacks and heights that they need of panels.

A `web` is a thin strip across the gap (`fab.panels.webs`); a `knuckle` is barrels of both panels
around a pin, printed in place (`fab.panels.knuckles`); a `film` is below all panels, or embedded
in their middle (`fab.panels.film`); `none` leaves panels apart.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from fab.errors import InvalidJob
from fab.panels.bevelled_panels import LEAST_THICKNESS_MM, PanelSettings
from fab.panels.setbacks import Setbacks, setbacks
from fab.pattern.crease_pattern import CreasePattern
from fab.settings import Settings
from solver.vectors import FloatArray

__all__ = [
    "HingeKind",
    "HingeSettings",
    "barrel_radius_mm",
    "crease_kinds",
    "heights_and_setbacks",
    "heights_over_axes_mm",
    "hinge_setbacks",
    "hinges_fit",
    "hole_radius_mm",
    "least_thickness_mm",
    "require_fitting_hinges",
    "setback_of_kinds",
]

HingeKind: TypeAlias = Literal["web", "knuckle", "film", "none"]

# Sides of the prisms as which pins and holes are printed; pins lie within their circle and holes
# around it, so that they turn with all of their play.
ROUND_SIDES = 24
# A lower step from a web to its panel is none: it is lost in single precision.
_LEAST_STEP_MM = 0.005
# Sides of a barrel: one lies on the bed and those beside it rise at 45 degrees.
BARREL_SIDES = 8


class HingeSettings(Settings):
    """Which hinges creases get, and how they are made."""

    kind: HingeKind = Field(default="web", description="hinge of all creases")
    mountain: HingeKind | None = Field(default=None, description="hinge of mountains; else kind")
    valley: HingeKind | None = Field(default=None, description="hinge of valleys; else kind")
    flat: HingeKind | None = Field(
        default=None, description="hinge of creases that are neither; else kind"
    )
    web_mm: float = Field(
        default=0.4, ge=0.01, le=1000, description="thickness of the web: one or two layers"
    )
    relief_mm: float = Field(
        default=0.3,
        ge=0.01,
        le=1000,
        description="from the end of a hinge to the nearest panel corner; of webs, to the "
        "farthest panel corner at their vertex",
    )
    strain_max: float = Field(
        default=0.5,
        gt=0,
        le=10,
        description="how far the outside of a web or film may stretch: it is made long enough. "
        "That of the print material where left out",
    )
    anchor_mm: float = Field(
        default=0.0,
        ge=0,
        le=1000,
        description="how far webs reach into their panels, in dovetails; 0 for none. Where panels "
        "and hinges are of different materials, five nozzles where left out",
    )
    knuckle_mm: float = Field(
        default=4.0, ge=0.1, le=1000, description="least length of a barrel, along its crease"
    )
    pin_mm: float = Field(default=1.2, ge=0.1, le=1000, description="diameter of the pin")
    play_mm: float = Field(
        default=0.25,
        ge=0.01,
        le=100,
        description="gap around a pin, between barrels, and from barrels to the other panel. "
        "The least gap of the printer where left out",
    )
    snap: bool = Field(
        default=False,
        description="barrels are open at the top, so that panels snap off their pins and on again. "
        "Slots are narrower than pins by half of play_mm",
    )
    wall_mm: float = Field(
        default=0.6, ge=0.01, le=1000, description="least wall around the hole of a barrel or panel"
    )
    film_mm: float = Field(
        default=0.2, ge=0.01, le=1000, description="thickness of the film or fabric"
    )
    embedded: bool = Field(
        default=False,
        description="a film or fabric is laid into the middle of all panels while their print "
        "pauses, in place of being printed below them",
    )
    hole_mm: float = Field(
        default=0.0,
        ge=0,
        le=1000,
        description="diameter of a hole through each panel, to align it by; 0 for none",
    )

    @property
    def kinds(self) -> tuple[HingeKind, HingeKind, HingeKind]:
        """Of mountains, of valleys and of other creases."""
        return self.mountain or self.kind, self.valley or self.kind, self.flat or self.kind


def hole_radius_mm(settings: HingeSettings) -> float:
    """From the axis to the farthest corner of the hole in a barrel."""
    return float((settings.pin_mm / 2 + settings.play_mm) / np.cos(np.pi / ROUND_SIDES))


def barrel_radius_mm(panel: PanelSettings) -> float:
    """From the axis to the farthest corner of a barrel as high as its panels."""
    return float(panel.thickness_mm / 2 / np.cos(np.pi / BARREL_SIDES))


def heights_over_axes_mm(panel: PanelSettings, hinge: HingeSettings) -> tuple[float, float]:
    """Bottom and top of the panels over the axes of their hinges; a film has them in its middle.

    >>> heights_over_axes_mm(PanelSettings(thickness_mm=2.0, axis="middle"), HingeSettings())
    (-1.0, 1.0)
    """
    if hinge.embedded:
        return -panel.thickness_mm / 2, panel.thickness_mm / 2
    if "film" in hinge.kinds:
        return hinge.film_mm / 2, hinge.film_mm / 2 + panel.thickness_mm
    return panel.heights_mm


def hinges_fit(panel: PanelSettings, hinge: HingeSettings) -> bool:
    """Whether panels can have such hinges.

    >>> hinges_fit(PanelSettings(thickness_mm=0.4), HingeSettings(web_mm=0.4))
    False
    """
    return next(_misfits(panel, hinge), None) is None


def require_fitting_hinges(panel: PanelSettings, hinge: HingeSettings) -> None:
    """Raise `InvalidJob`, which names the keys at fault, where panels cannot have such hinges."""
    for misfit in _misfits(panel, hinge):
        raise InvalidJob(misfit)


def _misfits(panel: PanelSettings, hinge: HingeSettings) -> Iterator[str]:
    """Everything about panels and hinges that does not go together, as messages for the user."""
    thickness, kinds = panel.thickness_mm, set(hinge.kinds)
    low, high = panel.heights_mm
    if hinge.snap and "knuckle" not in kinds:
        yield "hinges.snap = true without knuckles: set hinges.kind = knuckle, or leave snap out"
    if hinge.snap and hinge.play_mm > hinge.pin_mm / 2:
        yield (
            f"hinges.play_mm = {hinge.play_mm:g} must be at most half of hinges.pin_mm = "
            f"{hinge.pin_mm:g} for barrels that snap on. Raise pin_mm"
        )
    if "film" in kinds and len(kinds) > 1:
        yield (
            f"hinges.kind = film with other hinges ({', '.join(sorted(kinds - {'film'}))}) on some "
            "creases: a film lies under all of them. Give film to all or to none"
        )
    if hinge.embedded and kinds != {"film"}:
        yield (
            f"hinges.embedded = true with hinges of {', '.join(sorted(kinds))}: films alone are "
            "embedded. Set hinges.kind = film for all creases, or leave embedded out"
        )
    if hinge.embedded and hinge.film_mm >= thickness / 2:
        yield (
            f"hinges.film_mm = {hinge.film_mm:g} must be below half of panels.thickness_mm = "
            f"{thickness:g} to be embedded: panels are printed on both sides of it. Raise the "
            "thickness"
        )
    if "film" in kinds and panel.axis != "bottom":
        yield (
            f"panels.axis = {panel.axis} with hinges.kind = film: the axes lie in the film. Leave "
            "panels.axis out"
        )
    if "web" in kinds and thickness < hinge.web_mm + _LEAST_STEP_MM:
        yield (
            f"hinges.web_mm = {hinge.web_mm:g} must be below panels.thickness_mm = "
            f"{thickness:g}, by {_LEAST_STEP_MM:g} at least: a web is thinner than its panels"
        )
    if "web" in kinds and not low <= 0 <= high:
        yield (
            f"panels.axis_mm = {panel.axis_mm:g} must be 0 to panels.thickness_mm = {thickness:g} "
            "for webs: they lie at the axis. Change it, or hinges.kind"
        )
    if "knuckle" in kinds and low != -high:
        yield (
            f"panels.axis = {panel.axis} with knuckles: their axis lies in the middle. Set "
            "panels.axis = middle, or change hinges.kind"
        )
    if "knuckle" in kinds and thickness < _knuckle_thickness_mm(hinge):
        yield (
            f"panels.thickness_mm = {thickness:g} must be at least "
            f"{_knuckle_thickness_mm(hinge):.4g} for knuckles: twice pin_mm / 2 + play_mm + "
            "wall_mm, and a little for corners. Raise it, or lower one of these"
        )


def _knuckle_thickness_mm(hinge: HingeSettings) -> float:
    """The least thickness of panels with knuckles: a hole for the pin with a wall on both sides."""
    return 2 * (hole_radius_mm(hinge) + hinge.wall_mm)


def least_thickness_mm(panel: PanelSettings, hinge: HingeSettings) -> float:
    """The least thickness at which panels reach up to their axes, and can have such hinges.

    Of hinges that fit the panels as given. Knuckles keep panels with axis = offset as thick as they
    are: their axis is in the middle at that thickness alone.

    >>> least_thickness_mm(PanelSettings(), HingeSettings(web_mm=0.4))
    0.405
    """
    least = max(LEAST_THICKNESS_MM, panel.axis_mm or 0.0)
    if "web" in hinge.kinds:
        least = max(least, hinge.web_mm + _LEAST_STEP_MM)
    if hinge.embedded:
        least = max(least, 2 * hinge.film_mm + _LEAST_STEP_MM)
    if "knuckle" in hinge.kinds:
        exact = panel.thickness_mm if panel.axis == "offset" else 0.0
        least = max(least, exact, _knuckle_thickness_mm(hinge))
    return least


def crease_kinds(pattern: CreasePattern, settings: HingeSettings) -> NDArray[np.str_]:
    """The kind of hinge of every edge, shape (ne,); none at borders, cuts, and within a face."""
    mountain, valley, flat = settings.kinds
    letter = pattern.edges_assignment
    out = np.where(letter == "M", mountain, np.where(letter == "V", valley, flat))
    out[~pattern.edges_joining] = "none"
    return out


def hinge_setbacks(
    pattern: CreasePattern, panel: PanelSettings, settings: HingeSettings
) -> FloatArray:
    """Setback that the hinge of each crease needs, mm, shape (ne,).

    A web or film of thickness w and length 2 s bent by rho stretches its outside by
    w rho / (4 s). Knuckles need room for the barrels of the other panel.

    Creases that fold over the limit of the panels count as folded by the limit.
    """
    kinds = crease_kinds(pattern, settings)
    return setback_of_kinds(kinds, pattern.edges_foldAngle, panel, settings)


def setback_of_kinds(
    kinds: NDArray[np.str_], angle_deg: FloatArray, panel: PanelSettings, settings: HingeSettings
) -> FloatArray:
    """The same of creases with hinges of some kinds that fold by angles, both of shape (ne,)."""
    rho = np.minimum(np.abs(np.radians(angle_deg)), np.radians(panel.fold_limit_deg))
    out = np.zeros(len(rho))
    for kind, thickness in (("web", settings.web_mm), ("film", settings.film_mm)):
        out[kinds == kind] = (thickness * rho / (4 * settings.strain_max))[kinds == kind]
    out[kinds == "knuckle"] = barrel_radius_mm(panel) + settings.play_mm
    return out


def heights_and_setbacks(
    pattern: CreasePattern, panel: PanelSettings, hinge: HingeSettings
) -> tuple[tuple[float, float], Setbacks]:
    """Bottom and top of the panels of a pattern over their axes, mm, and what they are set back."""
    heights = heights_over_axes_mm(panel, hinge)
    back = setbacks(
        pattern,
        heights,
        gap_mm=panel.gap_mm,
        clearance_mm=panel.clearance_mm,
        hinge_mm=hinge_setbacks(pattern, panel, hinge),
        limit_deg=panel.fold_limit_deg,
    )
    return heights, back
