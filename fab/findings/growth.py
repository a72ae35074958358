"""Findings of sheets as they are grown, measured and judged by goals."""

from __future__ import annotations

from fab.findings.explanation import ERROR, NOTE, WARNING, Explanation

__all__ = ["GROWTH"]

GROWTH = (
    Explanation(
        "growth-stopped",
        (ERROR,),
        "Growth ended before all strips were there.",
        "No flap angle leads on: neighbouring creases would meet, or a vertex misses its surface.",
        "Change the value that the text names, such as lengths, the flap angle or the number of "
        "strips.",
    ),
    Explanation(
        "surface-not-followed",
        (ERROR,),
        "The best sheet that was found cannot be made, or is far from its surface.",
        "The surface is too steep, too sharp or too finely detailed for quads of this size.",
        "More columns, a smoother surface, or the surface cut apart; the text says which of "
        "these helps.",
    ),
    Explanation(
        "surface-not-covered",
        (WARNING,),
        "A part of the surface is not under the sheet.",
        "Growth ended at the sides before the surface did.",
        "Give trim = true and a longer seed, more columns, or other zigzag, row_step or turn_deg.",
    ),
    Explanation(
        "far-from-surface",
        (WARNING,),
        "A sheet that folds rigidly is far from its surface.",
        "With flat faces no freedom is left to follow any but gentle surfaces.",
        "Fewer columns, a larger thickness, a flatter surface, or rigid = false for material "
        "that bends.",
    ),
    Explanation(
        "development-overlaps",
        (NOTE, ERROR),
        "Faces lie on each other when the sheet is flat.",
        "The sheet curves so much that it does not lie flat beside itself. It is a note where "
        "the sheet is "
        "cut into pieces that do not overlap.",
        "Cut it into pieces with `quadfold fabricate` or a table [cutter]; for panels, grow "
        "fewer columns or "
        "strips.",
    ),
    Explanation(
        "not-planar",
        (ERROR,),
        "Faces are bent by more than the tolerance.",
        "Vertices of a folded form that was read, or made by hand, are off their faces' planes.",
        "Give the form with more digits, or a larger --tolerance if that is exact enough.",
    ),
    Explanation(
        "not-developable",
        (ERROR,),
        "The angles around an inner vertex do not add up to 360 degrees.",
        "The folded form is of no flat sheet, or has few digits.",
        "Give the form with more digits, or a larger --tolerance if that is exact enough.",
    ),
    Explanation(
        "not-isometric",
        (ERROR,),
        "Flat and folded form differ in lengths.",
        "They are not of the same sheet, or have few digits: short edges lose them first.",
        "Give both forms with more digits, or a larger --tolerance if that is exact enough.",
    ),
    Explanation(
        "angles-differ",
        (ERROR,),
        "Fold angles of the file are not those of its folded form.",
        "One of the two was changed without the other.",
        "Remove the angles from the file, so that they are measured, or the folded form.",
    ),
    Explanation(
        "angles-open",
        (WARNING,),
        "The fold angles around a vertex do not close: walking around it does not lead back.",
        "An angle is wrong or rounded, or a crease is missing.",
        "Correct the angles, add a crease, or take those of a rigid fold with --rigid.",
    ),
    Explanation(
        "sheet-crosses-itself",
        (WARNING,),
        "Faces of the folded sheet pass through each other.",
        "The design grows into itself, which geometry allows and paper does not.",
        "Grow fewer strips, or change flap angles or lengths. The flat sheet can be cut all the "
        "same.",
    ),
    Explanation(
        "sheets-meet",
        (NOTE,),
        "Faces of different sheets of one body pass through each other.",
        "Along a seam, pleats of both sheets reach across it.",
        "Join the sheets edge to edge at the seam; elsewhere more columns keep them apart.",
    ),
    Explanation(
        "rims-meet",
        (NOTE,),
        "Sheets that cover a body together are glued at numbered points of their rims.",
        "The surface needs more than one sheet.",
        "Nothing is wrong. Strips of paper across the seam hold what lies between the points.",
    ),
    Explanation(
        "goal-missed",
        (WARNING,),
        "A goal of the table [goals], or room for panels, is not reached.",
        "The bound is beyond what a sheet with these columns and this size can have.",
        "Fewer columns or a larger sheet; the text says which bound is within reach.",
    ),
)
