"""Findings of sheets for laser cutters and plotters."""

from __future__ import annotations

from fab.findings.explanation import ERROR, NOTE, WARNING, Explanation

__all__ = ["SHEETS"]

_LARGER = "Enlarge the sheet, or take a finer beam."

SHEETS = (
    Explanation(
        "no-kerf",
        (NOTE,),
        "The drawing has lines as they are in the pattern, with no kerf taken into account.",
        "The job has no table [cutter], so no machine is known.",
        "Add a table [cutter], or cut the FOLD file with `quadfold fabricate`.",
    ),
    Explanation(
        "sheet-split",
        (NOTE,),
        "The sheet is cut into pieces.",
        "It overlaps itself, is larger than the bed, or is in pieces already.",
        "Nothing: join the pieces in the order of their labels.",
    ),
    Explanation(
        "tab-no-room",
        (WARNING,),
        "Some seams have no glue tab.",
        "The tab would overlap its own piece or another one, or be too narrow.",
        "Join these seams with tape, lower the width of tabs, or enlarge the sheet.",
    ),
    Explanation(
        "label-too-small",
        (WARNING,),
        "Some labels are left out.",
        "Their faces have no room for letters of a readable size.",
        "Enlarge the sheet; the report lists the seams of all pieces in any case.",
    ),
    Explanation(
        "sheets-short",
        (WARNING,),
        "More sheets are needed than cutter.sheets says are at hand.",
        "The pieces do not fit on fewer.",
        "Get more sheets, or ask for fewer copies or a smaller size.",
    ),
    Explanation(
        "power-unset",
        (NOTE,),
        "Layers of a LightBurn project have the power that LightBurn gives to new ones.",
        "The machine's file has no [powers]; no shipped one has.",
        "Set the power in LightBurn, or give it as `powers` in a machine of your own.",
    ),
    Explanation(
        "bridges-fewer",
        (WARNING,),
        "Outlines hold to the sheet by fewer bridges than asked for.",
        "There is no room for them away from corners.",
        "Lower cutter.bridges or cutter.bridge_mm, or enlarge the sheet.",
    ),
    Explanation(
        "title-no-room",
        (WARNING,),
        "The title is left out.",
        "There is no room beside the pieces.",
        "Take a larger bed, or write it on the stock.",
    ),
    Explanation(
        "lead-in-left-out",
        (NOTE,),
        "Closed cuts begin on their line, without a lead-in.",
        "What is thrown away is too narrow for one.",
        "Lower knife.lead_in_mm.",
    ),
    Explanation(
        "mirrored",
        (NOTE,),
        "The drawings are mirrored.",
        "cutter.mirror = true asked for it.",
        "Lay the material face down.",
    ),
    Explanation(
        "crease-too-short",
        (WARNING, ERROR),
        "Creases are so short that nothing of them is cut.",
        "Their margins, relief holes or lattices take all of their length. It is an error where "
        "they are a "
        "large part of all.",
        "Lower margin_mm, or enlarge the sheet as the text says.",
    ),
    Explanation(
        "lattice-rigid",
        (WARNING, ERROR),
        "Living hinges have room for a single slit, and do not bend.",
        "The crease is too short for its slits. It is an error where they are a large part of all.",
        "Lower cut_mm, or enlarge the sheet as the text says.",
    ),
    Explanation(
        "lattices-meet",
        (ERROR,),
        "Living hinges are left out.",
        "They would meet other lines across a face.",
        "Lower rows or pitch_mm, or enlarge the sheet.",
    ),
    Explanation(
        "cut-shorter-than-kerf",
        (WARNING,),
        "Dashes are no longer than the beam is wide.",
        "The style of the crease is finer than the beam.",
        "Lengthen the cuts, or take a finer beam.",
    ),
    Explanation(
        "face-narrower-than-kerf",
        (WARNING,),
        "Nothing of a face is left between its creases.",
        "It is no wider than the beam.",
        _LARGER,
    ),
    Explanation(
        "gap-narrower-than-kerf",
        (WARNING,),
        "A notch or a waist of an outline is cut once, along its middle.",
        "It is narrower than the beam.",
        _LARGER,
    ),
    Explanation(
        "hole-narrower-than-kerf",
        (WARNING,),
        "A hole is cut along its middle, or pierced.",
        "It is nowhere wider than the beam.",
        _LARGER,
    ),
    Explanation(
        "outline-crosses-itself",
        (ERROR,),
        "An outline is not moved by the kerf.",
        "It crosses or touches itself, so that it has no inside.",
        "Split the sheet into pieces.",
    ),
    Explanation(
        "outlines-nearer-than-kerf",
        (WARNING,),
        "The beam that cuts one outline takes material from another.",
        "The two are nearer than the beam is wide.",
        "Set them apart.",
    ),
    Explanation(
        "relief-left-out",
        (WARNING,),
        "Relief holes at vertices are left out.",
        "They would come too near to another hole, the outline or another crease.",
        "Lower web_mm or radius_mm of [perforation] relief, or enlarge the sheet.",
    ),
    Explanation(
        "relief-web-thin",
        (WARNING,),
        "Relief holes leave thin webs between their creases.",
        "radius_mm is smaller than the creases around the vertex need.",
        "Raise radius_mm, or leave it out.",
    ),
)
