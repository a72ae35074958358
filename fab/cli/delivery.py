"""What a command made: written, listed and summed up, with its exit code."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fab.cli.console import say, tell, tell_all, tell_left
from fab.cli.progress_lines import progress_of
from fab.errors import Severity
from fab.interrupts import Interrupts
from fab.jobs.file_names import Family, left_over
from fab.outputs import Made, require_folder, write
from fab.progress import Progress

if TYPE_CHECKING:
    from fab.folding.checkpoints import FoldCheckpoints

__all__ = ["FilesOf", "Told", "deliver", "write_made"]


class Told(StrEnum):
    """What a command prints.

    Lines; those and all findings and the seconds of each stage; the report as one JSON document; or
    nothing but errors.
    """

    LINES = "lines"
    ALL = "all"
    JSON = "json"
    ERRORS = "errors"


@dataclass(frozen=True)
class FilesOf:
    """The name of the job or pattern, and the families of files of which older ones are named."""

    name: str
    families: Sequence[Family]


def deliver(
    interrupts: Interrupts,
    make: Callable[[Progress], Made],
    out: Path,
    files: FilesOf,
    *,
    dry_run: bool,
    summary: Callable[[Mapping[str, Any]], Iterable[str]],
    told: Told = Told.LINES,
    kept: FoldCheckpoints | None = None,
) -> None:
    """Make files with progress at the terminal, write and sum them up, and exit.

    summary : gives the lines that sum up a report.
    told : what is printed; a refusal is one line of the error stream, whatever it is.
    kept : what keeps folds of the run that are cut short, until all files are written.
    """
    require_folder(out)
    in_lines = told in (Told.LINES, Told.ALL)
    with progress_of(interrupts, lines=in_lines) as progress:
        made = _whole(make, progress, kept)
    interrupts.check()
    if in_lines:
        write_made(made, out, dry_run=dry_run)
    elif not dry_run:
        write(made, out)
    if kept is not None:
        kept.remove()
    if told is Told.JSON:
        say(json.dumps({"folder": None if dry_run else str(out), **made.report}, indent=2))
    if told is Told.ERRORS:
        tell([finding for finding in made.findings if finding.severity is Severity.ERROR])
    if told is Told.ALL:
        for stage, seconds in made.report.get("seconds", {}).items():
            say(f"{stage:<10}  {seconds:.2f} s")
    if in_lines:
        for line in summary(made.report):
            say(line)
        tell_left(left_over(made.files, files.name, files.families, out))
        (tell_all if told is Told.ALL else tell)(made.findings)
    sys.exit(0 if made.within_tolerance else 1)


def _whole(
    make: Callable[[Progress], Made], progress: Progress, kept: FoldCheckpoints | None
) -> Made:
    try:
        return make(progress)
    except KeyboardInterrupt:
        if kept is not None:
            kept.cut_short()
        raise


def write_made(made: Made, folder: Path, *, dry_run: bool = False) -> None:
    """Write all files, unless it is a dry run, and list them."""
    if not dry_run:
        write(made, folder)
    verb = "would write" if dry_run else "wrote"
    for name, data in made.files.items():
        say(f"{verb} {folder / name}  {len(data)} bytes")
