"""Coordinates of files that geometry can take."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fab.errors import InvalidFile
from solver.vectors import FloatArray

__all__ = ["require_range"]

# Products of four lengths stay within the range of floats.
_SMALLEST, _LARGEST = 1e-50, 1e50
# Over the largest coordinate: a smaller sheet is lost in its rounding.
_PRECISION_REL = 1e-11


def require_range(path: Path, coords: FloatArray, what: str) -> None:
    """Raise `InvalidFile` unless points, shape (n, 2) or (n, 3), are of a size that can be read.

    what : they are, for the message.
    """
    bad = np.flatnonzero(~np.isfinite(coords).all(axis=1))
    if len(bad):
        raise InvalidFile(f"{path}: vertex {bad[0]} of the {what} is not finite.")
    if not len(coords):
        return
    largest = float(np.abs(coords).max())
    if largest > _LARGEST:
        raise InvalidFile(
            f"{path}: a coordinate of the {what} is {largest:.3g}, over the bound of "
            f"{_LARGEST:.0e}. Scale it by {100 / largest:.0e} for a size of 100."
        )
    size = float(np.ptp(coords, axis=0).max())
    if 0 < size < _SMALLEST:
        raise InvalidFile(
            f"{path}: the {what} is {size:.3g} units large, under the bound of {_SMALLEST:.0e}. "
            "Scale it up to a size of about 100."
        )
    if 0 < size < _PRECISION_REL * largest:
        raise InvalidFile(
            f"{path}: the {what} is {size:.3g} units large but {largest:.3g} away from the origin: "
            "its digits are lost. Move it to the origin."
        )
