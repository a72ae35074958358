"""Gaps between the pieces on a sheet, found on a raster and filled with more pieces.

A shape is free of others where none of its cells is taken. One product of Fourier transforms gives
the number of cells in common for all shifts at once.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
import shapely
from scipy.fft import irfft2, next_fast_len, rfft2
from scipy.ndimage import distance_transform_edt

from solver.vectors import BoolArray, FloatArray

__all__ = ["Gaps"]

# Cells along the longer side of a room.
_CELLS = 512
# Largest distance of a point from the middle of its cell, in cells.
_OFF = 0.5**0.5
# Buffers are polygons with their corners on arcs; between the corners they fall short of these.
_SEGMENTS = 16
_BULGE = 1 / np.cos(np.pi / (4 * _SEGMENTS))


class Gaps:
    """Free cells of a room: each shape that is placed takes some of them."""

    def __init__(
        self, taken: Sequence[shapely.Polygon], room_mm: FloatArray, gap_mm: float
    ) -> None:
        """A room with some shapes in it.

        taken : the shapes, mm. room_mm : shape (2,), width and height of the room, its lower left
        corner at the origin. gap_mm : least distance of two shapes.
        """
        self.room = room_mm
        self.gap = gap_mm
        self.cell = float(room_mm.max()) / _CELLS
        self.count = np.ceil(room_mm / self.cell).astype(int) + 1
        self.shape = next_fast_len(int(self.count[1])), next_fast_len(int(self.count[0]))
        self.taken = np.zeros(self.count[::-1], bool)
        self._take(taken)

    def _take(self, shapes: Iterable[shapely.Polygon]) -> None:
        for shape in shapes:
            low, high = np.reshape(shape.bounds, (2, 2))
            reach = self.gap + self.cell
            first = np.maximum(np.floor((low - reach) / self.cell).astype(int), 0)
            last = np.minimum(np.ceil((high + reach) / self.cell).astype(int), self.count)
            cells = self._cells(shape, first, last - first, self.gap)
            self.taken[first[1] : last[1], first[0] : last[0]] |= cells
        self.spectrum = rfft2(self.taken.astype(float), self.shape)
        self.widest = float(distance_transform_edt(~self.taken).max()) * self.cell

    def _cells(
        self, shape: shapely.Polygon, first: np.ndarray, count: np.ndarray, reach_mm: float
    ) -> BoolArray:
        """Which cells have a point nearer to a shape than reach_mm; a few others may be among them.

        first, count : the lower left cell and the numbers of cells to look at, along x and y.
        """
        around = shape.buffer((reach_mm + _OFF * self.cell) * _BULGE, quad_segs=_SEGMENTS)
        shapely.prepare(around)
        x, y = (
            (begin + np.arange(n) + 0.5) * self.cell for begin, n in zip(first, count, strict=True)
        )
        out: BoolArray = shapely.contains_xy(around, *np.meshgrid(x, y))
        return out

    def place(self, turned: Sequence[shapely.Polygon]) -> tuple[int, FloatArray] | None:
        """Place a piece in the lowest gap that it fits in the first turn that fits any.

        The number of its turn and its shift, shape (2,), mm; the gap is then taken. None where the
        piece fits nowhere.

        turned : the piece in each of its turns, mm.
        """
        disk = shapely.maximum_inscribed_circle(turned[0], tolerance=self.cell)
        if shapely.length(disk) > self.widest + 2 * self.cell:
            return None
        for turn, shape in enumerate(turned):
            low, high = np.reshape(shape.bounds, (2, 2))
            shifts = np.floor((self.room - (high - low)) / self.cell).astype(int) + 1
            if (shifts < 1).any():
                continue
            at_origin = shapely.transform(shape, lambda p, low=low: p - low)
            size = np.ceil((high - low) / self.cell).astype(int)
            mask = self._cells(at_origin, np.zeros(2, int), size, 0.0).astype(float)
            common = irfft2(self.spectrum * np.conj(rfft2(mask, self.shape)), self.shape)
            free = np.argwhere(common[: shifts[1], : shifts[0]] < 0.5)
            if len(free):
                corner = free[0, ::-1] * self.cell
                self._take([shapely.transform(at_origin, lambda p, c=corner: p + c)])
                return turn, corner - low
        return None
