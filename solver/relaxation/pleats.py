"""Pleated sheets over a surface's parameters: where relaxation begins, and the cell it keeps to.

A sheet is a grid of vertices over the surface, ruled by lines: the rows of an open patch, the
columns of a tube. Along a line the vertices zigzag within the surface, and the lines are in turn
below and above it: creases along them are valleys and mountains in turn, as in a Miura sheet, whose
cell has four lengths.

    o   o   o   o       line 2, below      step      : from vertex to vertex along a line
     o   o   o          (its zigzag)       zigzag    : swing of a line
                                           spacing   : from line to line
    o   o   o   o       line 1, above      thickness : from the lower to the upper offset
     o   o   o

    o   o   o   o       line 0, below
     o   o   o

Such sheets are made to follow surfaces by optimisation in L. H. Dudte, E. Vouga, T. Tachi and
L. Mahadevan, "Programming curvature using origami tessellations", Nature Materials 15 (2016).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from solver.errors import InvalidValue, require_count, require_within
from solver.mesh import QuadMesh, grid_faces
from solver.targets.base import Target
from solver.vectors import BoolArray, FloatArray, IntArray, norm

__all__ = ["Cell", "PleatedSheet", "pleated_patch", "pleated_tube", "prolonged"]

# Points along either parameter at which the mean size of a surface is taken.
_SAMPLES = 33


@dataclass(frozen=True)
class Cell:
    """Lengths of a Miura cell, in units of the surface, as drawn in the module.

    Attributes
    ----------
    step, zigzag, spacing, thickness : see there.

    >>> cell = Cell(step=3.0, zigzag=4.0, spacing=12.0, thickness=5.0)
    >>> cell.along, cell.across
    (5.0, 13.0)
    """

    step: float
    zigzag: float
    spacing: float
    thickness: float

    @property
    def along(self) -> float:
        """Length of a face's sides along a line."""
        return float(np.hypot(self.step, self.zigzag))

    @property
    def across(self) -> float:
        """Length of a face's sides from line to line."""
        return float(np.hypot(self.spacing, self.thickness))


