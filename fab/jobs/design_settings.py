"""Tables of designs in a job: the keys of each are the fields of its dataclass."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from enum import Enum
from pathlib import Path
from types import UnionType
from typing import (
    Annotated,
    Any,
    ClassVar,
    Literal,
    Union,
    get_args,
    get_origin,
    get_type_hints,
)

from pydantic import Field, Strict, create_model

from fab.errors import Finding, InvalidJob, did_you_mean
from fab.files import shortened
from fab.settings import Settings
from solver import DESIGNS
from solver.designs.surface_fit import SURFACES
from solver.errors import InvalidValue
from solver.goals import Goals
from solver.growth import GrowingDesign
from solver.mesh import QuadMesh
from solver.targets.base import Target
from solver.targets.surface_mesh import SurfaceMesh

__all__ = [
    "SEEDS",
    "SHIPPED_DESIGNS",
    "DesignSettings",
    "ParameterSettings",
    "design_key",
    "design_settings",
]

# Meshes that are read as those to relax onto are.
_OTHER_MESHES = (".3mf", ".glb", ".off")


class ParameterSettings(Settings):
    """Base of tables whose keys are the fields of a dataclass.

    Attributes
    ----------
    design_class : the dataclass.
    """

    design_class: ClassVar[type[Any]]

    @classmethod
    def keys(cls) -> dict[str, str]:
        """The key of each field of the dataclass, by the field's name."""
        return {field.name: design_key(field) for field in _fields(cls.design_class)}

    def parameters(self) -> Any:
        """The dataclass with these values, angles in radians."""
        return self.design_class(**self._given())

    def _given(self) -> dict[str, Any]:
        """The value of each field, by its name."""
        given = {}
        for field in _fields(self.design_class):
            value = getattr(self, design_key(field))
            if isinstance(value, tuple) and value and isinstance(value[0], ParameterSettings):
                value = tuple(table.parameters() for table in value)
            elif _is_angle(field) and value is not None:
                value = _each(math.radians, value)
            given[field.name] = value
        return given


class DesignSettings(ParameterSettings):
    """Base of the `design` tables; one for each design.

    Attributes
    ----------
    code : the file of its code, where it is not a shipped one.
    """

    code: ClassVar[str | None] = None

    def design(
        self,
        folder: Path,
        goals: Goals | None = None,
        unit: Callable[[QuadMesh], float] | None = None,
    ) -> tuple[GrowingDesign, tuple[Finding, ...]]:
        """The design with these parameters, angles in radians, and findings of files it reads.

        folder : where files that the job names are looked for. goals, unit : for fields of a
        design whose metadata say that they are given so; the unit is a mm, in units of a sheet.
        Raises `InvalidFile` for files that
        cannot be used.
        """
        given = self._given()
        findings: tuple[Finding, ...] = ()
        for field in _fields(self.design_class):
            value = given[field.name]
            if _is_target(field):
                given[field.name], findings = _target(value, self.model_dump(), folder)
            elif isinstance(value, DesignSettings):
                given[field.name], findings = value.design(folder, goals, unit)
        for field in dataclasses.fields(self.design_class):
            if _given_as(field):
                given[field.name] = {"goals": goals, "unit": unit}[_given_as(field)]
        design: GrowingDesign = self.design_class(**given)
        return design, findings

    def key_of(self, name: str) -> str | None:
        """The key of a field, or of a field of a design in it, as in "seed.columns"; or None."""
        field, _, inner = name.partition(".")
        key = self.keys().get(field)
        within = getattr(self, key, None) if key and inner else None
        if not isinstance(within, DesignSettings):
            return key
        return f"{key}.{within.key_of(inner) or inner}"


def _target(
    surface: str, values: Mapping[str, Any], folder: Path
) -> tuple[str | Target | SurfaceMesh, tuple[Finding, ...]]:
    """A surface by name, or from a file, which has an ending, and findings of the file.

    Sheets are grown on surfaces that are seen from above (`up`), and relaxed onto any other.
    """
    face, up = values["face"], values["up"]
    if Path(surface).suffix:
        if values.get("method", "grow") != "grow" and up is None:
            from fab.surfaces.reading import read_surface_mesh

            clean = read_surface_mesh(folder / surface, face)
            return clean.mesh, clean.findings
        return _seen_from_above(folder / surface, face, up), ()
    if face is not None or up is not None:
        raise InvalidJob(
            f"design.face = {face} and design.up = {up} must be left out for surface = "
            f"{shortened(surface)!r}: only STEP files have faces to choose from, and only meshes a "
            "side."
        )
    if surface not in SURFACES:
        raise InvalidJob(
            f"design.surface = {shortened(surface)!r} must be one of {', '.join(SURFACES)}, or a "
            "file that ends in .stl, .obj, .ply, .off, .3mf, .glb, .step or .stp."
            f"{did_you_mean(surface, SURFACES, 0.4)}"
        )
    return surface, ()


def _seen_from_above(file: Path, face: int | None, up: Sequence[float] | None) -> Target:
    """The surface in a file of any kind, to grow on it."""
    from fab.formats.meshes.surface import read_surface, require_surface

    if file.suffix.lower() not in _OTHER_MESHES:
        return read_surface(file, face, up)
    if face is not None:
        cure = "Faces are chosen in STEP files; a mesh is followed as a whole."
        raise InvalidValue("face", face, "be left out for a mesh", cure)
    from fab.surfaces.mesh_reader import read_triangles
    from solver.targets.mesh import MeshSurface

    coords, faces = read_triangles(file, require_surface(file, _OTHER_MESHES))
    return MeshSurface.from_faces(coords, faces, up=up)


