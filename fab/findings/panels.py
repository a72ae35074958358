"""Findings of thick panels, their hinges, and the room they have from flat to folded."""

from __future__ import annotations

from fab.findings.explanation import ERROR, WARNING, Explanation

__all__ = ["PANELS"]

PANELS = (
    Explanation(
        "panel-vanishes",
        (WARNING, ERROR),
        "Faces have no panel.",
        "The setbacks of their creases leave nothing of them. It is a warning where they are "
        "slivers, up to 1 % "
        "of the area together, which stay open.",
        "A smaller thickness_mm, or a larger sheet, as the text says; --suggest lists what works.",
    ),
    Explanation(
        "panel-side-vanishes",
        (WARNING,),
        "A panel loses a side.",
        "The edge is so short that the setbacks of its neighbours meet.",
        "Enlarge the sheet, or lower gap_mm or thickness_mm.",
    ),
    Explanation(
        "panel-not-convex",
        (ERROR,),
        "Faces with a concave corner have no panel.",
        "The setbacks of their creases make them lose a side, or cross themselves.",
        "Divide them by creases, or enlarge the sheet.",
    ),
    Explanation(
        "fold-too-far",
        (ERROR,),
        "Creases fold too far for panels at any size.",
        "Near 180 degrees two panels would lie on each other with their axis between them.",
        "Set panels.fold_limit_deg, or give a pattern that folds less.",
    ),
    Explanation(
        "fold-limited",
        (WARNING,),
        "Panels are made for a smaller fold than the target's.",
        "Creases fold by 180 degrees or nearly, which thick panels cannot.",
        "Nothing, or panels.fold_limit_deg; the text says how to fold all the way.",
    ),
    Explanation(
        "fold-blocked",
        (WARNING,),
        "Panels stop before the target.",
        "A crease reaches fold_limit_deg on the way.",
        "Thinner panels, a larger sheet, or a pattern that folds less. Expected for paper's "
        "steep folds.",
    ),
    Explanation(
        "panels-lock",
        (WARNING,),
        "With flat faces the sheet does not leave the flat state.",
        "Paper bends on its way to this target; rigid panels reach it only if their hinges give.",
        "Choose a pattern that folds rigidly, such as rigid_miura.",
    ),
    Explanation(
        "panels-jam",
        (WARNING,),
        "Panels overlap in states between flat and the target.",
        "They come into each other's way, or slip along their axes where faces have to bend.",
        "Raise gap_mm, or lower thickness_mm or fold_limit_deg.",
    ),
    Explanation(
        "clearance-between",
        (WARNING,),
        "Between flat and the target, panels come nearer than at either.",
        "The creases do not turn evenly.",
        "Raise gap_mm.",
    ),
    Explanation(
        "solids-overlap",
        (WARNING, ERROR),
        "Two bodies share room when flat or at the target.",
        "Panels are too thick for the folds around them. It is a warning where bent faces may "
        "have room that "
        "flat ones lack.",
        "The thickness or fold limit that the text names.",
    ),
    Explanation(
        "clearance-too-small",
        (ERROR,),
        "Two bodies are nearer than they are made to be.",
        "Other creases bring them together.",
        "Raise gap_mm, or enlarge the sheet.",
    ),
    Explanation(
        "panels-touch",
        (ERROR,),
        "Bodies without a common crease touch, and are printed as one.",
        "Pieces of the pattern lie side to side, or two corners meet.",
        "Move them apart in the pattern, or name a printer, which sets pieces apart.",
    ),
    Explanation(
        "panels-close",
        (WARNING,),
        "Bodies without a common crease are nearer than the printer keeps open.",
        "They may fuse in the print.",
        "Raise gap_mm, or lower thickness_mm.",
    ),
    Explanation(
        "panels-loose",
        (ERROR,),
        "The panels are in more bodies than there are pieces.",
        "Some have no hinge.",
        "Lower gap_mm or relief_mm, or enlarge the sheet.",
    ),
    Explanation(
        "solid-invalid",
        (ERROR,),
        "A body is not a sound solid.",
        "This is a fault of quadfold.",
        "Report it with the job; a slightly different gap_mm or thickness_mm may avoid it.",
    ),
    Explanation(
        "joined-invalid",
        (ERROR,),
        "The surface of all bodies together is not a sound solid.",
        "Bodies meet in a way that joining them does not survive.",
        "Take the single bodies (--only zip), or change gap_mm or thickness_mm a little; report "
        "it with the job.",
    ),
    Explanation(
        "hinge-missing",
        (WARNING,),
        "Creases have no hinge.",
        "They are too short for one, or fold too far, or their panels are too thin.",
        "Lower gap_mm or relief_mm, enlarge the sheet, or choose another hinge for them.",
    ),
    Explanation(
        "web-not-anchored",
        (WARNING,),
        "Webs of a material of their own may come off.",
        "There is no room for a dovetail in a panel, or the sheet is printed in parts, whose "
        "webs have none.",
        "Lower anchor_mm or wall_mm, enlarge the sheet, or print panels and hinges of one "
        "material.",
    ),
    Explanation(
        "hole-missing",
        (WARNING,),
        "Panels have no alignment hole.",
        "They are too narrow for hole_mm with walls beside it.",
        "Lower hole_mm or wall_mm, or enlarge the sheet.",
    ),
    Explanation(
        "slit-not-cut",
        (ERROR,),
        "A cut that ends within a face is not made.",
        "A slot as wide as gap_mm would leave nothing of the panel, or part it.",
        "Lower gap_mm, or enlarge the sheet.",
    ),
    Explanation(
        "crease-within-panel",
        (WARNING,),
        "A crease that ends within a face has no hinge.",
        "The panel of the face does not bend.",
        "Divide the face by creases from border to border.",
    ),
)
