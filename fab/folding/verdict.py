"""Verdict on a simulated fold: whether it reached its target, and what is wrong where it did not.

Low strain alone proves nothing: a sheet may rest unstrained in another shape. Shape and every
crease's angle are judged.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np

from fab.errors import Finding, Severity, first_few
from fab.folding.bar_hinge_model import Framework
from fab.folding.quasi_static import Folding, FoldState, aligned
from fab.pattern.crease_pattern import FLAT_ANGLE_DEG
from fab.pattern.kinematics import unknown_angles
from fab.pattern.self_intersection import crossing_faces
from solver.vectors import FloatArray, IntArray, norm

__all__ = ["PathPoint", "Verdict", "findings_of", "folded_form", "judge", "target_form"]

# Largest errors of a fold that has reached its target: of a crease's angle, of the shape (relative
# to its diagonal), and strain. Files with four decimals in their angles pass, a wrong crease fails.
_ANGLE_DEG = 0.1
_SHAPE_REL = 1e-4
_STRAIN = 1e-4
# A vertex closes where its rotations multiply to the identity within this angle.
_CLOSURE_RAD = 1e-3
# A text names up to this many vertices.
_SHOWN = 5


@dataclass(frozen=True)
class PathPoint:
    """One state of a fold.

    Attributes
    ----------
    load : share of the target angles, 0 to 1.
    energy_bars, energy_hinges : as in `fab.folding.bar_hinge_model.Energy`.
    strain_mean, strain_max : of all bars, absolute.
    crossings : number of pairs of faces that pass through each other.
    settled : whether the sheet came to rest.
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
    """What a folding simulation found of a pattern.

    Attributes
    ----------
    reached : whether shape, strain and every crease's angle are those of the target.
    rmsd_rel : root mean square distance to the target form, aligned without mirroring, relative to
        the diagonal of its box; None where no target form is known.
    strain_mean, strain_max : absolute, of all bars, at the end.
    facet_bending_max_deg : largest angle by which a face is bent, at the end.
    wrong_creases : edges that end on the wrong side of flat.
    off_creases : edges whose angle is off by over 0.1 degrees, worst first.
    angle_error_max_deg : largest error of an angle.
    closure_max_rad : largest angle by which the rotations around a vertex or hole miss the
        identity.
    open_vertices : vertices that do not close, worst first.
    gap_rel : largest distance of a vertex from where one of its faces has it, by the angles alone,
        relative to the diagonal of the sheet. Large at free creases, and where angles do not close.
    driven : number of creases that fold.
    free : number of creases that nothing drives: of unknown angle, and slits of one edge.
    peak_strain, peak_strain_load : the largest strain of the whole fold, and the load of the state
        up to which it occurred.
    iterations : linear systems solved, or Euler steps.
    in_turn : whether the creases were driven along a folding path, since all at once they get
        stuck.
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
    def in_local_minimum(self) -> bool:
        """Whether the fold got stuck: creases are off their angles, though all are known and close.

        Angles that close have a state without energy, so the one that was found is a local minimum.
        """
        closes = self.closure_max_rad <= _CLOSURE_RAD and self.gap_rel <= _SHAPE_REL
        return bool(self.off_creases) and not self.free and closes

    def report(self) -> dict[str, Any]:
        """As JSON values: the first 20 creases or vertices of each list, and KEY_count for all."""
        out = dataclasses.asdict(self)
        for key in ("wrong_creases", "off_creases", "open_vertices"):
            out[f"{key}_count"] = len(out[key])
            out[key] = first_few(out[key])
        return out


def judge(folding: Folding) -> Verdict:
    """Judge a fold against its pattern's angles and folded form (`target_form`)."""
    frame = folding.frame
    sheet, kinematics = frame.sheet, frame.kinematics
    last = folding.states[-1]
    creases, off_deg = _crease_errors(frame, last.coords)
    target_deg = sheet.pattern.edges_foldAngle[creases]
    folds = np.abs(target_deg) > FLAT_ANGLE_DEG
    wrong = creases[folds & (np.sign(target_deg + off_deg) != np.sign(target_deg))]
    worst = float(np.abs(off_deg).max(initial=0.0))
    rmsd = _distance(frame, last.coords, target_form(frame))
    peak = max(folding.states, key=lambda state: state.strain_peak)
    reached = worst <= _ANGLE_DEG and last.strain_max <= _STRAIN and (rmsd or 0.0) <= _SHAPE_REL
    open_vertices = _worst_first(kinematics.vertices_closure_rad, _CLOSURE_RAD)
    return Verdict(
        reached and last.settled,
        rmsd,
        last.strain_mean,
        last.strain_max,
        _facet_bending_deg(frame, last.coords),
        _numbers(sheet.edges_source[wrong]),
        _numbers(sheet.edges_source[creases[_worst_first(np.abs(off_deg), _ANGLE_DEG)]]),
        worst,
        max(kinematics.closure_max_rad, kinematics.gap_rad),
        _numbers(sheet.vertices_source[open_vertices]),
        kinematics.gap_mm / frame.size_mm,
        int(folds.sum()),
        int(unknown_angles(sheet.pattern)[frame.hinges_edge[frame.hinges_edge >= 0]].sum()),
        peak.strain_peak,
        peak.load,
        folding.iterations,
        folding.in_turn,
        tuple(_path_point(frame, state) for state in folding.states),
    )


