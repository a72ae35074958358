"""The text of a job, changed key by key: comments and order stay."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from fab.errors import InvalidJob
from fab.files import shortened
from fab.jobs.job import Job, parse_job
from fab.settings import toml_of
from fab.studio.table_lists import put_tables

__all__ = ["MOST_BYTES", "Change", "changed_text", "job_of_text"]

# Of a job, as of all files that users write.
MOST_BYTES = 1_000_000

# Tables and key, and the value, a list of tables, or None to remove the key.
Change = tuple[Sequence[str], Any]


def job_of_text(text: str, folder: Path, *, allow_code: bool = False) -> Job:
    """The job that a text is, which names files within `folder` alone.

    Raises `InvalidJob` for what `parse_job` refuses, and for files outside.
    """
    document = _document(text)
    _require_within(document, folder)
    return parse_job(document, "job", folder, allow_code=allow_code)


def changed_text(text: str, changes: Sequence[Change]) -> str:
    r"""The text with other values of some keys; comments of keys that stay do so too.

    Raises `InvalidJob` for keys within what is no table.

    >>> changed_text("[design]\nrows = 8  # of quads\n", [(["design", "rows"], 6)])
    '[design]\nrows = 6  # of quads\n'
    """
    import tomlkit
    from tomlkit.exceptions import TOMLKitError

    _document(text)
    document = tomlkit.parse(text)
    for path, value in changes:
        table: Any = document
        for key in path[:-1]:
            if key not in table:
                if value is None:
                    break
                table[key] = tomlkit.table()
            table = table[key]
            if not isinstance(table, Mapping):
                raise InvalidJob(f"{shortened('.'.join(path))}: {shortened(key)} is no table.")
        else:
            try:
                _put(table, path[-1], value)
            except (TOMLKitError, ValueError, TypeError) as error:
                where = shortened(".".join(path))
                raise InvalidJob(f"{where}: cannot be written as TOML: {error}.") from error
    return tomlkit.dumps(document)


def _put(table: Any, key: str, value: Any) -> None:
    """Give a value to a key, or remove it; numbers stay with or without a point as they were."""
    if value is None:
        table.pop(key, None)
        return
    if isinstance(value, list):
        put_tables(table, key, value)
        return
    before = table.get(key)
    if isinstance(before, float) and isinstance(value, int) and not isinstance(value, bool):
        with suppress(OverflowError):  # what is too large is refused where its key is read
            value = float(value)
    table[key] = value


def _document(text: str) -> dict[str, Any]:
    if len(text.encode("utf-8", "surrogatepass")) > MOST_BYTES:
        raise InvalidJob(f"job: has {len(text)} characters, must have at most {MOST_BYTES} bytes.")
    try:
        return toml_of(text)
    except (ValueError, RecursionError) as error:
        raise InvalidJob(f"job: not a TOML file: {error}. Correct it there.") from error


def _require_within(document: Mapping[str, Any], folder: Path) -> None:
    """Refuse files outside `folder`, under the keys that name files."""
    named = [
        ("design", "surface"),
        ("design", "kind"),
        ("printer", "machine"),
        ("printer", "material"),
        ("printer", "panel_material"),
        ("printer", "hinge_material"),
    ]
    inside = folder.resolve()
    for table, key in named:
        value = document.get(table)
        value = value.get(key) if isinstance(value, Mapping) else None
        if not isinstance(value, str):
            continue
        try:
            place = (inside / value.partition(".py:")[0]).resolve()
        except (OSError, ValueError, RuntimeError):
            continue  # no path at all, which the reader of the key refuses
        if not place.is_relative_to(inside):
            raise InvalidJob(
                f"{table}.{key} = {shortened(value)!r} is outside {inside}, where the studio was "
                "started: it reads nothing else. Move the file there, or start the studio in a "
                "folder above both."
            )
