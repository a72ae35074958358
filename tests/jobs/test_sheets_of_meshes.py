"""Sheets of meshes: the same files as a job's, and findings where a mesh is no sheet."""

import json

import numpy as np
import pytest

import fab
from fab.errors import InvalidJob, Severity
from solver import InvalidValue, Miura, TiltedRings

SIZE = {"width_mm": 200.0}
TABLES = {"panels": {"thickness_mm": 1.2}, "tolerance": 1e-8}


def made_by_job(kind, **keys):
    design = {"kind": kind, **keys}
    return fab.parse_job({**TABLES, "name": "sheet", "design": design, "sheet": SIZE})


def without(report, *keys):
    report = json.loads(report)
    return {key: value for key, value in report.items() if key not in ("seconds", *keys)}


def test_a_grown_mesh_and_its_rows_give_what_the_job_gives(tmp_path):
    formats = ["fold", "dxf", "svg", "stl", "png"]
    mesh = Miura(columns=4, rows=3).grow().mesh
    by_job = fab.make(made_by_job("miura", columns=4, rows=3), formats)
    rows = mesh.vertices_coords[mesh.grid]
    for source in (mesh, rows, rows.tolist()):
        sheet = fab.from_mesh(source, **SIZE, settings=TABLES)
        made = sheet.write(tmp_path / "out", formats)
        assert made.files == {p.name: p.read_bytes() for p in (tmp_path / "out").iterdir()}
        assert set(made.files) == set(by_job.files)
        for name in set(made.files) - {"sheet_report.json"}:
            assert made.files[name] == by_job.files[name], name
        own, theirs = made.report, by_job.report
        assert own["growth"] is None
        assert own["job"] == {k: v for k, v in theirs["job"].items() if k != "design"}
        reports = (each.files["sheet_report.json"] for each in (made, by_job))
        assert len({json.dumps(without(r, "job", "growth")) for r in reports}) == 1


def test_rings_are_cut_open():
    design = TiltedRings(sides=5, strips=4)
    mesh = design.grow().mesh
    by_job = fab.make(made_by_job("tilted_rings", sides=5, strips=4), ["fold"])
    rows = mesh.vertices_coords[mesh.grid]
    for sheet in (fab.from_mesh(mesh, **SIZE), fab.from_mesh(rows, **SIZE, closed=True)):
        assert sheet.make(["fold"]).files["sheet.fold"] == by_job.files["sheet.fold"]


def test_a_mesh_that_no_flat_sheet_folds_to_is_an_error():
    x, y = np.meshgrid(np.linspace(-1, 1, 6), np.linspace(-1, 1, 5))
    sheet = fab.from_mesh(np.stack([x, y, 0.3 * (x**2 + y**2)], axis=2), width_mm=100.0)
    made = sheet.make(["fold"])
    assert not made.within_tolerance
    codes = {finding.code for finding in made.findings if finding.severity == Severity.ERROR}
    assert "not-developable" in codes


def test_what_is_at_fault_is_named(tmp_path):
    rows = Miura(columns=4, rows=3).grow().mesh.vertices_coords.reshape(4, 5, 3)
    with pytest.raises(InvalidJob, match="give exactly one of"):
        fab.from_mesh(rows)
    with pytest.raises(InvalidJob, match=r"panels.thicknes_mm .* Did you mean"):
        fab.from_mesh(rows, **SIZE, settings={"panels": {"thicknes_mm": 1.0}})
    with pytest.raises(InvalidJob, match="design is not a known key"):
        fab.from_mesh(rows, **SIZE, settings={"design": {"kind": "miura"}})
    with pytest.raises(InvalidValue, match="rows = array of shape"):
        fab.from_mesh(rows[0], **SIZE)
    with pytest.raises(InvalidJob, match=r"format 'dfx' must be among .* Did you mean dxf\?"):
        fab.from_mesh(rows, **SIZE).write(tmp_path / "out", ["dfx"])
    assert not (tmp_path / "out").exists()
    (tmp_path / "mine.toml").write_text("kind = 3")
    printed = fab.from_mesh(
        rows, **SIZE, settings={"printer": {"machine": "mine.toml"}}, folder=tmp_path
    )
    with pytest.raises(InvalidJob, match=r"mine.toml: kind = '3' must be 'printer'"):
        printed.make(["stl"])


def test_a_sheet_with_a_face_inside_out_is_made_with_its_errors():
    rows = np.zeros((3, 3, 3))
    rows[..., 0], rows[..., 1] = np.meshgrid(np.arange(3.0), np.arange(3.0))
    rows[1, 1, :2] = 2.5, 2.5  # beyond the corner of its faces
    made = fab.from_mesh(rows, **SIZE).make(["fold"])
    assert made.report["rigid"] is None
    assert [finding.code for finding in made.findings] == ["not-developable", "not-isometric"]
