"""Files that are dropped on the page: kept in the studio's folder, as a surface or a pattern."""

from __future__ import annotations

import re
from itertools import count
from pathlib import Path
from typing import Any

from fab.errors import InvalidFile
from fab.files import shortened
from fab.formats.reading import READ
from fab.outputs import Made, write

__all__ = ["MOST_DROPPED", "kept_file"]

MOST_DROPPED = 50_000_000
_SURFACES = (".stl", ".obj", ".ply", ".off", ".3mf", ".glb", ".step", ".stp")
_PATTERNS = tuple(ending for ending in READ if ending not in _SURFACES)
_JOB = """name = "{name}"

[design]
kind = "surface_fit"
surface = "{file}"
method = "relax"         # all vertices at once, onto surfaces of any shape
columns = 20             # quads around it

[sheet]
folded_width_mm = 200.0
"""


def kept_file(folder: Path, name: str, data: bytes) -> dict[str, Any]:
    """Write a file into the folder under a free name near its own: its name, and what it is.

    Surfaces come with the text of a job that follows them. Raises `InvalidFile` for other kinds.
    """
    ending = Path(name).suffix.lower()
    if ending not in (*_SURFACES, *_PATTERNS):
        raise InvalidFile(
            f"{shortened(name)!r} must end in one of {', '.join((*_SURFACES, *_PATTERNS))}."
        )
    stem = re.sub(r"[^A-Za-z0-9_-]+", "_", Path(name).stem).strip("_-")[:80] or "dropped"
    for number in count(1):
        file = f"{stem}{ending}" if number == 1 else f"{stem}_{number}{ending}"
        path = folder / file
        if not path.exists() and not path.is_symlink():
            write(Made({file: data}, {}, ()), folder)
            break
        if path.is_file() and not path.is_symlink() and path.read_bytes() == data:
            break
    text = _JOB.format(name=Path(file).stem, file=file) if ending in _SURFACES else None
    return {"file": file, "text": text}
