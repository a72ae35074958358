"""Findings of sheets as they fold, with faces that bend or rigidly."""

from __future__ import annotations

from fab.findings.explanation import ERROR, NOTE, WARNING, Explanation

__all__ = ["FOLDING"]

FOLDING = (
    Explanation(
        "target-not-reached",
        (NOTE, WARNING, ERROR),
        "The simulated fold does not end where the fold angles say.",
        "Angles do not close, the sheet locks, or it comes to rest elsewhere. It is an error in "
        "`simulate`; for "
        "thick panels a note where the folded form is known, a warning where it is not.",
        "Correct the vertex that the text names, take more --states, or give --rigid and "
        "--fold-deg for angles that close.",
    ),
    Explanation(
        "angles-do-not-close",
        (ERROR,),
        "The fold angles around a vertex contradict each other.",
        "An angle is wrong, fewer than 4 creases fold there, or the vertex is a little off its "
        "place; of creases that fold by 180 degrees it is the vertex, or the sectors between them.",
        "Correct the angle, draw the missing crease or move the vertex, as the text says, or give "
        "--rigid and --fold-deg for angles that close.",
    ),
    Explanation(
        "folded-form-differs",
        (WARNING,),
        "The folded form in the file is not the one that its fold angles give.",
        "It was moved or rounded, or is of another state.",
        "Nothing: the angles are the target. Remove the form from the file, or write it again.",
    ),
    Explanation(
        "cannot-lie-flat",
        (WARNING, ERROR),
        "Folded flat, the sheet passes through itself in every order of its layers.",
        "Creases of these letters force a face through a fold or between two that are joined. The "
        "text names a few faces that already have no order, whatever the others do. "
        "It is a warning where creases of unknown angle are taken to be folded.",
        "Change the letters of creases between those faces, or the lengths of flaps.",
    ),
    Explanation(
        "layers-undecided",
        (WARNING,),
        "Whether the sheet can lie flat was not found out.",
        "There are too many layers for the time, or the vertices are too inexact to say which "
        "edges are on each other.",
        "Write the file with more digits, or judge a part of the pattern.",
    ),
    Explanation(
        "face-orders-contradict",
        (WARNING,),
        "The order of layers in the file (faceOrders) is none that a sheet can have.",
        "It contradicts the letters of creases, or faces would pass through each other.",
        "Nothing: they are left out, and a folded form is given another order. The FOLD file that "
        "`simulate` writes has it.",
    ),
    Explanation(
        "face-orders-unknown",
        (WARNING,),
        "The order of layers in the file (faceOrders) is not readable.",
        "Rows must be two different faces of the file, and 1, -1 or 0.",
        "Nothing: an order is found anew. Write the file again to have that in it.",
    ),
    Explanation(
        "nothing-to-fold",
        (WARNING,),
        "No crease has an angle: the sheet stays flat.",
        "All creases are flat (F) or unassigned (U), or all angles are 0.",
        "Give mountains and valleys, and --fold-deg where the file has no angles.",
    ),
    Explanation(
        "creases-free",
        (NOTE,),
        "Some creases turn freely.",
        "They are unassigned (U) and have no angle, or are slits.",
        "Nothing, or give them letters: --assign finds those that flat folding forces.",
    ),
    Explanation(
        "folds-in-turn",
        (NOTE,),
        "The sheet is folded along a path, each crease at a rate of its own.",
        "Folded all at once, it gets stuck, as many flat-folded models do.",
        "Nothing: fold it in turn by hand as well.",
    ),
    Explanation(
        "crosses-on-the-way",
        (NOTE, WARNING),
        "Faces pass through each other while the sheet folds.",
        "All creases fold together, without contact. It is a warning where "
        "the last state "
        "crosses too.",
        "Fold the sheet in another order; where the last state crosses, change the pattern.",
    ),
    Explanation(
        "stopped-by-contact",
        (WARNING, ERROR),
        "Faces press on each other and keep the sheet from its target.",
        "In every order of folding that was tried they are in each other's way. It is an error "
        "where the stopped fold is what is shown (--contact, or a thickness); else a warning: an "
        "order that was not tried may get there, as for a crane.",
        "Look at the two faces in the state that the text names: fold other creases first, or "
        "change the pattern.",
    ),
    Explanation(
        "thickness-not-used",
        (NOTE,),
        "A thickness is given, but the sheet is folded without contact.",
        "simulation.thickness_mm keeps layers apart in contact alone: with contact = false, or by "
        "another solver than the quasi-static one, it says nothing.",
        "Leave out contact = false (--no-contact) and --solver, or the thickness.",
    ),
    Explanation(
        "folded-in-contact",
        (NOTE,),
        "The sheet is folded so that its faces do not pass through each other.",
        "Without contact they would; with it the sheet reaches its target.",
        "Nothing; --no-contact shows the fold without it.",
    ),
    Explanation(
        "contact-not-finished",
        (WARNING,),
        "The fold in contact takes too long, and is given up.",
        "Many layers of a large sheet, such as the turns of a long ribbon, lie near each other: "
        "what is shown is folded without contact.",
        "Fold a smaller part of the sheet, or simulate with --no-contact.",
    ),
    Explanation(
        "contact-not-possible",
        (WARNING,),
        "The fold is simulated without contact.",
        "The flat sheet overlaps itself: no face there is above the other.",
        "Cut the sheet into pieces, or simulate with --no-contact.",
    ),
    Explanation(
        "strained-on-the-way",
        (NOTE,),
        "The sheet is stretched on its way, and relaxed at its end.",
        "It does not fold with flat faces: it snaps, or its faces bend.",
        "Nothing for paper; for stiff sheets take a pattern that folds rigidly (`check` says "
        "which do).",
    ),
    Explanation(
        "checkpoint-unusable",
        (WARNING,),
        "A file that keeps a fold which was cut short cannot be used, or not be written.",
        "It is damaged or of another fold, or the folder takes no more files.",
        "Nothing: the fold begins from flat. Free some space where none is left.",
    ),
    Explanation(
        "no-rigid-motion",
        (ERROR,),
        "There is no motion with flat faces to follow.",
        "The pattern is rigid when flat, or bends on its way.",
        "Leave out --rigid, or take a rigidly foldable design such as rigid_miura.",
    ),
    Explanation(
        "folds-rigidly",
        (NOTE,),
        "The sheet folds with flat faces all the way.",
        "Its sectors allow it.",
        "Nothing: it suits thick panels and stiff material.",
    ),
    Explanation(
        "folds-flat",
        (NOTE,),
        "Beyond its target the sheet folds on until it is flat.",
        "--fold-flat asked for it.",
        "Nothing.",
    ),
    Explanation(
        "fold-flat-stopped",
        (WARNING,),
        "Beyond its target the sheet does not fold until it is flat.",
        "Faces would pass through each other, or no motion leads there.",
        "Nothing, unless it is to be packed flat; choose other sectors then.",
    ),
    Explanation(
        "rigid-fold",
        (NOTE,),
        "The fold angles are those of a rigid fold.",
        "--rigid asked for them.",
        "Nothing.",
    ),
    Explanation(
        "rigid-fold-missing",
        (WARNING,),
        "No rigid fold with these mountains and valleys was found: the angles stay as they are.",
        "The letters do not suit each other around a vertex, the sheet locks, or it folds less "
        "far.",
        "Correct the letters at the vertex that the text names, or give a smaller --fold-deg.",
    ),
    Explanation(
        "loads-not-at-rest",
        (ERROR,),
        "Under its load the sheet does not come to rest.",
        "It turns about what holds it, a pull has nothing to act against, or the load is so large "
        "that it bends very far in each step.",
        "Fix more vertices, take more load_steps, or less load.",
    ),
    Explanation(
        "swings-about-support",
        (NOTE,),
        "What holds the sheet, or a piece of it, is on one straight line or in one point.",
        "An edge or a vertex that is held may turn as on a hinge: nothing but the load keeps the "
        "sheet from swinging about it.",
        "Hold a region to clamp it (--fix X,Y,X,Y), or hold it elsewhere too; nothing where it is "
        "meant to hang.",
    ),
    Explanation(
        "strained-by-loads",
        (WARNING,),
        "Under its load the sheet is strained by more than its material bears.",
        "It bends sharply, mostly where it is held or pulled.",
        "Hold it along an edge in place of a point, or take a thicker or stiffer sheet.",
    ),
    Explanation(
        "crease-stiffness-guessed",
        (NOTE,),
        "How stiff the creases are is not known.",
        "The file of the material has no crease_stiffness_n: folded sheets of few creases sag by "
        "other amounts.",
        "Measure how far a folded strip opens under a weight, and give crease_stiffness_n.",
    ),
)
