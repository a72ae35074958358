"""What commands print for people and for scripts, and shipped jobs by their name."""

import json
import re

import numpy as np
import pytest
from click.testing import CliRunner
from helpers import ROOT, TEMPLATES

import fab
from fab.cli.group import main
from fab.cli.progress_lines import StageLines
from fab.folding.bar_hinge_model import framework
from fab.folding.checkpoints import FoldCheckpoints
from fab.folding.quasi_static import fold
from fab.jobs.file_names import FAMILIES, left_over
from fab.jobs.grow import grown_pattern

TWIST = str(ROOT / "tests" / "patterns" / "square_twist.fold")
STOCK = ("--material", "card_300gsm", "--machine", "co2_60w_600x400")
COMMANDS = [
    ("run", str(TEMPLATES / "miura.toml"), "--only", "fold"),
    ("fabricate", TWIST, *STOCK, "--only", "dxf"),
    ("thicken", TWIST, "--set", "panels.fold_limit_deg=90", "--only", "stl"),
    ("simulate", TWIST, "--only", "fold", "--no-contact"),
    ("animate", TWIST, "--states", "4", "--only", "gif"),
]


def run(*words, typed=None):
    return CliRunner().invoke(main, [str(word) for word in words], input=typed)


@pytest.mark.parametrize("command", COMMANDS, ids=[command[0] for command in COMMANDS])
def test_json_is_one_document_with_files_and_findings_and_quiet_prints_errors_alone(
    command, tmp_path
):
    lines = run(*command, "--out", tmp_path / "a")
    told = run(*command, "--out", tmp_path / "b", "--json")
    quiet = run(*command, "--out", tmp_path / "c", "--quiet")
    report = json.loads(told.stdout)
    assert report["folder"] == str(tmp_path / "b")
    assert told.stderr == ""
    assert quiet.stdout == ""
    severities = {finding["severity"] for finding in report["findings"]}
    assert told.exit_code == quiet.exit_code == lines.exit_code == int("error" in severities)
    assert bool(quiet.stderr) == ("error" in severities)
    made = {path.name: path.read_bytes() for path in (tmp_path / "b").iterdir()}
    assert {file["file"]: file["bytes"] for file in report["outputs"]}.items() <= {
        name: len(data) for name, data in made.items()
    }.items()
    assert {path.name for path in (tmp_path / "c").iterdir()} == set(made)


def test_a_dry_run_in_json_names_no_folder(tmp_path):
    told = run("run", "miura", "--only", "fold", "--dry-run", "--json", "--out", tmp_path / "a")
    assert json.loads(told.stdout)["folder"] is None
    assert not (tmp_path / "a").exists()


@pytest.mark.parametrize("options", [("--json", "--quiet"), ("--quiet", "--verbose")])
def test_options_of_what_is_printed_exclude_each_other(options):
    result = run("run", "miura", *options)
    assert result.exit_code == 2
    assert f"{' and '.join(options)} exclude each other" in result.stderr


def test_verbose_prints_every_finding_and_the_seconds_of_each_stage(tmp_path):
    words = ("thicken", TWIST, "--width-mm", 8, "--only", "stl", "--out", tmp_path)
    limit = ("--set", "panels.fold_limit_deg=90")
    brief, verbose = run(*words, *limit), run(*words, *limit, "--verbose")
    report = json.loads((tmp_path / "square_twist_thick_report.json").read_text())
    assert len(report["findings"]) > len(brief.stderr.splitlines())
    assert len(verbose.stderr.splitlines()) == len(report["findings"])
    assert "more of these" not in verbose.stderr
    for stage in report["seconds"]:
        assert re.search(rf"^{re.escape(stage)} +\d+\.\d\d s$", verbose.stdout, re.MULTILINE)


def test_formats_of_several_options_add_up(tmp_path):
    words = ("run", "miura", "--only", "dxf", "--only", "svg,dxf", "--out", tmp_path)
    assert run(*words).exit_code == 0
    made = sorted(path.name for path in tmp_path.iterdir())
    assert made == ["miura.dxf", "miura.svg", "miura_report.json"]


def test_a_job_on_standard_input_is_that_of_its_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = (TEMPLATES / "miura.toml").read_text()
    options = ("--only", "fold", "--set", "design.rows=3")
    assert run("run", "-", *options, "--out", "a", typed=text).exit_code == 0
    assert run("run", TEMPLATES / "miura.toml", *options, "--out", "b").exit_code == 0
    assert (tmp_path / "a/miura.fold").read_bytes() == (tmp_path / "b/miura.fold").read_bytes()


