"""A pleated sheet relaxed onto a surface, from coarse to fine.

Large zigzags (two or three steps) reach furthest on domes: each cell can then be much wider or
narrower than others without its folds closing. A hemisphere is covered so by 160 columns. Sheets
with cells left out begin with all their vertices: carried over from larger cells, those at a jagged
rim begin further off than on their own offsets, and as many rounds are needed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from solver.goals import Bounds, PanelRoom
from solver.mesh import QuadMesh
from solver.relaxation.constraints import DevelopableVertices, FlatFoldableVertices, PlanarFaces
from solver.relaxation.goal_terms import AlikePanels, LeastRooms, LeastSectors
from solver.relaxation.method import Relaxation, relax
from solver.relaxation.minimisation import Soft
from solver.relaxation.neighbours import opposite_pairs, sides
from solver.relaxation.objectives import (
    FoldBounds,
    LeastDistances,
    RimReach,
    SideLengths,
    SurfaceOffsets,
)
from solver.relaxation.pleats import PleatedSheet, prolonged
from solver.relaxation.terms import Term
from solver.targets.base import Target
from solver.vectors import BoolArray, FloatArray, unit

__all__ = ["SheetFit", "Wishes", "relaxed_sheet", "sheet_terms"]

# Sheets of more rows than this begin with one of half the resolution.
_ROWS_AT_ONCE = 30
# A coarse sheet need not be exact: rounds that it has at most.
_COARSE_ROUNDS = 60


@dataclass(frozen=True)
class Wishes:
    """Soft terms of a sheet on a surface, and whether it folds rigidly.

    Attributes
    ----------
    rigid : whether all vertices are flat-foldable too, a hard term: no freedom is left inside the
        sheet, which then follows the surface only about.
    least_side : least length of sides, over that in the cell.
    least_span : least distance of vertices two apart, over that in the cell.
    bounds : of sides, inradii, sectors, folds, room for panels, and alike panels, whose templates
        must be known.
    most_fold : largest fold angle, radians, or None: beyond 165 degrees pleats soon cross.
    offset, rim, side, least, fold, bound : weights of the soft terms; `least` is that of both least
        distances, `bound` that of inradii, sectors, room for panels and alike panels. With rim = 0
        a sheet may draw back from the rim of its surface, far so where the surface is domed, and is
        nearer to its offsets for it.
    """

    rigid: bool = False
    least_side: float = 0.4
    least_span: float = 0.2
    bounds: Bounds = field(default_factory=Bounds)
    most_fold: float | None = 11 * np.pi / 12
    offset: float = 1.0
    rim: float = 0.1
    side: float = 3e-3
    least: float = 1.0
    fold: float = 1.0
    bound: float = 1.0


@dataclass(frozen=True)
class SheetFit:
    """A sheet on a surface.

    Attributes
    ----------
    mesh : the sheet. relaxation : how it was found; of the finest level.
    deviations : signed distances of the held vertices from their offsets, in steps of the cell,
        shape (n,). coarse_rounds : rounds of all coarser levels together.
    """

    mesh: QuadMesh
    relaxation: Relaxation
    deviations: FloatArray
    coarse_rounds: int


def relaxed_sheet(
    target: Target,
    sheet: PleatedSheet,
    wishes: Wishes | None = None,
    *,
    held: BoolArray | None = None,
    rim: RimReach | None = None,
    start: FloatArray | None = None,
    rounds: int = 200,
    progress: Callable[[int, float], None] | None = None,
    interrupted: Callable[[], bool] | None = None,
) -> SheetFit:
    """The sheet whose faces are planar, vertices developable, nearest to its offsets and cell.

    Parameters
    ----------
    wishes : soft terms; None for the usual ones.
    held : vertices that follow the surface, shape (R C,); None for all. Others, such as those
        beyond its rim, only continue the sheet.
    rim : planes that the sheet reaches; None for those across the rim of its first points.
    start : coordinates to begin with, shape (R C, 3); None: the sheet on its offsets, or, where it
        is a whole grid of more than 30 rows, as a relaxed sheet of half the resolution has it.
    rounds, progress, interrupted : see `relax`; the last two are of the coarser levels too.

    >>> from solver.relaxation import pleated_patch
    >>> from solver.targets import explicit_surface
    >>> bump = explicit_surface(lambda x, y: 0.3 * np.exp(-2 * (x**2 + y**2)))
    >>> sheet = pleated_patch(bump, 8, zigzag=1.5, spacing=1.2, thickness=1.2)
    >>> fit = relaxed_sheet(bump, sheet)
    >>> fit.relaxation.status, bool(np.abs(fit.deviations).mean() < 0.01)
    (<RelaxationStatus.RELAXED: 'relaxed'>, True)
    """
    wishes = wishes or Wishes()
    coarse_rounds = 0
    if start is None:
        start = sheet.points(target)
        if sheet.shape[0] > _ROWS_AT_ONCE and sheet.kept is None:
            half = sheet.halved()
            coarse = relaxed_sheet(
                target,
                half,
                wishes,
                held=None if held is None else _resampled(held, sheet, half),
                rounds=min(rounds, _COARSE_ROUNDS),
                progress=progress,
                interrupted=interrupted,
            )
            coarse_rounds = coarse.coarse_rounds + coarse.relaxation.rounds
            start = prolonged(half, coarse.relaxation.coords, sheet, target)
    hard, soft = sheet_terms(target, sheet, wishes, held, rim, start)
    done = relax(
        start,
        hard,
        soft,
        sheet.cell.step,
        rounds=rounds,
        progress=progress,
        interrupted=interrupted,
    )
    return SheetFit(sheet.mesh(done.coords), done, done.soft_values[0], coarse_rounds)


def sheet_terms(
    target: Target,
    sheet: PleatedSheet,
    wishes: Wishes,
    held: BoolArray | None = None,
    rim: RimReach | None = None,
    start: FloatArray | None = None,
) -> tuple[list[Term], list[Soft]]:
    """Hard and soft terms of a sheet on a surface; the first soft one is that of its offsets.

    held, rim, start : see `relaxed_sheet`; fold angles are followed from those at the start.
    """
    first = sheet.points(target)
    faces, count = sheet.faces_vertices, len(first)
    hard: list[Term] = [PlanarFaces(faces), DevelopableVertices.of(faces, count)]
    if wishes.rigid:
        hard.append(FlatFoldableVertices.of(faces, count))
    used = np.bincount(faces.ravel(), minlength=count) > 0
    followed = np.flatnonzero(used if held is None else used & held)
    edges, spans = sides(faces), opposite_pairs(faces, count)
    lengths, bounds = sheet.side_lengths(edges), wishes.bounds
    soft = [
        Soft(
            SurfaceOffsets(
                target,
                followed[:, None],
                sheet.offsets[followed],
                sheet.cell.step,
                target.places(sheet.uv[followed]),
            ),
            wishes.offset,
        ),
        Soft(SideLengths(edges, lengths), wishes.side),
        Soft(
            LeastDistances(edges, np.maximum(wishes.least_side * lengths, bounds.least_side)),
            wishes.least,
        ),
        Soft(LeastDistances(spans, wishes.least_span * sheet.spans(spans)), wishes.least),
    ]
    if wishes.rim:
        soft.append(Soft(_rim(sheet, first) if rim is None else rim, wishes.rim))
    most = np.pi if wishes.most_fold is None else wishes.most_fold
    if min(most, bounds.most_fold) < np.pi:
        begun = first if start is None else start
        term = FoldBounds.of(faces, begun, min(most, bounds.most_fold))
        soft.append(Soft(term, wishes.fold))
    if bounds.least_sector:
        soft.append(Soft(LeastSectors.of(faces, bounds.least_sector), wishes.bound))
    rooms = [PanelRoom(_no_setbacks, bounds.least_inradius)] if bounds.least_inradius else []
    for room in rooms if bounds.panels is None else [*rooms, bounds.panels]:
        soft.append(Soft(LeastRooms.of(faces, count, room, sheet.cell.step), wishes.bound))
    alike = bounds.alike
    if alike is not None and alike.shapes is not None:
        panels = AlikePanels.of(faces, alike.shapes, alike.within, sheet.cell.step)
        soft.append(Soft(panels, wishes.bound))
    return hard, soft


def _no_setbacks(angles: FloatArray) -> FloatArray:
    return np.zeros((1, len(angles)))


def _rim(sheet: PleatedSheet, first: FloatArray) -> RimReach:
    """Planes through the first points of the rim's vertices, across the sheet there."""
    number = np.arange(len(first)).reshape(sheet.shape)
    ends = [(number[0], number[2]), (number[-1], number[-3])]
    if not sheet.closed:
        ends += [(number[:, 0], number[:, 2]), (number[:, -1], number[:, -3])]
    at, behind = (np.concatenate([pair[k] for pair in ends]) for k in (0, 1))
    points = first[at]
    return RimReach(at[:, None], unit(points - first[behind]), points, sheet.cell.step)


def _resampled(held: BoolArray, fine: PleatedSheet, coarse: PleatedSheet) -> BoolArray:
    """The vertices of the coarse sheet whose nearest ones in the fine sheet are held."""
    (R, C), (rows, columns) = fine.shape, coarse.shape
    down = np.rint(np.linspace(0, R - 1, rows)).astype(int)
    across = (
        np.linspace(0, C, columns, endpoint=False)
        if fine.closed
        else np.linspace(0, C - 1, columns)
    )
    grid = held.reshape(R, C)[down][:, np.rint(across).astype(int) % C]
    return np.asarray(grid.ravel())
