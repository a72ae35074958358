"""The creases of a sheet with rigid faces: states that close, and steps from one to the next.

A state is an angle of every crease that folds; it is one of rigid faces where the rotations around
every vertex multiply to the identity (belcastro and Hull 2002).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csc_array

from fab.folding.bar_hinge_model import Framework
from fab.folding.damped import DampedSystems
from fab.folding.folding_path import Closure, hinges_around
from fab.folding.rigid_states import crease_jacobian
from solver.vectors import FloatArray, IntArray

__all__ = [
    "CLOSED_RAD",
    "EXACT_RAD",
    "NEARLY_FLAT_RAD",
    "RigidCreases",
    "beginning",
    "closed",
    "direction",
    "rigid_creases",
    "stepped",
]

# States whose errors are within this close.
CLOSED_RAD = 1e-9
# Newton's method goes on to this, as rounding allows.
EXACT_RAD = 1e-13
_NEWTON_STEPS = 60
# It ends where so many steps have not halved the error.
_PATIENCE = 15
# Added to the diagonal of normal equations, relative to its mean: redundant vertices leave them
# singular.
_DAMPING = 1e-12
# Where it leaves what the letters allow, it begins again up to so often, as far within.
_PROJECTIONS = 6
_CLEAR_RAD = np.radians(2.0)
# Where states with the signs of the letters are sought: all creases at this angle, at first.
_BEGINNINGS_DEG = (30.0, 60.0, 10.0, 90.0, 120.0)
# A direction along which the sheet moves by a smaller share than wanted is rounding.
_MOVES = 1e-6
# Wrong signs within this of flat are rounding.
_FLAT_RAD = 1e-9
# A sheet that has come back this far is flat.
NEARLY_FLAT_RAD = np.radians(1.0)


@dataclass(frozen=True)
class RigidCreases:
    """The creases that fold, and what has to close.

    Attributes
    ----------
    hinges : numbers of the k hinges that turn, shape (k,).
    column : of each hinge, its place among them, -1 for those that stay flat, shape (nh,).
    signs : of the letters, -1 for mountains, 1 for valleys, 0 where free, shape (k,).
    """

    frame: Framework
    closure: Closure
    hinges: IntArray
    column: IntArray
    signs: FloatArray

    @property
    def edges(self) -> IntArray:
        """The edges of the pattern that fold, by their numbers in it, shape (k,)."""
        sheet = self.frame.sheet
        return np.asarray(sheet.edges_source[self.frame.hinges_edge[self.hinges]])

    def errors(self, angles: FloatArray) -> FloatArray:
        """Errors of closure around all vertices, shape (3 m,)."""
        return self.closure.errors(self.spread(angles)[None])[0].ravel()

    def gap(self, angles: FloatArray) -> float:
        """The largest error of closure, radians."""
        return float(np.abs(self.errors(angles)).max(initial=0.0))

    def linearised(self, angles: FloatArray) -> tuple[FloatArray, csc_array]:
        """Errors, and their derivatives by the angles, shape (3 m, k)."""
        missed, slopes = self.closure.errors(self.spread(angles)[None])
        return missed.ravel(), crease_jacobian(self.closure.hinges, slopes[0], self.column)

    def spread(self, angles: FloatArray) -> FloatArray:
        """Angles of all hinges, shape (nh,): those of the creases, and 0 elsewhere."""
        out = np.zeros(len(self.column))
        out[self.hinges] = angles
        return out

    def allow(self, angles: FloatArray) -> bool:
        """Whether no crease has the wrong sign, or is beyond 180 degrees."""
        signed = angles * self.signs > -_FLAT_RAD
        return bool((signed & (np.abs(angles) <= np.pi + CLOSED_RAD)).all())

    def nearest_allowed(self, angles: FloatArray) -> FloatArray:
        """Angles well within what the letters allow, where they are not."""
        turned = np.clip(angles * self.signs, _CLEAR_RAD, np.pi - _CLEAR_RAD)
        free = np.clip(angles, _CLEAR_RAD - np.pi, np.pi - _CLEAR_RAD)
        return np.where(self.signs == 0, free, self.signs * turned)


def rigid_creases(frame: Framework) -> RigidCreases:
    """The creases of a framework that fold: M, V, U, and slits."""
    letters = frame.sheet.pattern.edges_assignment[frame.hinges_edge]
    turns = (frame.hinges_edge >= 0) & np.isin(letters, ["M", "V", "U", "C"])
    hinges = np.flatnonzero(turns)
    column = np.full(len(turns), -1)
    column[hinges] = np.arange(len(hinges))
    own = letters[hinges]
    signs = np.where(own == "V", 1.0, np.where(own == "M", -1.0, 0.0))
    return RigidCreases(frame, hinges_around(frame), hinges, column, signs)


def closed(creases: RigidCreases, angles: FloatArray, held: int | None = None) -> FloatArray:
    """Newton's method to closure, each step the shortest; it may end short of it.

    held : a crease whose angle stays.
    """
    best, least = angles, np.inf
    halved, bound = 0, np.inf
    systems = DampedSystems()
    for number in range(_NEWTON_STEPS):
        missed, jacobian = creases.linearised(angles)
        worst = float(np.abs(missed).max(initial=0.0))
        if worst < least:
            best, least = angles, worst
        if worst <= EXACT_RAD or (worst <= CLOSED_RAD and worst > least):
            break
        if worst <= bound / 2:
            halved, bound = number, worst
        elif number - halved >= _PATIENCE:
            break
        if held is not None:
            free = np.ones(len(angles))
            free[held] = 0.0
            jacobian = (jacobian * free).tocsc()
        step = _shortest(jacobian, missed, systems)
        step *= min(1.0, 0.5 / max(float(np.abs(step).max(initial=0.0)), 1e-300))
        angles = angles - step
        if not np.isfinite(angles).all():
            break
    return best


def _shortest(
    jacobian: csc_array, wanted: FloatArray, systems: DampedSystems | None = None
) -> FloatArray:
    """The shortest x with jacobian x = wanted, as near as that can be met."""
    if not jacobian.shape[0] or not jacobian.nnz:
        return np.zeros(jacobian.shape[1])
    systems = systems or DampedSystems()
    normal = (jacobian @ jacobian.T).tocsc()
    return np.asarray(jacobian.T @ systems.factorised(normal, _DAMPING)(wanted))


def beginning(creases: RigidCreases) -> tuple[FloatArray | None, FloatArray]:
    """A state away from flat whose signs are those of the letters; None where none is found.

    And the angles of those tried that close best.
    """
    tried = []
    for degrees in _BEGINNINGS_DEG:
        angles = creases.signs * np.radians(degrees)
        for _ in range(_PROJECTIONS):
            angles = closed(creases, angles)
            folds = np.abs(angles).max() > NEARLY_FLAT_RAD
            if folds and creases.allow(angles) and creases.gap(angles) <= CLOSED_RAD:
                return angles, angles
            angles = creases.nearest_allowed(angles)
            tried.append((creases.gap(angles), angles))
    return None, min(tried, key=lambda pair: pair[0])[1]


def direction(creases: RigidCreases, angles: FloatArray, wanted: FloatArray) -> FloatArray | None:
    """The direction nearest to a wanted one in which the sheet moves, its largest change 1.

    None where the sheet does not move that way.
    """
    _, jacobian = creases.linearised(angles)
    out = wanted - _shortest(jacobian, jacobian @ wanted)
    largest = float(np.abs(out).max())
    moves = largest > _MOVES * float(np.abs(wanted).max())
    return np.asarray(out / largest, np.float64) if moves else None


def stepped(creases: RigidCreases, angles: FloatArray, step: FloatArray) -> FloatArray | None:
    """The state beside a step; None where none is near that the letters allow."""
    found = closed(creases, angles + step)
    near = bool(np.abs(found - angles - step).max() <= np.abs(step).max() / 2)
    allowed = near and creases.gap(found) <= CLOSED_RAD and creases.allow(found)
    return found if allowed else None
