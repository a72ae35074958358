"""Panels, webs and their files, checked with manifold3d and read back by other readers."""

import io
import re
import xml.etree.ElementTree as ElementTree
import zipfile

import numpy as np
import pytest
import trimesh
from fab.solid import assembly, step_bytes, stl_bytes, threemf_bytes
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from manifold3d import Error, Manifold, Mesh64
from strategies import patches

from fab.bodies import joined_mesh, prism_meshes
from fab.crease import CreasePattern, assignments, crease_pattern
from fab.development import develop
from fab.errors import Severity
from fab.hinges import HingeSettings, make_webs
from fab.inspection import inspect_solids
from fab.panels import PanelSettings, inset, make_panels
from solver import CurvedFold, Miura
from solver.mesh import edges_of


def pattern_of(mesh, width_mm=200.0):
    development = develop(mesh)
    return crease_pattern(mesh, development, width_mm / development.vertices_coords.max())


def polygon_pattern(coords, faces, angle_deg=60.0) -> CreasePattern:
    corners = np.array([v for face in faces for v in face])
    offsets = np.concatenate([[0], np.cumsum([len(face) for face in faces])])
    edges = edges_of(corners, offsets)
    angle = np.where(edges.edges_faces[:, 1] >= 0, angle_deg, 0.0)
    return CreasePattern(
        np.array(coords, float),
        edges.edges_vertices,
        edges.edges_faces,
        assignments(angle, edges),
        angle,
        corners,
        offsets,
    )


def manifold(mesh) -> Manifold:
    return Manifold(Mesh64(mesh.vertices_coords, mesh.triangles.astype(np.uint64)))


@pytest.fixture(scope="module")
def miura():
    pattern = pattern_of(Miura(columns=4, rows=4).grow().mesh, 100.0)
    panels, missing = make_panels(pattern, PanelSettings())
    webs, open_creases = make_webs(pattern, panels, HingeSettings())
    assert missing == open_creases == []
    return pattern, panels, webs


def test_inset_of_a_square_with_its_own_setbacks():
    square = np.array([[0.0, 0], [10, 0], [10, 10], [0, 10]])
    moved, kept = inset(square, np.array([0, 4]), np.array([1.0, 2.0, 0.0, 0.5]))
    assert moved == pytest.approx(np.array([[0.5, 1], [8, 1], [8, 10], [0.5, 10]]))
    assert kept.tolist() == [True]
    _, kept = inset(square, np.array([0, 4]), np.array([1.0, 5.0, 0.0, 5.0]))
    assert kept.tolist() == [False]


def test_inset_at_reflex_and_straight_corners():
    dart = np.array([[0.0, 0], [4, 4], [0, 1], [-4, 4]]) * 5
    moved, kept = inset(dart, np.array([0, 4]), np.full(4, 0.2))
    assert kept.all()
    sides = np.roll(dart, -1, axis=0) - dart
    normal = np.column_stack([-sides[:, 1], sides[:, 0]]) / np.hypot(*sides.T)[:, None]
    assert ((moved - dart) * normal).sum(axis=1) == pytest.approx(np.full(4, 0.2))
    straight = np.array([[0.0, 0], [5, 0], [10, 0], [10, 10], [0, 10]])
    moved, kept = inset(straight, np.array([0, 5]), np.full(5, 1.0))
    assert moved[1] == pytest.approx([5, 1])
    assert kept.all()


def test_counts_volume_and_bodies_of_a_miura_sheet(miura):
    pattern, panels, webs = miura
    assert len(panels.prisms) == 16
    assert len(webs.prisms) == 24
    joined = joined_mesh(panels, webs)
    figures, findings = inspect_solids(pattern, panels, webs, joined, 1.0)
    assert [f.severity for f in findings] == [Severity.WARNING]  # valleys meet before the target
    assert figures.bodies == 1
    assert figures.overlap_max_mm3 < 1e-9
    assert figures.clearance_min_mm == pytest.approx(1.0, abs=1e-9)
    assert manifold(joined).volume() == pytest.approx(figures.volume_mm3, rel=1e-12)


def test_the_inner_panel_of_a_square_grid_has_the_exact_volume():
    y, x = np.mgrid[:4, :4] * 20.0
    faces = [
        [4 * j + i, 4 * j + i + 1, 4 * j + i + 5, 4 * j + i + 4] for j in range(3) for i in range(3)
    ]
    pattern = polygon_pattern(np.column_stack([x.ravel(), y.ravel()]), faces)
    panels, _ = make_panels(pattern, PanelSettings(thickness_mm=2.0, gap_mm=1.0))
    webs, _ = make_webs(pattern, panels, HingeSettings(web_mm=0.5, relief_mm=0.25))
    volumes = panels.prisms.volumes_mm3()
    assert volumes[4] == pytest.approx(19 * 19 * 2, rel=1e-14)
    assert volumes[0] == pytest.approx(19.5 * 19.5 * 2, rel=1e-14)
    # webs: 0.5 thick, 1 wide, as long as both panels' sides less the reliefs
    lengths = np.sort(webs.prisms.volumes_mm3()) / 0.5
    assert lengths == pytest.approx([18.5] * 4 + [19.0] * 8, rel=1e-12)


