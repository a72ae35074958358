"""Rigid motions: faces stay flat along them, and sheets that must bend are told apart."""

import json
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner
from flat_patterns import fan_of, grid
from helpers import PATTERNS, TEMPLATES
from relaxed_surfaces import bump
from scipy.sparse import block_diag, csc_array

from fab import read_pattern
from fab.cli.group import main
from fab.folding.bar_hinge_model import framework
from fab.folding.fold_settings import FoldSettings
from fab.folding.folded_states import Stage, folded_states
from fab.folding.freedom import freedom_of
from fab.folding.rigid_creases import rigid_creases
from fab.folding.rigid_folding import fold_rigidly
from fab.folding.rigid_motion import RigidVerdict, rigid_motion
from fab.folding.simulation import Solver
from fab.folding.verdict import judge
from fab.formats.fold.reader import read_fold
from fab.jobs.folding_files import simulate
from fab.jobs.grow import grown_pattern
from fab.jobs.job import load_job
from fab.jobs.job_files import Format, make
from fab.pattern.crease_pattern import crease_pattern, scaled
from fab.pattern.development import develop
from solver import Miura, RigidMiura
from solver.relaxation import Wishes, pleated_patch, relaxed_sheet


def pattern_of_mesh(mesh, width_mm=300.0):
    return scaled(crease_pattern(mesh, develop(mesh), 1.0), width_mm=width_mm)


def relaxed(rigid):
    """A sheet over a bump, with flat-foldable vertices or without."""
    surface = bump(0.2)
    sheet = pleated_patch(surface, 12, zigzag=1.5, spacing=1.2, thickness=1.2)
    return pattern_of_mesh(relaxed_sheet(surface, sheet, Wishes(rigid=rigid)).mesh)


@pytest.fixture(scope="module")
def rigid_sheets():
    return {
        "miura": pattern_of_mesh(Miura(columns=8, rows=6).grow().mesh),
        "rigid_miura": pattern_of_mesh(RigidMiura(columns=9, rows=8).grow().mesh),
        "relaxed": relaxed(True),
    }


@pytest.mark.parametrize("name", ["miura", "rigid_miura", "relaxed"])
def test_rigid_sheets_keep_their_faces_flat_from_flat_to_folded_flat(rigid_sheets, name):
    pattern = rigid_sheets[name]
    motion = rigid_motion(pattern)
    assert motion.verdict is RigidVerdict.FOLDS
    assert (motion.freedom.count, motion.freedom.exact) == (1, True)
    assert motion.freedom.moving.all()
    fold = fold_rigidly(framework(pattern), motion, 20, fold_flat=True)
    assert fold.bend_max_mm <= 1e-9
    verdict = judge(fold.folding)
    assert verdict.reached
    assert verdict.rmsd_rel <= 1e-12
    assert verdict.peak_strain <= 1e-11
    assert not fold.stopped
    assert len(fold.beyond) == 20
    assert np.abs(fold.angles_deg[-1]) == pytest.approx(180, abs=1e-12)
    coords = fold.beyond[-1].coords
    across = np.linalg.svd(coords - coords.mean(axis=0))[1][2]
    assert across <= 1e-12 * np.sqrt(len(coords))  # folded flat: one plane
    # half-angle tangents keep their ratios (Tachi 2009); the driving crease turns in equal steps
    driven = fold.angles_deg[:21, motion.driving]
    assert driven == pytest.approx(np.linspace(0, driven[-1], 21), abs=1e-9)
    tangents = np.tan(np.radians(fold.angles_deg[1:21]) / 2)
    ratios = tangents / tangents[:, motion.driving, None]
    assert ratios == pytest.approx(np.broadcast_to(ratios[-1], ratios.shape), rel=1e-7)


def test_the_motion_of_a_marched_sheet_is_its_closed_form(rigid_sheets):
    pattern = rigid_sheets["rigid_miura"]
    motion = rigid_motion(pattern)
    sheet = RigidMiura(columns=9, rows=8).march().sheet
    for angles in motion.stations(7)[1:]:
        along, across = sheet.fold_angles(np.abs(angles).max())
        closed_form = np.sort(np.concatenate([along.ravel(), across.ravel()]))
        assert np.sort(angles) == pytest.approx(closed_form, abs=1e-9)


