"""Growth whose rows may end: a front narrows where vertices at its side cannot be grown.

                 z1----z2----z3      x0 has no crease to the next offset: the new row begins at x1
                 | r1  | r2  | r3
           x0----x1----x2----x3      the front

A front that narrows never widens again. The longest part of it whose vertices can all be grown goes
on, with a flap angle of its own: there the paper's growth would end.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from solver.errors import InvalidState, InvalidValue, require_count
from solver.front import Front
from solver.growth import Growth, Status, Stop, Strip, length_trouble, lengths_along, usable_lengths
from solver.mesh import QuadMesh, Side
from solver.vectors import BoolArray, FloatArray

__all__ = ["Chooser", "EndedGrowth", "grow_ending"]

# A front of fewer vertices ends growth: it could not follow a surface.
_LEAST = 4


class Chooser(Protocol):
    """Chooses strips of a front that may narrow."""

    def choose(self, front: Front, strip: int) -> Strip | Stop:
        """The free choices of strip number `strip` on `front`; see `solver.growth.grow`."""

    def narrow(self, strip: int, first: int, last: int) -> None:
        """Strip `strip` begins at the vertices `first` to `last` - 1 of its front alone.

        What was chosen for it is void: `choose` is called again.
        """


@dataclass(frozen=True)
class EndedGrowth:
    """What growth with ending rows made.

    Attributes
    ----------
    growth : its status is that of the front that was left at last.
    firsts : front vertex of the side at which each new row begins, shape (strips,).
    ended : why the first vertices were left out, with advice; None where all rows are whole.
    """

    growth: Growth
    firsts: tuple[int, ...]
    ended: Stop | None


def grow_ending(
    mesh: QuadMesh,
    strips: int,
    chooser: Chooser,
    *,
    side: Side = Side.TOP,
    progress: Callable[[int, int], None] | None = None,
) -> EndedGrowth:
    """Grow up to `strips` strips on a side of an open patch with faces; rows may end.

    Where all rows are whole, the mesh is that of `solver.growth.grow` to the last bit.

    A vertex at the left end refuses every strip after the first, and the row behind it ends:

    >>> from solver import seeds
    >>> class Left:
    ...     def choose(self, front, strip):
    ...         lengths = np.full(len(front.vertices_coords), 0.2)
    ...         lengths[0] = np.nan if strip and len(lengths) == 7 else 0.2
    ...         return Strip(2.0, lengths)
    ...     def narrow(self, strip, first, last):
    ...         print("strip", strip, "from vertex", first, "to", last - 1)
    >>> ended = grow_ending(seeds.miura(6, 1.0, 0.5, 1.0, 1.0), 2, Left())
    strip 1 from vertex 1 to 6
    >>> ended.firsts, ended.growth.mesh.grid[-1].tolist()
    ((0, 1), [-1, 21, 22, 23, 24, 25, 26])
    """
    require_count("strips", strips, 1, "Ask for one strip or more.")
    behind = mesh.previous_vertices(side)
    if behind is None or mesh.closed:
        raise InvalidState(
            "mesh", "rows may end on open patches with faces alone", "Use `solver.growth.grow`."
        )
    front: Front | None = Front.of(mesh, side)
    x, y, first = mesh.vertices_coords[mesh.front_vertices(side)], mesh.vertices_coords[behind], 0
    ended: Stop | None = None
    rows: list[FloatArray] = []
    firsts: list[int] = []
    stop: Stop | None = None
    while len(rows) < strips and stop is None:
        row, reason, part = _grown_row(front, x, y, len(rows), strips, chooser)
        front = None
        if row is not None:
            y, x = x, row
            rows.append(row)
            firsts.append(first)
            if progress is not None:
                progress(len(rows), strips)
            continue
        assert reason is not None
        begin, end = part
        if end - begin < _LEAST or end - begin == len(x):
            stop = reason
            break
        ended = ended or reason
        chooser.narrow(len(rows), begin, end)
        x, y, first = x[begin:end], y[begin:end], first + begin
    for begin, row in zip(firsts, rows, strict=True):
        mesh = mesh.extended(side, row[None], begin)
    status, advice = (Status.GROWN, "") if stop is None else (stop.status, stop.advice)
    return EndedGrowth(Growth(mesh, len(rows), status, advice), tuple(firsts), ended)


def _grown_row(
    front: Front | None, x: FloatArray, y: FloatArray, strip: int, strips: int, chooser: Chooser
) -> tuple[FloatArray | None, Stop | None, tuple[int, int]]:
    """The next row on x, or why there is none and the longest part of x that may have one.

    front : of x, where it is known. Where no part can help, the part is all of x.
    """
    place = f"Strip {strip + 1} of {strips}"
    if front is None:
        try:
            front = Front.between(x, y)
        except InvalidValue as error:
            advice = f"{place} has no room to fold: {error}"
            return None, Stop(Status.FRONT_NOT_FOLDABLE, advice), (0, len(x))
    choice = chooser.choose(front, strip)
    if isinstance(choice, Stop):
        return None, choice, (0, len(x))
    rays = front.rays(choice.flap_angle, at=choice.at, boundary_angles=choice.boundary_angles)
    lengths = lengths_along(choice.lengths, rays)
    trouble = length_trouble(lengths, rays)
    if trouble is None:
        return rays.row(lengths), None, (0, len(x))
    i, status, bound = trouble
    advice = f"{place}: at front vertex {i} the length must {bound}."
    return None, Stop(status, advice), longest_run(usable_lengths(lengths, rays))


def longest_run(good: BoolArray) -> tuple[int, int]:
    """Begin and end of the longest run of True, the first of several; (0, 0) where there is none.

    >>> longest_run(np.array([True, False, True, True, False]))
    (2, 4)
    """
    edges = np.flatnonzero(np.diff(np.concatenate([[False], good, [False]])))
    if not len(edges):
        return 0, 0
    begins, ends = edges[::2], edges[1::2]
    i = int(np.argmax(ends - begins))
    return int(begins[i]), int(ends[i])
