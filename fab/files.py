"""Files that the user names: regular ones that can be read, or a refusal that says why not."""

from __future__ import annotations

import stat
from pathlib import Path

from solver.errors import OrigamiError

__all__ = ["require_file", "shortened", "shown_path"]

# Longer paths are shortened in messages.
_LONGEST_SHOWN = 120


def require_file(path: Path, refusal: type[OrigamiError], cure: str) -> int:
    """The size in bytes of a file that can be read.

    Raises `refusal`, with `cure` at its end, where there is none at this path: nothing, a folder or
    a device, or a path that is too long, holds a NUL character, or may not be read.
    """
    try:
        status = path.stat()
        regular = stat.S_ISREG(status.st_mode)
        if regular:
            with path.open("rb"):
                return status.st_size
    except OSError as error:
        why = error.strerror or type(error).__name__
        raise refusal(f"{shown_path(path)}: cannot be read: {why}. {cure}") from error
    except ValueError as error:  # a NUL character
        raise refusal(f"{shown_path(path)}: cannot be read: {error}. {cure}") from error
    what = "a folder" if stat.S_ISDIR(status.st_mode) else "a device"
    raise refusal(f"{shown_path(path)}: {what}, not a file. {cure}")


def shown_path(path: Path) -> str:
    """A path for a message, `shortened`."""
    return shortened(str(path))


def shortened(text: str) -> str:
    """A path or name for a message; a long one without its middle.

    >>> shortened("miura"), len(shortened("a" * 5000))
    ('miura', 120)
    """
    if len(text) <= _LONGEST_SHOWN:
        return text
    half = _LONGEST_SHOWN // 2
    return f"{text[: half - 1]}…{text[-half:]}"