def target_form(frame: Framework) -> FloatArray | None:
    """The folded form that a fold is judged by, shape (nv, 3), relative to the framework's size.

    That of the pattern, or that of its angles; None where the pattern has none and its angles do
    not close.
    """
    kinematics, folded = frame.kinematics, frame.sheet.pattern.folded_coords
    if folded is not None:
        return folded / frame.size_mm
    closes = max(kinematics.closure_max_rad, kinematics.gap_rad) <= _CLOSURE_RAD
    if closes and kinematics.gap_mm <= _SHAPE_REL * frame.size_mm:
        return kinematics.folded_coords / frame.size_mm
    return None


def folded_form(folding: Folding, verdict: Verdict) -> FloatArray | None:
    """The folded form of a sheet, shape (nv, 3), relative to the framework's size.

    Its `target_form`, or the end of a fold that reached the target angles; None otherwise.
    """
    form = target_form(folding.frame)
    return folding.states[-1].coords if form is None and verdict.reached else form


def findings_of(verdict: Verdict) -> list[Finding]:
    """What a user should know of a verdict."""
    found = [
        _target_not_reached(verdict),
        _nothing_to_fold(verdict),
        _creases_free(verdict),
        _angles_do_not_close(verdict),
        _folds_in_turn(verdict),
        _crosses_on_the_way(verdict),
        _strained_on_the_way(verdict),
    ]
    return [finding for finding in found if finding is not None]


def _target_not_reached(verdict: Verdict) -> Finding | None:
    if verdict.reached:
        return None
    text = (
        "the sheet does not fold to its target: "
        f"{_counted(len(verdict.wrong_creases), 'crease')} on the wrong side, "
        f"{len(verdict.off_creases)} off by over {_ANGLE_DEG:g} degrees (at most "
        f"{verdict.angle_error_max_deg:.3g}), strain up to {verdict.strain_max:.2%}"
    )
    if verdict.rmsd_rel is not None:
        text += f", shape off by {verdict.rmsd_rel:.2e} of the diagonal"
    text += ". " if verdict.path[-1].settled else "; it did not come to rest. "
    text += _cause(verdict)
    return Finding("target-not-reached", Severity.ERROR, text, first_few(verdict.off_creases))


def _cause(verdict: Verdict) -> str:
    """Why a sheet does not reach its target, as far as the verdict shows it."""
    if verdict.closure_max_rad > _CLOSURE_RAD and not verdict.open_vertices:
        return f"Its angles miss each other by {verdict.closure_max_rad:.3g} rad around a hole."
    if verdict.open_vertices:
        return "Its angles do not close: see open_vertices."
    if verdict.free:
        return (
            f"{_free_creases(verdict)}, U without an angle or slits: give those that fold M or V "
            "and an angle."
        )
    if verdict.gap_rel > _SHAPE_REL:
        return f"Its faces miss each other by {verdict.gap_rel:.2%} of the diagonal around a hole."
    if not verdict.off_creases and verdict.strain_max <= _STRAIN:
        return "Its angles are right, but the folded form in the file is not the one they give."
    return "Its angles close, so there may be another path to the target: take more steps."


def _nothing_to_fold(verdict: Verdict) -> Finding | None:
    if verdict.driven:
        return None
    text = "no crease has an angle other than 0: the sheet stays flat."
    return Finding("nothing-to-fold", Severity.WARNING, text)


def _creases_free(verdict: Verdict) -> Finding | None:
    if not (verdict.driven and verdict.reached and verdict.free):
        return None
    text = f"{_free_creases(verdict)}: U without an angle, or slits."
    return Finding("creases-free", Severity.NOTE, text)


