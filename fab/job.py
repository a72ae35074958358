"""What does a job say: which design, which size, which styles, and is all of it known?"""

from __future__ import annotations

import dataclasses
import difflib
import math
import re
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

from pydantic import Field, PrivateAttr, ValidationError, create_model, model_validator

from fab.development import Development
from fab.errors import InvalidJob
from fab.hinges import HingeSettings
from fab.panels import PanelSettings
from fab.perforation import PerforationSettings
from fab.settings import Settings
from solver import DESIGNS, Design
from solver.designs.surface_fit import SURFACES
from solver.targets import Target

__all__ = ["Job", "SheetSettings", "design_key", "load_job", "parse_job"]


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
        from fab.surface_file import read_surface

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


class Job(Settings):
    """Everything that a job file says. Unknown keys, NaN and values out of bounds are refused."""

    name: str = Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]{0,99}$")
    description: str = ""
    outputs: list[Literal["fold", "dxf", "svg", "step", "stl", "3mf", "png"]] = Field(
        default=["fold", "dxf", "svg", "step", "stl", "3mf", "png"],
        min_length=1,
        description="what is made where the command line does not say",
    )
    tolerance: float = Field(default=1e-9, gt=0, description="of planarity and so on, relative")
    design: Annotated[Union[tuple(_DESIGN_SETTINGS.values())], Field(discriminator="kind")]  # type: ignore[valid-type] # noqa: UP007
    sheet: SheetSettings
    perforation: PerforationSettings = PerforationSettings()
    panels: PanelSettings = PanelSettings()
    hinges: HingeSettings = HingeSettings()
    _folder: Path = PrivateAttr(default=Path())

    @property
    def folder(self) -> Path:
        """Where files that the job names are looked for."""
        return self._folder

    @model_validator(mode="after")
    def _web_below_panel(self) -> Job:
        if self.hinges.web_mm >= self.panels.thickness_mm:
            raise ValueError(
                f"hinges.web_mm = {self.hinges.web_mm:g} must be below panels.thickness_mm = "
                f"{self.panels.thickness_mm:g}: a web is thinner than its panels"
            )
        return self


def load_job(path: Path, changes: Sequence[str] = ()) -> Job:
    """Read a job from a TOML file, with `changes` such as "design.strips=4" laid over it.

    Raises `InvalidJob` with every key at fault, its bound and its cure.
    """
    try:
        document = tomllib.loads(_text(path))
    except OSError as error:
        raise InvalidJob(
            f"{path}: cannot be read: {error.strerror}. Check the path, or copy a template with "
            "`quadfold new`."
        ) from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError) as error:
        raise InvalidJob(f"{path}: not a TOML file: {error}.") from error
    for change in changes:
        _apply(document, change)
    return parse_job(document, str(path), path.parent)


def _text(path: Path) -> str:
    if path.exists() and not path.is_file():
        raise InvalidJob(f"{path}: not a file. Give the path of a job file.")
    return path.read_text(encoding="utf-8-sig")


def _apply(document: dict[str, Any], change: str) -> None:
    key, equals, text = change.partition("=")
    parts = [part.strip() for part in key.split(".")]
    if not equals or not all(parts):
        raise InvalidJob(f"--set {change}: must have the form key=value, as in design.strips=4.")
    try:
        parsed = tomllib.loads(f"value = {text}")
        value = parsed["value"] if len(parsed) == 1 else text
    except (tomllib.TOMLDecodeError, RecursionError):
        value = text.strip()
    table = document
    for part in parts[:-1]:
        table = table.setdefault(part, {})
        if not isinstance(table, dict):
            raise InvalidJob(f"--set {change}: {part} is a value, not a table.")
    table[parts[-1]] = value


def parse_job(document: Mapping[str, Any], source: str = "job", folder: Path = Path()) -> Job:
    """Check a job given as nested tables. Raises `InvalidJob`; `source` begins its message.

    folder : where files that the job names are looked for.
    """
    try:
        job = Job.model_validate(document)
    except ValidationError as error:
        lines = [_explain(e, document) for e in error.errors(include_url=False)]
        raise InvalidJob(f"{source}: " + "\n".join(lines)) from error
    job._folder = folder
    return job


