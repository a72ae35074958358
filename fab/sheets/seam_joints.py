"""Joints of seams: tabs to glue, tongues and slots, stitching holes, or nothing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fab.pattern.crease_pattern import CreasePattern
from fab.sheets.cut_wishes import TabKind
from fab.sheets.glue_tabs import Tabs, glue_tabs, paired_tabs
from fab.sheets.openings import Openings
from fab.sheets.seams import SeamSides
from fab.sheets.slot_tabs import slotted
from fab.sheets.stitches import stitching_holes
from solver.vectors import BoolArray, IntArray

__all__ = ["JointStyle", "SeamJoints", "seam_joints"]


@dataclass(frozen=True)
class JointStyle:
    """How seams are joined.

    Attributes
    ----------
    tab_mm, angle_deg : greatest height of tabs, and greatest angle at their foot.
    thickness_mm : of the material, for slots.
    stitch_mm, stitch_hole_mm : distance of stitching holes, and their diameter.
    """

    kind: TabKind
    tab_mm: float
    angle_deg: float
    thickness_mm: float
    stitch_mm: float
    stitch_hole_mm: float


@dataclass(frozen=True)
class SeamJoints:
    """Tabs on the edges of seams, and openings beside them."""

    tabs: Tabs
    openings: Openings

    def bare(self, count: int) -> BoolArray:
        """Which of `count` seams have neither, shape (count,)."""
        out: BoolArray = np.ones(count, bool)
        out[self.tabs.seam] = False
        out[self.openings.seams] = False
        return out

    def stitches(self, count: int) -> IntArray:
        """How many stitches each of `count` seams has: pairs of holes, shape (count,)."""
        out: IntArray = np.bincount(self.openings.seams, minlength=count) // 2
        return out


def seam_joints(
    pattern: CreasePattern, faces_piece: IntArray, sides: SeamSides, style: JointStyle
) -> SeamJoints:
    """The joints of all seams in a style; faces_piece : piece that each face is in, shape (nf,)."""
    where = (pattern, faces_piece, sides, style.tab_mm, style.angle_deg)
    match style.kind:
        case "one side":
            return SeamJoints(glue_tabs(*where), Openings.none())
        case "both sides":
            return SeamJoints(paired_tabs(*where), Openings.none())
        case "slots":
            return SeamJoints(*slotted(pattern, sides, glue_tabs(*where), style.thickness_mm))
        case "stitches":
            holes = stitching_holes(pattern, sides, style.stitch_mm, style.stitch_hole_mm)
            return SeamJoints(Tabs.none(), holes)
        case "none":
            return SeamJoints(Tabs.none(), Openings.none())
