"""Small inputs that people reported of some tool or sent as a file, each with its right value.

They are read in place from the folder `shared/cases` beside the repository; the kind of each fault
has tests of its own in this folder.
"""

import json
import re

import pytest
from click.testing import CliRunner
from shared_cases import shared_case

from fab.cli.group import main
from fab.errors import InvalidFile
from fab.formats.read_options import ReadOptions
from fab.formats.reading import read_pattern_file

SHEET = ["--material", "card_300gsm", "--machine", "co2_60w_600x400", "--only", "dxf"]
HULL, CUT, SECOND = (
    ReadOptions(border="hull"),
    ReadOptions(inner_border="cut"),
    ReadOptions(frame=2),
)
FOUND = None


@pytest.mark.parametrize(
    ("name", "options", "counts", "size", "codes"),
    [
        ("slit2_C.fold", FOUND, {"M": 1, "B": 6, "C": 1}, (100, 60), {"crease-dangling"}),
        ("dangle_C.fold", FOUND, {"B": 4, "C": 1}, (100, 60), {"crease-dangling"}),
        ("slit_lost.fold", FOUND, {"B": 4, "C": 1}, (100, 100), {"crease-dangling"}),
        ("comb.fold", FOUND, {"V": 2, "B": 10}, (100, 60), set()),
        ("os_flat_saved.fold", FOUND, {"M": 1, "B": 6}, (2, 1.2), {"flat-form-taken"}),
        ("xz_plane.fold", FOUND, {"M": 1, "B": 6}, (100, 60), {"frame-turned"}),
        ("flat_in_xz_foldedForm.fold", FOUND, {"V": 1, "B": 4}, (100, 100), {"frame-turned"}),
        ("folded_form_only.fold", FOUND, {"V": 1, "B": 6}, (100, 110), {"unfolded"}),
        ("two_cps.fold", FOUND, {"M": 1, "B": 6}, (100, 60), {"several-patterns"}),
        ("two_cps.fold", SECOND, {"V": 1, "B": 4}, (40, 40), set()),
        ("touch2.fold", FOUND, {"B": 8}, (80, 40), set()),
        ("cross.fold", FOUND, {"M": 2, "V": 2, "B": 4}, (100, 60), {"lines-split"}),
        ("crease_ends_on_border.fold", FOUND, {"V": 1, "B": 6}, (100, 100), {"lines-split"}),
        ("soup.fold", FOUND, {"M": 1, "B": 6}, (100, 60), {"vertices-merged"}),
        ("gap_0.001.fold", FOUND, {"M": 1, "B": 6}, (100, 60), {"ends-joined"}),
        ("crease_sticks_out_0.02mm.fold", FOUND, {"V": 1, "B": 6}, (100, 100), {"line-outside"}),
        (
            "face_along_dangling_crease.fold",
            FOUND,
            {"M": 1, "V": 2, "B": 6},
            (100, 100),
            {"crease-dangling"},
        ),
        ("flat_line_outside.fold", FOUND, {"V": 1, "B": 6}, (100, 100), {"line-outside"}),
        ("noborder.fold", HULL, {"M": 3, "V": 1, "B": 4}, (100, 100), {"border-hull"}),
        ("inner_border.fold", CUT, {"B": 6, "C": 1}, (100, 100), {"border-inside"}),
        ("unit_square.fold", FOUND, {"V": 1, "B": 4}, (1, 1), {"unit-unknown"}),
        (
            "closed_crease_loop.fold",
            FOUND,
            {"M": 16, "B": 4, "J": 2},
            (100, 100),
            {"island-joined"},
        ),
        ("hole_island.fold", FOUND, {"M": 1, "B": 10, "J": 2}, (90, 90), {"hole", "island-joined"}),
        ("flap.fold", FOUND, {"V": 1, "B": 4, "C": 3, "J": 2}, (100, 80), {"island-joined"}),
        ("keyhole.fold", FOUND, {"M": 4, "V": 1, "B": 4, "J": 1}, (10, 10), {"island-joined"}),
        ("diagonal_with_folded_frame.fold", FOUND, {"V": 1, "B": 4}, (100, 100), set()),
        ("flat_only.obj", FOUND, {"U": 1, "B": 6}, (100, 60), {"edges-missing"}),
        ("yup_flat.obj", FOUND, {"V": 1, "B": 6}, (100, 60), {"frame-turned"}),
        ("yup_fold.obj", FOUND, {"V": 1, "B": 6}, (100, 60), {"frame-turned"}),
        ("framepart.fold", FOUND, {"M": 2, "V": 2, "B": 12}, (160, 100), set()),
        ("flat_1e-9.fold", FOUND, {"V": 1, "B": 4}, (1e-9, 1e-9), {"unit-unknown"}),
        ("valley_of_angle_0.fold", FOUND, {"V": 1, "B": 4}, (100, 100), {"fold-angle-zero"}),
        ("flat_1e10.fold", FOUND, {"V": 1, "B": 4}, (1e10, 1e10), {"unit-unknown"}),
    ],
)
def test_cases_are_read_as_they_are_meant(name, options, counts, size, codes):
    read = read_pattern_file(shared_case(name), options)
    assert read.pattern.counts() == {"M": 0, "V": 0, "F": 0, "B": 0, **counts}
    assert read.pattern.vertices_coords.max(axis=0) == pytest.approx(size, rel=1e-6)
    assert codes <= {finding.code for finding in read.findings}


