"""Where must the beam run so that what it leaves has the outline that was asked for?"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely

from fab.errors import Finding, Severity
from fab.geometry.rings import ring_areas
from fab.sheets.crease_styles import require_kerf
from solver.vectors import FloatArray

__all__ = ["compensated"]

# Mitres reach at most this many half kerfs from their corner; sharper corners are cut off straight.
_MITRE_LIMIT = 5.0


def compensated(
    outlines: Sequence[FloatArray], kerf_mm: float
) -> tuple[tuple[FloatArray, ...], list[Finding]]:
    """Outlines moved by half the kerf into what is thrown away, with mitred corners.

    Parameters
    ----------
    outlines : closed polylines, each of shape (m, 2), material on their left: counterclockwise
        rings are outer ones and grow, clockwise rings are holes and shrink.

    No ring that comes out crosses or touches itself, each runs the same way around as before. A
    ring that crosses itself is returned as it is, with a finding; a hole narrower than the kerf is
    left out, with a finding; a notch narrower than the kerf is closed, a waist of a hole splits it,
    with a finding; so are neighbours that come to cross each other. Corners and concave bends are
    exact but for shapely's simplification, up to 1 % of the distance.

    Raises `InvalidValue` for a kerf that is negative.
    """
    require_kerf(kerf_mm)
    if kerf_mm == 0 or not outlines:
        return tuple(outlines), []
    sizes = [len(outline) for outline in outlines]
    corners = np.concatenate(outlines)
    outer = ring_areas(corners, np.cumsum([0, *sizes])) > 0
    shapes = shapely.polygons(
        shapely.linearrings(corners, indices=np.repeat(np.arange(len(outlines)), sizes))
    )
    plain = shapely.is_valid(shapes)
    distance = np.where(outer, kerf_mm / 2, -kerf_mm / 2)
    moved = shapely.buffer(shapes, distance, join_style="mitre", mitre_limit=_MITRE_LIMIT)
    moved[~plain] = shapes[~plain]
    parts, of_part = shapely.get_parts(moved, return_index=True)
    full = ~shapely.is_empty(parts)
    lines, of_line = shapely.get_rings(parts[full], return_index=True)
    number = of_part[full][of_line]
    exterior = np.diff(of_line, prepend=-1) > 0
    turned = shapely.is_ccw(lines) != (outer[number] == exterior)
    points, of_point = shapely.get_coordinates(lines, return_index=True)
    closed_rings = np.split(points, np.flatnonzero(np.diff(of_point)) + 1) if len(lines) else []
    rings = []
    for ring, of, back in zip(closed_rings, number.tolist(), turned.tolist(), strict=True):
        whole = ring[:-1][::-1] if back else ring[:-1]
        rings.append(whole if plain[of] else outlines[of])
    count = np.bincount(number, minlength=len(outlines))
    crossing = np.flatnonzero(~plain).tolist()
    vanished = np.flatnonzero(plain & (count == 0)).tolist()
    closed = np.flatnonzero(plain & (count > 1)).tolist()
    findings = []
    if crossing:
        findings.append(
            _finding(
                "outline-crosses-itself",
                Severity.ERROR,
                crossing,
                outlines,
                "cross or touch themselves and are not moved by the kerf. Split the sheet into "
                "pieces.",
            )
        )
    if vanished:
        findings.append(
            _finding(
                "hole-narrower-than-kerf",
                Severity.WARNING,
                vanished,
                outlines,
                f"are holes nowhere wider than the kerf ({kerf_mm:g} mm) and are left out. Enlarge "
                "them.",
            )
        )
    if closed:
        findings.append(
            _finding(
                "gap-narrower-than-kerf",
                Severity.WARNING,
                closed,
                outlines,
                f"have a notch or a waist narrower than the kerf ({kerf_mm:g} mm), which is not "
                "cut. Enlarge the sheet, or take a finer beam.",
            )
        )
    return tuple(rings), findings + _meeting(lines, kerf_mm)


def _finding(
    code: str,
    severity: Severity,
    numbers: list[int],
    outlines: Sequence[FloatArray],
    text: str,
) -> Finding:
    x, y = outlines[numbers[0]].mean(axis=0).tolist()
    return Finding(
        code,
        severity,
        f"{len(numbers)} of {len(outlines)} outlines (the first around x = {x:.3f}, y = {y:.3f} "
        f"mm) {text}",
    )


def _meeting(lines: Sequence[shapely.LinearRing], kerf_mm: float) -> list[Finding]:
    """A finding where moved rings cross each other."""
    if not len(lines):
        return []
    one, two = shapely.STRtree(lines).query(lines, predicate="intersects")
    met = np.flatnonzero(one < two)
    if not len(met):
        return []
    place = shapely.intersection(lines[one[met[0]]], lines[two[met[0]]])
    x, y = shapely.get_coordinates(place)[0].tolist()
    return [
        Finding(
            "outlines-nearer-than-kerf",
            Severity.WARNING,
            f"{len(met)} pairs of outlines are nearer to each other than the kerf ({kerf_mm:g} mm),"
            f" the first at x = {x:.3f}, y = {y:.3f} mm: there the beam takes from one what it "
            "cuts around the other. Set them apart.",
        )
    ]
