"""Strips that are chosen one by one: what can be grown, what cannot and why, and a first proposal.

Growth that a rule drives ends where it cannot go on; here somebody has chosen, so that a choice
which cannot be grown is refused, with the bound that it missed.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from solver.arcs import contain
from solver.errors import InvalidState, InvalidValue, require_number
from solver.flap_costs import DesignAngleCost
from solver.front import Front
from solver.growth import CLOSED, Strip, grow, length_trouble
from solver.mesh import QuadMesh, Side
from solver.rays import Rays
from solver.transfer import Closing
from solver.vectors import FloatArray, norm

__all__ = [
    "ChosenStrip",
    "free_arcs_of",
    "grown_strip",
    "nearest_arc",
    "proposed_strip",
    "strip_front",
]

# Arcs that meet in a locked flap angle leave as much by rounding, radians.
_NARROW = 1e-9
# A proposed strip keeps its creases clear of where they meet, by this share.
_CLEAR = 0.6
# Decimals of a proposed flap angle, in degrees, and digits of its lengths.
_DECIMALS, _DIGITS = 2, 3
# Flap angles around the circle that are tried for it.
_TRIALS = 360


@dataclass(frozen=True)
class ChosenStrip:
    """The choices of one strip: where it grows, how it folds, how wide it is.

    Attributes
    ----------
    side : of the sheet as it is then: top, right, bottom or left.
    flap_angle : at the first interior vertex of that side, which new growth has on its left,
        radians.
    lengths : of the creases across the strip: one for all, or one for each vertex of the side, in
        the same order.
    boundary_angles : design angles at the first and last vertex of the side, between it and the new
        boundary, radians in (0, pi); left out: boundaries parallel to the creases beside them.
    """

    side: Side = Side.TOP
    flap_angle: float = field(default=np.pi / 2, metadata={"angle": True})
    lengths: float | tuple[float, ...] = 1.0
    boundary_angles: tuple[float, float] | None = field(default=None, metadata={"angle": True})

    def rays(self, front: Front) -> Rays:
        """The creases of the strip on its front. Raises `InvalidValue` for angles out of bounds."""
        return front.rays(self.flap_angle, boundary_angles=self.boundary_angles or (None, None))


def strip_front(mesh: QuadMesh, side: Side) -> Front:
    """The front on a side of a sheet. Raises `InvalidState` for sides on which no strip can grow.

    >>> from solver.designs import Miura
    >>> len(strip_front(Miura(columns=4, rows=2).grow().mesh, Side.RIGHT).k)
    1
    """
    if mesh.closed and side in (Side.LEFT, Side.RIGHT):
        raise InvalidState(
            "side", "a ring has no left and right side", "Grow on its top or bottom."
        )
    if len(mesh.pentagons) and side is Side.BOTTOM:
        raise InvalidState(
            "side", "a filled corner is between the bottom and the rest", "Grow on another side."
        )
    count = len(mesh.front_vertices(side))
    if count < 3 and not mesh.closed:
        raise InvalidState(
            "side",
            f"the {side} side of the sheet has {count} vertices and none between its ends",
            "Grow on the sides beside it first.",
        )
    try:
        return Front.of(mesh, side)
    except InvalidState:
        raise
    except InvalidValue as error:
        raise InvalidState(
            "side",
            f"on the {side} side new faces have no room to fold, as {error.name} is {error.value}",
            "Turn the strips beside it, or grow on another side.",
        ) from error


def grown_strip(mesh: QuadMesh, chosen: ChosenStrip, name: str = "strip") -> QuadMesh:
    """The sheet with one more strip.

    name : of the strip, in messages. Raises `InvalidValue` for a flap angle at which new faces
    cross old ones or a loop does not close, with the nearest angles that are free, and for lengths
    out of bounds; `InvalidState` for sides on which no strip can grow.

    >>> from solver.designs import Miura
    >>> seed = Miura(columns=4, rows=2).grow().mesh
    >>> grown_strip(seed, ChosenStrip(Side.TOP, np.radians(100), 0.5)).grid.shape
    (4, 5)
    >>> try:
    ...     grown_strip(seed, ChosenStrip(Side.TOP, np.radians(20), 0.5))
    ... except InvalidValue as error:
    ...     print(error.name, error.bound[:50])
    flap angle of strip lie between 180 deg (3.14159265 rad) and 360 deg (
    """
    try:
        strip_front(mesh, chosen.side)
    except InvalidValue as error:
        raise _of(name, error) from error
    lengths = chosen.lengths
    given = np.asarray(lengths, float) if isinstance(lengths, tuple | list) else lengths

    def choose(front: Front, _strip: int) -> Strip:
        require_number(f"flap angle of {name}", chosen.flap_angle)
        if front.closed and chosen.boundary_angles is not None:
            raise InvalidState(
                name, f"{name}: a ring has no boundary angles", "Leave boundary_angles out."
            )
        closing = closing_flap_angles(front)
        if closing is not None:
            _require_closing(front, float(chosen.flap_angle), closing, name)
        else:
            _require_free(front, float(chosen.flap_angle), name)
        try:
            rays = chosen.rays(front)
            trouble = length_trouble(rays.each(given), rays)
        except InvalidValue as error:
            raise _of(name, error) from error
        if trouble is not None:
            i, _, bound = trouble
            raise InvalidValue(
                f"length at vertex {i} of {name}",
                f"{rays.each(given)[i]:.9g}",
                bound,
                "Give another length there, or another flap angle.",
            )
        return Strip(
            chosen.flap_angle, given, boundary_angles=chosen.boundary_angles or (None, None)
        )

    return grow(mesh, 1, choose, side=chosen.side).mesh


def _of(name: str, error: InvalidValue) -> InvalidValue:
    """The same error, of a strip by name."""
    if isinstance(error, InvalidState):
        return InvalidState(name, f"{name}: {error.value}", error.cure)
    return InvalidValue(f"{error.name} of {name}", error.value, error.bound, error.cure)


def free_arcs_of(front: Front) -> FloatArray:
    """Free flap angles at front vertex 1, as arcs, shape (k, 2), but those of rounding alone."""
    free = front.free_flap_angles()
    wide = np.remainder(free[:, 1] - free[:, 0], 2 * np.pi) > _NARROW
    out: FloatArray = free[wide | (np.ptp(free, axis=1) == 2 * np.pi)]
    return out


def closing_flap_angles(front: Front) -> FloatArray | None:
    """Flap angles at front vertex 1 that close a loop without crossings, the continuation first.

    None for open fronts, and for loops that close at every flap angle.
    """
    if not front.closed:
        return None
    closings = front.closings()
    if closings.case is Closing.FAMILY:
        return None
    closing: FloatArray = closings.flap_angles[contain(free_arcs_of(front), closings.flap_angles)]
    return closing


def nearest_arc(free: FloatArray, angle: float) -> FloatArray:
    """Of free arcs, shape (k, 2), k at least 1, the one whose end is nearest, shape (2,).

    >>> nearest_arc(np.array([[6.0, 1.0], [2.0, 3.0]]), 1.2).tolist()
    [6.0, 1.0]
    """
    away = np.abs(np.remainder(free - angle + np.pi, 2 * np.pi) - np.pi).min(axis=1)
    nearest: FloatArray = free[int(np.argmin(away))]
    return nearest


def _require_free(front: Front, flap_angle: float, name: str) -> None:
    free = free_arcs_of(front)
    if not len(free):
        raise InvalidState(
            name,
            f"{name}: new faces would cross old ones at every flap angle",
            "Change the strips before it, or grow on another side.",
        )
    angle = flap_angle % (2 * np.pi)
    if contain(free, np.array([angle]))[0] or np.ptp(free[0]) == 2 * np.pi:
        return
    start, end = nearest_arc(free, angle).tolist()
    past = ", past 0" if 0 < end < start else ""
    raise InvalidValue(
        f"flap angle of {name}",
        _angle(flap_angle),
        f"lie between {_angle(start)} and {_angle(end or 2 * np.pi)}{past}, the nearest angles at "
        "which new faces do not cross old ones",
        "Choose one of them.",
    )


def _require_closing(front: Front, flap_angle: float, closing: FloatArray, name: str) -> None:
    """Refuse a flap angle of a loop that is none of those that close it."""
    if not len(closing):
        raise InvalidState(
            name,
            f"{name}: where the ring closes new faces would cross old ones",
            "Change the strips before it, or grow on another side.",
        )
    miss = np.abs(np.remainder(closing - flap_angle + np.pi, 2 * np.pi) - np.pi).min()
    if miss <= CLOSED and front.rays(flap_angle).closing_error <= CLOSED:
        return
    raise InvalidValue(
        f"flap angle of {name}",
        _angle(flap_angle),
        f"be {' or '.join(map(_angle, closing.tolist()))}",
        "Give all its digits: at others the ring does not close.",
    )


def _angle(angle: float) -> str:
    return f"{np.degrees(angle):.9g} deg ({angle:.9g} rad)"


def proposed_strip(mesh: QuadMesh, side: Side) -> ChosenStrip:
    """A strip that can be grown on a side, to begin with.

    Its creases are as long as those behind them are on average, or shorter where these would come
    too near to each other at every flap angle. Its flap angle is the free one of least cost S30 at
    which they do not; of a loop that closes for two alone, the one that folds. Both are rounded.

    Raises `InvalidState` for sides on which no strip can grow.

    >>> from solver.designs import Miura
    >>> strip = proposed_strip(Miura(columns=6, rows=3).grow().mesh, Side.TOP)
    >>> round(float(np.degrees(strip.flap_angle)), 4), strip.lengths
    (135.0, 1.0)
    """
    front = strip_front(mesh, side)
    behind = mesh.previous_vertices(side)
    assert behind is not None  # `strip_front` has faces behind it
    coords = mesh.vertices_coords
    usual = float(norm(coords[behind] - coords[mesh.front_vertices(side)]).mean())
    angles = _candidates(front)
    if not len(angles):
        raise InvalidState(
            "side",
            f"no strip can grow on the {side} side: new faces would cross old ones at every flap "
            "angle",
            "Grow on another side, or change the strips before.",
        )
    room = _CLEAR * np.array([front.rays(angle).length_bounds.min() for angle in angles.tolist()])
    wide = room >= usual
    best = int(np.argmax(wide) if wide.any() else np.argmax(room))
    length = min(usual, float(room[best]))
    digit = 10.0 ** (np.floor(np.log10(length)) - _DIGITS + 1)
    rounded = float(f"{np.floor(length / digit + 1e-6) * digit:.{_DIGITS}g}")
    return ChosenStrip(side, float(angles[best]), rounded)


def _candidates(front: Front) -> FloatArray:
    """Flap angles with which a front can grow, the best first, shape (n,)."""
    free = free_arcs_of(front)
    if not len(free):
        return np.empty(0)
    closing = closing_flap_angles(front)
    if closing is not None:
        last_first: FloatArray = closing[::-1]  # the continuation, which has no folds, comes first
        return last_first
    cost = DesignAngleCost.of(front)
    start, end = free.T
    span = np.remainder(end - start, 2 * np.pi)
    span[span == 0] = 2 * np.pi
    middles = (start + span / 2) % (2 * np.pi)
    even = np.arange(_TRIALS) * (2 * np.pi / _TRIALS)
    best = np.radians(np.round(np.degrees([cost.best_of(free) % (2 * np.pi)]), _DECIMALS))
    trials = np.concatenate([best, even, middles])
    trials = trials[contain(free, trials) | (np.ptp(free, axis=1) == 2 * np.pi).any()]
    best_first: FloatArray = trials[np.argsort(cost.cost(trials), kind="stable")]
    return best_first
