"""The stock that the page offers: sheets, cutters, printers and print materials.

They are the shipped ones and the user's own, by name, and those whose TOML files are in the
studio's folder.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Literal

from fab.catalogue import described, known_of
from fab.errors import InvalidJob
from fab.preferences import preferences
from fab.settings import toml_of

__all__ = ["KINDS", "Kind", "names_of", "stock", "usual_names"]

Kind = Literal["sheet", "cutter", "print", "printer"]
KINDS: tuple[Kind, ...] = ("sheet", "cutter", "print", "printer")
# Files of the folder that are looked into, and how large those are at most.
_MOST_FILES, _MOST_BYTES = 500, 100_000
# Keys by which a file is known that does not name its kind.
_KNOWN_BY: Mapping[str, Kind] = {"density_kg_m3": "sheet", "kerf_mm": "cutter"}


def stock(folder: Path) -> dict[str, list[dict[str, Any]]]:
    """What there is of each kind: name, description, and whether it is a file of the folder."""
    texts = {**described("materials"), **described("machines")}
    found: dict[str, list[dict[str, Any]]] = {
        kind: [{"name": name, "text": texts[name][1], "own": False} for name in known_of(kind)]
        for kind in KINDS
    }
    for kind, name, text in _files(folder):
        found[kind].append({"name": name, "text": text, "own": True})
    return found


def usual_names() -> dict[str, str | None]:
    """What the user mostly takes, by names of preferences; nothing where their file is faulty."""
    try:
        return preferences().model_dump()
    except InvalidJob:
        return {}


def names_of(kind: Kind, folder: Path) -> tuple[str, ...]:
    """Names of the known ones of a kind, then those of files in the folder."""
    own = (name for found, name, _ in _files(folder) if found == kind)
    return (*known_of(kind), *own)


def _files(folder: Path) -> Iterator[tuple[Kind, str, str]]:
    """Kind, name and description of every file of the folder that is of some kind."""
    for path in sorted(folder.glob("*.toml"))[:_MOST_FILES]:
        try:
            if path.is_symlink() or path.stat().st_size > _MOST_BYTES:
                continue
            document = toml_of(path.read_text(encoding="utf-8-sig"))
        except (OSError, ValueError, RecursionError):
            continue  # whatever it is, it is none of these
        kind = document.get("kind") or next(
            (kind for key, kind in _KNOWN_BY.items() if key in document), None
        )
        if kind in KINDS:
            yield kind, path.name, str(document.get("description", ""))
