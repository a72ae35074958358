"""Variations of a sweep: which values each of them has, without making a list of all of them."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import prod
from typing import Any

import numpy as np

from fab.errors import InvalidJob
from fab.sweeps.axes import Axis, Value, axes_of
from fab.sweeps.constraints import Constraint, constraints_of
from fab.sweeps.sweep_settings import Sweep
from solver.vectors import FloatArray

__all__ = ["MOST", "Variation", "Variations", "hash_of", "variations_of"]

MOST = 10_000_000


@dataclass(frozen=True)
class Variation:
    """A variation of a sweep.

    Attributes
    ----------
    number : in the sweep, from 0.
    values : of the axes by their keys.
    job_hash : of all that decides its row, once it is to be run.
    """

    number: int
    values: Mapping[str, Value]
    job_hash: str = ""


@dataclass(frozen=True)
class Variations:
    """All variations of a sweep, made as they are asked for.

    Attributes
    ----------
    whole : how many there are before constraints.
    """

    axes: tuple[Axis, ...]
    combine: str
    whole: int
    constraints: tuple[Constraint, ...] = ()
    seed: int = 0

    def __iter__(self) -> Iterator[Variation]:
        for number in range(self.whole):
            values = self.values(number)
            if all(constraint.holds(values) for constraint in self.constraints):
                yield Variation(number, values)

    def values(self, number: int) -> dict[str, Value]:
        """The values of a variation by its number; of a grid, the last axis runs fastest."""
        if self.combine == "zip":
            return {axis.key: axis.values[number] for axis in self.axes}
        if self.combine == "latin_hypercube":
            shares = self._shares[number].tolist()
            return {axis.key: axis.between(s) for axis, s in zip(self.axes, shares, strict=True)}
        values: dict[str, Value] = {}
        for axis in reversed(self.axes):
            number, place = divmod(number, len(axis.values))
            values[axis.key] = axis.values[place]
        return {axis.key: values[axis.key] for axis in self.axes}

    @cached_property
    def _shares(self) -> FloatArray:
        """Shares of the axes, shape (variations, axes), one in each of as many equal cells."""
        from scipy.stats import qmc

        drawn = qmc.LatinHypercube(len(self.axes), rng=np.random.default_rng(self.seed))
        return np.asarray(drawn.random(self.whole))


def variations_of(sweep: Sweep, source: str) -> Variations:
    """The variations of a sweep. Raises `InvalidJob` for axes, constraints and counts."""
    axes = axes_of(sweep.axes, source, sweep.types_of)
    keys = [axis.key for axis in axes]
    constraints = constraints_of(sweep.constraints, keys)
    sizes = {axis.key: len(axis.values) for axis in axes}
    if sweep.combine == "zip" and len(set(sizes.values())) > 1:
        listed = ", ".join(f"{key} {size}" for key, size in sizes.items())
        raise InvalidJob(f"{source}: combine = 'zip' needs axes of equal length: {listed} values.")
    if sweep.count is not None and sweep.count * len(axes) > MOST:
        raise InvalidJob(
            f"{source}: count = {sweep.count} must be at most {MOST // len(axes)}, which makes "
            f"{MOST} values of {len(axes)} axes. Take fewer."
        )
    whole = {
        "grid": prod(sizes.values()),
        "zip": next(iter(sizes.values())),
        "latin_hypercube": sweep.count or 0,
    }[sweep.combine]
    if whole > MOST:
        listed = " x ".join(str(size) for size in sizes.values())
        raise InvalidJob(
            f"{source}: has {whole} variations ({listed}), must have at most {MOST}. Take fewer "
            "values, or combine = 'latin_hypercube' with a count."
        )
    return Variations(axes, sweep.combine, whole, constraints, sweep.seed)


def hash_of(
    document: Mapping[str, Any], files: Mapping[str, str], measure: Sequence[str], version: str
) -> str:
    """A hash of all that decides the row of a variation.

    document : its job. files : hashes of those that the job names. measure : what is measured.

    >>> hashes = [hash_of({"name": "a"}, {"mine.py": text}, [], "1") for text in ("1f", "1f", "2c")]
    >>> len(set(hashes))
    2
    """
    decides = [document, dict(files), list(measure), version]
    text = json.dumps(decides, sort_keys=True, allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()[:20]
