"""Kerf compensation: the beam moved so that what it leaves has the outline that was asked for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely
from numpy.typing import NDArray

from fab.drawings.beam import Beam
from fab.errors import Finding, Severity, counted
from fab.geometry.rings import ring_areas
from fab.sheets.crease_cuts import SHORTEST_CUT_MM, require_kerf
from fab.sheets.narrow_gaps import Gaps, narrow_gaps
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["Compensated", "compensated"]

# Mitres reach at most this many half kerfs from their corner; sharper corners are cut off straight.
_MITRE_LIMIT = 5.0
# Moved rings are this share of the distance away at least: shapely simplifies by 1 % of it.
_MOVED_REL = 0.95
_ROUNDING_MM = 1e-9

Shapes = NDArray[np.object_]


@dataclass(frozen=True)
class Compensated:
    """Outlines as the beam follows them.

    Attributes
    ----------
    rings : closed polylines, each of shape (m, 2). None crosses or touches itself, and each runs
        the same way around as before.
    gaps : centre lines of what is narrower than the kerf, shape (n, 2, 2), and pierces.
    """

    rings: tuple[FloatArray, ...]
    gaps: FloatArray
    findings: tuple[Finding, ...]


def compensated(outlines: Sequence[FloatArray], kerf_mm: float | Beam) -> Compensated:
    """Outlines moved by half the kerf into what is thrown away, with mitred corners.

    Parameters
    ----------
    outlines : closed polylines, each of shape (m, 2), material on their left: counterclockwise
        rings are outer ones and grow, clockwise rings are holes and shrink.
    kerf_mm : width of the beam, or the beam as it is in the drawing. One that is wider along an
        axis is made round by a scale, and the moved outlines scaled back, so that they are moved by
        exactly its half: by their Minkowski sum with its ellipse but for mitres.

    Findings name what a beam cannot cut as drawn: a ring that crosses itself is returned as it is;
    a hole, a notch or a waist narrower than the kerf, and the rest of a wedge, are cut once, along
    their centre lines, and a hole no larger than the kerf is a pierce; neighbours come to cross
    each other. Corners and concave bends are exact but for shapely's simplification, up to 1 % of
    the distance.

    Raises `InvalidValue` for a kerf that is negative or wider than 10 mm.

    >>> square = np.array([[0.0, 0.0], [9.0, 0.0], [9.0, 9.0], [0.0, 9.0]])
    >>> moved = compensated([square], 0.2)
    >>> np.ptp(moved.rings[0], axis=0).round(6).tolist(), moved.findings
    ([9.2, 9.2], ())
    """
    beam = Beam.of(kerf_mm)
    require_kerf(beam)
    if beam.widest_mm == 0 or not outlines:
        return Compensated(tuple(outlines), np.empty((0, 2, 2)), ())
    if beam.is_round:
        moved = _moved(outlines, beam.x_mm)
    else:
        there = beam.to_round()
        moved = _moved([outline @ there.T for outline in outlines], beam.x_mm)
        moved = moved.back(np.linalg.inv(there).astype(np.float64))
    findings = (
        *_crossing_findings(outlines, np.flatnonzero(~moved.plain)),
        *_vanished_findings(outlines, moved.gaps, moved.vanished, beam.text),
        *_closed_findings(outlines, moved.gaps, ~moved.vanished, beam.text),
        *_meeting_findings(moved.lines, beam.text),
    )
    rings = [
        ring if moved.plain[of] else outlines[of]
        for ring, of in zip(moved.rings, moved.number.tolist(), strict=True)
    ]
    return Compensated(tuple(rings), moved.gaps.segments, findings)


@dataclass(frozen=True)
class _Moved:
    """Outlines moved by half the kerf.

    Attributes
    ----------
    rings, number : closed polylines, and the outline that each is of; lines : the same as shapes.
    gaps : what is cut along centre lines.
    plain, vanished : which outlines do not cross themselves, and of which nothing is left, (n,).
    """

    rings: tuple[FloatArray, ...]
    number: IntArray
    lines: Shapes
    gaps: Gaps
    plain: BoolArray
    vanished: BoolArray

    def back(self, matrix: FloatArray) -> _Moved:
        """The same with all points p moved to matrix @ p; pierces keep their length."""
        gaps, pierced = self.gaps.segments @ matrix.T, ~_are_lines(self.gaps)
        middle = gaps[pierced].mean(axis=1)
        gaps[pierced] = middle[:, None] + np.array([[-0.5, 0.0], [0.5, 0.0]]) * SHORTEST_CUT_MM
        return replace(
            self,
            rings=tuple(ring @ matrix.T for ring in self.rings),
            lines=shapely.transform(self.lines, lambda points: points @ matrix.T),
            gaps=replace(self.gaps, segments=gaps),
        )


def _moved(outlines: Sequence[FloatArray], kerf_mm: float) -> _Moved:
    """Outlines moved by half of the width of a round beam."""
    shapes = _polygons(outlines)
    plain = shapely.is_valid(shapes)
    outer = ring_areas(np.concatenate(outlines), _offsets(outlines)) > 0
    distance = np.where(outer, kerf_mm / 2, -kerf_mm / 2)
    moved = shapely.buffer(shapes, distance, join_style="mitre", mitre_limit=_MITRE_LIMIT)
    moved[~plain] = shapes[~plain]
    moved[plain] = _without_artefacts(moved[plain], shapes[plain], kerf_mm)
    lines, number, turned = _rings_of(moved, outer)
    corners, of_line = shapely.get_coordinates(lines, return_index=True)
    rings = np.split(corners, np.flatnonzero(np.diff(of_line)) + 1) if len(lines) else []
    kept = [
        ring[:-1][::-1] if back else ring[:-1]
        for ring, back in zip(rings, turned.tolist(), strict=True)
    ]
    vanished = plain & shapely.is_empty(moved)
    gaps = narrow_gaps(shapes, moved, outer, kerf_mm, plain)
    return _Moved(tuple(kept), number, lines, gaps, plain, vanished)


def _offsets(outlines: Sequence[FloatArray]) -> IntArray:
    """Where each outline begins among the corners of all, and their number, shape (n + 1,)."""
    return np.cumsum([0, *(len(outline) for outline in outlines)])


def _polygons(outlines: Sequence[FloatArray]) -> Shapes:
    """The figures within outlines, shape (n,)."""
    index = np.repeat(np.arange(len(outlines)), [len(outline) for outline in outlines])
    rings = shapely.linearrings(np.concatenate(outlines), indices=index)
    out: Shapes = shapely.polygons(rings)
    return out


def _without_artefacts(moved: Shapes, shapes: Shapes, kerf_mm: float) -> Shapes:
    """Moved figures without rings nearer to the outline than they were moved.

    GEOS leaves small ones where mitres meet in a narrow notch.
    """
    parts, of_part = shapely.get_parts(moved, return_index=True)
    full = np.flatnonzero(~shapely.is_empty(parts))
    rings, of_ring = shapely.get_rings(parts[full], return_index=True)
    of = of_part[full][of_ring]
    away = shapely.distance(rings, shapely.boundary(shapes[of]))
    far = away >= _MOVED_REL * kerf_mm / 2 - _ROUNDING_MM
    out = moved.copy()
    for number in np.unique(of[~far]).tolist():
        kept = []
        for part in np.flatnonzero(of_part[full] == number).tolist():
            own = np.flatnonzero(of_ring == part)
            if far[own[0]]:
                kept.append(shapely.Polygon(rings[own[0]], list(rings[own[1:][far[own[1:]]]])))
        out[number] = shapely.union_all(kept) if kept else shapely.Polygon()
    return out


def _rings_of(figures: Shapes, outer: BoolArray) -> tuple[Shapes, IntArray, BoolArray]:
    """All rings of figures, the figure that each is of, and whether it is to be reversed, (m,).

    outer : which figures are material, shape (n,). Material is to be on the left of all rings.
    """
    parts, of_part = shapely.get_parts(figures, return_index=True)
    full = ~shapely.is_empty(parts)
    lines, of_line = shapely.get_rings(parts[full], return_index=True)
    number = of_part[full][of_line]
    exterior = np.diff(of_line, prepend=-1) > 0
    turned = shapely.is_ccw(lines) != (outer[number] == exterior)
    return lines, number, turned


def _crossing_findings(outlines: Sequence[FloatArray], numbers: IntArray) -> list[Finding]:
    """Outlines that are not moved."""
    if not len(numbers):
        return []
    cross = (
        "crosses or touches itself and is"
        if len(numbers) == 1
        else "cross or touch themselves and are"
    )
    text = (
        f"{_named(outlines, numbers)} {cross} not moved by the kerf. Split the sheet into pieces."
    )
    return [Finding("outline-crosses-itself", Severity.ERROR, text)]


def _vanished_findings(
    outlines: Sequence[FloatArray], gaps: Gaps, vanished: BoolArray, kerf: str
) -> list[Finding]:
    """Holes that are cut along their centre lines, or pierced."""
    numbers = np.flatnonzero(vanished)
    if not len(numbers):
        return []
    are, them = ("is a hole", "it") if len(numbers) == 1 else ("are holes", "them")
    text = (
        f"{_named(outlines, numbers)} {are} nowhere wider than the kerf ({kerf}) and "
        f"{are.split()[0]} cut as {_cut_as(gaps, vanished)}. Enlarge {them}, or take a finer beam."
    )
    return [Finding("hole-narrower-than-kerf", Severity.WARNING, text)]


def _closed_findings(
    outlines: Sequence[FloatArray], gaps: Gaps, there: BoolArray, kerf: str
) -> list[Finding]:
    """Outlines with a notch or a waist that is cut along its centre line."""
    of = gaps.owner[there[gaps.owner]]
    if not len(of):
        return []
    numbers = np.unique(of)
    have = "has" if len(numbers) == 1 else "have"
    text = (
        f"{_named(outlines, numbers)} {have} a notch or a waist narrower than the kerf "
        f"({kerf}), cut as {_cut_as(gaps, there)}. Enlarge the sheet, or take a finer beam."
    )
    return [Finding("gap-narrower-than-kerf", Severity.WARNING, text)]


def _cut_as(gaps: Gaps, outlines: BoolArray) -> str:
    """How many centre lines, of which length, and pierces some of the outlines have."""
    own = outlines[gaps.owner]
    sides = gaps.segments[own]
    length = np.hypot(*(sides[:, 1] - sides[:, 0]).T)
    line = _are_lines(gaps)[own]
    pierces = int((~line).sum())
    lines = len(np.unique(gaps.line[own][line]))
    parts = []
    if lines:
        parts.append(f"{counted(lines, 'centre line')} of {length[line].sum():.4g} mm")
    if pierces:
        parts.append(counted(pierces, "pierce"))
    return " and ".join(parts)


def _are_lines(gaps: Gaps) -> BoolArray:
    """Which segments of gaps are no pierces, shape (n,)."""
    length = np.hypot(*(gaps.segments[:, 1] - gaps.segments[:, 0]).T)
    out: BoolArray = length > SHORTEST_CUT_MM * (1 + 1e-9)
    return out


def _named(outlines: Sequence[FloatArray], numbers: IntArray) -> str:
    """How many outlines are concerned, and where the first of them is."""
    x, y = outlines[numbers[0]].mean(axis=0).tolist()
    count, first = counted(len(outlines), "outline"), "" if len(numbers) == 1 else "the first "
    return f"{len(numbers)} of {count} ({first}around x = {x:.3f}, y = {y:.3f} mm)"


def _meeting_findings(lines: Shapes, kerf: str) -> list[Finding]:
    """Moved rings that cross each other."""
    if not len(lines):
        return []
    first, second = shapely.STRtree(lines).query(lines, predicate="intersects")
    met = np.flatnonzero(first < second)
    if not len(met):
        return []
    place = shapely.intersection(lines[first[met[0]]], lines[second[met[0]]])
    x, y = shapely.get_coordinates(place)[0].tolist()
    pairs = "1 pair of outlines is" if len(met) == 1 else f"{len(met)} pairs of outlines are"
    where = "" if len(met) == 1 else "the first "
    return [
        Finding(
            "outlines-nearer-than-kerf",
            Severity.WARNING,
            f"{pairs} nearer to each other than the kerf ({kerf}), {where}at "
            f"x = {x:.3f}, y = {y:.3f} mm: the beam that cuts one takes material from the other. "
            "Set them apart.",
        )
    ]
