"""One shape out of files of every kind: the same kind of mesh, and nearly the same points."""

import numpy as np
import pytest
import surface_meshes as made
import trimesh
from build123d import (
    Box,
    Compound,
    Face,
    Mesher,
    Pos,
    Rot,
    Sphere,
    Unit,
    Vector,
    export_step,
    extrude,
    fillet,
    import_step,
)

from fab.errors import InvalidFile
from fab.surfaces.mesh_reader import MESH_ENDINGS
from fab.surfaces.reading import read_surface_mesh
from solver.errors import InvalidValue
from solver.targets.mesh_target import MeshTarget
from solver.targets.surface_mesh import MeshKind

pytestmark = pytest.mark.usefixtures("read_in_this_process")


def height(x, y):
    return 6 * np.cos(x / 15) * np.cos(y / 12)


def free_form():
    """A spline face over [-20, 20] x [-16, 16]."""
    x, y = np.linspace(-20, 20, 9), np.linspace(-16, 16, 9)
    grid = [[Vector(a, b, float(height(a, b))) for b in y] for a in x]
    return Face.make_surface_from_array_of_points(grid)


def as_mesh():
    return made.grid(lambda x, y: (x, y, height(x, y)), 80, 80, u=(-20, 20), v=(-16, 16))


def far_from(first, second):
    """How far the points of one mesh are from another one, at most."""
    target = MeshTarget(second)
    points = first.vertices_coords
    _, _, places = target.distance(points, target.unknown(len(points)))
    return np.linalg.norm(points - target.mesh_point(places), axis=1).max()


@pytest.mark.parametrize("ending", [".glb", ".obj", ".off", ".ply", ".stl"])
def test_meshes_of_all_formats_are_the_same(ending, tmp_path):
    path = tmp_path / f"a{ending}"
    coords, faces = as_mesh()
    trimesh.Trimesh(coords, faces, process=False).export(path)
    clean = read_surface_mesh(path)
    assert clean.findings == ()
    assert clean.mesh.kind is MeshKind.DISC
    assert len(clean.mesh.faces_vertices) == len(faces)
    assert far_from(clean.mesh, made.mesh_of((coords, faces))) < 1e-5  # single precision
    assert ending in MESH_ENDINGS


def test_3mf_files_are_in_millimetres_with_their_transforms(tmp_path):
    path = tmp_path / "a.3mf"
    writer = Mesher(unit=Unit.CM)
    writer.add_shape(Pos(1, 2, 3) * Sphere(2))
    with made.writing_3mf():
        writer.write(path)
    clean = read_surface_mesh(path)
    assert clean.mesh.kind is MeshKind.SPHERE
    middle = np.ptp(clean.mesh.vertices_coords, axis=0) / 2 + clean.mesh.vertices_coords.min(axis=0)
    assert middle == pytest.approx([10, 20, 30], abs=0.1)
    assert np.linalg.norm(clean.mesh.vertices_coords - [10, 20, 30], axis=1) == pytest.approx(
        20, rel=3e-3
    )


def test_a_mesh_a_step_face_a_face_of_a_solid_and_adjacent_faces_are_one_surface(tmp_path):
    coords, faces = as_mesh()
    trimesh.Trimesh(coords, faces, process=False).export(tmp_path / "mesh.stl")
    mesh = read_surface_mesh(tmp_path / "mesh.stl").mesh
    face = free_form()
    export_step(face, tmp_path / "face.step")
    solid = Pos(0, 0, 0) * Box(40, 32, 40) - extrude(face, 60, dir=(0, 0, 1))
    export_step(solid, tmp_path / "solid.step")
    top = _number_of_top(tmp_path / "solid.step")
    halves = Compound(
        [face & Pos(-10, 0, 0) * Box(20, 40, 40), face & Pos(10, 0, 0) * Box(20, 40, 40)]
    )
    export_step(halves, tmp_path / "halves.step")
    read = [
        read_surface_mesh(tmp_path / "face.step").mesh,
        read_surface_mesh(tmp_path / "solid.step", top).mesh,
        read_surface_mesh(tmp_path / "halves.step", [0, 1]).mesh,
    ]
    stated = 1e-4 * mesh.size
    for other in read:
        assert other.kind is MeshKind.DISC
        assert far_from(other, mesh) < stated + 0.01  # the mesh's own facets
        assert far_from(mesh, other) < stated + 0.01
        assert other.area == pytest.approx(mesh.area, rel=1e-3)
        up = other.doubled_areas[:, 2]
        assert (up > 0).all() or (up < 0).all()


