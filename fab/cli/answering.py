"""One command from its words to its exit code."""

from __future__ import annotations

from collections.abc import Sequence

from click import Abort, ClickException

from fab.cli.group import main
from fab.interrupts import Interrupts
from solver.errors import escaped

__all__ = ["exit_code"]


def exit_code(words: Sequence[str], interrupts: Interrupts) -> int:
    """Run a command, whose wrong usage is shown; its exit code.

    interrupts : entered, which note what comes before a command begins, and when it is over.
    """
    try:
        code = main.main(list(words), prog_name="quadfold", standalone_mode=False)
    except ClickException as error:
        error.message = escaped(error.message)  # words of the user, which may hold anything
        error.show()
        return error.exit_code
    except Abort:
        return interrupts.exit_code
    except SystemExit as error:
        code = error.code
    return code if isinstance(code, int) else 0