def _explain(error: Any, document: Mapping[str, Any]) -> str:
    place = _place(error["loc"], document)
    key = ".".join(place) or "job"
    kind, value = error["type"], error.get("input")
    if kind == "extra_forbidden":
        here = _known_keys(place[:-1], document)
        hint = _hint(place, here, document)
        return f"{key} is not a known key.{hint} Known here: {', '.join(sorted(here))}."
    if kind in ("union_tag_invalid", "union_tag_not_found"):
        given = value.get("kind") if isinstance(value, Mapping) else None
        known = re.findall(r"'(\w+)'", error["ctx"].get("expected_tags", "")) or DESIGNS
        close = difflib.get_close_matches(str(given), known, 1, 0.4)
        hint = f" Did you mean {close[0]}?" if close else ""
        return f"{key}.kind = {given!r} must be one of {', '.join(sorted(known))}.{hint}"
    if kind == "missing":
        return f"{key} is missing. Add it; `quadfold new` copies a complete job."
    if key == "name":
        return (
            f"name = {value!r} must be 1 to 100 letters, digits, '_', '-' or '.', and begin with a "
            "letter or digit: it names the files in the output folder."
        )
    if kind in ("model_type", "model_attributes_type", "dict_type"):
        return f"{key} = {value!r} must be a table, such as [{key}] with keys below it."
    message = error["msg"].removeprefix("Value error, ")
    if isinstance(value, Mapping | Settings):
        return f"{key}: {message}."
    return f"{key} = {value!r} is refused: {message}."


def _hint(place: Sequence[str], here: Sequence[str], document: Mapping[str, Any]) -> str:
    """The nearest known key, in the same table or else in any other."""
    close = difflib.get_close_matches(place[-1], here, 1, 0.6)
    if close:
        return f" Did you mean {'.'.join([*place[:-1], close[0]])}?"
    elsewhere = {
        key: f"{table}.{key}"
        for table in ("design", "sheet", "perforation", "panels", "hinges")
        for key in _known_keys([table], document)
    }
    close = difflib.get_close_matches(place[-1], elsewhere, 1, 0.8)
    return f" Did you mean {elsewhere[close[0]]}?" if close else ""


def _known_keys(place: Sequence[str], document: Mapping[str, Any]) -> list[str]:
    model: Any = Job
    node: Any = document
    for part in place:
        listed = get_args(model)[0] if get_origin(model) is list else None
        node = _within(node, part)
        model = _table(listed or model.model_fields[part].annotation, node)
    return list(model.model_fields)


def _table(annotation: Any, node: Any) -> Any:
    """The table that an annotation stands for; of a choice, the one that the node's kind names."""
    tables = _choices(annotation)
    if len(tables) == 1:
        return tables[0]
    kind = _kind(node)
    named = (t for t in tables if get_args(t.model_fields["kind"].annotation) == (kind,))
    return next(named, Settings)


def _choices(annotation: Any) -> list[Any]:
    if get_origin(annotation) is Annotated:
        return _choices(get_args(annotation)[0])
    if get_origin(annotation) in (Union, UnionType):
        parts = [part for part in get_args(annotation) if part is not NoneType]
        return [table for part in parts for table in _choices(part)]
    return [annotation]


def _place(loc: Sequence[Any], document: Any) -> list[str]:
    """Where in the document; pydantic names the kind of a table between the table and its key."""
    out = []
    for part in loc:
        if isinstance(document, Mapping) and part not in document and part == _kind(document):
            continue
        out.append(str(part))
        document = _within(document, part)
    return out


def _kind(node: Any) -> Any:
    """The kind that a table names; styles without one are dashes."""
    return node.get("kind", "dashes") if isinstance(node, Mapping) else None


def _within(node: Any, part: Any) -> Any:
    if isinstance(node, Mapping):
        return node.get(part)
    index = int(part) if isinstance(node, list) and str(part).isdigit() else -1
    return node[index] if 0 <= index < len(node) else None
