"""What does a job say: which design, which size, which styles, and is all of it known?"""

from __future__ import annotations

import dataclasses
import difflib
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal, Union, get_type_hints

from pydantic import Field, PrivateAttr, create_model, model_validator

from fab.errors import InvalidJob
from fab.folding.fold_settings import FoldSettings
from fab.pattern.development import Development
from fab.printing.thick_settings import ThickSettings
from fab.settings import Settings, apply_change, checked, read_toml
from fab.sheets.perforation import PerforationSettings
from solver import DESIGNS, Design
from solver.designs.surface_fit import SURFACES
from solver.targets.base import Target

__all__ = ["Job", "SheetSettings", "design_key", "load_job", "parse_job"]

_CURE = "`quadfold new` copies a complete job."


class DesignSettings(Settings):
    """Base of the `design` tables; one for each design of the solver."""

    def design(self, folder: Path) -> Design:
        """The solver's design with these parameters, angles in radians.

        folder : where files that the job names are looked for. Raises `InvalidFile` for those that
        cannot be used.
        """
        values = self.model_dump()
        cls = DESIGNS[values.pop("kind")]
        given = {}
        for field in dataclasses.fields(cls):
            value = values[design_key(field)]
            if _is_angle(field) and value is not None:
                value = math.radians(value)
            elif _is_target(field):
                value = _target(value, values["face"], values["up"], folder)
            given[field.name] = value
        design: Design = cls(**given)
        return design


def _target(surface: str, face: int | None, up: list[float] | None, folder: Path) -> str | Target:
    """A surface by name, or from a file (which is told by its ending)."""
    if Path(surface).suffix:
        from fab.formats.surface import read_surface

        target: Target = read_surface(folder / surface, face, up)
        return target
    if face is not None or up is not None:
        raise InvalidJob(
            f"design.face = {face} and design.up = {up} must be left out for surface = "
            f"{surface!r}: only STEP files have faces to choose from, and only meshes a side."
        )
    if surface not in SURFACES:
        close = difflib.get_close_matches(surface, SURFACES, 1, 0.4)
        hint = f" Did you mean {close[0]}?" if close else ""
        raise InvalidJob(
            f"design.surface = {surface!r} must be one of {', '.join(SURFACES)}, or a file that "
            f"ends in .stl, .obj, .ply, .step or .stp.{hint}"
        )
    return surface


def _is_angle(field: dataclasses.Field[Any]) -> bool:
    return bool(field.metadata.get("angle"))


def _is_target(field: dataclasses.Field[Any]) -> bool:
    return bool(field.metadata.get("target"))


def design_key(field: dataclasses.Field[Any]) -> str:
    """The key of a design's field in a job: angles are given in degrees, and named so."""
    return f"{field.name}_deg" if _is_angle(field) else field.name


def _design_settings(kind: str, cls: type[Design]) -> type[DesignSettings]:
    """The job table of a design: its own fields, with angles in degrees and named so."""
    types = get_type_hints(cls)
    fields: dict[str, Any] = {"kind": (Literal[kind], ...)}
    for field in dataclasses.fields(cls):
        default: Any = field.default
        if _is_angle(field) and default is not None:
            default = round(math.degrees(default), 10)
        fields[design_key(field)] = (str if _is_target(field) else types[field.name], default)
        if _is_target(field):  # a file may hold several surfaces
            fields["face"] = (int | None, None)
            direction = Annotated[list[float], Field(min_length=3, max_length=3)]
            fields["up"] = (direction | None, None)
    return create_model(f"{cls.__name__}Settings", __base__=DesignSettings, **fields)


_DESIGN_SETTINGS = {kind: _design_settings(kind, cls) for kind, cls in DESIGNS.items()}


class SheetSettings(Settings):
    """How large the flat sheet is; exactly one of the two."""

    width_mm: float | None = Field(
        default=None, gt=0, le=1e5, description="longer side of the flat sheet"
    )
    scale_mm_per_unit: float | None = Field(
        default=None, gt=0, le=1e8, description="mm per design unit"
    )

    @model_validator(mode="after")
    def _one(self) -> SheetSettings:
        if (self.width_mm is None) == (self.scale_mm_per_unit is None):
            raise ValueError(
                f"width_mm = {self.width_mm} and scale_mm_per_unit = {self.scale_mm_per_unit}, "
                "give exactly one of them"
            )
        return self

    def scale(self, development: Development) -> float:
        """Millimetres per design unit."""
        if self.scale_mm_per_unit is not None:
            return self.scale_mm_per_unit
        assert self.width_mm is not None  # the validator's promise
        return self.width_mm / float(development.vertices_coords.max())


class Job(ThickSettings):
    """Everything that a job file says. Unknown keys, NaN and values out of bounds are refused."""

    name: str = Field(
        pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]{0,99}$",
        description="1 to 100 letters, digits, '_', '-' or '.', of which the first is a letter or "
        "digit: it names the files in the output folder",
    )
    description: str = ""
    outputs: list[Literal["fold", "dxf", "svg", "step", "stl", "3mf", "png", "zip"]] = Field(
        default=["fold", "dxf", "svg", "step", "stl", "3mf", "png"],
        min_length=1,
        description="what is made where the command line does not say",
    )
    tolerance: float = Field(default=1e-9, gt=0, description="of planarity and so on, relative")
    design: Annotated[Union[tuple(_DESIGN_SETTINGS.values())], Field(discriminator="kind")]  # type: ignore[valid-type] # noqa: UP007
    sheet: SheetSettings
    perforation: PerforationSettings = PerforationSettings()
    simulation: FoldSettings | None = Field(
        default=None, description="fold the sheet from flat and judge; not where left out"
    )
    _folder: Path = PrivateAttr(default=Path())

    @property
    def folder(self) -> Path:
        """Where files that the job names are looked for."""
        return self._folder


def load_job(path: Path, changes: Sequence[str] = ()) -> Job:
    """Read a job from a TOML file, with `changes` such as "design.strips=4" laid over it.

    Raises `InvalidJob` with every key at fault, its bound and its cure.
    """
    document = read_toml(path, f"Check the path. {_CURE}")
    for change in changes:
        apply_change(document, change)
    return parse_job(document, str(path), path.parent)


def parse_job(document: Mapping[str, Any], source: str = "job", folder: Path = Path()) -> Job:
    """Check a job given as nested tables. Raises `InvalidJob`; `source` begins its message.

    folder : where files that the job names are looked for.
    """
    job = checked(Job, document, source, _CURE)
    job._folder = folder
    return job
