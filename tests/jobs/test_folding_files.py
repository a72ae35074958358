"""Simulations from files and jobs: what is written, what the report says, bad input."""

import io
import json
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner
from flat_patterns import grid, pattern_of
from folded_strips import strip
from helpers import PATTERNS, TEMPLATES
from PIL import Image

from fab import read_pattern
from fab.cli.group import main
from fab.folding.bar_hinge_model import framework
from fab.folding.fold_settings import FoldSettings
from fab.folding.quasi_static import aligned, fold
from fab.folding.simulation import Solver, fold_and_judge
from fab.folding.target_forms import form_difference
from fab.folding.verdict import judge
from fab.formats.fold.reader import read_fold
from fab.jobs.folding_files import SimulationFormat, simulate
from fab.jobs.job import load_job
from fab.jobs.job_files import Format, make
from fab.pattern.kinematics import fold_by_angles

REACHED = [
    "bird_base",
    "box",
    "crane",
    "maze",
    "miura",
    "popup",
    "square_twist",
    "waterbomb",
    "yoshimura",
]
# This Resch tessellation has creases without an angle.
NOT_REACHED = ["resch"]


def run(*arguments):
    return CliRunner().invoke(main, [str(a) for a in arguments])


def report(name):
    pattern, findings = read_pattern(PATTERNS / f"{name}.fold")
    settings = FoldSettings(contact=False)  # layers in contact take room: see test_contact
    return simulate(pattern, name, settings, formats=[], findings=findings).report


def test_every_pattern_of_others_has_its_verdict():
    assert sorted(REACHED + NOT_REACHED) == sorted(p.stem for p in PATTERNS.glob("*.fold"))


@pytest.mark.parametrize("name", REACHED)
def test_patterns_of_others_fold_to_their_target(name):
    verdict = report(name)["verdict"]
    assert verdict["reached"]
    assert verdict["rmsd_rel"] < 1e-12
    assert verdict["wrong_creases_count"] == verdict["off_creases_count"] == 0
    assert all(point["settled"] for point in verdict["path"])


@pytest.mark.parametrize("name", NOT_REACHED)
def test_patterns_that_miss_their_target_are_reported(name):
    found = report(name)
    verdict = found["verdict"]
    assert not verdict["reached"]
    assert 0 < len(verdict["off_creases"]) <= 20 <= verdict["off_creases_count"]
    finding = next(f for f in found["findings"] if f["code"] == "target-not-reached")
    assert "creases turn freely" in finding["text"]


def test_the_files_of_a_simulation_hold_its_states(tmp_path):
    result = run("simulate", PATTERNS / "miura.fold", "--states", 4, "--out", tmp_path)
    assert result.exit_code == 0, result.output
    assert "folds to its target" in result.output
    names = {f"miura_folding.{kind}" for kind in (*SimulationFormat, "json")}
    assert {path.name for path in tmp_path.iterdir()} == names
    found = read_fold(tmp_path / "miura_folding.fold")
    assert len(found.states) == 4
    saved = json.loads((tmp_path / "miura_folding.json").read_text())
    loads = [point["load"] for point in saved["verdict"]["path"]]
    assert loads == pytest.approx([0, 0.25, 0.5, 0.75, 1.0])
    last = found.states[-1][1]
    side = np.hypot(*np.ptp(found.pattern.vertices_coords, axis=0))
    lengths = [
        np.linalg.norm(np.diff(points[found.pattern.edges_vertices], axis=1)[:, 0], axis=1)
        for points in (last, np.pad(found.pattern.vertices_coords, ((0, 0), (0, 1))))
    ]
    assert lengths[0] == pytest.approx(lengths[1], abs=1e-9 * side)
    with Image.open(tmp_path / "miura_folding.gif") as animation:
        assert animation.n_frames == 5 + 3
    with Image.open(tmp_path / "miura_folding.png") as picture:
        assert picture.size == (1920, 1140)
        assert len(picture.convert("RGB").getcolors(10**7)) > 100


