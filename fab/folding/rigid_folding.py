"""A fold along the rigid motion of a sheet: its states, at equal steps of the driving crease."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fab.folding.bar_hinge_model import Framework
from fab.folding.quasi_static import Folding, FoldState, aligned, state_of
from fab.folding.rigid_motion import RigidMotion
from fab.folding.rotation_predictor import rotation_predictor
from fab.pattern.face_poses import bend_mm
from fab.progress import Steps, no_steps
from solver.self_intersection import crossing_faces
from solver.vectors import FloatArray

__all__ = ["RigidFold", "fold_rigidly"]


@dataclass(frozen=True)
class RigidFold:
    """States with flat faces.

    Attributes
    ----------
    folding : from flat to the end of the motion, without strain.
    beyond : states further on, towards the sheet that is folded flat; their loads are over 1.
    stopped : whether faces would pass through each other in the state after the last one.
    angles_deg : shape (n, k), of the creases of the motion in all states, those beyond included.
    bend_max_mm : largest distance of a corner from its rigid face, in any state.
    """

    folding: Folding
    beyond: tuple[FoldState, ...]
    stopped: bool
    angles_deg: FloatArray
    bend_max_mm: float

    @property
    def shown(self) -> Folding:
        """All states, those beyond included."""
        return replace(self.folding, states=(*self.folding.states, *self.beyond))

    def report(self, motion: RigidMotion) -> dict[str, Any]:
        """As JSON values: the angles in all states, of creases by their numbers in the pattern."""
        return {
            "bend_max_mm": self.bend_max_mm,
            "creases": motion.creases.edges.tolist(),
            "angles_deg": self.angles_deg.tolist(),
        }


def fold_rigidly(
    frame: Framework,
    motion: RigidMotion,
    steps: int,
    progress: Steps = no_steps,
    *,
    fold_flat: bool = False,
) -> RigidFold:
    """Fold a framework by the motion of its pattern, in `steps` equal steps of the driving crease.

    fold_flat : go on, in as many steps, until the sheet is folded flat, or faces would pass through
    each other. progress : called with (states done, states in all).
    """
    every = motion.stations(steps)
    loads = np.linspace(0.0, 1.0, steps + 1)
    further = motion.beyond() if fold_flat else None
    if further is not None:
        every = np.concatenate([every, further.stations(steps)[1:]])
        driven = every[steps + 1 :, motion.driving] / motion.path[-1, motion.driving]
        loads = np.concatenate([loads, driven])
    predictor = rotation_predictor(frame)
    states: list[FoldState] = []
    stopped = False
    for number, (angles, load) in enumerate(zip(every, loads.tolist(), strict=True)):
        progress(number, len(every))
        hinges = motion.creases.spread(angles)
        before = states[-1].coords if states else frame.vertices_coords
        coords = aligned(predictor.coords(hinges), before)
        stopped = number > steps and _crosses(frame, coords)
        if stopped:
            break
        states.append(state_of(frame, load, coords, hinges, 0, True))
    progress(len(every), len(every))
    sheet, size = frame.sheet.pattern, frame.size_mm
    return RigidFold(
        Folding(frame, tuple(states[: steps + 1])),
        tuple(states[steps + 1 :]),
        stopped,
        np.degrees(every[: len(states)]),
        max(bend_mm(sheet, state.coords * size) for state in states),
    )


def _crosses(frame: Framework, coords: FloatArray) -> bool:
    sheet = frame.sheet.pattern
    return len(crossing_faces(coords, sheet.faces_vertices, sheet.faces_offsets)) > 0
