"""Attributes of SVG elements that must be lengths, refused where they are none."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

from fab.errors import InvalidFile
from fab.formats.source_files import shown
from fab.formats.svg.viewports import is_length, numbers

__all__ = ["require_lengths"]

_PLACE = ("x", "y", "width", "height")
_LENGTHS = {
    "svg": _PLACE,
    "symbol": _PLACE,
    "use": _PLACE,
    "rect": (*_PLACE, "rx", "ry"),
    "circle": ("cx", "cy", "r"),
    "ellipse": ("cx", "cy", "rx", "ry"),
    "line": ("x1", "y1", "x2", "y2"),
}
# Of them, those that CSS lets a program work out.
_AUTOMATIC = frozenset({"width", "height", "rx", "ry"})
_BOXED = frozenset({"svg", "symbol"})


def require_lengths(path: Path, name: str, tag: str, attributes: Mapping[str, str]) -> None:
    """Raise `InvalidFile` for an attribute of an element that is given and cannot be read.

    name : of the element, for the message. tag : its kind. A viewBox must be four numbers, of which
    the last two, its width and height, are over 0.
    """
    for key in _LENGTHS.get(tag, ()):
        text = attributes.get(key)
        if text is None or is_length(text) or (key in _AUTOMATIC and text.strip() == "auto"):
            continue
        raise InvalidFile(
            f"{path}: {key} = {shown(text)} of {name} is no length. Give a number, or a number "
            "with a unit such as mm or %."
        )
    box = attributes.get("viewBox") if tag in _BOXED else None
    if box is not None and not _is_box(box):
        raise InvalidFile(
            f"{path}: viewBox = {shown(box)} of {name} is no rectangle. Give four numbers: "
            "left, top, and a width and a height over 0."
        )


def _is_box(text: str) -> bool:
    values = numbers(text)
    parts = text.replace(",", " ").split()
    return (
        len(values) == len(parts) == 4
        and all(map(math.isfinite, values))
        and all(map(is_length, parts))
        and min(values[2:]) > 0
    )
