"""A crumpled sheet: random flap angles and lengths on a corrugated seed (figures 4E and S16)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from solver import seeds
from solver.arcs import at_share
from solver.errors import InvalidValue, require_count, require_length, require_number
from solver.front import Front
from solver.growth import Growth, Status, Stop, Strip, grow
from solver.rays import Rays
from solver.transfer import transfer_flap_angles
from solver.vectors import FloatArray

__all__ = ["Crumpled"]

# Flap angles that a strip tries, for those that fold away from the strip before.
_TRIALS = 256


@dataclass(frozen=True)
class Crumpled:
    """Seed: a corrugated strip with random creases. Flap angles and lengths: random.

    As printed, a flap angle is uniform over the exterior of the union of the intervals in which new
    faces cross old ones somewhere, and L is one for all creases of a strip, the least of their
    bounds: so it is in the authors' model of figure 4E. Ours keeps sheets open: it draws from the
    flap angles that fold most new creases away from the old ones, and each crease has its own L.

    Attributes
    ----------
    columns, strips : number of quads in each direction, the seed's strip included.
    beta, k : angles of the seed's front, radians.
    power : p of the lengths X (1 - k/2pi)^p, X uniform in (0.1, 0.9) of the length's bound:
        the larger, the more a strip shrinks towards flat regions.
    length_limit : taken as the bound of a crease that its neighbours do not meet (nearby).
    seed_deviation : standard deviation of the seed's crease lengths about 1 (normal, positive).
    random_seed : the same number gives the same sheet.
    as_printed : whether flap angles and lengths are drawn by the printed recipe.
    """

    columns: int = 20
    strips: int = 40
    beta: float = field(default=0.6 * np.pi, metadata={"angle": True})
    k: float = field(default=1.2 * np.pi, metadata={"angle": True})
    power: float = 2.0
    length_limit: float = 2.0
    seed_deviation: float = 0.4
    random_seed: int = 0
    as_printed: bool = False

    def grow(self, progress: Callable[[int, int], None] | None = None) -> Growth:
        """Grow the sheet. Raises `InvalidValue` for parameters out of bounds."""
        require_count("strips", self.strips, 2, "The seed itself is the first strip.")
        require_count("random_seed", self.random_seed, 0, "Any whole number in this range will do.")
        require_length("length_limit", self.length_limit)
        require_count("columns", self.columns, 2, "A strip needs an interior crease.")
        for name, value in (("power", self.power), ("seed_deviation", self.seed_deviation)):
            require_number(name, value)
            if not 0 <= value <= 20:
                raise InvalidValue(name, value, "be from 0 to 20", "Try the default.")
        random = np.random.Generator(np.random.PCG64(self.random_seed))
        lengths = _positive_normal(random, self.columns + 1, abs(self.seed_deviation))
        seed = seeds.corrugated(self.columns, self.beta, self.k, lengths)

        def choose(front: Front, strip: int) -> Strip | Stop:
            if not self.as_printed:
                return Strip(_flap_angle(front, random), self._lengths(front, random))
            free = front.free_flap_angles()
            if not len(free):
                return Stop(
                    Status.FACES_CROSS,
                    f"Strip {strip + 1}: at every flap angle new faces would cross old ones "
                    "somewhere. Use another random_seed, or as_printed = false.",
                )
            return Strip(at_share(free, random.uniform()), self._lengths(front, random))

        return grow(seed, self.strips - 1, choose, progress=progress)

    def _lengths(self, front: Front, random: np.random.Generator) -> Callable[[Rays], FloatArray]:
        def lengths(rays: Rays) -> FloatArray:
            bound = np.minimum(rays.length_bounds, self.length_limit)
            if self.as_printed:
                bound = np.full_like(bound, bound.min())
            free = np.interp(np.arange(len(bound)), np.arange(1, len(bound) - 1), front.k)
            share = random.uniform(0.1, 0.9, len(bound))
            return share * bound * (1 - free / (2 * np.pi)) ** self.power

        return lengths


def _positive_normal(random: np.random.Generator, count: int, deviation: float) -> FloatArray:
    values = 1 + random.normal(0.0, deviation, count)
    while (values <= 0).any():
        again = values <= 0
        values[again] = 1 + random.normal(0.0, deviation, int(again.sum()))
    return values


def _flap_angle(front: Front, random: np.random.Generator) -> float:
    """A random flap angle that folds every new crease away from the old ones, where there is one.

    Of evenly spread candidates with the most creases folding away, one from the middle half of
    the longest run is drawn: its ends nearly lock some vertex, and rows would close up there.
    """
    trials = (np.arange(_TRIALS, dtype=np.float64) + random.uniform()) * (2 * np.pi / _TRIALS)
    flap_angles = transfer_flap_angles(front.transfer_matrices, trials)
    away = front.away_from_back(flap_angles).sum(axis=0)
    best = np.flatnonzero(away == away.max())
    # runs on the circle: start after a gap, so that no run passes the end of the list
    gaps = np.diff(best, append=best[0] + _TRIALS)
    best = np.roll(best, -1 - int(np.argmax(gaps)))
    runs = np.split(best, np.flatnonzero(np.diff(best) % _TRIALS != 1) + 1)
    run = max(runs, key=len)
    return float(trials[run[int(len(run) * random.uniform(0.25, 0.75))]])
