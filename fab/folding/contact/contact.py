"""Contact of a sheet with itself: a barrier that keeps its faces from passing through each other.

Incremental potential contact (Li et al. 2020): every vertex and triangle, and every two edges, that
are nearer to each other than their gap and the reach of the barrier repel each other, without bound
as they come to their gap (`fab.folding.contact.barrier`); and every step ends before any of them
would touch (`fab.folding.contact.free_share`). Edges that are nearly parallel repel each other less
and less, since their closest points jump: their ends do it in their place.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from fab.folding.contact.barrier import barrier, barrier_curvature, barrier_slope
from fab.folding.contact.closest_points import separations
from fab.folding.contact.free_share import free_share
from fab.folding.contact.near_pairs import NearPairs, near_pairs
from fab.folding.contact.surface import Pairs, Surface, weights_of
from fab.folding.contact.work import Work
from solver.assembly import Blocks
from solver.vectors import FloatArray, cross, dot, scattered

__all__ = ["Contact", "Touching"]

# The square of the sine between edges below which they count as nearly parallel.
_NEARLY_PARALLEL = 1e-3
# Pairs are looked for again where there are more than so many for each vertex, and the boxes for
# which they were found are so much larger than needed.
_FEW, _LOOSE = 100, 10.0
# A step longer than the sides of the triangles is looked at in up to this many parts.
_MOST_PARTS = 16
# Within their gap parts have no less than this share of their reach: their energy is infinite.
_TINY = 1e-300
# Boxes are larger than a step needs by this share of it, so that the next ones are in them too.
_MARGIN = 0.25
# And by this share of the mean side of a triangle.
_SIDES = 0.15


@dataclass(frozen=True)
class Touching:
    """Pairs within the reach of their barriers.

    Attributes
    ----------
    pairs : which. weights, normal : shapes (n, 4) and (n, 3), of their closest points.
    room, reach : shape (n,): distance beyond the gap, and reach of the barrier.
    pressure : shape (n,), the force between them.
    parallel : shape (n,), factor of edges that are nearly parallel, 1 for others; by_first,
        by_second : shape (n, 3), its gradient by the direction of each edge.
    """

    pairs: Pairs
    weights: FloatArray
    normal: FloatArray
    room: FloatArray
    reach: FloatArray
    pressure: FloatArray
    parallel: FloatArray
    by_first: FloatArray
    by_second: FloatArray


@dataclass(frozen=True)
class _Seen:
    """The pairs that were found last; they serve until a vertex leaves its box."""

    near: list[NearPairs] = field(default_factory=list)
    touching: list[tuple[FloatArray, Touching]] = field(default_factory=list)


@dataclass(frozen=True)
class Contact:
    """The energy of contact, a `fab.folding.potentials.Potential`.

    Attributes
    ----------
    surface : what may touch.
    reach : of the barrier beyond the gap, relative to the size of the sheet.
    force : stiffness of the barrier, in those of hinges (energy over length).
    work : what looking at pairs is counted in.
    """

    surface: Surface
    reach: float
    force: float
    work: Work = field(default_factory=Work, repr=False, compare=False)
    _seen: _Seen = field(default_factory=_Seen, repr=False, compare=False)

    def energy(self, coords: FloatArray) -> float:
        """Energy at coords, shape (nv, 3); infinite where two parts are within their gap."""
        found = self.touching(coords)
        if not len(found.room):
            return 0.0
        height = np.where(found.parallel > 0, barrier(found.room / found.reach), 0.0)
        return float(self.force * (found.reach * found.parallel) @ height)

    def linearised(self, coords: FloatArray) -> tuple[FloatArray, list[Blocks]]:
        """Gradient of the energy, shape (nv, 3), and its curvature along the normals."""
        found = self.touching(coords)
        if not len(found.room):
            return np.zeros_like(coords), []
        share = found.room / found.reach
        along = found.weights[:, :, None] * found.normal[:, None, :]
        gradient = -found.pressure[:, None, None] * along
        height = (self.force * found.reach * barrier(share))[:, None]
        turn, other = height * found.by_first, height * found.by_second
        gradient += np.stack([-turn, turn, -other, other], axis=1)
        members = found.pairs.members
        total = scattered(members.ravel(), gradient.reshape(-1, 3), len(coords))
        stiff = self.force * found.parallel / found.reach * barrier_curvature(share)
        flat = along.reshape(-1, 12)
        matrices = stiff[:, None, None] * flat[:, :, None] * flat[:, None, :]
        return total, [Blocks(members, matrices)]

    def longest_step(self, coords: FloatArray, step: FloatArray) -> float:
        """The share of a step, 0 to 1, that leaves all parts a tenth of their room."""
        longest = float(np.sqrt(dot(step, step)).max(initial=0.0))
        parts = int(np.clip(np.ceil(longest / self.surface.side), 1, _MOST_PARTS))
        for number in range(parts):
            # long steps part by part: the boxes of all at once would meet too many others
            start = coords + number / parts * step
            pairs = self._near(start, start + step / parts)
            self.work.spend(len(pairs.members))
            share = free_share(self.surface, start, step / parts, pairs)
            if share < 1:
                return (number + share) / parts
        return 1.0

    def touching(self, coords: FloatArray) -> Touching:
        """The pairs within the reach of their barriers at coords, shape (nv, 3)."""
        last = self._seen.touching
        if last and last[0][0] is coords:
            return last[0][1]
        pairs = self._near(coords, coords)
        self.work.spend(len(pairs.members))
        found = self._among(coords, pairs)
        last[:] = [(coords, found)]
        return found

    @property
    def seen(self) -> dict[str, FloatArray]:
        """What `see_again` takes. The work depends on it, energies and steps do not."""
        (near,) = self._seen.near
        return {"low": near.low, "high": near.high, "margin": np.array(near.margin)}

    def see_again(
        self, coords: FloatArray, low: FloatArray, high: FloatArray, margin: FloatArray
    ) -> None:
        """Take up what was `seen` when coords, shape (nv, 3), had just been looked at."""
        near = near_pairs(self.surface, low, high, self.surface.gap + self.reach, 0.0)
        self._seen.near[:] = [replace(near, margin=float(margin))]
        self._seen.touching[:] = [(coords, self._among(coords, near.pairs))]

    def _among(self, coords: FloatArray, pairs: Pairs) -> Touching:
        """Those of some pairs that are within the reach of their barriers."""
        reach = np.minimum(self.reach, pairs.limit)
        close = pairs.meeting(self.surface.boxes(coords, coords), reach)
        return self._touching(coords, pairs.chosen(close), reach[close])

    def _touching(self, coords: FloatArray, pairs: Pairs, reach: FloatArray) -> Touching:
        if not len(reach):
            none = np.empty((0, 3))
            return Touching(pairs, np.empty((0, 4)), none, reach, reach, reach, reach, none, none)
        points = coords[pairs.members]
        weights = weights_of(points, pairs.faced)
        distance, normal = separations(points, weights)
        room = distance - pairs.gap
        close = np.flatnonzero(room < reach)
        if not len(close):
            return self._touching(coords, pairs.chosen(close), reach[close])
        pairs, points = pairs.chosen(close), points[close]
        room, reach = room[close], reach[close]
        parallel = _parallel(points, pairs.faced)
        pressure = -self.force * parallel[0] * barrier_slope(np.maximum(room / reach, _TINY))
        return Touching(pairs, weights[close], normal[close], room, reach, pressure, *parallel)

    def _near(self, start: FloatArray, end: FloatArray) -> Pairs:
        seen = self._seen.near
        span = float(np.abs(end - start).mean())
        if seen and seen[0].covers(start) and seen[0].covers(end):
            few = len(seen[0].pairs.members) < _FEW * len(start)
            if few or seen[0].span < _LOOSE * (span + self.reach):
                return seen[0].pairs
        most = _SIDES * self.surface.side
        margin = most
        if seen:  # many layers on each other meet fewer others in smaller boxes
            many = len(seen[0].pairs.members) > _FEW * len(start)
            margin = seen[0].margin / 4 if many else min(2 * seen[0].margin, most)
        wider = self.reach + _MARGIN * np.abs(end - start)
        low, high = np.minimum(start, end) - wider, np.maximum(start, end) + wider
        reach = self.surface.gap + self.reach
        seen[:] = [near_pairs(self.surface, low, high, reach, margin)]
        return seen[0].pairs


def _parallel(points: FloatArray, faced: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The factor of edges that are nearly parallel, shape (n,), and its gradients, (n, 3) each."""
    factor = np.ones(len(points))
    by_first, by_second = np.zeros((2, len(points), 3))
    u, v = points[faced:, 1] - points[faced:, 0], points[faced:, 3] - points[faced:, 2]
    area = cross(u, v)
    lengths = dot(u, u) * dot(v, v)
    sine = dot(area, area) / lengths / _NEARLY_PARALLEL
    near = np.flatnonzero(sine < 1)
    u, v, area, lengths, sine = u[near], v[near], area[near], lengths[near], sine[near]
    rows = faced + near
    factor[rows] = sine * (2 - sine)
    slope = (2 * (2 - 2 * sine) / lengths / _NEARLY_PARALLEL)[:, None]
    shrink = ((2 - 2 * sine) * 2 * sine)[:, None]
    by_first[rows] = slope * cross(v, area) - shrink * u / dot(u, u)[:, None]
    by_second[rows] = slope * cross(area, u) - shrink * v / dot(v, v)[:, None]
    return factor, by_first, by_second
