"""Bytes and text of files of other programs, refused where they are too large or no such files."""

from __future__ import annotations

import codecs
import unicodedata
from pathlib import Path

from fab.errors import InvalidFile

__all__ = ["decoded", "shown", "source_bytes", "source_text"]

# A longer piece of a file is shortened in messages.
_SHOWN = 40
_MARKS = (
    (codecs.BOM_UTF8, "utf-8-sig"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)


def source_bytes(path: Path, largest: int) -> bytes:
    """The content of a file. Raises `InvalidFile` for none, an empty one, and over `largest` bytes.

    The size is looked at before anything is read.
    """
    try:
        if path.exists() and not path.is_file():
            raise InvalidFile(f"{path}: not a file. Give the path of a drawing.")
        size = path.stat().st_size
        if size > largest:
            raise InvalidFile(
                f"{path}: {size} bytes are over the bound of {largest}. Split the drawing, or "
                "leave out of it what is no crease and no border."
            )
        data = path.read_bytes()
    except OSError as error:
        raise InvalidFile(f"{path}: cannot be read: {error.strerror}. Check the path.") from error
    except ValueError as error:  # a path with a NUL character
        raise InvalidFile(f"{shown(str(path))}: cannot be read: {error}.") from error
    if not data.strip():
        raise InvalidFile(f"{path}: the file is empty. Export it again.")
    return data


def source_text(path: Path, largest: int) -> str:
    """The content of a text file of up to `largest` bytes, decoded as `decoded` does."""
    return decoded(path, source_bytes(path, largest))


def decoded(path: Path, data: bytes, encodings: tuple[str, ...] = ("utf-8", "cp1252")) -> str:
    """The text of bytes: by their byte-order mark, or the first encoding that they fit.

    Raises `InvalidFile` for what is no text: NUL bytes, none of the encodings, or nothing at all.
    """
    named = [encoding for mark, encoding in _MARKS if data.startswith(mark)]
    for encoding in named or encodings:
        try:
            text = data.decode(encoding)
        except UnicodeError:
            continue
        if not text.strip():  # blank in its own letters: bytes alone do not show that
            raise InvalidFile(f"{path}: the file is empty. Export it again.")
        if "\0" not in text:
            return text
    raise InvalidFile(f"{path}: not a text file. Export it again, or rename it by what it is.")


def shown(text: str) -> str:
    """A piece of a file for a message: in quotes, short, without control characters."""
    plain = "".join("?" if unicodedata.category(c).startswith("C") else c for c in text)
    short = plain if len(plain) <= _SHOWN else plain[: _SHOWN - 1] + "…"
    return f"'{short}'"
