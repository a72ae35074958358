"""Files and reports of a run: how they are named, listed, packed and written."""

from __future__ import annotations

import dataclasses
import errno
import hashlib
import io
import json
import logging
import os
import zipfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Any, TypeVar

from fab.errors import Finding, InvalidJob, Severity, did_you_mean
from fab.files import shown_path
from fab.interrupts import held
from fab.scratch import beside, locked
from solver.vectors import FloatArray

__all__ = [
    "Made",
    "box_mm",
    "finding_entry",
    "fixed_dxf_metadata",
    "formats_among",
    "plain_title",
    "require_folder",
    "with_report",
    "write",
    "zip_bytes",
]


# What helps where files cannot be written.
_CURES = {
    errno.ENAMETOOLONG: "Give the file that they are made from, or --out, a shorter name.",
    errno.ENOSPC: "Free some space, or choose another --out.",
    errno.EDQUOT: "Free some space, or choose another --out.",
}


Kind = TypeVar("Kind", bound=StrEnum)


@dataclass(frozen=True)
class Made:
    """What a run made: files by name, the report that goes with them, and its findings."""

    files: Mapping[str, bytes]
    report: Mapping[str, Any]
    findings: tuple[Finding, ...]

    @property
    def within_tolerance(self) -> bool:
        """Whether no finding is an error."""
        return all(finding.severity != Severity.ERROR for finding in self.findings)


def with_report(
    files: Mapping[str, bytes], name: str, report: Mapping[str, Any], findings: Sequence[Finding]
) -> Made:
    """Files and their report, the last of them: `report`, then all files and findings."""
    outputs = [
        {"file": file, "bytes": len(data), "sha256": hashlib.sha256(data).hexdigest()}
        for file, data in files.items()
    ]
    listed = [finding_entry(finding) for finding in findings]
    whole = {**report, "outputs": outputs, "findings": listed}
    data = (json.dumps(whole, indent=2, allow_nan=False) + "\n").encode()
    return Made({**files, name: data}, whole, tuple(findings))


def finding_entry(finding: Finding) -> dict[str, Any]:
    """A finding in a report, as any `Finding`; its places only where it has some."""
    entry = {field.name: getattr(finding, field.name) for field in dataclasses.fields(Finding)}
    if not finding.places:
        del entry["places"]
    return entry


def box_mm(coords: FloatArray) -> list[float]:
    """Sides of the box around points, rounded to 1e-6 mm."""
    return [round(float(side), 6) for side in coords.max(axis=0) - coords.min(axis=0)]


def plain_title(text: str) -> str:
    """The text with "_" for everything that cannot be printed.

    That is control characters (XML cannot hold them), bytes of a file name that are not text, marks
    that turn the direction of reading, and line breaks.
    """
    return "".join(letter if letter.isprintable() else "_" for letter in text)


def formats_among(names: Iterable[str], kinds: type[Kind], source: str) -> list[Kind]:
    """The kinds of files of these names. Raises `InvalidJob`, which begins with `source`."""
    known = [str(kind) for kind in kinds]
    chosen = []
    for name in names:
        if name not in known:
            hint = did_you_mean(name, known)
            raise InvalidJob(f"{source} {str(name)!r} must be among {','.join(known)}.{hint}")
        chosen.append(kinds(name))
    return chosen


def zip_bytes(files: Mapping[str, bytes]) -> bytes:
    """A zip archive of files by name, in their order, without dates."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as package:
        for name, data in files.items():
            entry = zipfile.ZipInfo(name, date_time=(1980, 1, 1, 0, 0, 0))
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = 0o644 << 16
            package.writestr(entry, data)
    return stream.getvalue()


def require_folder(folder: Path) -> None:
    """Raise `InvalidJob` unless `folder` is a writable folder, or can become one."""
    if "\0" in str(folder):
        raise InvalidJob(f"{shown_path(folder)}: a NUL character in a path. Choose another --out.")
    try:
        existing = next(p for p in [folder, *folder.absolute().parents] if p.exists())
    except OSError as error:
        raise _unwritten(folder, error) from error
    if not existing.is_dir():
        which = "" if existing == folder else f"{existing} "
        raise InvalidJob(
            f"{folder}: {which}is a file, not a folder to write into. Choose another --out."
        )
    if not os.access(existing, os.W_OK | os.X_OK):
        raise InvalidJob(f"{folder}: no permission to write in {existing}. Choose another --out.")


def write(made: Made, folder: str | Path) -> None:
    """Write all files of a run into `folder`, which is made where it is missing.

    Every file is written in full beside its place before any is renamed, so an interrupted run
    leaves no partial file under a final name. Then all are renamed, and no other run renames any
    meanwhile. Raises `InvalidJob` where the folder cannot take the files.
    """
    folder = Path(folder)
    require_folder(folder)
    fresh = [p for p in [folder, *folder.absolute().parents] if not p.exists()]
    try:
        for name in made.files:
            if (folder / name).is_dir():
                raise InvalidJob(f"{folder / name} is a folder. Move it, or choose another --out.")
        folder.mkdir(parents=True, exist_ok=True)
        with beside(folder) as own:
            for name, data in made.files.items():
                (own / name).write_bytes(data)
            with locked(folder), held():
                for name in made.files:
                    (own / name).replace(folder / name)
                fresh = []
    except OSError as error:
        raise _unwritten(folder, error) from error
    finally:
        for made_folder in fresh:
            if made_folder.is_dir() and not any(made_folder.iterdir()):
                made_folder.rmdir()


def _unwritten(folder: Path, error: OSError) -> InvalidJob:
    cure = _CURES.get(error.errno or 0, "Choose another --out.")
    why = error.strerror or error
    return InvalidJob(
        f"{shown_path(folder)}: cannot be written: {why}. No partial file was left. {cure}"
    )


@contextmanager
def fixed_dxf_metadata() -> Iterator[None]:
    """Dates and GUIDs of ezdxf fixed, so that the same drawing gives the same bytes.

    Its warning that R12 has no units is held back: they are written all the same.
    """
    import ezdxf

    logger = logging.getLogger("ezdxf")
    before, level = ezdxf.options.write_fixed_meta_data_for_testing, logger.level
    ezdxf.options.write_fixed_meta_data_for_testing = True
    logger.setLevel(logging.ERROR)
    try:
        yield
    finally:
        ezdxf.options.write_fixed_meta_data_for_testing = before
        logger.setLevel(level)
