"""The table of makers' goals in a job."""

from __future__ import annotations

from pydantic import Field

from fab.settings import Settings

__all__ = ["GoalSettings"]


class GoalSettings(Settings):
    """Bounds that a maker wants of a sheet: a relaxed one is brought within them, any is judged."""

    least_side_mm: float | None = Field(
        default=None, gt=0, le=1e5, description="shortest side of a face"
    )
    least_inradius_mm: float | None = Field(
        default=None, gt=0, le=1e5, description="radius of the widest circle in every face"
    )
    least_sector_deg: float | None = Field(
        default=None, gt=0, lt=90, description="smallest corner of a face"
    )
    most_fold_deg: float | None = Field(
        default=None, gt=0, le=180, description="largest fold angle, mountain or valley"
    )
    different_panels: int | None = Field(
        default=None, ge=1, description="templates by which all panels are cut, turned or not"
    )
    alike_mm: float = Field(
        default=0.2,
        gt=0,
        le=1e5,
        description="by how much a side or diagonal may differ from that of the template",
    )
