"""Did the sheet fold to its target, and if not, which creases and vertices stand in the way?

Low strain alone proves nothing: a sheet may rest unstrained in another shape. Shape and every
crease's angle are judged.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np

from fab.errors import Finding, Severity
from fab.folding.bar_hinge_model import Framework
from fab.folding.quasi_static import Folding, aligned
from fab.pattern.crease_pattern import FLAT_ANGLE_DEG
from fab.pattern.kinematics import Kinematics, fold_by_angles, unknown_angles
from fab.pattern.self_intersection import crossing_faces
from solver.vectors import FloatArray, IntArray, norm

__all__ = ["PathPoint", "Verdict", "findings_of", "judge", "target_form"]

# Off by more, a crease, or the shape over the diagonal, or a bar over its length, is not there:
# files whose angles have four digits behind the point are, those with a wrong crease are not.
_ANGLE_DEG = 0.1
_SHAPE_REL = 1e-4
_STRAIN = 1e-4
# Turns around a vertex that miss the identity by more do not close.
_CLOSURE_RAD = 1e-3
_NAMED = 20


@dataclass(frozen=True)
class PathPoint:
    """One state of a fold.

    load : share of the target angles. energy_bars, energy_hinges : see `fab.framework`.
    strain_mean, strain_max : over all bars. crossings : pairs of faces that pass through each
    other. settled : whether it came to rest.
    """

    load: float
    energy_bars: float
    energy_hinges: float
    strain_mean: float
    strain_max: float
    crossings: int
    settled: bool


@dataclass(frozen=True)
class Verdict:
    """What a folding simulation says of a pattern.

    Attributes
    ----------
    reached : shape, strain and every crease's angle are those of the target.
    rmsd_rel : root of the mean square distance to the target form, aligned without mirroring, over
        the diagonal of its box; None where no target form is known.
    strain_mean, strain_max : sizes over all bars, at the end.
    facet_bending_max_deg : largest angle by which a face is bent, at the end.
    wrong_creases : edges that end on the wrong side of flat; off_creases : those whose angle is off
        by over 0.1 degrees, worst first; angle_error_max_deg : the largest.
    closure_max_rad : by how much the turns around a vertex or hole miss the identity at most;
        open_vertices : where they do not close, worst first.
    gap_rel : how far the places that faces give to a vertex lie from it at most, by the angles
        alone, over the diagonal of the sheet. Large at free creases, and where angles do not close.
    driven : number of creases that fold; free : number of creases that nothing drives, those of
        unknown angle and slits of one edge.
    peak_strain, peak_strain_load : the largest strain on the way, and the state up to which.
    iterations : linear systems solved.
    in_turn : whether the creases were driven in turn, since all at once they lock.
    path : all states, the flat one first.
    """

    reached: bool
    rmsd_rel: float | None
    strain_mean: float
    strain_max: float
    facet_bending_max_deg: float
    wrong_creases: tuple[int, ...]
    off_creases: tuple[int, ...]
    angle_error_max_deg: float
    closure_max_rad: float
    open_vertices: tuple[int, ...]
    gap_rel: float
    driven: int
    free: int
    peak_strain: float
    peak_strain_load: float
    iterations: int
    in_turn: bool
    path: tuple[PathPoint, ...]

    @property
    def locked(self) -> bool:
        """Whether creases are not at their angles although all of these are known and close."""
        closes = self.closure_max_rad <= _CLOSURE_RAD and self.gap_rel <= _SHAPE_REL
        return bool(self.off_creases) and not self.free and closes

    def report(self) -> dict[str, Any]:
        """As JSON values; lists of creases and vertices hold the first twenty, and their number."""
        out = dataclasses.asdict(self)
        for key in ("wrong_creases", "off_creases", "open_vertices"):
            out[f"{key}_count"] = len(out[key])
            out[key] = out[key][:_NAMED]
        return out


def judge(folding: Folding) -> Verdict:
    """Judge a fold against its pattern's angles and folded form.

    The folded form is the pattern's own, or that of its angles where they close.
    """
    frame = folding.frame
    sheet = frame.sheet
    last = folding.states[-1]
    kinematics = fold_by_angles(sheet.pattern)
    creases, error = _crease_errors(frame, last.coords)
    wanted = sheet.pattern.edges_foldAngle[creases]
    found = wanted + error
    folds = np.abs(wanted) > FLAT_ANGLE_DEG
    wrong = creases[folds & (np.sign(found) != np.sign(wanted))]
    order = np.argsort(-np.abs(error), kind="stable")
    off = creases[order][np.abs(error[order]) > _ANGLE_DEG]
    worst = float(np.abs(error).max(initial=0.0))
    facets = (frame.hinges_edge < 0) & (frame.hinges_stiffness > 0)
    bending = np.abs(frame.angles_near(last.coords, frame.hinges_target)[facets])
    rmsd = _distance(frame, last.coords, _form(frame, kinematics))
    closure = kinematics.vertices_closure_rad
    bad = np.flatnonzero(closure > _CLOSURE_RAD)
    bad = bad[np.argsort(-closure[bad], kind="stable")]
    peak = max(folding.states, key=lambda state: state.strain_peak)
    reached = worst <= _ANGLE_DEG and last.strain_max <= _STRAIN and (rmsd or 0.0) <= _SHAPE_REL
    return Verdict(
        reached and last.settled,
        rmsd,
        last.strain_mean,
        last.strain_max,
        float(np.degrees(bending.max(initial=0.0))),
        _numbers(sheet.edges_source[wrong]),
        _numbers(sheet.edges_source[off]),
        worst,
        max(kinematics.closure_max_rad, kinematics.gap_rad),
        _numbers(sheet.vertices_source[bad]),
        kinematics.gap_mm / frame.size_mm,
        int(folds.sum()),
        int(unknown_angles(sheet.pattern)[frame.hinges_edge[frame.hinges_edge >= 0]].sum()),
        peak.strain_peak,
        peak.load,
        folding.iterations,
        folding.in_turn,
        tuple(
            PathPoint(
                state.load,
                state.energy.bars,
                state.energy.hinges,
                state.strain_mean,
                state.strain_max,
                len(_crossings(frame, state.coords)),
                state.settled,
            )
            for state in folding.states
        ),
    )


def target_form(frame: Framework) -> FloatArray | None:
    """The folded form that a fold is judged by, over the framework's size, shape (nv, 3).

    That of the pattern, or that of its angles; None where these do not close.
    """
    return _form(frame, fold_by_angles(frame.sheet.pattern))


def findings_of(verdict: Verdict) -> list[Finding]:
    """What a user should know of a verdict."""
    out = []
    if not verdict.reached:
        last = verdict.path[-1]
        text = (
            f"the sheet does not fold to its target: {len(verdict.wrong_creases)} creases on the "
            f"wrong side, {len(verdict.off_creases)} off by over {_ANGLE_DEG:g} degrees (at most "
            f"{verdict.angle_error_max_deg:.3g}), strain up to {verdict.strain_max:.2%}"
        )
        if verdict.rmsd_rel is not None:
            text += f", shape off by {verdict.rmsd_rel:.2e} of the diagonal"
        text += ". " if last.settled else "; it did not come to rest. "
        if verdict.closure_max_rad > _CLOSURE_RAD and not verdict.open_vertices:
            text += (
                f"Its angles miss each other by {verdict.closure_max_rad:.3g} rad around a hole."
            )
        elif verdict.open_vertices:
            text += "Its angles do not close: see open_vertices."
        elif verdict.free:
            text += (
                f"{verdict.free} creases turn freely, U without an angle or slits: give those that "
                "fold M or V and an angle."
            )
        elif verdict.gap_rel > _SHAPE_REL:
            text += (
                f"Its faces miss each other by {verdict.gap_rel:.2%} of the diagonal around a hole."
            )
        elif not verdict.off_creases and verdict.strain_max <= _STRAIN:
            text += "Its angles are right: the folded form of the file is another than theirs."
        else:
            text += "Its angles close, so that another way there may exist: take more steps."
        out.append(
            Finding("target-not-reached", Severity.ERROR, text, verdict.off_creases[:_NAMED])
        )
    if not verdict.driven:
        text = "no crease has an angle other than 0: the sheet stays flat."
        out.append(Finding("nothing-to-fold", Severity.WARNING, text))
    elif verdict.reached and verdict.free:
        text = f"{verdict.free} creases turn freely: U without an angle, or slits."
        out.append(Finding("creases-free", Severity.NOTE, text))
    if verdict.open_vertices:
        vertices = ", ".join(map(str, verdict.open_vertices[:5]))
        text = (
            f"the fold angles do not close around {len(verdict.open_vertices)} vertices (first "
            f"{vertices}): by up to {verdict.closure_max_rad:.3g} rad. One of their creases has a "
            "wrong angle."
        )
        out.append(Finding("angles-do-not-close", Severity.ERROR, text))
    if verdict.in_turn:
        text = (
            "folded all at once its creases lock: they are folded in turn, each at a rate of its "
            "own."
        )
        out.append(Finding("folds-in-turn", Severity.NOTE, text))
    crossing = [point.load for point in verdict.path if point.crossings]
    if crossing:
        ends = verdict.path[-1].crossings > 0
        text = (
            f"faces pass through each other from {crossing[0]:.0%} to {crossing[-1]:.0%} of the "
            "fold: the simulation knows no contact. Paper would have to be folded in another order."
        )
        severity = Severity.WARNING if ends else Severity.NOTE
        out.append(Finding("crosses-on-the-way", severity, text))
    if verdict.peak_strain > _STRAIN:
        text = (
            f"on the way, at {verdict.peak_strain_load:.0%}, the sheet is strained by up to "
            f"{verdict.peak_strain:.2%}: it snaps, or its faces bend."
        )
        out.append(Finding("strained-on-the-way", Severity.NOTE, text))
    return out


def _crease_errors(frame: Framework, coords: FloatArray) -> tuple[IntArray, FloatArray]:
    """Creases that are driven, and by how many degrees each is off its target."""
    driven = np.flatnonzero((frame.hinges_edge >= 0) & (frame.hinges_stiffness > 0))
    off = frame.angles_near(coords, frame.hinges_target) - frame.hinges_target
    return frame.hinges_edge[driven], np.degrees(off[driven])


def _form(frame: Framework, kinematics: Kinematics) -> FloatArray | None:
    folded = frame.sheet.pattern.folded_coords
    if folded is not None:
        return folded / frame.size_mm
    closes = max(kinematics.closure_max_rad, kinematics.gap_rad) <= _CLOSURE_RAD
    if closes and kinematics.gap_mm <= _SHAPE_REL * frame.size_mm:
        return kinematics.folded_coords / frame.size_mm
    return None


def _distance(frame: Framework, coords: FloatArray, form: FloatArray | None) -> float | None:
    """Largest over the pieces, each aligned by itself: they may lie anywhere."""
    if form is None:
        return None
    found = 0.0
    diagonal = float(norm(np.ptp(form, axis=0))) or 1.0  # that of the sheet, for a mere point
    for piece in range(int(frame.component.max()) + 1):
        own = frame.component == piece
        off = aligned(coords[own], form[own]) - form[own]
        found = max(found, float(np.sqrt((off**2).sum(axis=1).mean())) / diagonal)
    return found


def _crossings(frame: Framework, coords: FloatArray) -> IntArray:
    """Pairs of faces of which triangles cross: on the way faces are bent."""
    triangles = frame.triangles_vertices
    pairs = crossing_faces(coords, triangles.ravel(), 3 * np.arange(len(triangles) + 1))
    faces = np.sort(frame.triangles_face[pairs], axis=1)
    return np.unique(faces[faces[:, 0] != faces[:, 1]], axis=0)


def _numbers(array: IntArray) -> tuple[int, ...]:
    return tuple(dict.fromkeys(array.tolist()))
