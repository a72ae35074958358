"""Coordinates of files that geometry can take."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fab.errors import InvalidFile, InvalidJob
from fab.pattern.crease_pattern import CreasePattern
from solver.vectors import FloatArray

__all__ = ["require_asked_size", "require_range", "require_sheet_size"]

# Products of four lengths stay within the range of floats.
_SMALLEST, _LARGEST = 1e-50, 1e50
# Over the largest coordinate: a smaller sheet is lost in its rounding.
_PRECISION_REL = 1e-11
# Sheets that anything can be made of, mm, by their longer side; and a size that suits most.
_LEAST_SHEET_MM, _LARGEST_SHEET_MM, _USUAL_MM = 0.1, 1e5, 100.0


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


def require_sheet_size(path: Path, pattern: CreasePattern) -> None:
    """Raise `InvalidFile` for patterns of a size that nothing can be made of."""
    sides = np.ptp(pattern.vertices_coords, axis=0)
    longer = float(sides.max())
    if not _LEAST_SHEET_MM <= longer <= _LARGEST_SHEET_MM:
        raise InvalidFile(
            f"{path}: the sheet is {sides[0]:.4g} x {sides[1]:.4g} mm large; its longer side must "
            f"be from {_LEAST_SHEET_MM:g} to {_LARGEST_SHEET_MM:g} mm. Give --width-mm, or "
            f"--scale {_USUAL_MM / longer:.3g} for {_USUAL_MM:g} mm."
        )


def require_asked_size(asked: str, longer_mm: float) -> None:
    """Raise `InvalidJob` where the size asked for is one that nothing can be made of."""
    if not _LEAST_SHEET_MM <= longer_mm <= _LARGEST_SHEET_MM:
        raise InvalidJob(
            f"{asked}: the sheet would be {longer_mm:.4g} mm large; its longer side must be from "
            f"{_LEAST_SHEET_MM:g} to {_LARGEST_SHEET_MM:g} mm. Give --width-mm {_USUAL_MM:g} or so."
        )
