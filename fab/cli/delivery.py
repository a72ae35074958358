"""What a command made: written, listed and summed up, with its exit code."""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Callable, Iterable, Mapping
from enum import StrEnum
from pathlib import Path
from typing import Any

from fab.cli.console import Interrupts, progress_bar, say, tell, tell_left
from fab.errors import Severity
from fab.outputs import Made, left_over, require_folder, write
from fab.progress import Progress

__all__ = ["Told", "deliver", "write_made"]


class Told(StrEnum):
    """What a command prints: lines, the report as one JSON document, or nothing but errors."""

    LINES = "lines"
    JSON = "json"
    ERRORS = "errors"


def deliver(
    interrupts: Interrupts,
    make: Callable[[Progress], Made],
    out: Path,
    *,
    dry_run: bool,
    summary: Callable[[Mapping[str, Any]], Iterable[str]],
    names: re.Pattern[str] | None = None,
    told: Told = Told.LINES,
) -> None:
    """Make files with progress at the terminal, write and sum them up, and exit.

    summary : gives the lines that sum up a report.
    names : what files of the kind are called; those in `out` of an earlier run are named.
    told : what is printed; a refusal is one line of the error stream, whatever it is.
    """
    require_folder(out)
    with progress_bar(interrupts) as progress:
        made = make(progress)
    interrupts.check()
    if told is Told.LINES:
        write_made(made, out, dry_run=dry_run)
    elif not dry_run:
        write(made, out)
    if told is Told.JSON:
        say(json.dumps({"folder": None if dry_run else str(out), **made.report}, indent=2))
    if told is Told.ERRORS:
        tell([finding for finding in made.findings if finding.severity is Severity.ERROR])
    if told is Told.LINES:
        for line in summary(made.report):
            say(line)
        if names is not None:
            tell_left(left_over(made.files, names, out))
        tell(made.findings)
    sys.exit(0 if made.within_tolerance else 1)


def write_made(made: Made, folder: Path, *, dry_run: bool = False) -> None:
    """Write all files, unless it is a dry run, and list them."""
    if not dry_run:
        write(made, folder)
    verb = "would write" if dry_run else "wrote"
    for name, data in made.files.items():
        say(f"{verb} {folder / name}  {len(data)} bytes")
