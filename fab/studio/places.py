"""Places within the studio's folder, outside of which it reads and writes nothing."""

from __future__ import annotations

from pathlib import Path

from fab.errors import InvalidJob
from fab.files import shortened

__all__ = ["inside"]


def inside(folder: Path, name: str) -> Path:
    """A path within the folder. Raises `InvalidJob` for one that leaves it."""
    home = folder.resolve()
    try:
        place = (home / name).resolve()
        place.exists()  # names may be too long for the file system
    except (OSError, ValueError, RuntimeError) as error:
        raise InvalidJob(f"{shortened(name)!r} is no path.") from error
    if not place.is_relative_to(home):
        raise InvalidJob(
            f"{shortened(name)!r} is outside {home}, where the studio was started: it reads and "
            "writes nothing else. Choose a place within."
        )
    return place
