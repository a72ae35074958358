"""What is a sheet made of, and which machine cuts it? Both are data that a person can replace."""

from __future__ import annotations

import difflib
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Literal, TypeVar

from pydantic import Field, ValidationError, field_validator, model_validator

from fab.colours import Colours
from fab.dxf import DxfVersion
from fab.errors import InvalidJob
from fab.settings import Settings

__all__ = [
    "Machine",
    "Material",
    "Perforation",
    "Speeds",
    "load_machine",
    "load_material",
    "perforation_for",
    "shipped",
]

_PACKAGED = Path(__file__).parent / "templates"
_CHECKED_OUT = Path(__file__).parent.parent / "templates"

# What each style of a crease is described by; all but `rows` in millimetres.
_STYLES = {
    "score": (),
    "dashes": ("cut_mm", "gap_mm"),
    "dash_dot": ("cut_mm", "dot_mm", "gap_mm"),
    "dots": ("dot_mm", "pitch_mm"),
    "lattice": ("cut_mm", "gap_mm", "rows", "pitch_mm"),
    "engrave": (),
    "none": (),
}
_SCORE = {"kind": "score"}

Style = dict[str, str | float | int]


class _Described(Settings):
    """Base of materials and machines: what it is, and which of its values are to be tried first."""

    description: str = Field(min_length=1)
    starting_points: list[str] = Field(
        default=[],
        description="keys, such as speeds.cut_mm_s, whose values differ by machine: "
        "a test card finds the right ones",
    )

    @model_validator(mode="after")
    def _names_keys(self) -> _Described:
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


class Perforation(Settings):
    """How creases are made, by assignment: a table of `kind` and its lengths for each."""

    margin_mm: float = Field(gt=0, le=1000, description="uncut at both ends of every crease")
    mountain: Style
    valley: Style

    @field_validator("mountain", "valley")
    @classmethod
    def _known_style(cls, style: Style) -> Style:
        kind = style.get("kind")
        if kind not in _STYLES:
            close = difflib.get_close_matches(str(kind), _STYLES, 1, 0.5)
            hint = f". Did you mean {close[0]}?" if close else ""
            raise ValueError(f"kind = {kind!r} must be one of {', '.join(_STYLES)}{hint}")
        wanted = _STYLES[str(kind)]
        if set(style) != {"kind", *wanted}:
            needs = ", ".join(wanted) or "no lengths"
            given = ", ".join(sorted(set(style) - {"kind"})) or "none"
            raise ValueError(f"kind = {kind!r} takes {needs}; given are {given}")
        for name in wanted:
            value = style[name]
            whole = name == "rows"
            if isinstance(value, str | bool) or (whole and not isinstance(value, int)):
                raise ValueError(f"{name} = {value!r} must be a {'whole ' * whole}number")
            low, high = (1, 99) if whole else (0.01, 1000)
            if not low <= value <= high:
                raise ValueError(f"{name} = {value} must lie from {low} to {high}")
        return style


class Material(_Described):
    """A sheet, and how creases are best made in it."""

    thickness_mm: float = Field(gt=0, le=100)
    density_kg_m3: float = Field(gt=0, le=30000)
    web_mm: float = Field(gt=0, le=100, description="least width that may stay between two cuts")
    tab_mm: float = Field(gt=0, le=200, description="height of glue tabs")
    bend_radius_mm: float | None = Field(
        default=None,
        ge=0,
        le=1000,
        description="least inner radius of a bend that is not cut into; none where unknown",
    )
    relief_mm: float = Field(
        default=0, ge=0, le=50, description="least diameter of relief holes at vertices; 0 for none"
    )
    cut_speed_ratio: float = Field(
        gt=0, le=10, description="speed of cutting through, over that of the machine (300 gsm card)"
    )
    perforation: Perforation

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


class Machine(_Described):
    """What cuts the sheet: how large, how fast, and which file its software wants."""

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


def perforation_for(machine: Machine, material: Material) -> Perforation:
    """How creases of the material are drawn for the machine.

    For software that perforates by itself each crease is one whole line on its layer.
    """
    if machine.profile == "pre_dashed":
        return material.perforation
    return material.perforation.model_copy(update={"mountain": _SCORE, "valley": _SCORE})


def load_material(name_or_path: str | Path) -> Material:
    """A shipped material by name, or one of the user's own by the path of its TOML file.

    Raises `InvalidJob` with every key at fault.
    """
    return _load(Material, "materials", name_or_path)


def load_machine(name_or_path: str | Path) -> Machine:
    """A shipped machine by name, or one of the user's own by the path of its TOML file.

    Raises `InvalidJob` with every key at fault.
    """
    return _load(Machine, "machines", name_or_path)


def shipped(kind: Literal["materials", "machines"]) -> dict[str, Path]:
    """Files of the shipped materials or machines, by name."""
    folder = (_PACKAGED if _PACKAGED.is_dir() else _CHECKED_OUT) / kind
    return {path.stem: path for path in sorted(folder.glob("*.toml"))}


Kind = TypeVar("Kind", Material, Machine)


def _load(
    model: type[Kind], kind: Literal["materials", "machines"], name_or_path: str | Path
) -> Kind:
    path = Path(name_or_path)
    if path.suffix != ".toml":
        known = shipped(kind)
        if str(name_or_path) not in known:
            close = difflib.get_close_matches(str(name_or_path), known, 1, 0.4)
            hint = f" Did you mean {close[0]}?" if close else ""
            raise InvalidJob(
                f"{kind[:-1]} {str(name_or_path)!r} must be one of {', '.join(known)}, or the path "
                f"of a .toml file.{hint}"
            )
        path = known[str(name_or_path)]
    try:
        document = tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except OSError as error:
        raise InvalidJob(f"{path}: cannot be read: {error.strerror}. Check the path.") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError) as error:
        raise InvalidJob(f"{path}: not a TOML file: {error}.") from error
    try:
        return model.model_validate(document)
    except ValidationError as error:
        lines = [_explain(e, model) for e in error.errors(include_url=False)]
        raise InvalidJob(f"{path}: " + "\n".join(lines)) from error


def _explain(error: Any, model: type[Settings]) -> str:
    place = [str(part) for part in error["loc"]]
    key = ".".join(place)
    message = error["msg"].removeprefix("Value error, ")
    message += "" if message.endswith("?") else "."
    if error["type"] == "extra_forbidden":
        table: Any = model
        for part in place[:-1]:
            table = table.model_fields[part].annotation
        known = sorted(table.model_fields)
        close = difflib.get_close_matches(place[-1], known, 1, 0.6)
        hint = f" Did you mean {close[0]}?" if close else ""
        return f"{key} is not a known key.{hint} Known here: {', '.join(known)}."
    if error["type"] == "missing":
        return f"{key} is missing. Add it, or begin with a copy of a shipped file."
    if isinstance(error.get("input"), Mapping):
        return f"{key}: {message}" if key else message
    return f"{key} = {error.get('input')!r} is refused: {message}"
