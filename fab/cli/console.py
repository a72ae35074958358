"""The terminal: errors, interrupts and findings of a run, as the user sees them."""

from __future__ import annotations

import signal
import sys
import threading
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from types import FrameType
from typing import Any

import click

from fab.errors import Finding, Severity
from solver.errors import OrigamiError, escaped

__all__ = ["Interrupts", "answers", "say", "tell", "tell_all", "tell_left"]

# Files of an earlier run that are named.
_LISTED = 3


@contextmanager
def answers() -> Iterator[Interrupts]:
    """Turn expected errors into one message and exit code 2, interrupts into 130."""
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
            sys.exit(130)
        if isinstance(error, OrigamiError):
            say(f"quadfold: {error}", error=True)
            sys.exit(2)
        if isinstance(error, MemoryError):
            say("quadfold: out of memory. Ask for fewer quads or dashes.", error=True)
            sys.exit(2)
        raise


class Interrupts:
    """Notes SIGINT and SIGTERM: some libraries swallow the exception that they raise."""

    def __init__(self) -> None:
        self.came = False
        self._before: dict[int, Any] = {}

    def __enter__(self) -> None:
        if threading.current_thread() is threading.main_thread():
            for number in (signal.SIGINT, signal.SIGTERM):
                self._before[number] = signal.signal(number, self._note)

    def __exit__(self, *_: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def _note(self, _: int, frame: FrameType | None) -> None:
        self.came = True
        if not _importing(frame):
            raise KeyboardInterrupt

    def check(self) -> None:
        """Raise again what a library may have swallowed."""
        if self.came:
            raise KeyboardInterrupt


def _importing(frame: FrameType | None) -> bool:
    """Whether a library is being imported, which an exception would leave half done."""
    while frame is not None:
        if frame.f_code.co_filename.startswith("<frozen importlib"):
            return True
        frame = frame.f_back
    return False


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
