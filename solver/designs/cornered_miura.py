"""A Miura sheet with a concave corner, and strips that go around it (S1 B.1)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from solver.corner import CornerStrip, grow_corner, grow_part, grow_pentagon
from solver.designs.miura import Miura
from solver.errors import InvalidValue, require_count, require_length
from solver.front import Front
from solver.growth import Growth, Strip, grow
from solver.mesh import QuadMesh
from solver.rays import Rays
from solver.vectors import FloatArray, norm
from solver.vertex import flap_angle_of

__all__ = ["CorneredMiura"]


@dataclass(frozen=True)
class CorneredMiura:
    """Seed: the lower rows of a Miura sheet. On its left part the sheet's own strips go on, and
    leave a concave corner. Around it: either strips that fill the corner, where quads match, or a
    pentagon and a hem of ordinary strips, whose flap angle is the sheet's own on the left arm.
    Lengths: all one, but at most half the length at which neighbouring creases meet.

    Attributes
    ----------
    columns, rows : number of quads in each direction of the whole Miura sheet.
    corner_column, corner_row : quads to the left of the corner and below it.
    sector_angle : acute angle of the parallelograms, radians in (0, pi/2).
    fold : angle between each parallelogram and the plane of the sheet, radians in (0, pi/2).
    strips : how many go around the corner; at most as many as fill it where they match.
    strip_length : of their creases; the Miura sheet's are 1.
    matched : whether the creases from the corner's neighbours meet; otherwise they end before, and
        the first strip has a pentagon.
    """

    columns: int = 10
    rows: int = 10
    corner_column: int = 4
    corner_row: int = 4
    sector_angle: float = field(default=np.pi / 3, metadata={"angle": True})
    fold: float = field(default=np.pi / 4, metadata={"angle": True})
    strips: int = 3
    strip_length: float = 0.3
    matched: bool = False

    def grow(self, progress: Callable[[int, int], None] | None = None) -> Growth:
        """Grow the sheet. Raises `InvalidValue` for parameters out of bounds."""
        require_count("strips", self.strips, 1, "One strip alone surrounds the corner.")
        require_length("strip_length", self.strip_length)
        for name, value, least, most in (
            ("corner_column", self.corner_column, 2, self.columns - 1),
            ("corner_row", self.corner_row, 1, self.rows - 2),
        ):
            if not least <= value <= most:
                cure = "The part above the corner needs two columns and two rows or more."
                raise InvalidValue(name, value, f"be from {least} to {most}", cure)
        sheet = Miura(self.columns, self.rows, self.sector_angle, self.fold).grow().mesh
        whole = sheet.vertices_coords[sheet.grid]
        cornered = self._cornered(whole)
        if self.matched:
            strip = CornerStrip(self._lengths)
            return grow_corner(cornered, self.strips, lambda _: strip, progress=progress)
        first = grow_pentagon(cornered, CornerStrip(self._lengths))

        def advanced(done: int, _: int) -> None:
            if progress is not None:
                progress(done + 1, self.strips)

        if first.strips:
            advanced(0, 0)
        if first.strips in (0, self.strips):
            return first

        def choose(front: Front, strip: int) -> Strip:
            column = self.corner_column + 1 + strip
            ahead = whole[-1, 1 + column % 2] - whole[-1, column % 2]
            u = front.edges_direction
            return Strip(float(flap_angle_of(-u[0], u[1], ahead)), self._lengths)

        growth = grow(first.mesh, self.strips - 1, choose, progress=advanced)
        return replace(growth, strips=growth.strips + 1)

    def _cornered(self, whole: FloatArray) -> QuadMesh:
        """The Miura sheet `whole`, shape (R, C, 3), grown without the part beyond the corner."""

        def choose(front: Front, strip: int) -> Strip:
            row = self.corner_row + strip
            crease = whole[row + 1, : self.corner_column + 1] - whole[row, : self.corner_column + 1]
            u = front.edges_direction
            return Strip(float(flap_angle_of(-u[0], u[1], crease[1])), norm(crease))

        lower = QuadMesh.from_rows(whole[: self.corner_row + 1])
        part = (0, self.corner_column)
        return grow_part(lower, self.rows - self.corner_row, choose, part=part).mesh

    def _lengths(self, rays: Rays) -> FloatArray:
        return np.minimum(self.strip_length, 0.5 * rays.length_bounds)
