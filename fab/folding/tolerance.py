"""How exactly a fold must reach its target."""

from __future__ import annotations

from dataclasses import dataclass

from solver.errors import require_positive

__all__ = ["Tolerance"]

# Of an angle of 0.1 degrees.
_PER_DEG = 1e-3
_CLOSURE_PER_DEG = 1e-2


@dataclass(frozen=True)
class Tolerance:
    """Largest errors of a fold that has reached its target.

    By default files with four decimals in their angles pass, and a wrong crease fails.

    Attributes
    ----------
    angle_deg : of a crease's angle; the others are in proportion to it.
    """

    angle_deg: float = 0.1

    def __post_init__(self) -> None:
        require_positive("tolerance_deg", self.angle_deg)

    @property
    def shape_rel(self) -> float:
        """Of the shape, relative to its diagonal; 1e-4 by default."""
        return _PER_DEG * self.angle_deg

    @property
    def strain(self) -> float:
        """Of lengths, relative; 1e-4 by default."""
        return _PER_DEG * self.angle_deg

    @property
    def closure_rad(self) -> float:
        """Of the rotations around a vertex, which multiply to the identity; 1e-3 by default."""
        return _CLOSURE_PER_DEG * self.angle_deg
