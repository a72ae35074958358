"""Sheets of one surface relaxed together until vertices of their rims meet, to be glued there.

Each sheet is relaxed and trimmed alone, its rim jagged by up to half a cell. Vertices of two rims
that are nearest to each other are then drawn together, and made one point by a hard term, while all
sheets stay exact and near their offsets; those left over are tried after them. Rims that have other
numbers of vertices, or teeth beside teeth, do not meet everywhere.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from solver.measure import sector_angles
from solver.mesh import interior_vertices
from solver.nearest_pairs import nearest_pairs
from solver.relaxation.constraints import DevelopableVertices, MeetingVertices, PlanarFaces
from solver.relaxation.goal_terms import LeastSectors
from solver.relaxation.laying import rim_points
from solver.relaxation.method import Relaxation, RelaxationStatus, relax
from solver.relaxation.minimisation import Soft
from solver.relaxation.neighbours import opposite_pairs, sides
from solver.relaxation.objectives import (
    FoldBounds,
    LeastDistances,
    RimReach,
    SideLengths,
    SurfaceOffsets,
)
from solver.relaxation.terms import Term
from solver.targets.mesh_target import MeshTarget
from solver.targets.surface_mesh import SurfaceMesh
from solver.vectors import BoolArray, FloatArray, IntArray, norm

__all__ = ["RimSheet", "RimsMet", "met_rims"]

_ROUNDS = 80
# Weights of the terms, and how far at least sides and spans keep their lengths.
_SIDES, _RIM, _HEIGHT, _MEET = 1e-2, 0.1, 0.3, 1.0
_LEAST_SIDE, _LEAST_SPAN = 0.35, 0.5
_LEAST_SECTOR = np.radians(12)
_MOST_FOLD = 11 * np.pi / 12
# Sectors of a face, and gaps beside the faces at a vertex of the rim, are at least so wide.
_SLIM = np.radians(3)
# From so far inside, in steps, vertices are kept on their side of the rim.
_BESIDE = 1.5


@dataclass(frozen=True)
class RimSheet:
    """A sheet that was relaxed onto a part of a surface, and trimmed.

    Attributes
    ----------
    coords, faces_vertices : shapes (nv, 3) and (nf, 4). part : of the surface. step : of its cell.
    thickness : distance of the two offsets.
    """

    coords: FloatArray
    faces_vertices: IntArray
    part: SurfaceMesh
    step: float
    thickness: float


@dataclass(frozen=True)
class RimsMet:
    """Sheets with vertices that meet.

    Attributes
    ----------
    coords : of each sheet. deviations : of its inner vertices from their offsets, in units of the
        surface, for each sheet. distances : the largest one of its vertices from the surface.
        faulty : vertices, numbered through all sheets, whose faces are not convex, or overlap
        around them when they are flat. pairs : of vertices that are one point, numbered through all
        sheets, shape (n, 2).
    """

    coords: tuple[FloatArray, ...]
    deviations: tuple[FloatArray, ...]
    distances: tuple[float, ...]
    faulty: IntArray
    pairs: IntArray


def met_rims(
    target: MeshTarget,
    sheets: Sequence[RimSheet],
    before: IntArray,
    barred: IntArray,
    reach: float,
    interrupted: Callable[[], bool] | None = None,
) -> RimsMet | None:
    """The sheets with more vertices of their rims that meet.

    target : the whole surface. before : pairs that meet already, shape (n, 2), numbered through all
    sheets. barred : vertices that are not to meet any nor to be on the rim, shape (m,). reach :
    in steps, vertices farther apart do not meet. None where no further ones are that near each
    other, or where they cannot meet. interrupted : see `relax`; None then too.
    """
    union = _Union(target, tuple(sheets), barred)
    free = np.flatnonzero(union.rim)
    free = free[~np.isin(free, before) & ~np.isin(free, barred)]
    found = nearest_pairs(union.coords[free], union.sheet[free], reach * union.step)
    if not len(found):
        return None
    pairs = np.concatenate([before, free[found]])
    drawn = union.relaxed(union.coords, pairs, interrupted, hard=False)
    met = union.relaxed(drawn.coords, pairs, interrupted, hard=True)
    if met.status is not RelaxationStatus.RELAXED:
        return None
    off, owner = met.soft_values[0] * union.step, union.sheet[union.inner]
    far = np.abs(target.distance(met.coords, target.unknown(len(met.coords)))[0])
    numbers = range(len(sheets))
    return RimsMet(
        tuple(met.coords[union.sheet == number] for number in numbers),
        tuple(off[owner == number] for number in numbers),
        tuple(float(far[union.used & (union.sheet == number)].max()) for number in numbers),
        _faulty(met.coords, union.faces),
        pairs,
    )


def _faulty(coords: FloatArray, faces: IntArray) -> IntArray:
    """Vertices of faces that are not convex, and those whose sectors leave no gap at the rim."""
    convex = LeastSectors.of(faces, _SLIM)
    slim = convex.vertices[convex.linearised(coords).values < 0].ravel()
    around = np.bincount(faces.ravel(), sector_angles(coords, faces).ravel(), len(coords))
    rim = ~interior_vertices(faces, len(coords))
    return np.union1d(slim, np.flatnonzero(rim & (around > 2 * np.pi - _SLIM)))


class _Union:
    """All sheets as one mesh in as many pieces."""

    def __init__(self, target: MeshTarget, sheets: tuple[RimSheet, ...], barred: IntArray) -> None:
        counts = np.array([len(sheet.coords) for sheet in sheets])
        starts = np.cumsum(counts) - counts
        self.target, self.sheets = target, sheets
        self.coords = np.concatenate([sheet.coords for sheet in sheets])
        self.sheet = np.repeat(np.arange(len(sheets)), counts)
        self.faces = np.concatenate(
            [sheet.faces_vertices + start for sheet, start in zip(sheets, starts, strict=True)]
        )
        self.step = max(sheet.step for sheet in sheets)
        used = np.bincount(self.faces.ravel(), minlength=len(self.coords)) > 0
        inside = interior_vertices(self.faces, len(self.coords))
        self.used, self.inner, self.rim = used, np.flatnonzero(inside), used & ~inside
        bounded = used.copy()
        bounded[barred] = False
        self.soft = self._soft(bounded)

    def relaxed(
        self,
        start: FloatArray,
        pairs: IntArray,
        interrupted: Callable[[], bool] | None,
        *,
        hard: bool,
    ) -> Relaxation:
        """All sheets with the pairs drawn together, or as one point each (`hard`)."""
        meeting = MeetingVertices.of(pairs, self.step)
        terms: list[Term] = [
            PlanarFaces(self.faces),
            DevelopableVertices.of(self.faces, len(self.coords)),
        ]
        return relax(
            start,
            [*terms, meeting] if hard else terms,
            self.soft if hard else [*self.soft, Soft(meeting, _MEET)],
            self.step,
            rounds=_ROUNDS,
            interrupted=interrupted,
        )

    def _soft(self, bounded: BoolArray) -> list[Soft]:
        target, coords, inner = self.target, self.coords, self.inner
        thickness = np.array([sheet.thickness for sheet in self.sheets])[self.sheet[inner]]
        distances, _, places = target.distance(coords[inner], target.unknown(len(inner)))
        offsets = np.where(distances > 0, thickness / 2, -thickness / 2)
        rim = np.flatnonzero(self.rim)
        heights, _, feet = target.distance(coords[rim], target.unknown(len(rim)))
        edges, spans = sides(self.faces), opposite_pairs(self.faces, len(coords))
        lengths, spanned = (norm(coords[p[:, 1]] - coords[p[:, 0]]) for p in (edges, spans))
        least = np.minimum(lengths, _LEAST_SIDE * float(np.median(lengths)))
        return [
            Soft(SurfaceOffsets(target, inner[:, None], offsets, self.step, places)),
            Soft(SurfaceOffsets(target, rim[:, None], heights, self.step, feet), _HEIGHT),
            Soft(SideLengths(edges, lengths), _SIDES),
            Soft(LeastDistances(edges, least)),
            Soft(LeastDistances(spans, _LEAST_SPAN * spanned)),
            Soft(LeastSectors.of(self.faces, _LEAST_SECTOR)),
            Soft(FoldBounds.of(self.faces, coords, _MOST_FOLD)),
            Soft(self._planes(bounded), _RIM),
        ]

    def _planes(self, bounded: BoolArray) -> RimReach:
        """Planes across the rims of parts: all vertices on one side, those of rims on them."""
        vertices, directions, points = [], [], []
        for number, sheet in enumerate(self.sheets):
            own = np.flatnonzero(bounded & (self.sheet == number))
            foot, ahead = rim_points(MeshTarget(sheet.part), self.step)
            gap, near = cKDTree(foot).query(self.coords[own])
            own, near = own[gap <= _BESIDE * self.step], near[gap <= _BESIDE * self.step]
            outer = self.rim[own]
            vertices += [own, own[outer]]
            directions += [-ahead[near], ahead[near[outer]]]
            points += [foot[near], foot[near[outer]]]
        return RimReach(
            np.concatenate(vertices)[:, None],
            np.concatenate(directions),
            np.concatenate(points),
            self.step,
        )
