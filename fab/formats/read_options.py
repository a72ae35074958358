"""What a user says of a file that is read as a crease pattern."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from solver.errors import InvalidValue, require_positive

__all__ = ["ReadOptions"]

_FULLY_FOLDED_DEG = 180.0


@dataclass(frozen=True)
class ReadOptions:
    """How a drawing or FOLD file is understood. Every command that reads patterns takes these.

    Attributes
    ----------
    strict : refuse files that need a repair or an assumption.
    mm_per_unit : size of a unit in files that name none; None: of the format's custom (1 mm, or
        25.4 / 96 mm for SVG).
    merge_mm : ends nearer to each other, or to a line, are joined; None: in proportion to the
        drawing.
    colours : letters by colour ("#rrggbb", lower case) or by the name of a layer or class, which
        come before the format's customs.
    border : "drawn", or "hull": the convex hull of all lines where no border is drawn.
    inner_border : what a border with faces on both sides is: "refuse" or "cut". In formats that
        have one letter for both it is a cut.
    assign : give letters to creases without one (U) where flat folding leaves one possibility only.
    fold_deg : fold angle of mountains and valleys that have none; None: 180.
    rigid : take the fold angles of a rigid fold up to `fold_deg`. Readers leave that to commands:
        `fab.jobs.reading`.
    frame : number of the crease pattern among several of one file, from 1; None: the first.
    """

    strict: bool = False
    mm_per_unit: float | None = None
    merge_mm: float | None = None
    colours: Mapping[str, str] = field(default_factory=dict)
    border: Literal["drawn", "hull"] = "drawn"
    inner_border: Literal["refuse", "cut"] = "refuse"
    assign: bool = False
    fold_deg: float | None = None
    rigid: bool = False
    frame: int | None = None

    def __post_init__(self) -> None:
        """Raise `InvalidValue` for numbers out of bounds."""
        for name in ("mm_per_unit", "merge_mm"):
            if (value := getattr(self, name)) is not None:
                require_positive(name, value)
        if self.fold_deg is not None and not 0 < self.fold_deg <= _FULLY_FOLDED_DEG:
            raise InvalidValue(
                "fold_deg", self.fold_deg, "be over 0 and at most 180", "Give it in degrees."
            )
