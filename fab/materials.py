"""What is a sheet made of, and which machine cuts it? Both are data that a person can replace."""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Literal, TypeVar, get_args

from pydantic import Field, field_validator, model_validator

from fab.colours import Colours
from fab.dxf import DxfVersion
from fab.errors import InvalidJob
from fab.perforation import PerforationSettings
from fab.settings import Settings, checked, read_toml
from fab.shipped import shipped
from fab.styles import ScoreStyle

__all__ = [
    "Described",
    "Machine",
    "Material",
    "Speeds",
    "described",
    "load_described",
    "load_machine",
    "load_material",
    "perforation_for",
    "shipped_of",
]


_CURE = "Begin with a copy of a shipped file."
# What a material must say of its creases; the rest takes the defaults of a job.
_OF_MATERIALS = ("margin_mm", "mountain", "valley")


class Described(Settings):
    """Base of materials and machines: what it is, and which of its values are to be tried first."""

    description: str = Field(min_length=1, description="one line, for lists of names")
    starting_points: list[str] = Field(
        default=[],
        description="keys, such as speeds.cut_mm_s, whose values differ by machine: "
        "a test card finds the right ones",
    )

    @model_validator(mode="after")
    def _names_keys(self) -> Described:
        known = sorted(_keys(self.model_dump()))
        for key in self.starting_points:
            if key not in known:
                close = difflib.get_close_matches(key, known, 1, 0.6)
                hint = f" Did you mean {close[0]}?" if close else ""
                raise ValueError(f"starting_points names {key}, which is no key here.{hint}")
        return self


def _keys(table: Mapping[str, Any], above: str = "") -> Iterator[str]:
    for key, value in table.items():
        yield above + key
        if isinstance(value, Mapping):
            yield from _keys(value, f"{above}{key}.")


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
    perforation: PerforationSettings = Field(description="as in a job")

    @field_validator("perforation")
    @classmethod
    def _says_how(cls, perforation: PerforationSettings) -> PerforationSettings:
        missing = [key for key in _OF_MATERIALS if key not in perforation.model_fields_set]
        if missing:
            raise ValueError(f"{' and '.join(missing)} must be given in a material. {_CURE}")
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


class Machine(Described):
    """What cuts the sheet: how large, how fast, and which file its software wants."""

    kind: Literal["cutter"] = "cutter"
    bed_mm: tuple[float, float] = Field(strict=False, description="width and height")
    margin_mm: float = Field(ge=0, le=500, description="of the bed, on all sides, kept free")
    kerf_mm: float = Field(ge=0, le=10, description="width of material that a cut takes away")
    speeds: Speeds
    profile: Literal["pre_dashed", "whole_lines"] = Field(
        description="creases as dashes, or as whole lines for software that perforates by itself"
    )
    dxf_version: DxfVersion = Field(default=DxfVersion.R2000, strict=False)
    colours: Colours = Colours()

    @field_validator("bed_mm")
    @classmethod
    def _has_size(cls, sides: tuple[float, float]) -> tuple[float, float]:
        if not all(0 < side <= 1e5 for side in sides):
            raise ValueError("both sides must be above 0 and at most 100000 mm")
        return sides

    @model_validator(mode="after")
    def _has_room(self) -> Machine:
        if min(self.room_mm) <= 0:
            raise ValueError(
                f"margin_mm = {self.margin_mm:g} leaves nothing of bed_mm = {list(self.bed_mm)}: "
                f"it must be below {min(self.bed_mm) / 2:g}"
            )
        return self

    @property
    def room_mm(self) -> tuple[float, float]:
        """Width and height of the bed within its margins."""
        width, height = self.bed_mm
        return width - 2 * self.margin_mm, height - 2 * self.margin_mm


def perforation_for(
    machine: Machine, material: Material, *, scored: bool = False
) -> PerforationSettings:
    """How creases of the material are drawn for the machine.

    Where they are scored, and for software that perforates by itself, each crease is one whole line
    on the layer of its letter.
    """
    if machine.profile == "pre_dashed" and not scored:
        return material.perforation
    whole = {"mountain": ScoreStyle(), "valley": ScoreStyle(), "bands": []}
    return material.perforation.model_copy(update=whole)


def load_material(name_or_path: str | Path) -> Material:
    """A shipped sheet material by name, or one of the user's own by the path of its TOML file.

    Raises `InvalidJob` with every key at fault, and for what is printed.
    """
    return load_described(Material, "materials", name_or_path)


def load_machine(name_or_path: str | Path) -> Machine:
    """A shipped cutter by name, or one of the user's own by the path of its TOML file.

    Raises `InvalidJob` with every key at fault, and for printers.
    """
    return load_described(Machine, "machines", name_or_path)


Model = TypeVar("Model", bound=Described)
Folder = Literal["materials", "machines"]
# What a file is that does not say so.
_KINDS = {"materials": "sheet", "machines": "cutter"}


def described(folder: Folder) -> dict[str, tuple[str, str]]:
    """Kind and description of every shipped material or machine, by name."""
    documents = {name: read_toml(path, "") for name, path in shipped(folder).items()}
    return {
        name: (_kind(document, folder), str(document["description"]))
        for name, document in documents.items()
    }


def shipped_of(kind: Literal["sheet", "print", "cutter", "printer"]) -> dict[str, Path]:
    """TOML files of the shipped sheets, print materials, cutters or printers, by name, sorted."""
    folder: Folder = "materials" if kind in ("sheet", "print") else "machines"
    kinds = described(folder)
    return {name: path for name, path in shipped(folder).items() if kinds[name][0] == kind}


def load_described(model: type[Model], folder: Folder, name_or_path: str | Path) -> Model:
    """A shipped file by name or any other by its path, as the model that its kind is.

    Raises `InvalidJob` with every key at fault, and for files of another kind.
    """
    (wanted,) = get_args(model.model_fields["kind"].annotation)
    path = Path(name_or_path)
    if path.suffix != ".toml":
        name = str(name_or_path)
        kinds = {known: kind for known, (kind, _) in described(folder).items()}
        known = [name for name, kind in kinds.items() if kind == wanted]
        if name not in known:
            what = f"is a {kinds[name]}, not a {wanted}: it " if name in kinds else ""
            close = difflib.get_close_matches(name, known, 1, 0.4)
            hint = f" Did you mean {close[0]}?" if close else ""
            raise InvalidJob(
                f"{folder[:-1]} {name!r} {what}must be one of {', '.join(known)}, or the path "
                f"of a .toml file.{hint}"
            )
        path = shipped(folder)[name]
    document = read_toml(path, f"Check the path, or list the names: `quadfold shipped {folder}`.")
    kind = _kind(document, folder)
    if kind != wanted:
        raise InvalidJob(
            f"{path}: kind = {kind!r} must be {wanted!r} here. List the names: "
            f"`quadfold shipped {folder}`."
        )
    return checked(model, document, str(path), _CURE)


def _kind(document: Mapping[str, Any], folder: Folder) -> str:
    return str(document.get("kind", _KINDS[folder]))
