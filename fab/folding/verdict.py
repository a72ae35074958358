"""Verdict on a simulated fold: whether it reached its target, and what is wrong where it did not.

Low strain alone proves nothing: a sheet may rest unstrained in another shape. Shape and every
crease's angle are judged.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fab.errors import Finding, Severity, counted, first_few
from fab.folding.bar_hinge_model import Framework
from fab.folding.contact.contact_fold import REACH_LAST
from fab.folding.contact.stops import Stop
from fab.folding.misplaced_vertices import Misplaced, OpenVertex
from fab.folding.quasi_static import Folding, FoldState
from fab.folding.target_forms import distance_rel, target_form
from fab.folding.tolerance import Tolerance
from fab.pattern.crease_pattern import FLAT_ANGLE_DEG
from fab.pattern.kinematics import unknown_angles
from solver.self_intersection import crossing_faces
from solver.vectors import FloatArray, IntArray

__all__ = [
    "ANOTHER_PATH",
    "NEARLY_DEG",
    "PathPoint",
    "Verdict",
    "enough_deg",
    "findings_of",
    "folded_form",
    "judge",
]

_DEFAULT = Tolerance()
# A fold that misses by less nearly gets there.
NEARLY_DEG = 2.0
# Why a sheet does not reach its target, where nothing else is known.
ANOTHER_PATH = "Its angles close, so there may be another path to the target: take more steps."
# A text names up to this many vertices.
_SHOWN = 5
# Faces around a vertex stay flat where at least this many creases fold, which are not all in one
# straight line.
_FEWEST = 4


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
    reached : whether shape, strain and every crease's angle are those of the target, and the angles
        close.
    rmsd_rel : root mean square distance to the target form, aligned without mirroring, relative to
        the diagonal of its box; None where no target form is known.
    strain_mean, strain_max : absolute, of all bars, at the end.
    facet_bending_max_deg : largest angle by which a face is bent, at the end.
    wrong_creases : edges that end on the wrong side of flat.
    off_creases : edges whose angle is off by over the tolerance, 0.1 degrees and the room that
        layers in contact take, worst first.
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
    stopped : where contact stops the sheet; None where it does not, or was not looked at.
    layers_rel : how far layers that touch at the end are apart, relative to the sheet's diagonal; 0
        without contact.
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
    stopped: Stop | None = None
    layers_rel: float = 0.0

    def closes(self, tolerance: Tolerance) -> bool:
        """Whether the rotations around its vertices and holes close, as far as angles are known."""
        return self.closure_max_rad <= tolerance.closure_rad

    @property
    def in_local_minimum(self) -> bool:
        """Whether the fold got stuck: creases are off their angles, though all are known and close.

        Angles that close have a state without energy, so the one that was found is a local minimum.
        """
        closes = self.closes(_DEFAULT) and self.gap_rel <= _DEFAULT.shape_rel
        return bool(self.off_creases) and not self.free and closes

    def report(self) -> dict[str, Any]:
        """As JSON values: the first 20 creases or vertices of each list, and KEY_count for all."""
        out = dataclasses.asdict(self)
        for key in ("wrong_creases", "off_creases", "open_vertices"):
            out[f"{key}_count"] = len(out[key])
            out[key] = first_few(out[key])
        return out


def judge(folding: Folding, tolerance: Tolerance = _DEFAULT) -> Verdict:
    """Judge a fold against its pattern's angles and folded form (`target_form`).

    Layers that are in contact at its end take room: they are allowed for (`Tolerance.with_layers`).
    """
    frame = folding.frame
    allowed = tolerance.with_layers(folding.layers_rel)
    sheet, kinematics = frame.sheet, frame.kinematics
    last = folding.states[-1]
    creases, off_deg = _crease_errors(frame, last.coords)
    target_deg = sheet.pattern.edges_foldAngle[creases]
    folds = np.abs(target_deg) > FLAT_ANGLE_DEG
    wrong = creases[folds & (np.sign(target_deg + off_deg) != np.sign(target_deg))]
    worst = float(np.abs(off_deg).max(initial=0.0))
    within = np.abs(off_deg) <= allowed.creases_deg(target_deg)
    rmsd = distance_rel(frame, last.coords, target_form(frame, tolerance))
    peak = max(folding.states, key=lambda state: state.strain_peak)
    reached = bool(within.all()) and last.strain_max <= allowed.strain
    reached = reached and (rmsd or 0.0) <= allowed.shape_rel
    closure_rad = max(kinematics.closure_max_rad, kinematics.gap_rad)
    reached = reached and closure_rad <= allowed.closure_rad
    open_vertices = _worst_first(kinematics.vertices_closure_rad, tolerance.closure_rad)
    return Verdict(
        reached and last.settled,
        rmsd,
        last.strain_mean,
        last.strain_max,
        _facet_bending_deg(frame, last.coords),
        _numbers(sheet.edges_source[wrong]),
        _numbers(
            sheet.edges_source[creases[_worst_first(np.where(within, 0.0, np.abs(off_deg)), 0.0)]]
        ),
        worst,
        closure_rad,
        _numbers(sheet.vertices_source[open_vertices]),
        kinematics.gap_mm / frame.size_mm,
        int(folds.sum()),
        int(unknown_angles(sheet.pattern)[frame.hinges_edge[frame.hinges_edge >= 0]].sum()),
        peak.strain_peak,
        peak.load,
        folding.iterations,
        folding.in_turn,
        tuple(_path_point(frame, state) for state in folding.states),
        folding.stopped,
        folding.layers_rel,
    )


def folded_form(
    folding: Folding, verdict: Verdict, tolerance: Tolerance = _DEFAULT
) -> FloatArray | None:
    """The folded form of a sheet, shape (nv, 3), relative to the framework's size.

    Its `target_form`, or the end of a fold that reached the target angles; None otherwise.
    """
    form = target_form(folding.frame, tolerance)
    return folding.states[-1].coords if form is None and verdict.reached else form


def findings_of(
    verdict: Verdict,
    tolerance: Tolerance = _DEFAULT,
    misplaced: Sequence[Misplaced] = (),
    worst: OpenVertex | None = None,
) -> list[Finding]:
    """What a user should know of a verdict.

    tolerance : that of the verdict. misplaced : those of its open vertices that are off their
    places (`misplaced_vertices`). worst : the one that misses most (`open_vertex`).
    """
    found = [
        _target_not_reached(verdict, tolerance, misplaced),
        _nothing_to_fold(verdict),
        _creases_free(verdict),
        _angles_do_not_close(verdict, misplaced, worst),
        _folds_in_turn(verdict),
        _crosses_on_the_way(verdict),
        _strained_on_the_way(verdict, tolerance),
    ]
    return [finding for finding in found if finding is not None]


def _target_not_reached(
    verdict: Verdict, tolerance: Tolerance, misplaced: Sequence[Misplaced]
) -> Finding | None:
    if verdict.reached:
        return None
    text = (
        "the sheet does not fold to its target: "
        f"{counted(len(verdict.wrong_creases), 'crease')} on the wrong side, "
        f"{len(verdict.off_creases)} off by over {tolerance.angle_deg:g} degrees"
        f"{' and the room of layers' if verdict.layers_rel else ''} (at most "
        f"{verdict.angle_error_max_deg:.3g}), strain up to {verdict.strain_max:.2%}"
    )
    if verdict.rmsd_rel is not None:
        text += f", shape off by {verdict.rmsd_rel:.2e} of the diagonal"
    text += ". " if verdict.path[-1].settled else "; it did not come to rest. "
    text += _cause(verdict, tolerance, misplaced)
    return Finding("target-not-reached", Severity.ERROR, text, first_few(verdict.off_creases))


def _cause(verdict: Verdict, tolerance: Tolerance, misplaced: Sequence[Misplaced]) -> str:
    """Why a sheet does not reach its target, as far as the verdict shows it."""
    if not (verdict.closes(tolerance) or verdict.open_vertices):
        return f"Its angles miss each other by {verdict.closure_max_rad:.3g} rad around a hole."
    if misplaced and len(misplaced) == len(verdict.open_vertices):
        flat = all(each.kawasaki_deg is not None for each in misplaced)
        cause = "Its angles are right, but vertices are"
        if not flat:
            cause = "Its angles close but for vertices that are"
        off = max(each.distance_mm for each in misplaced)
        enough = enough_deg(verdict)
        cure = f"--tolerance-deg {enough:g} accepts that" if enough <= NEARLY_DEG else "move them"
        return f"{cause} off by up to about {off:.2g} mm: {cure}."
    if verdict.open_vertices:
        return f"Its angles do not close around {_open_vertices(verdict)}: see angles-do-not-close."
    if verdict.free:
        return (
            f"{_free_creases(verdict)}, U without an angle or slits: give those that fold M or V "
            "and an angle."
        )
    if verdict.gap_rel > tolerance.shape_rel:
        return f"Its faces miss each other by {verdict.gap_rel:.2%} of the diagonal around a hole."
    if verdict.stopped is not None:
        return "Its angles close, but its faces keep it from them: see stopped-by-contact."
    if verdict.layers_rel > REACH_LAST:
        return "Its angles close, but its layers take too much room: try a lower thickness_mm."
    return ANOTHER_PATH


def enough_deg(verdict: Verdict) -> float:
    """The tolerance with which a fold is at its target, its first digit rounded up."""
    default = _DEFAULT.angle_deg
    share = max(
        verdict.angle_error_max_deg / default,
        (verdict.rmsd_rel or 0.0) / _DEFAULT.shape_rel,
        verdict.strain_max / _DEFAULT.strain,
        verdict.closure_max_rad / _DEFAULT.closure_rad,
    )
    digit = 10.0 ** np.floor(np.log10(share * default))
    return float(np.ceil(share * default / digit) * digit)


def _nothing_to_fold(verdict: Verdict) -> Finding | None:
    if verdict.driven:
        return None
    text = "no crease has an angle other than 0: the sheet stays flat."
    if verdict.free:
        text += f" {_free_creases(verdict)}, U without an angle or slits: give letters M and V."
    return Finding("nothing-to-fold", Severity.WARNING, text)


def _creases_free(verdict: Verdict) -> Finding | None:
    if not (verdict.driven and verdict.reached and verdict.free):
        return None
    text = f"{_free_creases(verdict)}: U without an angle, or slits."
    return Finding("creases-free", Severity.NOTE, text)


def _angles_do_not_close(
    verdict: Verdict, misplaced: Sequence[Misplaced], worst: OpenVertex | None
) -> Finding | None:
    count = len(verdict.open_vertices)
    if not count:
        return None
    text = (
        f"the fold angles do not close around {_open_vertices(verdict)}: by up to "
        f"{verdict.closure_max_rad:.3g} rad."
    )
    if len(misplaced) < count:
        text += f" {_why_open(count, worst)}"
    if misplaced:
        text += _nearest_move(misplaced)
    return Finding("angles-do-not-close", Severity.ERROR, text)


def _open_vertices(verdict: Verdict) -> str:
    """Such as "vertex 7", or "6 vertices (first 7, 2, 3, 4, 5)"."""
    count = len(verdict.open_vertices)
    if count == 1:
        return f"vertex {verdict.open_vertices[0]}"
    first = ", ".join(map(str, verdict.open_vertices[:_SHOWN]))
    return f"{count} vertices ({'first ' if count > _SHOWN else ''}{first})"


def _why_open(count: int, worst: OpenVertex | None) -> str:
    """Why vertices that are at their places do not close: of several, the one that misses most."""
    angles = "give --rigid and --fold-deg for angles that close."
    if worst is None:
        their = "its" if count == 1 else "their"
        return f"One of {their} creases has a wrong angle: correct it, or {angles}"
    where = f"vertex {worst.vertex}"
    if worst.creases < _FEWEST:
        folds = f"{counted(worst.creases, 'crease')} {'folds' if worst.creases == 1 else 'fold'}"
        return (
            f"Only {folds} at {where}: faces around a vertex stay flat where {_FEWEST} or more "
            "fold, or 2 in one straight line, by one angle. Draw what is missing, or let it stay "
            "flat (F)."
        )
    if worst.flat and worst.kawasaki_deg is None:
        return (
            f"{worst.creases} creases fold by 180 degrees at {where}: flat-folded it has an even "
            f"number of them. Draw the missing one, or {angles}"
        )
    if worst.kawasaki_deg is not None:
        return (
            f"All creases fold by 180 degrees at {where}, but the sectors between them miss "
            f"Kawasaki's condition by {worst.kawasaki_deg:.2g} degrees: turn one of them in the "
            f"sheet by half of that, or {angles}"
        )
    return f"A crease of {where} has a wrong angle: correct it, or {angles}"


def _nearest_move(misplaced: Sequence[Misplaced]) -> str:
    """Which move of vertices makes their angles close."""
    worst = max(misplaced, key=lambda each: each.distance_mm)
    moved = sum(each.distance_mm > 0 for each in misplaced)
    own = "" if len(misplaced) == 1 else f" of vertex {worst.vertex}"
    if worst.kawasaki_deg is not None:
        return (
            f" Creases{own} that fold by 180 degrees are right, but the sectors between them miss "
            f"Kawasaki's condition by {worst.kawasaki_deg:.2g} degrees: the vertex is about "
            f"{worst.distance_mm:.2g} mm off."
        )
    if moved == 1:
        return f" They close where vertex {worst.vertex} moves by {worst.distance_mm:.2g} mm."
    return (
        f" They close where {moved} vertices move by up to {worst.distance_mm:.2g} mm (vertex "
        f"{worst.vertex})."
    )


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
    first, last = (f"{load:.0%}" for load in (crossing[0], crossing[-1]))
    where = f"at {first}" if first == last else f"from {first} to {last}"
    text = (
        f"faces pass through each other {where} of the "
        "fold, which is without contact. Paper would have to be folded in another order."
    )
    severity = Severity.WARNING if verdict.path[-1].crossings else Severity.NOTE
    return Finding("crosses-on-the-way", severity, text)


def _strained_on_the_way(verdict: Verdict, tolerance: Tolerance) -> Finding | None:
    if verdict.peak_strain <= tolerance.strain:
        return None
    text = (
        f"on the way, at {verdict.peak_strain_load:.0%}, the sheet is strained by up to "
        f"{verdict.peak_strain:.2%}: it snaps, or its faces bend."
    )
    return Finding("strained-on-the-way", Severity.NOTE, text)


def _free_creases(verdict: Verdict) -> str:
    """Such as "1 crease turns freely"."""
    return f"{counted(verdict.free, 'crease')} {'turns' if verdict.free == 1 else 'turn'} freely"


def _crease_errors(frame: Framework, coords: FloatArray) -> tuple[IntArray, FloatArray]:
    """Creases that are driven, and by how many degrees each is off its target, shapes (k,)."""
    driven = np.flatnonzero((frame.hinges_edge >= 0) & (frame.hinges_stiffness > 0))
    off = frame.angles_near(coords, frame.hinges_target) - frame.hinges_target
    return frame.hinges_edge[driven], np.degrees(off[driven])


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
