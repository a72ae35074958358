"""Entry point of the command line, which interrupts end cleanly from first to last."""

from __future__ import annotations

import os
import sys
from contextlib import suppress
from typing import TYPE_CHECKING, NoReturn

from fab.interrupts import Interrupts, ignore_interrupts

if TYPE_CHECKING:
    from sys import UnraisableHookArgs

__all__ = ["run"]


def run() -> NoReturn:
    """Run `quadfold`, and exit. An interrupt while it loads ends it once all is loaded.

    Libraries turn an interrupt while they load into errors of their own. One that comes when the
    work is done does not change the exit code.
    """
    interrupts = Interrupts(raises=False)
    sys.unraisablehook = _unraisable
    with interrupts:
        from fab.cli.answering import exit_code

        if interrupts.came:
            _end(interrupts.exit_code)
        _end(exit_code(sys.argv[1:], interrupts))


def _end(code: int) -> NoReturn:
    """Exit with this code, whatever becomes of who reads what is printed, and of interrupts."""
    ignore_interrupts()
    for stream in (sys.stdout, sys.stderr):
        try:
            if stream is not None:
                stream.flush()
        except OSError:  # a closed pipe or a full disk, which is reported again at the exit
            with suppress(OSError, ValueError):
                os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
    sys.exit(code)


def _unraisable(failed: UnraisableHookArgs) -> None:
    """Report what goes wrong where nothing can be raised, but for interrupts, which are noted."""
    if not isinstance(failed.exc_value, KeyboardInterrupt):
        sys.__unraisablehook__(failed)


if __name__ == "__main__":
    run()
