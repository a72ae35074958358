"""One command from its words to its exit code."""

from __future__ import annotations

import io
from collections.abc import Sequence

from click import Abort, ClickException

from fab.cli.console import say
from fab.cli.group import main
from fab.interrupts import Interrupts

__all__ = ["exit_code"]


def exit_code(words: Sequence[str], interrupts: Interrupts) -> int:
    """Run a command, whose wrong usage is shown; its exit code.

    interrupts : entered, which note what comes before a command begins, and when it is over.
    """
    try:
        code = main.main(list(words), prog_name="quadfold", standalone_mode=False)
    except ClickException as error:
        shown = io.StringIO()
        error.show(file=shown)
        say(shown.getvalue().rstrip("\n"), error=True)  # it quotes words, which may hold anything
        return error.exit_code
    except Abort:
        return interrupts.exit_code
    except SystemExit as error:
        code = error.code
    return code if isinstance(code, int) else 0
