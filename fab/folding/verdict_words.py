"""The verdict on a fold in words that people use, with the figures behind them.

Which kind of fold it is, on scales that mean something off the screen: millimetres by which faces
bend, the strain of the outer fibre beside what sheets bear, and the energy that a fold must be
pushed over beside that of folding all its creases.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any

import numpy as np

from fab.errors import Finding, Severity
from fab.folding.bending import Bend, largest_bend
from fab.folding.misplaced_vertices import misplaced_vertices
from fab.folding.quasi_static import Folding
from fab.folding.rigid_motion import RigidMotion, RigidVerdict
from fab.folding.tolerance import Tolerance
from fab.folding.verdict import NEARLY_DEG, Verdict, enough_deg

__all__ = ["Barrier", "Bearer", "VerdictKind", "VerdictWords", "energy_barrier", "in_words"]

# A fold snaps where the energy of its sheet rises to this share of that of folding all creases, and
# falls to less than half of it. Shipped designs that bend on their way stay below 0.6 of it.
_SNAP = 1e-2
# Faces that bend by a smaller share of the sheet are flat.
_FLAT_REL = 1e-6
# A sentence names up to so many sheets.
_NAMED = 3


class VerdictKind(StrEnum):
    """What a fold is like."""

    NOTHING = "nothing-folds"
    RIGID = "folds-rigidly"
    BENDS = "bends-on-its-way"
    SNAPS = "snaps"
    STOPPED = "is-stopped"
    UNORDERED = "cannot-lie-flat"
    VERTICES_OFF = "vertices-off"
    MISSES = "does-not-reach-its-target"


@dataclass(frozen=True)
class Bearer:
    """A sheet of which it is known what it bears.

    name : such as "card_300gsm". strain_max : without breaking or keeping a bend.
    """

    name: str
    thickness_mm: float
    strain_max: float


@dataclass(frozen=True)
class Barrier:
    """How the energy of a fold rises on its way and falls again.

    Attributes
    ----------
    height_rel, load : the largest energy of the sheet on its way, relative to that of folding all
        creases, and the load of that state.
    end_rel : the energy at the end.
    """

    height_rel: float
    load: float
    end_rel: float

    @property
    def snaps(self) -> bool:
        """Whether it is so high that a sheet does not rest halfway, but snaps."""
        return self.height_rel > _SNAP and self.end_rel < self.height_rel / 2


@dataclass(frozen=True)
class VerdictWords:
    """The verdict in one sentence, and figures.

    Attributes
    ----------
    kind : of the fold. text : the sentence, without its end.
    bend, barrier : of the fold; barrier is None where no crease is driven.
    strains : the largest strain of the outer fibre of each sheet that was asked about.
    bears : whether each bears its strain.
    """

    kind: VerdictKind
    text: str
    bend: Bend
    barrier: Barrier | None
    sheets: tuple[Bearer, ...]
    strains: tuple[float, ...]

    @property
    def bears(self) -> tuple[bool, ...]:
        """Whether each sheet bears its strain."""
        pairs = zip(self.sheets, self.strains, strict=True)
        return tuple(strain <= sheet.strain_max for sheet, strain in pairs)

    def report(self) -> dict[str, Any]:
        """As JSON values."""
        out: dict[str, Any] = {
            "kind": self.kind.value,
            "text": self.text,
            "bend_max_mm": self.bend.distance_mm,
            "bend_strain": self.bend.strain,
            "bend_load": self.bend.load,
            "curvature_max_per_mm": self.bend.curvature_per_mm,
            "bars_as_paper": self.bend.as_paper,
        }
        if self.barrier is not None:
            out["barrier_rel"] = self.barrier.height_rel
            out["barrier_load"] = self.barrier.load
        out["materials"] = [
            {
                "material": sheet.name,
                "strain": strain,
                "strain_max": sheet.strain_max,
                "bears": fine,
            }
            for sheet, strain, fine in zip(self.sheets, self.strains, self.bears, strict=True)
        ]
        return out


def energy_barrier(folding: Folding, bend: Bend) -> Barrier | None:
    """The energy barrier of a fold; None where no crease is driven.

    bend : of its states, with their energy where bars are as stiff as those of paper.
    """
    frame = folding.frame
    whole = frame.energy(frame.vertices_coords, frame.hinges_target).hinges
    if whole == 0:
        return None
    energy = np.array([state.energy.total for state in folding.states]) / whole
    most = int(energy.argmax())
    highest = max(float(energy[most]), bend.energy / whole)
    return Barrier(highest, folding.states[most].load, float(energy[-1]))


def in_words(
    folding: Folding,
    verdict: Verdict,
    motion: RigidMotion,
    findings: Sequence[Finding],
    sheets: Sequence[Bearer] = (),
    tolerance: Tolerance | None = None,
) -> VerdictWords:
    """The verdict in words.

    Parameters
    ----------
    folding, verdict, findings : of the simulation, with those of layers.
    motion : of the sheet with rigid faces.
    sheets : whose strain is looked at: that of the user, or several to compare.
    """
    tolerance = tolerance or Tolerance()
    frame = folding.frame
    bend = largest_bend(folding)
    barrier = energy_barrier(folding, bend)
    strains = tuple(
        bend.strain + bend.curvature_per_mm * sheet.thickness_mm / 2 for sheet in sheets
    )
    kind = _kind(verdict, motion, bend, barrier, frame.size_mm, tolerance)
    off = _vertices_off(folding, verdict) if kind is VerdictKind.MISSES else ""
    if off:
        kind = VerdictKind.VERTICES_OFF
    if kind is not VerdictKind.MISSES and _text_of(findings, VerdictKind.UNORDERED, errors=True):
        kind = VerdictKind.UNORDERED
    elif verdict.closes(tolerance) and _text_of(findings, _STOPPED):
        kind = VerdictKind.STOPPED
    made = VerdictWords(kind, off, bend, barrier, tuple(sheets), strains)
    if kind is VerdictKind.VERTICES_OFF:
        return made
    return replace(made, text=_text(made, motion, findings, reached=verdict.reached))


def _kind(
    verdict: Verdict,
    motion: RigidMotion,
    bend: Bend,
    barrier: Barrier | None,
    size_mm: float,
    tolerance: Tolerance,
) -> VerdictKind:
    if not verdict.reached:
        return VerdictKind.MISSES
    if not verdict.driven:
        return VerdictKind.NOTHING
    flat = bend.distance_mm <= _FLAT_REL * size_mm and verdict.peak_strain <= tolerance.strain
    if motion.verdict is RigidVerdict.FOLDS or flat:
        return VerdictKind.RIGID
    if barrier is not None and barrier.snaps:
        return VerdictKind.SNAPS
    return VerdictKind.BENDS


def _vertices_off(folding: Folding, verdict: Verdict) -> str:
    """That a fold nearly gets there, and misses by vertices off their places; else empty."""
    if not verdict.open_vertices or enough_deg(verdict) > NEARLY_DEG:
        return ""
    sheet = folding.frame.sheet
    own = np.flatnonzero(np.isin(sheet.vertices_source, verdict.open_vertices))
    found = misplaced_vertices(sheet.pattern, own)
    if len(found) < len(own):
        return ""
    worst = max(found, key=lambda each: each.distance_mm)
    vertex = int(sheet.vertices_source[worst.vertex])
    return (
        f"folds but for vertices off their places, by up to about {worst.distance_mm:.2g} mm "
        f"(vertex {vertex}): --tolerance-deg {enough_deg(verdict):g} accepts that"
    )


def _text(
    words: VerdictWords, motion: RigidMotion, findings: Sequence[Finding], *, reached: bool
) -> str:
    """The sentence. reached : whether the fold is at its target, if only without contact."""
    match words.kind:
        case VerdictKind.MISSES:
            missed = _text_of(findings, "target-not-reached")
            return missed.replace("the sheet does not fold to its target", _MISSES).rstrip(".")
        case VerdictKind.UNORDERED:
            text, _, _ = _text_of(findings, VerdictKind.UNORDERED).partition(". ")
            return text.removeprefix("the sheet ").rstrip(".")
        case VerdictKind.STOPPED:
            how = "is stopped on its way"
            if reached:
                how = "reaches its target only by passing through itself, in every order tried"
            return f"{how}: {_text_of(findings, _STOPPED).rstrip('.')}"
        case VerdictKind.NOTHING:
            return "nothing folds: no crease has an angle other than 0"
        case VerdictKind.RIGID if motion.verdict is RigidVerdict.FOLDS:
            return f"{motion.sentence()}; its faces stay flat"
        case VerdictKind.RIGID:
            return "folds rigidly, as it is simulated: its faces stay flat"
        case VerdictKind.SNAPS:
            assert words.barrier is not None  # what makes it snap
            text = (
                f"snaps: on its way its energy rises to {words.barrier.height_rel:.2g} of that of "
                f"folding all creases, at {words.barrier.load:.0%} of the fold, and falls again; "
                "its "
            )
            return text + _bending(words)
    return f"bends on its way: its {_bending(words)}"


_STOPPED = "stopped-by-contact"
_MISSES = "does not reach its target"


def _text_of(findings: Sequence[Finding], code: str, *, errors: bool = False) -> str:
    """The text of the finding of a kind; empty where there is none. errors : of errors alone."""
    found = (f for f in findings if f.code == code)
    return next((f.text for f in found if not errors or f.severity is Severity.ERROR), "")


def _bending(words: VerdictWords) -> str:
    """How much faces bend and stretch, and which sheets bear it."""
    bend = words.bend
    strain = f"{100 * bend.strain:.2g} % (at {bend.load:.0%} of the fold)"
    if bend.curvature_per_mm > 0:
        text = f"faces bend by up to {bend.distance_mm:.2g} mm and stretch by up to {strain}"
    else:
        text = f"triangles stretch by up to {strain}"
    if len(words.sheets) == 1:
        (sheet,), (most,), (fine,) = words.sheets, words.strains, words.bears
        bears = "bears" if fine else "does not bear"
        outer = f"{100 * most:.2g} % of {100 * sheet.strain_max:g} % in its outer fibre"
        return f"{text}: {sheet.name} {bears} that ({outer})"
    if not words.sheets:
        return text
    names = [sheet.name for sheet, bears in zip(words.sheets, words.bears, strict=True) if bears]
    if not names:
        return f"{text}: no shipped sheet bears that"
    verb = "bears" if len(names) == 1 else "bear"
    if len(names) > _NAMED:
        names = [*names[:_NAMED], f"{len(names) - _NAMED} more"]
    *others, last = names
    return f"{text}: {', '.join(others)}{' and ' if others else ''}{last} {verb} that"
