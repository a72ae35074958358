"""Settings of perforation: the style of each crease by assignment and fold angle, and relief."""

from __future__ import annotations

from itertools import pairwise

from pydantic import Field, model_validator

from fab.settings import Settings
from fab.sheets.crease_styles import CreaseStyle, DashStyle, EngraveStyle, NoStyle
from fab.sheets.relief_holes import ReliefSettings

__all__ = ["FoldBand", "PerforationSettings"]


class FoldBand(Settings):
    """Styles of the creases that fold by at least `from_deg` and less than `to_deg`.

    A band that ends at 180 includes creases that fold by 180.
    """

    from_deg: float = Field(ge=0, le=180, description="least fold angle of the band")
    to_deg: float = Field(ge=0, le=180, description="fold angle at which the band ends")
    mountain: CreaseStyle | None = Field(default=None, description="left out: as outside the bands")
    valley: CreaseStyle | None = Field(default=None, description="left out: as outside the bands")

    @model_validator(mode="after")
    def _runs_upwards(self) -> FoldBand:
        if self.from_deg >= self.to_deg:
            raise ValueError(
                f"from_deg = {self.from_deg:g} must be below to_deg = {self.to_deg:g}. Exchange "
                "them, or remove the band"
            )
        return self


class PerforationSettings(Settings):
    """How creases are perforated, by assignment and by how far they fold."""

    mountain: CreaseStyle = DashStyle(cut_mm=3.0, gap_mm=1.0)
    valley: CreaseStyle = DashStyle(cut_mm=1.0, gap_mm=1.0)
    flat: CreaseStyle = NoStyle()
    unassigned: CreaseStyle = EngraveStyle()
    margin_mm: float = Field(
        default=0.5, gt=0, le=1000, description="uncut at both ends of every crease"
    )
    bands: list[FoldBand] = Field(
        default=[], description="other styles by fold angle; between bands those above apply"
    )
    relief: ReliefSettings | None = Field(
        default=None, description="holes at vertices; none where left out"
    )

    @model_validator(mode="after")
    def _bands_apart(self) -> PerforationSettings:
        bands = sorted(self.bands, key=lambda band: band.from_deg)
        for lower, upper in pairwise(bands):
            if upper.from_deg < lower.to_deg:
                raise ValueError(
                    f"bands from {lower.from_deg:g} to {lower.to_deg:g} and from "
                    f"{upper.from_deg:g} to {upper.to_deg:g} degrees overlap. Let one end where "
                    "the other begins"
                )
        return self
