"""The folded form that a fold is judged by, and what is wrong with the one that a file gives."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fab.errors import Finding, Severity
from fab.folding.bar_hinge_model import Framework
from fab.folding.quasi_static import aligned
from fab.folding.tolerance import Tolerance
from fab.pattern.kinematics import unknown_angles
from solver.vectors import FloatArray, norm

__all__ = ["FormDifference", "distance_rel", "form_difference", "inspect_form", "target_form"]

# Lengths of a folded form may differ from those of the sheet by this share: it may be that of a
# program that stretches its faces.
_STRETCH = 1e-2
# Smaller changes of lengths are not reported.
_SEEN = 1e-6


@dataclass(frozen=True)
class FormDifference:
    """By how much a given folded form cannot be that of its sheet.

    Attributes
    ----------
    stretch_mm, stretch_rel : largest change of a side or diagonal of a face.
    distance_mm : largest distance of a vertex from the form that the fold angles give; None where
        they give none.
    likely : what it is instead, such as "the mirror image of it"; empty where that is not seen.
    """

    stretch_mm: float
    stretch_rel: float
    distance_mm: float | None
    likely: str = ""


def target_form(frame: Framework, tolerance: Tolerance | None = None) -> FloatArray | None:
    """The folded form that a fold is judged by, shape (nv, 3), relative to the framework's size.

    That of the pattern, unless `form_difference` contradicts it, or else that of its angles; None
    where the pattern has none and its angles do not close.
    """
    folded = frame.sheet.pattern.folded_coords
    if folded is not None and form_difference(frame, tolerance) is None:
        return folded / frame.size_mm
    if _closes(frame, tolerance or Tolerance()):
        return frame.kinematics.folded_coords / frame.size_mm
    return None


def form_difference(frame: Framework, tolerance: Tolerance | None = None) -> FormDifference | None:
    """What contradicts the pattern's folded form; None where there is none, or it may be right.

    It is wrong where the fold angles close and give another shape, and where they do not, if it
    changes lengths by over 1 %.
    """
    tolerance = tolerance or Tolerance()
    folded = frame.sheet.pattern.folded_coords
    if folded is None:
        return None
    form = folded / frame.size_mm
    stretch = np.abs(frame.strains(form))
    longest = float((stretch * frame.bars_length).max(initial=0.0)) * frame.size_mm
    largest = float(stretch.max(initial=0.0))
    # creases of unknown angle have that of the form
    if _closes(frame, tolerance) and not unknown_angles(frame.sheet.pattern).any():
        given = frame.kinematics.folded_coords / frame.size_mm
        if (distance_rel(frame, form, given) or 0.0) <= tolerance.shape_rel:
            return None
        distance = _largest_distance(frame, form, given)
        return FormDifference(longest, largest, distance, _likely(frame, form, given, tolerance))
    return FormDifference(longest, largest, None) if largest > _STRETCH else None


def inspect_form(frame: Framework, tolerance: Tolerance | None = None) -> list[Finding]:
    """A finding where the pattern's folded form is wrong."""
    found = form_difference(frame, tolerance)
    if found is None:
        return []
    lengths = f"by up to {found.stretch_mm:.3g} mm ({found.stretch_rel:.2%})"
    if found.distance_mm is None:
        text = (
            f"the folded form changes lengths of the sheet {lengths}, so that it is not the target."
        )
    else:
        stretched = f", and changes lengths {lengths}" if found.stretch_rel > _SEEN else ""
        likely = f" (it is {found.likely})" if found.likely else ""
        text = (
            f"the folded form is up to {found.distance_mm:.3g} mm from the one that the fold "
            f"angles give{stretched}{likely}: the angles are the target."
        )
    return [Finding("folded-form-differs", Severity.WARNING, text)]


def _likely(frame: Framework, form: FloatArray, given: FloatArray, tolerance: Tolerance) -> str:
    """What a form is that is not the one given by the angles: of faults that are often seen."""

    def near(first: FloatArray, second: FloatArray) -> bool:
        return (distance_rel(frame, first, second) or 0.0) <= tolerance.shape_rel

    factor = _extent(form) / (_extent(given) or 1.0)
    if near(form * [1.0, 1.0, -1.0], given):
        return "the mirror image of it"
    if factor > 0 and near(form / factor, given):
        return f"{factor:.4g} times as large as it"
    if near(form, frame.vertices_coords):
        return "the flat sheet"
    return ""


def _extent(coords: FloatArray) -> float:
    """Root mean square distance of points from their middle."""
    return float(np.sqrt(((coords - coords.mean(axis=0)) ** 2).sum(axis=1).mean()))


def distance_rel(frame: Framework, coords: FloatArray, form: FloatArray | None) -> float | None:
    """Root mean square distance to a form, relative to its diagonal; None where there is no form.

    The largest of all components of the sheet, each aligned by itself: they may lie anywhere.
    """
    if form is None:
        return None
    found = 0.0
    diagonal = float(norm(np.ptp(form, axis=0))) or 1.0  # that of the sheet, for a mere point
    for component in range(int(frame.component.max()) + 1):
        own = frame.component == component
        off = aligned(coords[own], form[own]) - form[own]
        found = max(found, float(np.sqrt((off**2).sum(axis=1).mean())) / diagonal)
    return found


def _largest_distance(frame: Framework, coords: FloatArray, form: FloatArray) -> float:
    """Largest distance of a vertex of two forms, each component aligned by itself, mm."""
    parts = [frame.component == number for number in range(int(frame.component.max()) + 1)]
    return max(
        float(norm(aligned(coords[own], form[own]) - form[own]).max()) * frame.size_mm
        for own in parts
    )


def _closes(frame: Framework, tolerance: Tolerance) -> bool:
    """Whether the fold angles give a form."""
    kinematics = frame.kinematics
    closes = max(kinematics.closure_max_rad, kinematics.gap_rad) <= tolerance.closure_rad
    return closes and kinematics.gap_mm <= tolerance.shape_rel * frame.size_mm
