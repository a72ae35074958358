"""Conversion: pairs of OBJ files, colours of Origami Simulator, files of the command line."""

import json
from xml.etree import ElementTree

import numpy as np
import pytest
from click.testing import CliRunner
from flat_patterns import fan, pattern_of
from helpers import PATTERNS, REFERENCE, published, template_fold

from fab import ReadOptions, read_pattern
from fab.cli.group import main
from fab.errors import InvalidFile, InvalidJob
from fab.formats.fold.writer import fold_bytes
from fab.formats.meshes.obj import obj_bytes, read_obj
from fab.formats.pattern_file import PatternFile
from fab.formats.svg.writer import simulator_svg_bytes
from fab.jobs.conversion import convert
from fab.jobs.reading import read_any
from fab.outputs import write
from fab.pattern.crease_pattern import fold_angles_deg
from fab.pattern.inspection import inspect_angles, measure_pattern
from fab.pattern.kinematics import vertices_closure_rad


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(*words):
    return CliRunner().invoke(main, ["convert", *map(str, words)])


def names_in(folder):
    return sorted(path.name for path in folder.iterdir())


@pytest.mark.parametrize("name", ["F4D", "F4E", "F4F", "peaks_coarse"])
def test_published_pairs_become_fold_files(here, name):
    """The flat file of peaks_coarse is mirrored, and two of its sides are no longer than 1e-11."""
    points = published(name, "fold").reshape(-1, 3)
    result = run(REFERENCE / f"{name}_flat.obj", "sheet.fold")
    assert result.exit_code == 0, result.output
    pattern, findings = read_pattern("sheet.fold", ReadOptions(strict=True))
    assert {finding.code for finding in findings} <= {"sheet-overlaps"}
    assert pattern.face_count == len(read_obj(REFERENCE / f"{name}_fold.obj").faces_vertices)
    assert inspect_angles(pattern) == []
    accuracy = measure_pattern(pattern)
    assert accuracy.isometry_max_rel < 1e-7
    assert accuracy.planarity_max < 1e-12
    if name == "peaks_coarse":
        assert "face-clockwise" in result.output
        assert len(pattern.folded_coords) == len(points) - 2
    else:
        assert np.array_equal(pattern.folded_coords, points)
    gaps = np.degrees(vertices_closure_rad(pattern))
    assert np.nanmax(gaps, initial=0.0) < 1e-6
    checked = CliRunner().invoke(main, ["check", "sheet.fold"])
    assert checked.exit_code == 0, checked.output


def test_a_pair_of_obj_files_comes_back_as_it_was(here):
    data = template_fold("miura")
    (here / "miura.fold").write_bytes(data)
    assert run("miura.fold", "pair/sheet.obj").exit_code == 0
    assert names_in(here / "pair") == ["sheet_flat.obj", "sheet_fold.obj"]
    for words in (
        ["pair/sheet_flat.obj", "back.fold"],
        ["pair/sheet_fold.obj", "back.fold"],
        ["pair/sheet_flat.obj", "pair/sheet_fold.obj", "--out", "back.fold"],
        ["pair/sheet_flat.obj", "pair/sheet_fold.obj", "back.fold"],
    ):
        (here / "back.fold").unlink(missing_ok=True)
        result = run(*words)
        assert result.exit_code == 0, result.output
        before, after = read_pattern("miura.fold")[0], read_pattern("back.fold")[0]
        for key in ("vertices_coords", "folded_coords", "edges_vertices", "edges_assignment"):
            assert np.array_equal(getattr(before, key), getattr(after, key)), key
        assert after.edges_foldAngle == pytest.approx(before.edges_foldAngle, abs=1e-9)
    assert run("miura.fold", "pair/sheet_flat.obj").exit_code == 0
    assert names_in(here / "pair") == ["sheet_flat.obj", "sheet_fold.obj"]


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("v 0 0\nf 1 1 1\n", "line 1: a point needs 3 finite numbers, not 'v 0 0'"),
        ("v 0 0 nan\n", "line 1: a point needs 3 finite"),
        ("v 0 0 x\n", "line 1: a point needs 3 finite"),
        ("v 0 0 0\nf 1 a 3\n", "line 2: a face needs numbers of points, not 'f 1 a 3'"),
        ("v 0 0 0\nf 0 1 1\n", "line 2: a face needs"),
        ("v 0 0 0\nf 1 1 \\\n 1 \\\n x\n", "line 2: a face needs numbers of points, not 'f 1 1"),
        ("v 0 0 0\n", "no faces"),
        ("# of a model\n", "no faces"),
        ("", "the file is empty"),
    ],
)
def test_what_is_no_obj_file_is_refused_with_its_line(tmp_path, text, match):
    path = tmp_path / "sheet.obj"
    path.write_text(text)
    with pytest.raises(InvalidFile, match=match) as caught:
        read_obj(path)
    assert str(path) in str(caught.value)