@settings(max_examples=30)
@given(patches(), st.floats(0.2, 1.0), st.floats(0.5, 3.0))
def test_joined_body_is_closed_and_has_the_volume_of_its_parts(mesh, gap, thickness):
    pattern = pattern_of(mesh, 400.0)
    panels, _ = make_panels(pattern, PanelSettings(thickness_mm=thickness, gap_mm=gap))
    assume(len(panels.prisms) > 0)
    webs, _ = make_webs(pattern, panels, HingeSettings(web_mm=0.3, relief_mm=0.2))
    body = manifold(joined_mesh(panels, webs))
    assert body.status() == Error.NoError
    total = panels.prisms.volumes_mm3().sum() + webs.prisms.volumes_mm3().sum()
    assert body.volume() == pytest.approx(total, rel=1e-9)
    for prisms in (panels.prisms, webs.prisms):
        for solid, volume in zip(prism_meshes(prisms), prisms.volumes_mm3(), strict=True):
            assert manifold(solid).status() == Error.NoError
            assert manifold(solid).volume() == pytest.approx(volume, rel=1e-9)


def test_triangles_darts_and_hexagons_stand_as_panels():
    angle = np.arange(6) * np.pi / 3
    ring = np.column_stack([np.cos(angle), np.sin(angle)]) * 20
    coords = [*ring.tolist(), [0, 40], [24, 30]]
    pattern = polygon_pattern(coords, [[0, 1, 2, 3, 4, 5], [2, 1, 6], [1, 7, 6]])
    panels, missing = make_panels(pattern, PanelSettings())
    webs, open_creases = make_webs(pattern, panels, HingeSettings())
    assert missing == open_creases == []
    joined = joined_mesh(panels, webs)
    figures, findings = inspect_solids(pattern, panels, webs, joined, 1.0)
    assert not [f for f in findings if f.severity == Severity.ERROR]
    assert figures.panels == 3
    assert figures.hinges == 2


def test_webs_stay_between_the_ends_of_their_crease():
    """Two faces along a slit that opens by 6 degrees: panels reach beyond the crease."""
    a = np.radians(3)
    coords = [
        (0, 0), (20, 0), (20, 10), (0, 10), (-20 * np.cos(a), 20 * np.sin(a)),
        (20, -10), (0, -10), (-20 * np.cos(a), -20 * np.sin(a)),
    ]  # fmt: skip
    pattern = polygon_pattern(coords, [[0, 1, 2, 3, 4], [0, 7, 6, 5, 1]])
    panels, _ = make_panels(pattern, PanelSettings())
    webs, _ = make_webs(pattern, panels, HingeSettings(relief_mm=0.3))
    x = webs.prisms.bottom[:, 0]
    assert x.min() == pytest.approx(0.3)
    assert x.max() == pytest.approx(19.7)


def test_polygons_of_more_than_four_sides_must_be_convex():
    ell = [[0, 0], [30, 0], [30, 10], [10, 10], [10, 30], [0, 30], [30, -20], [0, -20]]
    pattern = polygon_pattern(ell, [[0, 1, 2, 3, 4, 5], [0, 7, 6, 1]])
    panels, findings = make_panels(pattern, PanelSettings())
    assert [f.code for f in findings] == ["panel-not-convex"]
    assert findings[0].panels == (0,)
    assert panels.faces.tolist() == [1]


def test_valleys_without_a_web_block_as_well(miura):
    pattern, panels, _ = miura
    webs, _ = make_webs(pattern, panels, HingeSettings(relief_mm=12.0))
    _, findings = inspect_solids(pattern, panels, webs, joined_mesh(panels, webs), 1.0)
    assert "fold-blocked" in [f.code for f in findings]


def test_faces_smaller_than_their_gaps_are_left_out_and_named():
    pattern = pattern_of(Miura(columns=4, rows=4).grow().mesh, 12.0)
    panels, findings = make_panels(pattern, PanelSettings(gap_mm=2.6))
    assert [f.code for f in findings] == ["panel-vanishes"]
    assert findings[0].severity == Severity.ERROR
    assert set(findings[0].panels).isdisjoint(panels.faces.tolist())
    assert len(findings[0].panels) + len(panels.faces) == 16


def test_creases_without_room_for_a_web_are_named_and_loose_panels_found(miura):
    pattern, panels, _ = miura
    webs, findings = make_webs(pattern, panels, HingeSettings(relief_mm=12.0))
    assert [f.code for f in findings] == ["hinge-missing"]
    assert len(webs.prisms) == 0
    figures, findings = inspect_solids(pattern, panels, webs, joined_mesh(panels, webs), 1.0)
    assert figures.bodies == 16
    assert "panels-loose" in [f.code for f in findings]