@pytest.mark.parametrize(
    ("typed", "words"),
    [
        ("", "standard input: name is missing"),
        ("a = ", "standard input: not a TOML file"),
        (b"\xff\xfe", "standard input: not a TOML file"),
        ("#" * 1_000_001, "standard input: has more than 1000000 bytes"),
    ],
)
def test_what_is_no_job_on_standard_input_is_refused(typed, words, tmp_path):
    result = run("run", "-", "--out", tmp_path / "out", typed=typed)
    assert result.exit_code == 2
    assert words in result.stderr
    assert not (tmp_path / "out").exists()


def test_files_of_an_earlier_run_are_named_whatever_their_kind(tmp_path):
    run("run", "miura", "--only", "fold,svg", "--out", tmp_path)
    run("fabricate", tmp_path / "miura.fold", *STOCK, "--only", "dxf", "--out", tmp_path)
    run("simulate", tmp_path / "miura.fold", "--only", "png", "--out", tmp_path)
    older = {path.name for path in tmp_path.iterdir()} - {"miura.fold", "miura_report.json"}
    assert len(older) == 5
    for name in ("miura.txt", "miura2.svg", "miura_thick.md", "a_miura.svg"):
        (tmp_path / name).touch()
    again = run("run", "miura", "--only", "fold", "--out", tmp_path)
    made = ["miura.fold", "miura_report.json"]
    assert {path.name for path in left_over(made, "miura", FAMILIES, tmp_path)} == older
    first = ", ".join(sorted(older)[:3])
    text = f"note: {first} and 2 more in {tmp_path} are from an earlier run"
    assert text in again.stderr
    assert "earlier run" not in run("run", "miura", "--dry-run", "--out", tmp_path / "new").stderr


def test_long_stages_have_a_line_each_with_the_time_left():
    clock, lines = [0.0], []
    stages = StageLines(lines.append, now=lambda: clock[0])

    def step(seconds, stage, done, total):
        clock[0] += seconds
        stages(stage, done, total)

    step(0, "grow", 0, 4)
    step(9.9, "grow", 3, 4)
    step(0, "fit", 0, 40)
    step(12, "fit", 1, 40)  # too early to say how long
    step(0, "nest", 0, 10)
    step(8, "nest", 1, 10)
    step(8, "nest", 4, 10)
    step(100, "nest", 9, 10)
    step(0, "simulate", 0, 1)
    step(20, "write", 0, 1)
    stages.end()
    assert lines == [
        "fit: 1 of 40 after 12 s",
        "nest: 4 of 10 after 16 s, about 24 s left",
        "simulate: done after 20 s",
    ]


def test_the_closing_lines_say_what_a_maker_asks(tmp_path):
    printed = ("--set", 'printer.machine="prusa_mk4s"', "--set", 'printer.material="pp_filament"')
    words = ("--only", "fold,stl", "--out", tmp_path)
    lines = run("run", "miura", *printed, *words).stdout.splitlines()
    report = json.loads((tmp_path / "miura_report.json").read_text())
    flat, folded = (report["bounding_box_mm"][form] for form in ("flat", "folded"))
    sides = lambda box: " x ".join(f"{side:.4g}" for side in box)  # noqa: E731
    assert f"flat {sides(flat)} mm; folded {sides(folded)} mm" in lines
    assert report["rigid"]["text"] in lines
    assert report["rigid"]["text"].startswith("folds rigidly, 1 degree of freedom")
    assert [line for line in lines if line.startswith("nothing overlaps in 10 checked states")]
    (thick,) = [line for line in lines if line.startswith("thick: ")]
    assert thick.startswith("thick: 80 panels, ")
    assert thick.endswith(f"{report['solids']['mass_g']:.3g} g")


def test_completion_of_a_shell_has_the_commands():
    from click.shell_completion import get_completion_class

    for shell in ("bash", "zsh", "fish"):
        script = get_completion_class(shell)(main, {}, "quadfold", "_QUADFOLD_COMPLETE")
        assert "_QUADFOLD_COMPLETE" in script.source()
    bash = get_completion_class("bash")(main, {}, "quadfold", "_QUADFOLD_COMPLETE")
    assert [item.value for item in bash.get_completions([], "fab")] == ["fabricate"]
    own = [item.value for item in bash.get_completions(["run"], "curved")]
    assert "curved_fold" in own
    cutters = [item.value for item in bash.get_completions(["fabricate", "--machine"], "co2")]
    assert "co2_60w_600x400" in cutters


