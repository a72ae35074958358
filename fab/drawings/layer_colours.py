"""Layer colours: the colour of each operation, by which laser software distinguishes layers."""

from __future__ import annotations

from pydantic import Field

from fab.drawings.cut_paths import Operation
from fab.settings import Settings

__all__ = ["Colour", "Colours"]


class Colour(Settings):
    """A colour, for drawings with any colours and for those with a palette."""

    hex: str = Field(pattern=r"^#[0-9a-f]{6}$", description="#rrggbb, for SVG and PDF")
    aci: int = Field(ge=1, le=255, description="AutoCAD colour index, for DXF")


class Colours(Settings):
    """Colours of the operations.

    By default marks are green, mountains red, valleys blue, relief holes magenta, holes orange, and
    cuts black (white on dark in DXF).

    >>> Colours().of(Operation.VALLEY).hex
    '#0000ff'
    """

    engrave: Colour = Colour(hex="#00a000", aci=3)
    mountain: Colour = Colour(hex="#ff0000", aci=1)
    valley: Colour = Colour(hex="#0000ff", aci=5)
    relief: Colour = Colour(hex="#ff00ff", aci=6)
    hole: Colour = Colour(hex="#ff8000", aci=30)
    cut: Colour = Colour(hex="#000000", aci=7)

    def of(self, operation: Operation) -> Colour:
        """The colour of an operation."""
        return {
            Operation.ENGRAVE: self.engrave,
            Operation.MOUNTAIN: self.mountain,
            Operation.VALLEY: self.valley,
            Operation.RELIEF: self.relief,
            Operation.HOLE: self.hole,
            Operation.CUT: self.cut,
        }[operation]