def test_panels_of_a_sheet_that_overlaps_itself_are_caught():
    """Negative control: a strip that turns by more than a full circle in the plane."""
    mesh = CurvedFold(columns=60, strips=1).grow().mesh
    pattern = pattern_of(mesh, 380.0)
    panels, _ = make_panels(pattern, PanelSettings(gap_mm=0.4))
    webs, _ = make_webs(pattern, panels, HingeSettings())
    _, findings = inspect_solids(pattern, panels, webs, joined_mesh(panels, webs), 0.4)
    expected = {tuple(pair) for pair in develop(mesh).overlaps.tolist()}
    caught = [f.panels for f in findings if f.code == "solids-overlap" and len(f.panels) == 2]
    assert len(caught) > 10
    assert set(caught) <= expected


def test_the_assembly_of_the_python_api_has_labels_and_colours(miura):
    pattern, panels, webs = miura
    compound = assembly(panels, webs, pattern.edges_assignment.tolist(), "miura")
    assert [child.label for child in compound.children[:2]] == ["panel_0", "panel_1"]
    assert len(compound.solids()) == 40
    assert len({tuple(child.color) for child in compound.children}) == 3


def test_a_gap_that_is_too_narrow_is_caught(miura):
    pattern, panels, webs = miura
    joined = joined_mesh(panels, webs)
    _, findings = inspect_solids(pattern, panels, webs, joined, 1.5)  # made with 1.0
    assert "clearance-too-small" in [f.code for f in findings]


def test_stl_is_watertight_in_single_precision(miura):
    _, panels, webs = miura
    joined = joined_mesh(panels, webs)
    back = trimesh.load(io.BytesIO(stl_bytes(joined)), file_type="stl")
    assert back.is_watertight
    assert back.is_winding_consistent
    assert back.body_count == 1
    assert back.volume == pytest.approx(manifold(joined).volume(), rel=1e-5)
    assert len(back.faces) == len(joined.triangles)
    assert back.area_faces.min() > 1e-6


def test_threemf_holds_the_same_surface_in_millimetres(miura):
    _, panels, webs = miura
    joined = joined_mesh(panels, webs)
    package = zipfile.ZipFile(io.BytesIO(threemf_bytes(joined, 'name with "<&>"')))
    assert package.testzip() is None
    assert {entry.date_time for entry in package.infolist()} == {(1980, 1, 1, 0, 0, 0)}
    core = "{http://schemas.microsoft.com/3dmanufacturing/core/2015/02}"
    model = ElementTree.fromstring(package.read("3D/3dmodel.model"))
    assert model.get("unit") == "millimeter"
    vertices = [[float(v.get(k)) for k in "xyz"] for v in model.iter(f"{core}vertex")]
    triangles = [[int(t.get(f"v{k}")) for k in (1, 2, 3)] for t in model.iter(f"{core}triangle")]
    assert np.array(vertices) == pytest.approx(joined.vertices_coords, abs=1e-6)
    assert (np.array(triangles) == joined.triangles).all()
    assert model.find(f"{core}resources/{core}object").get("name") == 'name with "<&>"'


def test_step_holds_named_coloured_valid_solids(miura, tmp_path):
    from build123d import import_step

    pattern, panels, webs = miura
    letters = pattern.edges_assignment.tolist()
    data = step_bytes(panels, webs, letters, "miura")
    (tmp_path / "miura.step").write_bytes(data)
    back = import_step(tmp_path / "miura.step")
    solids = back.solids()
    assert len(solids) == 40
    assert all(solid.is_valid for solid in solids)
    exact = panels.prisms.volumes_mm3().sum() + webs.prisms.volumes_mm3().sum()
    assert sum(solid.volume for solid in solids) == pytest.approx(exact, rel=1e-9)
    names = {child.label for child in back.children}
    assert names == {f"panel_{f}" for f in panels.faces} | {f"hinge_{e}" for e in webs.creases}
    colours = {child.label: tuple(child.color)[:3] for child in back.children}
    mountain = next(e for e in webs.creases if letters[e] == "M")
    valley = next(e for e in webs.creases if letters[e] == "V")
    assert colours[f"hinge_{mountain}"][0] > colours[f"hinge_{mountain}"][2]
    assert colours[f"hinge_{valley}"][2] > colours[f"hinge_{valley}"][0]


def test_step_bytes_repeat_within_a_process(miura):
    pattern, panels, webs = miura
    letters = pattern.edges_assignment.tolist()
    one, two = (step_bytes(panels, webs, letters, "miura") for _ in range(2))
    assert one == two
    assert re.search(rb"FILE_NAME\('miura','1980-01-01T00:00:00'", one)