def test_obj_files_of_other_programs_are_read(tmp_path):
    path = tmp_path / "sheet.obj"
    path.write_text(
        "# C:\\\nmtllib a.mtl\no sheet\nv 0 0 0\nv 1 0 0 1.0\nvt 0 0\nvn 0 0 1\ns off\n"
        "v 1 1 0\nv 0 1 0\nusemtl a\nf 1/1/1 2//1\\\n 3/1\nf -4 \\\r\n-2 -1\nl 1 2\n"
    )
    mesh = read_obj(path)
    assert mesh.faces_vertices == [[0, 1, 2], [0, 2, 3]]
    assert mesh.vertices_coords.tolist() == [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]


def test_trimesh_reads_what_we_write(tmp_path):
    import trimesh

    sheet = fan(5, 10.0)
    flat = np.pad(sheet.vertices_coords, ((0, 0), (0, 1)))
    path = tmp_path / "fan.obj"
    path.write_bytes(obj_bytes(flat, sheet.faces_vertices, sheet.faces_offsets, "a\nb"))
    mesh = trimesh.load_mesh(path, process=False)
    assert np.array_equal(mesh.faces, sheet.faces_vertices.reshape(-1, 3))
    assert np.abs(mesh.vertices - flat).max() < 1e-12
    assert np.array_equal(read_obj(path).vertices_coords, flat)


SVG = "{http://www.w3.org/2000/svg}"


def test_colours_say_what_lines_are_and_opacity_how_far_they_fold():
    letters = np.array(["M", "V", "F", "U", "C", "J", "M"])
    rim = [[np.cos(t), np.sin(t)] for t in np.arange(7) * 2 * np.pi / 7]
    faces = [[0, 1 + i, 1 + (i + 1) % 7] for i in range(7)]
    whole = pattern_of([[0, 0], *rim], faces, "M")
    spokes = np.flatnonzero(whole.edges_assignment == "M")
    all_letters = np.full(len(whole.edges_assignment), "B")
    angles = np.zeros(len(all_letters))
    all_letters[spokes] = letters
    angles[spokes] = [90, 45, 0, 0, 0, 0, 0]
    sheet = pattern_of([[0, 0], *rim], faces, all_letters, angle=angles)
    root = ElementTree.fromstring(simulator_svg_bytes(sheet, "fan"))
    lines = root.findall(f"{SVG}g/{SVG}line")
    assert len(lines) == len(all_letters)
    told = [(line.get("stroke"), line.get("stroke-opacity")) for line in lines]
    assert [told[i] for i in spokes] == [
        ("#ff0000", "0.5"),
        ("#0000ff", "0.25"),
        ("#ffff00", None),
        ("#ff00ff", None),
        ("#00ff00", None),
        ("#ffff00", None),
        ("#ffff00", None),  # a mountain that stays flat
    ]
    assert {told[i] for i in range(14) if i not in spokes} == {("#000000", None)}
    ends = np.array([[[float(line.get(k + n)) for k in "xy"] for n in "12"] for line in lines])
    box = [float(x) for x in root.get("viewBox").split()]
    factor = box[2] / float(root.get("width").removesuffix("mm"))
    assert factor == 100  # sides of 0.87 mm become longer than the 3 units that are merged
    places = sheet.vertices_coords[sheet.edges_vertices] - sheet.vertices_coords.min(axis=0)
    places[..., 1] = np.ptp(sheet.vertices_coords[:, 1]) - places[..., 1]
    assert ends / factor == pytest.approx(places, abs=1e-6)


