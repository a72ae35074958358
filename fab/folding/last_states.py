"""The last state of a fold at which something holds, found between the states that are known."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fab.folding.bar_hinge_model import Framework, framework
from fab.folding.folded_states import (
    SOFT,
    FoldedState,
    Stage,
    panels_at,
    share_of,
    states_within,
)
from fab.folding.folding_path import Closure, hinges_around
from fab.folding.rest import relaxed
from fab.folding.rigid_states import rigid_coords_at
from fab.folding.rotation_predictor import RotationPredictor, rotation_predictor
from fab.pattern.crease_pattern import CreasePattern
from solver.vectors import FloatArray, IntArray

__all__ = ["StatesBetween", "last_state", "states_between", "with_state_at_limit"]

# Halvings of the part of the fold between two states: to about 1e-5 of the whole.
_HALVINGS = 14


@dataclass(frozen=True)
class StatesBetween:
    """States between any two of a fold: all creases on their way from one to the other.

    Where no state with flat faces is near to the angles between, the faces are those of a sheet
    that bends, at rest under these angles, as in the simulated states.
    """

    pattern: CreasePattern
    frame: Framework
    closure: Closure
    predictor: RotationPredictor

    def at(self, first: FoldedState, second: FoldedState, share: float) -> FoldedState:
        """The state at a share of the way, 0 to 1."""
        turned = second.angles_deg - first.angles_deg
        # 180 and -180 degrees are the same
        angles = first.angles_deg + share * ((turned + 180.0) % 360.0 - 180.0)
        frame = self.frame
        own = frame.hinges_edge >= 0
        hinges: FloatArray = np.zeros(len(own))
        hinges[own] = np.radians(angles[frame.sheet.edges_source[frame.hinges_edge[own]]])
        coords = rigid_coords_at(frame, self.closure, self.predictor, hinges)
        if coords is None:
            coords = relaxed(frame, self.predictor.coords(hinges), hinges, last=False).coords
        made = panels_at(
            self.pattern, coords * frame.size_mm, Stage.BETWEEN, 1.0, frame.sheet.pattern
        )
        return replace(made, share=share_of(self.pattern, made), sought=True)


def states_between(pattern: CreasePattern) -> StatesBetween:
    """The states between those of a pattern. Raises `InvalidValue` where a face has no area."""
    frame = framework(pattern, SOFT)
    return StatesBetween(pattern, frame, hinges_around(frame), rotation_predictor(frame))


def last_state(
    between: StatesBetween,
    first: FoldedState,
    second: FoldedState,
    holds: Callable[[FoldedState], bool],
    halvings: int = _HALVINGS,
) -> FoldedState:
    """The last state from the first on, at which something holds, up to the second, where not.

    The first itself where it does not hold anywhere between that was looked at.
    """
    low, high, best = 0.0, 1.0, first
    for _ in range(halvings):
        share = (low + high) / 2
        state = between.at(first, second, share)
        if holds(state):
            low, best = share, state
        else:
            high = share
    return best


def with_state_at_limit(
    pattern: CreasePattern, faces: IntArray, states: Sequence[FoldedState], limit_deg: float
) -> list[FoldedState]:
    """The states of a fold, with that at which it reaches a fold limit, if it does between them.

    As `fab.folding.folded_states.states_within` takes them, of which it is the last one then.
    """
    reached, beyond = states_within(pattern, faces, states, limit_deg)
    if not len(beyond) or not reached:
        return list(states)
    count = len(reached)

    def holds(state: FoldedState) -> bool:
        return not len(states_within(pattern, faces, [state], limit_deg)[1])

    found = last_state(states_between(pattern), states[count - 1], states[count], holds)
    return [*states[:count], *([found] if found.sought else []), *states[count:]]