@pytest.mark.parametrize("name", ["hypar_20", "paraboloid_10", "random_tube", "wave_fold"])
def test_generic_sheets_are_told_apart(name):
    """No freedom is left at their target; the nearest to one is far from rounding."""
    pattern, _ = grown_pattern(load_job(TEMPLATES / f"{name}.toml"))
    motion = rigid_motion(pattern)
    assert motion.verdict is RigidVerdict.BENDS
    assert motion.freedom.count == 0
    assert motion.freedom.least_locked > 1e-6
    assert len(motion.path) == 0
    assert motion.beyond() is None


def test_a_relaxed_sheet_without_flat_foldable_vertices_bends():
    motion = rigid_motion(relaxed(False))
    assert (motion.verdict, motion.freedom.count) == (RigidVerdict.BENDS, 0)


def test_a_sheet_beside_a_rigid_one_bends(rigid_sheets):
    """One vertex moved by a thousandth of its cell; the angles are those of the rigid sheet."""
    pattern = rigid_sheets["miura"]
    inner = np.setdiff1d(
        np.arange(len(pattern.vertices_coords)),
        pattern.edges_vertices[pattern.edges_faces[:, 1] < 0],
    )
    coords = pattern.vertices_coords.copy()
    coords[inner[7]] += [0.03, 0.01]
    moved = replace(pattern, vertices_coords=coords, folded_coords=None)
    motion = rigid_motion(moved)
    assert motion.verdict in (RigidVerdict.BENDS, RigidVerdict.NONE)
    assert len(motion.path) == 0


def test_drawings_with_few_digits(rigid_sheets):
    """A Miura sheet has room for rounded vertices; others are said to bend, by as little."""

    def drawn(name):
        """As a drawing has it: to a thousandth of a millimetre, letters and no angles."""
        pattern = rigid_sheets[name]
        signs = np.select([pattern.edges_assignment == k for k in "VM"], [180.0, -180.0])
        rounded = pattern.vertices_coords.round(3)
        return replace(pattern, vertices_coords=rounded, edges_foldAngle=signs, folded_coords=None)

    motion = rigid_motion(drawn("miura"))
    assert (motion.verdict, motion.freedom.count) == (RigidVerdict.FOLDS, 1)
    assert np.abs(motion.path[-1]) == pytest.approx(np.pi)
    other = rigid_motion(drawn("rigid_miura"))
    assert other.verdict is RigidVerdict.BENDS
    assert 0 < other.report()["missed_deg"] < 0.01
    missed = other.report()["missed_deg"]
    assert f"misses closure by {missed:.2g} degrees" in other.sentence()


@pytest.mark.parametrize(
    ("name", "verdict", "freedom"),
    [
        ("miura", RigidVerdict.FOLDS, 1),
        ("waterbomb", RigidVerdict.FOLDS, 25),
        ("yoshimura", RigidVerdict.FOLDS, 17),
        ("popup", RigidVerdict.FOLDS, 9),
        ("square_twist", RigidVerdict.BENDS, None),
        ("crane", RigidVerdict.BENDS, None),
        ("box", RigidVerdict.BENDS, 4),
    ],
)
def test_patterns_of_others(name, verdict, freedom):
    """For the square twist see Silverberg et al. (2015); a triangulated sheet with v interior
    vertices and e creases has e - 3 v freedoms.
    """
    pattern, _ = read_pattern(PATTERNS / f"{name}.fold")
    motion = rigid_motion(pattern)
    assert motion.verdict is verdict
    assert (motion.freedom.count if motion.freedom else None) == freedom
    if name in ("waterbomb", "yoshimura"):
        creases = motion.creases
        assert freedom == len(creases.hinges) - 3 * len(creases.closure.hinges)


