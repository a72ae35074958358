"""What keeps the folds of a command that are cut short."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from fab.cli.console import say, tell
from fab.cli.delivery import Told
from fab.errors import Finding

if TYPE_CHECKING:
    from fab.folding.checkpoints import FoldCheckpoints

__all__ = ["kept_fold"]


def kept_fold(out: Path, name: str, told: Told) -> FoldCheckpoints:
    """That of a run that writes the files of a job or pattern of this name into `out`."""
    from fab.folding.checkpoints import FoldCheckpoints

    def line(text: str | Finding) -> None:
        if told not in (Told.LINES, Told.ALL):
            return
        if isinstance(text, Finding):
            tell([text])
        else:
            say(text, error=True)

    return FoldCheckpoints(out, name, line)
