"""What was read from a file of crease patterns."""

from __future__ import annotations

from dataclasses import dataclass

from fab.errors import Finding
from fab.pattern.crease_pattern import CreasePattern
from solver.vectors import FloatArray

__all__ = ["PatternFile", "State"]

# A folded shape by its title and points, shape (nv, 3), mm.
State = tuple[str, FloatArray]


@dataclass(frozen=True)
class PatternFile:
    """A crease pattern in millimetres, its lower left corner at the origin.

    Attributes
    ----------
    title : of the file; empty where it has none.
    states : other folded shapes than the folded form, by their titles, in mm.
    findings : what was repaired, assumed or noticed.
    patterns : how many crease patterns the file holds; `ReadOptions.frame` chooses one of them.
    """

    title: str
    pattern: CreasePattern
    states: tuple[State, ...]
    findings: tuple[Finding, ...]
    patterns: int = 1
