"""The choice of strip after strip between the two offsets of a surface (S4)."""

from __future__ import annotations

import numpy as np

from solver.errors import InvalidValue
from solver.flap_costs import DesignAngleCost, FlapCost, is_free
from solver.front import Front
from solver.growth import Status, Stop, Strip, usable_lengths
from solver.mirroring import Mirror
from solver.rays import Rays
from solver.targets.base import Target, ray_hit
from solver.vectors import FloatArray

__all__ = ["COSTS", "Follower"]

# What a strip's flap angle makes least: the distance to mirrored creases, or S30.
COSTS = ("mirror", "design_angles")

# How near the last good flap angle the next one is expected, and how much more each crease may miss
# its mirror image there before all flap angles are tried again, as 1 - cosine.
_NEAR = 0.05
_WORSE = 0.05
# Flap angles tried besides the one of least cost where the strip after it would miss, radians.
_ASIDE = np.array([1e-3, 3e-3, 0.01, 0.03, 0.1])


class Follower:
    """Chooses strip after strip from one offset to the other, until the domain is passed."""

    def __init__(
        self,
        target: Target,
        places: FloatArray,
        offset: float,
        longest: float,
        *,
        cost: str = "mirror",
        lookahead: bool = False,
    ) -> None:
        """Begin on a front of these places, (m + 1, d), on this offset; `longest` of its creases.

        cost : of `COSTS`; lookahead : whether a flap angle after which creases would miss gives way
        to one beside it.
        """
        self.target = target
        self.cost = cost
        self.lookahead = lookahead
        self.places = places  # of the front of this strip
        self.strip = 0
        self.seed_offset = offset
        self.longest = longest
        self.rows: list[FloatArray] = []  # places of the rows grown, by strip
        self.found: dict[int, tuple[float, float]] = {}  # angle and cost by the strip's parity

    def choose(self, front: Front, strip: int) -> Strip | Stop:
        """The next strip, for `solver.growth.grow`."""
        self._go_to(strip)
        middles = self.target.places((self.places[1:, :2] + self.places[:-1, :2]) / 2)
        if not self.target.inside(np.concatenate([self.places, middles])).any():
            return Stop(Status.COVERED, "The domain is covered.")
        flap_angle = self._flap_angle(front, strip % 2)
        if flap_angle is None:
            return Stop(
                Status.FACES_CROSS,
                f"Strip {strip + 1}: at every flap angle new faces would cross old ones somewhere. "
                "A larger zigzag or row_step gives the front more room.",
            )
        if self.lookahead:
            flap_angle = self._looked_ahead(front, flap_angle)

        def to_offset(rays: Rays) -> FloatArray:
            lengths, places = self._reached(rays, strip, self.places)
            self.rows.append(places)
            return lengths

        return Strip(flap_angle, to_offset)

    def narrow(self, strip: int, first: int, last: int) -> None:
        """Leave vertices of this strip's front out, for `solver.ending_rows`."""
        self._go_to(strip)
        self.places = self.places[first:last]
        if first:  # flap angles are counted at vertex 1
            self.found.clear()

    def _go_to(self, strip: int) -> None:
        """Begin this strip, or begin it again: what was chosen for it before is void."""
        if strip > self.strip:
            self.strip, self.places = strip, self.rows[strip - 1]
        del self.rows[strip:]

    def _reached(self, rays: Rays, strip: int, places: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Lengths of a strip's creases, NaN where they miss its offset nearby, and places there."""
        offset = self.seed_offset * (-1.0) ** (strip + 1)
        lengths, found = ray_hit(self.target, rays.vertices_coords, rays.directions, offset, places)
        return np.where(lengths < self.longest, lengths, np.nan), found

    def _looked_ahead(self, front: Front, flap_angle: float) -> float:
        """The flap angle, or one beside it, after which the fewest creases miss their offsets."""
        fewest = self._misses(front, flap_angle)
        if fewest == 0:
            return flap_angle
        free = front.free_flap_angles()
        best = flap_angle
        for aside in np.stack([-_ASIDE, _ASIDE], axis=1).ravel().tolist():
            trial = flap_angle + aside
            if is_free(free, trial):
                misses = self._misses(front, trial)
                if misses < fewest:
                    best, fewest = trial, misses
        return best

    def _misses(self, front: Front, flap_angle: float) -> int:
        """How many creases of this strip, and of the next one after it, cannot be grown."""
        size = len(self.places)
        rays = front.rays(flap_angle)
        lengths, places = self._reached(rays, self.strip, self.places)
        missed = size - int(usable_lengths(lengths, rays).sum())
        if missed:
            return size + missed
        row = rays.row(lengths)
        try:
            following = Front.between(row, front.vertices_coords)
        except InvalidValue:
            return size
        free = following.free_flap_angles()
        if not len(free):
            return size
        rays = following.rays(self._cost_of(following, places).best_of(free))
        lengths, _ = self._reached(rays, self.strip + 1, places)
        return size - int(usable_lengths(lengths, rays).sum())

    def _flap_angle(self, front: Front, parity: int) -> float | None:
        """The free flap angle of least cost; None where none is free.

        Looked for near that of the strip before the last, and all around only where it is not
        there any more or has become much worse.
        """
        free = front.free_flap_angles()
        if not len(free):
            return None
        flap_cost = self._cost_of(front, self.places)
        known = self.found.get(parity)
        if known is not None:
            angle = flap_cost.minimum(known[0] - _NEAR, known[0] + _NEAR)
            if angle is not None and is_free(free, angle):
                cost = float(flap_cost.cost(np.array([angle]))[0])
                if cost <= known[1] + _WORSE * len(front.beta):
                    self.found[parity] = angle, cost
                    return angle
        angle = flap_cost.best_of(free)
        self.found[parity] = angle, float(flap_cost.cost(np.array([angle]))[0])
        return angle

    def _cost_of(self, front: Front, places: FloatArray) -> FlapCost:
        if self.cost == "design_angles":
            return DesignAngleCost.of(front)
        return Mirror.of(front, self.target.normal(places[1:-1]))
