"""The command line: answers, exit codes, what is imported, and what the guide says of it."""

import io
import json
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import time
import xml.etree.ElementTree as ElementTree
import zipfile
from contextlib import redirect_stdout
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import trimesh
from click.testing import CliRunner
from helpers import DOCS, PATTERNS, ROOT, TEMPLATE_NAMES, TEMPLATES, guide, template_fold
from machine_readers import read_grbl, read_lightburn, read_plotter

from fab.cli.group import main


def names_in(folder) -> list[str]:
    return sorted(path.name for path in Path(folder).iterdir())


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(*arguments):
    return CliRunner().invoke(main, [str(a) for a in arguments])


def test_run_writes_what_it_says(here):
    result = run("run", TEMPLATES / "miura.toml", "--out", "out", "--only", "dxf,SVG,fold")
    assert result.exit_code == 0, result.output
    names = ["miura.dxf", "miura.fold", "miura.svg", "miura_report.json"]
    assert names_in("out") == names
    for name in names:
        path = Path("out") / name
        assert f"wrote {path}  {path.stat().st_size} bytes\n" in result.output


def test_dry_run_writes_nothing(here):
    result = run("run", TEMPLATES / "miura.toml", "--out", "out", "--only", "dxf", "--dry-run")
    assert result.exit_code == 0
    assert "would write" in result.output
    assert names_in(".") == []


def test_errors_in_the_report_give_exit_code_1_and_all_files(here):
    result = run(
        "run", TEMPLATES / "curved_fold.toml", "--set", "design.k_deg=187.2", "--only", "dxf"
    )
    assert result.exit_code == 1
    assert "error: development-overlaps" in result.output
    assert names_in(".") == ["curved_fold.dxf", "curved_fold_report.json"]


@pytest.mark.parametrize(
    "arguments",
    [
        ["run", "missing.toml"],
        ["run", TEMPLATES / "miura.toml", "--only", "dfx"],
        ["run", TEMPLATES / "miura.toml", "--only", ""],
        ["run", TEMPLATES / "miura.toml", "--set", "design.colums=4"],
        ["run", TEMPLATES / "miura.toml", "--set", "design.fold_deg=nan"],
        ["run", TEMPLATES / "miura.toml", "--set", "design.fold_deg=90"],
        ["run", TEMPLATES / "miura.toml", "--set", "name=../up"],
        ["run", TEMPLATES / "miura.toml", "--out", "/dev/null/below"],
        ["run", TEMPLATES / "crumpled.toml", "--set", "design.k_deg=20.0"],
        ["run", TEMPLATES / "curved_fold.toml", "--set", "design.k_deg=1.0"],
        ["run"],
        ["new", "nothing"],
        ["thicken", "missing.fold"],
        ["thicken", TEMPLATES / "miura.toml"],
        ["thicken", PATTERNS / "box.fold", "--set", "panels.thickness_mm=-1"],
        ["thicken", PATTERNS / "box.fold", "--set", "panels.clearance_mm=-0.1"],
        ["thicken", PATTERNS / "box.fold", "--set", "hinges.web_mm=3.0"],
        ["thicken", PATTERNS / "box.fold", "--set", "sheet.width_mm=3.0"],
        ["thicken", PATTERNS / "box.fold", "--printer", "prusa"],
        ["thicken", PATTERNS / "box.fold", "--material", "card_300gsm"],
        ["thicken", PATTERNS / "box.fold", "--only", "dxf"],
        ["thicken", PATTERNS / "box.fold", "--width-mm", "-5"],
        ["thicken", PATTERNS / "miura.fold", "--width-mm", "3e7", "--only", "stl"],
        ["thicken", PATTERNS / "box.fold", "--width-mm", "5", "--scale", "2"],
        ["check", "missing.fold"],
        ["check", TEMPLATES / "miura.toml"],
        ["unknown"],
    ],
)
def test_bad_input_gives_exit_code_2_and_writes_nothing(here, arguments):
    result = run(*arguments)
    assert result.exit_code == 2, result.output
    assert len(result.output.strip()) > 20
    assert "Traceback" not in result.output
    assert names_in(".") == []