def test_the_flat_state_counts_too_many(rigid_sheets):
    """Why freedom is counted between: flat, and folded flat, all axes are in one plane."""
    creases = rigid_creases(framework(rigid_sheets["miura"]))
    target = creases.frame.hinges_target[creases.hinges]
    for angles in (0 * target, np.pi * np.sign(target)):
        assert freedom_of(creases.linearised(angles)[1]).count > 1
    assert freedom_of(creases.linearised(target)[1]).count == 1


def test_creases_that_cannot_move_are_named():
    """A grid folds along its columns; where it is folded so, the creases of its row are locked."""
    sheet = grid(3, 2, 10.0)
    middle = sheet.vertices_coords[sheet.edges_vertices].mean(axis=1)
    row = sheet.edges_joining & (middle[:, 1] == 10)
    letters = np.where(row, "U", sheet.edges_assignment)
    angles = np.where(row, 0.0, np.where(sheet.edges_joining, 90.0, 0.0))
    motion = rigid_motion(replace(sheet, edges_assignment=letters, edges_foldAngle=angles))
    assert motion.verdict is RigidVerdict.FOLDS
    assert motion.freedom.count == 2
    assert motion.report()["creases_still"] == tuple(np.flatnonzero(row))
    flat = replace(sheet, edges_assignment=np.where(sheet.edges_joining, "F", "B"))
    nothing = replace(flat, edges_foldAngle=0 * flat.edges_foldAngle)
    assert rigid_motion(nothing).verdict is RigidVerdict.FLAT


@pytest.fixture(scope="module")
def derivatives(rigid_sheets):
    creases = rigid_creases(framework(rigid_sheets["miura"]))
    return creases.linearised(creases.frame.hinges_target[creases.hinges])[1]


@pytest.mark.parametrize("copies", [1, 5, 12, 70])
def test_freedom_of_large_sheets_is_that_of_their_parts(derivatives, copies):
    """Beyond 300 creases the smallest singular values alone are found; of over 64, no more."""
    whole = csc_array(block_diag([derivatives] * copies, format="csc"))
    freedom = freedom_of(whole)
    assert (freedom.count, freedom.exact) == (min(copies, 64), copies < 64)
    if copies < 64:
        values = np.linalg.svd(derivatives.toarray(), compute_uv=False)
        assert freedom.least_locked == pytest.approx(values[-2], rel=0.02)
        assert freedom.moving.all()


def test_states_between_are_those_of_the_only_motion(rigid_sheets):
    for pattern in rigid_sheets.values():
        states, findings = folded_states(pattern, 8)
        assert findings == []
        assert [state.stage for state in states] == [Stage.FLAT, *8 * [Stage.BETWEEN], Stage.TARGET]
        assert max(state.bend_mm for state in states) <= 1e-9
        driven = [np.abs(state.angles_deg).max() for state in states]
        assert driven == pytest.approx(np.linspace(0, driven[-1], 10), abs=1e-6)


def test_faces_that_would_cross_end_the_way_to_the_flat_state():
    """A long arch rolls up until it meets itself."""
    pattern = pattern_of_mesh(RigidMiura(columns=4, rows=24, fold=0.5).grow().mesh)
    made = simulate(
        pattern, "arch", FoldSettings(steps=20), solver=Solver.RIGID, formats=[], fold_flat=True
    )
    codes = [finding.code for finding in made.findings]
    assert codes == ["folds-rigidly", "fold-flat-stopped"]
    rigid = made.report["rigid"]
    driven = np.abs(rigid["angles_deg"])[:, rigid["creases"].index(rigid["driving_crease"])]
    assert driven.max() > 1.2 * np.degrees(0.5)
    assert driven.max() < 175
    assert rigid["bend_max_mm"] <= 1e-9


def run(*arguments):
    return CliRunner().invoke(main, [str(a) for a in arguments])


def test_simulate_follows_the_rigid_motion(tmp_path):
    file = PATTERNS / "miura.fold"
    options = ["--rigid", "--fold-flat", "--states", 5, "--only", "fold", "--out", tmp_path]
    result = run("simulate", file, *options)
    assert result.exit_code == 0, result.output
    assert "folds rigidly, 1 degree of freedom" in result.output
    report = json.loads((tmp_path / "miura_folding.json").read_text())
    assert report["solver"] == "rigid"
    assert report["rigid"]["verdict"] == "folds-rigidly"
    assert np.shape(report["rigid"]["angles_deg"]) == (11, 31)
    assert report["rigid"]["bend_max_mm"] <= 1e-9
    assert report["verdict"]["peak_strain"] <= 1e-11
    states = read_fold(tmp_path / "miura_folding.fold").states
    assert len(states) == 10
    flat = states[-1][1] - states[-1][1].mean(axis=0)
    assert np.linalg.svd(flat)[1][2] <= 1e-9


