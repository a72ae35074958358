"""Rigid motions: does a sheet fold from flat to its target with flat faces, and in how many ways?

Freedom is counted at a state between flat and folded flat (`fab.folding.freedom`): at the target,
or at one with the signs of the letters. From there the sheet is followed to flat and to its target,
each station brought back to closure by Newton's method, so that a sheet that moves to first order
and then locks is told from one that folds.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import numpy as np

from fab.errors import counted, first_few
from fab.folding.bar_hinge_model import Framework, framework, wrapped
from fab.folding.freedom import Freedom, freedom_of
from fab.folding.quasi_static import path_at
from fab.folding.rigid_creases import (
    CLOSED_RAD,
    NEARLY_FLAT_RAD,
    RigidCreases,
    beginning,
    closed,
    direction,
    rigid_creases,
    stepped,
)
from fab.folding.target_forms import target_form
from fab.pattern.crease_pattern import FLAT_ANGLE_DEG, CreasePattern
from fab.pattern.kinematics import unknown_angles
from solver.hinge_angles import hinge_angles
from solver.vectors import FloatArray

__all__ = ["RigidMotion", "RigidVerdict", "rigid_motion"]

# From station to station no crease turns by more.
_STRIDE_RAD = np.radians(4.0)
_LEAST_STRIDE_RAD = np.radians(0.01)
_MOST_STATIONS = 400
# Creases within this of 180 degrees, or of 0, are folded flat, or flat.
_FOLDED_RAD = 1e-6
# Errors of closure grow with the square of those of angles there: what a drawing's digits leave.
_FLAT_CLOSED_RAD = 1e-4
# States between are not sought in sheets with more creases: that takes minutes.
_MOST_CREASES = 4000


class RigidVerdict(StrEnum):
    """How a sheet with flat faces folds."""

    FOLDS = "folds-rigidly"
    MISSES = "folds-rigidly-elsewhere"
    BENDS = "bends-on-its-way"
    NONE = "no-rigid-state"
    UNSOUGHT = "not-sought"
    FLAT = "nothing-folds"


@dataclass(frozen=True)
class RigidMotion:
    """What is known of a sheet with rigid faces.

    Attributes
    ----------
    verdict : FOLDS, from flat to its target; MISSES, away from flat, but no motion to its target is
        found; BENDS, no motion from flat leads to the target, or to another state with flat faces;
        NONE, no target is known, nor such a state; UNSOUGHT, in a sheet of over 4,000 creases
        without a target between flat and folded flat; FLAT, no crease has to fold.
    creases : those that fold. Of holes, the faces around them need not meet.
    path : shape (n, k), radians, angles of the k creases at stations from the beginning of the
        motion, mostly flat, to its end; none (n = 0) where there is no motion.
    freedom : at a state between; None where none is found.
    missed_rad : where none is found, by how much the nearest does not close; None otherwise. A
        sheet that folds rigidly, drawn with few digits, misses by little.
    """

    verdict: RigidVerdict
    creases: RigidCreases
    path: FloatArray
    freedom: Freedom | None
    missed_rad: float | None = None

    @property
    def driving(self) -> int:
        """The place of the crease that folds most at the end, among the creases."""
        return int(np.abs(self.path[-1]).argmax())

    def stations(self, count: int) -> FloatArray:
        """Angles at the beginning and after each of `count` equal steps of the driving crease.

        Shape (count + 1, k), radians; all vertices close to rounding. Where the driving crease
        turns back on its way, the steps are those of the path's length.
        """
        driven = np.abs(self.path[:, self.driving])
        rises = bool((np.diff(driven) > 0).all())
        out = [self.path[0]]
        for share in np.arange(1, count) / count:
            if rises:
                at = driven[0] + share * (driven[-1] - driven[0])
                begin = np.array([np.interp(at, driven, angles) for angles in self.path.T])
                found = closed(self.creases, begin, self.driving)
            else:
                begin, _ = path_at(self.path, float(share))
                found = closed(self.creases, begin)
            out.append(found)
        return np.stack([*out, self.path[-1]])

    def beyond(self) -> RigidMotion | None:
        """The motion from the end of this one on, until every crease is at 180 degrees.

        None where the sheet does not fold so far, or has done so.
        """
        if not len(self.path) or _folded_flat(self.path[-1]):
            return None
        end = self.path[-1]
        flat = np.where(np.abs(end) > _FOLDED_RAD, np.copysign(np.pi, end), 0.0)
        path, reached = _followed(self.creases, end, flat)
        return RigidMotion(self.verdict, self.creases, path, self.freedom) if reached else None

    def report(self) -> dict[str, Any]:
        """As JSON values; edges are those of the pattern, the first 20 that do not move."""
        out: dict[str, Any] = {
            "verdict": self.verdict.value,
            "text": self.sentence(),
            "degrees_of_freedom": None,
        }
        if self.freedom is not None:
            still = self.creases.edges[~self.freedom.moving]
            out["degrees_of_freedom"] = self.freedom.count
            out["more_degrees_possible"] = not self.freedom.exact
            out["creases_moving"] = int(self.freedom.moving.sum())
            out["creases_still"] = first_few(still.tolist())
            # errors of closure, rad, for each rad of the softest motion that is locked
            out["least_locked"] = self.freedom.least_locked
        if self.missed_rad is not None:
            out["missed_deg"] = float(np.degrees(self.missed_rad))
        if len(self.path):
            out["driving_crease"] = int(self.creases.edges[self.driving])
            out["driving_deg"] = float(np.degrees(self.path[-1, self.driving]))
        return out

    def sentence(self) -> str:
        """Such as "folds rigidly, 1 degree of freedom, crease 12 driven to 90 degrees"."""
        freedom = self.freedom
        ways = ""
        if freedom is not None:
            more = "" if freedom.exact else "at least "
            ways = ", " + more + counted(freedom.count, "degree", "degrees") + " of freedom"
        missed = ""
        if self.missed_rad is not None:
            missed = f" (the nearest misses closure by {np.degrees(self.missed_rad):.2g} degrees)"
        driven = ""
        if len(self.path):
            edge, angle = self.creases.edges[self.driving], self.path[-1, self.driving]
            driven = f"crease {edge} driven to {np.degrees(angle):.6g} degrees"
        match self.verdict:
            case RigidVerdict.FOLDS:
                return f"folds rigidly{ways}, {driven}"
            case RigidVerdict.MISSES:
                target = "no motion from there to its target is found"
                return f"folds rigidly{ways}, {driven}, but {target}"
            case RigidVerdict.BENDS if freedom is not None and freedom.count:
                return f"bends on its way: it moves with flat faces{ways}, but not from flat"
            case RigidVerdict.BENDS if freedom is not None:
                return "bends on its way: with flat faces it is locked when folded"
            case RigidVerdict.BENDS:
                return f"bends on its way: no state with flat faces is found between{missed}"
            case RigidVerdict.FLAT:
                return f"no crease folds{_unassigned(self.creases.frame)}"
            case RigidVerdict.UNSOUGHT:
                return f"over {_MOST_CREASES:,} creases: no rigid motion was sought"
        return f"no folded state with flat faces is found{missed}"


def rigid_motion(pattern: CreasePattern, frame: Framework | None = None) -> RigidMotion:
    """The motion of a pattern with rigid faces, from flat to its target.

    Its target is its folded form, or its fold angles where they close, those of unassigned creases
    left open. Mountains and valleys fold as their letters say, unassigned creases as they must,
    others not at all.

    frame : that of the pattern, where it is known. Raises `InvalidValue` as
    `fab.folding.bar_hinge_model.framework`.
    """
    creases = rigid_creases(framework(pattern) if frame is None else frame)
    nowhere = np.empty((0, len(creases.hinges)))
    target = _target(creases)
    if not (creases.signs.any() or (target is not None and _folds(target))):
        return RigidMotion(RigidVerdict.FLAT, creases, nowhere, None)
    between = target
    if target is None or _folded_flat(target):
        if len(creases.hinges) > _MOST_CREASES:
            return RigidMotion(RigidVerdict.UNSOUGHT, creases, nowhere, None)
        between, nearest = beginning(creases) if creases.signs.any() else (None, None)
        if between is None:
            verdict = RigidVerdict.NONE
            if target_form(creases.frame) is not None:
                verdict = RigidVerdict.BENDS
            missed = None if nearest is None else creases.gap(nearest)
            return RigidMotion(verdict, creases, nowhere, None, missed)
    assert between is not None
    freedom = freedom_of(creases.linearised(between)[1])
    down, reached = (nowhere, False)
    if freedom.count:
        down, reached = _followed(creases, between, np.zeros_like(between))
    if not reached:
        return RigidMotion(RigidVerdict.BENDS, creases, nowhere, freedom)
    path = down[::-1]
    if between is target:
        return RigidMotion(RigidVerdict.FOLDS, creases, path, freedom)
    # folded flat, creases without a letter are at either of -180 and 180 degrees
    signs = np.where(creases.signs, creases.signs, np.sign(between))
    goal = signs * (np.pi if target is None else np.abs(target))
    up, reached = _followed(creases, between, goal)
    reached = reached and (target is not None or _as_driven(creases, goal))
    verdict = RigidVerdict.FOLDS if reached else RigidVerdict.MISSES
    return RigidMotion(verdict, creases, np.concatenate([path, up[1:]]), freedom)


def _unassigned(frame: Framework) -> str:
    """Such as ": 4 are unassigned (U), give them letters M and V"; empty without such creases."""
    sheet = frame.sheet.pattern
    free = unknown_angles(sheet) & (sheet.edges_assignment == "U") & sheet.edges_joining
    count = int(free.sum())
    are = "is" if count == 1 else "are"
    return f": {count} {are} unassigned (U), give letters M and V" if count else ""


def _target(creases: RigidCreases) -> FloatArray | None:
    """Angles of the creases at the target, radians; None where it has none with flat faces."""
    frame = creases.frame
    angles = frame.hinges_target[creases.hinges]
    form = target_form(frame)
    if form is not None and unknown_angles(frame.sheet.pattern).any():
        measured = hinge_angles(form, frame.hinges_vertices)[creases.hinges]
        angles = angles + wrapped(measured - angles)
    elif form is None:
        return None
    if _folded_flat(angles):
        return angles  # where Newton's method would be slow
    found = closed(creases, angles)
    near = bool(np.abs(found - angles).max(initial=0.0) <= NEARLY_FLAT_RAD)
    return found if near and creases.gap(found) <= CLOSED_RAD else None


def _as_driven(creases: RigidCreases, angles: FloatArray) -> bool:
    """Whether some creases turn freely, and all others are at their target angles."""
    frame = creases.frame
    free = unknown_angles(frame.sheet.pattern)[frame.hinges_edge[creases.hinges]]
    off = np.abs(angles - frame.hinges_target[creases.hinges])[~free]
    return bool(free.any() and (off <= _FOLDED_RAD).all())


def _folds(angles: FloatArray) -> bool:
    return bool((np.abs(angles) > np.radians(FLAT_ANGLE_DEG)).any())


def _folded_flat(angles: FloatArray) -> bool:
    """Whether all faces are in one plane, and some creases folded."""
    size = np.abs(angles)
    flat = np.minimum(size, np.abs(np.pi - size)) < _FOLDED_RAD
    return bool(flat.all() and (size > 1).any())


def _followed(
    creases: RigidCreases, start: FloatArray, target: FloatArray
) -> tuple[FloatArray, bool]:
    """Stations from a state towards another, shape (n, k), and whether it is reached.

    The last station is the target itself where it closes and all creases have come near to it.
    """
    stations, stride = [start], _STRIDE_RAD
    near = _STRIDE_RAD if target.any() else NEARLY_FLAT_RAD
    for _ in range(_MOST_STATIONS):
        rest = target - stations[-1]
        left = float(np.abs(rest).max(initial=0.0))
        if left <= near:
            bound = _FLAT_CLOSED_RAD if _folded_flat(target) else CLOSED_RAD
            reached = creases.gap(target) <= bound
            return np.stack([*stations, target] if reached and left else stations), reached
        # creases fold in proportion near the flat state, whichever way it is left
        ahead = direction(creases, stations[-1], rest)
        if ahead is None:
            break
        found = stepped(creases, stations[-1], min(stride, left / 2) * ahead)
        stride = stride / 2 if found is None else min(2 * stride, _STRIDE_RAD)
        if found is not None:
            stations.append(found)
        if stride < _LEAST_STRIDE_RAD:
            break
    return np.stack(stations), False
