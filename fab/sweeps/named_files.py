"""Files that the values of a job name, such as surfaces, materials and Python files of designs."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

__all__ = ["NamedFiles"]

_LONGEST_NAME = 4096


class NamedFiles:
    """The files beside a job that its texts name, by their content: each is read once.

    Attributes
    ----------
    folder : of the job, where the names of its files begin.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._known: dict[str, str | None] = {}

    def digests(self, document: Mapping[str, Any]) -> dict[str, str]:
        """Hashes of the files that a job names, by its texts: "mine.py:Class" is the file before
        the colon.
        """
        found = {text: self._digest(text) for text in _texts(document)}
        return {text: digest for text, digest in found.items() if digest is not None}

    def _digest(self, text: str) -> str | None:
        if text not in self._known:
            self._known[text] = next(filter(None, map(self._content, _names(text))), None)
        return self._known[text]

    def _content(self, name: str) -> str | None:
        path = os.path.join(self.folder, name)  # noqa: PTH118 - also for names no file can have
        if not os.path.isfile(path):  # noqa: PTH113
            return None
        try:
            with Path(path).open("rb") as stream:
                return hashlib.file_digest(stream, "sha256").hexdigest()
        except OSError:
            return None  # the job says so when it reads it


def _names(text: str) -> list[str]:
    file, colon, _ = text.rpartition(":")
    return [text, file] if colon and file else [text]


def _texts(value: Any) -> Iterator[str]:
    """All texts of nested tables that may be names of files."""
    if isinstance(value, str):
        if 0 < len(value) <= _LONGEST_NAME and "\0" not in value and "\n" not in value:
            yield value
    elif isinstance(value, Mapping):
        for inner in value.values():
            yield from _texts(inner)
    elif isinstance(value, list | tuple):
        for inner in value:
            yield from _texts(inner)
