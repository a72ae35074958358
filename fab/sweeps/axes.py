"""Axes of a sweep: the values that a key of the job takes, listed, stepped or drawn at random."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, TypeAlias

import numpy as np
from pydantic import Field, model_validator

from fab.errors import InvalidJob
from fab.settings import Settings, checked

__all__ = ["Axis", "Value", "axes_of"]

Value: TypeAlias = int | float | str | bool
_MOST_VALUES = 100_000
_MOST_AXES = 50


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
    steps: int = Field(ge=2, le=_MOST_VALUES, description="how many values, both ends among them")

    def values(self) -> tuple[Value, ...]:
        spread = np.linspace(self.first, self.last, self.steps).tolist()
        if isinstance(self.first, int) and isinstance(self.last, int):
            if (self.last - self.first) % (self.steps - 1):
                raise InvalidJob(
                    f"from {self.first} to {self.last} in {self.steps} steps are no whole numbers. "
                    f"Write {self.first}.0 where fractions are meant, or take other steps."
                )
            return tuple(round(value) for value in spread)
        return tuple(spread)


class _Random(Settings):
    """Values drawn at random, evenly, the same for the same seed."""

    random: Annotated[list[int | float], Field(min_length=2, max_length=2)] = Field(
        description="lowest and highest, such as [20.0, 70.0]"
    )
    count: int = Field(ge=1, le=_MOST_VALUES, description="how many values")
    seed: int = Field(default=0, ge=0, description="of the random numbers")

    @model_validator(mode="after")
    def _ordered(self) -> _Random:
        if self.random[0] >= self.random[1]:
            raise ValueError(f"random = {self.random} must have the lower value first")
        return self

    def values(self) -> tuple[Value, ...]:
        low, high = self.random
        numbers = np.random.default_rng(self.seed)
        if isinstance(low, int) and isinstance(high, int):
            return tuple(numbers.integers(low, high, self.count, endpoint=True).tolist())
        return tuple(numbers.uniform(low, high, self.count).tolist())


def axes_of(table: Mapping[str, Any], source: str) -> tuple[Axis, ...]:
    """The axes of the table `[axes]`, in its order. Raises `InvalidJob` with the axis at fault.

    >>> table = {"design": {"fold_deg": [30.0, 60.0], "rows": {"from": 2, "to": 6, "steps": 3}}}
    >>> [(axis.key, axis.values) for axis in axes_of(table, "sweep.toml")]
    [('design.fold_deg', (30.0, 60.0)), ('design.rows', (2, 4, 6))]
    """
    axes = tuple(_axis(key, given, source) for key, given in _leaves(table))
    if not axes:
        raise InvalidJob(
            f"{source}: axes is empty. Name a key of the job and its values, such as "
            "design.fold_deg = [30.0, 60.0]."
        )
    if len(axes) > _MOST_AXES:
        raise InvalidJob(f"{source}: has {len(axes)} axes, must have at most {_MOST_AXES}.")
    return axes


def _leaves(table: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, Any]]:
    for key, value in table.items():
        if isinstance(value, Mapping) and not {"from", "to", "steps", "random"} & set(value):
            yield from _leaves(value, f"{above}{key}.")
        else:
            yield above + key, value


def _axis(key: str, given: Any, source: str) -> Axis:
    place = f"{source}: axes.{key}"
    if isinstance(given, Mapping):
        model: type[_Steps] | type[_Random] = _Random if "random" in given else _Steps
        steps = checked(model, given, place, "Give from, to and steps, or random and count.")
        try:
            values = steps.values()
        except InvalidJob as error:
            raise InvalidJob(f"{place}: {error}") from error
        ends = steps.random if isinstance(steps, _Random) else [steps.first, steps.last]
        return Axis(key, values, (min(ends), max(ends)))
    return Axis(key, _listed(given, place), _spread(given))


def _listed(given: Any, place: str) -> tuple[Value, ...]:
    if not isinstance(given, Sequence) or isinstance(given, str):
        raise InvalidJob(
            f"{place} = {given!r}: must be a list of values, {{ from, to, steps }} or "
            "{ random, count, seed }."
        )
    if not 1 <= len(given) <= _MOST_VALUES:
        raise InvalidJob(f"{place}: has {len(given)} values, must have 1 to {_MOST_VALUES}.")
    for value in given:
        if not isinstance(value, Value):
            raise InvalidJob(f"{place}: {value!r} must be a number, text, true or false.")
        if isinstance(value, float) and not np.isfinite(value):
            raise InvalidJob(f"{place}: {value} must be finite.")
    repeated = [value for number, value in enumerate(given) if value in given[:number]]
    if repeated:
        raise InvalidJob(f"{place}: {repeated[0]!r} is listed twice. Name each value once.")
    return tuple(given)


def _spread(values: Sequence[Any]) -> tuple[float, float] | None:
    numbers = all(isinstance(v, int | float) and not isinstance(v, bool) for v in values)
    return (min(values), max(values)) if numbers and len(values) > 1 else None
