"""Resolution of a sheet: the fewest columns with which something of it is as small as wanted."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

__all__ = ["Resolution", "fewest_columns"]

Sheet = TypeVar("Sheet")

# Sheets that are made at most. One within this share of the bound is not too fine.
_MOST_TRIALS = 5
_NEAR = 0.92
# More columns than a guess has, as a factor: they are to keep the bound.
_SAFE = 1.01
# So many times as many as at first are tried before it is said that no sheet is fine enough.
_FINER = 4


@dataclass(frozen=True)
class Resolution(Generic[Sheet]):
    """The sheet that was chosen.

    Attributes
    ----------
    sheet, columns : that one. sizes : what was found of each number of columns tried, in turn.
    held : whether the sheet is as fine as wanted.
    needed : columns with which it would be, by those tried; None where it is, or some were tried.
    """

    sheet: Sheet
    columns: int
    sizes: dict[int, float]
    held: bool
    needed: int | None = None


def fewest_columns(
    made: Callable[[int], Sheet],
    size: Callable[[Sheet], float],
    bound: float,
    *,
    first: int,
    least: int,
    most: int,
) -> Resolution[Sheet]:
    """The sheet of the fewest columns whose size is at most `bound`, with few trials.

    made : the sheet of so many columns. size : of a sheet, about as small as columns are many.
    first, least, most : columns to begin with, and their bounds. Where no sheet is fine enough, it
    is the finest of those tried; sheets of more than four times as many columns as at first are not
    made where even `most` of them would be too few by the sizes of others.

    >>> found = fewest_columns(lambda n: n, lambda n: 10.0 / n, 0.3, first=12, least=4, most=400)
    >>> found.columns, found.held, list(found.sizes)
    (34, True, [12, 34])
    """
    sheets: dict[int, Sheet] = {}
    sizes: dict[int, float] = {}
    columns, needed = first, None
    while True:
        sheets[columns] = made(columns)
        sizes[columns] = size(sheets[columns])
        fine = [n for n, found in sizes.items() if found <= bound]
        coarse = [
            n for n, found in sizes.items() if found > bound and n < min(fine, default=most + 1)
        ]
        low = max(coarse, default=least - 1) + 1
        high = min(fine, default=most + 1) - 1
        close = bool(fine) and sizes[min(fine)] >= _NEAR * bound
        if close or low > high or len(sizes) == _MOST_TRIALS:
            break
        guess = _guess(sizes, bound)
        if guess > most and not fine:
            finer = min(_FINER * first, most)
            if max(sizes) >= finer:
                needed = guess
                break
            guess = finer
        columns = min(max(guess, low), high)
    best = min(fine) if fine else min(sizes, key=lambda n: sizes[n])
    return Resolution(sheets[best], best, sizes, bool(fine), needed)


def _guess(sizes: dict[int, float], bound: float) -> int:
    """Columns whose size would be just below the bound, were it a power of their number.

    Of the power that the two sizes nearest to the bound have, or of one over their number.
    """
    near = sorted(sizes, key=lambda n: abs(math.log(sizes[n] / bound)))[:2]
    power = 1.0
    if len(near) == 2:
        steps = math.log(near[1] / near[0])
        power = min(max(math.log(sizes[near[0]] / sizes[near[1]]) / steps, 0.4), 2.5)
    return math.ceil(near[0] * math.pow(sizes[near[0]] / bound, 1 / power) * _SAFE)
