"""What commands print for people and for scripts, and shipped jobs by their name."""

import json

import pytest
from click.testing import CliRunner
from helpers import ROOT, TEMPLATES

from fab.cli.group import main

TWIST = str(ROOT / "tests" / "patterns" / "square_twist.fold")
STOCK = ("--material", "card_300gsm", "--machine", "co2_60w_600x400")
COMMANDS = [
    ("run", str(TEMPLATES / "miura.toml"), "--only", "fold"),
    ("fabricate", TWIST, *STOCK, "--only", "dxf"),
    ("thicken", TWIST, "--set", "panels.fold_limit_deg=90", "--only", "stl"),
    ("simulate", TWIST, "--only", "fold"),
    ("animate", TWIST, "--states", "4", "--only", "gif"),
]


def run(*words):
    return CliRunner().invoke(main, [str(word) for word in words])


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


def test_json_and_quiet_exclude_each_other():
    result = run("run", "miura", "--json", "--quiet")
    assert result.exit_code == 2
    assert "--json and --quiet exclude each other" in result.stderr


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