def _number_of_top(path):
    kinds = [face.geom_type.name for face in import_step(path).faces()]
    return kinds.index("BSPLINE")


def test_all_faces_of_a_body_are_a_closed_surface_outwards(tmp_path):
    body = Rot(10, 20, 30) * fillet(Box(30, 20, 10).edges(), 3)
    export_step(body, tmp_path / "body.step")
    clean = read_surface_mesh(tmp_path / "body.step")
    assert clean.mesh.kind is MeshKind.SPHERE
    (finding,) = clean.findings
    assert finding.code == "model-faces"
    assert "All 26 faces" in finding.text
    assert ": plane of " in finding.text  # so that one may be chosen
    first = clean.mesh.vertices_coords[clean.mesh.faces_vertices[:, 0]]
    volume = float((first * clean.mesh.doubled_areas).sum() / 6)
    assert volume == pytest.approx(body.volume, rel=2e-3)


def test_faces_that_are_not_adjacent_are_pieces(tmp_path):
    export_step(Box(30, 20, 10), tmp_path / "box.step")
    first, *others = import_step(tmp_path / "box.step").faces()
    across = [abs(face.normal_at().dot(first.normal_at())) > 0.5 for face in others]
    apart = read_surface_mesh(tmp_path / "box.step", [0, 1 + across.index(True)])
    assert [finding.code for finding in apart.findings] == ["mesh-pieces"]
    assert apart.mesh.area == pytest.approx(first.area)
    beside = 1 + across.index(False)
    joined = read_surface_mesh(tmp_path / "box.step", [0, beside])
    assert joined.findings == ()
    assert joined.mesh.area == pytest.approx(first.area + others[beside - 1].area)


def test_what_cannot_be_read_is_refused_with_its_name(tmp_path):
    stl = tmp_path / "a.stl"
    stl.write_text(
        "solid a\nfacet normal 0 0 1\nouter loop\nvertex nan 0 0\nvertex 1 0 0\n"
        "vertex 0 1 0\nendloop\nendfacet\nendsolid a\n"
    )
    with pytest.raises(InvalidFile, match=r"a\.stl: 1 vertex is not finite"):
        read_surface_mesh(stl)
    with pytest.raises(InvalidFile, match=r"files that end in \.3mf, \.glb"):
        read_surface_mesh(tmp_path / "a.dwg")
    with pytest.raises(InvalidFile, match="Check the path"):
        read_surface_mesh(tmp_path / "none.stl")
    with pytest.raises(InvalidValue, match="be None for a mesh"):
        read_surface_mesh(stl, 0)
    export_step(Box(1, 1, 1), tmp_path / "box.step")
    with pytest.raises(
        InvalidValue,
        match=r"face = 6 is out of bounds: it must lie from 0 to 5.*5: plane of 1 mm2",
    ):
        read_surface_mesh(tmp_path / "box.step", [0, 6])
    with pytest.raises(InvalidValue, match="name a face"):
        read_surface_mesh(tmp_path / "box.step", [])
    with pytest.raises(InvalidValue, match="whole number"):
        read_surface_mesh(tmp_path / "box.step", [True])
    damaged = tmp_path / "a.3mf"
    damaged.write_bytes(b"PK no zip")
    with pytest.raises(InvalidFile, match=r"a\.3mf"):
        read_surface_mesh(damaged)
