"""Time that is left of an export, from its stages so far."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Mapping

__all__ = ["TimeLeft", "run_stages"]

# Seconds of the stages of a run after its growth, in their order, of a sheet of 400 faces: other
# sheets and machines are faster or slower as a whole.
_SECONDS: Mapping[str, float] = {
    "states": 1.0,
    "panels": 0.02,
    "join": 0.4,
    "inspect": 0.05,
    "clearance": 0.15,
    "step": 3.4,
    "3mf": 0.07,
    "thick png": 1.2,
    "png": 0.9,
    "html": 0.6,
}
_OF_SOLIDS = ("states", "panels", "join", "inspect", "clearance")
_SOLIDS = {"step", "stl", "3mf", "zip"}


def run_stages(outputs: Collection[str]) -> dict[str, float]:
    """Seconds that the stages of a run take of each other, where it makes these formats.

    >>> list(run_stages(["svg", "png"]))
    ['png']
    """
    solid = bool(_SOLIDS & set(outputs))
    wanted = {*outputs, *(_OF_SOLIDS if solid else ())}
    if solid and "png" in outputs:
        wanted.add("thick png")
    return {stage: seconds for stage, seconds in _SECONDS.items() if stage in wanted}


class TimeLeft:
    """Seconds that are left, if stages take as long in relation to each other as they are said to.

    stages : seconds of each in some other run, in their order; those that are not among them count
    by their own steps. clock : of seconds.
    """

    def __init__(
        self, stages: Mapping[str, float], clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._stages, self._clock = dict(stages), clock
        self._names = list(stages)
        self._begin: float | None = None  # of the first of the stages
        self._furthest = 0
        self._other, self._other_begin = "", 0.0

    def __call__(self, stage: str, done: float, total: int) -> float | None:
        """Seconds that are left when a stage has done some of its steps; None while unknown."""
        now, share = self._clock(), done / max(total, 1)
        if stage not in self._stages:
            if stage != self._other:
                self._other, self._other_begin = stage, now
            return (now - self._other_begin) * (1 - share) / share if share > 0 else None
        self._begin = now if self._begin is None else self._begin
        place = self._names.index(stage)
        if place < self._furthest:  # one that goes on after another
            place, share = self._furthest, 0.0
        self._furthest = place
        before = sum(self._stages[name] for name in self._names[:place])
        so_far = before + share * self._stages[stage]
        if so_far <= 0:
            return None
        return (now - self._begin) * (sum(self._stages.values()) - so_far) / so_far
