"""Lists of lists of numbers in FOLD files, as arrays."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

__all__ = ["number_rows"]


def number_rows(rows: Sequence[Any]) -> Any:
    """The array of rows of numbers; one of text where they are none, or not alike in length.

    What is no number is looked for first: an array of texts is as wide as the longest of them.

    >>> number_rows([[1, 2], [3, 4]]).tolist(), number_rows([[1, "2"]]).dtype.kind
    ([[1, 2], [3, 4]], 'U')
    """
    if all(type(value) in (int, float) for value in _values(rows)):  # no bool, which is an int too
        try:
            return np.array(rows)
        except (ValueError, OverflowError):  # of rows that are not alike, and endless numbers
            pass
    return np.array(["ragged"])


def _values(rows: Sequence[Any]) -> Iterator[Any]:
    for row in rows:
        if isinstance(row, list):
            yield from row
        else:
            yield row
