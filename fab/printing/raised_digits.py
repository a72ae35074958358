"""Numbers that a printer raises on a plate, in digits of seven straight strokes."""

from __future__ import annotations

import shapely

__all__ = ["number_outline"]

# Strokes of a digit in a cell 1 wide and 2 high, as boxes from one corner to the other in units of
# half a cell: a top, b and c right, d bottom, e and f left, g middle.
_STROKES = {
    "a": ((0, 4), (2, 4)),
    "b": ((2, 2), (2, 4)),
    "c": ((2, 0), (2, 2)),
    "d": ((0, 0), (2, 0)),
    "e": ((0, 0), (0, 2)),
    "f": ((0, 2), (0, 4)),
    "g": ((0, 2), (2, 2)),
}
_DIGITS = {
    "0": "abcdef",
    "1": "bc",
    "2": "abged",
    "3": "abgcd",
    "4": "fgbc",
    "5": "afgcd",
    "6": "afgedc",
    "7": "abc",
    "8": "abcdefg",
    "9": "abcdfg",
}
# Widths of a digit and of the space between two, in strokes.
_CELL, _SPACE = 4.0, 1.5


def number_outline(number: int, stroke_mm: float) -> shapely.Geometry:
    """The plan of a number of 0 and more, its lower left corner at (0, 0).

    stroke_mm : width of its lines; digits are four of them wide and seven high.

    >>> number_outline(25, 1.0).bounds
    (0.0, 0.0, 9.5, 7.0)
    """
    boxes, x = [], 0.0
    for letter in str(number):
        half = (_CELL - 1.0) / 2
        for name in _DIGITS[letter]:
            (left, low), (right, high) = _STROKES[name]
            boxes.append(
                shapely.box(x + left * half, low * half, x + right * half + 1.0, high * half + 1.0)
            )
        x += _CELL + _SPACE
    outline = shapely.union_all(boxes)
    low_x, low_y, _, _ = outline.bounds
    return shapely.transform(outline, lambda points: (points - [low_x, low_y]) * stroke_mm)
