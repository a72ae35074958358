"""Findings of prints: plates, joints, walls and the printer's own bounds."""

from __future__ import annotations

from fab.findings.explanation import ERROR, NOTE, WARNING, Explanation

__all__ = ["PRINTING"]

PRINTING = (
    Explanation(
        "sheet-divided",
        (NOTE,),
        "The sheet is printed in parts, on several plates.",
        "It is larger than the bed.",
        "Nothing: join the parts in the order of the report and the guide.",
    ),
    Explanation(
        "joint-pin",
        (WARNING,),
        "Parts are joined by pins at some creases, not by dovetails.",
        "Their panels have no room for a pocket.",
        "Nothing, or lower mouth_mm, depth_mm or wall_mm of [plates.joints], or enlarge the sheet.",
    ),
    Explanation(
        "joint-tape",
        (WARNING,),
        "Parts are to be taped together at some creases.",
        "There is no room for a dovetail or a pin, or no web.",
        "Nothing, or lower mouth_mm, depth_mm or wall_mm of [plates.joints], or enlarge the sheet.",
    ),
    Explanation(
        "joint-bare",
        (NOTE,),
        "Creases between parts have no hinge, and so no joint.",
        "Their kind of hinge is none.",
        "Join them as all others without one, by tape or laminate.",
    ),
    Explanation(
        "film-taped",
        (NOTE,),
        "A film is cut along the creases between parts.",
        "Parts with films are laid edge to edge.",
        "Tape or glue the film as the text says; the tape folds as the film does.",
    ),
    Explanation(
        "pieces-moved",
        (NOTE,),
        "Pieces of the pattern are set apart on the bed.",
        "They were nearer than the printer's least_gap_mm and would fuse.",
        "Nothing.",
    ),
    Explanation(
        "first-layer-relief",
        (NOTE,),
        "Bottoms are cut back at the bed.",
        "The first layer spreads, and would bridge the gap to another body.",
        "Switch off what the slicer does about elephant's foot.",
    ),
    Explanation(
        "pause-for-film",
        (NOTE,),
        "The print pauses for a film or fabric to be laid in.",
        "hinges.embedded = true asked for it.",
        "Do as the text says, at its layer; slicers other than PrusaSlicer want the pause set "
        "by hand.",
    ),
    Explanation(
        "film-off-middle",
        (NOTE,),
        "The film is not in the middle of its panels.",
        "The middle is not at a whole layer.",
        "Set thickness_mm to a multiple of two layers.",
    ),
    Explanation(
        "film-too-thick",
        (WARNING,),
        "The nozzle would catch the film.",
        "It is thicker than a layer.",
        "Take a thinner film or an open fabric, or thicker layers.",
    ),
    Explanation(
        "print-too-large",
        (ERROR,),
        "The flat print does not fit the bed.",
        "It is larger within margins, at any angle.",
        "Scale it as the text says, or let `thicken` print it in parts.",
    ),
    Explanation(
        "print-too-high",
        (ERROR,),
        "The flat print is higher than the printer reaches.",
        "Its panels are too thick.",
        "Lower thickness_mm.",
    ),
    Explanation(
        "wall-too-thin",
        (WARNING,),
        "Panels are narrower than the nozzle at their bottom or top.",
        "Bevels meet in a ridge.",
        "Lower thickness_mm or gap_mm, or enlarge the sheet: slicers leave such ridges out.",
    ),
    Explanation(
        "gap-too-narrow",
        (WARNING,),
        "Gaps are narrower than the printer keeps open.",
        "gap_mm, or the play of knuckles, is below the printer's least_gap_mm.",
        "Raise the key that the text names.",
    ),
    Explanation(
        "web-too-thin",
        (ERROR,),
        "Webs are thinner than one layer, and are not printed.",
        "web_mm is below the printer's layer_mm.",
        "Raise web_mm to a layer at least.",
    ),
    Explanation(
        "web-between-layers",
        (NOTE,),
        "Webs come out thinner or thicker than they are drawn.",
        "web_mm is no whole number of layers.",
        "Set it to one of the two values in the text.",
    ),
    Explanation(
        "overhang-too-flat",
        (WARNING,),
        "Sides of panels lean out more than the printer prints without support.",
        "Steep folds with the axis above the bottom.",
        "Print with support, set axis = bottom, or lower fold_limit_deg.",
    ),
    Explanation(
        "bridge-too-long",
        (WARNING,),
        "Webs span a gap over air that is wider than the printer bridges.",
        "The axis is above the bottom, and gap_mm is wide.",
        "Set axis = bottom, or print with support.",
    ),
    Explanation(
        "too-few-extruders",
        (WARNING,),
        "The printer prints fewer materials at a time than panels and hinges are of.",
        "panel_material and hinge_material differ, and the printer has no changer.",
        "Give one material, or take a printer with a changer of materials.",
    ),
    Explanation(
        "one-material",
        (NOTE,),
        "Panels and hinges are printed of the same material.",
        "The printer has one extruder.",
        "Choose one that bends, such as PP or TPU.",
    ),
    Explanation(
        "hinge-breaks",
        (WARNING,),
        "Webs are of a material that breaks where it bends.",
        "Its file says so.",
        "Print them of PP or TPU, or choose other hinges.",
    ),
    Explanation(
        "hinge-strains",
        (WARNING,),
        "Webs stretch by more than their material bears.",
        "They are too thick, or the gap too narrow, for their fold angle.",
        "Set hinges.strain_max to that of the material, raise gap_mm, or lower web_mm.",
    ),
    Explanation(
        "stl-not-closed",
        (ERROR,),
        "The surface needs repair in the single precision of STL files.",
        "Gaps are so narrow, or the sheet so large, that vertices fall together.",
        "Print the 3MF file, or enlarge the gaps.",
    ),
)
