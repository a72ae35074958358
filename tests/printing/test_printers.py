"""Printers and what they print: every shipped file, every refusal, every bound from both sides."""

import tomllib
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner
from thick_sheets import SIDE_MM, book, solid

from fab.catalogue import known_of, shipped
from fab.clearance.soundness import inspect_solids
from fab.cli.group import main
from fab.errors import InvalidJob, Severity
from fab.geometry.bodies import TriangleMesh
from fab.geometry.booleans import joined_mesh, manifolds
from fab.panels.bevelled_panels import PanelSettings
from fab.panels.hinges import HingeSettings
from fab.panels.panel_widths import panel_widths_mm
from fab.panels.thick_sheet import thicken
from fab.printing.printability import (
    bed_area_mm2,
    inspect_print,
    inspect_webs,
    print_figures,
)
from fab.printing.printers import load_print_material, load_printer
from fab.sheets.materials import load_machine, load_material

PRINTERS, PRINTED = known_of("printer"), known_of("print")


def test_all_that_is_promised_is_shipped():
    assert set(PRINTERS) == {
        "prusa_mk4s",
        "bambu_x1c",
        "bambu_a1_mini",
        "ender_3",
        "large_format_fdm",
        "sls_nylon",
    }
    assert {name.split("_")[0] for name in PRINTED} == {"pla", "petg", "pp", "tpu", "nylon"}
    for folder, kinds in (("machines", "cutter printer"), ("materials", "sheet print")):
        listed = CliRunner().invoke(main, ["shipped", folder]).output.splitlines()
        assert [line.split()[0] for line in listed] == list(shipped(folder))
        assert {line.split()[1] for line in listed} == set(kinds.split())


@pytest.mark.parametrize("name", PRINTERS)
def test_every_printer_is_sound(name):
    printer = load_printer(name)
    assert all(0 < room < side for room, side in zip(printer.room_mm, printer.bed_mm, strict=True))
    assert 0.25 * printer.nozzle_mm <= printer.layer_mm <= 0.75 * printer.nozzle_mm
    assert "least_gap_mm" in printer.starting_points
    text = PRINTERS[name].read_text()
    assert "# Based on: " in text
    sizes = f"{printer.bed_mm[0]:g} x {printer.bed_mm[1]:g} x {printer.height_mm:g} mm"
    assert sizes in printer.description


@pytest.mark.parametrize("name", PRINTED)
def test_every_print_material_is_sound(name):
    material = load_print_material(name)
    assert 800 < material.density_kg_m3 < 1400
    assert (material.strain_max is None) == (name == "pla_filament")
    assert "# Based on: " in PRINTED[name].read_text()


def test_what_cuts_and_what_prints_are_not_taken_for_each_other(tmp_path):
    with pytest.raises(InvalidJob, match="'prusa_mk4s' is a printer, not a cutter: it must be one"):
        load_machine("prusa_mk4s")
    with pytest.raises(InvalidJob, match="'knife_a4' is a cutter, not a printer: it must be one"):
        load_printer("knife_a4")
    with pytest.raises(InvalidJob, match="'pla_filament' is a print, not a sheet"):
        load_material("pla_filament")
    with pytest.raises(InvalidJob, match="'card_300gsm' is a sheet, not a print"):
        load_print_material("card_300gsm")
    with pytest.raises(InvalidJob, match="Did you mean prusa_mk4s"):
        load_printer("prusa_mk4")
    mine = tmp_path / "mine.toml"
    mine.write_text(PRINTERS["ender_3"].read_text())
    assert load_printer(mine) == load_printer("ender_3")
    with pytest.raises(InvalidJob, match=r"kind = 'printer' must be 'cutter' here"):
        load_machine(mine)
    words = ["coupon", "--material=card_300gsm", "--machine=ender_3", f"--out={tmp_path / 'out'}"]
    result = CliRunner().invoke(main, words)
    assert result.exit_code == 2
    assert "is a printer, not a cutter" in result.output
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("old", "new", "match"),
    [
        ("margin_mm = 5.0", "margin_mm = 110.0", "margin_mm = 110 leaves nothing"),
        ("layer_mm = 0.2", "layer_mm = 0.5", "layer_mm = 0.5 must be at most nozzle_mm = 0.4"),
        ("overhang_deg = 45.0", "overhang_deg = 95.0", "at least 0 and at most 90"),
        ("bed_mm = [220.0, 220.0]", "bed_mm = [220.0, 0.0]", "both sides must be above 0"),
        ("extruders = 1", "extruders = 0", "at least 1"),
        ("nozzle_mm = 0.4", "nozle_mm = 0.4", "Did you mean nozzle_mm"),
        ('"bridge_mm"]', '"bridge"]', "names bridge, which is no key here"),
        ('kind = "printer"', 'kind = "plotter"', "kind = 'plotter' must be 'printer' here"),
    ],
)
def test_printers_that_cannot_be_right_are_refused(tmp_path, old, new, match):
    text = PRINTERS["ender_3"].read_text()
    assert old in text
    (tmp_path / "mine.toml").write_text(text.replace(old, new, 1))
    with pytest.raises(InvalidJob) as refused:
        load_printer(tmp_path / "mine.toml")
    assert match in str(refused.value)


