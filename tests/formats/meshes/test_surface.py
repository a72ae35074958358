"""Surfaces out of files: faces of STEP models as exact splines, meshes, and what is refused."""

import numpy as np
import pytest
import trimesh
from build123d import (
    Axis,
    Circle,
    Compound,
    Cone,
    Cylinder,
    Face,
    Line,
    Plane,
    Pos,
    Rectangle,
    Rot,
    Solid,
    Sphere,
    Spline,
    Torus,
    Vector,
    export_step,
    import_step,
)

from fab.errors import InvalidFile
from fab.formats.meshes.spline_face import SplineFace
from fab.formats.meshes.step_faces import spline_face
from fab.formats.meshes.surface import read_surface
from solver import Status, developability, planarity
from solver.errors import InvalidValue
from solver.fitting import fit_surface
from solver.targets.mesh import MeshSurface

pytestmark = pytest.mark.usefixtures("read_in_this_process")

TURN = Rot(20, 30, 40)


def axes_of(turn):
    plane = Plane(turn)
    return np.array([[*plane.x_dir], [*plane.y_dir], [*plane.z_dir]])


def free_form():
    grid = [
        [Vector(x, 1.5 * y, np.sin(x) * np.cos(1.3 * y)) for y in np.linspace(-1, 1, 6)]
        for x in np.linspace(-1.5, 1.5, 7)
    ]
    return Face.make_surface_from_array_of_points(grid)


@pytest.fixture(scope="module")
def face_of(tmp_path_factory):
    """Writes a shape as a STEP file and gives one of its faces back, as CAD face and as ours."""
    folder = tmp_path_factory.mktemp("step")

    def of(shape, kind, name) -> tuple[Face, SplineFace]:
        path = folder / f"{name}.step"
        export_step(shape, path)
        face = next(f for f in import_step(path).faces() if f.geom_type.name == kind)
        return face, spline_face(face)

    return of


def misses(points, name):
    """How far points are off the surface with such a name, by its equation."""
    x, y, z = axes_of(TURN) @ points.T
    if name == "plane":
        return z - 2.5
    if name == "cylinder":
        return np.hypot(x, y) - 2
    if name == "cone":
        return np.hypot(x, y) - (1.5 - z / 4)
    if name == "sphere":
        return np.sqrt(x * x + y * y + z * z) - 3
    return np.hypot(np.hypot(x, y) - 4, z) - 1


SHAPES = {
    "plane": (lambda: TURN * Pos(0, 0, 2.5) * Rectangle(3, 2), "PLANE"),
    "cylinder": (lambda: TURN * Cylinder(2, 5), "CYLINDER"),
    "cone": (lambda: TURN * Cone(2, 1, 4), "CONE"),
    "sphere": (lambda: TURN * Sphere(3), "SPHERE"),
    "torus": (lambda: TURN * Torus(4, 1), "TORUS"),
}


@pytest.mark.parametrize("name", sorted(SHAPES))
def test_faces_satisfy_their_equations_also_beyond_their_edges(face_of, name):
    make, kind = SHAPES[name]
    _, spline = face_of(make(), kind, name)
    # beyond the poles a sphere has no parameters of its own
    reach = np.array([1.3, 0.95 if name == "sphere" else 1.3])
    u, v = (np.random.default_rng(0).uniform(-1, 1, (200, 2)) * reach).T
    points = spline.position(u, v)
    assert np.abs(misses(points, name)).max() < 1e-12 * np.abs(points).max()
    # tangents are tangent: a step along them leaves the surface in the second order only
    for along in spline.derivatives(u, v):
        slope = (misses(points + 1e-5 * along, name) - misses(points - 1e-5 * along, name)) / 2e-5
        assert np.abs(slope).max() < 1e-7
    assert np.ptp(points, axis=0).min() > 0.5


def curved():
    return {
        **{name: make for name, (make, _) in SHAPES.items()},
        "free": free_form,
        "extruded": lambda: Face.extrude(
            Spline((0, 0), (1, 0.6), (2, 0)).edge(), Vector(0.3, 0, 1)
        ),
        "revolved": lambda: Face.revolve(
            Spline((1, 0, 0), (1.5, 0, 1), (1.2, 0, 2)).edge(), 120, Axis.Z
        ),
    }


KINDS = {name: kind for name, (_, kind) in SHAPES.items()} | {
    "free": "BSPLINE",
    "extruded": "EXTRUSION",
    "revolved": "REVOLUTION",
}


