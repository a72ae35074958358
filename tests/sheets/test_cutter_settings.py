"""The table of sheets: keys, files and options become one request."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner
from flat_patterns import grid

from fab.catalogue import shipped
from fab.cli.group import main
from fab.drawings.drawing_files import SheetFormat
from fab.errors import InvalidJob, Severity
from fab.jobs.job import parse_job
from fab.jobs.sheet_files import fabricate
from fab.sheets.crease_styles import DashStyle
from fab.sheets.cutter_settings import CutterSettings, cutter_tables
from fab.sheets.materials import load_machine, load_material
from fab.sheets.perforation_settings import PerforationSettings
from fab.sheets.registration import Registration
from fab.sheets.sheet_request import SheetRequest

STOCK = {"material": "card_300gsm", "machine": "co2_40w_300x200"}
JOB = {"name": "m", "design": {"kind": "miura"}, "sheet": {"width_mm": 90.0}}


def test_a_request_is_what_the_keys_say():
    settings = CutterSettings(**STOCK, copies=3, sheets=2, two_sided=True)
    kinds = [SheetFormat.PLT]
    expected = SheetRequest(
        load_material("card_300gsm"),
        load_machine("co2_40w_300x200"),
        3,
        Registration(),
        kinds,
        page=False,
        stock_sheets=2,
    )
    assert settings.request(kinds, page=False) == expected


def test_own_files_are_looked_for_beside_the_job(tmp_path):
    for folder, name in (("materials", "card_300gsm"), ("machines", "co2_40w_300x200")):
        text = shipped(folder)[name].read_text().replace("margin_mm = 5.0", "margin_mm = 7.0")
        (tmp_path / f"{folder}.toml").write_text(text)
    table = {"material": "materials.toml", "machine": "machines.toml"}
    job = parse_job({**JOB, "cutter": table}, folder=tmp_path)
    assert job.cutter is not None
    assert job.cutter.request(folder=job.folder).margin_mm == 7.0
    with pytest.raises(InvalidJob, match=r"^materials\.toml: cannot be read"):
        job.cutter.request()


def test_creases_are_those_of_the_job_where_it_has_them_and_else_of_the_material():
    dots = PerforationSettings(valley=DashStyle(cut_mm=2.0, gap_mm=2.0), margin_mm=1.5)
    creases = CutterSettings(**STOCK).request(perforation=dots).perforation
    material = load_material("card_300gsm").perforation
    assert creases == material.model_copy(update={"valley": dots.valley, "margin_mm": 1.5})
    assert creases.mountain == material.mountain
    assert CutterSettings(**STOCK).request(perforation=PerforationSettings()) == (
        CutterSettings(**STOCK).request()
    )
    whole = {**STOCK, "machine": "diode_10w_400x400"}
    assert CutterSettings(**whole).request(perforation=dots).perforation.margin_mm == 1.5
    assert CutterSettings(**whole).request(perforation=dots).perforation.valley.kind == "score"


def test_options_prevail_over_changes():
    tables = cutter_tables(["cutter.copies=3", "cutter.sheets=2"], {**STOCK, "copies": 5})
    assert tables.cutter == CutterSettings(**STOCK, copies=5, sheets=2)
    tables = cutter_tables(["perforation.margin_mm=2.0"], STOCK)
    assert tables.perforation is not None
    assert tables.perforation.model_fields_set == {"margin_mm"}


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ("cutter.copy=3", r"cutter\.copy is not a known key\. Did you mean cutter\.copies\?"),
        ("cutter=3", r"cutter = 3 must be a table"),
        ("cutter.sheets=0", r"cutter\.sheets = 0 is out of bounds: it must be at least 1"),
        ("panels.thickness_mm=3.0", "panels is not a known key"),
    ],
)
def test_what_no_sheet_has_is_refused(change, text):
    with pytest.raises(InvalidJob, match=text):
        cutter_tables([change], STOCK)


def test_a_job_names_its_material_and_machine():
    with pytest.raises(InvalidJob, match=r"cutter\.machine is missing"):
        parse_job({**JOB, "cutter": {"material": "card_300gsm"}})
    assert parse_job(JOB).cutter is None


@pytest.mark.parametrize("sheets", [None, 1, 2, 3])
def test_more_sheets_than_are_at_hand_are_a_warning(sheets):
    request = CutterSettings(**STOCK, copies=2, sheets=sheets).request(
        [SheetFormat.SVG], page=False
    )
    made = fabricate(grid(2, 1, 100.0), "board", request)
    assert len(made.report["sheets"]) == 2
    short = [finding for finding in made.findings if finding.code == "sheets-short"]
    assert len(short) == (sheets == 1)
    for finding in short:
        assert finding.severity is Severity.WARNING
        assert finding.text.startswith("2 sheets are needed, cutter.sheets = 1 at hand: get 1 more")


def test_any_key_is_set_on_the_command_line(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    from fab.formats.fold.writer import fold_bytes

    Path("board.fold").write_bytes(fold_bytes(grid(2, 1, 100.0), "board"))
    words = ["fabricate", "board.fold", "--material", STOCK["material"], "--only", "svg"]
    sets = ["--set", f"cutter.machine={STOCK['machine']}", "--set", "cutter.copies=2"]
    result = CliRunner().invoke(main, [*words, *sets, "--set", "cutter.sheets=1"])
    assert result.exit_code == 0, result.output
    assert "2 sheets are needed, cutter.sheets = 1 at hand" in result.output
    assert Path("board_2.svg").exists()
    result = CliRunner().invoke(main, [*words, "--set", "cutter.machine=laser"])
    assert result.exit_code == 2
    assert "machine 'laser' must be one of" in result.output


@pytest.mark.parametrize("value", ["1e9", "-1e9", '"no"', "[]", "[7.5]", "nan", "true"])
@pytest.mark.parametrize("key", sorted(CutterSettings.model_fields))
def test_a_wrong_value_of_any_key_is_refused_in_words_of_our_own(key, value):
    given = {name: stock for name, stock in STOCK.items() if name != key}
    try:
        cutter_tables([f"cutter.{key}={value}"], given)
    except InvalidJob as refusal:
        text = str(refusal)
        assert f"cutter.{key}" in text
        assert "must" in text
        assert "nput should" not in text
