"""Numbers of a report as HTML tables, with units out of their keys and a few digits."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from html import escape
from typing import Any

__all__ = ["label_of", "mapping_table", "rows_table", "shown"]

_UNITS = {
    "mm": "mm",
    "mm2": "mm²",
    "mm3": "mm³",
    "mm_s": "mm/s",
    "deg": "°",
    "rad": "rad",
    "g": "g",
    "n": "N",
    "nm": "N m",
    "mpa": "MPa",
    "pa": "Pa",
    "s": "s",
    "kg_m3": "kg/m³",
    "rel": "relative",
}
_DIGITS = 5
# Of longer lists the first entries are shown.
_LISTED = 12


def label_of(key: str) -> str:
    """A key of a report in words, with its unit.

    >>> label_of("overlap_max_mm3"), label_of("fold_angle_deg"), label_of("crossings")
    ('overlap max, mm³', 'fold angle, °', 'crossings')
    """
    for ending, unit in _UNITS.items():
        if key.endswith(f"_{ending}"):
            return f"{key.removesuffix(f'_{ending}').replace('_', ' ')}, {unit}"
    return key.replace("_", " ")


def shown(value: Any) -> str:
    """A value of a report as text.

    >>> shown(3.14159265), shown([200.0, 196.299092]), shown(None), shown(True), shown(1.5e-16)
    ('3.1416', '200 x 196.3', '-', 'yes', '1.5e-16')
    """
    if value is None or value == "":
        return "-"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.{_DIGITS}g}" if math.isfinite(value) else str(value)
    if isinstance(value, Sequence) and not isinstance(value, str):
        sides = len(value) in (2, 3) and all(isinstance(each, float) for each in value)
        listed = [shown(each) for each in value[:_LISTED]]
        more = f" … ({len(value)} in all)" if len(value) > _LISTED else ""
        return (" x " if sides else ", ").join(listed) + more or "-"
    return str(value)


def mapping_table(caption: str, values: Mapping[str, Any]) -> str:
    """A table of two columns; nested mappings are rows of their own, lists of mappings tables."""
    rows = [
        f'<tr><th scope="row">{escape(label)}</th><td>{escape(shown(value))}</td></tr>'
        for label, value in _flat(values)
    ]
    table = _table(caption, f"<tbody>{''.join(rows)}</tbody>") if rows else ""
    lists = [
        rows_table(f"{caption}: {label_of(key)}", value)
        for key, value in values.items()
        if _is_list_of_mappings(value)
    ]
    return table + "".join(lists)


def rows_table(caption: str, rows: Sequence[Mapping[str, Any]]) -> str:
    """A table with a row for each mapping, all of which have the same keys."""
    keys = list(dict.fromkeys(key for row in rows for key in row if not _is_nested(row[key])))
    head = "".join(f'<th scope="col">{escape(label_of(key))}</th>' for key in keys)
    body = "".join(
        "<tr>" + "".join(f"<td>{escape(shown(row.get(key)))}</td>" for key in keys) + "</tr>"
        for row in rows
    )
    return _table(caption, f'<thead><tr>{head}</tr></thead><tbody class="rows">{body}</tbody>')


def _table(caption: str, inner: str) -> str:
    # wide tables are scrolled with the keyboard too
    return (
        f'<div class="wide" tabindex="0" role="group" aria-label="{escape(caption)}"><table>'
        f"<caption>{escape(caption)}</caption>{inner}</table></div>"
    )


def _flat(values: Mapping[str, Any], before: str = "") -> Iterator[tuple[str, Any]]:
    for key, value in values.items():
        label = before + label_of(key)
        if isinstance(value, Mapping):
            yield from _flat(value, f"{label}: ")
        elif not _is_list_of_mappings(value):
            yield label, value


def _is_list_of_mappings(value: Any) -> bool:
    return isinstance(value, list | tuple) and bool(value) and isinstance(value[0], Mapping)


def _is_nested(value: Any) -> bool:
    return isinstance(value, Mapping) or _is_list_of_mappings(value)
