"""Fold angles of a rigid fold: those that all creases have when the one that folds most is at a
given angle, while all faces stay flat.

The states of a rigid fold are the angles that close around every vertex (belcastro and Hull 2002).
From a state with the signs of the letters they are followed back to flat, and from there to the
angle that is asked for, along the steepest rise of the sum of all angles (or, where that ends, of
the sum of their squares); every station is brought back to closure by Newton's method.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fab.errors import Finding, Severity, counted
from fab.folding.bar_hinge_model import framework
from fab.folding.rigid_creases import (
    CLOSED_RAD,
    EXACT_RAD,
    NEARLY_FLAT_RAD,
    RigidCreases,
    beginning,
    closed,
    direction,
    rigid_creases,
    stepped,
)
from fab.pattern.crease_pattern import CreasePattern
from fab.pattern.kinematics import fold_by_angles, vertices_closure_rad
from fab.pattern.open_cuts import opened
from solver.errors import InvalidValue
from solver.vectors import FloatArray

__all__ = ["rigid_angles"]

# From station to station no crease turns by more.
_STRIDE_RAD = np.radians(4.0)
_LEAST_STRIDE_RAD = np.radians(0.01)
_MOST_STATIONS = 400
_FULL_DEG = 180.0
# Of the sheet: the places that its faces give to a vertex beside a hole.
_GAP_REL = 1e-9


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
    creases = rigid_creases(framework(replace(pattern, folded_coords=None)))
    if not creases.signs.any():
        text = "no mountain or valley says how the sheet folds: its fold angles stay."
        return pattern, [Finding("rigid-fold-missing", Severity.WARNING, text)]
    begin, nearest = beginning(creases)
    if begin is None:
        return pattern, [_not_closing(pattern, creases, nearest)]
    flat = _unfolded(creases, begin)
    largest = float(np.abs(flat).max())
    if largest > NEARLY_FLAT_RAD:
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


def _unfolded(creases: RigidCreases, angles: FloatArray) -> FloatArray:
    """The state at which a motion ends on which all creases unfold in proportion.

    No crease of it is at more than a degree where it leads to the flat sheet.
    """
    stride = _STRIDE_RAD
    for _ in range(_MOST_STATIONS):
        largest = np.abs(angles).max()
        if largest <= NEARLY_FLAT_RAD:
            break
        # creases fold in proportion near the flat state, whichever way it is left
        fall = direction(creases, angles, -angles)
        if fall is None:
            break
        found = stepped(creases, angles, min(stride, largest / 2) * fall)
        stride = stride / 2 if found is None else min(2 * stride, _STRIDE_RAD)
        angles = angles if found is None else found
        if stride < _LEAST_STRIDE_RAD:
            break
    return angles


def _folded(
    creases: RigidCreases, angles: FloatArray, goal_rad: float, *, evenly: bool
) -> tuple[FloatArray, bool]:
    """The state ahead whose largest angle is the goal, and whether it is reached.

    evenly : whether all creases are driven alike, or in proportion to their angles.
    """
    stride = _STRIDE_RAD
    for _ in range(_MOST_STATIONS):
        alike = np.where(creases.signs, creases.signs, np.sign(angles))
        rise = direction(creases, angles, alike if evenly else angles)
        if rise is None:
            break
        ahead = angles + stride * rise
        if np.abs(ahead).max() >= goal_rad:
            end = _ended(creases, angles, ahead, goal_rad)
            if end is not None:
                return end, True
        found = stepped(creases, angles, stride * rise)
        stride = stride / 2 if found is None else min(2 * stride, _STRIDE_RAD)
        angles = angles if found is None else found
        if stride < _LEAST_STRIDE_RAD:
            break
    return angles, False


def _ended(
    creases: RigidCreases, angles: FloatArray, ahead: FloatArray, goal_rad: float
) -> FloatArray | None:
    """The state between two stations whose largest angle is the goal; None where none closes."""
    held = int(np.abs(ahead).argmax())
    for _ in range(len(ahead)):
        share = (goal_rad - np.abs(angles[held])) / (np.abs(ahead[held]) - np.abs(angles[held]))
        begin = angles + share * (ahead - angles)
        begin[held] = np.sign(begin[held]) * goal_rad
        folded = np.where(np.abs(begin) > np.pi - _STRIDE_RAD / 2, np.copysign(np.pi, begin), begin)
        if goal_rad == np.pi and creases.gap(folded) <= EXACT_RAD:
            return np.asarray(folded)  # flat, where Newton's method would be slow
        found = closed(creases, begin, held)
        if creases.gap(found) > CLOSED_RAD or not creases.allow(found):
            return None
        largest = int(np.abs(found).argmax())
        if np.abs(found[largest]) <= goal_rad + CLOSED_RAD:
            return found
        held = largest
    return None


def _with_angles(
    pattern: CreasePattern, creases: RigidCreases, angles: FloatArray
) -> CreasePattern:
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
    if error > CLOSED_RAD or gap > _GAP_REL:
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


def _not_closing(pattern: CreasePattern, creases: RigidCreases, angles: FloatArray) -> Finding:
    """The vertex at which the best angles that were found close worst."""
    made = _with_angles(creases.frame.sheet.pattern, creases, angles)
    gaps = np.nan_to_num(vertices_closure_rad(made))
    text = "no fold with flat faces and these mountains and valleys is found: "
    if gaps.max() > CLOSED_RAD:
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
