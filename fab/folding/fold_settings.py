"""Settings of a folding simulation: stiffness of the sheet, and number of steps."""

from __future__ import annotations

from pydantic import Field

from fab.folding.loads.load_settings import LoadSettings
from fab.settings import Settings

__all__ = ["FoldSettings", "Stiffness"]


class Stiffness(Settings):
    """Stiffness of bars and hinges (`fab.folding.bar_hinge_model`); their ratios alone matter.

    The defaults are those of Ghassaei, Demaine and Gershenfeld (2018). With much stiffer creases
    thin triangles collapse while they fold; with much softer ones the fold settles slowly.
    """

    axial: float = Field(default=20.0, gt=0, le=1e12, description="of bars, per length")
    crease: float = Field(default=0.7, ge=0, le=1e12, description="per length and radian")
    facet: float = Field(
        default=0.7, ge=0, le=1e12, description="of bent faces and joined edges, as of creases"
    )


class FoldSettings(Stiffness):
    """Stiffness, the number of steps from flat to folded, contact, and what the sheet carries."""

    steps: int = Field(default=10, ge=1, le=10_000, description="equal steps of the load")
    contact: bool | None = Field(
        default=None,
        description="whether faces stop each other; left out, where a thickness is given, or they "
        "cross in a fold without",
    )
    thickness_mm: float = Field(
        default=0.0,
        ge=0,
        le=1000,
        description="of the sheet in contact, how far the middles of layers stay apart; over 0 it "
        "switches contact on, where contact is left out",
    )
    loads: LoadSettings | None = Field(
        default=None, description="what the folded sheet carries; nothing where left out"
    )

    @property
    def in_contact(self) -> bool | None:
        """Whether faces stop each other, as a given thickness wants; None where both are open."""
        return True if self.contact is None and self.thickness_mm > 0 else self.contact
