"""JSON files of other programs, refused where they are too large, or would not fit into memory."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from fab.errors import InvalidFile
from fab.formats.free_memory import free_bytes
from fab.formats.source_files import source_bytes

__all__ = ["memory_needed", "read_json"]

# What each byte of a file, each of its objects, keys and lists, and each of their values take, in
# bytes, while it is parsed.
_PER_BYTE, _PER_OBJECT, _PER_KEY, _PER_LIST, _PER_VALUE = 3, 100, 150, 90, 70


def read_json(path: Path, largest: int) -> dict[str, Any]:
    """The object that a JSON file of up to `largest` bytes holds.

    Raises `InvalidFile` for other files, and for those that would take more memory than is free,
    which is found before they are parsed.
    """
    data = source_bytes(path, largest)
    needed, free = memory_needed(data), free_bytes()
    if free is not None and needed > free:
        raise InvalidFile(
            f"{path}: would take about {needed / 1e9:.3g} GB of memory, and {free / 1e9:.3g} GB "
            "are free. Split the model, or close other programs."
        )
    try:
        document = json.loads(data.decode("utf-8-sig"))
    except (ValueError, RecursionError) as error:  # not JSON, not UTF-8, or endless digits
        raise InvalidFile(f"{path}: not a JSON file: {error}. Save it again.") from error
    if not isinstance(document, dict):
        raise InvalidFile(f"{path}: it must hold one JSON object, and holds something else.")
    return document


def memory_needed(data: bytes) -> int:
    """The most bytes that the JSON in `data` takes while it is read.

    >>> memory_needed(b'{"a": [1, 2]}')
    589
    """
    objects, lists = data.count(b"{"), data.count(b"[")
    values = data.count(b",") + objects + lists
    of_objects = _PER_OBJECT * objects + _PER_KEY * data.count(b":")
    return _PER_BYTE * len(data) + of_objects + _PER_LIST * lists + _PER_VALUE * values
