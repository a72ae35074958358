"""The terminal: errors, interrupts and findings of a run, as the user sees them."""

from __future__ import annotations

import errno
import sys
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

import click

from fab.errors import Finding, Severity
from fab.files import shown_path
from fab.interrupts import Interrupts
from solver.errors import OrigamiError, escaped

__all__ = ["answers", "say", "tell", "tell_all", "tell_left"]

# Files of an earlier run that are named.
_LISTED = 3


# How the machine fails a run, whatever it does: no room, no more files, a disk that is gone.
_MACHINE_FAILS = {
    getattr(errno, name)
    for name in (
        *("ENOSPC", "EDQUOT", "EFBIG", "EROFS", "EIO", "ESTALE"),
        *("EMFILE", "ENFILE", "ENOMEM", "EAGAIN"),
    )
    if hasattr(errno, name)
}


@contextmanager
def answers() -> Iterator[Interrupts]:
    """Turn expected errors into one message and exit code 2, interrupts into 130 or 143."""
    interrupts = Interrupts()
    try:
        with warnings.catch_warnings(), interrupts:
            # extreme numbers overflow on the way to the error that names them
            warnings.simplefilter("ignore", RuntimeWarning)
            yield interrupts
    except BaseException as error:
        # libraries turn an interrupt during their import into errors of their own
        if interrupts.came or isinstance(error, KeyboardInterrupt):
            say("quadfold: interrupted; no partial file was left.", error=True)
            sys.exit(interrupts.exit_code)
        if isinstance(error, OrigamiError):
            say(f"quadfold: {error}", error=True)
            sys.exit(2)
        if isinstance(error, MemoryError):
            say("quadfold: out of memory. Ask for fewer quads or dashes.", error=True)
            sys.exit(2)
        if isinstance(error, OSError) and error.errno in _MACHINE_FAILS:
            place = "" if error.filename is None else f"{shown_path(Path(error.filename))}: "
            say(f"quadfold: {place}{error.strerror}. No partial file was left.", error=True)
            sys.exit(2)
        raise


def say(text: str, *, error: bool = False) -> None:
    """Print a line; a closed pipe or full disk behind stdout does not change what was made.

    What the terminal cannot show, such as bytes of a file name that are not text, is escaped, and
    so is what it would obey: control characters of names and titles.
    """
    stream = sys.stderr if error else sys.stdout
    encoding = getattr(stream, "encoding", None) or "utf-8"
    with suppress(OSError):
        click.echo(escaped(text).encode(encoding, "backslashreplace").decode(encoding), err=error)


def tell(findings: Sequence[Finding]) -> None:
    """One line for each code of finding, the most severe of it; the report lists all of them.

    Errors come first, then warnings and notes; within each, codes in the order of their findings.
    """
    alike: dict[str, list[Finding]] = {}
    for finding in findings:
        alike.setdefault(finding.code, []).append(finding)
    worst = [max(found, key=_gravity) for found in alike.values()]  # the first of equals
    for finding in sorted(worst, key=_gravity, reverse=True):  # which keeps the order of equals
        count = len(alike[finding.code])
        more = f" (and {count - 1} more of these)" if count > 1 else ""
        say(f"{finding.severity}: {finding.code}: {finding.text}{more}", error=True)


def tell_all(findings: Sequence[Finding]) -> None:
    """A line for each finding: errors first, then warnings and notes, each in their order."""
    for finding in sorted(findings, key=_gravity, reverse=True):
        say(f"{finding.severity}: {finding.code}: {finding.text}", error=True)


def _gravity(finding: Finding) -> int:
    return list(Severity).index(finding.severity)


def tell_left(left: Sequence[Path]) -> None:
    """One line for files of the same name that an earlier run left and this one did not make."""
    if left:
        names = ", ".join(path.name for path in left[:_LISTED])
        more = f" and {len(left) - _LISTED} more" if len(left) > _LISTED else ""
        are = "are" if len(left) > 1 else "is"
        say(f"note: {names}{more} in {left[0].parent} {are} from an earlier run", error=True)
