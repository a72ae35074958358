"""Axes of a sweep: the values that a key of the job takes, listed, stepped or drawn at random."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, TypeAlias

import numpy as np
from pydantic import Field, model_validator

from fab.errors import InvalidJob
from fab.settings import Settings, checked

__all__ = ["MOST_AXES", "MOST_VALUES", "Axis", "Value", "axes_of"]

Value: TypeAlias = int | float | str | bool
MOST_VALUES = 100_000
MOST_AXES = 50
# Whole numbers of the tables have 64 bits; differences of others must not overflow.
_MOST_WHOLE, _MOST = 2**63 - 1, 1e300
_DIGITS = 12


@dataclass(frozen=True)
class Axis:
    """A key of the job, such as "design.fold_deg", and its values in their order.

    drawn : from which a Latin hypercube takes values between the listed ones; None for values that
        lie on no line, such as names.
    """

    key: str
    values: tuple[Value, ...]
    drawn: tuple[float, float] | None = None

    def between(self, share: float) -> Value:
        """The value at a share from 0 to 1 of the axis: between its ends, or one of its values."""
        if self.drawn is None:
            return self.values[min(int(share * len(self.values)), len(self.values) - 1)]
        low, high = self.drawn
        if all(isinstance(value, int) for value in self.values):
            return min(int(low + share * (high - low + 1)), int(high))
        return low + share * (high - low)


class _Steps(Settings):
    """Values at equal distances."""

    first: int | float = Field(alias="from", description="the first value")
    last: int | float = Field(alias="to", description="the last value")
    steps: int = Field(ge=2, le=MOST_VALUES, description="how many values, both ends among them")

    @model_validator(mode="after")
    def _apart(self) -> _Steps:
        if self.first == self.last:
            raise ValueError(f"from and to are both {self.first}: write [{self.first}]")
        return self

    @property
    def ends(self) -> tuple[int | float, int | float]:
        return self.first, self.last

    def values(self, *, whole: bool) -> tuple[Value, ...]:
        if not whole:
            spread = np.linspace(self.first, self.last, self.steps).tolist()
            # 0.3 and not 0.30000000000000004, which no condition on the table would find
            inner = (float(f"{value:.{_DIGITS}g}") for value in spread[1:-1])
            return (float(self.first), *inner, float(self.last))
        first, last = int(self.first), int(self.last)
        step, rest = divmod(last - first, self.steps - 1)
        if rest:
            fit = _counts_near(abs(last - first), self.steps)
            raise InvalidJob(
                f"from {first} to {last} in {self.steps} steps are no whole numbers. "
                f"Take steps = {fit}, or other ends."
            )
        return tuple(range(first, last + (1 if step > 0 else -1), step))


def _counts_near(length: int, steps: int) -> str:
    """How many whole numbers at equal distances fit, fewer and more than so many.

    >>> _counts_near(10, 5), _counts_near(3, 9)
    ('3 or 6', '4')
    """
    fits = [count + 1 for count in range(1, min(length, MOST_VALUES) + 1) if length % count == 0]
    fewer = [count for count in fits if count < steps]
    more = [count for count in fits if count > steps]
    return " or ".join(map(str, [*fewer[-1:], *more[:1]]))


class _Random(Settings):
    """Values drawn at random, evenly, the same for the same seed."""

    random: Annotated[list[int | float], Field(min_length=2, max_length=2)] = Field(
        description="lowest and highest, such as [20.0, 70.0]"
    )
    count: int = Field(ge=1, le=MOST_VALUES, description="how many values")
    seed: int = Field(default=0, ge=0, description="of the random numbers")

    @model_validator(mode="after")
    def _ordered(self) -> _Random:
        if self.random[0] >= self.random[1]:
            raise ValueError(f"random = {self.random} must have the lower value first")
        return self

    @property
    def ends(self) -> tuple[int | float, int | float]:
        return self.random[0], self.random[1]

    def values(self, *, whole: bool) -> tuple[Value, ...]:
        low, high = self.random
        numbers = np.random.default_rng(self.seed)
        if whole:
            return tuple(numbers.integers(int(low), int(high), self.count, endpoint=True).tolist())
        return tuple(numbers.uniform(low, high, self.count).tolist())


def axes_of(
    table: Mapping[str, Any], source: str, types: Callable[[str], Sequence[Any]] | None = None
) -> tuple[Axis, ...]:
    """The axes of the table `[axes]`, in its order. Raises `InvalidJob` with the axis at fault.

    types : those that a key takes. Values are whole numbers for keys that take nothing else, and
        any for keys that take any; where that is not known, values between whole numbers are whole.

    >>> table = {"design": {"fold_deg": [30.0, 60.0], "rows": {"from": 2, "to": 6, "steps": 3}}}
    >>> [(axis.key, axis.values) for axis in axes_of(table, "sweep.toml")]
    [('design.fold_deg', (30.0, 60.0)), ('design.rows', (2, 4, 6))]
    >>> axes_of({"angle_deg": [30, 60]}, "sweep.toml", lambda key: [float])[0].values
    (30.0, 60.0)
    """
    leaves = list(_leaves(table))
    if not leaves:
        raise InvalidJob(
            f"{source}: axes is empty. Name a key of the job and its values, such as "
            "design.fold_deg = [30.0, 60.0]."
        )
    if len(leaves) > MOST_AXES:
        raise InvalidJob(f"{source}: has {len(leaves)} axes, must have at most {MOST_AXES}.")
    ((key, count),) = Counter(key for key, _ in leaves).most_common(1)
    if count > 1:
        raise InvalidJob(
            f"{source}: axes.{key} is there {count} times, with dots and as a table. Give it once."
        )
    return tuple(
        _axis(key, given, source, types(key) if types is not None else ()) for key, given in leaves
    )


def _leaves(table: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, Any]]:
    for key, value in table.items():
        if isinstance(value, Mapping) and not {"from", "to", "steps", "random"} & set(value):
            yield from _leaves(value, f"{above}{key}.")
        else:
            yield above + key, value


def _axis(key: str, given: Any, source: str, types: Sequence[Any]) -> Axis:
    place = f"{source}: axes.{key}"
    if not isinstance(given, Mapping):
        values = _fitting(_listed(given, place), types)
        return Axis(key, values, _spread(values))
    model: type[_Steps] | type[_Random] = _Random if "random" in given else _Steps
    steps = checked(model, given, place, "Give from, to and steps, or random and count.")
    whole = _are_whole(steps.ends, types, place)
    low, high = sorted(_bounded(int(end) if whole else end, place) for end in steps.ends)
    try:
        values = steps.values(whole=whole)
    except InvalidJob as error:
        raise InvalidJob(f"{place}: {error}") from error
    return Axis(key, values, (low, high))


def _are_whole(ends: Sequence[int | float], types: Sequence[Any], place: str) -> bool:
    """Whether values between these ends are whole numbers."""
    if float in types:
        return False
    if int in types:
        for end in ends:
            if end != int(end):
                raise InvalidJob(f"{place}: {end} must be a whole number, as the key takes.")
        return True
    return all(isinstance(end, int) for end in ends)


def _fitting(values: Sequence[Value], types: Sequence[Any]) -> tuple[Value, ...]:
    """Numbers as a key takes them: 30 is 30.0 where it takes any, and 4.0 is 4 where whole ones."""
    if float in types:
        return tuple(float(v) if type(v) is int else v for v in values)
    if int in types:
        return tuple(int(v) if type(v) is float and v == int(v) else v for v in values)
    return tuple(values)


def _bounded(value: int | float, place: str) -> int | float:
    most = _MOST_WHOLE if isinstance(value, int) else _MOST
    if abs(value) > most:
        shown = "a whole number of that many digits" if isinstance(value, int) else f"{value:g}"
        raise InvalidJob(f"{place}: {shown} is out of bounds: it must be within +-{most}.")
    return value


def _listed(given: Any, place: str) -> tuple[Value, ...]:
    if not isinstance(given, Sequence) or isinstance(given, str):
        raise InvalidJob(
            f"{place} = {given!r}: must be a list of values, {{ from, to, steps }} or "
            "{ random, count, seed }."
        )
    if not 1 <= len(given) <= MOST_VALUES:
        raise InvalidJob(f"{place}: has {len(given)} values, must have 1 to {MOST_VALUES}.")
    for value in given:
        if not isinstance(value, Value):
            raise InvalidJob(f"{place}: {value!r} must be a number, text, true or false.")
        if isinstance(value, float) and not np.isfinite(value):
            raise InvalidJob(f"{place}: {value} must be finite.")
        if isinstance(value, int):
            _bounded(value, place)
    counts = Counter(given)
    repeated = [value for value in given if counts[value] > 1]
    if repeated:
        raise InvalidJob(f"{place}: {repeated[0]!r} is listed twice. Name each value once.")
    return tuple(given)


def _spread(values: Sequence[Any]) -> tuple[float, float] | None:
    numbers = all(isinstance(v, int | float) and not isinstance(v, bool) for v in values)
    return (min(values), max(values)) if numbers and len(values) > 1 else None
