"""Pleated rings that end on tilting planes: twisted squares and nested cones (figures 4B, 4C)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import minimize_scalar

from solver.arcs import contain
from solver.errors import (
    InvalidValue,
    require_count,
    require_length,
    require_number,
    require_within,
)
from solver.front import Front
from solver.growth import Growth, Status, Stop, Strip, grow
from solver.mesh import QuadMesh
from solver.rays import Rays
from solver.transfer import Closing, inverse_matrices, transfer_each
from solver.vectors import FloatArray, angle_between
from solver.vertex import even_flap_angles

__all__ = ["COSTS", "TiltedRings"]

# What the flap angle makes least where every one closes the ring.
COSTS = ("even", "neighbours")

# Where in each free arc flap angles are tried before the best one is polished.
_SHARES = (np.arange(120) + 0.5) / 120


@dataclass(frozen=True)
class TiltedRings:
    """Seed: a cone over a regular polygon. Lengths: to the next ring's plane. Loops close exactly.

    Ring j lies in the plane tilted by j tilt about y at the distance
    (-1)^j height (1 + (j - 1) height_growth) / 2 from the origin. With an even number of sides
    every flap angle closes a ring that ends on a plane; the one of least cost is taken. With an odd
    number there are two, and the one that folds.

    Attributes
    ----------
    sides : of the polygon; the paper's figures have 4 and 100.
    strips : how many to grow after the seed's.
    height, height_growth : of the first ring over the plane, and its growth per ring.
    cone_angle : the seed's cone has the half-angle cone_angle / 2, radians.
    tilt : between the planes of successive rings, radians.
    opening : radius of the hole in the seed's cone, as a share of its outer radius.
    cost : even, the squares of theta1 - theta2 at all vertices; or neighbours, S34, as the authors'
        models 4B and 4C have it: the squares of what theta1, and theta2, change by from a vertex to
        the next, from vertex 1 once around to vertex 0, within the neighbourhoods (S35) of the flap
        angles that make the sectors of a vertex even.
    """

    sides: int = 4
    strips: int = 80
    height: float = 0.1
    height_growth: float = 0.0
    cone_angle: float = field(default=np.pi / 4, metadata={"angle": True})
    tilt: float = field(default=np.pi / 180, metadata={"angle": True})
    opening: float = 0.01
    cost: str = "even"

    def grow(self, progress: Callable[[int, int], None] | None = None) -> Growth:
        """Grow the rings. Raises `InvalidValue` for parameters out of bounds."""
        require_count("sides", self.sides, 3, "A ring has three corners or more.")
        require_length("height", self.height)
        require_within("cone_angle", self.cone_angle, 0, np.pi, "45 degrees is common.", angle=True)
        require_within("tilt", self.tilt, -np.pi, np.pi, "Small angles fold further.", angle=True)
        require_number("height_growth", self.height_growth)
        if not -1 < self.height_growth < 100:
            raise InvalidValue(
                "height_growth", self.height_growth, "lie between -1 and 100", "0 keeps it."
            )
        require_within("opening", self.opening, 0.0, 1.0, "The paper has 0.01.")
        if self.cost not in COSTS:
            raise InvalidValue(
                "cost", self.cost, f"be one of {', '.join(COSTS)}", "even is the default."
            )
        around = 2 * np.pi * np.arange(self.sides) / self.sides
        corners = np.column_stack([np.cos(around), np.sin(around), 0 * around])
        axis = np.array([0.0, 0.0, 1.0])
        radius = self.height * np.tan(self.cone_angle / 2)
        rows = [
            share * radius * corners + z * self.height * axis
            for share, z in ((self.opening, self.opening - 0.505), (1.0, 0.495))
        ]

        def choose(front: Front, strip: int) -> Strip | Stop:
            turn = (strip + 1) * self.tilt
            normal = np.array([-np.sin(turn), 0.0, np.cos(turn)])
            sign = -1.0 if strip % 2 == 0 else 1.0
            distance = sign * self.height * (1 + strip * self.height_growth) / 2

            def to_plane(rays: Rays) -> FloatArray:
                to_go = distance - rays.vertices_coords @ normal
                lengths: FloatArray = to_go / (rays.directions @ normal)
                return lengths

            return _folded_strip(front, to_plane, self.cost)

        return grow(QuadMesh.from_rows(rows, closed=True), self.strips, choose, progress=progress)


def _folded_strip(front: Front, lengths: Callable[[Rays], FloatArray], cost: str) -> Strip | Stop:
    """The strip that closes the loop with new folds, of the least cost."""
    closings = front.closings()
    if closings.case is Closing.CONTINUATION:
        return Stop(
            Status.LOOP_NOT_CLOSED,
            "The ring closes only by continuing the faces behind it, without folds: end every ring "
            "on a plane, or use an odd number of sides.",
        )
    if closings.case is Closing.PAIR:
        at, flap_angle = closings.start[1]
        return Strip(flap_angle, lengths, at=at + 1)

    # candidates cross no face at any vertex and reach the plane
    free = front.free_flap_angles()
    evens = _even_at_a_vertex(front)
    chosen = _most_even if cost == "even" else _most_alike
    best = chosen(front, free, evens, lambda angle: _usable(front.rays(angle), lengths))
    if best is None:
        return Stop(
            Status.LOOP_NOT_CLOSED,
            "No flap angle keeps the ring off the one before and reaches the next plane: "
            "tilt the planes less, or make the rings higher.",
        )
    return Strip(best, lengths)


def _even_at_a_vertex(front: Front) -> list[FloatArray]:
    """First flap angles that make the sectors of a vertex even, on both sides, shape (N,) each."""
    matrices = inverse_matrices(front.transfer_matrices)
    both = even_flap_angles(front.beta, front.k)
    return [transfer_each(matrices, angles[:, None])[:, 0] for angles in both]


def _sectors(front: Front, flap_angle: float) -> tuple[FloatArray, FloatArray]:
    """Design angles theta1 and theta2 of a loop's vertices."""
    rays = front.rays(flap_angle)
    a, b = -front.edges_direction[:-1], front.edges_direction[1:]
    return angle_between(a, rays.directions), angle_between(b, rays.directions)


