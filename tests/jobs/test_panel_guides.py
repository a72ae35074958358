"""Guides to thick panels: every hinge, the parts on their plates, and what joins them."""

import io
import re

import numpy as np
import pytest
from click.testing import CliRunner
from helpers import PATTERNS
from pypdf import PdfReader

from fab import read_pattern
from fab.cli.group import main
from fab.errors import Severity
from fab.jobs.file_names import THICK, left_over
from fab.jobs.print_files import ThickFormat, make_thick
from fab.panels.bevelled_panels import PanelSettings
from fab.panels.hinges import HingeSettings
from fab.panels.thick_sheet import thicken
from fab.pattern.crease_pattern import scaled
from fab.printing.thick_settings import thick_settings

ONLY = (ThickFormat.ASSEMBLY,)


def made(width_mm, *changes, formats=ONLY, name="twist"):
    pattern, _ = read_pattern(PATTERNS / "miura.fold")
    settings = thick_settings(changes, "prusa_mk4s", "pp_filament")
    wide = scaled(pattern, width_mm=width_mm)
    return wide, make_thick(wide, name, settings, print_with=settings.print_with(), formats=formats)


def read(made, name="twist"):
    pages = PdfReader(io.BytesIO(made.files[f"{name}_thick_assembly.pdf"])).pages
    return re.sub(r"[ \n]+", " ", " ".join(page.extract_text() for page in pages))


@pytest.fixture(scope="module")
def divided():
    return made(420.0)


def test_every_hinge_is_listed_with_its_panels(divided):
    pattern, result = divided
    text = read(result).partition("hinge kind mm fold panels")[2]
    rows = re.findall(
        r"(\d+) web(?:, joint (\d+))? [\d.]+ (?:\w+ [\d.]+°|flat) (\d+) - (\d+)", text
    )
    sheet, _ = thicken(pattern, PanelSettings(), HingeSettings())
    listed = {int(edge): {int(first), int(second)} for edge, _, first, second in rows}
    assert sorted(listed) == np.unique(sheet.held).tolist()
    assert len(rows) == len(listed) == result.report["solids"]["hinges"]
    for edge, panels in listed.items():
        assert panels == set(pattern.edges_faces[edge].tolist())
    joints = {int(joint): int(edge) for edge, joint, *_ in rows if joint}
    plates = result.report["plates"]
    assert joints == {row["joint"]: row["crease"] for row in plates["assembly"]}


def test_the_same_panels_are_the_same_bytes(divided):
    name = "twist_thick_assembly.pdf"
    assert made(420.0)[1].files[name] == divided[1].files[name]


def test_parts_are_joined_in_the_order_of_the_report(divided):
    _, result = divided
    text, plates = read(result), result.report["plates"]
    for number, parts in enumerate(plates["plates"], 1):
        assert f"Plate {number}: 250 x 210 mm, {len(parts)} part" in text
    steps = re.findall(r"Join (\w) to (\w(?: and \w)?) Joints? ([\d, and to]+), while", text)
    told = {}
    for later, others, numbers in steps:
        for part in re.split(r", | and ", numbers):
            first, _, last = part.partition(" to ")
            for label in range(int(first), int(last or first) + 1):
                told[label] = {later, *re.findall("[A-Z]", others)}
    assert list(told) == [row["joint"] for row in plates["assembly"]]
    for row in plates["assembly"]:
        assert {row["tongue_part"], row["pocket_part"]} <= told[row["joint"]]
    (row,) = [row for row in plates["assembly"] if row["joint"] == 1]
    assert f"pockets of {row['pocket_part']} over the tongues of {row['tongue_part']}" in text


def test_a_sheet_in_one_has_no_plates():
    _, result = made(160.0)
    text = read(result)
    assert "Print the sheet flat, as it is." in text
    assert "Plate" not in text
    assert "web: 51" in text


@pytest.mark.parametrize(
    ("snap", "kind", "told"),
    [
        ("false", "knuckle", "Pins are printed in their barrels"),
        ("true", "snap knuckle", "press the open barrels onto the pin"),
    ],
)
def test_hinges_with_pins_are_told_and_the_page_has_the_guide_too(snap, kind, told):
    changes = ("hinges.kind=knuckle", "panels.thickness_mm=4.0", "panels.axis=middle")
    snapping = (f"hinges.snap={snap}", "hinges.pin_mm=1.6")
    _, result = made(160.0, *changes, *snapping, formats=[ThickFormat.HTML])
    page = result.files["twist_thick.html"].decode()
    section = page.split('<h2 id="assembly">')[1].split("</section>")[0]
    assert told in section
    assert f"<td>{kind}</td>" in section


def test_what_must_not_be_made_as_it_is_says_so_first(divided):
    _, result = divided
    codes = {f.code for f in result.findings if f.severity is Severity.ERROR}
    assert codes == {"solids-overlap"}
    assert re.match(r"twist: panels Do not make it as it is: the report has 2 errors", read(result))
    _, fine = made(160.0, "panels.thickness_mm=0.6", "panels.gap_mm=1.5")
    assert fine.within_tolerance
    assert "Do not make it" not in read(fine)


def test_the_print_pauses_where_the_report_says():
    changes = ("hinges.kind=film", "hinges.embedded=true")
    _, result = made(160.0, *changes)
    pause = result.report["solids"]["pause"]
    assert f"z = {pause['z_mm']:g} mm, after layer {pause['after_layer']}" in read(result)


def test_the_command_makes_it_unless_something_else_is_asked_for(tmp_path):
    words = ["thicken", str(PATTERNS / "box.fold"), "--width-mm", "120", "--quiet"]
    words += ["--out", str(tmp_path)]
    CliRunner().invoke(main, [*words, "--only", "assembly"])
    file = tmp_path / "box_thick_assembly.pdf"
    assert file.is_file()
    assert left_over([], "box", [THICK], tmp_path) == sorted(tmp_path.iterdir())
    file.unlink()
    CliRunner().invoke(main, [*words, "--only", "stl"])
    assert not file.exists()
