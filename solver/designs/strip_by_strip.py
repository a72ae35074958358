"""A sheet grown by hand: a seed, and strips that are chosen one by one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from solver.designs.miura import Miura
from solver.errors import InvalidState, InvalidValue
from solver.growth import GrowingDesign, Growth, Status
from solver.strip_choices import ChosenStrip, grown_strip

__all__ = ["StripByStrip"]


@dataclass(frozen=True)
class StripByStrip:
    """Seed: the sheet of any design. Strips: each on a side, with a flap angle and lengths.

    Attributes
    ----------
    seed : a design, whose sheet they grow on.
    strips : in the order of growth.

    >>> from solver.mesh import Side
    >>> up, aside = (ChosenStrip(side, 2.0, 0.5) for side in (Side.TOP, Side.RIGHT))
    >>> StripByStrip(Miura(columns=4, rows=2), (up, aside)).grow().mesh.grid.shape
    (4, 6)
    """

    seed: GrowingDesign = field(
        default_factory=lambda: Miura(columns=6, rows=2), metadata={"design": True}
    )
    strips: tuple[ChosenStrip, ...] = ()

    def grow(self, progress: Callable[[int, int], None] | None = None) -> Growth:
        """Grow the sheet; where its seed stops, that alone.

        Raises `InvalidValue` for a strip that cannot be grown (`solver.strip_choices`), and for
        parameters of the seed out of bounds, which it names as in seed.columns.
        """
        try:
            seed = self.seed.grow()
        except InvalidState:
            raise
        except InvalidValue as error:
            name = f"seed.{error.name}"
            raise InvalidValue(name, error.value, error.bound, error.cure) from error
        if seed.status is not Status.GROWN:
            return Growth(seed.mesh, seed.strips, seed.status, f"In the seed: {seed.advice}")
        mesh = seed.mesh
        for number, strip in enumerate(self.strips, 1):
            mesh = grown_strip(mesh, strip, f"strip {number} ({strip.side} side)")
            if progress is not None:
                progress(number, len(self.strips))
        return Growth(mesh, seed.strips + len(self.strips))