def test_materials_and_machines_are_listed_by_a_word():
    every, knives = run("shipped", "machines").stdout, run("shipped", "machines", "Knife").stdout
    assert 0 < len(knives.splitlines()) < len(every.splitlines())
    assert all("knife" in line.casefold() for line in knives.splitlines())
    sheets = run("shipped", "materials", "sheet").stdout
    assert "Card, 300 g/m2, 0.36 mm\n" in sheets
    assert sheets.count("Birch plywood, 3 mm\n") == 1
    none = run("shipped", "materials", "zzz")
    assert none.exit_code == 2
    assert "none of the" in none.stderr


def test_shipped_jobs_run_by_their_name_and_a_file_of_that_name_comes_first(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    run("run", "miura", "--only", "fold", "--out", "a")
    run("run", TEMPLATES / "miura.toml", "--only", "fold", "--out", "b")
    assert (tmp_path / "a/miura.fold").read_bytes() == (tmp_path / "b/miura.fold").read_bytes()
    (tmp_path / "miura").write_text("no job")
    assert run("run", "miura", "--out", "c").exit_code == 2
    unknown = run("run", "miuru")
    assert unknown.exit_code == 2
    assert "neither a file nor a shipped job. Did you mean" in unknown.stderr


def test_templates_are_listed_by_a_word_of_their_name_or_description():
    listed = run("templates", "Lamp").stdout
    assert listed.startswith("lamp_shade")
    assert len(listed.splitlines()) < len(run("templates").stdout.splitlines())
    none = run("templates", "zzz")
    assert none.exit_code == 2
    assert "has 'zzz' in its name or description" in none.stderr


def test_the_closing_lines_of_sheets_have_time_and_mass(tmp_path):
    words = [
        f'cutter.{key}="{name}"'
        for key, name in zip(("material", "machine"), STOCK[1::2], strict=True)
    ]
    changes = [word for change in words for word in ("--set", change)]
    lines = run("run", "miura", *changes, "--only", "fold,dxf", "--out", tmp_path).stdout
    report = json.loads((tmp_path / "miura_report.json").read_text())
    found = re.search(
        r"^1 piece, 0 seams, 1 sheet of 600 x 400 mm, about ([\d.]+) minutes, ([\d.]+) g$",
        lines,
        re.MULTILINE,
    )
    minutes, grams = map(float, found.groups())
    assert minutes == round(report["sheets"][0]["minutes"], 1)
    pattern, _ = fab.read_pattern(tmp_path / "miura.fold")
    x, y = pattern.vertices_coords[pattern.faces_vertices].reshape(-1, 4, 2).transpose(2, 0, 1)
    doubled = x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1)
    area_m2 = np.abs(doubled.sum(axis=1)).sum() / 2e6
    assert grams == pytest.approx(area_m2 * 300, rel=0.01)  # kerf is cut beside the sheet


def test_folds_that_were_cut_short_go_on_and_those_of_other_settings_are_named(tmp_path):
    path, out = tmp_path / "job.toml", tmp_path / "out"
    text = (TEMPLATES / "miura.toml").read_text()
    path.write_text(text + "\n[simulation]\nsteps = 3\n")
    job = fab.load_job(path)
    pattern, _ = grown_pattern(job)
    for crease in (job.simulation.crease, 0.5):
        settings = job.simulation.model_copy(update={"crease": crease})
        kept = FoldCheckpoints(out, "miura", every_s=0.0)
        fold(framework(pattern, settings), 3, checkpoint=kept)
    assert len(list(out.iterdir())) == 2
    for command in (["run", path], ["simulate", path]):
        done = run(*command, "--only", "fold", "--out", out)
        assert done.exit_code == 0
        line = "fold: goes on at 100%, where it was cut short (miura_checkpoint_"
        assert (line in done.stderr) is (command[0] == "run")
        (other,) = out.glob("*.npz")
        assert f"note: {other.name}" in done.stderr
    assert run("run", path, "--only", "fold", "--out", out, "--quiet").stderr == ""
