"""Letters of single strokes, as a laser or a pen writes them, from a font of such letters.

The font is Relief SingleLine (SIL Open Font License), which comes with build123d; its contours are
lines to follow, not outlines to fill. It has all of ASCII, and the letters of most European
languages.
"""

from __future__ import annotations

import unicodedata
from dataclasses import dataclass
from functools import cache, lru_cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from solver.errors import InvalidState
from solver.vectors import FloatArray

__all__ = ["letter_strokes", "writable"]

_FILE = "data/fonts/reliefsingleline/ReliefSingleLineCAD-Regular.ttf"
# What stands for letters that the font does not have.
_UNKNOWN = "_"
# Chords of a curve; ends of a line nearer than this share of an em are one point.
_CHORDS = 6
_SAME_EM = 0.006


@dataclass(frozen=True)
class _Glyph:
    """Lines of a letter, each of shape (m, 2), and how far on the next letter begins, in ems."""

    lines: tuple[FloatArray, ...]
    advance: float


def writable(text: str) -> str:
    """The text with "_" for all characters that the font does not have.

    >>> writable("Fälten 300 g/m²"), writable("折り紙")
    ('Fälten 300 g/m²', '___')
    """
    known = _font().getBestCmap()
    plain = unicodedata.normalize("NFC", text)
    return "".join(letter if ord(letter) in known else _UNKNOWN for letter in plain)


@lru_cache(maxsize=4096)
def letter_strokes(text: str) -> tuple[FloatArray, ...]:
    """Open lines of a text, each of shape (m, 2) with m at least 3, capitals one high, from (0, 0).

    Lines that close end where they begin. Straight strokes have a point in their middle, by which
    readers of drawings tell them from creases.
    """
    out = []
    at = 0.0
    for letter in writable(text):
        glyph = _glyph(letter)
        out += [(line + np.array([at, 0.0])) / _capital_em() for line in glyph.lines]
        at += glyph.advance
    return tuple(out)


@cache
def _font() -> Any:
    """The font, read once. Raises `InvalidState` where it is missing."""
    from fontTools.ttLib import TTFont

    spec = find_spec("build123d")
    if spec is None or spec.origin is None:
        raise InvalidState("font", "build123d is not installed", "Install it: it has the font.")
    file = Path(spec.origin).parent / _FILE
    if not file.is_file():
        raise InvalidState("font", f"{file} is missing", "Install build123d again.")
    return TTFont(file)


@cache
def _capital_em() -> float:
    """Height of capitals, in ems."""
    font = _font()
    return float(font["OS/2"].sCapHeight / font["head"].unitsPerEm)


@cache
def _glyph(letter: str) -> _Glyph:
    from fontTools.pens.recordingPen import DecomposingRecordingPen

    font = _font()
    glyphs = font.getGlyphSet()
    glyph = glyphs[font.getBestCmap()[ord(letter)]]
    em = font["head"].unitsPerEm
    pen = DecomposingRecordingPen(glyphs)
    glyph.draw(pen)
    lines: list[list[FloatArray]] = []
    for operator, points in pen.value:
        ends = [np.array(point, np.float64) / em for point in points if point is not None]
        if operator == "moveTo":
            lines.append(ends)
        elif operator == "lineTo":
            lines[-1] += ends
        elif operator == "qCurveTo":
            lines[-1] += _curve(lines[-1][-1], ends)
        elif operator != "closePath":
            raise RuntimeError(f"the font draws {letter!r} by {operator}")
    drawn = tuple(_line(np.array(line)) for line in lines if len(line) > 1)
    return _Glyph(drawn, glyph.width / em)


def _curve(start: FloatArray, points: list[FloatArray]) -> list[FloatArray]:
    """Chords of a run of quadratic curves; on-curve points are in the middle of two controls."""
    out: list[FloatArray] = []
    controls, end = points[:-1], points[-1]
    share = (np.arange(1, _CHORDS + 1) / _CHORDS)[:, None]
    for number, control in enumerate(controls):
        last = number == len(controls) - 1
        stop = end if last else (control + controls[number + 1]) / 2
        out += list((1 - share) ** 2 * start + 2 * share * (1 - share) * control + share**2 * stop)
        start = stop
    return out or [end]


def _line(points: FloatArray) -> FloatArray:
    """A line without points twice, closed where its ends nearly meet, of three points or more."""
    apart = np.abs(np.diff(points, axis=0)).max(axis=1) > 0
    points = points[np.concatenate([[True], apart])]
    if len(points) > 2 and np.abs(points[-1] - points[0]).max() < _SAME_EM:
        points = np.concatenate([points[:-1], points[:1]])
    if len(points) == 2:
        points = np.stack([points[0], points.mean(axis=0), points[1]])
    return points