def test_a_sheet_with_cuts_is_written_open(tmp_path):
    result = run("simulate", PATTERNS / "popup.fold", "--only", "fold", "--out", tmp_path)
    assert result.exit_code == 0, result.output
    pattern, _ = read_pattern(tmp_path / "popup_folding.fold")
    whole, _ = read_pattern(PATTERNS / "popup.fold")
    assert pattern.face_count == whole.face_count
    assert len(pattern.vertices_coords) > 0
    assert "C" not in pattern.edges_assignment


def test_the_same_file_gives_the_same_bytes():
    pattern, _ = read_pattern(PATTERNS / "square_twist.fold")
    first, second = (simulate(pattern, "twist", FoldSettings(steps=2)) for _ in range(2))
    assert dict(first.files) == dict(second.files)
    assert set(first.files) == {f"twist_folding.{kind}" for kind in (*SimulationFormat, "json")}


def test_a_job_is_simulated_from_its_file_and_on_request(tmp_path):
    result = run("simulate", TEMPLATES / "miura.toml", "--only", "png", "--dry-run", "--states", 3)
    assert result.exit_code == 0, result.output
    assert "would write" in result.output
    job = load_job(TEMPLATES / "miura.toml", ["simulation.steps=5"])
    simulation = make(job, [Format.FOLD]).report["simulation"]
    assert simulation["reached"]
    assert len(simulation["path"]) == 6
    job = load_job(TEMPLATES / "miura.toml")
    assert make(job, [Format.FOLD]).report["simulation"] is None


def test_the_dynamic_solver_can_be_asked_for():
    pattern, _ = read_pattern(PATTERNS / "miura.fold")
    folding, verdict, _ = fold_and_judge(pattern, FoldSettings(steps=1), Solver.DYNAMIC)
    assert folding.iterations > 1000
    assert verdict.wrong_creases == ()
    assert verdict.rmsd_rel < 1e-3


def test_progress_is_reported_and_ends():
    pattern, _ = read_pattern(PATTERNS / "miura.fold")
    calls = []
    formats = [SimulationFormat.FOLD]
    simulate(
        pattern, "m", FoldSettings(steps=10), formats=formats, progress=lambda *at: calls.append(at)
    )
    done = [at[1] for at in calls if at[0] == "fold"]
    assert {at[2] for at in calls if at[0] == "fold"} == {10}
    assert [n for n in done if n == int(n)] == list(range(11))
    assert np.all(np.diff(done) > 0)
    assert len(done) >= 21  # on the way to each load as well
    assert calls[-1] == ("write", 1, 1)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["nowhere.fold"], "cannot be read"),
        (["--states", "0"], "steps"),
        (["--states", "100000"], "steps"),
        (["--only", "mp4"], "--only 'mp4'"),
        (["--solver", "magic"], "quasi-static"),
        (["--contact", "--solver", "dynamic"], "--contact and --solver dynamic: "),
        (["--thickness-mm", "0.3", "--rigid"], "--thickness-mm 0.3 and --rigid: "),
    ],
)
def test_bad_arguments_are_refused(tmp_path, arguments, message):
    file = [] if arguments[0].endswith(".fold") else [PATTERNS / "miura.fold"]
    result = run("simulate", *file, *arguments, "--out", tmp_path)
    assert result.exit_code == 2
    assert message in result.output
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "solver", [("--solver", "quasi-static"), ("--solver", "dynamic"), ("--rigid",)]
)
def test_an_interrupt_leaves_nothing(tmp_path, monkeypatch, solver):
    def stop(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("fab.folding.verdict.crossing_faces", stop)
    file = PATTERNS / f"{'miura' if solver == ('--rigid',) else 'square_twist'}.fold"
    result = run("simulate", file, "--states", 1, *solver, "--out", tmp_path)
    assert result.exit_code == 130
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"edges_foldAngle": 190.0}, "must be from -180 to 180"),
        ({"vertices_coords": [float("nan"), 0.0]}, "finite"),
    ],
)
def test_bad_files_are_refused(tmp_path, change, message):
    document = json.loads((PATTERNS / "miura.fold").read_text())
    for key, value in change.items():
        document[key][0] = value
    (tmp_path / "bad.fold").write_text(json.dumps(document))
    result = run("simulate", tmp_path / "bad.fold", "--out", tmp_path / "out")
    assert result.exit_code == 2
    assert message in result.output
    assert not (tmp_path / "out").exists()


