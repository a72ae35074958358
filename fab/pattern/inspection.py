"""Findings about the exactness of a pattern and its folded form.

Every finding has a code, a severity and names the creases or panels it is about.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fab.errors import Finding, Severity, first_few
from fab.pattern.crease_pattern import CreasePattern, fold_angles_deg
from fab.pattern.kinematics import vertices_closure_rad
from solver.measure import angle_excess, isometry, planarity
from solver.vectors import IntArray

__all__ = [
    "Accuracy",
    "inspect_accuracy",
    "inspect_angles",
    "inspect_closure",
    "inspect_crossings",
    "measure_pattern",
]

# Fold angles measured on short edges lose digits; a wrong crease is off by far more.
_ANGLE_DEG = 1e-3
# Files have their angles with a few digits, and each vertex has several of them.
_CLOSURE_DEG = 1e-2


@dataclass(frozen=True)
class Accuracy:
    """How exact a folded sheet and its crease pattern are; NaN where there is no folded form.

    Attributes
    ----------
    planarity_max : largest distance of a face from flat over its longest diagonal.
    developability_max_rad : largest |2 pi - sum of sector angles| at an interior vertex.
    isometry_max_rel : largest relative change of a side or diagonal from flat to folded.
    """

    planarity_max: float
    developability_max_rad: float
    isometry_max_rel: float


def measure_pattern(pattern: CreasePattern) -> Accuracy:
    """Measure a pattern with a folded form, faces of any size."""
    folded = pattern.folded_coords
    if folded is None:
        return Accuracy(float("nan"), float("nan"), float("nan"))
    planar = change = np.float64(0.0)
    excess = np.zeros(len(folded))
    corners = np.zeros(len(folded))
    inside = np.ones(len(folded), bool)
    inside[pattern.edges_vertices[pattern.edges_faces[:, 1] < 0]] = False
    for _, faces in pattern.faces_by_size():
        # numpy's maximum keeps NaN, the mark of a face without area
        planar = np.maximum(planar, planarity(folded, faces).max())
        change = np.maximum(change, isometry(folded, pattern.vertices_coords, faces).max())
        everywhere = np.ones(len(folded), bool)
        excess += angle_excess(folded, faces, everywhere) + 2 * np.pi
        corners += np.bincount(faces.ravel(), minlength=len(folded))
    inside &= corners > 0
    developable = np.abs(excess - 2 * np.pi)[inside].max(initial=0.0)
    return Accuracy(float(planar), float(developable), float(change))


def inspect_accuracy(accuracy: Accuracy, tolerance: float) -> list[Finding]:
    """A finding for each figure over `tolerance`, or not a number."""
    findings = []
    for code, value, cure in (
        ("not-planar", accuracy.planarity_max, "Faces are bent: their creases will not meet."),
        (
            "not-developable",
            accuracy.developability_max_rad,
            "The folded form does not unfold into a flat sheet.",
        ),
        (
            "not-isometric",
            accuracy.isometry_max_rel,
            "Flat and folded form differ in lengths: short edges lose digits first.",
        ),
    ):
        if not value <= tolerance:
            text = f"{code.replace('-', ' ')}: {value:.3g} is over the tolerance {tolerance:.3g}."
            findings.append(Finding(code, Severity.ERROR, f"{text} {cure}"))
    return findings


def inspect_angles(pattern: CreasePattern) -> list[Finding]:
    """A finding where stored fold angles differ from those of the folded form.

    Cuts, and creases that end within a face, have none there.
    """
    if pattern.folded_coords is None:
        return []
    measured = fold_angles_deg(
        pattern.folded_coords, pattern.edges, pattern.faces_vertices, pattern.faces_offsets
    )
    turn = np.abs(measured - pattern.edges_foldAngle)
    off = np.minimum(turn, 360 - turn)
    first, second = pattern.edges_faces.T
    off[(first == second) | (pattern.edges_assignment == "C")] = 0.0
    wrong = np.flatnonzero(off > _ANGLE_DEG)
    if not len(wrong):
        return []
    worst = int(np.argmax(off))
    count = len(wrong)
    differ = "1 stored fold angle differs" if count == 1 else f"{count} stored fold angles differ"
    return [
        Finding(
            "angles-differ",
            Severity.ERROR,
            f"{differ} from the folded form by over {_ANGLE_DEG:g} degrees; worst is edge "
            f"{worst}: {pattern.edges_foldAngle[worst]:.6g} stored, {measured[worst]:.6g} folded.",
            creases=first_few(wrong),
        )
    ]


def inspect_closure(pattern: CreasePattern) -> list[Finding]:
    """A finding where the fold angles around a vertex do not close."""
    gaps = np.nan_to_num(np.degrees(vertices_closure_rad(pattern)))
    wrong = np.flatnonzero(gaps > _CLOSURE_DEG)
    if not len(wrong):
        return []
    worst = int(np.argmax(gaps))
    x, y = pattern.vertices_coords[worst]
    where = "1 vertex" if len(wrong) == 1 else f"{len(wrong)} vertices"
    return [
        Finding(
            "angles-open",
            Severity.WARNING,
            f"the fold angles around {where} miss closure by over {_CLOSURE_DEG:g} degrees; worst "
            f"is vertex {worst} at ({x:.6g}, {y:.6g}) mm, by {gaps[worst]:.4g} degrees. Faces "
            "cannot stay flat there: change its angles, or add a crease.",
        )
    ]


def inspect_crossings(crossings: IntArray) -> list[Finding]:
    """A finding where faces of the folded form cross: pairs of `crossing_faces`, shape (n, 2).

    A warning: the flat files are right, but what is folded from them stops short.
    """
    if not len(crossings):
        return []
    first, second = crossings[0]
    pairs = "1 crossing pair" if len(crossings) == 1 else f"{len(crossings)} crossing pairs"
    return [
        Finding(
            "sheet-crosses-itself",
            Severity.WARNING,
            f"the folded sheet passes through itself: {pairs} of faces, the first {first} and "
            f"{second}. The flat sheet can be cut, but no sheet can fold to the whole of this "
            "shape: grow fewer strips, or change flap angles or lengths.",
            panels=tuple(sorted({int(face) for face in crossings[:10].ravel()})),
        )
    ]
