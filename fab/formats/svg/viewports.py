"""Lengths and viewports of SVG: from the numbers of a file to places on its page."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

__all__ = [
    "ABSOLUTE_PX",
    "IDENTITY",
    "NUMBER",
    "PX_MM",
    "Matrix",
    "Page",
    "is_length",
    "length_px",
    "numbers",
    "origin_of",
    "page_of",
    "viewport_matrix",
]

# (a, b, c, d, e, f): x' = a x + c y + e, y' = b x + d y + f.
Matrix: TypeAlias = tuple[float, float, float, float, float, float]
IDENTITY: Matrix = (1.0, 0.0, 0.0, 1.0, 0.0, 0.0)

_INCH_MM = 25.4
# A CSS pixel, mm.
PX_MM = _INCH_MM / 96
NUMBER = r"[-+]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][-+]?\d+)?"
_NUMBER = re.compile(NUMBER)
# Fits a text in one way only, so that none takes long to refuse.
_LENGTH = re.compile(rf"({NUMBER})\s*(%|[a-zA-Z]*)")
_PHYSICAL_MM = {
    "mm": 1.0,
    "cm": 10.0,
    "q": 0.25,
    "in": _INCH_MM,
    "pt": _INCH_MM / 72,
    "pc": _INCH_MM / 6,
}
# CSS pixels, which are units of user space, in each unit that depends on nothing else.
ABSOLUTE_PX = {"px": 1.0} | {unit: mm / PX_MM for unit, mm in _PHYSICAL_MM.items()}
# Of the window that shows the drawing.
_OF_WINDOW = frozenset({"vw", "vh", "vmin", "vmax"})
_RELATIVE_PX = {"": 1.0, "px": 1.0, "em": 16.0, "rem": 16.0, "ex": 8.0, "ch": 8.0}


def numbers(text: str) -> list[float]:
    """All numbers of a text such as that of viewBox or points."""
    return [float(found) for found in _NUMBER.findall(text)]


def is_length(text: str) -> bool:
    """Whether a text is a finite number, alone or with a unit of SVG."""
    found = _LENGTH.fullmatch(text.strip())
    if found is None or not math.isfinite(float(found[1])):
        return False
    unit = found[2].lower()
    return unit == "%" or unit in {*_PHYSICAL_MM, *_RELATIVE_PX, *_OF_WINDOW}


def length_px(text: str | None, whole: float, default: float = 0.0) -> float:
    """A length in CSS pixels, the default where it is none; percentages are of `whole`."""
    if text is None:
        return default
    found = _LENGTH.fullmatch(text.strip())
    if found is None:
        return default
    value, unit = float(found[1]), found[2].lower()
    if unit == "%" or unit in _OF_WINDOW:
        return value / 100 * whole
    if unit in _PHYSICAL_MM:
        return value * _PHYSICAL_MM[unit] / PX_MM
    return value * _RELATIVE_PX.get(unit, 1.0)


def origin_of(text: str, size: tuple[float, float]) -> tuple[float, float] | None:
    """The point that a transform-origin names in a viewport of this size; None where it is none.

    >>> origin_of("center", (100.0, 60.0)), origin_of("top 10px", (100.0, 60.0))
    ((50.0, 30.0), (10.0, 0.0))
    """
    words = text.lower().split()[:2]
    if len(words) < 2:
        words.append("center")
    if words[0] in ("top", "bottom") or words[1] in ("left", "right"):
        words.reverse()
    share = {"left": 0.0, "top": 0.0, "center": 0.5, "right": 1.0, "bottom": 1.0}
    x, y = (
        share[word] * whole if word in share else length_px(word, whole, math.nan)
        for word, whole in zip(words, size, strict=True)
    )
    return (x, y) if math.isfinite(x) and math.isfinite(y) else None


def viewport_matrix(
    attributes: Mapping[str, str], width: float, height: float
) -> tuple[Matrix, tuple[float, float]]:
    """From the user space of a viewBox onto a viewport of this size, and the size of that space.

    A missing viewBox is that of the viewport itself.
    """
    box = numbers(attributes.get("viewBox", ""))
    if len(box) != 4 or not (0 < box[2] < math.inf and 0 < box[3] < math.inf):
        return IDENTITY, (width, height)
    x, y, across, up = box
    if not (width > 0 and height > 0):
        return (1.0, 0.0, 0.0, 1.0, -x, -y), (across, up)
    fit = attributes.get("preserveAspectRatio", "").split()
    fit = fit[1:] if fit[:1] == ["defer"] else fit
    align = fit[0] if fit else "xMidYMid"
    sx, sy = width / across, height / up
    if align == "none":
        return (sx, 0.0, 0.0, sy, -x * sx, -y * sy), (across, up)
    scale = max(sx, sy) if fit[1:2] == ["slice"] else min(sx, sy)
    share = {"Min": 0.0, "Mid": 0.5, "Max": 1.0}
    left = share.get(align[1:4], 0.5) * (width - across * scale)
    top = share.get(align[5:8], 0.5) * (height - up * scale)
    return (scale, 0.0, 0.0, scale, left - x * scale, top - y * scale), (across, up)


@dataclass(frozen=True)
class Page:
    """The outermost viewport.

    Attributes
    ----------
    matrix : from user space to the page, in millimetres where `physical`, else in pixels.
    size : of the user space.
    physical : whether the file gives a size in millimetres, inches and the like.
    by_pixels : whether the millimetres follow from pixels, so that their size matters.
    """

    matrix: Matrix
    size: tuple[float, float]
    physical: bool
    by_pixels: bool


def page_of(attributes: Mapping[str, str], px_mm: float) -> Page:
    """The page of an outermost svg element.

    px_mm : size of a pixel of the program that wrote the file.
    """
    box = numbers(attributes.get("viewBox", ""))
    boxed = len(box) == 4 and 0 < box[2] < math.inf and 0 < box[3] < math.inf
    sides = [_side(attributes.get(name)) for name in ("width", "height")]
    physical = [mm for mm, _ in sides]
    pixels = [px for _, px in sides]
    if any(mm is not None for mm in physical):
        width, height = (
            mm if mm is not None else None if px is None else px * px_mm
            for mm, px in zip(physical, pixels, strict=True)
        )
        if not boxed:
            scale = px_mm
            size = ((width or 0.0) / scale, (height or 0.0) / scale)
            return Page((scale, 0.0, 0.0, scale, 0.0, 0.0), size, True, True)
        if width is None:
            width = (height or 0.0) * box[2] / box[3]
        if height is None:
            height = width * box[3] / box[2]
        matrix, size = viewport_matrix(attributes, width, height)
        return Page(matrix, size, True, False)
    width, height = pixels
    if not boxed:
        return Page(IDENTITY, (width or 0.0, height or 0.0), False, True)
    if width is None and height is None:
        width, height = box[2], box[3]
    elif width is None:
        width = (height or 0.0) * box[2] / box[3]
    elif height is None:
        height = width * box[3] / box[2]
    matrix, size = viewport_matrix(attributes, width or 0.0, height or 0.0)
    return Page(matrix, size, False, True)


def _side(text: str | None) -> tuple[float | None, float | None]:
    """A side of the page in mm, or in pixels; neither where it is relative or no length."""
    found = None if text is None else _LENGTH.fullmatch(text.strip())
    if found is None:
        return None, None
    value, unit = float(found[1]), found[2].lower()
    if not 0 < value < math.inf or unit == "%" or unit in _OF_WINDOW:
        return None, None
    if unit in _PHYSICAL_MM:
        return value * _PHYSICAL_MM[unit], None
    return None, value * _RELATIVE_PX.get(unit, 1.0)
