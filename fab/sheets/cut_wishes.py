"""Wishes for the cuts of a run: bridges, closed slots, mirrored sheets, tabs, an engraved title."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from fab.settings import Settings

__all__ = ["CutWishes", "TabKind"]

TabKind = Literal["one side", "both sides", "slots", "stitches", "none"]


class CutWishes(Settings):
    """How pieces are cut, joined and marked, whatever they are made of."""

    bridges: int = Field(
        default=0,
        ge=0,
        le=50,
        description="how many hold each piece in the sheet, away from corners",
    )
    bridge_mm: float = Field(
        default=0.4, ge=0.05, le=20, description="width of a bridge, as it is left by the kerf"
    )
    closed_slots: bool = Field(
        default=False, description="every open cut as a closed slot, for services that want them"
    )
    slot_mm: float = Field(
        default=0.4, gt=0, le=20, description="width of closed slots as they are cut"
    )
    mirror: bool = Field(
        default=False, description="left and right exchanged, for material that lies face down"
    )
    tabs: TabKind = Field(
        default="one side",
        description="of seams: glue tabs on one side, on both sides to be laid onto each other, "
        "tongues with slots, stitching holes, or none",
    )
    stitch_mm: float = Field(
        default=5.0, ge=0.5, le=100, description="from one stitching hole to the next"
    )
    stitch_hole_mm: float = Field(
        default=1.0, ge=0.1, le=20, description="diameter of stitching holes"
    )
    title: bool = Field(
        default=False,
        description="name, material, machine and a scale bar, engraved beside the pieces",
    )