def _most_even(
    front: Front, free: FloatArray, evens: list[FloatArray], usable: Callable[[float], bool]
) -> float | None:
    """The usable flap angle at which theta1 and theta2 are most alike at the vertices."""

    def unevenness(flap_angle: float) -> float:
        theta1, theta2 = _sectors(front, flap_angle)
        skew = theta1 - theta2
        return float(skew @ skew)

    candidates = [
        start + share * ((end - start) % (2 * np.pi))
        for start, end in free.tolist()
        for share in _SHARES
    ]
    # on a fine ring creases meet early except near even sectors at some vertex
    for even in evens:
        candidates += even[contain(free, even)].tolist()
    reached = [angle for angle in candidates if usable(angle)]
    if not reached:
        return None
    best = min(reached, key=unevenness)
    polished = float(minimize_scalar(unevenness, bracket=(best, best + 1e-4)).x)
    return polished if usable(polished) else best


def _most_alike(
    front: Front, free: FloatArray, evens: list[FloatArray], usable: Callable[[float], bool]
) -> float | None:
    """The usable flap angle at which theta1 and theta2 change least from vertex to vertex (S34).

    Looked for between the least and the greatest of the flap angles that make a vertex even (S35),
    on either side.
    """

    def change(flap_angle: float) -> float:
        steps = [np.diff(np.roll(theta, -1)) for theta in _sectors(front, flap_angle)]
        return float(steps[0] @ steps[0] + steps[1] @ steps[1])

    best: float | None = None
    for even in evens:
        off = np.angle(np.exp(1j * (even - even[0])))
        low, high = float(even[0] + off.min()), float(even[0] + off.max())
        candidates = [low + share * (high - low) for share in _SHARES.tolist()]
        inside = contain(free, np.array(candidates) % (2 * np.pi))
        reached = [angle for angle, kept in zip(candidates, inside, strict=True) if kept]
        reached = [angle for angle in reached if usable(angle)]
        if not reached:
            continue
        near = min(reached, key=change)
        step = (high - low) / len(_SHARES)
        bounds = max(low, near - step), min(high, near + step)
        options = {"xatol": 1e-13}
        polished = float(
            minimize_scalar(change, bounds=bounds, method="bounded", options=options).x
        )
        found = polished if usable(polished) and change(polished) <= change(near) else near
        if best is None or change(found) < change(best):
            best = found
    return best


def _usable(rays: Rays, lengths: Callable[[Rays], FloatArray]) -> bool:
    size = lengths(rays)
    return bool((size > 0).all() and (size < rays.length_bounds).all())
