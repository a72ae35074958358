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
from solver.front import Front, Rays
from solver.growth import Growth, Status, Stop, Strip, grow
from solver.mesh import QuadMesh
from solver.transfer import Closing, inverse_matrices, transfer_each
from solver.vectors import FloatArray, angle_between
from solver.vertex import even_flap_angles

__all__ = ["TiltedRings"]

# Where in each free arc flap angles are tried before the best one is polished.
_SHARES = (np.arange(120) + 0.5) / 120


@dataclass(frozen=True)
class TiltedRings:
    """Seed: a cone over a regular polygon. Lengths: to the next ring's plane. Loops close exactly.

    Ring j lies in the plane tilted by j tilt about y at the distance
    (-1)^j height (1 + (j - 1) height_growth) / 2 from the origin. With an even number of sides
    every flap angle closes a ring that ends on a plane; the one that makes the two new sectors at
    the vertices most alike is taken. With an odd number there are two, and the one that folds.

    Attributes
    ----------
    sides : of the polygon; the paper's figures have 4 and 100.
    strips : how many to grow after the seed's.
    height, height_growth : of the first ring over the plane, and its growth per ring.
    cone_angle : the seed's cone has the half-angle cone_angle / 2, radians.
    tilt : between the planes of successive rings, radians.
    opening : radius of the hole in the seed's cone, as a share of its outer radius.
    """

    sides: int = 4
    strips: int = 80
    height: float = 0.1
    height_growth: float = 0.0
    cone_angle: float = field(default=np.pi / 4, metadata={"angle": True})
    tilt: float = field(default=np.pi / 180, metadata={"angle": True})
    opening: float = 0.01

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

            return _folded_strip(front, to_plane)

        return grow(QuadMesh.from_rows(rows, closed=True), self.strips, choose, progress=progress)


def _folded_strip(front: Front, lengths: Callable[[Rays], FloatArray]) -> Strip | Stop:
    """The strip that closes the loop with new folds and the most even sectors."""
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

    a, b = -front.edges_direction[:-1], front.edges_direction[1:]

    def unevenness(flap_angle: float) -> float:
        rays = front.rays(flap_angle)
        skew = angle_between(a, rays.directions) - angle_between(b, rays.directions)
        return float(skew @ skew)

    # candidates cross no face at any vertex and reach the plane
    free = front.free_flap_angles()
    candidates = [
        start + share * ((end - start) % (2 * np.pi))
        for start, end in free.tolist()
        for share in _SHARES
    ]
    # on a fine ring creases meet early except near even sectors at some vertex
    matrices = inverse_matrices(front.transfer_matrices)
    for angles in even_flap_angles(front.beta, front.k):
        even = transfer_each(matrices, angles[:, None])[:, 0]
        candidates += even[contain(free, even)].tolist()
    reached = [angle for angle in candidates if _usable(front.rays(angle), lengths)]
    if not reached:
        return Stop(
            Status.LOOP_NOT_CLOSED,
            "No flap angle keeps the ring off the one before and reaches the next plane: "
            "tilt the planes less, or make the rings higher.",
        )
    best = min(reached, key=unevenness)
    polished = float(minimize_scalar(unevenness, bracket=(best, best + 1e-4)).x)
    return Strip(polished if _usable(front.rays(polished), lengths) else best, lengths)


def _usable(rays: Rays, lengths: Callable[[Rays], FloatArray]) -> bool:
    size = lengths(rays)
    return bool((size > 0).all() and (size < rays.length_bounds).all())
