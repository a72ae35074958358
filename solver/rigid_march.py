"""Quad sheets that fold rigidly and flat, marched vertex by vertex from a row and a column.

The sectors at the vertices of one row and one column, and the lengths of their creases, decide the
whole sheet. In a sheet that folds flat, all creases along a row fold by the same amount, and so do
all across a column; a vertex therefore has the multiplier of its row and column. Three known
corners of a panel leave the fourth its sector in the panel, and the multiplier gives the next one
in closed form (`solver.flat_foldable`); the vertex is where its two creases meet.

        |     |     |
      --x-----*-----*--    x  given: sectors on both sides of the crease that goes up
        |     |     |      *  marched
      --x-----x-----x--
        |     |     |

Sources: T. Tachi, "Generalization of rigid foldable quadrilateral mesh origami", Journal of the
IASS 50 (2009); R. J. Lang and L. Howell, "Rigidly foldable quadrilateral meshes from angle arrays",
Journal of Mechanisms and Robotics 10 (2018); F. Feng, X. Dang, R. D. James and P. Plucinsky, "The
designs and deformations of rigidly and flat-foldable quadrilateral mesh origami", Journal of the
Mechanics and Physics of Solids 142 (2020).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from solver.errors import InvalidValue, require_length, require_within
from solver.flat_foldable import left_sector, multiplier
from solver.growth import Status
from solver.vectors import ComplexArray, FloatArray, unit

__all__ = ["Marched", "RigidSheet", "march"]

# Sectors have this much of a half turn on both sides, radians.
_LEAST_SECTOR = 1e-3
# A row whose vertices turn by less does not fold the creases across it.
_LEAST_TURN = 1e-6
# Shorter sides, over the longest given length, are none.
_LEAST_SIDE = 1e-6
# Rays with a smaller sine between them do not meet.
_PARALLEL = 1e-12
# Creases at the rim end at this share of the length at which they would meet.
_RIM = 0.5


@dataclass(frozen=True)
class RigidSheet:
    """A sheet of C by R panels with one motion, from flat to folded flat. Arrays are read-only.

    Attributes
    ----------
    flat_coords : shape (R + 1, C + 1, 2), the flat sheet; panels are convex.
    right, left : shape (R - 1, C - 1), radians, the sectors on both sides of the crease that goes
        up from each interior vertex.
    along : shape (R - 1, C), tan(fold angle / 2) of the creases along each interior row over that
        of the crease that folds most; valleys positive.
    across : shape (R, C - 1), that of the creases across the rows.
    """

    flat_coords: FloatArray
    right: FloatArray
    left: FloatArray
    along: FloatArray
    across: FloatArray

    def __post_init__(self) -> None:
        for name in self.__dataclass_fields__:
            getattr(self, name).flags.writeable = False

    def fold_angles(self, fold: float) -> tuple[FloatArray, FloatArray]:
        """Fold angles of the creases along and across rows, radians, valley positive.

        fold : that of the crease that folds most, radians in [-pi, pi]; at pi the sheet is folded
        flat, and negative ones swap mountains and valleys. Raises `InvalidValue` for others.
        """
        room = np.nextafter(np.pi, 4.0)
        require_within("fold", fold, -room, room, "pi folds the sheet flat.", angle=True)
        s, c = np.sin(fold / 2), 0.0 if abs(fold) >= np.pi else np.cos(fold / 2)
        along, across = (2 * np.arctan2(t * s, c) for t in (self.along, self.across))
        return along, across

    def folded(self, fold: float) -> FloatArray:
        """The sheet with the largest fold angle `fold`, see `fold_angles`; (R + 1, C + 1, 3).

        The panel in the middle is where it is in the flat sheet.
        """
        along, across = self.fold_angles(fold)
        rows, columns = across.shape[0], along.shape[1]
        flat = np.pad(self.flat_coords, ((0, 0), (0, 0), (0, 1)))
        # motions x -> turn x + shift over each crease, of the panel on its right where the one on
        # its left stays, and upwards where the lower one stays
        sideways = _turned(flat[:-1, 1:-1], flat[1:, 1:-1], -across)
        upwards = _turned(flat[1:-1, :-1], flat[1:-1, 1:], along)
        motion = np.empty((rows, columns, 4, 4))
        r, c = rows // 2, columns // 2
        motion[r, c] = np.eye(4)
        for k in range(c + 1, columns):
            motion[r, k] = motion[r, k - 1] @ sideways[r, k - 1]
        for k in range(c - 1, -1, -1):
            motion[r, k] = motion[r, k + 1] @ _inverse(sideways[r, k])
        for k in range(r + 1, rows):
            motion[k] = motion[k - 1] @ upwards[k - 1]
        for k in range(r - 1, -1, -1):
            motion[k] = motion[k + 1] @ _inverse(upwards[k])
        face = np.ix_(
            np.minimum(np.arange(rows + 1), rows - 1),
            np.minimum(np.arange(columns + 1), columns - 1),
        )
        turn, shift = motion[face][..., :3, :3], motion[face][..., :3, 3]
        return np.asarray(np.squeeze(turn @ flat[..., None], -1) + shift, np.float64)


@dataclass(frozen=True)
class Marched:
    """A sheet with all rows that could be marched, and how the march ended.

    Attributes
    ----------
    sheet : R may be less than was asked for.
    status : GROWN, SECTOR_OUT_OF_BOUNDS or LENGTH_NOT_POSITIVE; advice : empty where it is GROWN.
    """

    sheet: RigidSheet
    status: Status
    advice: str


def march(
    row_right: FloatArray,
    row_left: FloatArray,
    column_right: FloatArray,
    column_left: FloatArray,
    row_lengths: FloatArray,
    column_lengths: FloatArray,
) -> Marched:
    """March the sheet of C by R panels that has given sectors and lengths in a row and a column.

    Creases along a row fold further than those across it at all given vertices. Creases at the rim
    have the first and last lengths, or end halfway to where they would meet.

    Parameters
    ----------
    row_right, row_left : shape (C - 1,), radians: sectors A and B of `solver.flat_foldable` at the
        interior vertices of the first interior row.
    column_right, column_left : shape (R - 2,), those of the first interior column above that row.
    row_lengths, column_lengths : shapes (C,) and (R,), of the creases along that row and column,
        those at the rim included; C and R are 2 or more.

    Raises `InvalidValue` for sectors that are not within (0, pi), or sum to pi, and for lengths
    that are not from 1e-6 to 1e6.
    """
    _require_sectors("row", row_right, row_left)
    _require_sectors("column", column_right, column_left)
    for name, lengths in (("row_lengths", row_lengths), ("column_lengths", column_lengths)):
        for k, length in enumerate(lengths.tolist()):
            require_length(f"{name}[{k}]", length)
    angles = _angles(row_right, row_left, column_right, column_left)
    placed = _placed(angles, row_lengths, column_lengths)
    rows = placed.shape[0] + 1
    status, advice = Status.GROWN, ""
    if rows < len(column_lengths):
        status, advice = _stopped(angles, rows)
    along, across = angles.along[: rows - 1], angles.across[:rows]
    largest = max(np.abs(along).max(), np.abs(across).max())
    flat = _with_rim(placed, angles, row_lengths, column_lengths)
    sheet = RigidSheet(
        np.stack([flat.real, flat.imag], axis=-1),
        angles.right[: rows - 1].copy(),
        angles.left[: rows - 1].copy(),
        along / largest,
        across / largest,
    )
    return Marched(sheet, status, advice)


@dataclass(frozen=True)
class _Angles:
    """All angles of a sheet, up to the last row whose sectors are within bounds.

    right, left, along, across : as in `RigidSheet`, tangents not yet scaled.
    headings : shape of `right`, radians from x, of the crease to the right of each vertex.
    outside : row, column and sector (radians) of the vertex that ended the march; None for none.
    """

    right: FloatArray
    left: FloatArray
    along: FloatArray
    across: FloatArray
    headings: FloatArray
    outside: tuple[int, int, float] | None


def _angles(
    row_right: FloatArray, row_left: FloatArray, column_right: FloatArray, column_left: FloatArray
) -> _Angles:
    columns, rows = len(row_right), 1 + len(column_right)
    right, left = np.empty((2, rows, columns))
    along, across = np.ones((rows, columns + 1)), np.empty((rows + 1, columns))
    right[0], left[0] = row_right, row_left
    right[1:, 0], left[1:, 0] = column_right, column_left
    across[0] = [multiplier(a, b) for a, b in zip(row_right, row_left, strict=True)]
    across[1] = -across[0]
    outside = None
    for j in range(1, rows):
        m = multiplier(float(right[j, 0]), float(left[j, 0]))
        along[j, :2] = across[j, 0] / m
        across[j + 1, 0] = -across[j, 0]
        for i in range(1, columns):
            # the sectors of a panel sum to a full turn
            a = float(right[j - 1, i - 1] + left[j - 1, i] - left[j, i - 1])
            t_left, t_below = float(along[j, i]), float(across[j, i])
            b = left_sector(a, t_left, t_below) if _fits(a) else np.nan
            if not (_fits(a) and _fits(b)):
                outside = j, i, b if _fits(a) else a
                break
            right[j, i], left[j, i] = a, b
            alike = abs(t_below) < abs(t_left)
            along[j, i + 1], across[j + 1, i] = (t_left, -t_below) if alike else (-t_left, t_below)
        if outside is not None:
            rows = j
            break
    right, left = right[:rows], left[:rows]
    headings = np.pi - right - left
    headings[0, 0] = 0.0
    headings[1:, 0] = np.cumsum(right[:-1, 0] - left[1:, 0])
    headings = np.cumsum(headings, axis=1)
    return _Angles(right, left, along[:rows], across[: rows + 1], headings, outside)


def _fits(sector: float) -> bool:
    return _LEAST_SECTOR <= sector <= np.pi - _LEAST_SECTOR


def _placed(angles: _Angles, row_lengths: FloatArray, column_lengths: FloatArray) -> ComplexArray:
    """Interior vertices of all rows whose creases have a length, as complex numbers."""
    to_right = np.exp(1j * angles.headings)
    up = np.exp(1j * (angles.headings + angles.right))
    least = _LEAST_SIDE * max(row_lengths.max(), column_lengths.max())
    rows, columns = angles.right.shape
    out = np.zeros((rows, columns), complex)
    out[0, 1:] = np.cumsum(row_lengths[1:-1] * to_right[0, :-1])
    for j in range(1, rows):
        out[j, 0] = out[j - 1, 0] + column_lengths[j] * up[j - 1, 0]
        for i in range(1, columns):
            a, b = _meeting(out[j, i - 1], to_right[j, i - 1], out[j - 1, i], up[j - 1, i])
            if not min(a, b) > least:
                return out[:j]
            out[j, i] = out[j, i - 1] + a * to_right[j, i - 1]
    return out


def _meeting(p: complex, u: complex, q: complex, v: complex) -> tuple[float, float]:
    """Lengths of the rays from p along u and from q along v up to where they meet."""
    turn = (u.conjugate() * v).imag
    if abs(turn) < _PARALLEL:
        return np.inf, np.inf
    return ((q - p).conjugate() * v).imag / turn, ((q - p).conjugate() * u).imag / turn


def _stopped(angles: _Angles, rows: int) -> tuple[Status, str]:
    """Why the march ended before row number `rows`, and what would help."""
    cure = "Give fewer rows, or sectors nearer to those of a Miura sheet (right as left)."
    if angles.outside is not None and angles.outside[0] == rows - 1:
        _, i, sector = angles.outside
        return Status.SECTOR_OUT_OF_BOUNDS, (
            f"Row {rows}: vertex {i + 1} would need a sector of {np.degrees(sector):.4g} degrees, "
            f"out of (0, 180). {cure}"
        )
    return Status.LENGTH_NOT_POSITIVE, (
        f"Row {rows}: creases meet before they leave their vertices, so that a panel has no side "
        f"left. Give shorter rows or longer columns. {cure}"
    )


def _with_rim(
    inner: ComplexArray, angles: _Angles, row_lengths: FloatArray, column_lengths: FloatArray
) -> ComplexArray:
    """The interior vertices with those at the rim around them."""
    rows, columns = inner.shape
    right, left = angles.right[:rows], angles.left[:rows]
    to_right = np.exp(1j * angles.headings[:rows])
    up, to_left, down = (
        to_right * np.exp(1j * turn) for turn in (right, right + left, np.pi + left)
    )
    out = np.empty((rows + 2, columns + 2), complex)
    out[1:-1, 1:-1] = inner
    out[1:-1, 0] = inner[:, 0] + _rim(inner[:, 0], to_left[:, 0], float(row_lengths[0]))
    out[1:-1, -1] = inner[:, -1] + _rim(inner[:, -1], to_right[:, -1], float(row_lengths[-1]))
    out[0, 1:-1] = inner[0] + _rim(inner[0], down[0], float(column_lengths[0]))
    out[-1, 1:-1] = inner[-1] + _rim(inner[-1], up[-1], float(column_lengths[rows]))
    for j, beside in ((0, 1), (-1, -2)):  # panels at the corners are parallelograms
        for i, within in ((0, 1), (-1, -2)):
            out[j, i] = out[beside, i] + out[j, within] - out[beside, within]
    return out


def _rim(points: ComplexArray, directions: ComplexArray, length: float) -> ComplexArray:
    """Creases from the vertices of a side outwards, no two of which meet."""
    lengths = np.full(len(points), length)
    for k in range(len(points) - 1):
        a, b = _meeting(points[k], directions[k], points[k + 1], directions[k + 1])
        if a > 0 and b > 0:
            lengths[k], lengths[k + 1] = min(lengths[k], _RIM * a), min(lengths[k + 1], _RIM * b)
    return np.asarray(lengths * directions)


def _turned(start: FloatArray, end: FloatArray, angle: FloatArray) -> FloatArray:
    """Motions that turn about lines from start to end, shapes (..., 3), as (..., 4, 4)."""
    u = unit(end - start)
    turn = Rotation.from_rotvec((u * angle[..., None]).reshape(-1, 3)).as_matrix()
    out = np.zeros((*angle.shape, 4, 4))
    out[..., :3, :3] = turn.reshape(*angle.shape, 3, 3)
    out[..., :3, 3] = start - np.squeeze(out[..., :3, :3] @ start[..., None], -1)
    out[..., 3, 3] = 1.0
    return out


def _inverse(motion: FloatArray) -> FloatArray:
    out = np.zeros_like(motion)
    back = motion[..., :3, :3].swapaxes(-1, -2)
    out[..., :3, :3] = back
    out[..., :3, 3] = -np.squeeze(back @ motion[..., :3, 3, None], -1)
    out[..., 3, 3] = 1.0
    return out


def _require_sectors(name: str, right: FloatArray, left: FloatArray) -> None:
    low, high = _LEAST_SECTOR, np.pi - _LEAST_SECTOR
    cure = "60 degrees on both sides are those of a Miura sheet."
    for k, (a, b) in enumerate(zip(right.tolist(), left.tolist(), strict=True)):
        require_within(f"{name}_right[{k}]", a, low, high, cure, angle=True)
        require_within(f"{name}_left[{k}]", b, low, high, cure, angle=True)
        if abs(a + b - np.pi) < _LEAST_TURN:
            raise InvalidValue(
                f"{name}_left[{k}]",
                f"{np.degrees(b):.7g} deg",
                f"not make 180 deg with {name}_right[{k}]",
                "Where a row does not turn, the creases across it do not fold.",
            )
