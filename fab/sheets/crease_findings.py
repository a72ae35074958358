"""Findings of creases that are not cut as asked for, over all pieces of a sheet at once."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fab.drawings.beam import Beam
from fab.errors import Finding, Severity, counted, first_few
from fab.sheets.feature_size import enlargement
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["CREASE_NAMES", "CutCreases", "crease_findings"]

# Assignments of the creases that have a style, and the names of the styles in a job.
CREASE_NAMES = {"M": "mountain", "V": "valley", "F": "flat", "U": "unassigned"}
# Where more creases than this share cannot be folded, a sheet is a waste of material.
_MOST_UNCUT = 0.5


@dataclass(frozen=True)
class CutCreases:
    """The creases of a pattern that are to be cut, and what became of each; shapes (n,).

    Attributes
    ----------
    numbers, letters : of the edges: their numbers and assignments.
    length_mm : length; needed_mm : the length above which anything is cut.
    cuts : how many cuts each has; lattice : which ones have a lattice.
    meeting : which ones stay uncut because their lattice would meet other lines.
    pierced : how many cuts of each are not longer than the kerf.
    """

    numbers: IntArray
    letters: NDArray[np.str_]
    length_mm: FloatArray
    needed_mm: FloatArray
    cuts: IntArray
    lattice: BoolArray
    meeting: BoolArray
    pierced: IntArray


def crease_findings(
    creases: Sequence[CutCreases], margin_mm: float, kerf_mm: float | Beam
) -> list[Finding]:
    """Findings of the creases that are not cut as asked for, each kind once for all patterns.

    creases : those of each pattern, at least one; findings name edges by their `numbers`.
    """
    every = CutCreases(
        *(
            np.concatenate([getattr(own, field.name) for own in creases])
            for field in dataclasses.fields(CutCreases)
        )
    )
    return [
        *_meeting(every),
        *_too_short(every, margin_mm),
        *_rigid(every),
        *_pierced(every, Beam.of(kerf_mm)),
    ]


def _meeting(creases: CutCreases) -> list[Finding]:
    """Lattices that are left out because they would meet other lines."""
    met = creases.numbers[creases.meeting]
    if not len(met):
        return []
    stay = "stays" if len(met) == 1 else "stay"
    return [
        Finding(
            "lattices-meet",
            Severity.ERROR,
            f"{counted(len(met), 'lattice')} would meet other lines across a face and {stay} "
            "uncut. Lower rows or pitch_mm, or enlarge the sheet.",
            creases=first_few(met),
        )
    ]


def _too_short(creases: CutCreases, margin_mm: float) -> list[Finding]:
    """Creases with nothing between their margins."""
    short = (creases.cuts == 0) & ~creases.meeting
    if not short.any():
        return []
    alike = [(name, short[creases.letters == letter]) for letter, name in CREASE_NAMES.items()]
    counts = [f"{uncut.sum()} of {len(uncut)} {name}" for name, uncut in alike if uncut.any()]
    length = creases.length_mm[short]
    leave, their, stay, shortest = (
        ("leaves", "its", "stays", "It")
        if len(length) == 1
        else ("leave", "their", "stay", "The shortest")
    )
    return [
        Finding(
            "crease-too-short",
            Severity.ERROR
            if any(len(uncut) and uncut.mean() > _MOST_UNCUT for _, uncut in alike)
            else Severity.WARNING,
            f"{' and '.join(counts)} creases {leave} nothing between {their} margins "
            f"({2 * margin_mm:g} mm, and what relief holes and lattices take) and {stay} uncut. "
            f"{shortest} is {length.min():.3g} mm long. Lower margin_mm, or make the sheet at "
            f"least {enlargement(creases.needed_mm[short], length)} times as large.",
            creases=first_few(creases.numbers[short]),
        )
    ]


def _rigid(creases: CutCreases) -> list[Finding]:
    """Lattices of a single slit, which do not bend."""
    rigid = creases.lattice & (creases.cuts == 1)
    if not rigid.any():
        return []
    bending = int((creases.lattice & (creases.cuts > 1)).sum())
    length = creases.length_mm[rigid]
    count = int(rigid.sum())
    have, do = ("has", "does") if count == 1 else ("have", "do")
    return [
        Finding(
            "lattice-rigid",
            Severity.ERROR if count > _MOST_UNCUT * creases.lattice.sum() else Severity.WARNING,
            f"{counted(count, 'lattice')} {have} room for a single slit and {do} not bend; "
            f"{bending} {'does' if bending == 1 else 'do'}. "
            f"The shortest of these creases is {length.min():.3g} mm long. Lower cut_mm, or make "
            f"the sheet at least {enlargement(creases.needed_mm[rigid], length)} times as large.",
            creases=first_few(creases.numbers[rigid]),
        )
    ]


def _pierced(creases: CutCreases, beam: Beam) -> list[Finding]:
    """Cuts that come out as long as the kerf is wide."""
    pierced = np.flatnonzero(creases.pierced)
    if not len(pierced):
        return []
    count = int(creases.pierced.sum())
    cuts = f"{counted(count, 'cut')} on {counted(len(pierced), 'crease')}"
    are = (
        "is not longer than the kerf ({0}) and is drawn as a pierce, which comes out"
        if count == 1
        else "are not longer than the kerf ({0}) and are drawn as pierces, which come out"
    ).format(beam.text)
    return [
        Finding(
            "cut-shorter-than-kerf",
            Severity.WARNING,
            f"{cuts} {are} as long as the kerf. Lengthen the cuts, or take a finer beam.",
            creases=first_few(creases.numbers[pierced]),
        )
    ]
