"""Jobs that name a surface file: relaxed onto it, whatever its topology, and reported."""

import json

import igl
import numpy as np
import pytest
import trimesh
from click.testing import CliRunner
from lib3mf import Lib3MF
from surface_meshes import cap, writing_3mf

import fab
from fab.cli.group import main
from fab.errors import InvalidFile, InvalidJob, Severity
from fab.jobs.grow import grown_pattern, growth_findings, overlap_findings
from fab.jobs.job import parse_job
from fab.jobs.job_parts import by_pieces
from fab.surfaces.reading import read_surface_mesh
from solver import Growth, InvalidValue, Miura, QuadMesh, Status, SurfaceFit
from solver.relaxed_fit import joined

SIZE = {"width_mm": 300.0}


def dome(path, half_angle=np.pi / 3, size=80.0):
    coords, faces = cap(half_angle, 12, 36)
    trimesh.Trimesh(size * coords, faces, process=False).export(path)


def job_of(folder, name, columns=10, **design):
    design = {"kind": "surface_fit", "surface": name, "columns": columns, **design}
    return fab.parse_job({"name": "sheet", "design": design, "sheet": SIZE}, folder=folder)


def codes(made, severity=None):
    return [f.code for f in made.findings if severity is None or f.severity == severity]


def test_a_dome_in_a_file_becomes_a_sheet(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    dome(tmp_path / "dome.stl")
    (tmp_path / "dome.toml").write_text(
        'name = "dome"\ndesign = {kind = "surface_fit", surface = "dome.stl", columns = 10}\n'
        "sheet = {width_mm = 300.0}\n"
    )
    result = CliRunner().invoke(main, ["run", "dome.toml", "--out", "out", "--only", "fold,dxf"])
    assert result.exit_code == 0, result.output
    report = json.loads((tmp_path / "out" / "dome_report.json").read_text())
    growth = report["growth"]
    assert growth["status"] == "grown"
    assert growth["coverage"] > 0.99
    assert growth["method"] == "relax"
    assert growth["chosen"]["sheets"] == 1
    keys = {"mean_mm", "rms_mm", "lowest_mm", "highest_mm", "largest_mm"}
    assert set(growth["deviation"]) == keys
    distance = growth["distance"]
    assert set(distance) == {*keys, "smoothing_length_mm"}
    assert distance["smoothing_length_mm"] == 0
    said = f"{distance['lowest_mm']:.3g} to {distance['highest_mm']:.3g} mm from the surface"
    assert said in result.output
    assert "smoothed" not in result.output
    pattern, *_ = fab.read_pattern(tmp_path / "out" / "dome.fold")
    checked = CliRunner().invoke(main, ["check", "out/dome.fold"])
    assert checked.exit_code == 0, checked.output
    assert pattern.face_count == report["counts"]["faces"]


@pytest.mark.parametrize(
    ("face", "faults", "cure"),
    [
        (
            "a",
            {"": ("'a'", 'a whole number or be a list, such as [1.0, 2.0] or ["A", "B"]')},
            " (number of the face of a STEP file, or several; all of them where left out)",
        ),
        ([1, "x", 0.5], {".1": ("'x'", "a whole number"), ".2": ("0.5", "a whole number")}, ""),
    ],
)
def test_faces_that_are_no_numbers_are_named(face, faults, cure):
    design = {"kind": "surface_fit", "surface": "roof.step", "face": face}
    with pytest.raises(InvalidJob) as caught:
        parse_job({"name": "roof", "design": design, "sheet": {"width_mm": 90.0}}, "roof.toml")
    assert str(caught.value).removeprefix("roof.toml: ").splitlines() == [
        f"design.face{place} = {value} is out of bounds: it must be {bound}. Correct it{cure}."
        for place, (value, bound) in faults.items()
    ]


def test_deviations_are_in_millimetres_of_the_made_sheet(tmp_path):
    """The same surface in other units, made as wide, is as far off in millimetres."""
    dome(tmp_path / "mm.stl", size=80.0)
    dome(tmp_path / "m.stl", size=0.08)
    one, other = (job_of(tmp_path, name, turn_deg=0.0) for name in ("mm.stl", "m.stl"))
    one, other = (fab.make(job, ["fold"]).report["growth"] for job in (one, other))
    for name, value in one["deviation"].items():
        assert other["deviation"][name] == pytest.approx(value, abs=1e-3)
    assert other["chosen"]["step"] == pytest.approx(one["chosen"]["step"] / 1000, rel=1e-4)


def test_distances_are_from_the_noisy_original_and_not_from_its_smoothed_copy(tmp_path):
    coords, faces = cap(0.8, 40, 120)
    noise = 0.01 * np.random.default_rng(7).normal(size=coords.shape)
    noisy = trimesh.Trimesh(100 * (coords + noise), faces, process=False)
    noisy.export(tmp_path / "noisy.ply")
    (tmp_path / "noisy.toml").write_text(
        'name = "n"\nsheet = {scale_mm_per_unit = 2.0}\n[design]\nkind = "surface_fit"\n'
        'surface = "noisy.ply"\ncolumns = 10\nzigzag = 2.0\nturn_deg = 0.0\n'
    )
    arguments = ["run", str(tmp_path / "noisy.toml"), "--out", str(tmp_path), "--only", "fold"]
    result = CliRunner().invoke(main, arguments)
    growth = json.loads((tmp_path / "n_report.json").read_text())["growth"]
    length = 2 * growth["chosen"]["smoothing_length"]
    assert growth["distance"]["smoothing_length_mm"] == pytest.approx(length)
    assert f"a copy of it smoothed over {length:.3g} mm is followed" in result.output
    folded = fab.read_pattern(tmp_path / "n.fold")[0].folded_coords
    far, _, near = igl.point_mesh_squared_distance(folded / 2, noisy.vertices, noisy.faces)
    far, inner = 2 * np.sqrt(far), np.hypot(*near[:, :2].T) < 69
    assert growth["distance"]["largest_mm"] == pytest.approx(far[inner].max(), rel=1e-3)
    assert growth["distance"]["rms_mm"] == pytest.approx(np.sqrt((far[inner] ** 2).mean()), rel=0.1)
    copy = 2 * 100 * (np.linalg.norm(folded / 200, axis=1) - 1)
    assert np.abs(far - np.abs(copy))[inner].max() > 1.0  # the noise is in it


def test_a_ball_becomes_sheets_side_by_side(tmp_path):
    trimesh.creation.icosphere(2, 50.0).export(tmp_path / "ball.stl")
    job = job_of(tmp_path, "ball.stl", zigzag=2.0, row_step=1.0, turn_deg=90.0)
    made = fab.make(job, ["fold", "svg"])
    growth = made.report["growth"]
    assert growth["chosen"]["sheets"] >= 2
    assert growth["coverage"] > 0.98
    assert "overlap" not in " ".join(codes(made))
    width, height = made.report["bounding_box_mm"]["flat"][:2]
    assert width == pytest.approx(300.0)
    assert height > 0


def test_repairs_of_the_file_are_findings_of_the_job(tmp_path):
    coords, faces = cap(np.pi / 3, 12, 36)
    faces[5] = faces[5, ::-1]  # one face is wound against its neighbours
    lines = [f"v {x} {y} {z}" for x, y, z in coords.tolist()]
    lines += [f"f {a} {b} {c}" for a, b, c in (faces + 1).tolist()]
    (tmp_path / "dome.obj").write_text("\n".join(lines))
    job = job_of(tmp_path, "dome.obj", turn_deg=0.0)
    design, findings = job.design.design(tmp_path)
    assert findings
    assert design.surface.wound.all()
    made = fab.make(job, ["fold"])
    assert set(codes(made)) >= {finding.code for finding in findings}
    _, listed = grown_pattern(job)
    assert set(findings) <= set(listed)


def pieces_apart(gap):
    """Two flat sheets of two by two faces each, upright to one another, which pass by `gap`."""
    x, y = np.meshgrid(np.linspace(0, 2, 3), np.linspace(0, 2, 3))
    level = QuadMesh.from_rows(np.stack([x, y, 0 * x], axis=-1))
    upright = QuadMesh.from_rows(np.stack([x + gap, 0 * x + 0.9, y - 0.7], axis=-1))
    return joined([level, upright])


def test_sheets_that_pass_through_each_other_meet_and_do_not_cross():
    for gap, meet in ((3.0, 0), (0.4, 1)):
        made = _made_of(pieces_apart(gap)).make(["fold"])
        found = [finding for finding in made.findings if finding.code == "sheets-meet"]
        assert len(found) == meet
        assert all(finding.severity == Severity.NOTE for finding in found)
        assert not [code for code in codes(made, Severity.ERROR) if "cross" in code]


def _made_of(mesh):
    return fab.from_mesh(mesh, **SIZE)


def test_pairs_of_faces_are_told_apart_by_their_pieces():
    pattern = _made_of(pieces_apart(3.0)).pattern
    same, between = by_pieces(pattern, np.array([[0, 3], [1, 4], [4, 7], [3, 7]]))
    assert same.tolist() == [[0, 3], [4, 7]]
    assert between.tolist() == [[1, 4], [3, 7]]


def test_a_surface_that_is_not_followed_is_an_error():
    mesh = Miura(columns=4, rows=3).grow().mesh
    growth = Growth(
        mesh,
        3,
        Status.NOT_FITTED,
        "Use more columns.",
        0.8,
        {},
        np.zeros(len(mesh.vertices_coords)),
    )
    first, second = growth_findings(growth)
    assert (first.code, first.severity) == ("surface-not-followed", Severity.ERROR)
    assert first.text == "Use more columns."
    assert second.code == "surface-not-covered"
    assert "trim" not in second.text


@pytest.mark.parametrize(
    ("name", "content", "text"),
    [
        ("none.stl", None, r"none\.stl: cannot be read: No such file"),
        ("bad.stl", b"solid nothing", r"bad\.stl.* at least one face"),
        ("empty.obj", b"", r"empty\.obj.* at least one face"),
        ("part.iges", b"x", r"part\.iges: surfaces are read from files that end in .*\.stl"),
    ],
)
@pytest.mark.parametrize("method", ["auto", "relax"])
def test_files_that_are_no_surfaces_are_refused(tmp_path, name, content, text, method):
    if content is not None:
        (tmp_path / name).write_bytes(content)
    with pytest.raises((InvalidFile, InvalidJob), match=text):
        fab.make(job_of(tmp_path, name, method=method), ["fold"])


@pytest.mark.parametrize(
    ("design", "text"),
    [
        ({"columns": 3}, r"design\.columns: columns = 3 .* from 4"),
        ({"columns": 401}, r"design\.columns: columns = 401 .* at most 400"),
        ({"method": "spin"}, r"design\.method: method = spin .* auto, grow, relax"),
        ({"face": 0}, r"design: face = 0 .*mesh"),
    ],
)
def test_settings_out_of_bounds_are_named_as_in_the_job(tmp_path, design, text):
    dome(tmp_path / "dome.stl")
    with pytest.raises(InvalidJob, match=text):
        fab.make(job_of(tmp_path, "dome.stl", **design), ["fold"])


def test_a_surface_with_formulas_is_grown_unless_it_is_to_be_relaxed():
    grown = SurfaceFit("hypar", columns=8).grow()
    assert grown.deviations is None
    relaxed = SurfaceFit("hypar", method="relax", columns=8, turn=0.0).grow()
    assert relaxed.status is Status.GROWN
    assert len(relaxed.deviations)


def test_a_face_that_crosses_itself_when_flat_is_named_so():
    texts = [overlap_findings(np.array(pairs))[0].text for pairs in ([[1, 1], [1, 2]], [[1, 2]])]
    assert "2 pairs of faces share area, the first is face 1 with itself. " in texts[0]
    assert "1 pair of faces share area, the first are 1 and 2. " in texts[1]


@pytest.mark.parametrize("ending", [".3mf", ".glb", ".off"])
def test_meshes_of_every_kind_of_file_are_grown_on(tmp_path, ending):
    made = trimesh.Trimesh(*cap(np.pi / 6, 12, 36), process=False)
    if ending == ".3mf":
        model = Lib3MF.Wrapper().CreateModel()
        mesh = model.AddMeshObject()
        mesh.SetGeometry(
            [Lib3MF.Position(tuple(point)) for point in made.vertices.tolist()],
            [Lib3MF.Triangle(tuple(face)) for face in made.faces.tolist()],
        )
        model.AddBuildItem(mesh, Lib3MF.Wrapper().GetIdentityTransform())
        with writing_3mf():
            model.QueryWriter("3mf").WriteToFile(str(tmp_path / "cap.3mf"))
    else:
        made.export(tmp_path / f"cap{ending}")
    made.export(tmp_path / "cap.stl")
    sheets = [
        grown_pattern(job_of(tmp_path, name, 8, method="grow"))
        for name in (f"cap{ending}", "cap.stl")
    ]
    sizes = [np.sort(np.ptp(sheet.vertices_coords, axis=0)) for sheet, _ in sheets]
    np.testing.assert_allclose(*sizes, rtol=2e-3, atol=1e-9)
    with pytest.raises(InvalidJob, match=r"face = 0 .* left out for a mesh"):
        grown_pattern(job_of(tmp_path, f"cap{ending}", 8, method="grow", face=0))


def test_a_mesh_of_any_topology_cannot_be_grown_on(tmp_path):
    dome(tmp_path / "dome.stl")
    mesh = read_surface_mesh(tmp_path / "dome.stl").mesh
    with pytest.raises(InvalidValue, match="relax for a SurfaceMesh"):
        SurfaceFit(mesh, method="grow").grow()