def test_every_number_of_a_printer_names_its_unit():
    for name in PRINTERS:
        document = tomllib.loads(PRINTERS[name].read_text())
        for key, value in document.items():
            if isinstance(value, float | list) and key != "starting_points":
                assert key.endswith(("_mm", "_deg")), key


def printed(sheet, printer, **changes):
    joined = joined_mesh(sheet.joining)
    return inspect_print(sheet, joined, printer.model_copy(update=changes))


PRINTER = load_printer("bambu_x1c")


def only(findings, code, severity=Severity.WARNING):
    """Exactly this finding, or none."""
    assert [f.code for f in findings] in ([], [code])
    assert all(f.severity == severity for f in findings)
    return bool(findings)


def test_a_gap_below_the_printers_is_reported():
    sheet = solid(book(0.0), thickness_mm=1.0, gap_mm=0.3)
    assert not only(printed(sheet, PRINTER, least_gap_mm=0.3), "gap-too-narrow")
    assert only(printed(sheet, PRINTER, least_gap_mm=0.301), "gap-too-narrow")


def test_a_play_below_the_printers_gap_is_reported():
    panel = PanelSettings(thickness_mm=3.2, axis="middle")
    hinge = HingeSettings(kind="knuckle", knuckle_mm=3.0, play_mm=0.28)
    sheet, _ = thicken(book(0.0), panel, hinge)
    assert len(sheet.held) == 1
    assert not only(printed(sheet, PRINTER, least_gap_mm=0.28), "gap-too-narrow")
    findings = printed(sheet, PRINTER, least_gap_mm=0.281)
    (finding,) = [finding for finding in findings if finding.code == "gap-too-narrow"]
    assert finding.creases == tuple(sheet.held.tolist())
    assert "1 knuckle has a play that is narrower" in finding.text
    assert "the least is 0.28 mm: they fuse. Raise play_mm" in finding.text


def test_webs_are_at_least_one_layer_and_whole_layers():
    sheet = solid(book(0.0), thickness_mm=1.0, gap_mm=0.5)  # webs of 0.2 mm
    assert printed(sheet, PRINTER, layer_mm=0.2) == printed(sheet, PRINTER, layer_mm=0.1) == []
    assert only(printed(sheet, PRINTER, layer_mm=0.15), "web-between-layers", Severity.NOTE)
    found = printed(sheet, PRINTER, layer_mm=0.25)
    assert only(found, "web-too-thin", Severity.ERROR)
    assert len(found[0].creases) == 1


def test_sides_that_lean_out_are_reported_by_their_angle():
    """With the axis in the middle a mountain of 60 degrees leans out by 30 below."""
    sheet = solid(book(-60.0), thickness_mm=1.0, gap_mm=0.5, axis="middle")
    assert not only(printed(sheet, PRINTER, overhang_deg=30.0), "overhang-too-flat")
    found = printed(sheet, PRINTER, overhang_deg=29.9)
    assert only(found, "overhang-too-flat")
    assert found[0].panels == (0, 1)
    bottom = solid(book(-60.0), thickness_mm=1.0, gap_mm=0.5)
    valley = solid(book(60.0), thickness_mm=1.0, gap_mm=0.5, axis="middle")
    assert (
        printed(bottom, PRINTER, overhang_deg=0.0)
        == printed(valley, PRINTER, overhang_deg=0.0)
        == []
    )


def test_webs_over_air_are_bridges_and_those_on_the_bed_are_not():
    aloft = solid(book(0.0), thickness_mm=1.0, gap_mm=0.5, axis="middle")
    assert not only(printed(aloft, PRINTER, bridge_mm=0.5), "bridge-too-long")
    assert only(printed(aloft, PRINTER, bridge_mm=0.49), "bridge-too-long")
    assert printed(solid(book(0.0), thickness_mm=1.0, gap_mm=0.5), PRINTER, bridge_mm=0.0) == []


