"""What a user should know of a sheet's rigid motion, and of a fold along it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from fab.errors import Finding, Severity, counted
from fab.folding.rigid_folding import RigidFold
from fab.folding.rigid_motion import RigidMotion, RigidVerdict
from fab.folding.verdict import Verdict

__all__ = ["findings_of_fold", "no_motion", "with_motion"]


def with_motion(
    findings: Sequence[Finding], verdict: Verdict, motion: RigidMotion
) -> list[Finding]:
    """The findings of a simulation that drives all creases at one rate, beside the rigid motion.

    A sheet that folds rigidly need not snap or bend where the simulation strains it: the note
    "strained-on-the-way" becomes "folds-rigidly".
    """
    if motion.verdict is not RigidVerdict.FOLDS:
        return list(findings)
    text = (
        f"the sheet {motion.sentence()}; along that motion (simulate --rigid) its faces stay flat. "
        f"Driven all at one rate, its creases strain it by up to {verdict.peak_strain:.2%} on the "
        f"way, at {verdict.peak_strain_load:.0%}."
    )
    return [
        replace(finding, code="folds-rigidly", text=text)
        if finding.code == "strained-on-the-way"
        else finding
        for finding in findings
    ]


def no_motion(motion: RigidMotion) -> Finding:
    """That there is no rigid motion to follow."""
    text = f"there is no rigid motion to follow ({motion.sentence()}). Leave out --rigid."
    return Finding("no-rigid-motion", Severity.ERROR, text)


def findings_of_fold(motion: RigidMotion, fold: RigidFold, fold_flat: bool) -> list[Finding]:
    """How flat the faces stay, and how far the sheet folds beyond its target where it was asked to.

    fold_flat : whether it was.
    """
    states = counted(len(fold.angles_deg), "state")
    bend = f"{fold.bend_max_mm:.1e} mm in {states}"
    text = f"the sheet {motion.sentence()}; its faces bend by at most {bend}."
    out = [Finding("folds-rigidly", Severity.NOTE, text)]
    if not fold_flat:
        return out
    if fold.stopped:
        last = [*fold.folding.states, *fold.beyond][-1]
        text = (
            f"beyond {last.load:.0%} of its fold faces would pass through each other: the sheet is "
            "not folded flat."
        )
        return [*out, Finding("fold-flat-stopped", Severity.WARNING, text)]
    if fold.beyond:
        text = "beyond its target the sheet folds on until it is flat; no faces cross on the way."
        return [*out, Finding("folds-flat", Severity.NOTE, text)]
    text = "beyond its target no motion leads on to a sheet that is folded flat."
    return [*out, Finding("fold-flat-stopped", Severity.WARNING, text)]