def test_files_are_repaired_on_the_way(here):
    result = run(PATTERNS / "waterbomb.fold", "mended.fold")
    assert result.exit_code == 0
    assert "face-clockwise" in result.output
    pattern, findings = read_pattern("mended.fold", ReadOptions(strict=True))
    assert findings == ()
    assert pattern.face_count == 96
    strict = run(PATTERNS / "waterbomb.fold", "strict.fold", "--strict")
    assert strict.exit_code == 2
    assert "96 of 96 faces are clockwise, the first is 0: turned. --strict" in strict.output
    assert run("mended.fold", "again.fold", "--strict", "--dry-run").exit_code == 0
    assert names_in(here) == ["mended.fold"]
    assert run("mended.fold", "again.fold", "--strict").exit_code == 0
    again = (here / "again.fold").read_bytes()
    assert again == (here / "mended.fold").read_bytes()
    assert json.loads(again)["file_title"] == "waterbomb tessellation"


def test_what_meshes_cannot_hold_is_told(tmp_path):
    sheet = fan(6, 10.0, "V")
    letters = sheet.edges_assignment.copy()
    letters[np.flatnonzero(letters == "V")[0]] = "U"
    faces = [sheet.faces_vertices[i : i + 3].tolist() for i in range(0, 18, 3)]
    flat = np.pad(sheet.vertices_coords, ((0, 0), (0, 1)))
    from dataclasses import replace

    sheet = replace(pattern_of(sheet.vertices_coords, faces, letters), folded_coords=flat)
    made = convert(PatternFile("", sheet, (), ()), tmp_path / "fan.obj")
    assert [finding.code for finding in made.findings] == ["lost-in-obj"]
    assert made.findings[0].creases == tuple(np.flatnonzero(letters == "U"))


def test_angles_that_do_not_close_are_told_with_their_place(here):
    sheet = fan(6, 10.0, "V")
    (here / "fan.fold").write_bytes(fold_bytes(sheet, "fan"))
    result = run("fan.fold", "fan.svg")
    assert result.exit_code == 0
    assert "warning: angles-open" in result.output
    assert "vertex 0 at (10, 8.66025) mm" in result.output


@pytest.mark.parametrize(
    ("words", "match"),
    [
        (["lone.fold"], "give one file, or two OBJ files"),
        (["good.fold", "out.stl"], "out.stl: must end in .fold, .svg, .dxf, .cp, .obj or .png"),
        (["good.fold", "good.fold", "--out", "x.fold"], "give one file, or two OBJ"),
        (["missing.fold", "out.fold"], "cannot be read"),
        (["cone.obj", "out.fold"], "vertex 0 not flat, the angles around the first add up to 240"),
        (["one.obj", "three.obj", "out.fold"], "3 vertices, but one.obj has 4"),
        (["fin.obj", "fin.obj", "out.fold"], "faces 1 and 2 lie on the same side"),
        (["good.fold", "one.obj/out.fold"], "is a file, not a folder"),
    ],
)
def test_bad_conversions_name_the_cure_and_write_nothing(here, words, match):
    square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n"
    (here / "good.fold").write_bytes(fold_bytes(fan(6, 10.0), "fan"))
    (here / "one.obj").write_text(square)
    (here / "cone.obj").write_text(
        "v 0 0 1\nv 1 0 0\nv 0 1 0\nv -1 0 0\nv 0 -1 0\nf 1 2 3\nf 1 3 4\nf 1 4 5\nf 1 5 2\n"
    )
    (here / "three.obj").write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n")
    (here / "fin.obj").write_text(square + "v 0.5 1 0\nf 1 3 5\n")
    before = names_in(here)
    result = run(*words)
    assert result.exit_code == 2, result.output
    assert match in result.output
    assert names_in(here) == before


