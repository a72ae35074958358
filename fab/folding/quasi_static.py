"""How does a flat sheet get to its target fold angles, and at what cost on the way?

Quasi-static: the target angles are ramped, and at each load the framework comes to rest. Each step
is predicted by turning all hinges (`fab.rotations`), so that long chains may turn far at once, and
corrected by damped Gauss-Newton steps (Levenberg-Marquardt), none of which raises the energy.
Angles that close store none at the full load, so that the last steps converge quadratically.
All hinges are driven alike, or along a way on which each has a rate of its own (`fab.way`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csc_array
from scipy.sparse.linalg import SuperLU, splu

from fab.folding.bar_hinge_model import Energy, Framework
from fab.folding.rotation_predictor import Turner, turner
from solver.errors import require_count
from solver.vectors import FloatArray

__all__ = [
    "FoldState",
    "Folding",
    "Progress",
    "aligned",
    "along",
    "damped",
    "flat_state",
    "fold",
    "largest_turns",
    "silent",
    "state_of",
]

# Damping, over the mean of the diagonal: as little as rounding allows, more where a step fails.
_LEAST_DAMPING, _MOST_DAMPING = 1e-13, 1e3
_FIRST_DAMPING = 1e-8
# Steps at each load, and at the full one.
_MOST, _MOST_AT_LAST = 150, 400
# Steps with more damping than this say nothing about how far the energy could still fall.
_TRUSTED_DAMPING = 1e-6
# On the way: the next step would lower the energy by less than this share.
_SETTLED = 1e-6
# Over the diagonal of the sheet: smaller steps are rounding.
_ROUNDING = 1e-12
# Over the sum of all stiffness: what coordinates that are off by a few roundings store.
_ROUNDING_ENERGY = (8 * np.finfo(float).eps) ** 2
# Hinges turn by no more from load to load.
_FARTHEST_RAD = np.radians(20.0)
# A step that raises the energy is tried shorter before it is damped.
_LENGTHS = (1.0, 0.5, 0.25, 0.125)

Progress = Callable[[int, int], None]


@dataclass(frozen=True)
class FoldState:
    """The sheet at rest under one load.

    Attributes
    ----------
    load : share of the target angles, 0 to 1.
    coords : shape (nv, 3), vertices of the framework over its size.
    energy : of bars and hinges; strain_mean, strain_max : sizes over all bars.
    strain_peak : the largest of the latter, here and at the loads since the state before.
    accepted : energy of the prediction, and after each step that was taken from there to rest.
    iterations : linear systems solved since the state before, or Euler steps.
    settled : whether it came to rest, here and at the loads since the state before.
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

    in_turn : whether the hinges were driven along a way of their own (`fab.way`), not all at once.
    """

    frame: Framework
    states: tuple[FoldState, ...]
    in_turn: bool = False

    @property
    def iterations(self) -> int:
        """Linear systems solved."""
        return sum(state.iterations for state in self.states)


def silent(done: int, total: int) -> None:
    """Progress that nobody watches."""
    del done, total


def fold(
    frame: Framework,
    steps: int = 10,
    progress: Progress = silent,
    way: FloatArray | None = None,
) -> Folding:
    """Fold a framework from flat to its targets, with as many states, evenly over the load.

    Where that would turn hinges by more than 20 degrees at once, there are loads in between: a
    prediction that turns far would find the target without a way there.

    way : shape (n, nh), radians, hinge angles to which the hinges are driven one after another,
        from 0 to the targets; straight where none is given. Loads are even over it as the hinge
        goes that turns the most.
    progress : called with (loads done, loads in all); an exception that it raises ends the fold.
    """
    require_count("steps", steps, 1, "Follow the fold in one step or more.")
    turning = turner(frame)
    in_turn = way is not None
    if way is None:
        way = np.stack([np.zeros_like(frame.hinges_target), frame.hinges_target])
    most = float(largest_turns(way).sum())
    between = max(1, int(np.ceil(most / (_FARTHEST_RAD * steps))))
    loads = between * steps
    state = flat_state(frame)
    states = [state]
    angles = np.zeros_like(frame.hinges_target)
    solved, rested, peak = 0, True, 0.0
    for number in range(1, loads + 1):
        progress(number - 1, loads)
        target, rate = along(way, number / loads)
        coords = _predicted(frame, turning, state.coords, angles + rate / loads, target)
        coords, accepted, iterations, settled = _rest(frame, coords, target, number == loads)
        coords = aligned(coords, state.coords)
        solved, rested = solved + iterations, rested and settled
        state = state_of(frame, number / loads, coords, target, solved, rested, accepted)
        peak = max(peak, state.strain_max)
        if number % between == 0:
            states.append(replace(state, strain_peak=peak))
            solved, rested, peak = 0, True, 0.0
        angles = frame.angles_near(coords, target)
    progress(loads, loads)
    return Folding(frame, tuple(states), in_turn)


def along(way: FloatArray, share: float) -> tuple[FloatArray, FloatArray]:
    """Angles at a share of a way, over 0 to 1, and how fast they change there, shapes (nh,).

    way : shape (n, nh), measured by how far the hinge goes that turns the most.
    """
    turned = largest_turns(way).cumsum()
    if turned[-1] == 0:
        return way[-1], np.zeros_like(way[-1])
    ends = turned / turned[-1]
    number = int(np.searchsorted(ends, share))
    begin = ends[number - 1] if number else 0.0
    rate = (way[number + 1] - way[number]) / (ends[number] - begin)
    return way[-1] if share == 1 else way[number] + (share - begin) * rate, rate


def largest_turns(way: FloatArray) -> FloatArray:
    """How far the hinge goes that turns the most, from each station to the next, shape (n - 1,)."""
    return np.asarray(np.abs(np.diff(way, axis=0)).max(axis=1, initial=0.0))


def _predicted(
    frame: Framework,
    turning: Turner,
    coords: FloatArray,
    angles: FloatArray,
    target: FloatArray,
) -> FloatArray:
    """The sheet with all hinges turned to `angles`, or as it was where that stores less energy."""
    turned = turning.coords(angles)
    if frame.energy(turned, target).total < frame.energy(coords, target).total:
        return turned
    return coords


def _rest(
    frame: Framework, coords: FloatArray, target: FloatArray, last: bool
) -> tuple[FloatArray, tuple[float, ...], int, bool]:
    """Coordinates of least energy near to `coords`; energies on the way; steps; whether settled."""
    most = _MOST_AT_LAST if last else _MOST
    energy = frame.energy(coords, target).total
    accepted = [energy]
    damping = _FIRST_DAMPING
    for solved in range(1, most + 1):
        gradient, matrix = frame.linearised(coords, target)
        if energy <= _ROUNDING_ENERGY * matrix.diagonal().sum():
            return coords, tuple(accepted), solved - 1, True
        step = damped(matrix, damping).solve(-gradient.ravel()).reshape(-1, 3)
        for length in _LENGTHS:
            lower = frame.energy(coords + length * step, target).total
            if lower < energy:
                break
        else:
            if np.abs(step).max() < _ROUNDING or damping > _MOST_DAMPING:
                return coords, tuple(accepted), solved, True
            damping = max(100 * damping, 1e-10)
            continue
        coords, share, energy = coords + length * step, 1 - lower / energy, lower
        accepted.append(energy)
        if np.abs(step).max() < _ROUNDING or (
            not last and damping < _TRUSTED_DAMPING and share < _SETTLED
        ):
            return coords, tuple(accepted), solved, True
        damping = max(damping / 10, _LEAST_DAMPING) if length == 1 else 10 * damping
    return coords, tuple(accepted), most, False


def damped(matrix: csc_array, damping: float) -> SuperLU:
    """Factors of a matrix with `damping` times the mean of its diagonal added to the latter."""
    matrix = matrix.copy()
    diagonal = matrix.diagonal()
    matrix.setdiag(diagonal + damping * diagonal.mean())
    return splu(
        matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
    )


def flat_state(frame: Framework) -> FoldState:
    """The flat sheet, without load."""
    return state_of(frame, 0.0, frame.vertices_coords, np.zeros_like(frame.hinges_target), 0, True)


def state_of(
    frame: Framework,
    load: float,
    coords: FloatArray,
    target: FloatArray,
    iterations: int,
    settled: bool,
    accepted: tuple[float, ...] = (),
) -> FoldState:
    """A state with its energy and strains."""
    strain = np.abs(frame.strains(coords))
    return FoldState(
        load,
        coords,
        frame.energy(coords, target),
        float(strain.mean()),
        float(strain.max()),
        float(strain.max()),
        accepted,
        iterations,
        settled,
    )


def aligned(coords: FloatArray, onto: FloatArray) -> FloatArray:
    """Moved rigidly, to lie as near as possible to the state before."""
    middle, place = coords.mean(axis=0), onto.mean(axis=0)
    left, _, right = np.linalg.svd((coords - middle).T @ (onto - place))
    sign = np.sign(np.linalg.det(left @ right))
    turn = left @ np.diag([1.0, 1.0, sign]) @ right
    return np.asarray((coords - middle) @ turn + place)
