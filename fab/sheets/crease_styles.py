"""Styles of creases, as a job or a material sets them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal, TypeAlias

from pydantic import BeforeValidator, Field, model_validator

from fab.settings import Settings

__all__ = [
    "CreaseStyle",
    "DashDotStyle",
    "DashStyle",
    "DotStyle",
    "EngraveStyle",
    "LatticeStyle",
    "NoStyle",
    "ScoreStyle",
]

_Length = Annotated[float, Field(ge=0.01, le=1000)]


class ScoreStyle(Settings):
    """One solid line between the margins: a score, or a half cut."""

    kind: Literal["score"] = "score"


class DashStyle(Settings):
    """Cuts and gaps along a crease; the ratio is kept and the period fitted to each crease."""

    kind: Literal["dashes"] = "dashes"
    cut_mm: _Length = Field(description="length of each cut")
    gap_mm: _Length = Field(description="uncut material between two cuts")


class DashDotStyle(Settings):
    """Dash, gap, dot, gap, and so on, with a dash at both ends."""

    kind: Literal["dash_dot"] = "dash_dot"
    cut_mm: _Length = Field(description="length of each dash")
    dot_mm: _Length = Field(description="length of each dot")
    gap_mm: _Length = Field(description="uncut material between a dash and a dot")


class DotStyle(Settings):
    """Pierces at a steady pitch."""

    kind: Literal["dots"] = "dots"
    dot_mm: _Length = Field(description="length of each pierce")
    pitch_mm: _Length = Field(description="from the middle of a pierce to that of the next")

    @model_validator(mode="after")
    def _dot_below_pitch(self) -> DotStyle:
        if self.dot_mm >= self.pitch_mm:
            raise ValueError(
                f"dot_mm = {self.dot_mm:g} must be below pitch_mm = {self.pitch_mm:g}, or the dots "
                "join to a cut. Lower dot_mm, or take the style score"
            )
        return self


class LatticeStyle(Settings):
    """A living hinge for rigid sheet: rows of slits along the crease, every other one shifted.

    The band is (rows - 1) pitch_mm wide, with the crease in its middle. A crease without room for
    two slits in a row has a single one, on its line, and does not bend.
    """

    kind: Literal["lattice"] = "lattice"
    cut_mm: _Length = Field(description="length of each slit")
    gap_mm: _Length = Field(description="uncut bridge between two slits of a row")
    rows: int = Field(ge=2, le=100, description="rows of slits beside each other")
    pitch_mm: _Length = Field(description="from a row to the next")

    @model_validator(mode="after")
    def _slits_overlap(self) -> LatticeStyle:
        if self.gap_mm >= self.cut_mm:
            raise ValueError(
                f"gap_mm = {self.gap_mm:g} must be below cut_mm = {self.cut_mm:g}: slits of "
                "neighbouring rows have to pass each other, or nothing bends. Lower gap_mm"
            )
        return self

    @property
    def width_mm(self) -> float:
        """From the first row to the last."""
        return (self.rows - 1) * self.pitch_mm

    @property
    def least_room_mm(self) -> float:
        """Room that a crease must exceed to have two slits in a row."""
        return self.cut_mm + (self.cut_mm + self.gap_mm) / 2


class EngraveStyle(Settings):
    """A mark only: one line between the margins on the layer of engravings."""

    kind: Literal["engrave"] = "engrave"


class NoStyle(Settings):
    """Nothing is drawn."""

    kind: Literal["none"] = "none"


def _dashes_by_default(value: Any) -> Any:
    if isinstance(value, Mapping) and "kind" not in value:
        return {"kind": "dashes", **value}
    return value


CreaseStyle: TypeAlias = Annotated[
    ScoreStyle | DashStyle | DashDotStyle | DotStyle | LatticeStyle | EngraveStyle | NoStyle,
    Field(discriminator="kind"),
    BeforeValidator(_dashes_by_default),
]
