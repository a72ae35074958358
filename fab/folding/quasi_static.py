"""Quasi-static folding of a flat sheet to its target fold angles.

The target angles are ramped, and at each load the framework comes to rest (`fab.folding.rest`).
Each load is predicted by turning all hinges (`fab.folding.rotation_predictor`), so that long chains
may turn far at once, and corrected by damped Gauss-Newton steps, none of which raises the energy.
Angles that close store no energy at the full load, so that the last steps converge quadratically.
All hinges are driven at one rate, or along a folding path on which each has a rate of its own
(`fab.folding.folding_path`). Potentials, such as weight, act besides (`fab.folding.potentials`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Protocol

import numpy as np

from fab.folding.bar_hinge_model import Energy, Framework
from fab.folding.contact.stops import Stop
from fab.folding.newton_system import NewtonSystem
from fab.folding.potentials import Potential, energy_of, free_share
from fab.folding.rest import relaxed
from fab.folding.rotation_predictor import rotation_predictor
from fab.progress import Steps, no_steps
from solver.errors import require_count
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = [
    "Checkpoint",
    "FoldState",
    "Folding",
    "Reached",
    "aligned",
    "flat_state",
    "fold",
    "largest_turns",
    "loads_per_step",
    "path_at",
    "state_of",
    "straight_path",
]

# Hinges turn by no more from load to load.
_FARTHEST_RAD = np.radians(20.0)
# Systems that a load takes at first guess.
_USUAL = 3.0
# A predicted sheet is brought to its fixed vertices; the others decide where these leave it free.
_LOOSE = 1e-6


@dataclass(frozen=True)
class FoldState:
    """The sheet at rest under one load.

    Attributes
    ----------
    load : share of the target angles, 0 to 1.
    coords : shape (nv, 3), vertices of the framework, relative to its size.
    energy : of bars and hinges, and of potentials.
    strain_mean, strain_max : mean and largest absolute strain of the bars.
    strain_peak : the largest `strain_max` at this load and those since the state before.
    accepted : energy of the prediction, and after each step that was taken from it.
    iterations : linear systems solved since the state before, or Euler steps.
    settled : whether the sheet came to rest at this load and all those since the state before.
    """

    load: float
    coords: FloatArray
    energy: Energy
    strain_mean: float
    strain_max: float
    strain_peak: float
    accepted: tuple[float, ...]
    iterations: int
    settled: bool


@dataclass(frozen=True)
class Folding:
    """A fold from flat: its states, the flat one first.

    Attributes
    ----------
    in_turn : whether the hinges were driven along a folding path (`fab.folding.folding_path`), not
        all at one rate.
    stopped : where contact keeps the sheet from its target; None where it does not, or was not
        looked at.
    layers_rel : how far layers that touch at the end are apart, relative to the framework's size; 0
        without contact.
    """

    frame: Framework
    states: tuple[FoldState, ...]
    in_turn: bool = False
    stopped: Stop | None = None
    layers_rel: float = 0.0

    @property
    def iterations(self) -> int:
        """Linear systems solved in all, or Euler steps."""
        return sum(state.iterations for state in self.states)


@dataclass(frozen=True)
class Reached:
    """How far a fold has come: all that the loads after it depend on.

    Attributes
    ----------
    number : loads done. states : of the fold, so far. state : under the last load.
    solved, rested, peak : systems, whether all loads came to rest, and largest strain, since the
        last of `states`.
    over : whether there are no loads after it.
    carried : arrays by name: what else the loads after it depend on.
    """

    number: int
    states: tuple[FoldState, ...]
    state: FoldState
    solved: int = 0
    rested: bool = True
    peak: float = 0.0
    over: bool = False
    carried: Mapping[str, FloatArray | IntArray] = field(default_factory=dict)

    @classmethod
    def flat(cls, state: FoldState, **carried: FloatArray | IntArray) -> Reached:
        """The flat sheet, before the first load."""
        return cls(0, (state,), state, carried=carried)

    def after(
        self, state: FoldState, ends: bool, over: bool, **carried: FloatArray | IntArray
    ) -> Reached:
        """One load later, at which the sheet is in this state; ends : whether a step does."""
        solved, rested = self.solved + state.iterations, self.rested and state.settled
        peak = max(self.peak, state.strain_max)
        states = self.states
        if ends:
            whole = replace(state, strain_peak=peak, iterations=solved, settled=rested)
            states, solved, rested, peak = (*states, whole), 0, True, 0.0
        return Reached(self.number + 1, states, state, solved, rested, peak, over, carried)


class Checkpoint(Protocol):
    """What keeps a fold."""

    def begin(
        self,
        frame: Framework,
        path: FloatArray,
        loads: int,
        per_step: int,
        others: Sequence[FloatArray | IntArray] = (),
    ) -> Reached | None:
        """How far this fold came when it was cut short; None where it begins.

        path : as of `fold`, in so many loads, of which each `per_step` are a step. others : what
        else its states depend on.
        """

    def keep(self, reached: Reached) -> None:
        """Keep how far the fold has come."""


def fold(
    frame: Framework,
    steps: int = 10,
    progress: Steps = no_steps,
    path: FloatArray | None = None,
    potentials: Sequence[Potential] = (),
    *,
    fixed: BoolArray | None = None,
    checkpoint: Checkpoint | None = None,
) -> Folding:
    """Fold a framework from flat to its targets: the flat state and `steps` more, evenly over load.

    Where a step would turn hinges by more than 20 degrees, it is divided into several loads: a
    prediction that turns farther could jump to the target of a sheet that cannot fold to it.

    Parameters
    ----------
    path : shape (n, nh), radians, stations from 0 to the targets through which the hinge angles are
        driven; the straight line where left out. Loads are even over the length of the path
        (`largest_turns`).
    progress : called with (loads done, loads in all), also on the way to each load, of which a part
        is then done; an exception that it raises ends the fold.
    potentials : what acts on the sheet at every load, besides its bars and hinges.
    fixed : vertices that stay where they are in the flat sheet, shape (nv,); none where left out.
    checkpoint : what keeps the fold after each load, and from which it goes on where it was cut
        short (`fab.folding.checkpoints`); of folds without potentials and fixed vertices.

    Raises `InvalidValue` for less than one step.
    """
    require_count("steps", steps, 1, "Follow the fold in one step or more.")
    predictor, system = rotation_predictor(frame), NewtonSystem(frame, fixed)
    held = fixed if fixed is not None and fixed.any() else None
    in_turn = path is not None
    path = straight_path(frame) if path is None else path
    per_step = loads_per_step(path, steps)
    loads = per_step * steps
    keeper = None if potentials or held is not None else checkpoint
    reached = keeper.begin(frame, path, loads, per_step) if keeper else None
    if reached is None:
        still = np.zeros_like(frame.hinges_target)
        reached = Reached.flat(flat_state(frame, potentials), angles=still)
    usual = _USUAL
    while not reached.over:
        number, before = reached.number + 1, reached.state.coords
        target, rate = path_at(path, number / loads)
        turned = predictor.coords(reached.carried["angles"] + rate / loads)
        rest = relaxed(
            frame,
            _predicted(frame, turned, before, target, potentials, held),
            target,
            number == loads,
            potentials,
            system=system,
            watch=partial(_report, progress, number, loads, usual),
        )
        usual += (rest.iterations - usual) / number
        coords = rest.coords if held is not None else aligned(rest.coords, before)
        reached = reached.after(
            state_of(
                frame,
                number / loads,
                coords,
                target,
                rest.iterations,
                rest.settled,
                rest.accepted,
                potentials,
            ),
            ends=number % per_step == 0,
            over=number == loads,
            angles=frame.angles_near(coords, target),
        )
        if keeper:
            keeper.keep(reached)
    progress(loads, loads)
    return Folding(frame, reached.states, in_turn)


def straight_path(frame: Framework) -> FloatArray:
    """The path on which all hinges turn at one rate, shape (2, nh), radians."""
    return np.stack([np.zeros_like(frame.hinges_target), frame.hinges_target])


def loads_per_step(path: FloatArray, steps: int) -> int:
    """How many loads each of the steps along a path has, so that no hinge turns too far at once.

    >>> loads_per_step(np.radians([[0.0, 0.0], [90.0, -180.0]]), 3)  # 60 degrees, 20 at a time
    3
    """
    length = float(largest_turns(path).sum())
    return max(1, int(np.ceil(length / (_FARTHEST_RAD * steps))))


def path_at(path: FloatArray, share: float) -> tuple[FloatArray, FloatArray]:
    """Hinge angles at a share, 0 to 1, of a path's length, and their rate of change per share.

    path : shape (n, nh), radians; its length is that of `largest_turns`. Both results have shape
    (nh,).

    >>> angles, rate = path_at(np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 3.0]]), 0.5)
    >>> angles.tolist(), rate.tolist()
    ([1.0, 1.0], [0.0, 4.0])
    """
    turned = largest_turns(path).cumsum()
    if turned[-1] == 0:
        return path[-1], np.zeros_like(path[-1])
    ends = turned / turned[-1]
    number = int(np.searchsorted(ends, share))
    begin = ends[number - 1] if number else 0.0
    rate = (path[number + 1] - path[number]) / (ends[number] - begin)
    return path[-1] if share == 1 else path[number] + (share - begin) * rate, rate


def largest_turns(path: FloatArray) -> FloatArray:
    """The largest turn of any hinge from each station of a path to the next, shape (n - 1,)."""
    return np.asarray(np.abs(np.diff(path, axis=0)).max(axis=1, initial=0.0))


def _report(progress: Steps, number: int, loads: int, usual: float, solved: int) -> None:
    """Report how far a load has come, which takes about as many systems as those before it."""
    progress(number - 1 + solved / max(usual, solved + 1), loads)


def _predicted(
    frame: Framework,
    turned: FloatArray,
    coords: FloatArray,
    target: FloatArray,
    potentials: Sequence[Potential],
    fixed: BoolArray | None,
) -> FloatArray:
    """The sheet with all hinges turned, or as it was where that stores less energy.

    Or where a potential does not let it get there. fixed : vertices that stay, if there are any.
    """
    if fixed is not None:
        turned = aligned(turned, coords, np.where(fixed, 1.0, _LOOSE))
        turned[fixed] = coords[fixed]
    elif potentials:
        turned = aligned(turned, coords)
    before = energy_of(frame, coords, target, potentials).total
    if not energy_of(frame, turned, target, potentials).total < before:
        return coords
    return turned if free_share(potentials, coords, turned - coords) >= 1 else coords


def flat_state(frame: Framework, potentials: Sequence[Potential] = ()) -> FoldState:
    """The flat sheet, without load."""
    coords, still = frame.vertices_coords, np.zeros_like(frame.hinges_target)
    return state_of(frame, 0.0, coords, still, 0, True, potentials=potentials)


def state_of(
    frame: Framework,
    load: float,
    coords: FloatArray,
    target: FloatArray,
    iterations: int,
    settled: bool,
    accepted: tuple[float, ...] = (),
    potentials: Sequence[Potential] = (),
) -> FoldState:
    """The state at `coords`, shape (nv, 3), with its energy and strains.

    target : shape (nh,), radians, of this load.
    """
    strain = np.abs(frame.strains(coords))
    return FoldState(
        load,
        coords,
        energy_of(frame, coords, target, potentials),
        float(strain.mean()),
        float(strain.max()),
        float(strain.max()),
        accepted,
        iterations,
        settled,
    )


def aligned(coords: FloatArray, onto: FloatArray, weights: FloatArray | None = None) -> FloatArray:
    """Points moved rigidly, without mirroring, to least square distance from others (Kabsch 1976).

    Both have shape (n, 3). weights : of the squares, shape (n,); all 1 where left out.

    >>> square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    >>> upright = square[:, [2, 0, 1]] + [5.0, 0.0, 0.0]
    >>> bool(np.allclose(aligned(upright, square), square))
    True
    """
    middle, goal = (np.average(x, axis=0, weights=weights) for x in (coords, onto))
    pull = onto - goal if weights is None else weights[:, None] * (onto - goal)
    left, _, right = np.linalg.svd((coords - middle).T @ pull)
    sign = np.sign(np.linalg.det(left @ right))
    turn = left @ np.diag([1.0, 1.0, sign]) @ right
    return np.asarray((coords - middle) @ turn + goal)