def test_two_materials_need_two_extruders():
    sheet = solid(book(0.0), thickness_mm=1.0, gap_mm=0.5)
    assert only(printed(sheet, PRINTER, extruders=1), "one-material", Severity.NOTE)


def test_narrow_tops_are_reported():
    """The top of each half is 20 mm less its gap and the bevel of 60 degrees wide."""
    sheet = solid(book(120.0), thickness_mm=5.0, gap_mm=0.5, axis="bottom")
    top = SIDE_MM - 0.25 - 5 * np.tan(np.radians(60))
    s0 = sheet.panels.setbacks.axis_mm.max()
    top += 0.25 - s0
    assert panel_widths_mm(sheet.panels) == pytest.approx([top, top])
    assert not only(printed(sheet, PRINTER, nozzle_mm=top - 0.001), "wall-too-thin")
    found = printed(sheet, PRINTER, nozzle_mm=top + 0.001)
    assert only(found, "wall-too-thin")
    assert found[0].panels == (0, 1)


def test_size_is_checked_however_the_print_lies():
    sheet = solid(book(0.0), thickness_mm=1.0, gap_mm=0.5)  # 40 x 20 x 1 mm
    sizes = {"bed_mm": (20.0, 40.0), "margin_mm": 0.0, "height_mm": 1.0}
    assert printed(sheet, PRINTER, **sizes) == []
    assert only(printed(sheet, PRINTER, **sizes | {"height_mm": 0.99}), "print-too-high", "error")
    found = printed(sheet, PRINTER, **sizes | {"bed_mm": (20.0, 32.0)})
    assert only(found, "print-too-large", "error")
    assert "40 x 20 mm" in found[0].text
    assert "0.8 of its size" in found[0].text
    assert "print it in parts" in found[0].text
    # no parts are joined around an embedded film
    embedded = HingeSettings(kind="film", embedded=True)
    filmed, _ = thicken(book(0.0), PanelSettings(thickness_mm=1.0), embedded)
    (found,) = printed(filmed, PRINTER, **sizes | {"bed_mm": (20.0, 32.0)})
    assert found.code == "print-too-large"
    assert "leave hinges.embedded out" in found.text
    # a print that lies askew fits when turned
    turn = np.radians(30)
    spun = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
    joined = joined_mesh(sheet.joining)
    askew = replace(joined, vertices_coords=joined.vertices_coords @ spun.T)
    assert inspect_print(sheet, askew, PRINTER.model_copy(update=sizes)) == []


def test_webs_that_stretch_too_far_are_reported_with_the_gap_that_helps():
    sheet = solid(book(90.0), thickness_mm=1.0, gap_mm=0.8)  # webs of 0.2 mm, 0.8 long
    strain = 0.2 * np.radians(90) / (2 * 0.8)
    material = load_print_material("tpu_95a_filament")

    def webs(of, limit_deg=180.0, **changes):
        return inspect_webs(of, material.model_copy(update=changes), limit_deg)

    assert not only(webs(sheet, strain_max=strain + 1e-6), "hinge-strains")
    found = webs(sheet, strain_max=strain / 2)
    assert only(found, "hinge-strains")
    assert "gap_mm to at least 1.6" in found[0].text
    assert webs(solid(book(90.0), thickness_mm=1.0, gap_mm=1.6), strain_max=strain / 2) == []
    assert webs(sheet, 45.0, strain_max=strain / 2) == []
    assert only(inspect_webs(sheet, load_print_material("pla_filament"), 180.0), "hinge-breaks")


def test_figures_of_mass_and_bed_area():
    sheet = solid(book(0.0), thickness_mm=1.0, gap_mm=0.5)
    joined = joined_mesh(sheet.joining)
    material = load_print_material("pp_filament")
    solids, findings = inspect_solids(sheet, manifolds(sheet.bodies), joined)
    figures = print_figures(solids, joined, material, material)
    assert findings == []
    web = 0.5 * (SIDE_MM - 0.2)  # ends 0.1 mm before the corners
    assert figures.bed_area_mm2 == pytest.approx(SIDE_MM * (2 * SIDE_MM - 0.5) + web)
    volume = SIDE_MM * (2 * SIDE_MM - 0.5) + 0.2 * web
    assert solids.volume_mm3 == pytest.approx(volume)
    assert figures.mass_g == pytest.approx(volume * 900 * 1e-6)
    none = TriangleMesh(np.empty((0, 3)), np.empty((0, 3), np.int64), np.empty(0, np.int64))
    assert bed_area_mm2(none) == 0
