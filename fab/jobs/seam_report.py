"""Sheets whose rims meet at numbered points: what is said of them, and engraved on them."""

from __future__ import annotations

import numpy as np

from fab.drawings.cut_paths import Layer
from fab.errors import Finding, Severity, counted
from fab.pattern.crease_pattern import CreasePattern
from fab.pattern.meeting_rims import MeetingRims

__all__ = ["seam_findings", "seam_marks"]

# Greatest height of the numbers, mm.
_LABEL_MM = 4.0
# Numbers are in the middle of this share of an edge, from its vertex that has the number.
_BESIDE = 0.5


def seam_findings(meeting: MeetingRims) -> list[Finding]:
    """That rims meet, at how many points, and how far apart they are at others."""
    points, touching = len(meeting.vertices), int(meeting.touching.sum())
    text = (
        f"rims of the sheets are glued together at {counted(points, 'numbered point')}; the same "
        f"number is on both sheets. Folded, {touching} of them touch"
    )
    if touching < points:
        text += f", others are up to {meeting.gaps_mm.max():.3g} mm apart"
    gaps = meeting.rim_gaps_mm
    if not meeting.touching.all() or gaps.max() > meeting.gaps_mm.max():
        text += (
            f". All along the seam rims are {gaps.mean():.3g} mm apart on average, "
            f"{gaps.max():.3g} mm at most: strips across it hold what is between the points"
        )
    return [Finding("rims-meet", Severity.NOTE, f"{text}.")]


def seam_marks(pattern: CreasePattern, meeting: MeetingRims) -> list[Layer]:
    """The numbers, engraved beside their vertices on both sheets, where there is room."""
    from fab.sheets.labels import engraved
    from fab.sheets.piece_labels import SeamNumbers, number_labels

    edges = meeting.edges.T.ravel()
    lines = pattern.vertices_coords[pattern.edges_vertices[edges]].copy()
    count = len(meeting.edges)
    # the first edge starts at its vertex, the second one ends there
    lines[:count, 1] = lines[:count, 0] + _BESIDE * (lines[:count, 1] - lines[:count, 0])
    lines[count:, 0] = lines[count:, 1] + _BESIDE * (lines[count:, 0] - lines[count:, 1])
    numbers = SeamNumbers(np.tile(np.arange(1, count + 1), 2), pattern.edges_faces[edges, 0], lines)
    labels = number_labels(pattern, numbers, _LABEL_MM)
    return [engraved([label for label in labels if label is not None])]
