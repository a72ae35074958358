"""Beam: what a tool takes away at one place, which may be wider along one axis of the bed."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from solver.vectors import FloatArray

__all__ = ["Beam"]


@dataclass(frozen=True)
class Beam:
    """An ellipse whose axes are those of the bed, both 0 for a tool that takes nothing away.

    Attributes
    ----------
    x_mm, y_mm : its widths along the axes of the bed.
    turn_rad : direction of the bed's x axis in the drawing, counterclockwise from the drawing's.

    >>> beam = Beam(0.1, 0.2)
    >>> beam.along(np.array([[1.0, 0.0], [0.0, 3.0]])).round(9).tolist()
    [0.1, 0.2]
    >>> beam.turned(np.pi / 2).along(np.array([[1.0, 0.0]])).round(9).tolist()
    [0.2]
    """

    x_mm: float
    y_mm: float
    turn_rad: float = 0.0

    @classmethod
    def of(cls, kerf_mm: float | Beam) -> Beam:
        """A round beam of a width; a beam as it is."""
        return kerf_mm if isinstance(kerf_mm, Beam) else cls(kerf_mm, kerf_mm)

    def turned(self, angle_rad: float) -> Beam:
        """The beam as it is in a drawing that comes onto the bed turned by -`angle_rad`."""
        return self if self.is_round else replace(self, turn_rad=self.turn_rad + angle_rad)

    @property
    def is_round(self) -> bool:
        """Whether it is as wide in all directions."""
        return self.x_mm == self.y_mm

    @property
    def widest_mm(self) -> float:
        """The greater of both widths."""
        return max(self.x_mm, self.y_mm)

    @property
    def text(self) -> str:
        """Its width in words.

        >>> Beam.of(0.15).text, Beam(0.1, 0.2).text
        ('0.15 mm', '0.1 x 0.2 mm')
        """
        return f"{self.x_mm:g} mm" if self.is_round else f"{self.x_mm:g} x {self.y_mm:g} mm"

    def along(self, directions: FloatArray) -> FloatArray:
        """Length that it clears beyond a cut's ends, both together, along directions (n, 2), (n,).

        Between two cuts on a line the material that is left is the gap less this, where it is
        narrowest.
        """
        u, v = self._in_beam(directions)
        if self.is_round:
            return np.full(len(u), self.x_mm)
        out: FloatArray = self.x_mm * self.y_mm / np.hypot(u * self.y_mm, v * self.x_mm)
        return out

    def across(self, directions: FloatArray) -> FloatArray:
        """Width of a cut that runs in directions (n, 2), shape (n,)."""
        u, v = self._in_beam(directions)
        if self.is_round:
            return np.full(len(u), self.x_mm)
        out: FloatArray = np.hypot(v * self.x_mm, u * self.y_mm)
        return out

    def to_round(self) -> FloatArray:
        """The matrix, shape (2, 2), that makes it round and `x_mm` wide."""
        c, s = np.cos(self.turn_rad), np.sin(self.turn_rad)
        scale = 1.0 if self.is_round else self.x_mm / self.y_mm
        out: FloatArray = np.array([[c, s], [-s * scale, c * scale]])
        return out

    def _in_beam(self, directions: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Unit vectors in the axes of the beam."""
        c, s = np.cos(self.turn_rad), np.sin(self.turn_rad)
        x, y = directions.T
        size = np.hypot(x, y)
        size = np.where(size > 0, size, 1.0)
        return (c * x + s * y) / size, (c * y - s * x) / size
