"""Tables that users write: how they are read and checked, and how their faults are named."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, TypeVar, Union, get_args, get_origin

import numpy as np
from pydantic import BaseModel, ConfigDict, ValidationError
from pydantic.fields import FieldInfo

from fab.errors import InvalidJob, counted, did_you_mean, nearest
from fab.files import require_file, shortened

__all__ = [
    "DEEPEST",
    "LARGEST_BYTES",
    "Settings",
    "alternatives",
    "apply_change",
    "checked",
    "parsed_toml",
    "plain",
    "read_toml",
    "toml_of",
    "types_of",
]

# Files that users write are a few kilobytes long, with tables in tables in tables.
LARGEST_BYTES = 1_000_000
DEEPEST = 50
# Whole numbers of more bits have over 4000 digits, which Python reads as 0x... and does not write.
_MOST_BITS = 13_000
_LONGEST_SHOWN = 80
# Keys at fault that an error lists.
_MOST_LISTED = 50
# A part of a key that is the place of an element of a list.
_PLACE = re.compile(r"[0-9]{1,18}")

# What a number must be, and what other values must, by pydantic's name of the error.
_NUMBERS = {
    "finite_number": "a finite number",
    "float_type": "a number",
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "greater_than": "",
    "greater_than_equal": "",
    "less_than": "",
    "less_than_equal": "",
}
_BOUNDS = {"gt": "greater than", "ge": "at least", "lt": "less than", "le": "at most"}
_OTHERS = {
    "bool_type": "be true or false",
    "string_type": "be text in quotes",
    "string_too_short": "not be empty",
    "list_type": 'be a list, such as [1.0, 2.0] or ["A", "B"]',
    "tuple_type": "be a list, such as [1.0, 2.0]",
    "literal_error": "be {expected}",
    "enum": "be {expected}",
    "too_short": "have {min_length} values or more",
    "too_long": "have {max_length} values or fewer",
}


class Settings(BaseModel):
    """Base of all tables that users write.

    Read-only, no unknown keys, no NaN, no text for numbers.
    """

    model_config = ConfigDict(
        frozen=True, extra="forbid", allow_inf_nan=False, strict=True, validate_default=True
    )


Table = TypeVar("Table", bound=Settings)


def read_toml(path: Path, cure: str) -> dict[str, Any]:
    """The tables of a TOML file. Raises `InvalidJob`, with `cure` where there is no such file."""
    size = require_file(path, InvalidJob, cure)
    if size > LARGEST_BYTES:
        raise InvalidJob(f"{path}: has {size} bytes, must have at most {LARGEST_BYTES}. {cure}")
    try:
        text = path.read_bytes()
    except OSError as error:
        raise InvalidJob(f"{path}: cannot be read: {error.strerror}. {cure}") from error
    return parsed_toml(text, str(path), cure)


def parsed_toml(text: bytes, source: str, cure: str) -> dict[str, Any]:
    """The tables of TOML that is read. Raises `InvalidJob`, which begins with `source`."""
    if len(text) > LARGEST_BYTES:
        raise InvalidJob(
            f"{source}: has more than {LARGEST_BYTES} bytes, must have at most as many. {cure}"
        )
    try:
        document = toml_of(text.decode("utf-8-sig"))
    except (ValueError, RecursionError) as error:
        raise InvalidJob(f"{source}: not a TOML file: {error}. Correct it there.") from error
    if _is_deeper(document, DEEPEST):
        raise InvalidJob(
            f"{source}: has tables or lists over {DEEPEST} deep, must have at most as many in each "
            f"other. {cure}"
        )
    return document


def toml_of(text: str) -> dict[str, Any]:
    """The tables of TOML. Raises `ValueError` or `RecursionError` where it is none.

    And for whole numbers that are too long for a message that names them.
    """
    document = tomllib.loads(text)
    level: list[Any] = [document]
    while level:
        parts = [p for each in level for p in (each.values() if isinstance(each, dict) else each)]
        if any(isinstance(part, int) and part.bit_length() > _MOST_BITS for part in parts):
            raise ValueError("a whole number has thousands of digits")
        level = [part for part in parts if isinstance(part, dict | list)]
    return document


def _is_deeper(node: Any, depth: int) -> bool:
    """Whether tables and lists are more than `depth` deep in each other."""
    level = [node]
    for _ in range(depth):
        inner = (each.values() if isinstance(each, dict) else each for each in level)
        level = [each for parts in inner for each in parts if isinstance(each, dict | list)]
        if not level:
            return False
    return True


def apply_change(document: dict[str, Any], change: str) -> None:
    """Lay a change such as "panels.thickness_mm=1.2" over nested tables. Raises `InvalidJob`."""
    key, equals, text = change.partition("=")
    parts = [part.strip() for part in key.split(".")]
    if not equals or not all(parts):
        raise InvalidJob(f"--set {change}: must have the form key=value, as in design.strips=4.")
    try:
        parsed = toml_of(f"value = {text}")
        value = parsed["value"] if len(parsed) == 1 and not _is_deeper(parsed, DEEPEST) else text
    except (ValueError, RecursionError):  # also of whole numbers with thousands of digits
        value = text.strip()
    table = document
    for part in parts[:-1]:
        table = table.setdefault(part, {})
        if not isinstance(table, dict):
            raise InvalidJob(f"--set {change}: {part} is a value, not a table.")
    table[parts[-1]] = value


def plain(value: Any, depth: int = DEEPEST) -> Any:
    """A value whose numbers and arrays of numpy, also in tables and lists, are Python's own.

    >>> import numpy as np
    >>> plain({"rows": np.int64(4), "widths": (np.array([1.5, 2.0]),)})
    {'rows': 4, 'widths': ([1.5, 2.0],)}
    """
    if isinstance(value, Mapping) and depth:
        return {key: plain(each, depth - 1) for key, each in value.items()}
    if type(value) in (list, tuple) and depth:
        return type(value)(plain(each, depth - 1) for each in value)
    return value.tolist() if isinstance(value, np.generic | np.ndarray) else value


def checked(model: type[Table], document: Mapping[str, Any], source: str, cure: str) -> Table:
    """The document as settings. Raises `InvalidJob` with all keys at fault.

    source : begins the message, such as the file's path; cure : where keys are missing.
    """
    document = plain(document)
    try:
        return model.model_validate(document)
    except ValidationError as error:
        found: dict[tuple[str, ...], list[Any]] = {}
        for each in error.errors(include_url=False):
            found.setdefault(tuple(_place(each["loc"], document)), []).append(each)
        # of the choices that a value has, what is said of its parts says more than of all of it
        whole = [place for place in found if any(p[: len(place)] == place != p for p in found)]
        lines = [
            _refusal(place, errors, model, document, cure)
            for place, errors in found.items()
            if place not in whole or errors[0]["type"] not in _NUMBERS | _OTHERS
        ]
        if len(lines) > _MOST_LISTED:
            more = len(lines) - _MOST_LISTED
            lines[_MOST_LISTED:] = [f"{counted(more, 'other key is', 'other keys are')} at fault."]
        raise InvalidJob(f"{source}: " + "\n".join(lines)) from error


def _refusal(
    place: Sequence[str],
    errors: Sequence[Any],
    model: type[Settings],
    document: Any,
    cure: str,
) -> str:
    """An error of pydantic's in the project's words: key, value, bound and cure.

    errors : one, or one for each of the choices that the value has.
    """
    error = errors[0]
    key = ".".join(map(shortened, place))
    kind, value = error["type"], error.get("input")
    field, annotation = _field(model, place, document)
    if kind == "extra_forbidden":
        known = _known_keys(model, place[:-1], document)
        hint = _hint(model, place, known, document)
        return f"{key} is not a known key.{hint} Known here: {', '.join(sorted(known))}."
    if kind in ("union_tag_invalid", "union_tag_not_found"):
        given = value.get("kind") if isinstance(value, Mapping) else None
        known = [name for table in alternatives(annotation) for name in _kinds(table)]
        must = f"must be one of {', '.join(sorted(known))}{_about(field)}"
        return f"{key}.kind = {_shown(given)} {must}.{did_you_mean(given, known, 0.4)}"
    if kind == "missing" and place[-1].isdigit():
        return f"{'.'.join(place[:-1])} has too few values. Give all of them."
    if kind == "missing":
        return f"{key} is missing. Add it{_about(field)}. {cure}"
    if kind in ("model_type", "model_attributes_type", "dict_type"):
        if not key:
            return f"{_shown(value)} must be a table of keys. {cure}"
        return f"{key} = {_shown(value)} must be a table, such as [{key}] with keys below it."
    given = f"{key} = {_shown(value)}"
    if kind == "value_error":
        fault = error["msg"].removeprefix("Value error, ")
        fault += "" if fault.endswith(("?", ".")) else "."
        whole = isinstance(value, Mapping | Settings)
        return f"{key if whole else given}: {fault}" if key else fault
    if kind == "string_pattern_mismatch":
        return f"{given} is out of bounds. Correct it{_about(field)}."
    musts = [_must(each, _bound(field)) for each in errors]
    fault = error["msg"] if None in musts else f"it must {' or '.join(map(str, musts))}"
    return f"{given} is out of bounds: {fault}. Correct it{_about(field)}."


def _must(error: Any, bound: str) -> str | None:
    """What the value must be or have; None for errors that are not of numbers and the like."""
    kind = error["type"]
    bound = bound or _broken(error.get("ctx", {}))
    if kind in _NUMBERS and (_NUMBERS[kind] or bound):
        return "be " + ", ".join(part for part in (_NUMBERS[kind], bound) if part)
    if kind in _OTHERS:
        return _OTHERS[kind].format(**error.get("ctx", {}))
    return None


def _shown(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= _LONGEST_SHOWN else f"{text[: _LONGEST_SHOWN - 3]}..."


def _about(field: FieldInfo | None) -> str:
    return f" ({field.description})" if field is not None and field.description else ""


def _bound(field: FieldInfo | None) -> str:
    """The bounds of a number in words, all of them."""
    parts = [
        f"{word} {getattr(limit, name):g}"
        for limit in (field.metadata if field is not None else [])
        for name, word in _BOUNDS.items()
        if hasattr(limit, name)
    ]
    return " and ".join(parts)


def _broken(context: Mapping[str, Any]) -> str:
    """The bound that a number is beyond, in words: of a kind of number that is part of a type."""
    return " and ".join(
        f"{word} {context[name]:g}" for name, word in _BOUNDS.items() if name in context
    )


def _hint(model: type[Settings], place: Sequence[str], same: Sequence[str], document: Any) -> str:
    """The nearest known key: of the same table, or else of any others."""
    *above, key = place
    close = nearest(key, same)
    if close:
        return f" Did you mean {'.'.join([*above, close])}?"
    elsewhere: dict[str, list[str]] = {}
    for table in model.model_fields:
        for inner in _known_keys(model, [table], document):
            elsewhere.setdefault(inner, []).append(f"{table}.{inner}")
    close = nearest(key, elsewhere, 0.8)
    return f" Did you mean {' or '.join(elsewhere[close])}?" if close else ""


def _known_keys(model: type[Settings], place: Sequence[str], document: Any) -> list[str]:
    _, annotation = _field(model, place, document)
    node = document
    for part in place:
        node = _within(node, part)
    return list(_fields(_table(annotation, node)))


def _fields(table: Any) -> dict[str, FieldInfo]:
    """The fields of a table by their keys, which are their names unless an alias is."""
    fields: Mapping[str, FieldInfo] = getattr(table, "model_fields", {})
    return {field.alias or name: field for name, field in fields.items()}


def types_of(model: type[Settings], key: str, document: Any) -> list[Any]:
    """The types that a key such as "design.rows" takes; none where it is no key of the model.

    document : tables of the model, whose kinds say which keys they have.
    """
    field, annotation = _field(model, key.split("."), document)
    return [] if field is None else alternatives(annotation)


def _field(
    model: type[Settings], place: Sequence[str], document: Any
) -> tuple[FieldInfo | None, Any]:
    """The field at a place and its type; within a list the item, with its bounds if it has any."""
    field: FieldInfo | None = None
    annotation: Any = model
    node = document
    for part in place:
        table = _table(annotation, node)
        if get_origin(table) in (list, tuple):
            annotation = get_args(table)[0]
            bounded = get_origin(annotation) is Annotated
            field = FieldInfo.from_annotation(annotation) if bounded else None
        else:
            field = _fields(table).get(part)
            annotation = field.annotation if field is not None else Settings
        node = _within(node, part)
    return field, annotation


def _table(annotation: Any, node: Any) -> Any:
    """The table that an annotation means; of a choice, the one that the node's kind names."""
    tables = alternatives(annotation)
    if len(tables) == 1:
        return tables[0]
    return next((table for table in tables if _kind(node) in _kinds(table)), Settings)


