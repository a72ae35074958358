"""Settings of the plates for a sheet in parts, and of the joints between these."""

from __future__ import annotations

from typing import Literal

import numpy as np
from pydantic import Field, model_validator

from fab.settings import Settings

__all__ = ["SIZES", "JointSettings", "PlateSettings"]

# Tongues that find no room are tried at these shares of their width and depth.
SIZES = (1.0, 0.75, 0.5)
# A tongue must not slide out by more than this share of its depth.
_MOST_PLAY = 0.5


class JointSettings(Settings):
    """Joints between parts that are printed apart."""

    joint: Literal["dovetail", "pin", "tape"] = Field(
        default="dovetail",
        description="dovetail: tongues that hold in the plane; pin: straps with a hole for a pin; "
        "tape: none. What finds no room on a crease becomes a pin, and then tape",
    )
    fit_mm: float = Field(
        default=0.1, ge=0.01, le=10, description="gap between a tongue and its pocket, all around"
    )
    tongue_mm: float | None = Field(
        default=None,
        ge=0.01,
        le=1000,
        description="height of the tongues, at least that of the web; the thickness of the panels "
        "lets them pass through. Left out: half the thickness, or all of it where roof_mm would "
        "not be left above half",
    )
    mouth_mm: float = Field(
        default=6.0, ge=1, le=1000, description="width of a tongue where it begins"
    )
    depth_mm: float = Field(default=4.0, ge=0.1, le=1000, description="length of a tongue")
    undercut_deg: float = Field(
        default=15.0, ge=5, le=45, description="angle by which a tongue widens on both sides"
    )
    wall_mm: float = Field(
        default=1.2, ge=0.1, le=1000, description="least wall between a pocket and what is beside"
    )
    roof_mm: float = Field(default=0.4, ge=0.05, le=1000, description="least wall above a pocket")
    pin_mm: float = Field(
        default=1.75, ge=0.1, le=100, description="thickness of a pin, such as filament"
    )

    @model_validator(mode="after")
    def _holds(self) -> JointSettings:
        if self.joint == "dovetail" and self.play_mm > _MOST_PLAY * SIZES[-1] * self.depth_mm:
            bound = _MOST_PLAY * SIZES[-1] * self.depth_mm * np.sin(np.radians(self.undercut_deg))
            raise ValueError(
                f"fit_mm = {self.fit_mm:g} must be at most {bound:.4g}, so that tongues hold: "
                "lower it, or raise undercut_deg or depth_mm"
            )
        return self

    @property
    def play_mm(self) -> float:
        """How far a dovetail can slide along its length before it holds."""
        return self.fit_mm / float(np.sin(np.radians(self.undercut_deg)))


class PlateSettings(Settings):
    """How parts lie on the printer's bed, and how they are joined."""

    margin_mm: float | None = Field(
        default=None,
        ge=0,
        le=1000,
        description="kept free along the edges of the bed; where left out, that of the printer",
    )
    part_gap_mm: float = Field(
        default=3.0, ge=0.1, le=1000, description="least distance of two parts on a plate"
    )
    joints: JointSettings = JointSettings()
