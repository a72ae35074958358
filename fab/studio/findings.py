"""Findings as the page lists them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from fab.errors import Finding
from fab.pattern.crease_pattern import CreasePattern

__all__ = ["listed"]

# The page says how many there are.
_LISTED = 50


def listed(
    findings: Sequence[Finding], pattern: CreasePattern | None = None
) -> list[dict[str, Any]]:
    """The first findings, with numbers of creases and panels that the pattern has."""
    creases = len(pattern.edges_vertices) if pattern is not None else 0
    panels = pattern.face_count if pattern is not None else 0
    return [
        {
            "code": finding.code,
            "severity": finding.severity.value,
            "text": finding.text,
            "creases": [edge for edge in finding.creases if edge < creases],
            "panels": [face for face in finding.panels if face < panels],
        }
        for finding in findings[:_LISTED]
    ]
