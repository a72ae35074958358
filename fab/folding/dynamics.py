"""Dynamic folding: masses that hinges pull to their targets, with damping.

The compliant dynamics of Ghassaei, Demaine and Gershenfeld (2018), "Fast, interactive origami
simulation using GPU computation", with its settings: unit masses at the vertices, bars with viscous
damping, hinges, springs at the corners of the triangles, and (semi-implicit) Euler steps as long as
the stiffest bar allows. For comparison: `fab.folding.quasi_static` gets to the target faster.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csr_array

from fab.folding.bar_hinge_model import Framework, hinge_forces
from fab.folding.quasi_static import Folding, flat_state, state_of
from fab.progress import Steps, no_steps
from solver.errors import InvalidValue, require_count, require_finite
from solver.vectors import FloatArray, cross, dot, norm

__all__ = ["DynamicSettings", "Motion", "fold_dynamically", "integrate"]

# Euler steps from one check, whether the sheet rests, to the next.
_CHECKED = 100


@dataclass(frozen=True)
class DynamicSettings:
    """How the sheet moves. Raises `InvalidValue` for values out of bounds.

    Attributes
    ----------
    face : stiffness of the triangles' corners, per radian.
    damping : of the bars, relative to critical damping; with 0 the sheet moves for ever.
    steps : the largest number of Euler steps.
    settled_speed : largest speed of a vertex, in diagonals per unit of time, that counts as rest.
    """

    face: float = 0.2
    damping: float = 0.45
    steps: int = 100_000
    settled_speed: float = 1e-6

    def __post_init__(self) -> None:
        require_count("steps", self.steps, 1, "Take one step or more.")
        for name in ("face", "damping", "settled_speed"):
            value = getattr(self, name)
            require_finite(name, value)
            if value < 0:
                raise InvalidValue(name, value, "be at least 0", "Leave it out for its default.")


@dataclass(frozen=True)
class Motion:
    """The state at the end of a motion.

    Attributes
    ----------
    coords, velocity : shape (nv, 3), relative to the framework's size.
    steps : Euler steps taken.
    settled : whether the sheet came to rest.
    finite : False where the integration blew up.
    """

    coords: FloatArray
    velocity: FloatArray
    steps: int
    settled: bool
    finite: bool


def fold_dynamically(
    frame: Framework,
    steps: int = 10,
    settings: DynamicSettings | None = None,
    progress: Steps = no_steps,
) -> Folding:
    """Fold a framework from flat to its targets in equal steps, each until the sheet rests.

    `settings.steps` is the limit of each step; iterations are Euler steps. A motion that blows up
    ends the fold: its last state is the one before, and not settled.

    progress : called with (steps done, steps in all).

    Raises `InvalidValue` for less than one step.
    """
    require_count("steps", steps, 1, "Follow the fold in one step or more.")
    states = [flat_state(frame)]
    motion: Motion | None = None
    for step in range(1, steps + 1):
        progress(step - 1, steps)
        target = step / steps * frame.hinges_target
        motion = integrate(
            frame, target, settings, motion, lambda *_, at=step: progress(at - 1, steps)
        )
        if not motion.finite:
            last = states[-1]
            states[-1] = replace(last, settled=False, iterations=last.iterations + motion.steps)
            break
        states.append(
            state_of(frame, step / steps, motion.coords, target, motion.steps, motion.settled)
        )
    progress(steps, steps)
    return Folding(frame, tuple(states))


def integrate(
    frame: Framework,
    target: FloatArray,
    settings: DynamicSettings | None = None,
    begin: Motion | None = None,
    progress: Steps = no_steps,
) -> Motion:
    """The motion of a framework with its hinges driven to `target`, shape (nh,), radians.

    begin : the state that it goes on from; the flat sheet at rest where left out.
    progress : called every 100 Euler steps with their number, and the largest one.
    """
    settings = settings or DynamicSettings()
    coords = frame.vertices_coords if begin is None else begin.coords
    velocity = np.zeros_like(coords) if begin is None else begin.velocity
    step = 0.9 / (2 * np.pi * np.sqrt(frame.bars_stiffness.max()))
    viscosity = 2 * settings.damping * np.sqrt(frame.bars_stiffness)
    rest = _corner_angles(frame, frame.vertices_coords)[0]
    start, end = frame.bars_vertices.T
    ends = np.concatenate([start, end, frame.triangles_vertices.ravel()])
    gathered = csr_array(
        (np.ones(len(ends)), (ends, np.arange(len(ends)))), shape=(len(coords), len(ends))
    )
    done = 0
    with np.errstate(all="ignore"):
        while done < settings.steps:
            force = hinge_forces(frame, coords, target)
            side = coords[end] - coords[start]
            length = norm(side)
            tension = frame.bars_stiffness * (length - frame.bars_length) / length
            pull = tension[:, None] * side
            pull += viscosity[:, None] * (velocity[end] - velocity[start])
            angles, gradients = _corner_angles(frame, coords)
            back = -settings.face * (angles - rest)
            corners = np.zeros((*angles.shape, 3))
            for k in range(3):
                for corner, gradient in enumerate(gradients[k]):
                    corners[:, (k + corner) % 3] += back[:, k, None] * gradient
            force += gathered @ np.concatenate([pull, -pull, corners.reshape(-1, 3)])
            velocity = velocity + step * force
            coords = coords + step * velocity
            done += 1
            if done % _CHECKED == 0:
                progress(done, settings.steps)
                speed = float(norm(velocity).max())
                if not np.isfinite(speed):
                    return Motion(coords, velocity, done, False, False)
                if speed < settings.settled_speed:
                    return Motion(coords, velocity, done, True, True)
    finite = bool(np.isfinite(coords).all())
    return Motion(coords, velocity, done, False, finite)


def _corner_angles(
    frame: Framework, coords: FloatArray
) -> tuple[FloatArray, list[tuple[FloatArray, FloatArray, FloatArray]]]:
    """Angles of all triangles, shape (nt, 3), and their gradients.

    For each corner three arrays of shape (nt, 3): its gradient by the corner itself, the next and
    the last.
    """
    points = coords[frame.triangles_vertices]
    normal = cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0])
    normal /= norm(normal)[:, None]
    angles, gradients = [], []
    for k in range(3):
        to_next = points[:, (k + 1) % 3] - points[:, k]
        to_last = points[:, (k + 2) % 3] - points[:, k]
        angles.append(np.arctan2(norm(cross(to_next, to_last)), dot(to_next, to_last)))
        by_next = cross(to_next, normal) / dot(to_next, to_next)[:, None]
        by_last = -cross(to_last, normal) / dot(to_last, to_last)[:, None]
        gradients.append((-by_next - by_last, by_next, by_last))
    return np.stack(angles, axis=1), gradients
