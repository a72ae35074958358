"""Lists of tables in the text of a job, changed row by row: comments of what stays do so too."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import Any

__all__ = ["put_tables"]

_INDENT = "    "


def put_tables(table: Any, key: str, rows: Sequence[Mapping[str, Any]]) -> None:
    r"""Give a list of tables to a key of a tomlkit table; rows that are the same are not touched.

    A list of `[[headings]]` stays one, and is left out when it is empty; any other has a row a
    line.

    >>> import tomlkit
    >>> job = tomlkit.parse("strips = [\n    { side = 'top', lengths = 1.0 },  # first\n]\n")
    >>> put_tables(job, "strips", [{"side": "top", "lengths": 2.0}, {"side": "left"}])
    >>> print(tomlkit.dumps(job), end="")
    strips = [
        { side = 'top', lengths = 2.0 },  # first
        { side = "left" },
    ]
    """
    import tomlkit
    from tomlkit.items import AoT, Array, InlineTable

    kept = table.get(key)
    if isinstance(kept, AoT) and not rows:
        table.remove(key)
        return
    lines = isinstance(kept, Array) and all(isinstance(row, InlineTable) for row in kept)
    if not isinstance(kept, AoT) and not (lines and "\n" in kept.as_string()):
        table[key] = _parsed("[\n" + "".join(f"{_INDENT}{_line(row)},\n" for row in rows) + "]")
        return
    for row, wanted in zip(kept, rows, strict=False):
        for name in [name for name in row if name not in wanted]:
            del row[name]
        for name, value in wanted.items():
            if row.get(name) != value:
                row[name] = _item(value)
    while len(kept) > len(rows):
        del kept[len(kept) - 1]
    for wanted in rows[len(kept) :]:
        if isinstance(kept, AoT):
            row = tomlkit.table()
            row.update({name: _item(value) for name, value in wanted.items()})
            kept.append(row)
        else:
            kept.add_line(_parsed(_line(wanted)), indent=_INDENT)


def _line(row: Mapping[str, Any]) -> str:
    """A row as an inline table."""
    import tomlkit

    parts = [
        f"{tomlkit.item({name: _item(value)}, _sort_keys=False).as_string().strip()}"
        for name, value in row.items()
    ]
    return f"{{ {', '.join(parts)} }}"


def _parsed(text: str) -> Any:
    import tomlkit

    return tomlkit.parse(f"value = {text}\n")["value"]


def _item(value: Any) -> Any:
    """Numbers have a point, as those of designs are real; what no float holds stays as it is."""
    if isinstance(value, list):
        return [_item(each) for each in value]
    if isinstance(value, int) and not isinstance(value, bool):
        with suppress(OverflowError):
            return float(value)
    return value
