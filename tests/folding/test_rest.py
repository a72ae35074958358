"""Rest under potentials: forces in balance, fixed vertices, walls that no step passes."""

from dataclasses import dataclass

import numpy as np
import pytest
from flat_patterns import grid

from fab.folding.bar_hinge_model import framework
from fab.folding.fold_settings import Stiffness
from fab.folding.quasi_static import fold
from fab.folding.rest import relaxed
from solver.assembly import Blocks


@dataclass(frozen=True)
class Pull:
    """The same force on every vertex; `lift` is added to the energy, and changes nothing else."""

    force: np.ndarray
    lift: float = 0.0

    def energy(self, coords):
        return self.lift - float((coords @ self.force).sum())

    def linearised(self, coords):
        return np.tile(-self.force, (len(coords), 1)), []

    def longest_step(self, coords, step):
        return 1.0


@dataclass(frozen=True)
class Spring:
    """A spring of no length between two vertices, however far apart they are in the sheet."""

    ends: tuple[int, int]
    stiffness: float

    def energy(self, coords):
        between = coords[self.ends[1]] - coords[self.ends[0]]
        return self.stiffness / 2 * float(between @ between)

    def linearised(self, coords):
        gradient = np.zeros_like(coords)
        pull = self.stiffness * (coords[self.ends[1]] - coords[self.ends[0]])
        gradient[self.ends[1]] += pull
        gradient[self.ends[0]] -= pull
        sides = np.array([[1.0, -1.0], [-1.0, 1.0]])
        block = self.stiffness * np.kron(sides, np.eye(3))
        return gradient, [Blocks(np.array([self.ends]), block[None])]

    def longest_step(self, coords, step):
        return 1.0


class Floor:
    """A floor below the sheet, with a barrier that rises without end towards it."""

    def __init__(self, height, stiffness):
        self.height, self.stiffness, self.seen = height, stiffness, []

    def energy(self, coords):
        above = coords[:, 2] - self.height
        self.seen.append(above.min())
        return float(-self.stiffness * np.log(above).sum()) if above.min() > 0 else np.inf

    def linearised(self, coords):
        above = coords[:, 2] - self.height
        gradient = np.zeros_like(coords)
        gradient[:, 2] = -self.stiffness / above
        block = np.zeros((len(coords), 3, 3))
        block[:, 2, 2] = self.stiffness / above**2
        return gradient, [Blocks(np.arange(len(coords))[:, None], block)]

    def longest_step(self, coords, step):
        above, down = coords[:, 2] - self.height, -step[:, 2]
        reached = np.min(above[down > 0] / down[down > 0], initial=np.inf)
        return float(min(1.0, 0.9 * reached))


def strip(**stiffness):
    """Five squares in a row, clamped by the corners of the first one."""
    frame = framework(grid(5, 1, 10.0), Stiffness(**stiffness))
    fixed = frame.vertices_coords[:, 0] <= 10.0 / frame.size_mm + 1e-9
    assert fixed.sum() == 4
    return frame, fixed


def test_fixed_vertices_bear_what_pulls_at_the_others():
    frame, fixed = strip()
    pull = Pull(np.array([0.0, 0.0, -1e-3]))
    still = np.zeros_like(frame.hinges_target)
    rest = relaxed(frame, frame.vertices_coords, still, True, [pull], fixed=fixed)
    assert rest.settled
    assert np.all(np.diff(rest.accepted) < 0)
    assert (rest.coords[fixed] == frame.vertices_coords[fixed]).all()
    inner, _ = frame.linearised(rest.coords, still)
    assert inner[~fixed] == pytest.approx(np.tile(pull.force, (int((~fixed).sum()), 1)), abs=1e-10)
    assert inner[fixed].sum(axis=0) == pytest.approx(-pull.force * (~fixed).sum(), abs=1e-10)
    assert rest.coords[~fixed, 2].max() < -1e-4


def test_where_energies_begin_changes_nothing():
    """Also where they are negative, or zero at first; the share that settles is of their sizes."""
    frame, fixed = strip()
    still = np.zeros_like(frame.hinges_target)
    ends = [
        relaxed(
            frame,
            frame.vertices_coords,
            still,
            True,
            [Pull(np.array([0.0, 1e-4, -1e-3]), lift)],
            fixed=fixed,
        )
        for lift in (0.0, -1.0, 1.0)
    ]
    for end in ends:
        assert end.settled
        assert end.coords == pytest.approx(ends[0].coords, abs=1e-7)


def test_potentials_may_join_vertices_that_are_far_apart():
    frame, fixed = strip(crease=0.01, facet=0.01)
    still = np.zeros_like(frame.hinges_target)
    far = int(np.argmax(frame.vertices_coords[:, 0]))
    near = int(np.flatnonzero(fixed)[0])
    assert not frame.assembly.covers(np.array([[near, far]]))
    spring, lift = Spring((near, far), 0.05), Pull(np.array([0.0, 0.0, 1e-5]))
    rest = relaxed(frame, frame.vertices_coords, still, True, [spring, lift], fixed=fixed)
    assert rest.settled
    slope = frame.linearised(rest.coords, still)[0] + spring.linearised(rest.coords)[0]
    assert (slope - lift.force)[~fixed] == pytest.approx(0.0, abs=1e-9)
    assert np.linalg.norm(rest.coords[far] - rest.coords[near]) < 0.9


def test_no_step_passes_a_wall_and_the_energy_never_rises():
    frame, fixed = strip(crease=0.05, facet=0.05)
    floor, pull = Floor(-0.2, 1e-6), Pull(np.array([0.0, 0.0, -5e-3]))
    folding = fold(frame, 2, potentials=[floor, pull], fixed=fixed)
    flat, *_, last = folding.states
    assert (last.coords[fixed] == flat.coords[fixed]).all()
    assert last.settled
    assert min(floor.seen) > 0
    assert last.coords[:, 2].min() < -0.15
    for state in folding.states[1:]:
        assert np.all(np.diff(state.accepted) < 0)
        assert state.accepted[-1] == pytest.approx(state.energy.total, rel=1e-9)


def test_a_sheet_that_nothing_pulls_folds_as_it_does_alone():
    """A potential that never acts changes no energy by more than rounding.

    Where the energy is least but for rounding, coordinates are known to the root of that.
    """
    frame = framework(grid(3, 3, 10.0))
    alone = fold(frame, 3)
    beside = fold(frame, 3, potentials=[Pull(np.zeros(3))])
    known = np.sqrt(np.finfo(float).eps)
    for one, other in zip(alone.states, beside.states, strict=True):
        assert other.coords == pytest.approx(one.coords, abs=known)
        assert other.energy.total == pytest.approx(one.energy.total, rel=1e-12)