def test_simulate_folds_rigidly_to_a_given_angle(tmp_path):
    options = ["--rigid", "--fold-deg", 60, "--only", "fold", "--out", tmp_path]
    result = run("simulate", PATTERNS / "miura.fold", *options)
    assert result.exit_code == 0, result.output
    report = json.loads((tmp_path / "miura_folding.json").read_text())
    assert np.abs(report["rigid"]["angles_deg"][-1]).max() == pytest.approx(60)


def test_sheets_that_bend_have_no_motion_to_follow(tmp_path):
    result = run("simulate", PATTERNS / "square_twist.fold", "--rigid", "--out", tmp_path)
    assert result.exit_code == 1
    assert "no-rigid-motion" in result.output
    assert "bends on its way" in result.output
    assert [path.name for path in tmp_path.iterdir()] == ["square_twist_folding.json"]
    report = json.loads((tmp_path / "square_twist_folding.json").read_text())
    assert report["verdict"] is None
    assert report["rigid"]["verdict"] == "bends-on-its-way"


@pytest.mark.parametrize(
    "options",
    [["--rigid", "--solver", "dynamic"], ["--fold-flat"], ["--fold-flat", "--fold-deg", "9"]],
)
def test_options_that_exclude_each_other_are_refused(tmp_path, options):
    result = run("simulate", PATTERNS / "miura.fold", *options, "--out", tmp_path)
    assert result.exit_code == 2
    assert "--rigid" in result.output


def test_the_simulation_says_which_sheets_need_not_bend():
    """Driven all at one rate, a Miura is strained; it is not said to snap or bend."""
    made = make(load_job(TEMPLATES / "miura.toml", ["simulation.steps=5"]), [Format.FOLD])
    (finding,) = [f for f in made.findings if "strain" in f.text]
    assert finding.code == "folds-rigidly"
    assert "1 degree of freedom" in finding.text
    pattern, _ = grown_pattern(load_job(TEMPLATES / "random_tube.toml"))
    report = simulate(pattern, "tube", FoldSettings(steps=5), formats=[]).report
    assert report["rigid"]["verdict"] == "bends-on-its-way"
    assert report["rigid"]["degrees_of_freedom"] == 0
    assert "strained-on-the-way" in [finding["code"] for finding in report["findings"]]


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("miura", "folds rigidly, 1 degree of freedom"),
        ("square_twist", "bends on its way: no state with flat faces is found between"),
        (
            "box",
            "bends on its way: it moves with flat faces, 4 degrees of freedom, but not from flat",
        ),
    ],
)
def test_check_says_how_a_pattern_folds(name, says):
    assert says in run("check", PATTERNS / f"{name}.fold").output


@pytest.mark.parametrize("letters", ["MVVU", "MUVU"])
def test_a_sheet_with_free_creases_folds_where_all_others_get_to_their_angles(letters):
    pattern, spokes = fan_of(np.radians([60.0, 90.0, 120.0, 90.0]), letters)
    angle = np.zeros(len(pattern.edges_vertices))
    angle[spokes] = [{"M": -180.0, "V": 180.0, "U": 0.0}[letter] for letter in letters]
    motion = rigid_motion(replace(pattern, edges_foldAngle=angle))
    assert motion.verdict is RigidVerdict.FOLDS
    assert np.degrees(motion.path[-1][motion.creases.signs != 0]) == pytest.approx(
        angle[spokes][[letter != "U" for letter in letters]]
    )
    # other angles are not those that it folds to
    motion = rigid_motion(replace(pattern, edges_foldAngle=angle / 2))
    assert motion.verdict is not RigidVerdict.FOLDS