def _fields(cls: type[Any]) -> list[dataclasses.Field[Any]]:
    """Fields that are keys of a job."""
    return [field for field in dataclasses.fields(cls) if field.init and not _given_as(field)]


def _is_angle(field: dataclasses.Field[Any]) -> bool:
    return bool(field.metadata.get("angle"))


def _given_as(field: dataclasses.Field[Any]) -> str:
    """What a job gives to a field that is none of its keys, or nothing."""
    return str(field.metadata.get("given", ""))


def _is_target(field: dataclasses.Field[Any]) -> bool:
    return bool(field.metadata.get("target"))


def _is_design(field: dataclasses.Field[Any]) -> bool:
    return bool(field.metadata.get("design"))


def design_key(field: dataclasses.Field[Any]) -> str:
    """The key of a design's field in a job: angles are in degrees, lengths in mm, named so."""
    if field.metadata.get("length"):
        return f"{field.name}_mm"
    return f"{field.name}_deg" if _is_angle(field) else field.name


def design_settings(kind: str, cls: type[Any], code: str | None = None) -> type[DesignSettings]:
    """The job table of a design: its own fields, with angles in degrees and named so.

    kind : the name that the table goes by; code : the file of the class, where it is not a shipped
    one.
    """
    keys = {"kind": (Literal[kind], ...), **_model_fields(cls)}
    table = create_model(f"{cls.__name__}Settings", __base__=DesignSettings, **keys)
    table.design_class, table.code = cls, code
    return table


def _model_fields(cls: type[Any]) -> dict[str, Any]:
    """Type and default of each key of a table, from the fields of its dataclass."""
    types = get_type_hints(cls)
    keys: dict[str, Any] = {}
    for field in _fields(cls):
        annotation = _annotation(field, types[field.name])
        keys[design_key(field)] = (annotation, _key(field, annotation))
        if _is_target(field):  # a file may hold several surfaces
            face = "number of the face of a STEP file, or several; all of them where left out"
            keys["face"] = (int | list[int] | None, Field(default=None, description=face))
            direction = Annotated[list[float], Field(min_length=3, max_length=3)]
            up = "direction from which a mesh is seen, to grow on it; relaxed where left out"
            keys["up"] = (direction | None, Field(default=None, description=up))
    return keys


def _annotation(field: dataclasses.Field[Any], hint: Any) -> Any:
    """What a job gives for a field: text for surfaces, tables for designs and dataclasses."""
    if _is_target(field):
        return str
    if _is_design(field):
        return Annotated[Union[tuple(SEEDS.values())], Field(discriminator="kind")]  # noqa: UP007
    parts = get_args(hint)
    if get_origin(hint) is tuple and dataclasses.is_dataclass(parts[0]):
        item: Any = parts[0]
        table = create_model(
            f"{item.__name__}Settings", __base__=ParameterSettings, **_model_fields(item)
        )
        table.design_class = item
        return tuple[table, ...]
    if get_origin(hint) in (Union, UnionType):  # a list among them is loose, as in `_key`
        loose = [Annotated[part, Strict(False)] if get_args(part) else part for part in parts]
        return Union[tuple(loose)]  # noqa: UP007
    return hint


def _key(field: dataclasses.Field[Any], annotation: Any) -> Any:
    """Default of a field's key, in degrees for angles; tuples and enums are lists and text."""
    loose = get_origin(annotation) is tuple or (
        isinstance(annotation, type) and issubclass(annotation, tuple | Enum)
    )
    strict = False if loose else None
    if field.default_factory is not dataclasses.MISSING:
        if _is_design(field):
            design = field.default_factory()
            return Field(default_factory=lambda: _table_of(design))
        return Field(default_factory=field.default_factory, strict=strict)
    default: Any = field.default
    if default is dataclasses.MISSING:
        return Field(strict=strict)
    if _is_angle(field) and default is not None:
        default = _each(lambda angle: round(math.degrees(angle), 10), default)
    return Field(default=default, strict=strict)


def _table_of(design: Any) -> dict[str, Any]:
    """The keys of a shipped design that are not as by default, in a job's units."""
    (kind,) = [kind for kind, cls in DESIGNS.items() if cls is type(design)]
    table: dict[str, Any] = {"kind": kind}
    for field in _fields(type(design)):
        value = getattr(design, field.name)
        if value != field.default:
            table[design_key(field)] = _each(math.degrees, value) if _is_angle(field) else value
    return table


def _each(convert: Callable[[float], float], value: Any) -> Any:
    """An angle converted, or each of several."""
    if isinstance(value, tuple | list):
        return tuple(convert(angle) for angle in value)
    return convert(value)


# Designs that sheets of others may begin with.
SEEDS = {
    kind: design_settings(kind, cls)
    for kind, cls in DESIGNS.items()
    if not any(map(_is_design, dataclasses.fields(cls)))
}
SHIPPED_DESIGNS = {
    kind: SEEDS.get(kind) or design_settings(kind, cls) for kind, cls in DESIGNS.items()
}
