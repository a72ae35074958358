"""Fold angles of a rigid fold: those that all creases have when the one that folds most is at a
given angle, while all faces stay flat.

The states of a rigid fold are the angles that close around every vertex (belcastro and Hull 2002).
From a state with the signs of the letters they are followed back to flat, and from there to the
angle that is asked for, along the steepest rise of the sum of all angles (or, where that ends, of
the sum of their squares); every station is brought back to closure by Newton's method.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csc_array

from fab.errors import Finding, Severity, counted
from fab.folding.bar_hinge_model import Framework, framework
from fab.folding.fold_settings import FoldSettings
from fab.folding.folding_path import Closure, hinges_around
from fab.folding.quasi_static import damped
from fab.folding.rigid_states import crease_jacobian
from fab.pattern.crease_pattern import CreasePattern
from fab.pattern.kinematics import fold_by_angles, vertices_closure_rad
from fab.pattern.open_cuts import opened
from solver.errors import InvalidValue
from solver.vectors import FloatArray, IntArray

__all__ = ["rigid_angles"]

_CLOSED_RAD = 1e-9
# Newton's method goes on to this, as rounding allows.
_EXACT_RAD = 1e-13
_NEWTON_STEPS = 60
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
# From station to station no crease turns by more.
_STRIDE_RAD = np.radians(4.0)
_LEAST_STRIDE_RAD = np.radians(0.01)
_MOST_STATIONS = 400
# Wrong signs within this of flat are rounding.
_FLAT_RAD = 1e-9
# A sheet that has come back this far is flat.
_NEARLY_FLAT_RAD = np.radians(1.0)
_FULL_DEG = 180.0
# Of the sheet: the places that its faces give to a vertex beside a hole.
_GAP_REL = 1e-9


@dataclass(frozen=True)
class _Creases:
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

    def errors(self, angles: FloatArray) -> FloatArray:
        """Errors of closure around all vertices, shape (3 m,)."""
        return self.closure.errors(self._spread(angles))[0].ravel()

    def linearised(self, angles: FloatArray) -> tuple[FloatArray, csc_array]:
        """Errors, and their derivatives by the angles, shape (3 m, k)."""
        missed, slopes = self.closure.errors(self._spread(angles))
        return missed.ravel(), crease_jacobian(self.closure.hinges, slopes[0], self.column)

    def _spread(self, angles: FloatArray) -> FloatArray:
        out = np.zeros((1, len(self.column)))
        out[0, self.hinges] = angles
        return out

    def allow(self, angles: FloatArray) -> bool:
        """Whether no crease has the wrong sign, or is beyond 180 degrees."""
        signed = angles * self.signs > -_FLAT_RAD
        return bool((signed & (np.abs(angles) <= np.pi + _CLOSED_RAD)).all())

    def nearest_allowed(self, angles: FloatArray) -> FloatArray:
        """Angles well within what the letters allow, where they are not."""
        turned = np.clip(angles * self.signs, _CLEAR_RAD, np.pi - _CLEAR_RAD)
        free = np.clip(angles, _CLEAR_RAD - np.pi, np.pi - _CLEAR_RAD)
        return np.where(self.signs == 0, free, self.signs * turned)


def rigid_angles(
    pattern: CreasePattern, fold_deg: float = _FULL_DEG
) -> tuple[CreasePattern, list[Finding]]:
    """The pattern with the fold angles of a rigid fold, and what is reported of it.

    Mountains and valleys fold as their letters say, unassigned creases as they must, and the crease
    that folds most by fold_deg. Angles and folded form of the pattern do not count and are
    replaced. Where no such fold is found the pattern stays as it is.

    Codes of the findings: "rigid-fold", a note; "rigid-fold-missing", a warning with the vertex at
    which closure fails worst, or with how far the sheet folds.

    Raises `InvalidValue` for a fold_deg that is not over 0 and at most 180, and where a face has
    no area.
    """
    if not 0 < fold_deg <= _FULL_DEG:
        raise InvalidValue("fold_deg", fold_deg, "be over 0 and at most 180", "Give degrees.")
    creases = _creases(pattern)
    if not creases.signs.any():
        text = "no mountain or valley says how the sheet folds: its fold angles stay."
        return pattern, [Finding("rigid-fold-missing", Severity.WARNING, text)]
    begin, nearest = _beginning(creases)
    if begin is None:
        return pattern, [_not_closing(pattern, creases, nearest)]
    flat = _unfolded(creases, begin)
    largest = float(np.abs(flat).max())
    if largest > _NEARLY_FLAT_RAD:
        text = (
            "a rigid fold with these mountains and valleys is found, but none that leads there "
            f"from the flat sheet: it ends where a crease is at {np.degrees(largest):.3g} degrees. "
            "The fold angles stay."
        )
        return pattern, [Finding("rigid-fold-missing", Severity.WARNING, text)]
    goal = np.radians(fold_deg)
    end, reached = _folded(creases, flat, goal, evenly=True)
    if not reached:
        again, reached = _folded(creases, flat, goal, evenly=False)
        end = (
            max(end, again, key=lambda angles: float(np.abs(angles).max()))
            if not reached
            else again
        )
    if not reached:
        text = (
            "with flat faces the sheet folds until a crease is at "
            f"{np.degrees(np.abs(end).max()):.4g} degrees, not to {fold_deg:g}. Give a smaller "
            "--fold-deg. The fold angles stay."
        )
        return pattern, [Finding("rigid-fold-missing", Severity.WARNING, text)]
    made = _with_angles(pattern, creases, end)
    return _checked(pattern, made, fold_deg)


def _creases(pattern: CreasePattern) -> _Creases:
    frame = framework(replace(pattern, folded_coords=None), FoldSettings())
    letters = frame.sheet.pattern.edges_assignment[frame.hinges_edge]
    turns = (frame.hinges_edge >= 0) & np.isin(letters, ["M", "V", "U", "C"])
    hinges = np.flatnonzero(turns)
    column = np.full(len(turns), -1)
    column[hinges] = np.arange(len(hinges))
    own = letters[hinges]
    signs = np.where(own == "V", 1.0, np.where(own == "M", -1.0, 0.0))
    return _Creases(frame, hinges_around(frame), hinges, column, signs)


def _closed(creases: _Creases, angles: FloatArray, held: int | None = None) -> FloatArray:
    """Newton's method to closure, each step the shortest; it may end short of it.

    held : a crease whose angle stays.
    """
    best, least = angles, np.inf
    for _ in range(_NEWTON_STEPS):
        missed, jacobian = creases.linearised(angles)
        worst = float(np.abs(missed).max(initial=0.0))
        if worst < least:
            best, least = angles, worst
        if worst <= _EXACT_RAD or (worst <= _CLOSED_RAD and worst > least):
            break
        if held is not None:
            free = np.ones(len(angles))
            free[held] = 0.0
            jacobian = (jacobian * free).tocsc()
        step = _shortest(jacobian, missed)
        step *= min(1.0, 0.5 / max(float(np.abs(step).max(initial=0.0)), 1e-300))
        angles = angles - step
        if not np.isfinite(angles).all():
            break
    return best


def _shortest(jacobian: csc_array, wanted: FloatArray) -> FloatArray:
    """The shortest x with jacobian x = wanted, as near as that can be met."""
    if not jacobian.shape[0] or not jacobian.nnz:
        return np.zeros(jacobian.shape[1])
    normal = (jacobian @ jacobian.T).tocsc()
    return np.asarray(jacobian.T @ damped(normal, _DAMPING).solve(wanted))


def _gap(creases: _Creases, angles: FloatArray) -> float:
    return float(np.abs(creases.errors(angles)).max(initial=0.0))


def _beginning(creases: _Creases) -> tuple[FloatArray | None, FloatArray]:
    """A state away from flat whose signs are those of the letters; None where none is found.

    And the angles of those tried that close best.
    """
    tried = []
    for degrees in _BEGINNINGS_DEG:
        angles = creases.signs * np.radians(degrees)
        for _ in range(_PROJECTIONS):
            angles = _closed(creases, angles)
            folds = np.abs(angles).max() > _NEARLY_FLAT_RAD
            if folds and creases.allow(angles) and _gap(creases, angles) <= _CLOSED_RAD:
                return angles, angles
            angles = creases.nearest_allowed(angles)
            tried.append((_gap(creases, angles), angles))
    return None, min(tried, key=lambda pair: pair[0])[1]


def _unfolded(creases: _Creases, angles: FloatArray) -> FloatArray:
    """The state at which a motion ends on which all creases unfold in proportion.

    No crease of it is at more than a degree where it leads to the flat sheet.
    """
    stride = _STRIDE_RAD
    for _ in range(_MOST_STATIONS):
        largest = np.abs(angles).max()
        if largest <= _NEARLY_FLAT_RAD:
            break
        # creases fold in proportion near the flat state, whichever way it is left
        fall = _along(creases, angles, -angles)
        if fall is None:
            break
        found = _stepped(creases, angles, min(stride, largest / 2) * fall)
        stride = stride / 2 if found is None else min(2 * stride, _STRIDE_RAD)
        angles = angles if found is None else found
        if stride < _LEAST_STRIDE_RAD:
            break
    return angles


def _folded(
    creases: _Creases, angles: FloatArray, goal_rad: float, *, evenly: bool
) -> tuple[FloatArray, bool]:
    """The state ahead whose largest angle is the goal, and whether it is reached.

    evenly : whether all creases are driven alike, or in proportion to their angles.
    """
    stride = _STRIDE_RAD
    for _ in range(_MOST_STATIONS):
        alike = np.where(creases.signs, creases.signs, np.sign(angles))
        rise = _along(creases, angles, alike if evenly else angles)
        if rise is None:
            break
        ahead = angles + stride * rise
        if np.abs(ahead).max() >= goal_rad:
            end = _ended(creases, angles, ahead, goal_rad)
            if end is not None:
                return end, True
        found = _stepped(creases, angles, stride * rise)
        stride = stride / 2 if found is None else min(2 * stride, _STRIDE_RAD)
        angles = angles if found is None else found
        if stride < _LEAST_STRIDE_RAD:
            break
    return angles, False


def _along(creases: _Creases, angles: FloatArray, wanted: FloatArray) -> FloatArray | None:
    """The direction nearest to a wanted one in which the sheet moves, its largest change 1.

    None where the sheet does not move that way.
    """
    _, jacobian = creases.linearised(angles)
    out = wanted - _shortest(jacobian, jacobian @ wanted)
    largest = float(np.abs(out).max())
    moves = largest > _MOVES * float(np.abs(wanted).max())
    return np.asarray(out / largest, np.float64) if moves else None


def _stepped(creases: _Creases, angles: FloatArray, step: FloatArray) -> FloatArray | None:
    """The state beside a step; None where none is near that the letters allow."""
    found = _closed(creases, angles + step)
    near = bool(np.abs(found - angles - step).max() <= np.abs(step).max() / 2)
    allowed = near and _gap(creases, found) <= _CLOSED_RAD and creases.allow(found)
    return found if allowed else None


def _ended(
    creases: _Creases, angles: FloatArray, ahead: FloatArray, goal_rad: float
) -> FloatArray | None:
    """The state between two stations whose largest angle is the goal; None where none closes."""
    held = int(np.abs(ahead).argmax())
    for _ in range(len(ahead)):
        share = (goal_rad - np.abs(angles[held])) / (np.abs(ahead[held]) - np.abs(angles[held]))
        begin = angles + share * (ahead - angles)
        begin[held] = np.sign(begin[held]) * goal_rad
        folded = np.where(np.abs(begin) > np.pi - _STRIDE_RAD / 2, np.copysign(np.pi, begin), begin)
        if goal_rad == np.pi and _gap(creases, folded) <= _EXACT_RAD:
            return np.asarray(folded)  # flat, where Newton's method would be slow
        found = _closed(creases, begin, held)
        if _gap(creases, found) > _CLOSED_RAD or not creases.allow(found):
            return None
        largest = int(np.abs(found).argmax())
        if np.abs(found[largest]) <= goal_rad + _CLOSED_RAD:
            return found
        held = largest
    return None


def _with_angles(pattern: CreasePattern, creases: _Creases, angles: FloatArray) -> CreasePattern:
    """The pattern folded by the angles of its creases."""
    sheet = creases.frame.sheet
    edges = creases.frame.hinges_edge[creases.hinges]
    if pattern is not sheet.pattern:
        edges = sheet.edges_source[edges]
    kept = pattern.edges_assignment[edges] != "C"
    out = np.zeros(len(pattern.edges_vertices))
    out[edges[kept]] = np.degrees(angles[kept])
    return replace(pattern, edges_foldAngle=out, folded_coords=None)


def _checked(
    pattern: CreasePattern, made: CreasePattern, fold_deg: float
) -> tuple[CreasePattern, list[Finding]]:
    """The pattern made, where its faces meet around holes too."""
    sheet = opened(made)
    kinematics = fold_by_angles(sheet.pattern)
    size = float(np.hypot(*np.ptp(pattern.vertices_coords, axis=0)))
    gap = kinematics.gap_mm / size
    error = max(kinematics.closure_max_rad, kinematics.gap_rad)
    if error > _CLOSED_RAD or gap > _GAP_REL:
        text = (
            "no fold with flat faces and these mountains and valleys is found: around a "
            f"hole its faces miss each other by {kinematics.gap_mm:.3g} mm and {error:.3g} rad. "
            "The fold angles stay."
        )
        return pattern, [Finding("rigid-fold-missing", Severity.WARNING, text)]
    count = int((made.edges_foldAngle != 0).sum())
    text = (
        f"{counted(count, 'fold angle')} of the rigid fold whose largest is {fold_deg:g} degrees; "
        f"around every vertex they close to {kinematics.closure_max_rad:.1e} rad."
    )
    return made, [Finding("rigid-fold", Severity.NOTE, text)]


def _not_closing(pattern: CreasePattern, creases: _Creases, angles: FloatArray) -> Finding:
    """The vertex at which the best angles that were found close worst."""
    made = _with_angles(creases.frame.sheet.pattern, creases, angles)
    gaps = np.nan_to_num(vertices_closure_rad(made))
    text = "no fold with flat faces and these mountains and valleys is found: "
    if gaps.max() > _CLOSED_RAD:
        worst = int(creases.frame.sheet.vertices_source[gaps.argmax()])
        x, y = pattern.vertices_coords[worst]
        text += (
            f"its creases close worst around vertex {worst} at ({x:.6g}, {y:.6g}) mm, by "
            f"{np.degrees(gaps.max()):.3g} degrees. "
        )
    else:
        text += "the letters do not suit each other. "
    text += "The fold angles stay."
    return Finding("rigid-fold-missing", Severity.WARNING, text)
