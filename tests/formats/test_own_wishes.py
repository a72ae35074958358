"""Our own sheets with bridges, closed slots, titles and holes give their pattern back."""

import re
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from flat_patterns import grid, pattern_of
from helpers import PATTERNS

from fab import ReadOptions, read_pattern
from fab.drawings.drawing_files import SheetFormat
from fab.errors import InvalidFile, Severity
from fab.jobs.reading import read_any
from fab.jobs.sheet_files import fabricate
from fab.pattern.crease_pattern import scaled
from fab.sheets.cut_wishes import CutWishes
from fab.sheets.cutter_settings import CutterSettings
from fab.sheets.materials import load_machine, load_material
from fab.sheets.sheet_request import SheetRequest


def lengths(pattern):
    ends = pattern.vertices_coords[pattern.edges_vertices]
    length = np.hypot(*(ends[:, 1] - ends[:, 0]).T)
    out = Counter()
    for letter, size in zip(pattern.edges_assignment.tolist(), length.tolist(), strict=True):
        out[letter] += size
    return {letter: size for letter, size in out.items() if letter not in "FJ"}


@pytest.mark.parametrize("kind", [SheetFormat.DXF, SheetFormat.SVG])
@pytest.mark.parametrize(
    "wishes",
    [{"bridges": 1}, {"bridges": 4, "title": True}, {"closed_slots": True}, {"mirror": True}],
)
@pytest.mark.parametrize("name", ["miura", "window"])
def test_a_sheet_with_wishes_gives_its_pattern_back(name, wishes, kind, tmp_path):
    pattern = (
        grid(4, 4, 40.0, without=[(1, 1)])
        if name == "window"
        else scaled(read_pattern(PATTERNS / "miura.fold")[0], width_mm=160)
    )
    machine, material = load_machine("co2_60w_600x400"), load_material("card_300gsm")
    request = SheetRequest(
        material, machine, formats=[kind], page=False, wishes=CutWishes(tabs="none", **wishes)
    )
    made = fabricate(pattern, "sheet", request)
    path = tmp_path / f"sheet_1.{kind}"
    path.write_bytes(made.files[path.name])
    found = read_any([path])
    again = found.pattern
    assert "colour-unknown" not in {finding.code for finding in found.findings}
    assert lengths(again) == pytest.approx(lengths(pattern), rel=1e-4)


@pytest.mark.parametrize("kind", [SheetFormat.DXF, SheetFormat.SVG])
def test_pieces_side_to_side_all_come_back(kind, tmp_path):
    """Twelve of two squares each: those in the middle have no line of their own but the crease."""
    settings = CutterSettings(
        material="card_300gsm", machine="co2_60w_600x400", shared_cuts=True, copies=12
    )
    request = settings.request([kind], page=False)
    made = fabricate(grid(2, 1, 30.0), "sheet", request)
    path = tmp_path / f"sheet_1.{kind}"
    path.write_bytes(made.files[path.name])
    found = read_any([path])
    assert {finding.severity for finding in found.findings} == {Severity.NOTE}
    assert found.pattern.face_count == 24
    total = lengths(found.pattern)
    width, height = 60.15, 30.15  # with the kerf
    assert total["V"] == pytest.approx(12 * height)
    assert total["C"] >= 17 * height  # in a grid of any shape
    assert total["B"] + 2 * total["C"] == pytest.approx(12 * 2 * (width + height))
    again = fabricate(found.pattern, "sheet", replace(request, copies=1))
    assert len(again.report["pieces"]) == 12


def test_gaps_that_pieces_side_to_side_enclose_are_no_pieces(tmp_path):
    """Nine angles of one crease: with equal sides together, four of them enclose a gap."""
    corners = np.array([(0, 0), (60, 0), (60, 20), (20, 20), (20, 60), (0, 60)], float)
    angle = pattern_of(corners, [[0, 1, 2, 3], [0, 3, 4, 5]], "V")
    settings = CutterSettings(
        material="card_300gsm", machine="co2_60w_600x400", shared_cuts=True, copies=9
    )
    made = fabricate(angle, "sheet", settings.request([SheetFormat.SVG], page=False))
    (tmp_path / "sheet_1.svg").write_bytes(made.files["sheet_1.svg"])
    found = read_any([tmp_path / "sheet_1.svg"])
    assert "hole" in {finding.code for finding in found.findings}
    assert found.pattern.face_count == 18


@pytest.mark.parametrize("kind", [SheetFormat.DXF, SheetFormat.SVG])
@pytest.mark.parametrize("closed_slots", [False, True])
@pytest.mark.parametrize(
    ("name", "material", "rows"), [("miura", "plywood_3mm", 5), ("square_twist", "acrylic_2mm", 7)]
)
def test_living_hinges_come_back_as_creases(name, material, rows, closed_slots, kind, tmp_path):
    """Each is `rows` rows of slits beside each other, every other one shifted."""
    pattern = scaled(read_pattern(PATTERNS / f"{name}.fold")[0], width_mm=380)
    settings = CutterSettings(
        material=material, machine="co2_60w_600x400", tabs="none", closed_slots=closed_slots
    )
    request = settings.request([kind], page=False)
    assert request.perforation.mountain.rows == rows
    made = fabricate(pattern, "sheet", request)
    path = tmp_path / f"sheet_1.{kind}"
    path.write_bytes(made.files[path.name])
    found = read_any([path])
    creases = int(np.isin(pattern.edges_assignment, ["M", "V"]).sum())
    assert f"our own sheet has {creases} living hinges" in " ".join(f.text for f in found.findings)
    assert lengths(found.pattern) == pytest.approx(lengths(pattern), rel=1e-3)  # the kerf


