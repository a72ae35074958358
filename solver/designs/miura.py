"""The Miura sheet, grown strip by strip like any other design."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from solver import seeds
from solver.errors import require_count
from solver.front import Front
from solver.growth import Growth, Strip, grow
from solver.rays import Rays
from solver.vectors import FloatArray
from solver.vertex import flap_angle_of

__all__ = ["Miura"]


@dataclass(frozen=True)
class Miura:
    """Seed: one strip of parallelograms. Flap angle: the flat-foldable one, so that rows repeat.
    Lengths: up to the planes z = 0 and z = height in turn; with lengths given as numbers rounding
    errors would grow threefold with every row.

    Attributes
    ----------
    columns, rows : number of quads in each direction.
    sector_angle : acute angle of the parallelograms, radians in (0, pi/2).
    fold : angle between each parallelogram and the plane of the sheet, radians in (0, pi/2); 0
        would be flat, pi/2 folded flat.
    zigzag_length, crease_length : sides of the parallelograms, along and across a strip.
    """

    columns: int = 10
    rows: int = 8
    sector_angle: float = field(default=np.pi / 3, metadata={"angle": True})
    fold: float = field(default=np.pi / 4, metadata={"angle": True})
    zigzag_length: float = 1.0
    crease_length: float = 1.0

    def grow(self, progress: Callable[[int, int], None] | None = None) -> Growth:
        """Grow the sheet. Raises `InvalidValue` for parameters out of bounds."""
        require_count("rows", self.rows, 2, "One strip alone has no interior vertex.")
        seed = seeds.miura(
            self.columns, self.sector_angle, self.fold, self.zigzag_length, self.crease_length
        )
        lower, upper = seed.vertices_coords[seed.grid]
        climb = upper[1] - lower[1]
        middle = self.columns // 2
        a, b = upper[middle - 1] - upper[middle], upper[middle + 1] - upper[middle]
        planes = 0.0, float(climb[2])
        flap_angles = [float(flap_angle_of(a, b, climb * [1.0, 1.0, up])) for up in (-1.0, 1.0)]

        def choose(_front: Front, strip: int) -> Strip:
            def to_plane(rays: Rays) -> FloatArray:
                return (planes[strip % 2] - rays.vertices_coords[:, 2]) / rays.directions[:, 2]

            return Strip(flap_angles[strip % 2], to_plane, at=middle)

        return grow(seed, self.rows - 1, choose, progress=progress)
