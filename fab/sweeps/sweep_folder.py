"""The folder of a sweep: its variations, its parts, and the table that is made of both.

- `variations.parquet`: number, hash of the job, and values of the axes
- `parts`: rows by the hash of their job
- `pictures`, `files`: folded forms, and files of variations, named by that hash
- `results.parquet`, `results.csv`: the whole table; `sweep.html`: the page; `contact_sheet.png`
- `.lock`: held while a sweep runs
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Protocol

import pyarrow as pa
import pyarrow.parquet as pq

from fab import __version__
from fab.errors import InvalidJob
from fab.sweeps.axes import Axis
from fab.sweeps.dotted_names import short_names
from fab.sweeps.named_files import NamedFiles
from fab.sweeps.parts import LIMITS, Parts, axis_fields, unwritten, write_table
from fab.sweeps.sweep_settings import Sweep
from fab.sweeps.variations import Variation, hash_of

__all__ = ["Listed", "Plan", "SweepFolder", "Varied", "locked"]

# Files that are being written, beside their places.
_STRAY = (".*.parquet.*", ".*.new")
_RESULTS = ("results.parquet", "results.csv")
# A page holds so many pictures.
_PICTURES = 500


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """The folder is this run's alone. Raises `InvalidJob` where another run is at work in it."""
    from filelock import FileLock, Timeout

    try:
        folder.mkdir(parents=True, exist_ok=True)
        lock = FileLock(folder / ".lock")
        lock.acquire(timeout=0)
    except Timeout as error:
        raise InvalidJob(
            f"{folder}: another sweep is at work there. Wait for it, or choose another --out."
        ) from error
    except OSError as error:
        raise InvalidJob(
            f"{folder}: cannot be written: {error.strerror or error}. Choose another --out."
        ) from error
    try:
        yield
    finally:
        lock.release()


class Varied(Protocol):
    """Variations along axes, which can be gone through again and again."""

    @property
    def axes(self) -> tuple[Axis, ...]:
        """The axes."""

    def __iter__(self) -> Iterator[Variation]:
        """All variations."""


@dataclass(frozen=True)
class Listed:
    """Variations that are known one by one."""

    axes: tuple[Axis, ...]
    variations: tuple[Variation, ...]

    def __iter__(self) -> Iterator[Variation]:
        return iter(self.variations)


@dataclass(frozen=True)
class Plan:
    """What there is to do: variations, different jobs, and hashes of those without a row.

    others : rows of other jobs. damaged : parts that cannot be read.
    """

    variations: int
    jobs: int
    hashes: set[str]
    others: int
    damaged: int