@pytest.mark.parametrize("kind", [SheetFormat.DXF, SheetFormat.SVG])
def test_letters_that_the_user_gives_hold_for_our_own_sheets(kind, tmp_path):
    """In half-etched steel valleys are engraved, and nothing in the file says that they fold."""
    settings = CutterSettings(
        material="stainless_0.5mm_half_etched", machine="fibre_1kw_1500x1000", tabs="none"
    )
    made = fabricate(grid(4, 1, 40.0), "sheet", settings.request([kind], page=False))
    path = tmp_path / f"sheet_1.{kind}"
    path.write_bytes(made.files[path.name])
    for colours, letters in (
        ({}, {"U"}),
        ({"engrave": "V"}, {"V"}),
        ({"#00a000": "M", "#00ff00": "M"}, {"M"}),  # of SVG and of DXF
        ({"engrave": "V", "cut": "C"}, {"V"}),
    ):
        found = read_any([path], ReadOptions(colours=colours))
        pattern = found.pattern
        assert set(pattern.edges_assignment.tolist()) == {"B", *letters}
        assert pattern.face_count == 4
        told = [f.text for f in found.findings if f.code == "engraved-unassigned"]
        assert len(told) == (not colours)
        assert all("3 engraved creases" in text for text in told)


@pytest.mark.parametrize("kind", [SheetFormat.DXF, SheetFormat.SVG])
def test_registration_crosses_are_no_engraved_creases(kind, tmp_path):
    settings = CutterSettings(
        material="card_300gsm", machine="co2_60w_600x400", two_sided=True, tabs="none"
    )
    made = fabricate(grid(4, 1, 40.0), "sheet", settings.request([kind], page=False))
    path = tmp_path / f"sheet_1_back.{kind}"
    path.write_bytes(made.files[path.name])
    assert "engraved-unassigned" not in {finding.code for finding in read_any([path]).findings}


def test_the_paths_of_a_drag_knife_are_no_pieces_side_to_side(tmp_path):
    """They go on beyond corners, so that outlines are open and cross themselves there."""
    machine = load_machine("knife_a3_roll")
    knife = machine.knife.model_copy(
        update={"offset_mm": 0.3, "overcut_mm": 1.0, "lead_in_mm": 2.0}
    )
    machine = machine.model_copy(update={"knife": knife})
    request = SheetRequest(
        load_material("card_300gsm"), machine, formats=[SheetFormat.SVG], page=False
    )
    made = fabricate(grid(2, 1, 40.0), "sheet", request)
    (tmp_path / "sheet_1.svg").write_bytes(made.files["sheet_1.svg"])
    with pytest.raises(InvalidFile, match=r"no line is a border.* \[knife\].*Read the FOLD file"):
        read_any([tmp_path / "sheet_1.svg"])


@pytest.mark.parametrize("kind", [SheetFormat.DXF, SheetFormat.SVG])
@pytest.mark.parametrize("overcut_mm", [0.0, 0.5])
def test_outlines_that_a_knife_cuts_on_beyond_their_start_are_a_warning(kind, overcut_mm, tmp_path):
    machine = load_machine("knife_a4")
    knife = machine.knife.model_copy(update={"overcut_mm": overcut_mm})
    machine = machine.model_copy(update={"knife": knife})
    request = SheetRequest(load_material("card_300gsm"), machine, formats=[kind], page=False)
    path = tmp_path / f"sheet_1.{kind}"
    path.write_bytes(fabricate(grid(2, 1, 40.0), "sheet", request).files[path.name])
    found = read_any([path])
    warnings = {f.code for f in found.findings if f.severity == Severity.WARNING}
    assert ("knife-paths" in warnings) == (overcut_mm > 0)
    assert found.pattern.face_count == 2


@pytest.mark.parametrize("plain", [False, True])
def test_a_sheet_that_inkscape_saved_again_gives_its_pattern_back(plain, tmp_path):
    """It adds a view, metadata and definitions beside the layers; plain SVG has no labels."""
    pattern = grid(4, 4, 40.0, without=[(1, 1)])
    settings = CutterSettings(material="card_300gsm", machine="co2_60w_600x400", tabs="none")
    made = fabricate(pattern, "sheet", settings.request([SheetFormat.SVG], page=False))
    added = (
        b'<sodipodi:namedview id="view" xmlns:sodipodi='
        b'"http://sodipodi.sourceforge.net/DTD/sodipodi-0.dtd"/><metadata id="m"/><defs id="d"/>'
    )
    path = tmp_path / "sheet.svg"
    data = made.files["sheet_1.svg"].replace(b"<title>", added + b"<title>")
    path.write_bytes(re.sub(rb' inkscape:\w+="\w+"', b"", data) if plain else data)
    found = read_any([path])
    assert "kerf-removed" in {finding.code for finding in found.findings}
    assert lengths(found.pattern) == pytest.approx(lengths(pattern), rel=1e-4)
