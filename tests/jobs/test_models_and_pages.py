"""Models and result pages of every command: what they are called, and what they hold."""

import base64
import hashlib
import json
import re
import zlib
from functools import cache

import numpy as np
import pytest
from glb_reading import read_glb
from helpers import PATTERNS, TEMPLATES

from fab import read_pattern
from fab.errors import Finding, Severity
from fab.formats.read_options import ReadOptions
from fab.jobs.folding_files import SimulationFormat, simulate
from fab.jobs.job import load_job
from fab.jobs.job_files import make
from fab.jobs.print_files import ThickFormat, make_thick
from fab.jobs.reading import read_sheet
from fab.jobs.sheet_files import fabricate
from fab.printing.thick_settings import thick_settings
from fab.sheets.materials import load_machine, load_material
from fab.sheets.sheet_request import SheetRequest

SMALL = ["design.columns=5", "design.rows=4", "sheet.width_mm=90.0"]


@cache
def ran(*formats, limit=False):
    changes = [*SMALL, "panels.fold_limit_deg=80.0"] if limit else SMALL
    return make(load_job(TEMPLATES / "miura.toml", changes), formats)


def data_of(page):
    text = re.search(rb'<script type="application/json" id="data">(.*?)</script>', page, re.DOTALL)
    return json.loads(text[1])


def test_a_run_makes_a_model_of_its_sheet_and_one_of_its_panels():
    assert set(ran("glb").files) == {"miura.glb", "miura_report.json"}
    made = ran("glb", "stl")
    assert set(made.files) == {"miura.stl", "miura.glb", "miura_thick.glb", "miura_report.json"}
    assert [mesh.name for mesh in read_glb(made.files["miura.glb"]).meshes] == ["miura"]
    names = {node.name for node in read_glb(made.files["miura_thick.glb"]).nodes}
    assert names == {"hinges", *(f"panel_{face}" for face in range(20))}


def test_panels_of_a_model_fold_as_far_as_they_are_made_for_and_the_sheet_to_its_target():
    made = ran("glb", "stl", "html", limit=True)
    states = made.report["solids"]["states"]
    panels, sheet = (read_glb(made.files[f"miura{end}.glb"]) for end in ("_thick", ""))
    hinges = next(mesh for mesh in panels.meshes if mesh.name == "hinges")
    assert hinges.extras["targetNames"][-1] == states[-1]["state"]
    assert len(hinges.extras["targetNames"]) == len(states) - 1
    assert sheet.meshes[0].extras["targetNames"][-1] == "1"
    data = data_of(made.files["miura.html"])
    assert data["panelsState"] == len(states) - 1 < len(data["states"]) - 1


def test_a_page_without_panels_asks_for_none():
    data = data_of(ran("html").files["miura.html"])
    assert data["bodies"] is None
    assert data["states"][0] == "flat"
    assert data["states"][-1] == "100% of the fold"
    assert len(data["states"]) == 11


def test_a_run_that_simulates_shows_the_states_of_its_simulation():
    job = load_job(TEMPLATES / "miura.toml", [*SMALL, "simulation.steps=4"])
    data = data_of(make(job, ["html"]).files["miura.html"])
    assert data["states"] == ["flat", *(f"{share}% of the fold" for share in (25, 50, 75, 100))]


def test_pages_list_all_files_with_their_hashes_and_are_in_the_report():
    made = ran("fold", "stl", "png", "html")
    page = made.files["miura.html"].decode()
    for name, data in made.files.items():
        if name in ("miura.html", "miura_report.json"):
            continue
        row = rf'<a href="{name}">{name}</a></td><td>{len(data)}</td>'
        assert row + f'<td class="hash">{hashlib.sha256(data).hexdigest()}</td>' in page
    (entry,) = [each for each in made.report["outputs"] if each["file"] == "miura.html"]
    assert entry["sha256"] == hashlib.sha256(made.files["miura.html"]).hexdigest()


def test_the_same_job_gives_the_same_page_and_models():
    again = make(load_job(TEMPLATES / "miura.toml", SMALL), ["glb", "stl", "png", "html"])
    first = ran("glb", "stl", "png", "html")
    for name in set(first.files) - {"miura_report.json"}:
        assert again.files[name] == first.files[name]