def test_templates_are_listed_and_copied(here):
    listed, series = run("templates"), run("templates", "--paper")
    assert listed.exit_code == series.exit_code == 0
    lines = [*listed.stdout.splitlines(), *series.stdout.splitlines()]
    assert sorted(line.split()[0] for line in lines) == TEMPLATE_NAMES
    assert all(len(line.split()) > 4 for line in lines)
    assert lines[0].startswith("lamp_shade ")
    assert {"hypar_20", "hypar_160"} <= {line.split()[0] for line in series.stdout.splitlines()}
    assert "templates --paper" in listed.stderr
    assert run("new", "miura").exit_code == 0
    assert run("new", "miura", "--out", "mine.toml").exit_code == 0
    assert names_in(".") == ["mine.toml", "miura.toml"]
    assert (here / "mine.toml").read_bytes() == (TEMPLATES / "miura.toml").read_bytes()
    again = run("new", "miura")
    assert again.exit_code == 2
    assert "exists already" in again.output
    long = run("new", "miura", "--out", 300 * "a")
    assert long.exit_code == 2
    assert "cannot be written: File name too long" in long.output
    assert "Did you mean miura" in run("new", "mura").output


@pytest.mark.parametrize(
    ("name", "kind"), [("card_300gsm", "material"), ("knife_a4", "machine"), ("ender_3", "machine")]
)
def test_new_copies_materials_and_machines_too(here, name, kind):
    made = run("new", name, "--out", "mine.toml")
    assert made.exit_code == 0
    assert f"in place of the name of a {kind}" in made.stdout
    assert (here / "mine.toml").read_bytes() == (
        TEMPLATES / f"{kind}s" / f"{name}.toml"
    ).read_bytes()
    assert "Did you mean card_300gsm" in run("new", "card_300gms").output


def test_names_of_shipped_files_are_of_one_kind_alone():
    folders = [TEMPLATES, TEMPLATES / "materials", TEMPLATES / "machines"]
    names = [path.stem for folder in folders for path in folder.glob("*.toml")]
    assert len(names) == len(set(names))


def test_shipped_jobs_are_folded_by_their_names(here):
    made = run("simulate", "rigid_miura", "--rigid", "--states", "2", "--only", "fold", "--dry-run")
    assert made.exit_code == 0
    assert "rigid_miura_folding.fold" in made.stdout
    assert run("simulate", "rigid_mura").exit_code == 2


def test_check_measures_a_fold_file(here):
    (here / "good.fold").write_bytes(template_fold("miura"))
    result = run("check", "good.fold")
    assert result.exit_code == 0, result.output
    assert "M:76 V:66 F:0 B:36" in result.output
    assert "crossings           0" in result.output
    document = json.loads((here / "good.fold").read_text())
    document["file_frames"][0]["vertices_coords"][20][2] += 0.5
    (here / "bent.fold").write_text(json.dumps(document))
    result = run("check", "bent.fold")
    assert result.exit_code == 1
    assert "not-planar" in result.output
    assert run("check", "bent.fold", "--tolerance", "0").exit_code == 2
    del document["file_frames"]
    (here / "flat.fold").write_text(json.dumps(document))
    result = run("check", "flat.fold")
    assert result.exit_code == 0, result.output
    assert "folded form         none to measure" in result.stdout
    assert "planarity" not in result.output


def test_suggest_prints_the_window_and_writes_nothing(here):
    words = ["--set", "panels.thickness_mm=20.0", "--suggest", "--out", "out"]
    result = run("run", TEMPLATES / "miura.toml", *words)
    assert result.exit_code == 0, result.output
    assert result.output.startswith("20 of 80 faces have a panel, at width_mm = 200")
    most = re.search(r"thickness_mm at most ([\d.]+)", result.output)[1]
    wide = re.search(r"this thickness with width_mm at least ([\d.]+)", result.output)[1]
    assert names_in(".") == []
    for changes in ([f"panels.thickness_mm={most}"], [f"sheet.width_mm={wide}"]):
        given = ["--set", "panels.thickness_mm=20.0", *(w for c in changes for w in ("--set", c))]
        again = run("run", TEMPLATES / "miura.toml", "--suggest", *given)
        assert again.output.startswith("80 of 80 faces have a panel"), again.output


