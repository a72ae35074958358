"""Crease patterns among the frames of a FOLD file: which are the same, and which say more."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

__all__ = ["SheetFrames", "sheet_frames"]

_Frame = dict[str, Any]
# All that is read of a flat sheet.
_KEYS = (
    "frame_unit",
    "vertices_coords",
    "edges_vertices",
    "edges_assignment",
    "edges_foldAngle",
    "faces_vertices",
    "faceOrders",
)
_Content = tuple[bytes | None, ...]


@dataclass(frozen=True)
class SheetFrames:
    """Frames that are crease patterns of their own, in the order of the file.

    Attributes
    ----------
    numbers : of their frames.
    same : for every frame of a crease pattern, the first that has the same.
    contents : what each of `numbers` holds of each key, None where it holds nothing.
    """

    numbers: list[int]
    same: dict[int, int]
    contents: dict[int, _Content]

    def fullest(self) -> int:
        """The frame of the first crease pattern, or of the first that says more of the same one."""
        found = self.numbers[0]
        for number in self.numbers[1:]:
            if self.says_all_of(number, found):
                found = number
        return found

    def says_all_of(self, number: int, other: int) -> bool:
        """Whether a frame has all that another one has, as it has it."""
        pairs = zip(self.contents[number], self.contents[other], strict=True)
        return all(theirs in (None, own) for own, theirs in pairs)

    def added(self, number: int, other: int) -> list[str]:
        """Keys that a frame has, and another one lacks."""
        triples = zip(_KEYS, self.contents[number], self.contents[other], strict=True)
        return [key for key, own, theirs in triples if own is not None and theirs is None]


def sheet_frames(frames: list[_Frame], flat: Iterable[int]) -> SheetFrames:
    """The crease patterns among `frames`, which have what they inherit.

    flat : numbers of the frames of crease patterns, ascending.
    """
    candidates = list(flat)
    if len(candidates) < 2:  # nothing to compare
        empty: _Content = (None,) * len(_KEYS)
        return SheetFrames(candidates, {n: n for n in candidates}, dict.fromkeys(candidates, empty))
    known: dict[tuple[str, int], bytes | None] = {}  # what is inherited is one object
    first: dict[_Content, int] = {}
    same = {}
    for number in candidates:
        content = []
        for key in _KEYS:
            value = frames[number].get(key)
            place = (key, id(value))
            if place not in known:
                known[place] = _digest(key, value)
            content.append(known[place])
        same[number] = first.setdefault(tuple(content), number)
    return SheetFrames(list(first.values()), same, {n: content for content, n in first.items()})


def _digest(key: str, value: Any) -> bytes | None:
    """What tells a value of a key from others; None where it says nothing."""
    if value in (None, []) or (key == "frame_unit" and value == "unit"):
        return None
    told = hashlib.blake2b(digest_size=16)
    for row in value if isinstance(value, list) else [[value]]:
        plain = [_plain(each) for each in row] if isinstance(row, list) else _plain(row)
        if key == "vertices_coords" and isinstance(plain, list) and plain[2:] == [0]:
            plain = plain[:2]
        told.update(repr(plain).encode("utf-8", "surrogatepass") + b"\n")
    return told.digest()


def _plain(value: Any) -> Any:
    """A number without its kind, 1 for 1.0; no more than the type of what no row should hold."""
    if isinstance(value, float) and value.is_integer():
        return int(value)
    return type(value).__name__ if isinstance(value, list | dict) else value
