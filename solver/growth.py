"""Growth of a patch strip by strip, and how it ended."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Protocol, TypeAlias

import numpy as np

from solver.errors import InvalidValue, require_count
from solver.front import Front
from solver.mesh import QuadMesh, Side
from solver.rays import Rays
from solver.vectors import LARGEST, SMALLEST, BoolArray, FloatArray

__all__ = ["CLOSED", "GrowingDesign", "Growth", "Lengths", "Status", "Stop", "Strip", "grow"]


class Status(StrEnum):
    """How growth ended. Everything but GROWN leaves a shorter mesh, with advice."""

    GROWN = "grown"
    FRONT_NOT_FOLDABLE = "front_not_foldable"
    LENGTH_OVER_BOUND = "length_over_bound"
    LENGTH_NOT_POSITIVE = "length_not_positive"
    SECTOR_OUT_OF_BOUNDS = "sector_out_of_bounds"
    LOOP_NOT_CLOSED = "loop_not_closed"
    FACES_CROSS = "faces_cross"
    CORNER_NOT_CONVEX = "corner_not_convex"
    CORNER_NOT_MATCHED = "corner_not_matched"
    COVERED = "covered"
    NOT_FITTED = "not_fitted"


# More would not fit into the memory of a common machine.
_MOST_QUADS = 20_000_000
# A loop's flap angle may miss itself by this much, radians.
CLOSED = 1e-9
# Creases shorter than this share of the coordinates are lost in rounding.
_RESOLVED = 1e-9
_CURE = "Another flap angle or other lengths in this strip and those before may help."


# Of the new creases: one length for all, one each, or a function of the rays.
Lengths: TypeAlias = float | FloatArray | Callable[[Rays], FloatArray]


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
    lengths: Lengths
    at: int = 1
    boundary_angles: tuple[float | None, float | None] = (None, None)


@dataclass(frozen=True)
class Stop:
    """The answer of a rule that can choose no strip: why, and what would help."""

    status: Status
    advice: str


@dataclass(frozen=True)
class Growth:
    """What growth made: a mesh in every case, and how it ended.

    Attributes
    ----------
    mesh : the patch with all strips that could be grown.
    strips : how many were grown; status : how growth ended; advice : empty where it is GROWN.
    coverage : share of a target's domain that the sheet covers; None where there is no target.
    chosen : what the design chose where it was left free, by name.
    deviations : signed distances of vertices from their offsets of a target, where the sheet was
        relaxed onto it; None where it was grown, exactly on them.
    distance : the largest one of a vertex from a target that the sheet was relaxed onto, smoothed
        where it is noisy.
    distances : signed distances from the target as it was given, of vertices of a relaxed sheet
        that are over it and not beyond its rim.
    """

    mesh: QuadMesh
    strips: int
    status: Status = Status.GROWN
    advice: str = ""
    coverage: float | None = None
    chosen: Mapping[str, float] = field(default_factory=dict)
    deviations: FloatArray | None = None
    distance: float | None = None
    distances: FloatArray | None = None


class GrowingDesign(Protocol):
    """A frozen dataclass whose fields are parameters, and that grows a sheet from them."""

    def grow(self, progress: Callable[[int, int], None] | None = None) -> Growth:
        """Grow the sheet. Raises `InvalidValue` for parameters out of bounds."""
        ...


def grow(
    mesh: QuadMesh,
    strips: int,
    choose: Callable[[Front, int], Strip | Stop],
    *,
    side: Side = Side.TOP,
    k: FloatArray | float | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Growth:
    """Grow `strips` strips on one side of a patch.

    Parameters
    ----------
    choose : called with the front and the strip's number, returns the strip's free choices, or
        that growth stops here.
    k : radians, for the first strip on a mesh that is only a curve (see `Front.on_curve`).
    progress : called after each strip with the number of strips grown and wanted.

    A seed that cannot grow at all raises `InvalidValue`; a later strip that cannot grow ends growth
    with a status and keeps all strips before it.

    Two strips on a zigzag in the plane, all flap angles and lengths alike:

    >>> x = np.arange(7.0)
    >>> zigzag = QuadMesh.from_rows(np.stack([x, x % 2, 0 * x], axis=1)[None])
    >>> growth = grow(zigzag, 2, lambda front, strip: Strip(2.0, 0.5), k=1.1 * np.pi)
    >>> growth.status, growth.strips, growth.mesh.grid.shape
    (<Status.GROWN: 'grown'>, 2, (3, 7))
    """
    require_count("strips", strips, 1, "Ask for one strip or more.")
    front = Front.of(mesh, side, k)
    quads = strips * len(front.edges_length)
    if quads > _MOST_QUADS:
        raise InvalidValue(
            "quads to grow", quads, f"be at most {_MOST_QUADS}", "Ask for fewer columns or strips."
        )
    rows, stop = grown_rows(front, strips, choose, progress)
    status, advice = (Status.GROWN, "") if stop is None else (stop.status, stop.advice)
    return Growth(mesh.extended(side, rows), len(rows), status, advice)


def grown_rows(
    front: Front,
    strips: int,
    choose: Callable[[Front, int], Strip | Stop],
    progress: Callable[[int, int], None] | None = None,
    beyond: tuple[int, int] = (0, 0),
) -> tuple[FloatArray, Stop | None]:
    """Rows of strips grown one after another, shape (n, C', 3), and why n is below `strips`.

    beyond : the number of vertices at the left and right end that belong to the first front alone:
        no crease begins at them.
    """
    drop, size = beyond[0], len(front.row_coords) - sum(beyond)
    start = front.row_coords[drop : drop + size]
    rows = np.empty((strips, size, 3))
    for j in range(strips):
        if j:
            behind = rows[j - 2] if j > 1 else start
            try:
                front = Front.between(rows[j - 1], behind, closed=front.closed)
            except InvalidValue as error:
                advice = f"Strip {j + 1} of {strips} has no room to fold: {error} {_CURE}"
                return rows[:j], Stop(Status.FRONT_NOT_FOLDABLE, advice)
        choice = choose(front, j)
        if isinstance(choice, Stop):
            return rows[:j], choice
        if not isinstance(choice, Strip):
            raise InvalidValue(
                "what `choose` returns", repr(choice), "be a Strip or a Stop", "See `grow`."
            )
        rays = front.rays(choice.flap_angle, at=choice.at, boundary_angles=choice.boundary_angles)
        if j == 0 and any(beyond):
            rays = rays.between(drop, drop + size)
        lengths = lengths_along(choice.lengths, rays)
        if rays.closing_error > CLOSED:
            advice = (
                f"Strip {j + 1} of {strips}: once around the loop the flap angle misses itself by "
                f"{rays.closing_error:.3g} rad. Take one of `solver.transfer.loop_closings`."
            )
            return rows[:j], Stop(Status.LOOP_NOT_CLOSED, advice)
        trouble = length_trouble(lengths, rays)
        if trouble is not None:
            i, status, bound = trouble
            advice = f"Strip {j + 1} of {strips}: at front vertex {i} the length must {bound}."
            if j == 0:
                raise InvalidValue(f"length[{i}]", lengths[i], bound, advice)
            return rows[:j], Stop(status, f"{advice} {_CURE}")
        rows[j] = rays.row(lengths)
        if progress is not None:
            progress(j + 1, strips)
    return rows, None


def lengths_along(wanted: Lengths, rays: Rays) -> FloatArray:
    """One length for each crease of a strip; refuses arrays of another shape."""
    return rays.each(wanted(rays) if callable(wanted) else wanted)


def length_trouble(lengths: FloatArray, rays: Rays) -> tuple[int, Status, str] | None:
    """The first vertex whose length cannot be used, why, and the bound; None where all can."""
    least = least_length(rays)
    if lengths.min() > least and lengths.max() < LARGEST and (lengths < rays.length_bounds).all():
        return None
    unusable = np.flatnonzero(~((lengths > least) & (lengths < LARGEST)))
    if len(unusable):
        bound = f"be finite and greater than 0, {least:.2g} at least and {LARGEST:g} at most"
        return int(unusable[0]), Status.LENGTH_NOT_POSITIVE, bound
    i = int(np.flatnonzero(lengths >= rays.length_bounds)[0])
    bound = f"be below {rays.length_bounds[i]:.9g}, where neighbouring creases meet"
    return i, Status.LENGTH_OVER_BOUND, bound


def usable_lengths(lengths: FloatArray, rays: Rays) -> BoolArray:
    """Which vertices have a length that can be used, shape (m + 1,)."""
    size = (lengths > least_length(rays)) & (lengths < LARGEST)
    usable: BoolArray = size & (lengths < rays.length_bounds)
    return usable


def least_length(rays: Rays) -> float:
    """Shorter creases would drown in the rounding of the coordinates."""
    return max(SMALLEST, _RESOLVED * float(np.abs(rays.vertices_coords).max()))