@pytest.mark.parametrize("of", [["run", TEMPLATES / "miura.toml"], ["thicken", "miura.fold"]])
def test_suggestions_are_told_as_asked_for(here, of):
    assert run("run", TEMPLATES / "miura.toml", "--only", "fold").exit_code == 0
    words = [*of, "--set", "panels.thickness_mm=20.0", "--suggest"]
    lines, quiet = run(*words), run(*words, "--quiet")
    assert (quiet.exit_code, quiet.output) == (0, "")
    told = json.loads(run(*words, "--json").stdout)
    window = told["window"]
    assert f"{window['panels']} of {window['faces']} faces have a panel" in lines.output
    most = float(re.search(r"thickness_mm at most ([\d.]+)", lines.output)[1])
    assert most <= window["thickness_max_mm"] < 1.01 * most + 0.01
    assert [row["thickness_mm"] for row in window["rows"]] == [5, 10, 15, 20, 30, 40, 60]
    assert told["findings"] == []


@pytest.mark.parametrize("axis", ["bottom", "middle"])
def test_thicken_makes_files_of_any_fold_file(here, axis):
    changes = ["panels.fold_limit_deg=120.0", "panels.thickness_mm=1.2", f"panels.axis={axis}"]
    words = [word for change in changes for word in ("--set", change)]
    file = PATTERNS / "square_twist.fold"
    words += ["--printer", "prusa_mk4s", "--material", "pp_filament"]
    dry = run("thicken", file, *words, "--dry-run", "--only", "stl")
    assert dry.exit_code == 0, dry.output
    assert names_in(".") == []
    result = run("thicken", file, *words, "--width-mm", "150", "--out", "out")
    assert result.exit_code == 0, result.output
    kinds = ["3mf", "html", "png", "step", "stl"]
    names = [f"square_twist_thick.{kind}" for kind in kinds]
    names.append("square_twist_thick_assembly.pdf")
    assert names_in("out") == sorted([*names, "square_twist_thick_report.json"])
    assert all(name in result.output for name in names)
    assert "9 panels, 12 hinges, 150 x 150 x 1.2 mm" in result.output
    assert "warning: fold-blocked" in result.output
    report = json.loads((here / "out" / "square_twist_thick_report.json").read_text())
    assert report["settings"]["panels"]["axis"] == axis
    assert report["printer"]["kind"] == "printer"
    density = report["material"]["density_kg_m3"] * 1e-6
    assert report["solids"]["mass_g"] == pytest.approx(report["solids"]["volume_mm3"] * density)
    assert {output["file"] for output in report["outputs"]} == set(names)
    left = run("thicken", file, *words, "--set", "panels.thickness_mm=200.0", "--out", "out")
    assert left.exit_code == 1
    assert "error: panel-vanishes: 9 faces have no panel" in left.output
    assert "and 3 more in out are from an earlier run" in left.output


def test_thicken_prints_what_is_larger_than_the_bed_in_parts(here):
    words = ["--set", "panels.fold_limit_deg=120.0", "--printer", "prusa_mk4s", "--out", "out"]
    file = PATTERNS / "square_twist.fold"
    result = run("thicken", file, *words, "--width-mm", "400", "--only", "stl,3mf,zip")
    assert result.exit_code == 0, result.output
    report = json.loads((here / "out" / "square_twist_thick_report.json").read_text())
    plates = report["plates"]["plates"]
    assert len(plates) > 1
    assert sorted(face for plate in plates for p in plate for face in p["panels"]) == list(range(9))
    made = {f"square_twist_thick_plate_{k + 1}" for k in range(len(plates))}
    assert set(names_in("out")) == {
        *(f"{name}.{kind}" for name in made for kind in ("stl", "3mf")),
        "square_twist_thick_bodies.zip",
        "square_twist_thick_report.json",
    }
    assert "note: sheet-divided" in result.output
    assert "print-too-large" not in result.output
    for name, parts in zip(sorted(made), plates, strict=True):
        mesh = trimesh.load(here / "out" / f"{name}.stl")
        assert mesh.is_watertight
        assert mesh.bounds[0] == pytest.approx([*mesh.bounds[0][:2], 0.0], abs=1e-6)
        assert (mesh.bounds[0][:2] >= 5 - 1e-4).all()
        assert (mesh.bounds[1][:2] <= np.array([250, 210]) - 5 + 1e-4).all()
        package = zipfile.ZipFile(here / "out" / f"{name}.3mf")
        model = ElementTree.fromstring(package.read("3D/3dmodel.model"))
        core = "{http://schemas.microsoft.com/3dmanufacturing/core/2015/02}"
        names = [thing.get("name") for thing in model.iter(f"{core}object")]
        assert names == [part["part"] for part in parts]
    again = run("thicken", file, *words, "--width-mm", "150", "--only", "stl")
    assert again.exit_code == 0, again.output
    assert "square_twist_thick_plate_1.stl and" in again.output
    words += ["--width-mm", "400", "--only", "stl"]
    film = run("thicken", file, *words, "--set", "hinges.kind=film")
    assert film.exit_code == 0
    assert "note: film-taped" in film.output


