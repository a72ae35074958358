"""Jobs with a cutter make the sheets of `fabricate`, others say what their drawing lacks."""

from __future__ import annotations

import io
from xml.etree import ElementTree

import ezdxf
import pytest
from click.testing import CliRunner
from flat_patterns import strips
from helpers import TEMPLATES

from fab import read_pattern
from fab.catalogue import shipped
from fab.cli.group import main
from fab.drawings.cut_paths import Operation, polylines
from fab.drawings.drawing_files import SheetFormat
from fab.errors import InvalidJob, Severity
from fab.jobs.job import parse_job
from fab.jobs.job_files import make
from fab.jobs.sheet_files import fabricate
from fab.sheets.cut_pieces import cut_pattern
from fab.sheets.cutter_settings import CutterSettings
from fab.sheets.labels import number_text

STOCK = {"material": "card_300gsm", "machine": "co2_40w_300x200"}
MIURA = {"kind": "miura", "columns": 6, "rows": 6}
JOB = {"name": "m", "design": MIURA, "sheet": {"width_mm": 250.0}}
DASHES = {"margin_mm": 1.0, "valley": {"cut_mm": 2.0, "gap_mm": 1.5}}


def engravings(layers):
    return sum(len(polylines(x)) for x in layers if x.operation is Operation.ENGRAVE)


@pytest.mark.parametrize(
    ("keys", "perforation"),
    [
        ({}, {}),
        ({"copies": 3, "sheets": 1}, DASHES),
        ({"two_sided": True}, DASHES),
        ({"machine": "knife_a3_roll", "grain_deg": 90.0}, {}),
    ],
)
def test_a_job_makes_the_sheets_of_its_fold_file(tmp_path, keys, perforation):
    table = {**STOCK, **keys}
    job = parse_job({**JOB, "cutter": table, "perforation": perforation})
    kinds = ["dxf", "svg", "pdf", "lbrn2", "plt"]
    ran = make(job, ["fold", *kinds])
    (tmp_path / "m.fold").write_bytes(ran.files["m.fold"])
    pattern, _ = read_pattern(tmp_path / "m.fold")
    request = CutterSettings(**table).request(
        [SheetFormat(kind) for kind in kinds], perforation=job.perforation, page=False
    )
    made = fabricate(pattern, "m", request)
    drawings = {name: data for name, data in made.files.items() if name != "m_sheets_report.json"}
    assert len(drawings) >= len(kinds)
    assert drawings.items() <= dict(ran.files).items()
    assert set(ran.files) == {"m.fold", "m_report.json", *drawings}
    for key in ("sheets", "pieces", "glue_up", "patterns", "copies", "material", "machine"):
        assert ran.report[key] == made.report[key]
    assert set(made.findings) <= set(ran.findings)
    assert "no-kerf" not in {finding.code for finding in ran.findings}


def test_gcode_is_made_for_a_machine_of_ones_own_beside_the_job(tmp_path):
    text = shipped("machines")["co2_40w_300x200"].read_text()
    powers = "powers = { cut_percent = 80, perforate_percent = 70, engrave_percent = 20 }\n"
    head, speeds, rest = text.partition("[speeds]")
    (tmp_path / "mine.toml").write_text(head + powers + speeds + rest)
    job = parse_job({**JOB, "cutter": {**STOCK, "machine": "mine.toml"}}, folder=tmp_path)
    made = make(job, ["gcode"])
    assert {"m_1.gcode", "m_1_frame.gcode"} <= set(made.files)


@pytest.mark.parametrize("kinds", [["svg", "html"], ["html"]])
def test_the_page_of_a_job_shows_its_sheets(kinds):
    page = make(parse_job({**JOB, "cutter": STOCK}), kinds).files["m.html"].decode()
    for text in ("m_1", "m_2", "Cutting", "Assembly order", "pierces"):
        assert text in page
    assert "As it is cut" not in page


