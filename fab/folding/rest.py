"""How a sheet comes to rest: damped Gauss-Newton steps, none of which raises the energy.

The energy is that of bars and hinges, whose sum of squares ends at or near zero, and of any number
of potentials. Each step is damped (Levenberg-Marquardt) as little as rounding allows, and more
where it fails; potentials may shorten it. Whether the sheet rests is judged by the step and by what
it gains, relative to the sum of all absolute energies, so that these may be negative.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fab.folding.bar_hinge_model import Energy, Framework
from fab.folding.newton_system import Linearised, NewtonSystem
from fab.folding.potentials import Potential, energy_of, free_share
from fab.progress import Steps
from solver.vectors import BoolArray, FloatArray

__all__ = ["Rest", "relaxed", "unwatched", "watched"]

# Damping, relative to the mean of the diagonal: as little as rounding allows, more where a step
# fails.
_LEAST_DAMPING, _MOST_DAMPING = 1e-13, 1e3
_FIRST_DAMPING = 1e-8
# Most steps at each load, and at the full one.
_MOST, _MOST_AT_LAST = 150, 400
# Steps with more damping than this say nothing about how far the energy could still fall.
_TRUSTED_DAMPING = 1e-6
# Below the full load, the sheet is at rest where a step lowers the energy by less than this share,
# unless another one is given.
_SETTLED = 1e-6
# Smaller steps, relative to the size of the sheet, are rounding.
_ROUNDING = 1e-12
# Energy of coordinates that are off by a few roundings, relative to the sum of all stiffness.
_ROUNDING_ENERGY = (8 * np.finfo(float).eps) ** 2
# A step that can gain no more than this share of the energies cannot be told from rounding.
_NO_GAIN = np.finfo(float).eps
# Where a potential leaves less than this share of a step, the step is longer than its linear model
# holds: the next ones are damped by this at least.
_CUT_SHORT, _CUT_DAMPING = 0.3, 1e-8
# The least energy along a step is looked for between these parts of it.
_LEAST_PART, _NEARLY_ALL = 0.1, 0.9
# A step is looked at again where potentials have more than this share of what bends along it, and
# where it gains less than this share of what the curvature promises.
_MOST_OF_IT = 0.5
# A step that raises the energy is tried shorter before it is damped.
_LENGTHS = (1.0, 0.5, 0.25, 0.125)


@dataclass(frozen=True)
class Rest:
    """Where the sheet came to rest.

    Attributes
    ----------
    coords : shape (nv, 3), relative to the framework's size.
    accepted : energy at first, and after each step that was taken.
    iterations : linear systems solved.
    settled : whether the sheet came to rest.
    """

    coords: FloatArray
    accepted: tuple[float, ...]
    iterations: int
    settled: bool


def unwatched(solved: int) -> None:
    """A load that nobody watches."""
    del solved


def watched(progress: Steps, done: int, loads: int, solved: int) -> None:
    """A load before which `done` are done: reported at each system, so that it can be ended."""
    del solved
    progress(done, loads)


def relaxed(
    frame: Framework,
    coords: FloatArray,
    target: FloatArray,
    last: bool,
    potentials: Sequence[Potential] = (),
    *,
    fixed: BoolArray | None = None,
    system: NewtonSystem | None = None,
    watch: Callable[[int], None] = unwatched,
    most: int | None = None,
    settled: float = _SETTLED,
) -> Rest:
    """The local minimum of energy near to `coords`, shape (nv, 3).

    Parameters
    ----------
    target : shape (nh,), radians, to which the hinges are driven.
    last : whether the load is the full one: the sheet then rests as exactly as rounding allows.
    potentials : what acts on the sheet besides its bars and hinges.
    fixed : vertices that do not move, shape (nv,); none where left out.
    system : that of the framework and its fixed vertices, where several loads share it.
    watch : called before each system with the number of those that are solved; an exception that
        it raises ends the fold.
    most : the largest number of steps; 150 where left out, 400 at the full load.
    settled : unless last, the sheet is at rest where a step lowers the energy by less than this
        share.
    """
    system = system or NewtonSystem(frame, fixed)
    most = most or (_MOST_AT_LAST if last else _MOST)
    energy = energy_of(frame, coords, target, potentials)
    accepted = [energy.total]
    damping = _FIRST_DAMPING
    here: Linearised | None = None
    for solved in range(1, most + 1):
        watch(solved - 1)
        if here is None:
            here = system.linearised(coords, target, potentials)
        if not here.pulled and energy.total <= _ROUNDING_ENERGY * here.trace:
            return Rest(coords, tuple(accepted), solved - 1, True)
        step = here.step(damping)
        taken = None
        if step is not None:
            taken = _Line(frame, target, potentials, coords, energy, here, step).lower()
        if taken is None or step is None:
            if step is not None and _no_more(here, step, damping, energy):
                return Rest(coords, tuple(accepted), solved, True)
            if damping > _MOST_DAMPING:
                return Rest(coords, tuple(accepted), solved, step is not None)
            damping = max(100 * damping, 1e-10)
            continue
        coords, here = taken.coords, None
        share = (energy.total - taken.energy.total) / max(energy.scale, taken.energy.scale)
        energy = taken.energy
        accepted.append(energy.total)
        if taken.free == 1 and (
            np.abs(step).max() < _ROUNDING
            or (not last and damping < _TRUSTED_DAMPING and share < settled)
        ):
            return Rest(coords, tuple(accepted), solved, True)
        if taken.free < 1:
            if taken.length * taken.free < _CUT_SHORT:
                damping = max(10 * damping, _CUT_DAMPING)
        elif taken.length < 1:
            damping = 10 * damping
        else:
            damping = max(damping / 10, _LEAST_DAMPING)
    return Rest(coords, tuple(accepted), most, False)


@dataclass(frozen=True)
class _Taken:
    """A step that lowers the energy: where to, what share of it is free, which part of that."""

    coords: FloatArray
    energy: Energy
    length: float
    free: float


@dataclass(frozen=True)
class _Line:
    """A step, shape (nv, 3), from where the sheet is, and what acts along it."""

    frame: Framework
    target: FloatArray
    potentials: Sequence[Potential]
    coords: FloatArray
    energy: Energy
    here: Linearised
    step: FloatArray

    def lower(self) -> _Taken | None:
        """The longest part of the step that lowers the energy; None where none does.

        Potentials may have less curvature than their energy: where they bend more than the sheet
        does, a step that gains much less than is promised ends where a parabola has its least
        energy, if that is lower still.
        """
        free = free_share(self.potentials, self.coords, self.step)
        for length in _LENGTHS:
            taken = self._at(length, free)
            if taken.energy.total < self.energy.total:
                return self._shorter(taken)
        return None

    def _at(self, length: float, free: float) -> _Taken:
        there = self.coords + length * free * self.step
        energy = energy_of(self.frame, there, self.target, self.potentials)
        return _Taken(there, energy, length, free)

    def _shorter(self, taken: _Taken) -> _Taken:
        """The part at the least energy of a parabola, where that is lower than at its end."""
        if not self.here.pulled or taken.free < 1:
            return taken
        part = taken.length
        slope, pull = (
            part * float(np.sum(each * self.step)) for each in (self.here.gradient, self.here.pull)
        )
        gain = self.energy.total - taken.energy.total
        bend = -gain - slope
        others = sum(taken.energy.others) - sum(self.energy.others) - pull
        promised = -slope * (1 - part / 2)
        if bend <= 0 or others < _MOST_OF_IT * bend or gain > _MOST_OF_IT * promised:
            return taken
        least = -slope / (2 * bend)
        if not _LEAST_PART < least < _NEARLY_ALL:
            return taken
        shorter = self._at(least * part, 1.0)
        lower = shorter.energy.total < taken.energy.total
        return replace(shorter, length=part) if lower else taken


def _no_more(here: Linearised, step: FloatArray, damping: float, energy: Energy) -> bool:
    """Whether a step that does not lower the energy shows that nothing will."""
    if np.abs(step).max() < _ROUNDING:
        return True
    gain = -float(np.sum(here.gradient * step)) / 2
    return bool(damping < _TRUSTED_DAMPING and gain <= _NO_GAIN * energy.scale)
