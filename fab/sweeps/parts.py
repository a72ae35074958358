"""Parts of a sweep's table: rows in Parquet files, by the hash of their job.

A row holds what became of a job; which variations have that job is known from the sweep alone. So
rows that are there stay good when a sweep is changed, and variations that are alike share one.
Each part is written beside its place and renamed: what is there is whole.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import islice
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from fab.errors import InvalidJob
from fab.sweeps.axes import Axis
from fab.sweeps.columns import FIGURES, OUTCOME, Column

__all__ = ["LIMITS", "Parts", "axis_fields", "unwritten", "write_table"]

_TYPES = {
    "text": pa.string(),
    "whole": pa.int64(),
    "number": pa.float64(),
    "truth": pa.bool_(),
}
_CHUNK = 4096


def fields_of(columns: Iterable[Column]) -> list[pa.Field]:
    """The columns as those of Arrow tables."""
    return [pa.field(column.name, _TYPES[column.kind]) for column in columns]


def axis_fields(axes: Sequence[Axis]) -> list[pa.Field]:
    """Columns of the values of axes; values of several types are text."""
    out = []
    for axis in axes:
        kinds = {type(value) for value in axis.values}
        kind = _KINDS[kinds.pop()] if len(kinds) == 1 else "text"
        if kinds == {int, float}:
            kind = "number"
        out.append(pa.field(axis.key, _TYPES[kind]))
    return out


_KINDS = {bool: "truth", int: "whole", float: "number", str: "text"}
# Which limits a row was run under, so that one that they ended is run again under higher ones.
LIMITS = ("limits.seconds", "limits.memory_mb")
_ROW = pa.schema(
    [
        *fields_of([*(each for each in OUTCOME if each.name != "number"), *FIGURES]),
        *(pa.field(name, pa.float64()) for name in LIMITS),
    ]
)


def write_table(path: Path, schema: pa.Schema, rows: Iterable[Mapping[str, Any]]) -> int:
    """Write rows as they come, beside the place of the file, and rename it. Returns their number.

    Raises `InvalidJob` where the folder cannot take them.
    """
    beside = path.with_name(f".{path.name}.{os.getpid()}")
    count = 0
    try:
        with pq.ParquetWriter(beside, schema, write_page_checksum=True) as writer:
            for chunk in _chunks(rows):
                writer.write_table(pa.Table.from_pylist(chunk, schema=schema))
                count += len(chunk)
        beside.replace(path)
    except OSError as error:
        raise unwritten(path, error) from error
    finally:
        beside.unlink(missing_ok=True)
    return count


def unwritten(path: Path, error: Exception) -> InvalidJob:
    """The refusal of a folder that cannot take a file."""
    why = getattr(error, "strerror", None) or error
    return InvalidJob(
        f"{path}: cannot be written: {why}. What was written before is whole: "
        "free some space, and run again to go on."
    )


def _chunks(rows: Iterable[Mapping[str, Any]]) -> Iterator[list[Mapping[str, Any]]]:
    rest = iter(rows)
    while chunk := list(islice(rest, _CHUNK)):
        yield chunk


class Parts:
    """The parts in a folder.

    Files that cannot be read are left aside, and named in `damaged`; so are those of other columns,
    which another version has written, in `foreign` with the numbers of their rows.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.damaged: list[Path] = []
        self.foreign: dict[Path, int] = {}

    def add(self, rows: Sequence[Mapping[str, Any]]) -> None:
        """Write a part. Raises `InvalidJob` where that cannot be."""
        jobs = " ".join(str(row["job_hash"]) for row in rows)
        name = f"{hashlib.sha256(jobs.encode()).hexdigest()[:20]}_{len(rows)}.parquet"
        known = set(_ROW.names)
        write_table(
            self.folder / name,
            _ROW,
            ({key: value for key, value in row.items() if key in known} for row in rows),
        )

    def hashes(self) -> set[str]:
        """Of all jobs whose rows are there."""
        done: set[str] = set()
        self.damaged, self.foreign = [], {}
        for path in self.paths():
            try:
                with pq.ParquetFile(path, page_checksum_verification=True) as file:
                    found = file.read()
                found.validate(full=True)
            except (OSError, pa.ArrowException):
                self.damaged.append(path)
                continue
            if found.schema.equals(_ROW):
                done.update(found["job_hash"].to_pylist())
            else:
                self.foreign[path] = len(found)
        return done

    def drop(self, unwanted: Callable[[Mapping[str, Any]], bool]) -> int:
        """Drop the rows of which that is true by status and limits. Returns their number.

        What is kept of a part is written before the part goes.
        """
        count = 0
        for path in self.readable():
            some = pq.read_table(path, columns=["status", *LIMITS]).to_pylist()
            going = [unwanted(row) for row in some]
            if not any(going):
                continue
            rows = pq.read_table(path).to_pylist()
            kept = [row for row, goes in zip(rows, going, strict=True) if not goes]
            if kept:
                self.add(kept)
            path.unlink()
            count += sum(going)
        return count

    def rows(self, columns: Sequence[str]) -> dict[str, dict[str, Any]]:
        """Some columns of all rows, by the hash of their job."""
        out: dict[str, dict[str, Any]] = {}
        wanted = list(dict.fromkeys(["job_hash", *columns]))
        for path in self.readable():
            for row in pq.read_table(path, columns=wanted).to_pylist():
                out[row["job_hash"]] = row
        return out

    def paths(self) -> list[Path]:
        """The files of all parts, sorted."""
        return sorted(self.folder.glob("*.parquet"))

    def readable(self) -> list[Path]:
        """Those that can be read, and are of this version."""
        self.hashes()
        aside = {*self.damaged, *self.foreign}
        return [path for path in self.paths() if path not in aside]
