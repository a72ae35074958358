"""Pages of keys, from the models that check them: types, units, bounds, defaults, meanings."""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from enum import Enum
from types import NoneType
from typing import Annotated, Any, Literal, get_args, get_origin

from pydantic.fields import FieldInfo

from fab.jobs.design_settings import SHIPPED_DESIGNS, ParameterSettings
from fab.jobs.job import Job
from fab.printing.printers import Printer, PrintMaterial
from fab.settings import Settings, alternatives
from fab.sheets.materials import Machine, Material
from fab.studio.form_fields import documented
from fab.sweeps.sweep_settings import Sweep
from made_pages.markdown import anchor, cell, docstring, table

__all__ = ["keys_pages", "missing_texts", "units_of"]

_HEAD = ("key", "meaning", "value", "default")
# Units by the ends of keys, the longer ends first.
_UNITS = {
    "_mm_per_unit": "mm per unit",
    "_kg_m3": "kg/m³",
    "_mm_s": "mm/s",
    "_n_mm": "N/mm",
    "_mpa": "MPa",
    "_percent": "%",
    "_deg": "°",
    "_rad": "rad",
    "_mm": "mm",
    "_mb": "MB",
    "_pa": "Pa",
    "_s": "s",
    "_n": "N",
    "seconds": "s",
}
_BOUNDS = {"gt": "> {}", "ge": "≥ {}", "lt": "< {}", "le": "≤ {}"}
_JOB = (
    "A job is a TOML file of these tables; [the guide](../guide/jobs.md) has a complete one. "
    "`name`, "
    "`design.kind` and a size of the `sheet` are needed, everything else has a default. Unknown "
    "keys "
    "are refused, with the nearest known one. `--set design.rows=12` changes a key for one run, "
    "and "
    "[a sweep](sweep_keys.md) varies any of them."
)


def keys_pages() -> dict[str, str]:
    """The pages by the names of their files."""
    return {
        "job_keys.md": _page("Keys of a job", _JOB, [("", Job)]),
        "design_keys.md": _designs(),
        "material_keys.md": _page(
            "Keys of materials",
            "A material is a TOML file: copy [a shipped one](materials.md) and give its path in "
            "place "
            "of the name.",
            [("Sheets to cut", Material), ("Print materials", PrintMaterial)],
        ),
        "machine_keys.md": _page(
            "Keys of machines and printers",
            "A machine is a TOML file: copy [a shipped one](machines.md) and give its path in "
            "place of "
            "the name.",
            [("Cutters and plotters", Machine), ("3D printers", Printer)],
        ),
        "sweep_keys.md": _page(
            "Keys of a sweep",
            "A sweep is a TOML file beside its base job; [the guide](../guide/sweeps.md) has a "
            "complete "
            "one.",
            [("", Sweep)],
        ),
    }


def missing_texts() -> list[str]:
    """Keys of all pages that say nothing of themselves."""
    models: list[tuple[str, type[Settings]]] = [
        *((f"design.{kind}", model) for kind, model in SHIPPED_DESIGNS.items()),
        *(
            (each.__name__, each)
            for each in (Job, Material, PrintMaterial, Machine, Printer, Sweep)
        ),
    ]
    return [
        f"{name}: {key}"
        for name, model in models
        for path, inner in _tables(model, ())
        for key, (info, text) in _fields(inner).items()
        if not text and key != "kind" and not _inner_tables(info)
        for key in [".".join([*path, key])]
    ]


def units_of(key: str) -> str:
    """The unit that the end of a key names.

    >>> units_of("thickness_mm"), units_of("columns")
    ('mm', '')
    """
    return next((unit for end, unit in _UNITS.items() if key.endswith(end)), "")


def _page(title: str, about: str, models: list[tuple[str, type[Settings]]]) -> str:
    out = [f"# {title}\n", about + "\n"]
    for heading, model in models:
        level = "###" if heading else "##"
        if heading:
            out += [f"## {heading}\n", docstring(inspect.getdoc(model) or "") + "\n"]
        for path, inner in _tables(model, ()):
            if path:
                name = ".".join(path)
                out.append(f"{level} [{name}]\n".replace("[", "\\["))
                out.append(docstring(_own_text(inner)) + "\n")
            fields = sorted(_fields(inner).items(), key=_what_is_needed_first)
            rows = [_row(key, info, text) for key, (info, text) in fields]
            out.append(table(_HEAD, rows))
    return "\n".join(out)


def _designs() -> str:
    out = [
        "# Keys of designs\n",
        "The table `[design]` of a job: `kind` is the name of a design, the others are its own "
        "keys. "
        "[The guide](../guide/jobs.md) says what each design is for.\n",
    ]
    for kind, model in SHIPPED_DESIGNS.items():
        assert issubclass(model, ParameterSettings)
        text = (inspect.getdoc(model.design_class) or "").partition("Attributes\n---")[0]
        out += [anchor(f"design-{kind}") + f"## {kind}\n", docstring(text) + "\n"]
        fields = _fields(model)
        rows = [_row(key, info, said) for key, (info, said) in fields.items() if key != "kind"]
        out.append(table(_HEAD, rows))
        for path, inner in _tables(model, ()):
            if path:
                out.append(f"### {kind}: \\[{'.'.join(path)}]\n")
                rows = [_row(key, info, said) for key, (info, said) in _fields(inner).items()]
                out.append(table(_HEAD, rows))
    return "\n".join(out)