@pytest.mark.parametrize("target", ["out.obj", "out_flat.obj"])
def test_without_a_folded_form_a_mesh_is_the_flat_sheet_alone(here, target):
    flat = fan(6, 10.0)
    (here / "good.fold").write_bytes(fold_bytes(flat, "fan"))
    result = run("good.fold", target)
    assert result.exit_code == 0, result.output
    assert "without its 6 mountains and valleys" in result.output
    assert names_in(here) == ["good.fold", target]
    read = read_any([here / target])
    wanted = flat.vertices_coords - flat.vertices_coords.min(axis=0)
    assert np.array_equal(read.pattern.vertices_coords, wanted)
    assert np.array_equal(read.pattern.faces_vertices, flat.faces_vertices)
    assert read.pattern.counts()["U"] == 6


def test_conversion_from_python_needs_no_command_line(tmp_path):
    read = read_any([PATTERNS / "yoshimura.fold"])
    write(convert(read, tmp_path / "y.svg"), tmp_path)
    assert names_in(tmp_path) == ["y.svg"]
    with pytest.raises(InvalidJob, match="no file: give one file"):
        read_any([])


def test_angles_of_a_converted_pair_are_those_of_its_folded_form(here):
    (here / "a.fold").write_bytes(template_fold("curved_fold"))
    assert run("a.fold", "a.obj").exit_code == 0
    pattern = read_any([here / "a_flat.obj"]).pattern
    measured = fold_angles_deg(
        pattern.folded_coords, pattern.edges, pattern.faces_vertices, pattern.faces_offsets
    )
    assert np.array_equal(measured, pattern.edges_foldAngle)


@pytest.mark.parametrize(
    ("ending", "lost"),
    [(".svg", True), (".dxf", True), (".cp", True), (".obj", False), (".fold", False)],
)
def test_drawings_of_sheets_that_overlap_themselves_are_told(here, ending, lost):
    """Five quads around a vertex: the fifth lies on the first."""
    around = [(20, 0), (20, 20), (0, 20), (-20, 20), (-20, 0), (-20, -20), (0, -20), (20, -20)]
    points = [(0, 0), *(around[k % 8] for k in range(11))]
    faces = [[0, k, k + 1, k + 2] for k in range(1, 10, 2)]
    document = {"frame_unit": "mm", "vertices_coords": points, "faces_vertices": faces}
    (here / "ring.fold").write_text(json.dumps(document))
    made = convert(read_any([here / "ring.fold"]), here / f"made{ending}")
    told = {finding.code: finding for finding in made.findings}
    assert "sheet-overlaps" in told
    assert ("faces-lost-in-drawing" in told) == lost
    if lost:
        assert told["faces-lost-in-drawing"].panels == (0, 4)


@pytest.mark.parametrize("ending", [".svg", ".dxf", ".cp", ".obj", ".fold", ".png"])
@pytest.mark.parametrize("order", [1, 0])
def test_an_order_of_layers_that_gets_lost_is_reported(here, ending, order):
    """A sheet folded in half: one pair of layers, or a row that says that its order is unknown."""
    document = {
        "frame_unit": "mm",
        "vertices_coords": [[0, 0], [20, 0], [40, 0], [40, 20], [20, 20], [0, 20]],
        "faces_vertices": [[0, 1, 4, 5], [1, 2, 3, 4]],
        "edges_vertices": [[0, 1], [1, 2], [2, 3], [3, 4], [4, 5], [5, 0], [1, 4]],
        "edges_assignment": [*"BBBBBBV"],
        "faceOrders": [[0, 1, order]],
    }
    (here / "half.fold").write_text(json.dumps(document))
    made = convert(read_any([here / "half.fold"]), here / f"made{ending}")
    told = [finding for finding in made.findings if finding.code == "layers-lost"]
    assert len(told) == (order == 1 and ending not in (".fold", ".png"))
    for finding in told:
        assert "faceOrders of 1 pair of faces" in finding.text
        assert finding.panels == (0, 1)