def test_a_drawing_for_no_machine_says_so_in_its_files_and_findings():
    made = make(parse_job(JOB), ["dxf", "svg", "fold"])
    (note,) = (finding for finding in made.findings if finding.code == "no-kerf")
    assert note.severity is Severity.NOTE
    assert "[cutter]" in note.text
    remark = "lines are drawn without kerf, for no machine"
    root = ElementTree.fromstring(made.files["m.svg"])
    assert [each.text for each in root if each.tag.endswith("desc")] == [remark]
    text = made.files["m.dxf"].decode()
    assert text.startswith(f"999\n{remark}\n  0\nSECTION\n")
    assert not ezdxf.read(io.StringIO(text)).audit().errors
    assert "no-kerf" not in {finding.code for finding in make(parse_job(JOB), ["fold"]).findings}


def test_drawings_for_no_machine_are_read_as_before(tmp_path):
    """The remark is no line, text or finding for who reads the drawing."""
    made = make(parse_job(JOB), ["dxf", "svg"])
    for name in ("m.dxf", "m.svg"):
        (tmp_path / name).write_bytes(made.files[name])
        pattern, findings = read_pattern(tmp_path / name)
        assert pattern.face_count > 0
        assert not [f for f in findings if "text" in f.text or "kerf" in f.text]


@pytest.mark.parametrize("kind", ["lbrn2", "plt", "gcode"])
def test_what_a_machine_follows_needs_one(kind):
    with pytest.raises(InvalidJob, match=rf"{kind}: the job names no machine"):
        make(parse_job(JOB), [kind])


def test_points_where_rims_meet_are_numbered_on_the_pieces():
    request = CutterSettings(material="card_300gsm", machine="co2_60w_600x400").request()
    apart = cut_pattern(strips(0.05, 2, 3), request)
    assert apart.meeting is not None
    assert not apart.pieces.seams
    texts = [[label.text for label in piece.labels] for piece in apart.pieces.pieces]
    assert texts == [[name, *map(number_text, range(1, 8))] for name in ("A", "B")]
    assert all(engravings(layers) >= 8 for layers in apart.layers)
    made = fabricate(strips(0.05, 2, 3), "m", request)
    assert [f.code for f in made.findings].count("rims-meet") == 1
    assert made.report["seams"]["points"] == 7


def test_points_of_rims_that_are_glued_as_a_whole_have_the_number_of_their_seam():
    request = CutterSettings(material="card_300gsm", machine="co2_60w_600x400").request()
    touching = cut_pattern(strips(0.0, 2, 3), request)
    assert len(touching.pieces.seams) == 6
    texts = [label.text for piece in touching.pieces.pieces for label in piece.labels]
    assert not [text for text in texts if text.startswith("p")]


def test_a_sheet_that_overlaps_itself_is_cut_into_pieces_that_do_not():
    design = {"kind": "curved_fold", "columns": 60}
    document = {"name": "m", "design": design, "sheet": {"width_mm": 200.0}, "cutter": STOCK}
    severity = {}
    for kinds in (["svg"], ["fold"]):
        made = make(parse_job(document), kinds)
        (found,) = (f for f in made.findings if f.code == "development-overlaps")
        severity[kinds[0]] = found.severity
        assert made.within_tolerance == (kinds == ["svg"])
    assert severity == {"svg": Severity.NOTE, "fold": Severity.ERROR}


def test_a_dry_run_says_sheets_and_minutes(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    words = ["run", str(TEMPLATES / "miura.toml"), "--dry-run", "--only", "dxf"]
    words += [part for key, name in STOCK.items() for part in ("--set", f"cutter.{key}={name}")]
    result = CliRunner().invoke(main, words)
    assert result.exit_code == 0, result.output
    assert "2 pieces, 8 seams, 2 sheets of 300 x 200 mm, about" in result.output
    assert "would write miura_1.dxf" in result.output
    assert not list(tmp_path.iterdir())