SQUARES = [[0, 0], [1, 0], [2, 0], [0, 1], [1, 1], [2, 1]]
TWO = [[0, 1, 4, 3], [1, 2, 5, 4]]


def codes(report):
    return {finding["code"] for finding in report["findings"]}


@pytest.mark.parametrize(
    "pattern",
    [
        pattern_of([[0, 0], [1, 0], [0, 1]], [[0, 1, 2]]),
        pattern_of(SQUARES, TWO, "U"),
        pattern_of(SQUARES, TWO, "V", angle=0.0),
        pattern_of(SQUARES, TWO, cuts=[(1, 4)]),
    ],
)
def test_sheets_with_nothing_to_fold_are_reported(pattern):
    made = simulate(pattern, "sheet", FoldSettings(steps=1), formats=[SimulationFormat.FOLD])
    assert made.report["verdict"]["reached"]
    assert made.report["verdict"]["driven"] == 0
    assert codes(made.report) == {"nothing-to-fold"}


def test_creases_that_turn_freely_are_reported():
    coords = [[x, y] for y in range(2) for x in range(4)]
    faces = [[x, x + 1, x + 5, x + 4] for x in range(3)]
    letters = np.full(len(pattern_of(coords, faces).edges_vertices), "V")
    edges = pattern_of(coords, faces).edges_vertices.tolist()
    letters[edges.index([1, 5])] = "U"
    found = simulate(pattern_of(coords, faces, letters), "sheet", formats=[]).report
    assert found["verdict"]["reached"]
    assert (found["verdict"]["driven"], found["verdict"]["free"]) == (1, 1)
    assert codes(found) == {"creases-free"}


def test_a_folded_form_against_the_angles_is_reported():
    flat = pattern_of(SQUARES, TWO, "V")
    other = replace(flat, folded_coords=np.pad(flat.vertices_coords, ((0, 0), (0, 1))))
    found = simulate(other, "sheet", formats=[]).report
    assert found["verdict"]["reached"]
    assert codes(found) == {"folded-form-differs"}
    point = framework(replace(flat, folded_coords=np.zeros((6, 3))))
    assert form_difference(point).stretch_rel == pytest.approx(1)
    assert judge(fold(point, 1)).rmsd_rel < 1e-9


def test_faces_that_miss_each_other_around_a_hole_are_reported():
    """Both rows around the hole roll up, one to each side: parallel at the end, but apart."""
    sheet = grid(3, 3, 10.0, without=[(1, 1)])
    middle = sheet.vertices_coords[sheet.edges_vertices].mean(axis=1)
    angle = np.zeros(len(middle))
    angle[(middle[:, 1] == 5) & (sheet.edges_faces[:, 1] >= 0)] = 90.0
    angle[(middle[:, 1] == 25) & (sheet.edges_faces[:, 1] >= 0)] = -90.0
    letters = np.where(angle > 0, "V", np.where(angle < 0, "M", "F"))
    letters[sheet.edges_faces[:, 1] < 0] = "B"
    found = simulate(
        replace(sheet, edges_foldAngle=angle, edges_assignment=letters), "sheet", formats=[]
    ).report
    assert found["verdict"]["closure_max_rad"] < 1e-9
    assert found["verdict"]["gap_rel"] > 0.1
    text = next(f["text"] for f in found["findings"] if f["code"] == "target-not-reached")
    assert "of the diagonal around a hole" in text