def _tables(model: type[Settings], path: tuple[str, ...]) -> Iterator[tuple[tuple[str, ...], Any]]:
    """A table, and those within it; of a choice each. A design has a page of its own."""
    yield path, model
    for key, info in model.model_fields.items():
        if key == "design" or key in path:
            continue
        inner = _inner_tables(info)
        if len(inner) > 5:  # designs within designs
            continue
        for each in inner:
            name = f"{key}: {_kind_of(each)}" if len(inner) > 1 else key
            yield from _tables(each, (*path, name))


def _inner_tables(info: FieldInfo) -> list[type[Settings]]:
    found = []
    for each in alternatives(info.annotation):
        each = _item(each)
        for inner in alternatives(each):
            if isinstance(inner, type) and issubclass(inner, Settings) and inner not in found:
                found.append(inner)
    return found


def _item(annotation: Any) -> Any:
    """What a list is of; of anything else the annotation itself."""
    if get_origin(annotation) is list or (
        get_origin(annotation) is tuple and get_args(annotation)[-1:] == (Ellipsis,)
    ):
        return get_args(annotation)[0]
    return annotation


def _kind_of(model: type[Settings]) -> str:
    info = model.model_fields.get("kind")
    return str(get_args(info.annotation)[0]) if info is not None else model.__name__


def _fields(model: type[Settings]) -> dict[str, tuple[FieldInfo, str]]:
    """Fields of a table and their meanings."""
    texts = documented(model)
    out = {}
    for key, info in model.model_fields.items():
        text = info.description or texts.get(key, "")
        if not text:
            inner = _inner_tables(info)
            text = _own_text(inner[0]).partition("\n")[0] if len(inner) == 1 else text
        out[key] = (info, text)
    return out


def _what_is_needed_first(field: tuple[str, tuple[FieldInfo, str]]) -> tuple[bool, bool]:
    """An order: needed keys, keys with values, tables."""
    info = field[1][0]
    return not info.is_required(), bool(_inner_tables(info))


def _own_text(model: type[Settings]) -> str:
    own = vars(model).get("__doc__")
    return inspect.cleandoc(own).partition("Attributes\n---")[0] if own else ""


def _row(key: str, info: FieldInfo, text: str) -> list[str]:
    return [
        f"`{key}`",
        cell(text),
        ", ".join(
            part for part in (_value(info.annotation), units_of(key), *_bounds(info)) if part
        ),
        _default(info),
    ]


def _value(annotation: Any) -> str:
    """What may be given, in words."""
    words = []
    for each in alternatives(annotation):
        origin = get_origin(each)
        if origin is Literal:
            words += [f"`{name}`" for name in get_args(each)]
        elif isinstance(each, type) and issubclass(each, Enum):
            words += [f"`{name.value}`" for name in each]
        elif isinstance(each, type) and issubclass(each, Settings):
            words.append("table")
        elif origin is list or (origin is tuple and get_args(each)[-1] is Ellipsis):
            words.append(f"list of {_value(get_args(each)[0])}")
        elif origin is tuple:
            words.append(f"{len(get_args(each))} x {_value(get_args(each)[0])}")
        elif origin is dict or each is dict:
            words.append("table")
        else:
            words.append(
                {bool: "true, false", int: "whole number", float: "number", str: "text"}.get(
                    each, "any"
                )
            )
    return ", ".join(dict.fromkeys(words))


def _bounds(info: FieldInfo) -> list[str]:
    """The bounds of a number, or of each of a list."""
    metadata = list(info.metadata)
    for each in alternatives(info.annotation):
        for inner in get_args(each) if get_origin(each) in (list, tuple) else ():
            if get_origin(inner) is Annotated:
                metadata += [
                    m for part in get_args(inner)[1:] for m in getattr(part, "metadata", [part])
                ]
    found = [
        text.format(f"{getattr(limit, name):g}")
        for limit in metadata
        for name, text in _BOUNDS.items()
        if getattr(limit, name, None) is not None
    ]
    return list(dict.fromkeys(found))


def _default(info: FieldInfo) -> str:
    if info.is_required():
        return "**needed**"
    value = info.get_default(call_default_factory=True)
    if value is None or isinstance(value, Settings):
        return ""
    if isinstance(value, tuple | list) and any(isinstance(each, Settings) for each in value):
        return ""
    return f"`{_toml(value)}`"


def _toml(value: Any) -> str:
    if isinstance(value, Enum):
        value = value.value
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(_toml, value)) + "]"
    if isinstance(value, float):
        return f"{value:.10g}" if value % 1 or abs(value) >= 1e6 else f"{value:.1f}"
    return "" if value is NoneType else str(value)