REFUSED = [
    ("noborder.fold", "enclose no face. .* --border hull"),
    ("outline_gap_of_2mm.fold", r"a gap of 2 mm between \(51, 100\) mm and \(49, 100\) mm"),
    ("inner_border.fold", r"near \(50, 50\) mm, is a border .* --inner-border cut"),
    ("cube3d.obj", "vertices 0, 1, 2, 3, 4 and 3 more not flat, .* 270 degrees"),
    ("geos.fold", "1.48e.302, over the bound of 1e.50. Scale it"),
    ("folded_1e300.fold", "1e.300, over the bound of 1e.50. Scale it"),
    ("fabricate_closing_inf.fold", "1e.300, over the bound of 1e.50. Scale it"),
]


@pytest.mark.parametrize(("name", "match"), REFUSED)
def test_cases_that_mean_nothing_are_refused_with_place_and_cure(name, match):
    with pytest.raises(InvalidFile, match=match):
        read_pattern_file(shared_case(name))


def test_ends_of_a_gap_that_are_joined_bring_a_mountain_onto_a_valley():
    with pytest.raises(InvalidFile, match="edge 5 is a mountain and edge 6 a valley"):
        read_pattern_file(shared_case("outline_gap_of_2mm.fold"), ReadOptions(merge_mm=2.5))


STRICT = [
    *("soup", "gap_0.001", "crease_sticks_out_0.02mm"),
    *("flat_line_outside", "two_cps", "closed_crease_loop", "folded_form_only"),
]


@pytest.mark.parametrize("name", STRICT)
def test_repairs_are_refused_where_none_are_wanted(name):
    path = shared_case(f"{name}.fold")
    with pytest.raises(InvalidFile):
        read_pattern_file(path, ReadOptions(strict=True, fold_deg=180))


@pytest.mark.parametrize("name", ["cross", "crease_ends_on_border"])
def test_faces_between_edges_are_no_assumption(name):
    read = read_pattern_file(shared_case(f"{name}.fold"), ReadOptions(strict=True, fold_deg=180))
    assert "faces-rebuilt" in {finding.code for finding in read.findings}