def test_the_form_that_a_fold_is_judged_by_is_written(tmp_path):
    """That of the angles, whatever the file has; none where they do not close."""
    names = ("square_twist", "popup", "miura")
    sheets = [read_pattern(PATTERNS / f"{name}.fold")[0] for name in names]
    assert all(pattern.folded_coords is None for pattern in sheets)
    mirrored = fold_by_angles(sheets[-1]).folded_coords * [1, 1, -1]
    for pattern in (*sheets, replace(sheets[-1], folded_coords=mirrored)):
        made = simulate(pattern, "sheet", formats=[SimulationFormat.FOLD])
        assert made.report["verdict"]["reached"]
        differs = pattern.folded_coords is not None
        assert ("folded-form-differs" in codes(made.report)) == differs
        data = made.files["sheet_folding.fold"]
        assert len(json.loads(data)["file_frames"]) == 11
        (tmp_path / "x.fold").write_bytes(data)
        found = read_fold(tmp_path / "x.fold")
        form, last = found.pattern.folded_coords, found.states[-1][1]
        size = np.linalg.norm(np.ptp(form, axis=0))
        off = np.linalg.norm(aligned(last, form) - form, axis=1).max() / size
        assert off < 1e-9
    square, _ = read_pattern(PATTERNS / "square_twist.fold")
    angles = square.edges_foldAngle.copy()
    angles[np.flatnonzero(square.edges_assignment == "M")[0]] += 20.0
    wrong = replace(square, edges_foldAngle=angles)
    made = simulate(wrong, "wrong", formats=[SimulationFormat.FOLD])
    assert len(json.loads(made.files["wrong_folding.fold"])["file_frames"]) == 10


def test_pictures_alone_need_no_other_files():
    pattern, _ = read_pattern(PATTERNS / "box.fold")
    made = simulate(pattern, "box", FoldSettings(steps=2), formats=[SimulationFormat.PNG])
    assert set(made.files) == {"box_folding.png", "box_folding.json"}
    assert Image.open(io.BytesIO(made.files["box_folding.png"])).format == "PNG"


def test_a_sheet_that_cannot_lie_flat_is_not_said_to_fold(tmp_path):
    impossible = strip([30, 10, 30], "VV")
    made = simulate(impossible, "flaps", formats=[SimulationFormat.FOLD])
    assert not made.within_tolerance
    assert made.report["layers"]["folds_flat"] == "no"
    assert made.report["layers"]["faces"] == [0, 1, 2]
    (finding,) = (each for each in made.findings if each.code == "cannot-lie-flat")
    assert (finding.severity, finding.panels) == ("error", (0, 1, 2))
    path = tmp_path / "flaps.fold"
    path.write_bytes(made.files["flaps_folding.fold"])
    for command in (["simulate", path, "--only", "fold", "--out", tmp_path], ["check", path]):
        done = run(*command)
        assert done.exit_code == 1
        assert "folds flat: no, because of faces 0, 1 and 2" in done.output
        assert "folds to its target" not in done.output
        assert "Another order" not in done.output  # no other gets there


def test_a_sheet_without_an_order_of_layers_has_no_hope_of_another_path():
    twice = grid(2, 2, 20.0)
    letters = twice.edges_assignment
    found = simulate(
        replace(twice, edges_foldAngle=np.where(letters == "V", 180.0, 0.0)), "map", formats=[]
    ).report
    assert found["layers"]["folds_flat"] == "no"
    (missed,) = (each for each in found["findings"] if each["code"] == "target-not-reached")
    assert missed["text"].endswith("Its layers have no order: see cannot-lie-flat.")


def test_a_sheet_that_lies_flat_has_the_orders_of_all_its_faces(tmp_path):
    made = simulate(strip([10, 10, 10, 10], "VMV"), "pleats", formats=[SimulationFormat.FOLD])
    layers = made.report["layers"]
    assert (layers["folds_flat"], layers["states"], layers["overlaps"]) == ("yes", 1, 6)
    form = json.loads(made.files["pleats_folding.fold"])["file_frames"][0]
    assert len(form["faceOrders"]) == 6
    path = tmp_path / "pleats.fold"
    path.write_bytes(made.files["pleats_folding.fold"])
    done = run("check", path)
    assert done.exit_code == 0, done.output
    assert "folds flat: yes, its layers have 1 order\n" in done.output
    assert (
        simulate(
            strip(
                [10, 10],
                "V",
            ),
            "half",
            formats=[],
        ).report["layers"]["states"]
        == 1
    )
    assert simulate(grid(2, 1, 10.0), "corner", formats=[]).report["layers"] is None
