"""Which findings of readers are facts about a file, and which are repairs or assumptions."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from fab.errors import Finding, InvalidFile, Severity
from fab.formats.read_options import ReadOptions

__all__ = ["FACTS", "is_repair", "require_no_repairs", "with_lost"]

# What is as it was drawn, or as the user said: the pattern means nothing else than the file. Lines
# that cross, or of which one ends on another, are drawn so on purpose, and meet where they do; ends
# that were moved to get there are repairs ("ends-joined", "ends-extended", "lines-bent").
FACTS = frozenset(
    {
        # of the file
        "auxiliary-lines",
        "colours-unused",
        "comment-lines",
        "faces-rebuilt",
        "fold-deg-unused",
        "frame-turned",
        "group-opacity",
        "half-missing",
        "merge-unused",
        "unit-named",
        "unit-unknown",
        # left out, as it is no crease
        "elements-skipped",
        "entities-skipped",
        "frames-left-out",
        "layer-unplotted",
        "layers-hidden",
        "line-without-length",
        "not-lines",
        "paper-space",
        "sheet-addition",
        "vertex-mark",
        # drawn in another manner
        "clip-ignored",
        "curve-flattened",
        "curves-flattened",
        "dashes-joined",
        "lines-split",
        "off-plane",
        "runs-joined",
        # of the sheet
        "crease-dangling",
        "hole",
        "sheet-overlaps",
        # asked for
        "border-hull",
        "border-inside",
        "letters-assigned",
        "rigid-fold",
        # possible
        "letters-assignable",
    }
)
# Facts whatever their severity; the others are guesses where they are warnings.
_WARNINGS_TOO = frozenset(
    {
        *("border-hull", "border-inside", "crease-dangling", "letters-contradict"),
        *("colours-unused", "fold-deg-unused", "merge-unused"),
    }
)


# What may lack in the drawing where the rest of it is refused.
_LOST = frozenset(
    {
        "entities-skipped",
        "layer-unplotted",
        "layers-hidden",
        "line-without-length",
        "not-lines",
    }
)


def with_lost(refusal: str, findings: Sequence[Finding]) -> str:
    """A refusal, and what the reader could not read or left out before it."""
    lost = [f for f in findings if f.severity != Severity.NOTE or f.code in _LOST]
    return " ".join([refusal, *(f"Before that: {finding.text}" for finding in lost)])


def is_repair(finding: Finding) -> bool:
    """Whether a finding of a reader is a repair or an assumption."""
    if finding.code in _WARNINGS_TOO:
        return False
    return finding.code not in FACTS or finding.severity != Severity.NOTE


def require_no_repairs(path: Path, findings: Sequence[Finding], options: ReadOptions) -> None:
    """Raise `InvalidFile` with the first repair where none are wanted."""
    repairs = [finding for finding in findings if is_repair(finding)]
    if options.strict and repairs:
        raise InvalidFile(f"{path}: {repairs[0].text} --strict refuses this.")