@dataclass(frozen=True)
class SweepFolder:
    """A folder, and the sweep that runs in it."""

    path: Path
    sweep: Sweep
    variations: Varied

    @property
    def parts(self) -> Parts:
        """Its parts."""
        return Parts(self.path / "parts")

    @property
    def files(self) -> Path | None:
        """Where files of variations go; None where none are kept."""
        return self.path / "files" if self.sweep.outputs else None

    def require_parts(self) -> None:
        """Make the folder of the parts, without what a run that was killed left beside them."""
        (self.path / "parts").mkdir(parents=True, exist_ok=True)
        folders = (self.path, self.path / "parts", self.path / "pictures")
        for stray in (s for folder in folders for form in _STRAY for s in folder.glob(form)):
            stray.unlink(missing_ok=True)

    def drop_unsettled(self) -> int:
        """Drop rows that crashed, or that a limit ended which is higher now. Their number."""
        return self.parts.drop(self._is_unsettled)

    def _is_unsettled(self, row: Mapping[str, Any]) -> bool:
        seconds, memory_mb = (row[name] for name in LIMITS)
        limits = self.sweep.limits
        if row["status"] == "too slow":
            return seconds is not None and limits.seconds > seconds
        if row["status"] == "too large":
            return memory_mb is None or limits.memory_mb is None or limits.memory_mb > memory_mb
        return row["status"] in ("crashed", "failed")

    def keep(self, rows: Sequence[Mapping[str, Any]]) -> None:
        """Write the rows of a batch, and their pictures before them."""
        for row in rows:
            if row.get("picture") is not None:
                self._write(f"pictures/{row['job_hash']}.png", row["picture"])
        limits = self.sweep.limits
        under = dict(zip(LIMITS, (limits.seconds, limits.memory_mb), strict=True))
        self.parts.add([{**row, **under} for row in rows])

    def _write(self, name: str, data: bytes) -> None:
        """Write a file beside its place, and rename it. Raises `InvalidJob` as `write_table`."""
        place = self.path / name
        beside = place.with_name(f".{place.name}.new")
        try:
            place.parent.mkdir(exist_ok=True)
            beside.write_bytes(data)
            beside.replace(place)
        except OSError as error:
            raise unwritten(place, error) from error
        finally:
            with suppress(OSError):  # of a disk that is full, where it would be in the way
                beside.unlink(missing_ok=True)

    def write_page(self) -> None:
        """Write the page, and the contact sheet where there are pictures, of the table as it is."""
        from fab.sweeps.sweep_page import MOST_ROWS, sweep_page_bytes

        table = pq.read_table(self.path / _RESULTS[0])
        rows = table.slice(0, MOST_ROWS).to_pylist()
        keys = [axis.key for axis in self.variations.axes]
        pictures = {
            row["job_hash"]: place.read_bytes()
            for row in rows[:_PICTURES]
            if (place := self.path / "pictures" / f"{row['job_hash']}.png").is_file()
        }
        page = sweep_page_bytes(self.sweep.name, keys, rows, table.num_rows, pictures)
        self._write("sweep.html", page)
        if pictures:
            from fab.sweeps.thumbnails import contact_sheet_bytes

            titles = short_names(keys)
            captions = [
                (
                    f"{row['number']}: "
                    + ", ".join(f"{titles[key]} {_short(row[key])}" for key in keys),
                    picture,
                )
                for row in rows
                if (picture := pictures.get(row["job_hash"])) is not None
            ]
            self._write("contact_sheet.png", contact_sheet_bytes(captions))

    def begin(self) -> Plan:
        """Write the variations, and say what there is to do.

        A variation whose job is that of another is run once.
        """
        self.require_parts()
        parts = self.parts
        done = parts.hashes()
        wanted: set[str] = set()

        fields = axis_fields(self.variations.axes)
        schema = pa.schema([("number", pa.int64()), ("job_hash", pa.string()), *fields])
        texts = {field.name: str for field in fields if field.type == pa.string()}

        def rows() -> Iterator[dict[str, Any]]:
            for variation in self.variations:
                hashed = self.hash_of(variation)
                wanted.add(hashed)
                values = {key: texts.get(key, _same)(v) for key, v in variation.values.items()}
                yield {"number": variation.number, "job_hash": hashed, **values}

        count = write_table(self.path / "variations.parquet", schema, rows())
        others, damaged = len(done - wanted) + sum(parts.foreign.values()), len(parts.damaged)
        return Plan(count, len(wanted), wanted - done, others, damaged)

    def hash_of(self, variation: Variation) -> str:
        """The hash of the job of a variation."""
        document = self.sweep.varied(variation.values)
        files = self._named_files.digests(document)
        return hash_of(document, files, self.sweep.measured, __version__)

    @cached_property
    def _named_files(self) -> NamedFiles:
        return NamedFiles(self.sweep.folder)

    def pending(self, hashes: set[str]) -> Iterator[Variation]:
        """The variations of these jobs, the first of each, in their order."""
        left = set(hashes)
        for variation in self.variations:
            hashed = self.hash_of(variation)
            if hashed in left:
                left.discard(hashed)
                yield replace(variation, job_hash=hashed)

    def rows(self) -> list[dict[str, Any]]:
        """The rows of the table, which has been written."""
        found: list[dict[str, Any]] = pq.read_table(self.path / _RESULTS[0]).to_pylist()
        return found

    def write_jobs(self, files: Mapping[str, bytes]) -> None:
        """Write jobs beside the table; those of an earlier search go."""
        for old in self.path.glob("best*.toml"):
            old.unlink()
        for name, data in files.items():
            self._write(name, data)

    def write_results(self) -> dict[str, int]:
        """Write the whole table, as Parquet and CSV. How many rows have which status."""
        import duckdb

        with duckdb.connect() as connection:
            connection.execute("SET preserve_insertion_order = true")
            variations = str(self.path / "variations.parquet").replace("'", "''")
            parts = [str(path) for path in self.parts.readable()]
            names = pq.read_schema(self.path / "variations.parquet").names
            limits = ", ".join(f'"{name}"' for name in LIMITS)
            axes = "".join(f', v."{name}"' for name in names if name not in ("number", "job_hash"))
            connection.execute(
                f"CREATE VIEW results AS SELECT v.number, v.job_hash{axes}, "
                f"p.* EXCLUDE (job_hash, {limits}) "
                f"FROM read_parquet('{variations}') v JOIN "
                f"(SELECT DISTINCT ON (job_hash) * FROM read_parquet({parts!r})) p "
                "ON v.job_hash = p.job_hash ORDER BY v.number"
            )
            for name, options in zip(
                _RESULTS, ("FORMAT parquet", "FORMAT csv, HEADER"), strict=True
            ):
                beside = self.path / f".{name}.new"
                place = str(beside).replace("'", "''")
                try:
                    connection.execute(f"COPY results TO '{place}' ({options})")
                    beside.replace(self.path / name)
                except (duckdb.IOException, OSError) as error:
                    beside.unlink(missing_ok=True)
                    raise unwritten(self.path / name, error) from error
            found = connection.execute(
                "SELECT status, count(*) FROM results GROUP BY status ORDER BY 2 DESC, 1"
            ).fetchall()
        return dict(found)


def _same(value: Any) -> Any:
    return value


def _short(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
