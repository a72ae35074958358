"""Sheet materials and the machines that cut them, both data that users can replace."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, field_validator

from fab.catalogue import CURE, Bedded, Described, load_described
from fab.drawings.beam import Beam
from fab.drawings.dxf import DxfVersion
from fab.drawings.layer_colours import Colours
from fab.drawings.svg import STROKE_MM
from fab.errors import did_you_mean
from fab.settings import Settings
from fab.sheets.crease_styles import ScoreStyle
from fab.sheets.perforation_settings import PerforationSettings

__all__ = [
    "Machine",
    "Material",
    "Powers",
    "Speeds",
    "load_machine",
    "load_material",
    "perforation_for",
]

Percent = Annotated[float, Field(ge=0, le=100)]
Degrees = Annotated[float, Field(ge=-360, le=360)]
KerfWidth = Annotated[float, Field(ge=0, le=10)]
KerfWidths = Annotated[tuple[KerfWidth, KerfWidth], Field(strict=False)]

# Words for rotations; None for any.
_TURNS_DEG = {"any": None, "half turns": [0.0, 180.0], "none": [0.0]}
# What a material must state about its creases; the rest takes the defaults of a job.
_OF_MATERIALS = ("margin_mm", "mountain", "valley")


class Material(Described):
    """A sheet, and how creases are best made in it."""

    kind: Literal["sheet"] = "sheet"
    thickness_mm: float = Field(gt=0, le=100, description="of the sheet")
    density_kg_m3: float = Field(gt=0, le=30000, description="of the sheet, 833 for card")
    tab_mm: float = Field(gt=0, le=200, description="height of glue tabs")
    bend_radius_mm: float | None = Field(
        default=None,
        ge=0,
        le=1000,
        description="least inner radius of a bend that is not cut into; none where unknown",
    )
    cut_speed_ratio: float = Field(
        gt=0, le=10, description="speed of cutting through, over that of the machine (300 gsm card)"
    )
    rotations_deg: Annotated[list[Degrees], Field(min_length=1)] | None = Field(
        default=None,
        description="by which pieces may be turned on the sheet: any, half turns, none, or a list "
        "such as [0.0, 180.0]",
    )
    grain_deg: Degrees | None = Field(
        default=None,
        description="direction of the grain of the sheet as it lies on the bed: 0 along x, 90 "
        "along y; left out where it has none",
    )
    youngs_modulus_mpa: float | None = Field(
        default=None, gt=0, le=1e6, description="of the sheet; loads need it"
    )
    poissons_ratio: float = Field(default=0.3, ge=0, lt=0.5, description="of the sheet")
    strain_max: float | None = Field(
        default=None,
        gt=0,
        le=2,
        description="of its outer fibre, without breaking or yielding; none where unknown",
    )
    crease_stiffness_n: float | None = Field(
        default=None,
        ge=0,
        le=1e6,
        description="moment that turns a crease, per length and radian; the bending stiffness of "
        "the sheet over 100 thicknesses where left out",
    )
    perforation: PerforationSettings = Field(description="as in a job")

    @field_validator("rotations_deg", mode="before")
    @classmethod
    def _in_words(cls, rotations: Any) -> Any:
        if not isinstance(rotations, str):
            return rotations
        if rotations not in _TURNS_DEG:
            hint = did_you_mean(rotations, _TURNS_DEG)
            raise ValueError(f"must be one of {', '.join(_TURNS_DEG)}, or a list of angles.{hint}")
        return _TURNS_DEG[rotations]

    @field_validator("perforation")
    @classmethod
    def _states_creases(cls, perforation: PerforationSettings) -> PerforationSettings:
        missing = [key for key in _OF_MATERIALS if key not in perforation.model_fields_set]
        if missing:
            raise ValueError(f"{' and '.join(missing)} must be given in a material. {CURE}")
        return perforation

    @property
    def grams_per_m2(self) -> float:
        """Mass of the sheet by area."""
        return self.thickness_mm * self.density_kg_m3


class Speeds(Settings):
    """How fast a machine works, in 300 gsm card."""

    cut_mm_s: float = Field(gt=0, le=10000, description="through the sheet, along outlines")
    perforate_mm_s: float = Field(gt=0, le=10000, description="through the sheet, dash by dash")
    engrave_mm_s: float = Field(gt=0, le=10000, description="marks on the surface")
    travel_mm_s: float = Field(gt=0, le=10000, description="between cuts")
    pierce_s: float = Field(ge=0, le=60, description="to begin a cut, on and off")


class Powers(Settings):
    """Share of a laser's full power, at the machine's speeds; left out where it is not known."""

    cut_percent: Percent | None = Field(default=None, description="outlines and relief holes")
    perforate_percent: Percent | None = Field(default=None, description="creases cut by dashes")
    score_percent: Percent | None = Field(
        default=None, description="creases scored as whole lines, which are not cut through"
    )
    engrave_percent: Percent | None = Field(default=None, description="marks on the surface")


class Knife(Settings):
    """How a knife cuts, and how any tool begins and ends closed cuts; nothing of it by default."""

    offset_mm: float = Field(
        default=0.0,
        ge=0,
        le=5,
        description="of a drag knife: from its axis to the tip of the blade, where the machine's "
        "software does not allow for it",
    )
    corner_deg: float = Field(
        default=20.0,
        ge=1,
        le=90,
        description="the blade swivels at corners that turn by more",
    )
    overcut_mm: float = Field(
        default=0.0, ge=0, le=50, description="by which closed cuts go on beyond their start"
    )
    lead_in_mm: float = Field(
        default=0.0, ge=0, le=50, description="cut in the waste before a closed cut"
    )


class Machine(Bedded):
    """What cuts the sheet: how large, how fast, and which file its software wants."""

    kind: Literal["cutter"] = "cutter"
    kerf_mm: KerfWidth | KerfWidths = Field(
        description="width of material that a cut takes away; [x, y] where the beam is wider along "
        "one axis of the bed: cuts along y are x wide, and cuts along x are y wide"
    )
    speeds: Speeds
    powers: Powers = Powers()
    knife: Knife = Knife()
    s_max: float = Field(
        default=1000.0, gt=0, le=1e6, description="S of G-code at full power, $30 of GRBL"
    )
    stroke_mm: float = Field(
        default=STROKE_MM,
        ge=0.001,
        le=1,
        description="width of lines in SVG; some drivers cut only hairlines",
    )
    profile: Literal["pre_dashed", "whole_lines"] = Field(
        description="creases as dashes, or as whole lines for software that perforates by itself"
    )
    dxf_version: DxfVersion = Field(
        default=DxfVersion.R2000,
        strict=False,
        description="of DXF files; R12 for software that reads no other",
    )
    colours: Colours = Colours()

    @field_validator("kerf_mm")
    @classmethod
    def _has_both_widths(cls, kerf_mm: float | tuple[float, float]) -> float | tuple[float, float]:
        if isinstance(kerf_mm, tuple) and (kerf_mm[0] == 0) != (kerf_mm[1] == 0):
            raise ValueError("both widths must be above 0, or both be 0 for a knife")
        return kerf_mm

    @property
    def beam(self) -> Beam:
        """What it takes away at one place."""
        widths = self.kerf_mm
        return Beam(*widths) if isinstance(widths, tuple) else Beam.of(widths)


def perforation_for(
    machine: Machine, material: Material, *, scored: bool = False, dashed: bool = False
) -> PerforationSettings:
    """How creases of the material are drawn for the machine.

    Where they are scored, and for software that perforates by itself, each crease is a whole line
    on the layer of its assignment. dashed : whether dashes are drawn for such software too.
    """
    if (dashed or machine.profile == "pre_dashed") and not scored:
        return material.perforation
    whole = {"mountain": ScoreStyle(), "valley": ScoreStyle(), "bands": []}
    return material.perforation.model_copy(update=whole)


def load_material(name_or_path: str | Path) -> Material:
    """A shipped sheet material by name, or one of the user's own by the path of its TOML file.

    Raises `InvalidJob` with every key at fault, and for materials of printers.

    >>> load_material("card_300gsm").thickness_mm
    0.36
    """
    return load_described(Material, "materials", name_or_path)


def load_machine(name_or_path: str | Path) -> Machine:
    """A shipped cutter by name, or one of the user's own by the path of its TOML file.

    Raises `InvalidJob` with every key at fault, and for printers.

    >>> load_machine("co2_60w_600x400").bed_mm
    (600.0, 400.0)
    """
    return load_described(Machine, "machines", name_or_path)