@pytest.mark.parametrize("name", sorted(KINDS))
def test_derivatives_agree_with_differences_and_normals_with_the_model(face_of, name):
    face, spline = face_of(curved()[name](), KINDS[name], f"{name}_slopes")
    u, v = np.random.default_rng(1).uniform(-0.95, 0.95, (2, 60))
    along_u, along_v = spline.derivatives(u, v)
    h = 6e-6
    by_u = (spline.position(u + h, v) - spline.position(u - h, v)) / (2 * h)
    by_v = (spline.position(u, v + h) - spline.position(u, v - h)) / (2 * h)
    # second derivatives jump at knots: leave out differences across one
    assert np.median(np.abs(along_u - by_u)) < 1e-9
    assert np.abs(along_u - by_u).max() < 1e-7
    assert np.abs(along_v - by_v).max() < 1e-7
    normal = np.cross(along_u, along_v)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    points = spline.position(u, v)
    for i in range(0, 60, 10):
        there = face.normal_at(Vector(*points[i].tolist()))
        assert normal[i] == pytest.approx([there.X, there.Y, there.Z], abs=1e-6)


def test_a_free_form_face_has_the_points_of_the_model(face_of):
    from OCP.BRep import BRep_Tool
    from OCP.gp import gp_Pnt, gp_Vec

    face, spline = face_of(free_form(), "BSPLINE", "free_points")
    surface = BRep_Tool.Surface_s(face.wrapped)
    u, v = np.random.default_rng(2).uniform(-1, 1, (2, 50))
    points = spline.position(u, v)
    along_u, along_v = spline.derivatives(u, v)
    for i in range(50):
        s, t = spline.middle + spline.half * [u[i], v[i]]
        point, by_s, by_t = gp_Pnt(), gp_Vec(), gp_Vec()
        surface.D1(s, t, point, by_s, by_t)
        assert points[i] == pytest.approx(point.Coord(), abs=1e-12)
        assert along_u[i] == pytest.approx(spline.half[0] * np.array(by_s.Coord()), abs=1e-12)
        assert along_v[i] == pytest.approx(spline.half[1] * np.array(by_t.Coord()), abs=1e-12)
    # and goes on smoothly beyond its edge
    edge = np.array([1.0])
    inner, outer = spline.position(edge - 1e-7, 0 * edge), spline.position(edge + 1e-7, 0 * edge)
    slope = spline.derivatives(edge, 0 * edge)[0]
    assert outer - inner == pytest.approx(2e-7 * slope, abs=1e-12)


def test_the_normals_of_a_model_point_outwards(tmp_path):
    export_step(Solid.make_box(1, 2, 3), tmp_path / "box.step")
    middle = np.array([0.5, 1.0, 1.5])
    for number in range(6):
        surface = read_surface(tmp_path / "box.step", number)
        place = surface.places(np.zeros((1, 2)))
        outwards = surface.point(place) - middle
        assert surface.normal(place) == pytest.approx(outwards / np.linalg.norm(outwards))
        corners = surface.point(surface.places(np.array([[-1.0, -1], [1, 1]])))
        assert np.sort(np.abs(corners[1] - corners[0]))[0] == pytest.approx(0, abs=1e-12)
        assert surface.inside(np.array([[0.9, -0.9], [1.1, 0]])).tolist() == [True, False]


def test_a_closed_face_goes_on_all_around(face_of):
    _, spline = face_of(Torus(4, 1), "TORUS", "around")
    u, v = np.random.default_rng(3).uniform(-1, 1, (2, 50))
    for du, dv in ((2, 0), (0, -2), (-4, 2)):
        assert spline.position(u + du, v + dv) == pytest.approx(spline.position(u, v), abs=1e-11)


def test_a_trimmed_face_knows_its_edge_and_its_hole(tmp_path):
    sheet = Rectangle(4, 2) - Circle(0.5)
    export_step(sheet, tmp_path / "hole.step")
    surface = read_surface(tmp_path / "hole.step")
    places = np.random.default_rng(4).uniform(-1.1, 1.1, (4000, 2))
    x, y, z = surface.point(places).T
    assert np.abs(z).max() < 1e-12
    radius = np.hypot(x, y)
    clear = np.abs(radius - 0.5) > 1e-3
    expected = (np.abs(x) <= 2) & (np.abs(y) <= 1) & (radius > 0.5)
    assert (surface.inside(places) == expected)[clear].all()
    export_step(Circle(1), tmp_path / "disc.stp")
    disc = read_surface(tmp_path / "disc.stp")
    radius = np.linalg.norm(disc.point(places), axis=1)
    clear = np.abs(radius - 1) > 1e-3
    assert (disc.inside(places) == (radius < 1))[clear].all()