@dataclass(frozen=True)
class PleatedSheet:
    """A pleated sheet in the parameters of a surface, R rows of C vertices.

    Attributes
    ----------
    base : u and v of the vertices, without zigzag, shape (R, C, 2).
    swing : half of the zigzag, as change of u and v, shape (R, C, 2).
    cell : lengths in space that the sheet keeps to.
    closed : whether the last column is joined to the first; lines then run along the columns of
        the tube, else along the rows.
    period : change of u and v once around, of a closed sheet.
    kept : which cells of the grid are part of the sheet, shape (R - 1, C - 1), or (R - 1, C) of a
        closed one; None for all. The vertices of others have no face.
    """

    base: FloatArray
    swing: FloatArray
    cell: Cell
    closed: bool = False
    period: tuple[float, float] = (0.0, 0.0)
    kept: BoolArray | None = None

    def __post_init__(self) -> None:
        if self.base.ndim != 3 or self.base.shape != self.swing.shape or self.base.shape[2] != 2:
            raise InvalidValue(
                "base and swing",
                f"arrays of shapes {self.base.shape} and {self.swing.shape}",
                "both have shape (rows, columns, 2)",
                "Give u and v of every vertex.",
            )
        rows, columns = self.base.shape[:2]
        cells = rows - 1, columns - (not self.closed)
        if self.kept is not None and self.kept.shape != cells:
            raise InvalidValue(
                "kept", f"array of shape {self.kept.shape}", f"have shape {cells}", "See `shape`."
            )
        if self.closed and self.base.shape[1] % 2:
            raise InvalidValue(
                "columns", self.base.shape[1], "be even around a tube", "Lines alternate around it."
            )

    @property
    def shape(self) -> tuple[int, int]:
        """Numbers of rows and columns of vertices."""
        return self.base.shape[0], self.base.shape[1]

    @property
    def parities(self) -> tuple[FloatArray, FloatArray]:
        """1 and -1 in turn along each line, and from line to line, each of shape (R, C)."""
        rows, columns = np.indices(self.shape)
        along, across = (rows, columns) if self.closed else (columns, rows)
        return np.where(along % 2, -1.0, 1.0), np.where(across % 2, 1.0, -1.0)

    @property
    def uv(self) -> FloatArray:
        """Parameters of the vertices, row after row, shape (R C, 2)."""
        out: FloatArray = (self.base + self.parities[0][:, :, None] * self.swing).reshape(-1, 2)
        return out

    @property
    def offsets(self) -> FloatArray:
        """Wanted signed distances of the vertices from the surface, shape (R C,)."""
        out: FloatArray = self.parities[1].ravel() * self.cell.thickness / 2
        return out

    def points(self, target: Target) -> FloatArray:
        """The vertices on their offsets, shape (R C, 3)."""
        places = target.places(self.uv)
        return target.point(places) + self.offsets[:, None] * target.normal(places)

    @property
    def faces_vertices(self) -> IntArray:
        """Corners of the cells that are part of the sheet, in its grid, shape (nf, 4)."""
        rows, columns = self.shape
        faces = grid_faces(np.arange(rows * columns).reshape(rows, columns), self.closed)
        return faces if self.kept is None else faces[self.kept.ravel()]

    def mesh(self, coords: FloatArray) -> QuadMesh:
        """The patch or tube with the vertices `coords`, shape (R C, 3).

        Where cells are left out, vertices without a face are left out too.
        """
        mesh = QuadMesh.from_rows(coords.reshape(*self.shape, 3), closed=self.closed)
        return mesh if self.kept is None else mesh.with_faces(self.kept)

    def side_lengths(self, pairs: IntArray) -> FloatArray:
        """Lengths of the cell's sides between neighbours, shape (n, 2), in the grid."""
        return np.where(self._on_line(pairs), self.cell.along, self.cell.across)

    def spans(self, pairs: IntArray) -> FloatArray:
        """Distances in the cell of vertices two apart, shape (n, 2), in the grid."""
        return 2 * np.where(self._on_line(pairs), self.cell.step, self.cell.spacing)

    def _on_line(self, pairs: IntArray) -> FloatArray:
        columns = self.shape[1]
        number = pairs % columns if self.closed else pairs // columns
        return np.asarray(number[:, 0] == number[:, 1])

    def resized(self, rows: int, columns: int) -> PleatedSheet:
        """The sheet over the same part of the surface with other numbers of vertices.

        Its cell is larger or smaller by as much; all cells are part of it.
        """
        R, C = self.shape
        by_rows = (R - 1) / (rows - 1)
        by_columns = C / columns if self.closed else (C - 1) / (columns - 1)
        along, across = (by_rows, by_columns) if self.closed else (by_columns, by_rows)
        cell = Cell(
            self.cell.step * along,
            self.cell.zigzag * along,
            self.cell.spacing * across,
            self.cell.thickness * across,
        )
        base = _interpolated(self.base, rows, columns, self.closed, self.period)
        swing = along * _interpolated(self.swing, rows, columns, self.closed)
        return replace(self, base=base, swing=swing, cell=cell, kept=None)

    def halved(self) -> PleatedSheet:
        """The sheet with half as many faces in either direction (as many lines around: even)."""
        R, C = self.shape
        around = 2 * max(2, round(C / 4))
        return self.resized(max(4, R // 2 + 1), around if self.closed else max(4, C // 2 + 1))


def pleated_patch(
    target: Target,
    columns: int,
    *,
    zigzag: float,
    spacing: float,
    thickness: float,
    stretch: float = 1.05,
    extent: tuple[float, float] = (1.0, 1.0),
) -> PleatedSheet:
    """An open sheet over a surface whose lines run along v.

    Parameters
    ----------
    columns : faces across the domain, along v.
    zigzag, spacing, thickness : of the cell, in steps: the mean distance in space of neighbours
        along v.
    stretch : the cell's step and spacing over the mean ones: how much more the sheet can reach
        where the surface is wider than on average. Deeper folds make up for it elsewhere.
    extent : half widths of the sheet's domain along u and v; 1 is the whole one.
    """
    require_count("columns", columns, 3, "Interior vertices need neighbours.")
    _require_cell(zigzag, spacing, thickness, stretch)
    wide, long = extent
    high, across = _mean_lengths(target, wide, long)
    step = across / columns
    rows = max(3, round(high / (spacing * step)) + 1)
    u, v = np.linspace(wide, -wide, rows), np.linspace(-long, long, columns + 1)
    base = np.stack(np.broadcast_arrays(u[:, None], v), axis=-1)
    swing = np.zeros_like(base)
    swing[:, :, 0] = zigzag * step / 2 * (2 * wide / high)
    cell = Cell(stretch * step, stretch * zigzag * step, stretch * high / (rows - 1), 0.0)
    return PleatedSheet(base, swing, replace(cell, thickness=thickness * step))


def pleated_tube(
    target: Target,
    around: int,
    rows: int,
    *,
    zigzag: float,
    thickness: float,
    stretch: float = 1.0,
    extent: float = 1.0,
) -> PleatedSheet:
    """A closed sheet around a surface on which u = -1 and u = 1 are the same line.

    Parameters
    ----------
    around : faces around it, even; rows : of faces along v.
    zigzag, thickness : of the cell, in steps: the mean distance in space of neighbours along v.
        Lines run along v and swing around the tube.
    stretch : the cell's spacing around the tube over the mean one.
    extent : half width of the sheet's domain along v.
    """
    require_count("around", around, 4, "Give the number of faces around the tube.")
    require_count("rows", rows, 2, "Interior vertices need neighbours.")
    _require_cell(zigzag, 1.0, thickness, stretch)
    girth, high = _mean_lengths(target, 1.0, extent)
    step = high / rows
    u, v = -1 + 2 * np.arange(around) / around, np.linspace(-extent, extent, rows + 1)
    base = np.stack(np.broadcast_arrays(u, v[:, None]), axis=-1)
    swing = np.zeros_like(base)
    swing[:, :, 0] = zigzag * step / 2 * (2 / girth)
    cell = Cell(step, zigzag * step, stretch * girth / around, thickness * step)
    return PleatedSheet(base, swing, cell, closed=True, period=(2.0, 0.0))


def prolonged(
    coarse: PleatedSheet, coords: FloatArray, fine: PleatedSheet, target: Target
) -> FloatArray:
    """A start for `fine`, shape (R C, 3), from the relaxed vertices of `coarse`.

    How far the coarse vertices have moved from their first points is a smooth field, and three more
    that alternate along the lines, from line to line, and along both. All four are interpolated
    bilinearly; the latter are as much smaller as the cell is.
    """
    moved = (coords - coarse.points(target)).reshape(*coarse.shape, 3)
    out = fine.points(target).reshape(*fine.shape, 3)
    smaller = fine.cell.along / coarse.cell.along
    one, other = (np.ones(sheet.shape) for sheet in (coarse, fine))
    (a, b), (c, d) = coarse.parities, fine.parities
    for sign, again, size in (
        (one, other, 1.0),
        (a, c, smaller),
        (b, d, smaller),
        (a * b, c * d, smaller),
    ):
        field = _smoothed(sign[:, :, None] * moved, coarse.closed)
        out = out + size * again[:, :, None] * _interpolated(field, *fine.shape, coarse.closed)
    return out.reshape(-1, 3)


def _require_cell(zigzag: float, spacing: float, thickness: float, stretch: float) -> None:
    lengths = (("zigzag", zigzag), ("spacing", spacing), ("thickness", thickness))
    for name, value in lengths:
        require_within(name, value, 0.0, 1000.0, "It is counted in steps.")
    require_within("stretch", stretch, 0.1, 10.0, "1 is the mean size of the surface.")


def _mean_lengths(target: Target, wide: float, long: float) -> tuple[float, float]:
    """Mean lengths of a surface's lines along u, |u| <= wide, and along v, |v| <= long."""
    u, v = np.linspace(-wide, wide, _SAMPLES), np.linspace(-long, long, _SAMPLES)
    grid = np.stack(np.meshgrid(u, v, indexing="ij"), axis=-1)
    points = target.point(target.places(grid.reshape(-1, 2))).reshape(_SAMPLES, _SAMPLES, 3)
    along_u, along_v = norm(np.diff(points, axis=0)), norm(np.diff(points, axis=1))
    return float(np.nanmean(along_u)) * (_SAMPLES - 1), float(np.nanmean(along_v)) * (_SAMPLES - 1)


def _interpolated(
    field: FloatArray,
    rows: int,
    columns: int,
    closed: bool,
    period: tuple[float, ...] = (0.0,),
) -> FloatArray:
    """A field over a grid, shape (R, C, d), bilinearly at (rows, columns) of the same extent."""
    R, C = field.shape[:2]
    if closed:
        field = np.concatenate([field, field[:, :1] + np.asarray(period)], axis=1)
    across = C * np.arange(columns) / columns if closed else np.linspace(0, C - 1, columns)
    down = np.linspace(0, R - 1, rows)
    i, j = (np.minimum(x.astype(int), n - 2) for x, n in ((down, R), (across, field.shape[1])))
    s, t = (down - i)[:, None, None], (across - j)[:, None]
    out: FloatArray = (1 - s) * ((1 - t) * field[i][:, j] + t * field[i][:, j + 1])
    out += s * ((1 - t) * field[i + 1][:, j] + t * field[i + 1][:, j + 1])
    return out


def _smoothed(field: FloatArray, closed: bool) -> FloatArray:
    """A field over a grid without what alternates along either direction; linear ones stay."""
    for axis in (0, 1):
        f = np.moveaxis(field, axis, 0)
        mean = (np.roll(f, 1, axis=0) + np.roll(f, -1, axis=0)) / 4 + f / 2
        if not (closed and axis == 1):
            mean[0] = f[0] / 2 + 0.75 * f[1] - f[3] / 4
            mean[-1] = f[-1] / 2 + 0.75 * f[-2] - f[-4] / 4
        field = np.moveaxis(mean, 0, axis)
    return field