def test_thicken_lengthens_webs_for_the_material(here):
    words = ["--set", "panels.fold_limit_deg=90.0", "--set", "panels.thickness_mm=0.8"]
    file = PATTERNS / "square_twist.fold"
    webs = []
    for material in ("tpu_95a_filament", "petg_filament"):
        out = run(
            "thicken", file, *words, "--material", material, "--out", material, "--only", "stl"
        )
        report = json.loads((here / material / "square_twist_thick_report.json").read_text())
        webs.append(report["settings"]["hinges"]["strain_max"])
        assert "hinge-strains" not in out.output
    assert webs == [0.5, 0.05]
    own = [*words, "--set", "hinges.strain_max=0.2", "--material", "petg_filament"]
    result = run("thicken", file, *own, "--dry-run", "--only", "stl")
    assert "hinge-strains" in result.output


def test_thicken_leaves_as_much_play_as_the_printer_needs(here):
    words = ["--set", "panels.axis=middle", "--set", "panels.thickness_mm=4.0", "--only", "stl"]
    words += ["--set", "panels.fold_limit_deg=60.0", "--set", "hinges.kind=knuckle"]
    words += ["--width-mm", "200", "--printer", "prusa_mk4s"]
    plays = []
    for own in ([], ["--set", "hinges.play_mm=0.25"]):
        result = run("thicken", PATTERNS / "square_twist.fold", *words, *own)
        report = json.loads((here / "square_twist_thick_report.json").read_text())
        plays.append(report["settings"]["hinges"]["play_mm"])
        assert ("gap-too-narrow" in result.output) == bool(own)
    assert plays == [0.3, 0.25]


def test_thicken_suggests_a_size_for_a_file(here):
    file = PATTERNS / "square_twist.fold"
    words = ["thicken", file, "--set", "panels.fold_limit_deg=150.0", "--suggest"]
    result = run(*words)
    assert result.exit_code == 0, result.output
    wide = re.search(r"this thickness with width_mm at least ([\d.]+)", result.output)[1]
    assert "9 of 9 faces" in run(*words, "--width-mm", wide).output
    less = str(0.99 * float(wide))
    assert "9 of 9 faces" not in run(*words, "--width-mm", less).output
    assert names_in(".") == []


def test_a_job_may_name_its_printer(here):
    job = (TEMPLATES / "miura.toml").read_text()
    printer = (TEMPLATES / "machines" / "prusa_mk4s.toml").read_text()
    Path("mine").mkdir()
    Path("mine/printer.toml").write_text(printer)
    table = '[printer]\nmachine = "{}"\nmaterial = "pla_filament"\n'
    Path("mine/job.toml").write_text(job + table.format("printer.toml"))
    result = run("run", "mine/job.toml", "--only", "stl", "--out", "out")
    report = json.loads(Path("out/miura_report.json").read_text())
    assert report["solids"]["mass_g"] > 0
    assert "hinge-breaks" in result.output
    Path("mine/job.toml").write_text(job + table.format("co2_40w_300x200"))
    result = run("run", "mine/job.toml", "--only", "stl", "--out", "other")
    assert result.exit_code == 2
    assert not Path("other").exists()


