"""Pleated sheets laid over a surface of triangles: which cells, how large, and up to which planes.

Cells are laid in the plane of a map of the surface (`solver.surface_maps`). Those that reach over
it are the sheet's, with a narrow margin beyond its rim, so that a sheet of any outline begins as a
grid with some of its cells left out. Holes are filled until the sheet is trimmed (`rim_trimming`):
with vertices around them alone, it would not close up when it is flat.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import binary_fill_holes
from scipy.spatial import cKDTree

from solver.coverage import one_piece
from solver.errors import InvalidState, require_count, require_within
from solver.mesh import interior_vertices
from solver.relaxation.objectives import RimReach
from solver.relaxation.pleats import Cell, PleatedSheet
from solver.targets.mesh_target import MeshTarget
from solver.targets.surface_mesh import MeshKind
from solver.vectors import BoolArray, FloatArray, dot, norm, unit

__all__ = ["Pleats", "held_vertices", "laid_patch", "laid_tube", "rim_planes", "rim_points"]

# How far beyond the rim of the surface the sheet's rim is to be at least, in steps.
_MARGIN = 0.1
# From so far inside, in steps, vertices of the sheet's rim are drawn to the surface's rim.
_NEAR_RIM = 1.0
# The share of a cell over the surface with which it is part of the sheet.
_SHARE = 0.04
# Points along either direction of a cell at which it is seen whether it is over the surface.
_WITHIN = (np.arange(6) + 0.5) / 6
# Cells that are looked at together: places of points within all of them would take gigabytes.
_AT_ONCE = 4000
# Rows that a map is longer by than a whole number of them, and that count for nothing: maps of
# symmetric surfaces are whole numbers long but for rounding, which is not to choose the sheet.
_SAME = 1e-6
_LONGEST = 1000.0


@dataclass(frozen=True)
class Pleats:
    """The shape of a cell, in steps.

    Attributes
    ----------
    zigzag, spacing, thickness : see `Cell`, where the surface is as wide as its map.
    stretch : by how much more than that cells can reach. Deeper folds make up for it elsewhere.

    >>> Pleats(zigzag=2.0).cell(0.5)
    Cell(step=0.55, zigzag=1.1, spacing=0.55, thickness=0.5)
    """

    zigzag: float = 2.0
    spacing: float = 1.0
    thickness: float = 1.0
    stretch: float = 1.1

    def __post_init__(self) -> None:
        for name in ("zigzag", "spacing", "thickness"):
            require_within(name, getattr(self, name), 0.0, _LONGEST, "It is counted in steps.")
        require_within("stretch", self.stretch, 0.1, 10.0, "1 is the size of the map.")

    def cell(self, step: float) -> Cell:
        """The cell that sheets of this step keep to."""
        wide = self.stretch * step
        return Cell(wide, self.zigzag * wide, self.spacing * wide, self.thickness * step)


def laid_patch(target: MeshTarget, columns: int, pleats: Pleats, turn: float = 0.0) -> PleatedSheet:
    """An open sheet over a disc whose lines run along one direction of its map.

    columns : faces across the map, along the lines. turn : their direction, radians from the map's
    u axis. Raises `InvalidState` where no cell is over the surface.
    """
    require_count("columns", columns, 3, "Interior vertices need neighbours.")
    corners = _corners_uv(target).reshape(-1, 2)
    along = np.array([np.cos(turn), np.sin(turn)])
    axes = np.stack([along, [-along[1], along[0]]], axis=1)  # from the map to lines and across
    low, high = (corners @ axes).min(axis=0), (corners @ axes).max(axis=0)
    step = float(high[0] - low[0]) / columns
    wide = pleats.spacing * step
    rows = int(np.ceil((high[1] - low[1]) / wide - _SAME)) + 3
    s = np.arange(columns + 3) * step
    t = np.arange(rows) * wide  # faces are counterclockwise
    middle = (low + high) / 2 - [s.mean(), t.mean()]
    grid = np.stack(np.broadcast_arrays(s, t[:, None]), axis=-1) + middle
    swing = np.zeros_like(grid)
    swing[:, :, 1] = pleats.zigzag * step / 2
    sheet = PleatedSheet(grid @ axes.T, swing @ axes.T, pleats.cell(step))
    return replace(sheet, kept=one_piece(binary_fill_holes(_over(target, sheet))))


def laid_tube(target: MeshTarget, period: float, around: int, pleats: Pleats) -> PleatedSheet:
    """A closed sheet around a ring mapped to a cylinder; see `cylinder_map`.

    around : faces around it, even. Lines run from rim to rim and swing around it: a step is what
    `pleats.spacing` of it makes of the period, once around.
    """
    require_count("around", around, 4, "Give the number of faces around the tube.")
    around += around % 2
    high = float(_corners_uv(target)[:, :, 1].max())
    step = period / around / pleats.spacing
    rows = max(3, round(high / step)) + 1
    u, v = period * np.arange(around) / around, np.linspace(0, high, rows)
    base = np.stack(np.broadcast_arrays(u, v[:, None]), axis=-1)
    swing = np.zeros_like(base)
    swing[:, :, 0] = pleats.zigzag * step / 2
    cell = replace(pleats.cell(step), step=pleats.stretch * high / (rows - 1))
    return PleatedSheet(base, swing, cell, closed=True, period=(period, 0.0))


def held_vertices(target: MeshTarget, sheet: PleatedSheet) -> BoolArray:
    """Vertices of cells over the surface, shape (R C,): others, above a hole, only join them."""
    if sheet.kept is None or target.mesh.kind is MeshKind.DISC:
        return np.ones(len(sheet.uv), bool)
    over = _over(target, replace(sheet, kept=None))[sheet.kept]
    held: BoolArray = np.bincount(sheet.faces_vertices[over].ravel(), minlength=len(sheet.uv)) > 0
    return held


def rim_planes(target: MeshTarget, sheet: PleatedSheet) -> RimReach:
    """Planes across the surface's rim that the sheet's own rim lies between.

    They are a margin beyond the surface's rim, and beyond where the sheet's begins: with the first
    alone sheets spread out over the continued surface.
    """
    step = sheet.cell.step
    places = target.places(sheet.uv)
    faces, count = sheet.faces_vertices, len(places)
    used = np.bincount(faces.ravel(), minlength=count) > 0
    outer = np.flatnonzero(used & ~interior_vertices(faces, count))
    points = target.point(places[outer])
    foot, ahead = rim_points(target, step)
    gap, nearest = cKDTree(foot).query(points)
    beyond = ~target.inside(places[outer])
    near = beyond | (gap <= _NEAR_RIM * step)
    outer, points, nearest = outer[near], points[near], nearest[near]
    foot, ahead = foot[nearest] + _MARGIN * step * ahead[nearest], ahead[nearest]
    farther = np.maximum(dot(points - foot, ahead), 0.0) + _MARGIN * step
    return RimReach(
        np.concatenate([outer, outer])[:, None],
        np.concatenate([ahead, -ahead]),
        np.concatenate([foot, foot + farther[:, None] * ahead]),
        step,
    )


def rim_points(target: MeshTarget, step: float) -> tuple[FloatArray, FloatArray]:
    """Points along the rim of the surface, and unit tangents of it there that point outwards."""
    mesh = target.mesh
    edges = np.flatnonzero(mesh.rim_edges)
    face = mesh.edges_faces[edges, 0]
    ends = mesh.vertices_coords[mesh.edges_vertices[edges]]
    middle = mesh.vertices_coords[mesh.faces_vertices[face]].mean(axis=1)
    along = ends[:, 1] - ends[:, 0]
    length = norm(along)
    along = unit(along)
    ahead = ends[:, 0] - middle
    ahead = unit(ahead - dot(ahead, along)[:, None] * along)
    parts = np.maximum(np.ceil(4 * length / step).astype(int), 1)
    which = np.repeat(np.arange(len(edges)), parts)
    part = np.arange(len(which)) - np.repeat(np.cumsum(parts) - parts, parts)
    share = ((part + 0.5) / parts[which])[:, None]
    return (1 - share) * ends[which, 0] + share * ends[which, 1], ahead[which]


def _corners_uv(target: MeshTarget) -> FloatArray:
    if target.corners_uv is None:
        raise InvalidState("corners_uv", "the mesh has no map", "Give it parameters.")
    return target.corners_uv


def _over(target: MeshTarget, sheet: PleatedSheet) -> BoolArray:
    """Cells of which more than a sliver is over the surface, shape (R - 1, C - 1)."""
    rows, columns = sheet.shape
    corners = sheet.uv[sheet.faces_vertices]
    s, t = (a.reshape(-1, 1) for a in np.meshgrid(_WITHIN, _WITHIN))
    weights = np.stack([(1 - s) * (1 - t), s * (1 - t), s * t, (1 - s) * t])
    share = np.empty(len(corners))
    for first in range(0, len(corners), _AT_ONCE):
        block = slice(first, first + _AT_ONCE)
        within = np.einsum("kpq,fkd->fpd", weights, corners[block])
        inside = target.inside(target.places(within.reshape(-1, 2)))
        share[block] = inside.reshape(len(within), -1).mean(axis=1)
    over: BoolArray = (share > _SHARE).reshape(rows - 1, columns - 1)
    if not over.any():
        raise InvalidState("columns", "no cell is over the surface", "Ask for more columns.")
    return over
