"""The form of a job: a field for each key with one value, from the models that check them."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from enum import Enum
from types import NoneType
from typing import Any, Literal, get_args, get_origin

from pydantic.fields import FieldInfo

from fab.jobs.design_settings import DesignSettings, ParameterSettings
from fab.jobs.job import Job
from fab.settings import Settings, alternatives
from fab.studio.stock import Kind, names_of
from solver.designs.surface_fit import SURFACES

__all__ = ["FormField", "documented", "form_fields"]

# Units by the ends of keys.
_UNITS = {
    "_mm_per_unit": "mm per unit",
    "_mm_s": "mm/s",
    "_mm": "mm",
    "_deg": "°",
    "_rad": "rad",
}
# Texts that name what there is in stock.
_STOCK: Mapping[tuple[str, ...], Kind] = {
    ("printer", "machine"): "printer",
    ("printer", "material"): "print",
    ("printer", "panel_material"): "print",
    ("printer", "hinge_material"): "print",
}
_BOUNDS = {"gt": "min", "ge": "min", "lt": "max", "le": "max"}


@dataclass(frozen=True)
class FormField:
    """A key of a job, and what may be given to it.

    Attributes
    ----------
    path : the tables that it is in, and the key itself.
    kind : "number", "integer", "boolean", "choice" or "text".
    text : what it is; unit : of a number, empty where it has none.
    default : where the key is left out; None where that is a state of its own.
    choices : of a choice, or offered for a text. low, high : bounds of a number, where it has some.
    """

    path: tuple[str, ...]
    kind: str
    text: str
    unit: str
    default: Any
    choices: tuple[str, ...] = ()
    low: float | None = None
    high: float | None = None


def form_fields(job: Job) -> tuple[FormField, ...]:
    """A field for each key of a job that has one value, those of its design first.

    Lists, and tables of which there are several kinds, have no field: they are changed in the text.

    >>> from fab.jobs.job import parse_job
    >>> job = parse_job({"name": "m", "design": {"kind": "miura"}, "sheet": {"width_mm": 90.0}})
    >>> fields = {".".join(field.path): field for field in form_fields(job)}
    >>> fields["design.fold_deg"].default, fields["design.fold_deg"].unit
    (45.0, '°')
    """
    return tuple(
        replace(field, choices=names_of(_STOCK[field.path], job.folder))
        if field.path in _STOCK
        else field
        for field in (*_of_design(job.design, ("design",)), *_of_table(type(job), ()))
    )


def _of_design(design: DesignSettings, path: tuple[str, ...]) -> Iterator[FormField]:
    """Those of a design, and of designs within it, such as its seed."""
    yield from _of_table(type(design), path)
    for key, value in design:
        if isinstance(value, DesignSettings):
            yield from _of_design(value, (*path, key))


def _of_table(table: type[Settings], above: tuple[str, ...]) -> Iterator[FormField]:
    texts = documented(table)
    for key, info in table.model_fields.items():
        path = (*above, key)
        if path == ("design",) or (above[:1] == ("design",) and key == "kind"):
            continue
        choices = alternatives(info.annotation)
        inner = choices[0] if len(choices) == 1 else None
        if isinstance(inner, type) and issubclass(inner, Settings):
            if NoneType not in get_args(info.annotation):
                yield from _of_table(inner, path)
            continue
        kind = _kind(choices)
        if kind:
            text = info.description or texts.get(key, "")
            yield _field(path, info, kind, _names(choices), text)


def _field(
    path: tuple[str, ...], info: FieldInfo, kind: str, names: tuple[str, ...], text: str
) -> FormField:
    default = None if info.is_required() else info.get_default(call_default_factory=True)
    suggested = tuple(SURFACES) if path == ("design", "surface") else ()
    if isinstance(default, Enum):
        default = default.value
    unit = next((unit for end, unit in _UNITS.items() if path[-1].endswith(end)), "")
    bounds = _bounds(info)
    return FormField(
        path,
        kind,
        text,
        unit,
        default,
        names or suggested,
        low=bounds.get("min"),
        high=bounds.get("max"),
    )


def _kind(choices: list[Any]) -> str:
    """What an annotation takes; nothing where it is no single value."""
    if len(choices) != 1:
        return ""
    (only,) = choices
    if _names(choices):
        return "choice"
    return {bool: "boolean", int: "integer", float: "number", str: "text"}.get(only, "")


def _names(choices: list[Any]) -> tuple[str, ...]:
    """The names among which an annotation is a choice."""
    (only, *others) = choices
    if others:
        return ()
    if get_origin(only) is Literal:
        return tuple(str(name) for name in get_args(only))
    if isinstance(only, type) and issubclass(only, Enum):
        return tuple(str(each.value) for each in only)
    return ()


def _bounds(info: FieldInfo) -> dict[str, float]:
    return {
        end: float(getattr(limit, name))
        for limit in info.metadata
        for name, end in _BOUNDS.items()
        if hasattr(limit, name)
    }


def documented(table: type[Settings]) -> Mapping[str, str]:
    """What the docstring of a design, or of a part of one, says of its fields, by their keys."""
    if not issubclass(table, ParameterSettings):
        return {}
    keys = table.keys()
    _, _, listed = (inspect.getdoc(table.design_class) or "").partition("Attributes\n----------\n")
    texts: dict[str, str] = {}
    for names, text in _entries(listed):
        if not text.startswith("see `"):
            texts |= {keys[name]: text for name in names if name in keys}
    return texts


def _entries(listed: str) -> Iterator[tuple[list[str], str]]:
    """Names and texts of a list such as "columns, rows : number of quads."."""
    starts = list(re.finditer(r"(?:^|[;.] |\n)\s*(\w+(?:, \w+)*) : ", listed))
    ends = [start.start() for start in starts[1:]] + [len(listed)]
    for start, end in zip(starts, ends, strict=True):
        text = listed[start.end() : end].partition("\n\n")[0]
        plain = " ".join(text.split()).rstrip(".;").replace(", radians", "")  # here in degrees
        yield start.group(1).split(", "), plain
