"""Folded states of a sheet with rigid faces: flat, between, and at its target."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from fab.errors import Finding, Severity
from fab.folding.bar_hinge_model import Framework, framework
from fab.folding.fold_settings import FoldSettings
from fab.folding.folding_path import hinges_around
from fab.folding.rigid_motion import RigidVerdict, rigid_motion
from fab.folding.rigid_states import rigid_coords
from fab.folding.rotation_predictor import rotation_predictor
from fab.folding.simulation import fold_and_judge
from fab.folding.target_forms import target_form
from fab.folding.verdict import folded_form
from fab.pattern.crease_pattern import FLAT_ANGLE_DEG, CreasePattern
from fab.pattern.face_poses import bend_mm, face_poses
from fab.pattern.kinematics import unknown_angles
from fab.progress import Progress, silent
from solver.errors import require_count
from solver.vectors import FloatArray, IntArray, cross, dot, unit

__all__ = [
    "SOFT",
    "FoldedState",
    "Stage",
    "flat_panels",
    "folded_states",
    "known_target",
    "panels_at",
    "share_of",
    "states_within",
    "with_free_angles",
]

# A sheet that folds by a smaller share of its angles with all faces flat does not fold rigidly.
_LEAST_SHARE = 0.01
_NOT_RIGID = Finding(
    "panels-lock",
    Severity.WARNING,
    "with flat faces the sheet does not leave the flat state: paper bends its way to the target, "
    "rigid panels reach it only if their hinges give. Choose a pattern that folds with flat faces.",
)
# Creases this much softer than faces leave the faces nearly plane wherever the pattern allows it:
# corners are 20 to 50 times nearer to rigid faces than with the stiffness of paper, which a job's
# own simulation has. So the two are different folds, and a job may need both. What panels run into
# is checked by their bodies.
SOFT = FoldSettings(crease=0.01, contact=False)
# Rigid faces miss their places by less than this share of the sheet.
_BENT_REL = 1e-9
# Faces that bend by less are flat.
_BENT_MM = 1e-3
# Accuracy of the fold angles of states.
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
    angles_deg : shape (ne,), fold angles between the faces; 0 for edges without two faces.
    bend_mm : largest distance of a corner of a rigid face from that of the bent one.
    sought : whether it was sought for its share (`fab.folding.last_states`).
    """

    stage: Stage
    share: float
    turns: FloatArray
    shifts: FloatArray
    angles_deg: FloatArray
    bend_mm: float
    sought: bool = False

    @property
    def name(self) -> str:
        """Such as "flat", "at 40 % of the fold" and "at the target"."""
        if self.stage == Stage.FLAT:
            return "flat"
        if self.stage == Stage.TARGET and self.share == 1:
            return "at the target"
        percent = 100 * self.share
        if self.sought:
            return f"at {percent:.4g} % of the fold"
        # two digits distinguish the states of a sheet that hardly folds until it snaps
        return f"at {percent:{'.2g' if percent < 9.5 else '.0f'}} % of the fold"


