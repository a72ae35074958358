"""Relief holes at vertices, so that the ends of their creases do not tear the sheet."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from typing import Literal

import numpy as np
import shapely
from pydantic import Field

from fab.errors import Finding, Severity, counted, first_few
from fab.pattern.crease_pattern import CreasePattern
from fab.pattern.sectors import Sectors, sectors_of
from fab.settings import Settings
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["ReliefHoles", "ReliefSettings", "relief_holes"]

# Round holes are drawn as polygons that deviate from the circle by at most this.
_CHORD_MM = 0.005
# A straight line of two creases folds without a hole.
_LEAST_DEGREE = 3
# A finding names up to this many vertices.
_NAMED = 10


class ReliefSettings(Settings):
    """Holes at interior vertices where at least three creases are cut."""

    shape: Literal["round", "polygon"] = Field(
        default="round", description="polygon: a corner on every crease"
    )
    web_mm: float = Field(
        ge=0.01, le=1000, description="least width of the material between two creases at the hole"
    )
    radius_mm: float | None = Field(
        default=None,
        ge=0.01,
        le=1000,
        description="of all holes; where left out, as small as the web allows",
    )


@dataclass(frozen=True)
class ReliefHoles:
    """The holes of a pattern, mm.

    Attributes
    ----------
    radii_mm : shape (nv,), 0 where a vertex has no hole.
    rings : closed polylines, clockwise, each of shape (m, 2), by rising vertex.
    """

    radii_mm: FloatArray
    rings: tuple[FloatArray, ...]


def relief_holes(
    pattern: CreasePattern,
    lines: BoolArray,
    walls: BoolArray,
    marks: BoolArray,
    settings: ReliefSettings,
) -> tuple[ReliefHoles, list[Finding]]:
    """A hole at each vertex with three or more cut creases and nothing but creases around it.

    Parameters
    ----------
    lines : shape (ne,), the edges along which anything is drawn.
    walls : which of them are outlines and inner cuts; where one ends, no hole is needed.
    marks : which of them are only engraved, and weaken nothing.

    Between neighbouring creases a web is left whose chord at the rim, 2 r sin(a / 2) for the
    sector angle a, is at least `web_mm`: the smallest sector sets the radius. Holes that would be
    nearer than `web_mm` to another hole, to an outline or to a crease of another vertex are left
    out, larger ones before smaller ones, with a finding.
    """
    sectors = sectors_of(pattern, lines & ~marks)
    spots = _spots(sectors, walls)
    chord = 2 * np.sin(spots.smallest / 2)
    findings = []
    if settings.radius_mm is None:
        with np.errstate(divide="ignore"):
            radius = settings.web_mm / chord
    else:
        radius = np.full(len(chord), settings.radius_mm)
        thin = spots.vertices[radius * chord < settings.web_mm * (1 - 1e-12)]
        findings += _thin_findings(pattern, thin, settings.web_mm)
    kept = _clear(pattern, np.flatnonzero(lines), spots.vertices, radius, settings.web_mm)
    findings += _left_out_findings(pattern, spots.vertices[~kept], settings.web_mm)
    radii = np.zeros(len(pattern.vertices_coords))
    radii[spots.vertices[kept]] = radius[kept]
    rings = []
    for spot in np.flatnonzero(kept).tolist():
        if settings.shape == "round":
            around = _clockwise_circle(_corners_of_circle(radius[spot]))
        else:
            around = _clockwise_polygon(sectors.directions[spots.ends(spot)])
        middle = pattern.vertices_coords[spots.vertices[spot]]
        rings.append(middle + radius[spot] * around)
    return ReliefHoles(radii, tuple(rings)), findings


@dataclass(frozen=True)
class _Spots:
    """Vertices that are to have a hole.

    Attributes
    ----------
    vertices : rising, shape (n,).
    first, degree : the first of each vertex' line ends among all sectors, and their number.
    smallest : the smallest sector at each, radians.
    """

    vertices: IntArray
    first: IntArray
    degree: IntArray
    smallest: FloatArray

    def ends(self, spot: int) -> slice:
        """The line ends at a vertex, among all sectors."""
        return slice(self.first[spot], self.first[spot] + self.degree[spot])


def _spots(sectors: Sectors, walls: BoolArray) -> _Spots:
    """The vertices where at least three lines meet and none of them is a wall."""
    vertices, first, degree = np.unique(sectors.vertices, return_index=True, return_counts=True)
    if not len(vertices):
        return _Spots(vertices, first, degree, np.empty(0))
    smallest = np.minimum.reduceat(sectors.angles, first)
    walled = np.logical_or.reduceat(walls[sectors.edges], first)
    wanted = (degree >= _LEAST_DEGREE) & ~walled
    return _Spots(vertices[wanted], first[wanted], degree[wanted], smallest[wanted])


def _corners_of_circle(radius: float) -> int:
    """How many corners keep a polygon within `_CHORD_MM` of its circle."""
    half = math.acos(max(1 - _CHORD_MM / radius, 0.0))
    return max(16, math.ceil(math.pi / half))


@cache
def _clockwise_circle(corners: int) -> FloatArray:
    """Corners of a regular polygon in the unit circle, shape (corners, 2)."""
    turn = np.linspace(0, -2 * np.pi, corners, endpoint=False)
    out: FloatArray = np.column_stack([np.cos(turn), np.sin(turn)])
    return out


def _clockwise_polygon(directions: FloatArray) -> FloatArray:
    """Points of the unit circle in some directions, rising, and in wide sectors between them."""
    turn = _cornered(directions)[::-1]
    out: FloatArray = np.column_stack([np.cos(turn), np.sin(turn)])
    return out


def _cornered(directions: FloatArray) -> FloatArray:
    """The directions, with more of them where sectors are wider than a third of a turn."""
    angle = np.diff(directions, append=directions[0] + 2 * np.pi)
    share = np.maximum(1, np.ceil(angle / (2 * np.pi / 3) - 1e-9)).astype(np.int64)
    begin = np.repeat(directions, share)
    number = np.arange(len(begin)) - np.repeat(np.cumsum(share) - share, share)
    out: FloatArray = begin + number * np.repeat(angle / share, share)
    return out


def _clear(
    pattern: CreasePattern, lines: IntArray, vertices: IntArray, radius: FloatArray, web_mm: float
) -> BoolArray:
    """Which holes keep a web to all lines not ending in them, and to each other, shape (n,)."""
    kept: BoolArray = np.isfinite(radius)
    points = shapely.points(pattern.vertices_coords[vertices])
    ends = pattern.edges_vertices[lines]
    tree = shapely.STRtree(shapely.linestrings(pattern.vertices_coords[ends]))
    reach = np.where(kept, radius, 0.0) + web_mm
    hole, line = tree.query(points, predicate="dwithin", distance=reach)
    foreign = (ends[line] != vertices[hole, None]).all(axis=1)
    kept[hole[foreign]] = False
    return _without_rivals(pattern, vertices, radius, web_mm, kept)


def _without_rivals(
    pattern: CreasePattern, vertices: IntArray, radius: FloatArray, web_mm: float, good: BoolArray
) -> BoolArray:
    """Which good holes stay when of those too near to each other the larger are left out."""
    kept = good.copy()
    alone = np.flatnonzero(good)
    if not len(alone):
        return kept
    points = shapely.points(pattern.vertices_coords[vertices[alone]])
    reach = radius[alone] + radius[alone].max() + web_mm
    near = shapely.STRtree(points).query(points, predicate="dwithin", distance=reach)
    a, b = alone[near]
    apart = pattern.vertices_coords[vertices[a]] - pattern.vertices_coords[vertices[b]]
    meets = np.hypot(apart[:, 0], apart[:, 1]) < radius[a] + radius[b] + web_mm
    rivals: dict[int, list[int]] = {}
    for i, j in np.column_stack([a, b])[meets & (a != b)].tolist():
        rivals.setdefault(i, []).append(j)
    taken: set[int] = set()
    for i in sorted(rivals, key=lambda i: (radius[i], i)):
        if taken.isdisjoint(rivals[i]):
            taken.add(i)
        else:
            kept[i] = False
    return kept


def _thin_findings(pattern: CreasePattern, vertices: IntArray, web_mm: float) -> list[Finding]:
    """Holes that are smaller than their webs need."""
    if not len(vertices):
        return []
    leave, their = ("leaves", "its") if len(vertices) == 1 else ("leave", "their")
    text = (
        f"{_named(vertices)} {leave} webs below web_mm = {web_mm:g} between {their} creases. Raise "
        "radius_mm, or leave it out."
    )
    return [_finding("relief-web-thin", pattern, vertices, text)]


def _left_out_findings(pattern: CreasePattern, vertices: IntArray, web_mm: float) -> list[Finding]:
    """Holes that have no room."""
    if not len(vertices):
        return []
    they, are = ("it does", "is") if len(vertices) == 1 else ("they do", "are")
    text = (
        f"{_named(vertices)} would come nearer than web_mm = {web_mm:g} to another hole, to the "
        f"outline or to a crease that {they} not belong to, and {are} left out. Lower web_mm or "
        "radius_mm, or enlarge the sheet."
    )
    return [_finding("relief-left-out", pattern, vertices, text)]


def _named(vertices: IntArray) -> str:
    """How many holes are concerned, and the first of their vertices."""
    numbers = ", ".join(str(vertex) for vertex in vertices[:_NAMED].tolist())
    more = ", ..." if len(vertices) > _NAMED else ""
    at = "vertex" if len(vertices) == 1 else "vertices"
    return f"{counted(len(vertices), 'relief hole')} (at {at} {numbers}{more})"


def _finding(code: str, pattern: CreasePattern, vertices: IntArray, text: str) -> Finding:
    """A finding with the creases at the vertices that are named."""
    at = np.isin(pattern.edges_vertices, vertices[:_NAMED]).any(axis=1)
    return Finding(code, Severity.WARNING, text, creases=first_few(np.flatnonzero(at)))