def test_a_sheet_that_crosses_itself_is_warned_of_when_made_and_when_checked(here):
    wide = ("design.sides=9", "design.crease_length=0.5", "design.random_seed=6")
    changes = [word for change in wide for word in ("--set", change)]
    made = run("run", TEMPLATES / "random_tube.toml", "--only", "fold", *changes)
    checked = run("check", "random_tube.fold")
    for result in (made, checked):
        assert result.exit_code == 0, result.output
        assert "warning: sheet-crosses-itself" in result.output
    assert "crossings           30" in checked.output


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
@pytest.mark.parametrize("delay_s", [0.8, 2.5, 4.0])
def test_ctrl_c_leaves_no_partial_file(here, delay_s):
    process = subprocess.Popen(
        [sys.executable, "-m", "fab", "run", str(TEMPLATES / "crumpled.toml"), "--out", "out"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    time.sleep(delay_s)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=120)
    assert process.returncode != 0
    assert b"Traceback" not in errors
    assert not (here / "out").exists() or not names_in("out")


def test_progress_is_silent_in_a_pipe(here):
    done = subprocess.run(
        [sys.executable, "-m", "fab", "run", str(TEMPLATES / "miura.toml"), "--only", "fold"],
        capture_output=True,
        check=True,
    )
    assert done.stderr == b""
    assert b"\x1b" not in done.stdout


@pytest.mark.skipif(sys.platform == "win32", reason="file names of POSIX")
def test_what_the_terminal_cannot_show_is_escaped(here):
    folder = os.fsdecode("ü".encode() + b"\xff")
    words = ["run", str(TEMPLATES / "miura.toml"), "--only", "svg", "--out", folder]
    done = subprocess.run(
        [sys.executable, "-m", "fab", *words],
        capture_output=True,
        check=True,
        env={**os.environ, "PYTHONIOENCODING": "ascii:strict"},
    )
    assert b"wrote \\xfc\\udcff/miura.svg" in done.stdout
    assert names_in(folder) == ["miura.svg", "miura_report.json"]


def printed_by(code):
    """What a script prints. It runs in this process: another takes seconds to load all again."""
    with redirect_stdout(io.StringIO()) as printed:
        exec(compile(code, "script", "exec"), {"__name__": "__main__"})
    return printed.getvalue()


def test_python_of_the_guide_runs(here):
    blocks = re.findall(r"```python\n(.*?)```", guide("python", "paper_figures"), re.DOTALL)
    (swept,) = [block for block in blocks if "fab.sweep(" in block]
    assert run("new", "miura", "--out", "mine.toml").exit_code == 0
    Path("script.py").write_text(swept)
    done = subprocess.run([sys.executable, "script.py"], capture_output=True, text=True, check=True)
    fold_deg, strain = map(float, done.stdout.split())
    assert fold_deg in (30.0, 50.0, 70.0)
    assert 0 < strain < 0.01
    blocks.remove(swept)
    shutil.rmtree("out")
    assert len(blocks) == 4
    assert "grown 360 faces" in printed_by(blocks[0])
    assert names_in("out") == ["sheet.dxf", "sheet.fold", "sheet_report.json"]
    assert run("run", TEMPLATES / "miura.toml", "--out", "out", "--only", "fold").exit_code == 0
    assert printed_by(blocks[1]) == "True {'M': 16, 'V': 12, 'F': 24, 'B': 24}\n"
    assert {"pleats.dxf", "pleats.fold"} <= set(names_in("out"))
    printed_by(blocks[2])
    folded = Path("folded.step").read_text()
    assert folded.count("MANIFOLD_SOLID_BREP(") == 80
    printed_by(blocks[3])
    assert Path("landscapes.svg").read_text().count("<svg") == 1


def test_the_page_about_laser_cutters_does_what_it_says(here):
    part = guide("laser_sheets")
    block = re.search(r"```sh\n(.*?)```", part, re.DOTALL)[1]
    lines = [line.partition("#")[0].split() for line in block.splitlines()]
    Path("out").mkdir()
    Path("out/curved_fold.fold").write_bytes(template_fold("curved_fold"))
    results = [run(*words[1:]) for words in lines]
    assert all(result.exit_code == 0 for result in results), results
    summary = re.search(r"`(\d+ pieces?, [^`]* g)`", part)[1]
    assert summary in results[-1].output
    kinds = [f"curved_fold_1.{kind}" for kind in ("dxf", "pdf", "svg")]
    assert names_in("sheets") == [
        *kinds,
        "curved_fold_assembly.pdf",
        "curved_fold_sheets.html",
        "curved_fold_sheets_report.json",
    ]
    assert "`curved_fold_assembly.pdf`" in part
    assert "`curved_fold_sheets.html`" in part
    assert "`curved_fold_sheets_report.json`" in part
    assert run(*lines[-1][1:], "--two-sided", "--only", "dxf").exit_code == 0
    for side in re.findall(r"`(curved_fold_1_\w+)`", part):
        assert f"{side}.dxf" in names_in("sheets")


def test_the_files_for_machines_of_the_guide_are_made(here):
    """The powers of the page, put where it says, reach the files."""
    part = guide("laser_sheets").partition("Files that a machine follows")[2]
    powers = re.search(r"`(powers = [^`]*)`", part)[1]
    shipped = (TEMPLATES / "machines" / "co2_60w_600x400.toml").read_text()
    Path("mine.toml").write_text(shipped.replace("[speeds]", f"{powers}\n\n[speeds]", 1))
    Path("out").mkdir()
    Path("out/curved_fold.fold").write_bytes((PATTERNS / "square_twist.fold").read_bytes())  # quick
    for line in re.search(r"```sh\n(.*?)```", part, re.DOTALL)[1].splitlines():
        result = run(*line.partition("#")[0].split()[1:], "--width-mm", "150")
        assert result.exit_code == 0, result.output
        assert "power-unset" not in result.output
    assert len(read_plotter(Path("knife/curved_fold_1.plt").read_bytes()).strokes) > 100
    assert "`curved_fold_1_frame.gcode`" in part
    assert read_grbl(Path("machine/curved_fold_1_frame.gcode").read_bytes()).strokes == []
    run_of = read_grbl(Path("machine/curved_fold_1.gcode").read_bytes())
    assert {tool: power for tool, (power, _) in run_of.settings.items()} == {
        "MOUNTAIN": 700,
        "VALLEY": 700,
        "CUT": 800,
    }
    project = read_lightburn(Path("machine/curved_fold_1.lbrn2").read_bytes())
    assert {name: float(layer["maxPower"]) for name, layer in project.layers.items()} == {
        "MOUNTAIN": 70,
        "VALLEY": 70,
        "CUT": 80,
    }


def test_the_page_about_printers_does_what_it_says(here):
    block = re.search(r"```sh\n(.*?)```", guide("thick_panels"), re.DOTALL)[1]
    lines = [line.partition("#")[0].split() for line in block.splitlines()]
    Path("out").mkdir()
    Path("out/miura.fold").write_bytes(template_fold("miura"))
    Path("theirs.fold").write_bytes((PATTERNS / "square_twist.fold").read_bytes())
    results = [run(*words[1:]) for words in lines]
    assert [result.exit_code for result in results] == [0, 0, 0, 0], results
    assert "Turn each plug" in results[0].output
    assert "coupon_prusa_mk4s_pp_filament.3mf" in names_in("print")
    assert "fold-blocked" in results[3].output
    kinds = [f"miura_thick.{kind}" for kind in ("3mf", "html", "png", "step", "stl")]
    others = ["miura_thick_assembly.pdf", "miura_thick_report.json"]
    assert names_in("solid") == sorted([*kinds, *others])


def test_commands_of_the_documentation_exist():
    pages = [ROOT / "README.md", *sorted(DOCS.rglob("*.md"))]
    text = "\n".join(page.read_text("utf-8") for page in pages)
    for command in set(re.findall(r"^quadfold (\w+)", text, re.MULTILINE)):
        assert run(command, "--help").exit_code == 0, command
    assert run("--version").exit_code == 0


def test_the_jobs_of_the_guide_are_jobs():
    import tomllib

    from fab.jobs.job import parse_job
    from fab.jobs.job_files import make

    text = guide("jobs", "strip_by_strip", "surfaces", "laser_sheets")
    blocks = re.findall(r"```toml\n(.*?)```", text, re.DOTALL)
    job, by_hand, dome, goals, grown, sheets = map(tomllib.loads, blocks)
    assert parse_job(job).name == "miura"
    assert len(make(parse_job({**job, **sheets}), ["dxf"]).report["sheets"]) == 1
    assert make(parse_job(by_hand), []).report["counts"]["faces"] == 21
    assert parse_job(dome).sheet.folded_width_mm == 300.0
    assert parse_job({**dome, **goals}).goals.least_side_mm == 8.0
    assert parse_job({**job, **grown}).design.method == "grow"


def test_the_dome_of_the_guide_is_made_from_its_file(here):
    from solver.designs.surface_fit import SURFACES
    from solver.relaxed_fit import sampled

    mesh = sampled(SURFACES["dome"])
    trimesh.Trimesh(80 * mesh.vertices_coords, mesh.faces_vertices).export("dome.stl")
    (text,) = re.findall(r'```toml\n(name = "dome".*?)```', guide("surfaces"), re.DOTALL)
    Path("dome.toml").write_text(text)
    words = ["--set", "design.columns=14", "--only", "fold", "--out", "out"]
    result = run("run", "dome.toml", *words)
    assert result.exit_code == 0, result.output
    flat, folded = re.search(
        r"^flat (.*) mm; folded (.*) mm$", result.output, re.MULTILINE
    ).groups()
    assert max(map(float, folded.split(" x "))) == 300.0
    report = json.loads(Path("out/dome_report.json").read_text())
    assert [float(side) for side in flat.split(" x ")] == pytest.approx(
        report["bounding_box_mm"]["flat"], rel=1e-3
    )
    assert report["growth"]["coverage"] > 0.99
    figures = {"mean_mm", "rms_mm", "lowest_mm", "highest_mm", "largest_mm"}
    assert set(report["growth"]["deviation"]) == figures
    assert report["growth"]["chosen"]["sheets"] == 1


def test_the_page_about_your_own_pattern_does_what_it_says(here):
    blocks = re.findall(r"```sh\n(.*?)```", guide("own_patterns", "convert"), re.DOTALL)
    assert len(blocks) == 2
    rim = [(0, 0), (30, 0), (70, 0), (100, 0), (100, 60), (70, 60), (30, 60), (0, 60), (0, 0)]
    rows = ["1 {} {} {} {}".format(*p, *q) for p, q in pairwise(rim)]
    (here / "step.cp").write_text("\n".join([*rows, "2 30 0 30 60", "3 70 0 70 60"]))
    assert run("convert", "step.cp", "step.dxf").exit_code == 0
    assert run("convert", PATTERNS / "square_twist.fold", "twist.svg").exit_code == 0
    (here / "theirs.fold").write_bytes(template_fold("miura"))
    assert run("convert", "theirs.fold", "miura.dxf").exit_code == 0
    for line in "".join(blocks).splitlines():
        words = shlex.split(line, comments=True)
        if words[1:3] == ["convert", "first.obj"]:
            for old, new in (("flat", "first"), ("fold", "second")):
                (here / f"sheet_{old}.obj").rename(here / f"{new}.obj")
        result = run(*words[1:])
        assert result.exit_code == 0, result.output
    assert {"twist.png", "twist.fold", "sheet.dxf", "sheet.cp", "sheet.fold"} <= set(names_in("."))
    assert "twist_1.dxf" in names_in("sheets")
    assert "step_thick.stl" in names_in("solid")
    assert "step_folding.gif" in names_in("folding")


def test_the_options_of_reading_of_the_guide_exist():
    table = guide("own_patterns").partition("| option |")[2].partition("\n\n")[0]
    named = set(re.findall(r"`(--[a-z-]+)", table))
    assert len(named) == 13
    assert named <= set(re.findall(r"--[a-z-]+", run("fabricate", "--help").output))


def test_the_three_things_of_the_readme_are_done(here):
    text = (ROOT / "README.md").read_text()
    assert len(text.splitlines()) <= 150
    part = text.partition("## Three things")[2].partition("\n## ")[0]
    assert run("convert", PATTERNS / "square_twist.fold", "twist.svg").exit_code == 0
    blocks = re.findall(r"```sh\n(.*?)```", part, re.DOTALL)
    assert len(blocks) == 3
    for line in "".join(blocks).splitlines():
        result = run(*shlex.split(line)[1:])
        assert result.exit_code == 0, result.output
    assert "twist_1.dxf" in names_in("sheets")
    assert "miura_thick.step" in names_in("solid")
    assert {"lamp_shade.png", "lamp_shade_folding.gif"} <= set(names_in("lamp"))
