"""Jobs and crease patterns that commands read."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from fab.cli.options import Size
from fab.errors import Finding, InvalidJob, did_you_mean
from fab.files import shown_path

if TYPE_CHECKING:
    from fab.formats.read_options import ReadOptions
    from fab.jobs.job import Job
    from fab.pattern.crease_pattern import CreasePattern

__all__ = ["STANDARD_INPUT", "allowed_job", "place_of_job", "sheet_of", "shipped_job"]

# What stands for a job on standard input, in place of its file.
STANDARD_INPUT = "-"


def allowed_job(path: Path, changes: Sequence[str], allow_code: bool) -> Job:
    """A job; the Python file that it may name is run where that is allowed.

    That is with `allow_code`, or where the user says so at a terminal. The files that a job on
    standard input names are looked for in the working folder. Raises `InvalidJob`.
    """
    from fab.jobs.job import load_job, parse_job
    from fab.jobs.own_designs import CodeNotAllowed

    if str(path) == STANDARD_INPUT:
        source = "standard input"
        return parse_job(_piped(source, changes), source, allow_code=allow_code)
    try:
        return load_job(path, changes, allow_code=allow_code)
    except CodeNotAllowed as refusal:
        if not _confirmed(f"{path} runs the code of {refusal.path}. Allow that?"):
            raise
    return load_job(path, changes, allow_code=True)


def shipped_job(name: Path) -> Path | None:
    """The file of a shipped job by its name; None for files, and for names of no shipped job."""
    from fab.catalogue import shipped

    if name.suffix or os.path.exists(name):  # noqa: PTH110 - false for names that no file can have
        return None
    return shipped("jobs").get(str(name))


def place_of_job(job: Path) -> Path:
    """The file of a job; of a shipped one by its name, where no file is called so."""
    from fab.catalogue import shipped

    if str(job) == STANDARD_INPUT or job.suffix or os.path.exists(job):  # noqa: PTH110 - as above
        return job
    found = shipped_job(job)
    if found is None:
        hint = did_you_mean(job, shipped("jobs"))
        raise InvalidJob(
            f"{shown_path(job)} is neither a file nor a shipped job.{hint} List these: "
            "`quadfold templates`."
        )
    return found


def _piped(source: str, changes: Sequence[str]) -> dict[str, Any]:
    """The tables of a job on standard input, with changes laid over them."""
    from fab.settings import LARGEST_BYTES, apply_change, parsed_toml

    cure = "Give a job, as in: quadfold run - < job.toml"
    stream = sys.stdin
    if stream is None:
        raise InvalidJob(f"{source} is closed. {cure}")
    try:
        text = stream.buffer.read(LARGEST_BYTES + 1)
    except OSError as error:
        raise InvalidJob(f"{source}: cannot be read: {error.strerror}. {cure}") from error
    document = parsed_toml(text, source, cure)
    for change in changes:
        apply_change(document, change)
    return document


def _confirmed(question: str) -> bool:
    """The user's answer at a terminal; no where nobody can be asked."""
    streams = (sys.stdin, sys.stderr)
    if not all(stream is not None and stream.isatty() for stream in streams):
        return False
    try:
        return click.confirm(question, err=True)
    except click.Abort:  # the end of the input; an interrupt has been noted elsewhere
        return False


def sheet_of(
    file: Path, options: ReadOptions, size: Size
) -> tuple[CreasePattern, str, Sequence[Finding]]:
    """The crease pattern of a file in the size asked for, its name, and the reader's findings.

    Raises `InvalidFile` for sizes that nothing can be made of.
    """
    from fab.jobs.reading import read_sheet
    from fab.outputs import plain_title

    read = read_sheet(file, options, width_mm=size.width_mm, factor=size.factor)
    return read.pattern, plain_title(file.stem), read.findings
