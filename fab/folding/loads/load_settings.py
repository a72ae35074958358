"""Settings of loads: what a folded sheet carries, where it is held, and what it is made of."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, field_validator, model_validator

from fab.settings import Settings

__all__ = ["AtVertices", "LoadSettings", "PullSettings"]

Places = Literal[
    "left edge", "right edge", "top edge", "bottom edge", "border", "corners", "lowest", "highest"
]
Vertex = Annotated[int, Field(ge=0)]
Coordinate = Annotated[float, Field(ge=-1e6, le=1e6)]
Region = Annotated[list[Coordinate], Field(min_length=4, max_length=4)]
Newtons = Annotated[float, Field(ge=-1e6, le=1e6)]
Direction = Annotated[float, Field(ge=-1e6, le=1e6)]

AtVertices = Annotated[
    list[Places | Vertex | Region],
    Field(
        min_length=1,
        description="vertices by number; a region of the flat sheet, [x from, y from, x to, y to] "
        'in mm; or "left edge", "right edge", "top edge", "bottom edge" of the flat sheet, its '
        '"corners" or its "border", without holes and slits; "lowest" or "highest" of '
        "the folded sheet. Edges and vertices that are held may turn; a region is clamped",
    ),
]


class PullSettings(Settings):
    """A force on some vertices."""

    at: AtVertices
    force_n: tuple[Newtons, Newtons, Newtons] = Field(
        strict=False, description="x, y and z of the whole force, which the vertices share equally"
    )


class LoadSettings(Settings):
    """What the folded sheet carries, in the pose in which pictures show it, z up."""

    material: str | None = Field(
        default=None,
        description="a shipped sheet material, or a .toml file, with youngs_modulus_mpa; that of "
        "[cutter] where left out",
    )
    fixed: AtVertices
    weight: bool = Field(default=True, description="whether the sheet's own weight pulls it down")
    down: tuple[Direction, Direction, Direction] = Field(
        default=(0.0, 0.0, -1.0), strict=False, description="the direction of the weight"
    )
    pulls: list[PullSettings] = Field(default=[], description="forces on vertices")
    pressure_pa: float = Field(
        default=0.0,
        ge=-1e7,
        le=1e7,
        description="on the lower sides of faces, towards their upper sides",
    )
    pressure_faces: list[Vertex] | None = Field(
        default=None, min_length=1, description="faces with the pressure; all where left out"
    )
    parts: int | None = Field(
        default=None,
        ge=1,
        le=50,
        description="into how many parts each side of the faces' triangles is divided, so that "
        "they bend; up to 6, for up to about 1,500 triangles, where left out",
    )
    load_steps: int = Field(default=4, ge=1, le=1000, description="equal steps of the load")

    @field_validator("down")
    @classmethod
    def _points_somewhere(cls, down: tuple[float, float, float]) -> tuple[float, float, float]:
        if not any(down):
            raise ValueError("must not be zero: [0.0, 0.0, -1.0] is down in pictures")
        return down

    @model_validator(mode="after")
    def _has_a_load(self) -> LoadSettings:
        if not (self.weight or self.pulls or self.pressure_pa):
            raise ValueError("there is no load: give weight = true, pulls or pressure_pa")
        return self
