"""A Miura sheet of any sectors that folds rigidly, with one motion from flat to folded flat."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from solver.errors import InvalidState, require_count, require_within
from solver.growth import Growth
from solver.mesh import QuadMesh
from solver.rigid_march import Marched, march
from solver.vectors import FloatArray

__all__ = ["RigidMiura"]


@dataclass(frozen=True)
class RigidMiura:
    """Boundary data: sectors and lengths along one row and one column; all others follow.

    Every vertex is developable and flat-foldable, and the sheet has one motion, along which the
    tangents of half the fold angles keep their ratios (`solver.rigid_march`). Lists are repeated
    in turn where they are shorter than the sheet.

    Attributes
    ----------
    columns, rows : number of quads in each direction.
    row_right, row_left : sectors on both sides of the crease that goes up from each vertex of the
        row, radians. Equal ones make a straight crease, two that sum to pi a row that does not
        turn.
    column_right, column_left : those of the vertices of the column, above that row.
    row_lengths, column_lengths : of the creases along that row and column, those at the rim first
        and last.
    fold : angle of the crease that folds most, radians in (0, pi).
    """

    columns: int = 16
    rows: int = 12
    row_right: tuple[float, ...] = field(
        default=(np.pi / 3, 2 * np.pi / 3), metadata={"angle": True}
    )
    row_left: tuple[float, ...] = field(
        default=(np.pi / 3, 2 * np.pi / 3), metadata={"angle": True}
    )
    column_right: tuple[float, ...] = field(
        default=(5 * np.pi / 12, np.pi / 3), metadata={"angle": True}
    )
    column_left: tuple[float, ...] = field(
        default=(5 * np.pi / 12, np.pi / 3), metadata={"angle": True}
    )
    row_lengths: tuple[float, ...] = (1.0,)
    column_lengths: tuple[float, ...] = (1.0,)
    fold: float = field(default=np.pi / 2, metadata={"angle": True})

    def grow(self, progress: Callable[[int, int], None] | None = None) -> Growth:
        """March the sheet and fold it. Raises `InvalidValue` for parameters out of bounds."""
        require_within("fold", self.fold, 0.0, np.pi, "0 is flat, 180 folded flat.", angle=True)
        marched = self.march()
        sheet = marched.sheet
        rows = len(sheet.across)
        if progress is not None:
            progress(rows - 1, self.rows - 1)
        mesh = QuadMesh.from_rows(sheet.folded(self.fold))
        return Growth(mesh, rows - 1, marched.status, marched.advice)

    def march(self) -> Marched:
        """The sheet with its motion. Raises `InvalidValue` for parameters out of bounds."""
        require_count("columns", self.columns, 2, "One column alone has no interior vertex.")
        require_count("rows", self.rows, 2, "One row alone has no interior vertex.")
        sides = {
            "row_right": self.columns - 1,
            "row_left": self.columns - 1,
            "column_right": self.rows - 2,
            "column_left": self.rows - 2,
            "row_lengths": self.columns,
            "column_lengths": self.rows,
        }
        return march(*(_repeated(name, getattr(self, name), n) for name, n in sides.items()))


def _repeated(name: str, values: Sequence[float], count: int) -> FloatArray:
    """The values in turn, `count` of them."""
    if not len(values):
        raise InvalidState(name, f"{name} is empty", "Give one value or more.")
    return np.resize(np.asarray(values, float), count)