def flat_panels(pattern: CreasePattern) -> FoldedState:
    """The flat state of a pattern."""
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
    """The state whose rigid faces are nearest to a folded form, by least squares of each.

    Parameters
    ----------
    coords : shape (nv, 3), mm, of the vertices of `sheet`.
    share : as in `FoldedState`.
    sheet : the pattern with its cuts open (`fab.pattern.open_cuts`), which has the same faces; the
        pattern itself where left out.
    """
    sheet = pattern if sheet is None else sheet
    turns, shifts = face_poses(sheet, coords)
    bend = bend_mm(sheet, coords, (turns, shifts))
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

    A state that was sought and bends its faces is no target: how they bend there is less certain
    than in the simulated one before it. A state is beyond the limit where a crease between two of
    `faces` folds by more than limit_deg; the creases are those of the first such state, shape (k,):
    none where all states are within.
    """
    chosen = np.zeros(pattern.face_count + 1, bool)  # the last one for borders
    chosen[faces] = True
    creases = (pattern.edges_assignment != "C") & chosen[pattern.edges_faces].all(axis=1)
    over = [creases & (np.abs(s.angles_deg) > limit_deg + _ANGLE_DEG) for s in states]
    first = next((k for k, beyond in enumerate(over) if beyond.any()), None)
    if first is None:
        return list(states), np.empty(0, np.int64)
    kept = list(states[:first])
    uncertain = bool(kept) and kept[-1].sought and kept[-1].bend_mm > _BENT_MM
    last = len(kept) - (2 if uncertain else 1)
    if last >= 0 and kept[last].stage == Stage.BETWEEN:
        kept[last] = replace(kept[last], stage=Stage.TARGET)
    return kept, np.flatnonzero(over[first])


def folded_states(
    pattern: CreasePattern,
    count: int = 8,
    progress: Progress = silent,
) -> tuple[list[FoldedState], list[Finding]]:
    """The flat state, `count` states of a simulated fold between, and the target.

    A pattern with one rigid motion from flat to its target has the states of that motion. The fold
    of others is simulated with soft creases, so that faces stay as plane as the pattern allows. The
    target is the pattern's own folded form, or that of its angles where they close, or what it
    folds to where that has the right angles. Without any of these, the end of the fold is a state
    between. A pattern in which nothing folds has the flat state alone.

    Raises `InvalidValue` where a face has no area, and for a negative count.
    """
    require_count("count", count, 0, "Check no states between flat and the target, or more.")
    states = [flat_panels(pattern)]
    if not (np.abs(pattern.edges_foldAngle) > FLAT_ANGLE_DEG).any():
        return states, []
    rigid = _rigid(pattern, count)
    if rigid is not None:
        return [*states, *rigid], []
    settings = SOFT.model_copy(update={"steps": count + 1})
    folding, verdict, _ = fold_and_judge(pattern, settings, progress=progress)
    frame, target = folding.frame, folded_form(folding, verdict)
    inner = folding.states[1:] if target is None else folding.states[1:-1]
    between = _between(pattern, frame, [state.coords for state in inner])
    states += between
    if target is not None:
        coords = target * frame.size_mm
        states.append(panels_at(pattern, coords, Stage.TARGET, 1.0, frame.sheet.pattern))
    findings = [] if verdict.reached else [_unreached(target is not None)]
    if between and max(state.share for state in between) < _LEAST_SHARE:
        findings.append(_NOT_RIGID)
    return states, findings


def _rigid(pattern: CreasePattern, count: int) -> list[FoldedState] | None:
    """States of the only rigid motion, from that after the flat one; None where it is not one."""
    motion = rigid_motion(pattern)
    freedom = motion.freedom
    if motion.verdict is not RigidVerdict.FOLDS or freedom is None or freedom.count != 1:
        return None
    frame = motion.creases.frame
    predictor, form = rotation_predictor(frame), target_form(frame)
    states = []
    for angles in motion.stations(count + 1)[1:-1]:
        coords = predictor.coords(motion.creases.spread(angles)) * frame.size_mm
        made = panels_at(pattern, coords, Stage.BETWEEN, 1.0, frame.sheet.pattern)
        if made.bend_mm > _BENT_REL * frame.size_mm:
            return None  # faces do not meet around a hole
        states.append(replace(made, share=share_of(pattern, made)))
    if form is None:
        return None
    sheet = frame.sheet.pattern
    return [*states, panels_at(pattern, form * frame.size_mm, Stage.TARGET, 1.0, sheet)]


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
    pattern: CreasePattern, frame: Framework, between: Sequence[FloatArray]
) -> list[FoldedState]:
    """States of a simulated fold; between : shapes (nv, 3), relative to the framework's size.

    Where the simulation bends faces, the rigid state nearby takes its place, if there is one.
    """
    closure, predictor = hinges_around(frame), rotation_predictor(frame)

    def state(coords: FloatArray) -> FoldedState:
        made = panels_at(pattern, coords * frame.size_mm, Stage.BETWEEN, 1.0, frame.sheet.pattern)
        return replace(made, share=share_of(pattern, made))

    out = []
    for coords in between:
        bent = state(coords)
        flat = rigid_coords(frame, closure, predictor, coords)
        rigid = bent if flat is None else state(flat)
        out.append(rigid if rigid.bend_mm < bent.bend_mm else bent)
    return out


def share_of(pattern: CreasePattern, state: FoldedState) -> float:
    """The share of all fold angles that a state has: creases may lag behind what drives them."""
    target = pattern.edges_foldAngle
    creases = (np.abs(target) > FLAT_ANGLE_DEG) & (pattern.edges_assignment != "C")
    angles = np.clip(state.angles_deg[creases] * np.sign(target[creases]), 0, None)
    return float(min(angles.sum() / np.abs(target[creases]).sum(), 1.0))


def _unreached(known: bool) -> Finding:
    if known:
        text = (
            "the simulated fold does not end at the target, so the real sheet may not pass through "
            "the states that are checked between flat and the target; the target itself is exact."
        )
    else:
        text = (
            "no folded form is known and the simulated fold does not reach the fold angles: panels "
            "are checked flat and in the states of that fold, not at a target. Give a pattern "
            "whose angles close, or one with its folded form."
        )
    severity = Severity.NOTE if known else Severity.WARNING
    return Finding("target-not-reached", severity, text)


def _angles_deg(pattern: CreasePattern, turns: FloatArray) -> FloatArray:
    """Fold angles of rotated faces, valley positive, shape (ne,)."""
    out = np.zeros(len(pattern.edges_vertices))
    faces, others = pattern.edges_faces.T
    shared = np.flatnonzero((others >= 0) & (faces != others))
    start, end = pattern.vertices_coords[pattern.edges_vertices[shared]].swapaxes(0, 1)
    first, second = turns[faces[shared]], turns[others[shared]]
    u = unit(np.squeeze((first + second)[:, :, :2] @ (end - start)[:, :, None], axis=2))
    n1, n2 = first[:, :, 2], second[:, :, 2]
    out[shared] = np.degrees(np.arctan2(dot(cross(n2, n1), u), dot(n1, n2)))
    return out
