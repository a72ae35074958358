"""Sheets whose rims meet at numbered points: what is said of them."""

from __future__ import annotations

from fab.errors import Finding, Severity, counted
from fab.pattern.meeting_rims import MeetingRims

__all__ = ["seam_findings"]


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
