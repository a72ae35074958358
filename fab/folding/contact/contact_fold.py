"""Quasi-static folding in contact: from rest to rest, and no step crosses anything.

As `fab.folding.quasi_static.fold`, with the energy of contact (`fab.folding.contact.contact`). On
the way its barrier reaches a thousandth of the size of the sheet, so that faces feel each other
before they touch; at the full load it shrinks to a hundredth of that, since layers without
thickness would otherwise keep their creases open. The sheet is stopped where contact keeps creases
from going on.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import TypeAlias

import numpy as np

from fab.folding.bar_hinge_model import Framework
from fab.folding.contact.contact import Contact
from fab.folding.contact.stops import Stop, stop_at
from fab.folding.contact.surface import Surface, surface_of
from fab.folding.contact.work import Work
from fab.folding.newton_system import NewtonSystem
from fab.folding.potentials import Potential, energy_of, free_share
from fab.folding.quasi_static import (
    Checkpoint,
    Folding,
    FoldState,
    Reached,
    aligned,
    flat_state,
    loads_per_step,
    path_at,
    state_of,
    straight_path,
)
from fab.folding.rest import Rest, relaxed, watched
from fab.folding.rotation_predictor import RotationPredictor, rotation_predictor
from fab.folding.tolerance import Tolerance
from fab.progress import Steps, no_steps
from solver.errors import require_count
from solver.vectors import FloatArray, IntArray

__all__ = ["REACH_LAST", "fold_in_contact"]

# Reach of the barrier on the way, and one after another at the full load.
_REACH = 1e-3
# On the way it is no more than this share of the mean side of a triangle, so that the layers of a
# long ribbon have room.
_REACH_OF_SIDE = 0.02
REACH_LAST = 1e-5
_REACHES_LAST = (1e-4, REACH_LAST)
# Most steps at each load: a sheet that needs more is jammed.
_MOST = 30
# Below the full load a sheet that does not press is at rest where a step lowers the energy by less
# than this share.
_SETTLED = 1e-4
# And while layers that are at rest come nearer at the full load.
_MOST_NEARER = 40
# They are near enough, and what presses on its way is at rest, where a step lowers the energy by
# less than this share.
_NEARER = 1e-3
# A crease that lags farther behind, while faces press on each other, does not come after.
_JAMMED_RAD = np.radians(90.0)
# Creases that are held farther off than this at the full load are not waiting for thinner layers.
_NEARLY_RAD = np.radians(15.0)
# A predicted turn is taken in parts, as far as nothing is in the way, in each of which no vertex
# moves farther than this, relative to the size of the sheet; in up to so many. Vertices move along
# straight lines in each, so that a part in which something is in the way is tried in smaller ones.
_FAR, _MOST_PARTS, _FINEST = 0.1, 24, 8
# A system takes as long as looking at so many pairs for each hinge.
_PAIRS_PER_HINGE = 30
# Halvings of the load at which faces first press.
_HALVINGS = 5
# Most steps without contact at each of these; a sheet that is about to snap takes many.
_MOST_ALONE = 15


def fold_in_contact(
    frame: Framework,
    steps: int = 10,
    thickness_mm: float = 0.0,
    progress: Steps = no_steps,
    path: FloatArray | None = None,
    potentials: Sequence[Potential] = (),
    work: Work | None = None,
    checkpoint: Checkpoint | None = None,
) -> Folding:
    """Fold a framework from flat to its targets, no faces passing through each other.

    The last state is the one in which the sheet is jammed, if it is; `Folding.stopped` says where
    contact stopped it. At no load does a step raise the energy.

    Parameters
    ----------
    steps, progress, path, potentials, checkpoint : as for `fab.folding.quasi_static.fold`.
    thickness_mm : how far the middles of two layers are apart where they touch.
    work : what it may take; without bound where left out.

    Raises `InvalidValue` for less than one step, and `OutOfWorkError` where it takes more. The flat
    sheet must not overlap itself.
    """
    require_count("steps", steps, 1, "Follow the fold in one step or more.")
    in_turn = path is not None
    path = straight_path(frame) if path is None else path
    per_step = loads_per_step(path, steps)
    loads = per_step * steps
    surface, work = surface_of(frame, thickness_mm), work or Work()
    course = _Course(frame, surface, path, loads, tuple(potentials), work)
    keeper = None if potentials else checkpoint
    others = [surface.joined, np.array([surface.gap, work.left])]
    reached = keeper.begin(frame, path, loads, per_step, others) if keeper else None
    if reached is None:
        pressing: _Pressing | None = None
        reached = Reached.flat(flat_state(frame, potentials))
    else:
        pressing = course.recalled(reached)
    while not reached.over:
        number, before = reached.number + 1, reached.state.coords
        progress(number - 1, loads)
        watch = course.counted(partial(watched, progress, number - 1, loads))
        rest = course.rest(before, number / loads, 1 / loads, watch)
        state = course.state(rest, before, number / loads)
        presses = course.presses(state.coords)
        if not presses:
            pressing = None
        elif pressing is None:
            pressing = number, before, state.coords
        jammed = presses and (not rest.settled or course.lag(state) > _JAMMED_RAD)
        reached = reached.after(
            state,
            ends=number % per_step == 0 or jammed,
            over=number == loads or jammed,
            **course.carried(pressing),
        )
        if keeper:
            keeper.keep(reached)
    progress(loads, loads)
    held = pressing is not None
    folding = Folding(frame, reached.states, in_turn, None, course.room if held else 0.0)
    if pressing is None or (reached.state.settled and course.closed(reached.state)):
        return folding
    watch = course.counted(partial(watched, progress, loads, loads))
    return replace(folding, stopped=course.stop(*pressing, watch))


# The load at which faces began to press on each other, and the sheet before and after it.
_Pressing: TypeAlias = tuple[int, FloatArray, FloatArray]


class _Course:
    """The loads of one fold, and what acts on the sheet at each."""

    def __init__(
        self,
        frame: Framework,
        surface: Surface,
        path: FloatArray,
        loads: int,
        potentials: tuple[Potential, ...],
        work: Work,
    ) -> None:
        driven = frame.hinges_stiffness > 0
        each = frame.hinges_stiffness[driven] / frame.hinges_length[driven]
        self._frame, self._path, self._loads = frame, path, loads
        self._driven = driven
        self._surface, self._others = surface, potentials
        # as stiff as creases are: half a reach resists about a radian
        self._force = float(each.mean()) if len(each) else 1.0
        reach = min(_REACH, _REACH_OF_SIDE * surface.side)
        self._work = work
        self._contact = Contact(surface, reach, self._force, work)
        self._predictor: RotationPredictor = rotation_predictor(frame)
        self._system = NewtonSystem(frame)

    @property
    def room(self) -> float:
        """How far layers are apart at the full load, relative to the size of the sheet."""
        return self._surface.gap + REACH_LAST

    def counted(self, watch: Callable[[int], None]) -> Callable[[int], None]:
        """What is called before each system, whose work is counted then."""

        def count(solved: int) -> None:
            self._work.spend(_PAIRS_PER_HINGE * len(self._frame.hinges_edge))
            watch(solved)

        return count

    def rest(
        self, before: FloatArray, share: float, part: float, watch: Callable[[int], None]
    ) -> Rest:
        """The sheet at rest at a share of the fold, which is a part of it after `before`."""
        target, rate = path_at(self._path, share)
        angles = self._frame.angles_near(before, target - part * rate)
        acting = [*self._others, self._contact]
        start = self._predicted(before, angles, part * rate, target, watch)
        rest = self._relaxed(start, target, self._contact, watch, settled=_NEARER)
        if rest.settled and not self.presses(rest.coords):
            again = self._relaxed(rest.coords, target, self._contact, watch)
            rest = _joined(rest, again)
        if share < 1 or not rest.settled:
            return rest
        if not len(self._contact.touching(rest.coords).room):
            last = relaxed(
                self._frame, rest.coords, target, True, acting, system=self._system, watch=watch
            )
            return _joined(rest, last)
        if np.abs(self._off(rest.coords, target)).max(initial=0.0) > _NEARLY_RAD:
            return rest
        for reach in _REACHES_LAST:
            if reach >= self._contact.reach:
                continue
            nearer = Contact(self._surface, reach, self._force, self._work)
            last = self._relaxed(rest.coords, target, nearer, watch, _MOST_NEARER, _NEARER)
            # the sheet is at rest: its layers may go on to come nearer
            rest = _joined(rest, replace(last, settled=True))
        return rest

    def _relaxed(
        self,
        start: FloatArray,
        target: FloatArray,
        contact: Contact,
        watch: Callable[[int], None],
        most: int = _MOST,
        settled: float = _SETTLED,
    ) -> Rest:
        return relaxed(
            self._frame,
            start,
            target,
            False,
            [*self._others, contact],
            system=self._system,
            watch=watch,
            most=most,
            settled=settled,
        )

    def _predicted(
        self,
        before: FloatArray,
        angles: FloatArray,
        turn: FloatArray,
        target: FloatArray,
        watch: Callable[[int], None],
    ) -> FloatArray:
        """The sheet with as much of a turn as nothing is in the way of, if that helps."""
        acting = [*self._others, self._contact]
        there = before
        far = aligned(self._predictor.coords(angles + turn), before) - before
        moved = float(np.abs(far).max(initial=0.0))
        longest = 1 / np.clip(np.ceil(moved / _FAR), 2, _MOST_PARTS)
        finest = longest if self.presses(before) else longest / _FINEST
        done, part = 0.0, longest
        while done < 1 and part >= finest:
            watch(0)
            share = min(done + part, 1.0)
            turned = aligned(self._predictor.coords(angles + share * turn), there)
            way = free_share(acting, there, turned - there)
            if way < 1:
                part *= min(way, 0.5)
            else:
                there, done, part = turned, share, min(2 * part, longest)
        energies = [energy_of(self._frame, x, target, acting).total for x in (there, before)]
        return there if energies[0] < energies[1] else before

    def state(self, rest: Rest, before: FloatArray, share: float) -> FoldState:
        """The state at a share of the fold."""
        target, _ = path_at(self._path, share)
        coords = aligned(rest.coords, before)
        acting = [*self._others, self._contact]
        return state_of(
            self._frame,
            share,
            coords,
            target,
            rest.iterations,
            rest.settled,
            rest.accepted,
            acting,
        )

    def carried(self, pressing: _Pressing | None) -> dict[str, FloatArray | IntArray]:
        """What the loads to come depend on besides the state, for `recalled`."""
        return {
            **self._contact.seen,
            "joined": self._system.joined,
            "work": np.array(self._work.left),
            "pressed": np.array(pressing[0] if pressing else 0),
            "pressing": np.stack(pressing[1:]) if pressing else np.empty(0),
        }

    def recalled(self, reached: Reached) -> _Pressing | None:
        """Go on from where a fold was cut short; since when faces press."""
        carried = reached.carried
        seen = {name: carried[name].astype(float) for name in ("low", "high", "margin")}
        self._contact.see_again(reached.state.coords, **seen)
        self._system.join([carried["joined"].astype(np.int64)])
        self._work.left = float(carried["work"])
        number = int(carried["pressed"])
        if not number:
            return None
        before, after = carried["pressing"].astype(float)
        return number, before, after

    def presses(self, coords: FloatArray) -> bool:
        """Whether faces press on each other."""
        return bool(len(self._contact.touching(coords).room))

    def lag(self, state: FoldState) -> float:
        """By how much the crease that is farthest behind is off its angle, radians."""
        target, _ = path_at(self._path, state.load)
        return float(np.abs(self._off(state.coords, target)).max(initial=0.0))

    def closed(self, state: FoldState) -> bool:
        """Whether all creases are at their angles, but for the room that layers take."""
        target, _ = path_at(self._path, state.load)
        creases = (self._frame.hinges_edge >= 0)[self._driven]
        off = np.degrees(np.abs(self._off(state.coords, target)))
        allowed = Tolerance(layers_rel=self.room).creases_deg(np.degrees(target[self._driven]))
        return bool((off <= allowed)[creases].all())

    def _off(self, coords: FloatArray, target: FloatArray) -> FloatArray:
        return (self._frame.angles_near(coords, target) - target)[self._driven]

    def stop(
        self, number: int, before: FloatArray, pressed: FloatArray, watch: Callable[[int], None]
    ) -> Stop | None:
        """Where faces began to press on each other, from `before` to `pressed`, a load later."""
        low, high = (number - 1) / self._loads, number / self._loads
        met: FloatArray | None = None
        for _ in range(_HALVINGS):
            share = (low + high) / 2
            there = self._alone(before, share, share - low, watch)
            if self.presses(there):
                high, met = share, there
            else:
                low, before = share, there
        if met is None:
            met = self._alone(before, high, high - low, watch)
        stop = stop_at(self._frame, self._contact, met, high)
        return stop or stop_at(self._frame, self._contact, pressed, number / self._loads)

    def _alone(
        self, before: FloatArray, share: float, part: float, watch: Callable[[int], None]
    ) -> FloatArray:
        """The sheet at rest at a share without contact, or where faces first press before it."""
        target, rate = path_at(self._path, share)
        angles = self._frame.angles_near(before, target - part * rate)
        turned = aligned(self._predictor.coords(angles + part * rate), before)
        start = min(
            (before, turned),
            key=lambda x: energy_of(self._frame, x, target, self._others).total,
        )
        rest = relaxed(
            self._frame,
            start,
            target,
            False,
            self._others,
            system=self._system,
            watch=watch,
            most=_MOST_ALONE,
        )
        there = aligned(rest.coords, before)
        for _ in range(_MOST_PARTS):
            way = self._contact.longest_step(before, there - before)
            if way == 1:
                return there
            before = before + way * (there - before)
            if self.presses(before):
                return before
        return before


def _joined(first: Rest, then: Rest) -> Rest:
    """Two rests of one load, one after the other."""
    return Rest(
        then.coords,
        first.accepted + then.accepted,
        first.iterations + then.iterations,
        first.settled and then.settled,
    )
