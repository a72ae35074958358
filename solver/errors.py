"""Errors of misuse, in two forms: a value out of its bound, or an input in an unusable state."""

from __future__ import annotations

import math
from numbers import Integral, Real

__all__ = [
    "InvalidState",
    "InvalidValue",
    "OrigamiError",
    "escaped",
    "require_count",
    "require_finite",
    "require_length",
    "require_number",
    "require_positive",
    "require_within",
]

# Far beyond every sheet that fits into memory, and every length that keeps its digits.
_MOST = 1_000_000
_LENGTHS = (1e-6, 1e6)


def escaped(text: str) -> str:
    r"""The text with escapes for control characters and marks that turn the direction of reading.

    >>> escaped("a\x1b[2J")
    'a\\x1b[2J'
    """
    return "".join(
        letter if letter.isprintable() or letter == "\n" else ascii(letter)[1:-1] for letter in text
    )


class OrigamiError(Exception):
    """Base of every error that this project raises on purpose; its texts are `escaped`."""

    def __init__(self, *arguments: object) -> None:
        super().__init__(*(escaped(x) if isinstance(x, str) else x for x in arguments))


class InvalidValue(OrigamiError, ValueError):
    """An argument is outside its bound.

    The message gives the value, the bound and the cure; the parts stay readable
    as the attributes `name`, `value`, `bound` and `cure`.

    >>> print(InvalidValue("columns", 1, "be at least 2", "Add a column."))
    columns = 1 is out of bounds: it must be at least 2. Add a column.
    """

    def __init__(self, name: str, value: object, bound: str, cure: str) -> None:
        super().__init__(f"{name} = {value} is out of bounds: it must {bound}. {cure}")
        self.name = name
        self.value = value
        self.bound = bound
        self.cure = cure


class InvalidState(InvalidValue):
    """An argument cannot be used as it is, and no single value of it is at fault.

    The message is a sentence and the cure: `name` is the argument, `value` the sentence, and
    `bound` is empty.

    >>> print(InvalidState("front", "the front is open", "Open fronts take any flap angle."))
    the front is open. Open fronts take any flap angle.
    """

    def __init__(self, name: str, sentence: str, cure: str) -> None:
        OrigamiError.__init__(self, f"{sentence}. {cure}")
        self.name = name
        self.value = sentence
        self.bound = ""
        self.cure = cure


def require_number(name: str, value: object) -> None:
    """Raise `InvalidValue` unless `value` is one real number (which may be NaN or infinite)."""
    if not isinstance(value, Real) or isinstance(value, bool):
        raise InvalidValue(name, repr(value), "be a number", "Give one real number.")


def require_positive(name: str, value: float, cure: str = "Give a positive number.") -> None:
    """Raise `InvalidValue` unless `value` is finite and greater than zero."""
    require_number(name, value)
    if not (math.isfinite(value) and value > 0):
        raise InvalidValue(name, value, "be finite and greater than 0", cure)


def require_finite(name: str, value: float) -> None:
    """Raise `InvalidValue` unless `value` is a finite number."""
    require_number(name, value)
    if not math.isfinite(value):
        raise InvalidValue(name, value, "be finite", "Give a number.")


def require_count(name: str, value: int, least: int, cure: str) -> None:
    """Raise `InvalidValue` unless the count `value` is from `least` to a million."""
    if not isinstance(value, Integral) or isinstance(value, bool):
        raise InvalidValue(name, repr(value), "be a whole number", cure)
    if not least <= value <= _MOST:
        raise InvalidValue(name, value, f"be from {least} to {_MOST}", cure)


def require_length(name: str, value: float) -> None:
    """Raise `InvalidValue` unless `value` is a length in design units, 1e-6 to 1e6."""
    require_number(name, value)
    low, high = _LENGTHS
    if not low <= value <= high:
        cure = "Lengths of a design are relative: the sheet's size is set when files are made."
        raise InvalidValue(name, value, f"be from {low:g} to {high:g}", cure)


def require_within(
    name: str, value: float, low: float, high: float, cure: str, *, angle: bool = False
) -> None:
    """Raise `InvalidValue` unless low < value < high (all in radians where `angle`)."""
    require_number(name, value)
    if low < value < high:
        return

    def say(x: float) -> str:
        return f"{x:.9g} rad ({math.degrees(x):.7g} deg)" if angle else f"{x:.9g}"

    raise InvalidValue(name, say(value), f"lie strictly between {say(low)} and {say(high)}", cure)
