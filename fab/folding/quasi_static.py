"""Quasi-static folding of a flat sheet to its target fold angles.

The target angles are ramped, and at each load the framework comes to rest. Each step is predicted
by turning all hinges (`fab.folding.rotation_predictor`), so that long chains may turn far at once,
and corrected by damped Gauss-Newton steps (Levenberg-Marquardt), none of which raises the energy.
Angles that close store no energy at the full load, so that the last steps converge quadratically.
All hinges are driven at one rate, or along a folding path on which each has a rate of its own
(`fab.folding.folding_path`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csc_array
from scipy.sparse.linalg import SuperLU, splu

from fab.folding.bar_hinge_model import Energy, Framework
from fab.folding.rotation_predictor import RotationPredictor, rotation_predictor
from fab.progress import Steps, no_steps
from solver.errors import require_count
from solver.vectors import FloatArray

__all__ = [
    "FoldState",
    "Folding",
    "Rest",
    "aligned",
    "damped",
    "flat_state",
    "fold",
    "largest_turns",
    "path_at",
    "relaxed",
    "state_of",
]

# Damping, relative to the mean of the diagonal: as little as rounding allows, more where a step
# fails.
_LEAST_DAMPING, _MOST_DAMPING = 1e-13, 1e3
_FIRST_DAMPING = 1e-8
# Most steps at each load, and at the full one.
_MOST, _MOST_AT_LAST = 150, 400
# Steps with more damping than this say nothing about how far the energy could still fall.
_TRUSTED_DAMPING = 1e-6
# Below the full load, the sheet is at rest where a step lowers the energy by less than this share.
_SETTLED = 1e-6
# Smaller steps, relative to the size of the sheet, are rounding.
_ROUNDING = 1e-12
# Energy of coordinates that are off by a few roundings, relative to the sum of all stiffness.
_ROUNDING_ENERGY = (8 * np.finfo(float).eps) ** 2
# Hinges turn by no more from load to load.
_FARTHEST_RAD = np.radians(20.0)
# A step that raises the energy is tried shorter before it is damped.
_LENGTHS = (1.0, 0.5, 0.25, 0.125)


@dataclass(frozen=True)
class FoldState:
    """The sheet at rest under one load.

    Attributes
    ----------
    load : share of the target angles, 0 to 1.
    coords : shape (nv, 3), vertices of the framework, relative to its size.
    energy : of bars and hinges.
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

    in_turn : whether the hinges were driven along a folding path (`fab.folding.folding_path`), not
        all at one rate.
    """

    frame: Framework
    states: tuple[FoldState, ...]
    in_turn: bool = False

    @property
    def iterations(self) -> int:
        """Linear systems solved in all, or Euler steps."""
        return sum(state.iterations for state in self.states)


def fold(
    frame: Framework,
    steps: int = 10,
    progress: Steps = no_steps,
    path: FloatArray | None = None,
) -> Folding:
    """Fold a framework from flat to its targets: the flat state and `steps` more, evenly over load.

    Where a step would turn hinges by more than 20 degrees, it is divided into several loads: a
    prediction that turns farther could jump to the target of a sheet that cannot fold to it.

    Parameters
    ----------
    path : shape (n, nh), radians, stations from 0 to the targets through which the hinge angles are
        driven; the straight line where left out. Loads are even over the length of the path
        (`largest_turns`).
    progress : called with (loads done, loads in all); an exception that it raises ends the fold.

    Raises `InvalidValue` for less than one step.
    """
    require_count("steps", steps, 1, "Follow the fold in one step or more.")
    predictor = rotation_predictor(frame)
    in_turn = path is not None
    if path is None:
        path = np.stack([np.zeros_like(frame.hinges_target), frame.hinges_target])
    length = float(largest_turns(path).sum())
    per_step = max(1, int(np.ceil(length / (_FARTHEST_RAD * steps))))
    loads = per_step * steps
    state = flat_state(frame)
    states = [state]
    angles = np.zeros_like(frame.hinges_target)
    solved, rested, peak = 0, True, 0.0
    for number in range(1, loads + 1):
        progress(number - 1, loads)
        target, rate = path_at(path, number / loads)
        coords = _predicted(frame, predictor, state.coords, angles + rate / loads, target)
        rest = relaxed(frame, coords, target, number == loads)
        coords = aligned(rest.coords, state.coords)
        solved, rested = solved + rest.iterations, rested and rest.settled
        state = state_of(frame, number / loads, coords, target, solved, rested, rest.accepted)
        peak = max(peak, state.strain_max)
        if number % per_step == 0:
            states.append(replace(state, strain_peak=peak))
            solved, rested, peak = 0, True, 0.0
        angles = frame.angles_near(coords, target)
    progress(loads, loads)
    return Folding(frame, tuple(states), in_turn)


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


def _predicted(
    frame: Framework,
    predictor: RotationPredictor,
    coords: FloatArray,
    angles: FloatArray,
    target: FloatArray,
) -> FloatArray:
    """The sheet with all hinges turned to `angles`, or as it was where that stores less energy."""
    turned = predictor.coords(angles)
    if frame.energy(turned, target).total < frame.energy(coords, target).total:
        return turned
    return coords


@dataclass(frozen=True)
class Rest:
    """Where the sheet came to rest: see `FoldState` for the fields."""

    coords: FloatArray
    accepted: tuple[float, ...]
    iterations: int
    settled: bool


def relaxed(frame: Framework, coords: FloatArray, target: FloatArray, last: bool) -> Rest:
    """The local minimum of energy near to `coords`; last : whether the load is the full one."""
    most = _MOST_AT_LAST if last else _MOST
    energy = frame.energy(coords, target).total
    accepted = [energy]
    damping = _FIRST_DAMPING
    for solved in range(1, most + 1):
        gradient, matrix = frame.linearised(coords, target)
        if energy <= _ROUNDING_ENERGY * matrix.diagonal().sum():
            return Rest(coords, tuple(accepted), solved - 1, True)
        step = damped(matrix, damping).solve(-gradient.ravel()).reshape(-1, 3)
        for length in _LENGTHS:
            lower = frame.energy(coords + length * step, target).total
            if lower < energy:
                break
        else:
            if np.abs(step).max() < _ROUNDING or damping > _MOST_DAMPING:
                return Rest(coords, tuple(accepted), solved, True)
            damping = max(100 * damping, 1e-10)
            continue
        coords, share, energy = coords + length * step, 1 - lower / energy, lower
        accepted.append(energy)
        if np.abs(step).max() < _ROUNDING or (
            not last and damping < _TRUSTED_DAMPING and share < _SETTLED
        ):
            return Rest(coords, tuple(accepted), solved, True)
        damping = max(damping / 10, _LEAST_DAMPING) if length == 1 else 10 * damping
    return Rest(coords, tuple(accepted), most, False)


def damped(matrix: csc_array, damping: float) -> SuperLU:
    """Factors of a symmetric matrix, `damping` times its mean diagonal entry added to each."""
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
    """The state at `coords`, shape (nv, 3), with its energy and strains.

    target : shape (nh,), radians, of this load.
    """
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
    """Points moved rigidly, without mirroring, to least square distance from others (Kabsch 1976).

    Both have shape (n, 3).

    >>> square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    >>> upright = square[:, [2, 0, 1]] + [5.0, 0.0, 0.0]
    >>> bool(np.allclose(aligned(upright, square), square))
    True
    """
    middle, goal = coords.mean(axis=0), onto.mean(axis=0)
    left, _, right = np.linalg.svd((coords - middle).T @ (onto - goal))
    sign = np.sign(np.linalg.det(left @ right))
    turn = left @ np.diag([1.0, 1.0, sign]) @ right
    return np.asarray((coords - middle) @ turn + goal)