def alternatives(annotation: Any) -> list[Any]:
    """What an annotation allows, without None."""
    if get_origin(annotation) is Annotated:
        return alternatives(get_args(annotation)[0])
    if get_origin(annotation) in (Union, UnionType):
        parts = [part for part in get_args(annotation) if part is not NoneType]
        return [table for part in parts for table in alternatives(part)]
    return [annotation]


def _kinds(table: Any) -> tuple[str, ...]:
    """The name that a table of a choice goes by in its key `kind`."""
    fields = getattr(table, "model_fields", {})
    return get_args(fields["kind"].annotation) if "kind" in fields else ()


def _place(loc: Sequence[Any], document: Any) -> list[str]:
    """Where in the document.

    Between a table and its key pydantic names the kind of the table, and after a value that may be
    of several types, the type.
    """
    place: list[str] = []
    for part in loc:
        if place and isinstance(part, str) and not isinstance(document, Mapping):
            continue
        if isinstance(document, Mapping) and part not in document and part == _kind(document):
            continue
        place.append(str(part))
        document = _within(document, part)
    return place


def _kind(node: Any) -> Any:
    """The kind that a table names; styles without one are dashes."""
    return node.get("kind", "dashes") if isinstance(node, Mapping) else None


def _within(node: Any, part: Any) -> Any:
    if isinstance(node, Mapping):
        return node.get(part)
    index = int(part) if isinstance(node, list) and _PLACE.fullmatch(str(part)) else -1
    return node[index] if 0 <= index < len(node) else None