def test_a_page_of_sheets_has_each_sheet_its_minutes_and_the_order_of_gluing():
    read = read_sheet(PATTERNS / "yoshimura.fold", ReadOptions(), width_mm=900.0, factor=None)
    request = SheetRequest(load_material("card_300gsm"), load_machine("co2_60w_600x400"))
    made = fabricate(read.pattern, "yoshimura", request)
    page = made.files["yoshimura_sheets.html"].decode()
    sheets = made.report["sheets"]
    assert len(sheets) > 1
    for number, _ in enumerate(sheets, 1):
        assert f'aria-label="yoshimura_{number}"' in page
    assert f"{sum(sheet['minutes'] for sheet in sheets):.5g}</td>" in page
    order = page.partition(">Assembly order</h2>")[2].partition("</section>")[0]
    labels = re.findall(r"<tbody class=\"rows\"><tr><td>(.*?)</td>|<tr><td>(.*?)</td>", order)
    glued = [first or second for first, second in labels]
    assert glued[-len(made.report["glue_up"]) :] == [
        str(seam["label"]) for seam in made.report["glue_up"]
    ]
    none = fabricate(
        read.pattern, "yoshimura", SheetRequest(request.material, request.machine, page=False)
    )
    assert set(made.files) - set(none.files) == {"yoshimura_sheets.html"}


@pytest.mark.parametrize("name", ["square_twist", "popup", "resch", "crane"])
def test_patterns_of_all_kinds_have_pages_and_models(name):
    pattern, findings = read_pattern(PATTERNS / f"{name}.fold")
    made = simulate(pattern, name, formats=["glb", "html"], findings=findings)
    data = data_of(made.files[f"{name}_folding.html"])
    assert len(data["findings"]) == len(made.findings)
    targets = read_glb(made.files[f"{name}_folding.glb"]).meshes[0].extras["targetNames"]
    assert len(targets) == len(data["states"]) - 1 == 10


@pytest.mark.parametrize("command", ["thicken", "fabricate", "simulate"])
def test_findings_of_sheets_with_cuts_light_up_the_creases_that_they_name(command):
    pattern, _ = read_pattern(PATTERNS / "popup.fold")
    inner = np.flatnonzero(np.isin(pattern.edges_assignment, ["M", "V"]))
    finding = Finding("made-up", Severity.NOTE, "", creases=tuple(inner.tolist()))
    if command == "thicken":
        settings = thick_settings(["panels.fold_limit_deg=80.0"], None, None)
        made = make_thick(pattern, "x", settings, formats=[ThickFormat.HTML], findings=[finding])
    elif command == "fabricate":
        request = SheetRequest(load_material("card_300gsm"), load_machine("co2_60w_600x400"))
        made = fabricate(pattern, "x", request, findings=[finding])
    else:
        made = simulate(pattern, "x", formats=[SimulationFormat.HTML], findings=[finding])
    (page,) = [data for name, data in made.files.items() if name.endswith(".html")]
    data = data_of(page)
    ends = unpacked(data["pattern"]["coords"])[unpacked(data["pattern"]["edges"])]
    number = [each.code for each in made.findings].index("made-up")
    found = ends[data["findings"][number]["creases"]]
    expected = pattern.vertices_coords[pattern.edges_vertices[inner]]
    assert in_order(found) == pytest.approx(in_order(expected), abs=1e-4)


def unpacked(entry):
    kind = {"f32": "<f4", "u16": "<u2"}[entry["kind"]]
    return np.frombuffer(zlib.decompress(base64.b64decode(entry["zlib"])), kind).reshape(-1, 2)


def in_order(lines):
    """Lines (n, 2, 2) in one order, whichever end is first."""
    return np.array(sorted(sorted(line.tolist()) for line in np.round(lines, 3)))


def test_thick_sheets_without_a_panel_have_no_page():
    pattern, _ = read_pattern(PATTERNS / "square_twist.fold")
    settings = thick_settings(["panels.thickness_mm=500.0"], None, None)
    made = make_thick(pattern, "twist", settings, formats=list(ThickFormat))
    assert set(made.files) == {"twist_thick_report.json"}
    assert not made.within_tolerance
