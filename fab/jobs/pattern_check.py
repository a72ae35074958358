"""Measures and findings of any crease pattern that has a folded form."""

from __future__ import annotations

from dataclasses import dataclass

from fab.errors import Finding, Severity
from fab.pattern.crease_pattern import CreasePattern
from fab.pattern.inspection import (
    Accuracy,
    inspect_accuracy,
    inspect_angles,
    inspect_crossings,
    measure_pattern,
)
from solver.self_intersection import crossing_faces

__all__ = ["PatternCheck", "check_pattern"]


@dataclass(frozen=True)
class PatternCheck:
    """How exact a folded sheet is, and where it is at fault.

    Attributes
    ----------
    accuracy : planarity, developability and isometry.
    crossings : number of pairs of faces that pass through each other.
    findings : of all of these, and of fold angles that differ from the folded form.
    """

    accuracy: Accuracy
    crossings: int
    findings: tuple[Finding, ...]

    @property
    def within_tolerance(self) -> bool:
        """Whether no finding is an error."""
        return all(finding.severity != Severity.ERROR for finding in self.findings)


def check_pattern(pattern: CreasePattern, tolerance: float) -> PatternCheck | None:
    """Measure a crease pattern and its folded form; None where it has none.

    tolerance : of planarity, developability (radians) and isometry. Raises `InvalidValue` where the
    fold angles cannot be measured.
    """
    if pattern.folded_coords is None:
        return None
    accuracy = measure_pattern(pattern)
    angles = inspect_angles(pattern)
    crossings = crossing_faces(pattern.folded_coords, pattern.faces_vertices, pattern.faces_offsets)
    findings = (
        *inspect_accuracy(accuracy, tolerance),
        *angles,
        *inspect_crossings(crossings),
    )
    return PatternCheck(accuracy, len(crossings), findings)