@pytest.mark.parametrize(
    ("name", "code", "text"),
    [
        ("os_flat_saved.fold", 0, "1 piece"),
        ("xz_plane.fold", 0, "1 piece"),
        ("folded_form_only.fold", 0, "1 piece"),
        ("cross.fold", 0, "lines-split"),
        ("soup.fold", 0, "vertices-merged"),
        ("gap_0.001.fold", 0, "ends-joined"),
        ("face_along_dangling_crease.fold", 0, "crease-dangling"),
        ("flat_line_outside.fold", 0, "line-outside"),
        ("hole_island.fold", 0, "island-joined"),
        ("keyhole.fold", 0, "island-joined"),
        ("outline_gap_of_2mm.fold", 2, "a gap of 2 mm"),
        ("inner_border.fold", 2, "--inner-border cut"),
        ("geos.fold", 2, "over the bound"),
        ("folded_1e300.fold", 2, "over the bound"),
        ("fabricate_closing_inf.fold", 2, "over the bound"),
        ("flat_1e-9.fold", 2, "1e-09 x 1e-09 mm large; .*--width-mm, or --scale 1e.11"),
        ("flat_1e10.fold", 2, "1e.10 x 1e.10 mm large; .*--width-mm, or --scale 1e-08"),
        ("esc_title.fold", 0, "folded-form-differs"),
    ],
)
def test_cases_are_fabricated_or_refused(tmp_path, name, code, text):
    words = ["fabricate", str(shared_case(name)), *SHEET, "--out", str(tmp_path), "--dry-run"]
    result = CliRunner().invoke(main, [*words, "--width-mm", "100"] if "os_" in name else words)
    assert result.exit_code == code, result.output
    assert re.search(text, result.output), result.output
    assert all(letter.isprintable() or letter == "\n" for letter in result.output)


SIMULATED = [
    ("valley_of_angle_0", [], 0, "folds to its target", {"fold-angle-zero"}),
    ("crane_folded_form_0.3mm_off", [], 0, r"up to 0\.295 mm from", {"folded-form-differs"}),
    (
        "vertex_off_0.1deg",
        [],
        1,
        "angles are right, but vertices are off by up to about 0.1 mm: --tolerance-deg 0.5 ",
        {"target-not-reached", "angles-do-not-close"},
    ),
    ("vertex_off_0.1deg", ["--tolerance-deg", "0.5"], 0, "folds to its target", set()),
    ("slit2_C", [], 0, "folds to its target", {"crease-dangling"}),
    ("dangle_C", [], 0, "nothing folds", {"crease-dangling", "nothing-to-fold"}),
    ("face_along_dangling_crease", [], 0, "folds to its target", {"crease-dangling"}),
]


@pytest.mark.parametrize(("name", "options", "code", "text", "codes"), SIMULATED)
def test_cases_are_simulated(tmp_path, name, options, code, text, codes):
    words = ["simulate", str(shared_case(f"{name}.fold")), "--only", "fold", "--states", "5"]
    result = CliRunner().invoke(main, [*words, *options, "--out", str(tmp_path)])
    assert result.exit_code == code, result.output
    assert re.search(text, result.output), result.output
    report = json.loads((tmp_path / f"{name}_folding.json").read_text())
    found = {finding["code"] for finding in report["findings"]}
    assert codes <= found
    severe = {f["code"] for f in report["findings"] if f["severity"] == "error"}
    assert bool(severe) == (code == 1)
    assert report["verdict"]["angle_error_max_deg"] < 1e-6


def test_a_valley_of_angle_0_is_one_thing(tmp_path):
    """Blue when converted, and cut as a valley."""
    path = str(shared_case("valley_of_angle_0.fold"))
    for target in ("a.svg", "a.fold"):
        CliRunner().invoke(main, ["convert", path, str(tmp_path / target)], catch_exceptions=False)
    assert 'stroke="#0000ff" stroke-opacity="1"' in (tmp_path / "a.svg").read_text()
    assert json.loads((tmp_path / "a.fold").read_text())["edges_assignment"].count("V") == 1
    words = ["fabricate", path, *SHEET, "--out", str(tmp_path)]
    result = CliRunner().invoke(main, words, catch_exceptions=False)
    assert "fold-angle-zero" in result.output
    (sheet,) = tmp_path.glob("*.dxf")
    assert "VALLEY" in sheet.read_text()


def test_what_we_convert_we_read_again(tmp_path):
    """Every case that can be read is written as FOLD and read without a repair."""
    folder = shared_case("cross.fold").parent
    done = 0
    for path in sorted([*folder.glob("*.fold"), *folder.glob("*.obj")]):
        first, second = tmp_path / "a.fold", tmp_path / "b.fold"
        result = CliRunner().invoke(main, ["convert", str(path), str(first)])
        if result.exit_code == 2:
            continue
        again = CliRunner().invoke(main, ["convert", str(first), str(second), "--strict"])
        assert again.exit_code == result.exit_code, f"{path}: {again.output}"
        assert first.read_bytes() == second.read_bytes(), path
        done += 1
    assert done > 30