def test_a_trimmed_curved_face_knows_its_edge(tmp_path):
    """A tube with a hole drilled across it."""
    drilled = Cylinder(2, 6) - Rot(0, 90, 0) * Cylinder(0.8, 10)
    export_step(drilled, tmp_path / "drilled.step")
    numbers = [
        i
        for i, face in enumerate(import_step(tmp_path / "drilled.step").faces())
        if face.geom_type.name == "CYLINDER" and face.bounding_box().size.Z > 5
    ]
    surface = read_surface(tmp_path / "drilled.step", numbers[0])
    places = np.random.default_rng(5).uniform(-1, 1, (4000, 2))
    x, y, z = surface.point(places).T
    assert np.abs(np.hypot(x, y) - 2).max() < 1e-12
    from_axis = np.hypot(y, z)
    clear = np.abs(from_axis - 0.8) > 5e-3
    assert (surface.inside(places) == (from_axis > 0.8))[clear].all()
    assert not surface.inside(places).all()


def test_meshes_are_read_as_meshes(tmp_path):
    mesh = trimesh.creation.icosphere(subdivisions=2)
    mesh.update_faces(mesh.triangles_center[:, 2] > 0.3)
    mesh.export(tmp_path / "dome.STL", file_type="stl")
    surface = read_surface(tmp_path / "dome.STL")
    assert isinstance(surface, MeshSurface)
    assert surface.own == len(mesh.faces)


def test_files_that_hold_no_surface_are_refused(tmp_path):
    with pytest.raises(InvalidFile, match=r"\.obj, \.ply, \.stl, \.step, \.stp"):
        read_surface(tmp_path / "surface.iges")
    with pytest.raises(InvalidFile, match="No such file"):
        read_surface(tmp_path / "missing.step")
    with pytest.raises(InvalidFile, match="No such file"):
        read_surface(tmp_path / "missing.stl")
    (tmp_path / "bad.step").write_text("nonsense")
    with pytest.raises(InvalidFile, match="no faces"):
        read_surface(tmp_path / "bad.step")
    export_step(Compound(children=[Line((0, 0), (1, 1))]), tmp_path / "wire.step")
    with pytest.raises(InvalidFile, match="no faces"):
        read_surface(tmp_path / "wire.step")


def test_the_face_must_be_chosen_and_exist(tmp_path):
    path = tmp_path / "cylinder.step"
    export_step(Cylinder(2, 5), path)
    listed = r"face = None .*from 0 to 2.* 0: cylinder of 62.8319 mm2; 1: plane of 12.5664 mm2; 2: "
    with pytest.raises(InvalidValue, match=listed):
        read_surface(path)
    for number in (-1, 3):
        with pytest.raises(InvalidValue, match=f"face = {number} .*from 0 to 2"):
            read_surface(path, number)
    trimesh.creation.icosphere().export(tmp_path / "ball.stl")
    with pytest.raises(InvalidValue, match=r"face = 0 .*mesh"):
        read_surface(tmp_path / "ball.stl", 0)
    many = Compound(children=[Solid.make_box(1, 1, 1 + i) for i in range(4)])
    export_step(many, tmp_path / "many.step")
    with pytest.raises(InvalidValue, match=r"19: plane of .*; \.\.\.\.$"):
        read_surface(tmp_path / "many.step")


def test_faces_that_are_no_exact_splines_are_refused(tmp_path):
    from OCP.BRep import BRep_Tool
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
    from OCP.Geom import Geom_OffsetSurface

    surface = Geom_OffsetSurface(BRep_Tool.Surface_s(free_form().wrapped), 0.1)
    export_step(Face(BRepBuilderAPI_MakeFace(surface, 1e-6).Face()), tmp_path / "offset.step")
    with pytest.raises(InvalidValue, match=r"kind of the face = offset .*B-spline"):
        read_surface(tmp_path / "offset.step")


def test_a_sheet_grows_on_a_free_form_face(tmp_path):
    """A gentle wave over 2.4 mm by 2 mm, to the rim."""
    grid = [
        [Vector(x, y, 0.25 * np.sin(2 * x) * np.cos(1.7 * y)) for y in np.linspace(-1, 1, 9)]
        for x in np.linspace(-1.2, 1.2, 9)
    ]
    export_step(Face.make_surface_from_array_of_points(grid), tmp_path / "wave.step")
    surface = read_surface(tmp_path / "wave.step")
    growth = fit_surface(surface, 20, zigzag=3.0, row_step=1.0)
    coords, faces = growth.mesh.vertices_coords, growth.mesh.faces_vertices
    assert growth.status is Status.GROWN
    assert growth.coverage > 0.98
    assert planarity(coords, faces).max() < 1e-13
    assert developability(coords, faces).max() < 1e-13
