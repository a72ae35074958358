"""What a user says of a file that is read as a crease pattern."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

__all__ = ["ReadOptions"]


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
    inner_border : what a border with faces on both sides is: "refuse" or "cut".
    assign : give letters to creases without one (U) where flat folding leaves one possibility only.
    fold_deg : fold angle of mountains and valleys that have none; None: 180.
    rigid : take the fold angles of a rigid fold up to `fold_deg`. Readers leave that to commands:
        `fab.folding.rigid_angles`.
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
