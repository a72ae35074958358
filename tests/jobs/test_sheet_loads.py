"""Loads asked for at the command line and in jobs: files, figures, and refusals."""

import json
import re

import pytest
from click.testing import CliRunner
from helpers import PATTERNS

from fab import read_pattern
from fab.cli.group import main
from fab.errors import InvalidJob
from fab.folding.fold_settings import FoldSettings
from fab.folding.loads.load_settings import LoadSettings
from fab.settings import checked

MIURA = str(PATTERNS / "miura.fold")


def panel(path, width, height):
    """A file of one rectangle, mm."""
    document = {
        "file_spec": 1.1,
        "frame_unit": "mm",
        "vertices_coords": [[0, 0], [width, 0], [width, height], [0, height]],
        "edges_vertices": [[0, 1], [1, 2], [2, 3], [3, 0]],
        "edges_assignment": ["B"] * 4,
    }
    path.write_text(json.dumps(document))
    return path


def run(*words):
    return CliRunner().invoke(main, ["simulate", MIURA, "--states", "2", *map(str, words)])


def test_a_sheet_that_is_held_sags_with_files_and_figures(tmp_path):
    result = run(
        *("--fix", "left edge", "--pull", "5=0,0,-0.01", "--material", "card_300gsm"),
        *("--only", "fold,png,html", "--out", tmp_path),
    )
    assert result.exit_code == 0, result.output
    assert "under load it sags by " in result.output
    report = json.loads((tmp_path / "miura_folding.json").read_text())
    loads = report["loads"]
    assert loads["settled"]
    assert loads["sag_mm"] > 0
    assert loads["reaction_sum_n"] == pytest.approx([0, 0, loads["weight_n"] + 0.01], abs=1e-7)
    assert loads["load_sum_n"] == pytest.approx([-x for x in loads["reaction_sum_n"]], abs=1e-7)
    assert loads["states"][-1]["sag_mm"] == loads["sag_mm"]
    assert [row["load"] for row in loads["states"]] == [0.0, 0.25, 0.5, 0.75, 1.0]
    assert {"crease-stiffness-guessed"} <= {found["code"] for found in report["findings"]}
    assert (tmp_path / "miura_folding_loads.png").read_bytes()[:4] == b"\x89PNG"
    assert "Under load" in (tmp_path / "miura_folding.html").read_text()
    document = json.loads((tmp_path / "miura_folding.fold").read_text())
    frames = {frame.get("frame_title", ""): frame for frame in document["file_frames"]}
    (last,) = [frame for title, frame in frames.items() if "under 100.00% of the load" in title]
    assert len(last["vertices_coords"]) == len(document["vertices_coords"])
    # it is where the fold has the sheet, but for what it sags
    (folded,) = [frame for title, frame in frames.items() if "100.00% of the way" in title]
    moved = [
        sum((a - b) ** 2 for a, b in zip(first, second, strict=True)) ** 0.5
        for first, second in zip(last["vertices_coords"], folded["vertices_coords"], strict=True)
    ]
    assert 0 < max(moved) <= loads["displacement_max_mm"] * (1 + 1e-6)
    assert min(moved) < 1e-6  # what is held


def test_a_sheet_that_air_lifts_is_said_to_rise_and_its_weight_is_not_named(tmp_path):
    path = panel(tmp_path / "panel.fold", 60.0, 40.0)
    words = ["--fix", "border", "--pressure-pa", "100", "--no-weight", "--only", "fold"]
    words += ["--material", "card_300gsm", "--out", str(tmp_path)]
    result = CliRunner().invoke(main, ["simulate", str(path), *words])
    assert result.exit_code == 0, result.output
    loads = json.loads((tmp_path / "panel_folding.json").read_text())["loads"]
    assert "under load it rises by " in result.output
    assert f" rises by {loads['displacement_max_mm']:.3g} mm at " in loads["text"]
    assert "weight" not in loads["text"]
    assert loads["load_sum_n"] == pytest.approx([0, 0, 100 * 60e-3 * 40e-3], rel=1e-3, abs=1e-6)
    assert loads["reaction_sum_n"] == pytest.approx([-x for x in loads["load_sum_n"]], abs=1e-6)


def test_a_held_edge_turns_and_the_region_that_the_note_names_clamps_it(tmp_path):
    path = panel(tmp_path / "strip.fold", 60.0, 20.0)
    sags = []
    where = "left edge"
    for swings in (True, False):
        words = ["--fix", where, "--only", "fold", "--material", "card_300gsm"]
        words += ["--out", str(tmp_path / "out")]
        result = CliRunner().invoke(main, ["simulate", str(path), *words])
        assert result.exit_code == 0, result.output
        report = json.loads((tmp_path / "out" / "strip_folding.json").read_text())
        sags.append(report["loads"]["sag_mm"])
        notes = [each for each in report["findings"] if each["code"] == "swings-about-support"]
        assert bool(notes) == swings
        if notes:
            assert notes[0]["severity"] == "note"
            assert "from (0, 0) to (0, 20) mm" in notes[0]["text"]
            where = re.search(r"--fix ([\d.,]*\d)\.$", notes[0]["text"])[1]
    assert sags[0] > 30
    assert sags[1] < 3


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--fix", "left edge"], "loads.material is missing"),
        (["--weight"], "say with --fix where it is held"),
        (["--fix", "0", "--material", "plywood_3mm"], "has no youngs_modulus_mpa"),
        (["--fix", "0", "--material", "card_30gsm"], "Did you mean card_300gsm"),
        (
            ["--fix", "left", "--material", "card_300gsm"],
            "fixed.0 = 'left' is out of bounds: it must be 'left edge'",
        ),
        (["--fix", "999", "--material", "card_300gsm"], "numbered from 0 to"),
        (["--fix", "0,0,1", "--material", "card_300gsm"], "must be 4 numbers"),
        (["--fix", "0", "--pull", "0,0,1"], "must have the form WHERE=X,Y,Z"),
        (["--fix", "0", "--pull", "0,0=0,0,1"], "--pull 0,0: must be 4 numbers"),
        (["--fix", "0", "--down", "0,0,0"], "must not be zero"),
        (["--fix", "0", "--no-weight"], "there is no load"),
    ],
)
def test_loads_that_cannot_be_are_refused_with_a_cure(tmp_path, words, said):
    result = run(*words, "--dry-run", "--out", tmp_path)
    assert result.exit_code == 2, result.output
    assert said in " ".join(result.output.split())


def test_settings_of_a_job_are_those_of_the_options():
    tables = {
        "steps": 3,
        "loads": {
            "fixed": ["left edge", 12, [0.0, 0.0, 20.0, 10.0]],
            "pulls": [{"at": ["right edge"], "force_n": [0.0, 0.0, -0.05]}],
        },
    }
    settings = checked(FoldSettings, tables, "job", "")
    assert settings.loads == LoadSettings.model_validate(tables["loads"])
    assert settings.loads.fixed == ["left edge", 12, [0.0, 0.0, 20.0, 10.0]]
    with pytest.raises(InvalidJob, match=r"loads\.fixed is missing"):
        checked(FoldSettings, {"loads": {"weight": True}}, "job", "")
    assert read_pattern(MIURA)[0].face_count == 40


@pytest.mark.parametrize("where", ["\u00b2", "9" * 5000, "-1", "vertex 3"])
def test_places_that_are_no_vertex_and_no_edge_are_told(tmp_path, where):
    result = run("--fix", where, "--only", "fold", "--out", tmp_path)
    assert result.exit_code == 2
    assert "quadfold: loads: fixed.0 = " in result.stderr
