"""Files that were made for the page: looked at, loaded one by one, and kept in the folder."""

from __future__ import annotations

import secrets
import shutil
from pathlib import Path

from fab.errors import InvalidJob
from fab.outputs import Made, require_folder, write, zip_bytes

__all__ = ["Exports"]

# What was made before the last few times is forgotten.
_MOST_KEPT = 8


class Exports:
    """Folders of files in a temporary one, by keys that nobody guesses."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._names: dict[str, list[str]] = {}

    def place(self) -> tuple[str, Path]:
        """A new key, and the folder that its files are to be written into."""
        key = secrets.token_hex(8)
        return key, self._folder / key

    def add(self, key: str, names: list[str]) -> None:
        """Hold the files of a key that were written, in their order; the oldest of many go."""
        self._names[key] = names
        while len(self._names) > _MOST_KEPT:
            oldest = next(iter(self._names))
            del self._names[oldest]
            shutil.rmtree(self._folder / oldest, ignore_errors=True)

    def files(self, key: str) -> dict[str, Path]:
        """The files of a key by name. Raises `InvalidJob` for one that is not there any more."""
        if key not in self._names:
            raise InvalidJob("These files are gone: only the last few are held. Make them again.")
        return {name: self._folder / key / name for name in self._names[key]}

    def archive(self, key: str) -> bytes:
        """All files of a key as a zip archive. Raises as `files`."""
        return zip_bytes({name: path.read_bytes() for name, path in self.files(key).items()})

    def keep(self, key: str, into: Path) -> None:
        """Write all files of a key into a folder. Raises `InvalidJob` as `files` and `write`."""
        require_folder(into)
        found = {name: path.read_bytes() for name, path in self.files(key).items()}
        write(Made(found, {}, ()), into)
