"""Where does a vertex need a hole, so that the ends of its creases do not tear the sheet?"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from typing import Literal

import numpy as np
import shapely
from pydantic import Field

from fab.errors import Finding, Severity
from fab.pattern.crease_pattern import CreasePattern
from fab.pattern.sectors import sectors_of
from fab.settings import Settings
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["ReliefHoles", "ReliefSettings", "relief_holes"]

# Round holes are drawn as polygons that deviate from the circle by at most this.
_CHORD_MM = 0.005
# A straight line of two creases folds without a hole.
_LEAST_DEGREE = 3


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
    walls : those of them that are outlines and inner cuts; where one ends, no hole is needed.
    marks : those of them that are only engraved, and weaken nothing.

    Between neighbouring creases a web is left whose chord at the rim, 2 r sin(a / 2) for the
    sector angle a, is at least `web_mm`: the smallest sector sets the radius. Holes that would come
    nearer than `web_mm` to another hole, to an outline or to a crease of another vertex are left
    out, larger ones before smaller ones, and named in a finding.
    """
    sectors = sectors_of(pattern, lines & ~marks)
    vertices, first, degree = np.unique(sectors.vertices, return_index=True, return_counts=True)
    radii = np.zeros(len(pattern.vertices_coords))
    if not len(vertices):
        return ReliefHoles(radii, ()), []
    smallest = np.minimum.reduceat(sectors.angles, first)
    walled = np.logical_or.reduceat(walls[sectors.edges], first)
    wanted = (degree >= _LEAST_DEGREE) & ~walled
    vertices, first, degree = vertices[wanted], first[wanted], degree[wanted]
    chord = 2 * np.sin(smallest[wanted] / 2)
    findings = []
    if settings.radius_mm is None:
        with np.errstate(divide="ignore"):
            radius = settings.web_mm / chord
    else:
        radius = np.full(len(vertices), settings.radius_mm)
        thin = vertices[radius * chord < settings.web_mm * (1 - 1e-12)]
        if len(thin):
            findings.append(
                _finding(
                    "relief-web-thin",
                    pattern,
                    thin,
                    f"leave webs below web_mm = {settings.web_mm:g} between their creases. Raise "
                    "radius_mm, or leave it out.",
                )
            )
    kept = _clear(pattern, np.flatnonzero(lines), vertices, radius, settings.web_mm)
    if not kept.all():
        findings.append(
            _finding(
                "relief-left-out",
                pattern,
                vertices[~kept],
                f"would come nearer than web_mm = {settings.web_mm:g} to another hole, to the "
                "outline or to a crease that they do not belong to, and are left out. Lower "
                "web_mm or radius_mm, or enlarge the sheet.",
            )
        )
    radii[vertices[kept]] = radius[kept]
    rings = []
    for vertex, begin, count in zip(vertices[kept], first[kept], degree[kept], strict=True):
        r = radii[vertex]
        if settings.shape == "round":
            around = _clockwise_circle(_corners_of_circle(r))
        else:
            turn = _cornered(sectors.directions[begin : begin + count])[::-1]
            around = np.column_stack([np.cos(turn), np.sin(turn)])
        rings.append(pattern.vertices_coords[vertex] + r * around)
    return ReliefHoles(radii, tuple(rings)), findings


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
    """Which holes keep a web to all lines that do not end in them, and to each other."""
    kept: BoolArray = np.isfinite(radius)
    points = shapely.points(pattern.vertices_coords[vertices])
    ends = pattern.edges_vertices[lines]
    tree = shapely.STRtree(shapely.linestrings(pattern.vertices_coords[ends]))
    reach = np.where(kept, radius, 0.0) + web_mm
    hole, line = tree.query(points, predicate="dwithin", distance=reach)
    foreign = (ends[line] != vertices[hole, None]).all(axis=1)
    kept[hole[foreign]] = False
    alone = np.flatnonzero(kept)
    if not len(alone):
        return kept
    tree = shapely.STRtree(points[alone])
    wide = radius[alone] + radius[alone].max() + web_mm
    one, two = alone[tree.query(points[alone], predicate="dwithin", distance=wide)]
    apart = pattern.vertices_coords[vertices[one]] - pattern.vertices_coords[vertices[two]]
    meets = np.hypot(apart[:, 0], apart[:, 1]) < radius[one] + radius[two] + web_mm
    rivals: dict[int, list[int]] = {}
    for i, j in np.column_stack([one, two])[meets & (one != two)].tolist():
        rivals.setdefault(i, []).append(j)
    taken: set[int] = set()
    for i in sorted(rivals, key=lambda i: (radius[i], i)):
        if taken.isdisjoint(rivals[i]):
            taken.add(i)
        else:
            kept[i] = False
    return kept


def _finding(code: str, pattern: CreasePattern, vertices: IntArray, text: str) -> Finding:
    names = ", ".join(str(vertex) for vertex in vertices[:10].tolist())
    at = np.isin(pattern.edges_vertices, vertices[:10]).any(axis=1)
    return Finding(
        code,
        Severity.WARNING,
        f"{len(vertices)} relief holes (at vertices {names}{', ...' if len(vertices) > 10 else ''})"
        f" {text}",
        creases=tuple(np.flatnonzero(at)[:20].tolist()),
    )
