"""In which folded states are the faces of a sheet, as rigid panels, between flat and its target?"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from fab.errors import Finding, Severity
from fab.folding.bar_hinge_model import Framework, framework
from fab.folding.fold_settings import FoldSettings
from fab.folding.folding_path import hinges_around
from fab.folding.rigid_states import rigid_coords
from fab.folding.rotation_predictor import turner
from fab.folding.simulation import simulated
from fab.folding.verdict import target_form
from fab.pattern.crease_pattern import FLAT_ANGLE_DEG, CreasePattern
from fab.pattern.face_poses import face_poses
from fab.pattern.kinematics import unknown_angles
from solver.errors import require_count
from solver.vectors import FloatArray, IntArray, cross, dot, norm, unit

__all__ = [
    "FoldedState",
    "Stage",
    "flat_panels",
    "folded_states",
    "known_target",
    "panels_at",
    "states_within",
    "with_free_angles",
]

# Sheets that fold by less of their angles with all faces flat do not fold.
_LOCKED_SHARE = 0.01
_LOCKED = Finding(
    "panels-lock",
    Severity.WARNING,
    "with flat faces the sheet does not leave the flat state: paper bends its way to the target, "
    "rigid panels reach it only if their hinges give. Choose a pattern that folds with flat faces.",
)
# Creases so much softer than faces leave these as good as plane wherever the pattern lets them be.
_CREASE_STIFFNESS = 0.01
# Fold angles of states are known to this.
_ANGLE_DEG = 1e-6


class Stage(StrEnum):
    """Which part of the fold a state belongs to."""

    FLAT = "flat"
    BETWEEN = "between"
    TARGET = "target"


@dataclass(frozen=True)
class FoldedState:
    """Where the faces of a pattern are, as rigid bodies.

    Attributes
    ----------
    stage : flat, between, or at the target.
    share : of the sum of all target fold angles, 0 to 1; creases on the wrong side count as flat.
    turns, shifts : shapes (nf, 3, 3) and (nf, 3), mm: motions x -> turn x + shift from flat.
    angles_deg : shape (ne,), fold angles between these faces; 0 where there are not two.
    bend_mm : largest distance of a corner from where the folded form has it: its faces bend.
    """

    stage: Stage
    share: float
    turns: FloatArray
    shifts: FloatArray
    angles_deg: FloatArray
    bend_mm: float

    @property
    def name(self) -> str:
        """Such as "flat", "at 40 % of the fold" and "at the target"."""
        if self.stage == Stage.FLAT:
            return "flat"
        if self.stage == Stage.TARGET and self.share == 1:
            return "at the target"
        percent = 100 * self.share
        # as many digits as tell apart the states of a sheet that hardly folds until it snaps
        return f"at {percent:{'.2g' if percent < 9.5 else '.0f'}} % of the fold"


def flat_panels(pattern: CreasePattern) -> FoldedState:
    """The flat state."""
    count = pattern.face_count
    turns = np.tile(np.eye(3), (count, 1, 1))
    angles = np.zeros(len(pattern.edges_vertices))
    return FoldedState(Stage.FLAT, 0.0, turns, np.zeros((count, 3)), angles, 0.0)


def panels_at(
    pattern: CreasePattern,
    coords: FloatArray,
    stage: Stage,
    share: float,
    sheet: CreasePattern | None = None,
) -> FoldedState:
    """The rigid faces that lie nearest to a folded form.

    coords : shape (nv, 3), mm, of the vertices of `sheet`: the pattern, or with its cuts open
    (`fab.opened`), which has the same faces.
    """
    sheet = pattern if sheet is None else sheet
    turns, shifts = face_poses(sheet, coords)
    face = np.repeat(np.arange(sheet.face_count), np.diff(sheet.faces_offsets))
    flat = sheet.vertices_coords[sheet.faces_vertices]
    placed = np.squeeze(turns[face, :, :2] @ flat[:, :, None], axis=2) + shifts[face]
    bend = float(norm(placed - coords[sheet.faces_vertices]).max(initial=0.0))
    return FoldedState(stage, share, turns, shifts, _angles_deg(pattern, turns), bend)


def known_target(pattern: CreasePattern) -> FoldedState | None:
    """The state of the pattern's folded form, or that of its angles; None where neither is known.

    Raises `InvalidValue` where a face has no area.
    """
    frame = framework(pattern, FoldSettings())
    form = target_form(frame)
    if form is None:
        return None
    return panels_at(pattern, form * frame.size_mm, Stage.TARGET, 1.0, frame.sheet.pattern)


def states_within(
    pattern: CreasePattern, faces: IntArray, states: Sequence[FoldedState], limit_deg: float
) -> tuple[list[FoldedState], IntArray]:
    """The states up to a fold limit, the last of them as the target, and the creases beyond it.

    A state is beyond it where a crease between two of some faces folds over limit_deg; the creases
    are those of the first such state, shape (k,): none where all states are within.
    """
    standing = np.zeros(pattern.face_count + 1, bool)  # the last one for borders
    standing[faces] = True
    creases = (pattern.edges_assignment != "C") & standing[pattern.edges_faces].all(axis=1)
    over = [creases & (np.abs(s.angles_deg) > limit_deg + _ANGLE_DEG) for s in states]
    first = next((k for k, beyond in enumerate(over) if beyond.any()), None)
    if first is None:
        return list(states), np.empty(0, np.int64)
    kept = list(states[:first])
    if kept and kept[-1].stage == Stage.BETWEEN:
        kept[-1] = replace(kept[-1], stage=Stage.TARGET)
    return kept, np.flatnonzero(over[first])


def folded_states(
    pattern: CreasePattern,
    count: int = 8,
    progress: Callable[[str, int, int], None] | None = None,
) -> tuple[list[FoldedState], list[Finding]]:
    """The flat state, `count` states of the simulated fold between, and the target.

    The target is the pattern's own folded form, or that of its angles where they close, or what it
    folds to where that has the right angles. Where there is none of them, the end of the fold is
    a state between. A pattern in which nothing folds has the flat state alone.

    Raises `InvalidValue` where a face has no area.
    """
    require_count("count", count, 0, "Check no states between flat and the target, or more.")
    states = [flat_panels(pattern)]
    if not (np.abs(pattern.edges_foldAngle) > FLAT_ANGLE_DEG).any():
        return states, []
    folding, verdict, _ = simulated(
        pattern, FoldSettings(steps=count + 1, crease=_CREASE_STIFFNESS), progress=progress
    )
    frame = folding.frame
    target = target_form(frame)
    if target is None and verdict.reached:
        target = folding.states[-1].coords
    way = folding.states[1:] if target is None else folding.states[1:-1]
    between = _between(pattern, frame, [state.coords for state in way])
    states += between
    if target is not None:
        coords = target * frame.size_mm
        states.append(panels_at(pattern, coords, Stage.TARGET, 1.0, frame.sheet.pattern))
    findings = [] if verdict.reached else [_unreached(target is not None)]
    if between and max(state.share for state in between) < _LOCKED_SHARE:
        findings.append(_LOCKED)
    return states, findings


def with_free_angles(pattern: CreasePattern, states: Sequence[FoldedState]) -> CreasePattern:
    """The pattern, its creases of unknown angle with the largest that they have in any state."""
    free = np.flatnonzero(unknown_angles(pattern) & (pattern.edges_assignment != "C"))
    if not len(free):
        return pattern
    angles = np.stack([state.angles_deg[free] for state in states])
    largest = np.take_along_axis(angles, np.abs(angles).argmax(axis=0)[None], axis=0)[0]
    known = pattern.edges_foldAngle.copy()
    known[free] = largest
    return replace(pattern, edges_foldAngle=known)


def _between(
    pattern: CreasePattern, frame: Framework, way: Sequence[FloatArray]
) -> list[FoldedState]:
    """States on the way, of vertices over the framework's size, shapes (nv, 3).

    Where the simulation bends faces, the state nearby is taken in which none is, if there is one.
    """
    closure, turning = hinges_around(frame), turner(frame)

    def state(coords: FloatArray) -> FoldedState:
        given = coords * frame.size_mm
        made = panels_at(pattern, given, Stage.BETWEEN, 1.0, frame.sheet.pattern)
        return replace(made, share=_share(pattern, made))

    out = []
    for coords in way:
        bent = state(coords)
        flat = rigid_coords(frame, closure, turning, coords)
        rigid = bent if flat is None else state(flat)
        out.append(rigid if rigid.bend_mm < bent.bend_mm else bent)
    return out


def _share(pattern: CreasePattern, state: FoldedState) -> float:
    """Which share of all fold angles a state has: creases may lag behind what drives them."""
    wanted = pattern.edges_foldAngle
    creases = (np.abs(wanted) > FLAT_ANGLE_DEG) & (pattern.edges_assignment != "C")
    angles = np.clip(state.angles_deg[creases] * np.sign(wanted[creases]), 0, None)
    return float(min(angles.sum() / np.abs(wanted[creases]).sum(), 1.0))


def _unreached(known: bool) -> Finding:
    if known:
        text = (
            "the simulated fold does not end at the target, so the states that are checked between "
            "flat and the target need not lie on the way of the sheet; the target itself is exact."
        )
    else:
        text = (
            "no folded form is known and the simulated fold does not reach the fold angles: panels "
            "are checked flat and on the way that it finds, not at a target. Give a pattern whose "
            "angles close, or one with its folded form."
        )
    severity = Severity.NOTE if known else Severity.WARNING
    return Finding("target-not-reached", severity, text)


def _angles_deg(pattern: CreasePattern, turns: FloatArray) -> FloatArray:
    """Fold angles by the convention of `fab.crease`, shape (ne,)."""
    out = np.zeros(len(pattern.edges_vertices))
    one, two = pattern.edges_faces.T
    shared = np.flatnonzero((two >= 0) & (one != two))
    start, end = pattern.vertices_coords[pattern.edges_vertices[shared]].swapaxes(0, 1)
    first, second = turns[one[shared]], turns[two[shared]]
    u = unit(np.squeeze((first + second)[:, :, :2] @ (end - start)[:, :, None], axis=2))
    n1, n2 = first[:, :, 2], second[:, :, 2]
    out[shared] = np.degrees(np.arctan2(dot(cross(n2, n1), u), dot(n1, n2)))
    return out
