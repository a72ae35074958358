"""JSON schema of the report of a job: where its figures are, of which type, and what they mean.

Built from the columns of tables of sweeps, so that both say the same of a figure. Reports have
more than these: lists of findings, of outputs, of states.
"""

from __future__ import annotations

from typing import Any

from fab.sweeps.columns import FIGURES, Column

__all__ = ["report_schema"]

_TYPES = {"text": "string", "whole": "integer", "number": "number", "truth": "boolean"}
_FINDING = {
    "type": "object",
    "required": ["code", "severity", "text"],
    "properties": {
        "code": {"type": "string", "description": "stable name of the kind of finding"},
        "severity": {"enum": ["note", "warning", "error"]},
        "text": {"type": "string", "description": "what, where, how much, and what helps"},
    },
}
_OUTPUT = {
    "type": "object",
    "required": ["file", "bytes", "sha256"],
    "properties": {
        "file": {"type": "string"},
        "bytes": {"type": "integer", "minimum": 0},
        "sha256": {"type": "string", "pattern": "^[0-9a-f]{64}$"},
    },
}


def report_schema() -> dict[str, Any]:
    """The schema, of draft 2020-12, as JSON values.

    >>> report_schema()["properties"]["crossings"]["type"]
    ['integer', 'null']
    """
    root: dict[str, Any] = {"properties": {}}
    for column in FIGURES:
        _add(root, column)
    root["properties"]["findings"] = {"type": "array", "items": _FINDING}
    root["properties"]["outputs"] = {"type": "array", "items": _OUTPUT}
    root["properties"]["quadfold"] = {"type": "string", "description": "version"}
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Report of quadfold run",
        "type": "object",
        "required": ["quadfold", "job", "counts", "findings", "outputs"],
        **root,
    }


def _add(root: dict[str, Any], column: Column) -> None:
    """Add what a column says at its path. Tables and lists may be null where there is none."""
    place = root
    for key in column.path:
        if key == "#":
            place.setdefault("type", ["array", "null"])
            return
        if isinstance(key, int) or key == "+":
            place.setdefault("type", ["array", "null"])
            place = place.setdefault("items", {})
        else:
            place.setdefault("type", ["object", "null"])
            place = place.setdefault("properties", {}).setdefault(key, {})
    place["type"] = [_TYPES[column.kind], "null"]
    place["description"] = f"{column.text} (column {column.name})"
