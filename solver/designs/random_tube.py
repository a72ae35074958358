"""A closed tube of random facets with free crease lengths: odd rings need no planes to close."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from solver.errors import InvalidValue, require_count, require_within
from solver.front import Front
from solver.growth import Growth, Status, Stop, Strip, grow
from solver.mesh import QuadMesh
from solver.rays import Rays
from solver.transfer import Closing
from solver.vectors import FloatArray

__all__ = ["RandomTube"]


@dataclass(frozen=True)
class RandomTube:
    """Seed: a random loop of an odd number of vertices. Flap angle: the root that folds.

    A loop of odd length closes for exactly two flap angles, whatever its shape; on the seed both
    fold, later one continues the faces behind and the other one, taken here, folds.

    Attributes
    ----------
    sides : of the loop, odd.
    strips : how many to grow.
    k : angle left for the first strip's faces at every vertex of the seed, radians.
    jitter : standard deviation of the seed's vertices about a circle of radius 1.
    crease_length : mean length of the creases; each is drawn between a half and one and a half of
        it, and shortened to four tenths of the length at which neighbours would meet.
    random_seed : the same number gives the same tube.
    """

    sides: int = 9
    strips: int = 4
    k: float = field(default=np.pi, metadata={"angle": True})
    jitter: float = 0.15
    crease_length: float = 0.5
    random_seed: int = 0

    def grow(self, progress: Callable[[int, int], None] | None = None) -> Growth:
        """Grow the tube. Raises `InvalidValue` for parameters out of bounds."""
        require_count("sides", self.sides, 3, "A ring has three corners or more.")
        if self.sides % 2 == 0:
            raise InvalidValue(
                "sides",
                self.sides,
                "be odd",
                "Even loops close with new folds on planes alone: see tilted_rings.",
            )
        require_within("jitter", self.jitter, 0.0, 0.5, "Small jitter keeps the loop open.")
        require_within("crease_length", self.crease_length, 1e-6, 1e6, "Half the radius is common.")
        require_count("random_seed", self.random_seed, 0, "Any whole number in this range will do.")
        random = np.random.Generator(np.random.PCG64(self.random_seed))
        around = 2 * np.pi * np.arange(self.sides) / self.sides
        loop = np.column_stack([np.cos(around), np.sin(around), 0 * around])
        loop += random.normal(0.0, self.jitter, loop.shape)

        def lengths(rays: Rays) -> FloatArray:
            wanted = self.crease_length * random.uniform(0.5, 1.5, self.sides)
            out: FloatArray = np.minimum(wanted, 0.4 * rays.length_bounds)
            return out

        def choose(front: Front, strip: int) -> Strip | Stop:
            closings = front.closings()
            if closings.case is not Closing.PAIR:
                return Stop(
                    Status.LOOP_NOT_CLOSED,
                    f"Strip {strip + 1}: the loop closes by {closings.case} only. Use another "
                    "random_seed or more jitter.",
                )
            at, flap_angle = closings.start[-1]
            return Strip(flap_angle, lengths, at=at + 1)

        seed = QuadMesh.from_rows(loop[None], closed=True)
        return grow(seed, self.strips, choose, k=self.k, progress=progress)
