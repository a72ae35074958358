"""Transforms of SVG: those of attributes, without units, and those of CSS, which need them."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from functools import lru_cache

from fab.formats.svg.viewports import ABSOLUTE_PX, IDENTITY, NUMBER, Matrix

__all__ = ["attribute_transform", "product", "style_transform"]

_FUNCTION = re.compile(r"\s*(?:,\s*)?([a-zA-Z]+)\s*\(([^()]*)\)")
_STYLE_FUNCTION = re.compile(r"\s*([a-zA-Z]+)\(([^()]*)\)")
_VALUE = re.compile(rf"\s*(?:,\s*)?({NUMBER})")
_WITH_UNIT = re.compile(rf"({NUMBER})([a-zA-Z]*)")
_TURN_DEG = {"deg": 1.0, "grad": 0.9, "rad": 180 / math.pi, "turn": 360.0}
# What resets a property, and the word for no transform.
_WITHOUT = frozenset({"", "none"})
_RESET = frozenset({"initial", "unset", "revert", "revert-layer"})
# How many numbers each function takes in an attribute.
_COUNTS = {
    "matrix": (6,),
    "translate": (1, 2),
    "scale": (1, 2),
    "rotate": (1, 3),
    "skewx": (1,),
    "skewy": (1,),
}
# What each number of a function is in CSS: a number, a length or an angle; optional ones last.
_STYLE_KINDS = {
    "matrix": ("nnnnnn", 6),
    "translate": ("ll", 1),
    "translatex": ("l", 1),
    "translatey": ("l", 1),
    "scale": ("nn", 1),
    "scalex": ("n", 1),
    "scaley": ("n", 1),
    "rotate": ("a", 1),
    "skew": ("aa", 1),
    "skewx": ("a", 1),
    "skewy": ("a", 1),
}


def product(outer: Matrix, inner: Matrix) -> Matrix:
    """The matrix of the inner transform, then the outer one."""
    if inner == IDENTITY:
        return outer
    a, b, c, d, e, f = outer
    p, q, r, s, t, u = inner
    return (
        a * p + c * q,
        b * p + d * q,
        a * r + c * s,
        b * r + d * s,
        a * t + c * u + e,
        b * t + d * u + f,
    )


@lru_cache(maxsize=4096)
def attribute_transform(text: str) -> Matrix | None:
    """The matrix of a transform attribute; None where it cannot be read, as with units.

    >>> attribute_transform("translate(3 4)"), attribute_transform("translate(3mm 4)")
    ((1.0, 0.0, 0.0, 1.0, 3.0, 4.0), None)
    """
    if text.strip().lower() in _WITHOUT:
        return IDENTITY
    return _composed(text, _FUNCTION, _attribute_function)


@lru_cache(maxsize=4096)
def style_transform(text: str) -> Matrix | None:
    """The matrix of the property transform of CSS; None where it cannot be read.

    Lengths and angles have a unit unless they are 0, and commas are between them. Percentages and
    lengths that depend on a font are not read.

    >>> style_transform("translate(1in, 0)"), style_transform("translate(1in 0)")
    ((1.0, 0.0, 0.0, 1.0, 96.0, 0.0), None)
    """
    if text.strip().lower() in _WITHOUT | _RESET:
        return IDENTITY
    return _composed(text, _STYLE_FUNCTION, _style_function)


def _composed(
    text: str, function: re.Pattern[str], matrix_of: Callable[[str, str], Matrix | None]
) -> Matrix | None:
    """The product of a list of functions; None where one of them, or what is between, is none."""
    plain = text.strip()
    if plain.startswith(","):
        return None
    out, at = IDENTITY, 0
    while at < len(plain):
        found = function.match(plain, at)
        matrix = matrix_of(found[1].lower(), found[2].strip()) if found else None
        if found is None or matrix is None:
            return None
        out, at = product(out, matrix), found.end()
    return out if all(map(math.isfinite, out)) else None


def _attribute_function(name: str, text: str) -> Matrix | None:
    values = _plain_values(text)
    if values is None or len(values) not in _COUNTS.get(name, ()):
        return None
    if name == "rotate" and len(values) == 3:
        turn, x, y = values
        moved = product((1.0, 0.0, 0.0, 1.0, x, y), _matrix(name, [turn]))
        return product(moved, (1.0, 0.0, 0.0, 1.0, -x, -y))
    return _matrix(name, values)


def _plain_values(text: str) -> list[float] | None:
    """Numbers between blanks or commas; None where there is anything else."""
    if text.startswith(","):
        return None
    values, at = [], 0
    while at < len(text):
        found = _VALUE.match(text, at)
        if found is None:
            return None
        values.append(float(found[1]))
        at = found.end()
    return values


def _style_function(name: str, text: str) -> Matrix | None:
    kinds, least = _STYLE_KINDS.get(name, ("", 1))
    parts = text.split(",")
    if not least <= len(parts) <= len(kinds):
        return None
    values = []
    for kind, part in zip(kinds, parts, strict=False):
        value = _style_value(kind, part.strip())
        if value is None:
            return None
        values.append(value)
    return _matrix(name, values)


def _style_value(kind: str, text: str) -> float | None:
    """A number, a length in px or an angle in degrees of CSS; None where it is none."""
    found = _WITH_UNIT.fullmatch(text)
    if found is None:
        return None
    value, unit = float(found[1]), found[2].lower()
    units = {"n": {"": 1.0}, "l": ABSOLUTE_PX, "a": _TURN_DEG}[kind]
    if not unit and value == 0:
        return 0.0
    return value * units[unit] if unit in units else None


def _matrix(name: str, values: list[float]) -> Matrix:
    first, second = values[0], values[1] if len(values) > 1 else None
    match name:
        case "matrix":
            a, b, c, d, e, f = values
            return (a, b, c, d, e, f)
        case "translate" | "translatex":
            return (1.0, 0.0, 0.0, 1.0, first, second or 0.0)
        case "translatey":
            return (1.0, 0.0, 0.0, 1.0, 0.0, first)
        case "scale":
            return (first, 0.0, 0.0, first if second is None else second, 0.0, 0.0)
        case "scalex":
            return (first, 0.0, 0.0, 1.0, 0.0, 0.0)
        case "scaley":
            return (1.0, 0.0, 0.0, first, 0.0, 0.0)
        case "rotate":
            return _rotation(first)
        case "skewy":
            return (1.0, _tangent(first), 0.0, 1.0, 0.0, 0.0)
    return (1.0, _tangent(second or 0.0), _tangent(first), 1.0, 0.0, 0.0)


def _rotation(degrees: float) -> Matrix:
    turn = math.radians(degrees) if math.isfinite(degrees) else math.nan
    cosine, sine = math.cos(turn), math.sin(turn)
    return (cosine, sine, -sine, cosine, 0.0, 0.0)


def _tangent(degrees: float) -> float:
    return math.tan(math.radians(degrees)) if math.isfinite(degrees) else math.nan