def _angles_do_not_close(verdict: Verdict) -> Finding | None:
    count = len(verdict.open_vertices)
    if not count:
        return None
    around = f"vertex {verdict.open_vertices[0]}"
    if count > 1:
        first = ", ".join(map(str, verdict.open_vertices[:_SHOWN]))
        around = f"{count} vertices ({'first ' if count > _SHOWN else ''}{first})"
    text = (
        f"the fold angles do not close around {around}: by up to {verdict.closure_max_rad:.3g} "
        f"rad. One of {'its' if count == 1 else 'their'} creases has a wrong angle."
    )
    return Finding("angles-do-not-close", Severity.ERROR, text)


def _folds_in_turn(verdict: Verdict) -> Finding | None:
    if not verdict.in_turn:
        return None
    text = (
        "folded all at once, its creases get stuck before they reach their angles: they are folded "
        "along a path instead, each at a rate of its own."
    )
    return Finding("folds-in-turn", Severity.NOTE, text)


def _crosses_on_the_way(verdict: Verdict) -> Finding | None:
    crossing = [point.load for point in verdict.path if point.crossings]
    if not crossing:
        return None
    text = (
        f"faces pass through each other from {crossing[0]:.0%} to {crossing[-1]:.0%} of the "
        "fold: the simulation knows no contact. Paper would have to be folded in another order."
    )
    severity = Severity.WARNING if verdict.path[-1].crossings else Severity.NOTE
    return Finding("crosses-on-the-way", severity, text)


def _strained_on_the_way(verdict: Verdict) -> Finding | None:
    if verdict.peak_strain <= _STRAIN:
        return None
    text = (
        f"on the way, at {verdict.peak_strain_load:.0%}, the sheet is strained by up to "
        f"{verdict.peak_strain:.2%}: it snaps, or its faces bend."
    )
    return Finding("strained-on-the-way", Severity.NOTE, text)


def _free_creases(verdict: Verdict) -> str:
    """Such as "1 crease turns freely"."""
    return f"{_counted(verdict.free, 'crease')} {'turns' if verdict.free == 1 else 'turn'} freely"


def _counted(count: int, noun: str) -> str:
    return f"{count} {noun}{'' if count == 1 else 's'}"


def _crease_errors(frame: Framework, coords: FloatArray) -> tuple[IntArray, FloatArray]:
    """Creases that are driven, and by how many degrees each is off its target, shapes (k,)."""
    driven = np.flatnonzero((frame.hinges_edge >= 0) & (frame.hinges_stiffness > 0))
    off = frame.angles_near(coords, frame.hinges_target) - frame.hinges_target
    return frame.hinges_edge[driven], np.degrees(off[driven])


def _distance(frame: Framework, coords: FloatArray, form: FloatArray | None) -> float | None:
    """Root mean square distance to a form, relative to its diagonal; None where there is no form.

    The largest of all components of the sheet, each aligned by itself: they may lie anywhere.
    """
    if form is None:
        return None
    found = 0.0
    diagonal = float(norm(np.ptp(form, axis=0))) or 1.0  # that of the sheet, for a mere point
    for component in range(int(frame.component.max()) + 1):
        own = frame.component == component
        off = aligned(coords[own], form[own]) - form[own]
        found = max(found, float(np.sqrt((off**2).sum(axis=1).mean())) / diagonal)
    return found


def _facet_bending_deg(frame: Framework, coords: FloatArray) -> float:
    """Largest angle of a facet crease."""
    facets = (frame.hinges_edge < 0) & (frame.hinges_stiffness > 0)
    bending = np.abs(frame.angles_near(coords, frame.hinges_target)[facets])
    return float(np.degrees(bending.max(initial=0.0)))


def _worst_first(errors: FloatArray, bound: float) -> IntArray:
    """Places of the errors beyond a bound, the largest first; NaN is none."""
    beyond = np.flatnonzero(errors > bound)
    return np.asarray(beyond[np.argsort(-errors[beyond], kind="stable")], np.int64)


def _path_point(frame: Framework, state: FoldState) -> PathPoint:
    return PathPoint(
        state.load,
        state.energy.bars,
        state.energy.hinges,
        state.strain_mean,
        state.strain_max,
        len(_crossings(frame, state.coords)),
        state.settled,
    )


def _crossings(frame: Framework, coords: FloatArray) -> IntArray:
    """Pairs of faces with triangles that cross, shape (n, 2): faces may be bent."""
    triangles = frame.triangles_vertices
    pairs = crossing_faces(coords, triangles.ravel(), 3 * np.arange(len(triangles) + 1))
    faces = np.sort(frame.triangles_face[pairs], axis=1)
    return np.unique(faces[faces[:, 0] != faces[:, 1]], axis=0)


def _numbers(array: IntArray) -> tuple[int, ...]:
    """Each number once, in the order of its first place."""
    return tuple(dict.fromkeys(array.tolist()))
