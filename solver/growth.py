"""How does a patch grow strip by strip, and why did it stop?"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from solver.errors import InvalidValue, require_at_least
from solver.front import Front, Rays
from solver.mesh import QuadMesh, Side
from solver.vectors import FloatArray

__all__ = ["Growth", "Status", "Strip", "grow"]


class Status(StrEnum):
    """How growth ended. Everything but GROWN leaves a shorter mesh, with advice."""

    GROWN = "grown"
    FRONT_NOT_FOLDABLE = "front_not_foldable"
    LENGTH_OVER_BOUND = "length_over_bound"


@dataclass(frozen=True)
class Strip:
    """The free choices of one strip.

    Attributes
    ----------
    flap_angle : radians, at front vertex number `at`.
    lengths : of the m + 1 new creases: one for all, one each, or a function of the `Rays`.
    boundary_angles : see `Front.rays`.
    """

    flap_angle: float
    lengths: float | FloatArray | Callable[[Rays], FloatArray]
    at: int = 1
    boundary_angles: tuple[float | None, float | None] = (None, None)


@dataclass(frozen=True)
class Growth:
    """What growth made: a mesh in every case, and how it ended.

    Attributes
    ----------
    strips : how many strips were grown; advice : empty where the status is GROWN.
    """

    mesh: QuadMesh
    strips: int
    status: Status = Status.GROWN
    advice: str = ""


def grow(
    mesh: QuadMesh,
    strips: int,
    choose: Callable[[Front, int], Strip],
    *,
    side: Side = Side.TOP,
    k: FloatArray | float | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Growth:
    """Grow `strips` strips on one side of a patch.

    Parameters
    ----------
    choose : called with the front and the strip's number, returns the strip's free choices.
    k : radians, for the first strip on a mesh that is only a curve (see `Front.on_curve`).
    progress : called after each strip with the number of strips grown and wanted.

    A seed that cannot grow at all raises `InvalidValue`; a later strip that cannot grow ends growth
    with a status and keeps all strips before it.
    """
    require_at_least("strips", strips, 1, "Ask for one strip or more.")
    front = Front.of(mesh, side, k)
    rows = np.empty((strips, *front.vertices_coords.shape))
    for j in range(strips):
        if j:
            behind = rows[j - 2] if j > 1 else mesh.vertices_coords[mesh.front_vertices(side)]
            try:
                front = Front.between(rows[j - 1], behind)
            except InvalidValue as error:
                return Growth(
                    mesh.extended(side, rows[:j]),
                    j,
                    Status.FRONT_NOT_FOLDABLE,
                    f"Strip {j + 1} of {strips} has no room to fold: {error} "
                    "Another flap angle or shorter creases in the strips before may help.",
                )
        choice = choose(front, j)
        rays = front.rays(choice.flap_angle, at=choice.at, boundary_angles=choice.boundary_angles)
        lengths = _lengths(choice, rays)
        over = np.flatnonzero(lengths >= rays.length_bounds)
        if len(over):
            i = int(over[0])
            advice = (
                f"Strip {j + 1} of {strips}: the crease at front vertex {i} is {lengths[i]:.6g} "
                f"long, but neighbouring creases meet at {rays.length_bounds[i]:.6g}. "
                "Choose shorter lengths or another flap angle."
            )
            if j == 0:
                raise InvalidValue(
                    f"length[{i}]", lengths[i], f"be below {rays.length_bounds[i]:.9g}", advice
                )
            return Growth(mesh.extended(side, rows[:j]), j, Status.LENGTH_OVER_BOUND, advice)
        rows[j] = rays.row(lengths)
        if progress is not None:
            progress(j + 1, strips)
    return Growth(mesh.extended(side, rows), strips)


def _lengths(choice: Strip, rays: Rays) -> FloatArray:
    given = choice.lengths(rays) if callable(choice.lengths) else choice.lengths
    lengths = np.broadcast_to(np.asarray(given, float), len(rays.directions))
    if not (np.isfinite(lengths).all() and (lengths > 0).all()):
        i = int(np.flatnonzero(~(np.isfinite(lengths) & (lengths > 0)))[0])
        raise InvalidValue(
            f"length[{i}]", lengths[i], "be finite and greater than 0", "Give positive lengths."
        )
    return lengths
