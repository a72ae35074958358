"""What goes wrong, and how is it said: value, bound and cure."""

from __future__ import annotations

import math

__all__ = ["InvalidValue", "OrigamiError", "require_at_least", "require_positive", "require_within"]


class OrigamiError(Exception):
    """Base of every error that this project raises on purpose."""


class InvalidValue(OrigamiError, ValueError):
    """An argument lies outside its bound.

    The message names the value, the bound and the cure; the parts stay readable
    as the attributes `name`, `value`, `bound` and `cure`.
    """

    def __init__(self, name: str, value: object, bound: str, cure: str) -> None:
        super().__init__(f"{name} = {value} is out of bounds: it must {bound}. {cure}")
        self.name = name
        self.value = value
        self.bound = bound
        self.cure = cure


def require_positive(name: str, value: float, cure: str = "Give a positive number.") -> None:
    """Raise `InvalidValue` unless `value` is finite and greater than zero."""
    if not (math.isfinite(value) and value > 0):
        raise InvalidValue(name, value, "be finite and greater than 0", cure)


def require_at_least(name: str, value: int, least: int, cure: str) -> None:
    """Raise `InvalidValue` unless the count `value` is at least `least`."""
    if value < least:
        raise InvalidValue(name, value, f"be at least {least}", cure)


def require_within(
    name: str, value: float, low: float, high: float, cure: str, *, angle: bool = False
) -> None:
    """Raise `InvalidValue` unless low < value < high (all in radians where `angle`)."""
    if low < value < high:
        return

    def say(x: float) -> str:
        return f"{x:.9g} rad ({math.degrees(x):.7g} deg)" if angle else f"{x:.9g}"

    raise InvalidValue(name, say(value), f"lie between {say(low)} and {say(high)}", cure)
