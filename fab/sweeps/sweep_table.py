"""Tables of sweeps: the best rows, those that meet a condition, as text or CSV."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fab.errors import InvalidJob
from fab.files import shortened, shown_path
from fab.sweeps.dotted_names import named

__all__ = ["Chosen", "choose", "column_named"]

# Words of a condition: text in quotes, names with dots, all else.
_WORDS = re.compile(r"'(?:[^']|'')*'|\"(?:[^\"]|\"\")*\"|[A-Za-z_][\w.]*|.", re.DOTALL)


@dataclass(frozen=True)
class Chosen:
    """Rows of a table: names of the columns, and the values of each row."""

    columns: tuple[str, ...]
    rows: tuple[tuple[Any, ...], ...]
    matching: int


def column_named(name: str, columns: Sequence[str]) -> str:
    """The column of a name. Raises `InvalidJob` for names that no column has, or several."""
    return named(name, columns, "column of the table")


def choose(
    table: Path,
    *,
    best: str | None = None,
    where: str | None = None,
    top: int | None = None,
    show: Sequence[str] = (),
    whole: bool = False,
) -> Chosen:
    """Rows of the table of a sweep.

    Parameters
    ----------
    best : a column of which the lowest values come first; with - before it, the highest.
    where : a condition as in SQL, such as "crossings = 0 and minutes < 10". Columns may be named
        without what is before their dots.
    top : at most so many rows.
    show : columns; where left out, axes, status, and those that best and where name.
    whole : whether all columns are shown instead.

    Raises `InvalidJob` for a table that is not there, unknown columns, and what is no condition.
    """
    import duckdb

    if not os.path.isfile(table):  # noqa: PTH113 - false for names that no file can have
        raise InvalidJob(f"{shown_path(table)}: is not there. Make it with `quadfold sweep`.")
    with duckdb.connect() as connection:
        try:
            connection.execute(
                "CREATE TABLE results AS SELECT * FROM read_parquet(?)", [str(table)]
            )
        except duckdb.Error as error:
            raise InvalidJob(_no_table(table, _first_line(error))) from error
        connection.execute("SET enable_external_access = false")
        connection.execute("SET lock_configuration = true")
        columns = [row[0] for row in connection.execute("DESCRIBE results").fetchall()]
        if lacking := {"number", "status"} - set(columns):
            raise InvalidJob(_no_table(table, f"it has no column {min(lacking)}"))
        names = [column_named(name, columns) for name in show]
        if whole:
            names = columns
        elif not names:
            names = _usual(columns, best, where)
        query = f"FROM results WHERE ({_condition(where, columns) if where else 'true'})"
        order = ""
        if best is not None:
            column = column_named(best.removeprefix("-"), columns)
            direction = "DESC" if best.startswith("-") else "ASC"
            query += f" AND {_quoted(column)} IS NOT NULL"
            order = f" ORDER BY {_quoted(column)} {direction}, number"
        try:
            found = connection.execute(f"SELECT count(*) {query}").fetchone()
            listed = ", ".join(map(_quoted, names))
            limit = "" if top is None else f" LIMIT {int(top)}"
            rows = connection.execute(
                f"SELECT {listed} {query}{order or ' ORDER BY number'}{limit}"
            ).fetchall()
        except duckdb.Error as error:
            why = _first_line(error)
            if where is None:
                raise InvalidJob(_no_table(table, why)) from error
            raise InvalidJob(
                f"--where {where!r}: is no condition on these columns: {why}. Correct it."
            ) from error
    return Chosen(tuple(names), tuple(map(tuple, rows)), 0 if found is None else int(found[0]))


def _no_table(table: Path, why: str) -> str:
    return f"{table}: is no table of a sweep: {why}. Make it again with `quadfold sweep`."


def _first_line(error: Exception) -> str:
    """What an error of the database says first, in printable characters and without a stop."""
    line = (str(error).splitlines() or [type(error).__name__])[0].rstrip(".? ")
    return shortened("".join(c if c.isprintable() else "\ufffd" for c in line))


def _usual(columns: Sequence[str], best: str | None, where: str | None) -> list[str]:
    """Number, axes and status, and the columns that are asked for."""
    begin = [name for name in columns[: columns.index("status") + 1] if name != "job_hash"]
    words = [] if where is None else _WORDS.findall(where)
    asked = [] if best is None else [column_named(best.removeprefix("-"), columns)]
    asked += [_word(word, columns)[1:-1] for word in words if _word(word, columns) != word]
    return list(dict.fromkeys([*begin, *asked]))


def _quoted(name: str) -> str:
    return '"' + name.replace('"', '""') + '"'


def _condition(text: str, columns: Sequence[str]) -> str:
    """A condition with names of columns in quotes.

    >>> print(_condition("mass_g < 5 and status = 'made'", ["solids.mass_g", "status"]))
    "solids.mass_g" < 5 and "status" = 'made'
    """
    if ";" in text:
        raise InvalidJob(f"--where {text!r}: must be one condition, without ';'.")
    return "".join(_word(word, columns) for word in _WORDS.findall(text))


def _word(word: str, columns: Sequence[str]) -> str:
    if not re.fullmatch(r"[A-Za-z_][\w.]*", word):
        return word
    ending = [column for column in columns if column == word or column.endswith(f".{word}")]
    if word in columns or len(ending) == 1 or "." in word or ending:
        return _quoted(column_named(word, columns))
    return word  # of SQL
