"""Meshes as targets: distances, skirts, files, and what is refused."""

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from solver import Status, developability, planarity
from solver.errors import InvalidValue
from solver.fitting import fit_surface
from solver.targets.mesh import _RINGS, MeshSurface

seeds = st.integers(0, 2**32 - 1)
UP = (0.0, 0.0, 1.0)


def plate(height=lambda x, y: 0 * x, n=9, width=1.0):
    """Vertices and quads of z = height(x, y) over [-1, 1] x [-width, width]."""
    x, y = np.meshgrid(np.linspace(-1, 1, n), np.linspace(-width, width, n), indexing="ij")
    i = np.arange(n * n).reshape(n, n)
    quads = np.stack([i[:-1, :-1], i[1:, :-1], i[1:, 1:], i[:-1, 1:]], axis=-1).reshape(-1, 4)
    return np.column_stack([x.ravel(), y.ravel(), height(x, y).ravel()]), quads


def waves(x, y):
    return 0.2 * np.sin(3 * x) * np.cos(2 * y)


def ball(level):
    mesh = trimesh.creation.icosphere(subdivisions=level)
    return np.array(mesh.vertices), np.array(mesh.faces)


def dome(level=3, floor=0.5):
    """The part of a ball above z = floor, with a ragged rim."""
    coords, faces = ball(level)
    return coords, faces[(coords[faces][..., 2] > floor).all(axis=1)]


def nearest_by_hand(point, corners):
    """Nearest point of one triangle: inside it, else on one of its sides."""
    a, b, c = corners
    plane = np.column_stack([b - a, c - a])
    weights = np.linalg.lstsq(plane, point - a, rcond=None)[0]
    feet = [a + plane @ weights] if weights.min() >= 0 and weights.sum() <= 1 else []
    for p, q in ((a, b), (b, c), (c, a)):
        feet.append(p + np.clip((point - p) @ (q - p) / ((q - p) @ (q - p)), 0, 1) * (q - p))
    return min(feet, key=lambda foot: np.linalg.norm(point - foot))


@settings(max_examples=25)
@given(seed=seeds)
def test_distances_are_those_of_all_triangles_tried_one_by_one(seed):
    rng = np.random.default_rng(seed)
    coords, quads = plate(lambda x, y: 0.3 * rng.normal(size=x.shape), n=5)
    surface = MeshSurface.from_faces(coords, quads, up=UP)
    points = rng.uniform(-1.3, 1.3, (6, 3))
    distance, gradient, found = surface.distance(points, points)
    feet = surface.point(found)
    corners = surface.vertices_coords[surface.triangles]
    for point, gap, slope, foot, place in zip(points, distance, gradient, feet, found, strict=True):
        tried = np.array([nearest_by_hand(point, triangle) for triangle in corners])
        gaps = np.linalg.norm(tried - point, axis=1)
        assert abs(gap) == pytest.approx(gaps.min(), abs=1e-12)
        assert np.linalg.norm(foot - point) == pytest.approx(gaps.min(), abs=1e-12)
        assert gaps[int(place[5])] == pytest.approx(gaps.min(), abs=1e-12)
        assert foot + gap * slope == pytest.approx(point, abs=1e-9)
    assert surface.frame.coordinates(feet)[:, :2] == pytest.approx(found[:, :2])


@settings(max_examples=25)
@given(seed=seeds)
def test_signs_are_right_at_sharp_edges_and_corners(seed):
    """A needle of a tetrahedron, wholly known by four half spaces."""
    rng = np.random.default_rng(seed)
    coords = rng.normal(size=(4, 3)) * [1, 1, 0.1]
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
    surface = MeshSurface.from_faces(coords, faces, up=UP)
    points = coords.mean(axis=0) + rng.normal(size=(200, 3)) * [2, 2, 0.3]
    weights = np.linalg.solve(
        np.vstack([coords.T, np.ones(4)]), np.vstack([points.T, np.ones(200)])
    )
    inner = (weights > 0).all(axis=0)
    assert ((surface.distance(points, points)[0] < 0) == inner).all()
    middle = coords.mean(axis=0)[None]
    assert surface.distance(middle, middle)[0] < 0


@settings(max_examples=25)
@given(seed=seeds)
def test_gradients_are_the_slopes_of_the_distance(seed):
    rng = np.random.default_rng(seed)
    surface = MeshSurface.from_faces(*plate(waves), up=UP)
    points = np.column_stack([rng.uniform(-1.2, 1.2, (40, 2)), rng.uniform(-0.4, 0.4, 40)])
    _, gradient, found = surface.distance(points, points)
    assert np.linalg.norm(gradient, axis=1) == pytest.approx(1.0)
    step = 1e-6 * rng.normal(size=(40, 3))
    ahead, behind = (surface.distance(points + s * step, points) for s in (1, -1))
    # where the nearest triangle changes the slope may jump: at hollow edges
    same = (ahead[2][:, 5] == found[:, 5]) & (behind[2][:, 5] == found[:, 5])
    assert same.mean() > 0.8
    slope = (ahead[0] - behind[0]) / 2
    assert slope[same] == pytest.approx(np.vecdot(gradient, step)[same], abs=1e-11)


@given(seed=seeds)
def test_a_plate_is_the_plane_far_beyond_its_rim(seed):
    rng = np.random.default_rng(seed)
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    coords, quads = plate(n=4)
    surface = MeshSurface.from_faces(coords @ turn.T, quads, up=turn[:, 2])
    uv = rng.uniform(-1.3, 1.3, (20, 2))
    places = surface.places(uv)
    height = rng.uniform(-0.05, 0.05, 20)
    points = surface.point(places) + height[:, None] * turn[:, 2]
    distance, gradient, found = surface.distance(points, places)
    assert distance == pytest.approx(height, abs=1e-14)
    assert gradient == pytest.approx(np.tile(turn[:, 2], (20, 1)), abs=1e-12)
    assert found[:, :2] == pytest.approx(uv, abs=1e-12)
    assert surface.normal(places) == pytest.approx(gradient, abs=1e-12)
    assert (surface.inside(places) == (np.abs(uv) <= 1).all(axis=1)).all()
    assert surface.point(places) @ turn[:, 2] == pytest.approx(0, abs=1e-14)


def test_the_distance_to_a_ball_converges_in_the_second_order():
    rng = np.random.default_rng(0)
    points = rng.normal(size=(500, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    height = rng.uniform(-0.3, 0.3, 500)
    errors = []
    for level in (2, 3, 4, 5):
        surface = MeshSurface.from_faces(*ball(level), up=UP)
        distance, gradient, _ = surface.distance((1 + height)[:, None] * points, points)
        errors.append(np.abs(distance - height).max())
        assert np.vecdot(gradient, points).min() > 0.9
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    assert ((rates > 1.85) & (rates < 2.15)).all()
    assert errors[-1] < 4e-4


def test_a_ball_is_seen_from_above_and_goes_on_below():
    coords, faces = ball(3)
    for turned in (faces, faces[:, ::-1]):  # wound inwards: still outward normals
        surface = MeshSurface.from_faces(coords, turned, up=UP, half_widths=(0.7, 0.7))
        places = surface.places(np.array([[0.0, 0.0], [0.9, -0.9]]))
        assert surface.point(places)[:, 2] == pytest.approx([1.0, 0.454], abs=0.01)
        assert surface.normal(places)[:, 2] == pytest.approx([1.0, 0.454], abs=0.02)
        assert surface.own == len(surface.triangles) == len(faces)
        below = np.array([[0.0, 0.0, -1.5]])
        distance, gradient, found = surface.distance(below, places[:1])
        assert distance == pytest.approx(0.5, abs=0.01)
        assert gradient[0, 2] < -0.99
        assert surface.point(found)[0, 2] == pytest.approx(-1, abs=0.01)


def test_of_several_sheets_the_upper_one_has_the_parameters():
    """A steep hill sheared until it hangs over, on a flat plate."""
    coords, quads = plate(lambda x, y: np.exp(-9 * (x**2 + y**2)), n=41)
    hanging = coords + np.outer(0.6 * coords[:, 2], [1, 0, 0])
    surface = MeshSurface.from_faces(hanging, quads, up=UP)
    assert (surface._normals[: surface.own] @ UP < -0.1).any()
    line = np.column_stack([np.linspace(-0.9, 0.9, 200), np.zeros(200)])
    places = surface.places(line)
    assert surface.point(places)[:, :2] == pytest.approx(
        line * surface.frame.half_widths[:2] + surface.frame.origin[:2]
    )
    # the upper side of the hill, to its furthest point, and then the plate
    middle = np.abs(hanging[:, 1]) < 1e-9
    x, z = hanging[middle][:, 0], hanging[middle][:, 2]
    tip = int(np.argmax(np.where(z > 0.1, x, -9)))
    height = surface.point(places)[:, 2]
    at = surface.point(places)[:, 0]
    over = at < x[tip]
    assert height[over] == pytest.approx(np.interp(at[over], x[: tip + 1], z[: tip + 1]), abs=1e-9)
    assert height[~over].max() < z[tip]
    coords, faces = ball(2)
    with pytest.raises(InvalidValue, match=r"upward normal at the rim .*cut it off"):
        MeshSurface.from_faces(coords, faces[(coords[faces][..., 2] > -0.8).any(axis=1)], up=UP)


def test_the_skirt_is_continuous_tangent_and_outside():
    surface = MeshSurface.from_faces(*plate(waves, n=21), up=UP)
    side = np.linspace(-1, 1, 101)
    rim = np.vstack(
        [np.column_stack(p) for e in (-1, 1) for p in ((side, side * 0 + e), (side * 0 + e, side))]
    )
    within, beyond = surface.places(rim * (1 - 1e-9)), surface.places(rim * (1 + 1e-8))
    assert np.abs(within[:, 2:5] - beyond[:, 2:5]).max() < 1e-7
    assert not surface.inside(beyond).any()
    assert (beyond[:, 5] >= surface.own).all()
    assert surface.inside(surface.places(rim * 0.9999)).all()
    # tangent: the height along v = 0 goes on with the slope it has at u = 1
    line = surface.point(surface.places(np.array([[0.99, 0.0], [1.0, 0.0], [1.3, 0.0]])))
    slopes = np.diff(line[:, 2]) / np.diff(line[:, 0])
    assert slopes[1] == pytest.approx(0.6 * np.cos(3.0), abs=0.03)
    assert slopes[1] == pytest.approx(slopes[0], abs=0.06)
    # the distance itself does not jump across the rim
    over = surface.normal(within) * 0.03
    inner = surface.distance(surface.point(within) + over, within)[0]
    outer = surface.distance(surface.point(beyond) + over, beyond)[0]
    assert np.abs(inner - outer).max() < 1e-7
    # and triangles of the skirt do not cross: seen from above all are counterclockwise
    assert (surface._normals @ UP > 0).all()


def test_a_ragged_dome_gets_a_skirt_without_gaps():
    surface = MeshSurface.from_faces(*dome())
    added = surface.triangles[surface.own :]
    assert len(added)
    uses = np.unique(
        np.sort(np.stack([surface.triangles, np.roll(surface.triangles, -1, axis=1)], -1), -1)
        .reshape(-1, 2)
        .tolist(),
        axis=0,
        return_counts=True,
    )[1]
    assert (uses == 1).sum() == len(added) // (2 * _RINGS)  # no rim is left but the skirt's own
    assert surface.frame.axes[2] == pytest.approx(UP, abs=1e-6)
    places = surface.places(np.array([[0.0, 0.0], [1.0, 1.0]]))
    assert surface.inside(places).tolist() == [True, False]
    assert surface.point(places)[0, 2] == pytest.approx(1.0, abs=0.01)


def test_holes_are_covered_but_not_inside():
    coords, quads = plate(n=11)
    hole = np.abs(coords[quads].mean(axis=1)[:, :2]).max(axis=1) < 0.3
    surface = MeshSurface.from_faces(coords, quads[~hole], up=UP)
    uv = np.array([[0.0, 0.05], [0.19, 0.19], [0.21, 0.21], [0.9, 0.0]])
    places = surface.places(uv)
    assert surface.inside(places).tolist() == [False, False, True, True]
    assert surface.point(places) == pytest.approx(np.pad(uv, ((0, 0), (0, 1))))
    corner = np.zeros(len(quads), bool)
    corner[[22, 23, 24, 32, 42]] = True  # an L of quads: seen from its mean, sides turn back
    with pytest.raises(InvalidValue, match=r"hole of 12 sides .* not star-shaped\. Fill it"):
        MeshSurface.from_faces(coords, quads[~corner], up=UP)


def test_points_that_are_no_numbers_stay_so():
    surface = MeshSurface.from_faces(*plate(), up=UP)
    points = np.array([[0.1, 0.1, 0.2], [np.nan, 0, 0], [0, np.inf, 0]])
    distance, gradient, found = surface.distance(points, points)
    assert distance[0] == pytest.approx(0.2)
    assert np.isnan(distance[1:]).all()
    assert np.isnan(gradient[1:]).all()
    assert np.isnan(found[1:]).all()


@pytest.mark.parametrize("ending", ["stl", "obj", "ply"])
def test_files_give_the_mesh_they_hold(tmp_path, ending):
    coords, quads = plate(waves)
    direct = MeshSurface.from_faces(coords, quads, up=UP)
    faces = np.vstack([quads[:, :3], quads[:, [2, 3, 0]]])
    trimesh.Trimesh(coords, faces, process=False).export(tmp_path / f"mesh.{ending}")
    surface = MeshSurface.read(tmp_path / f"mesh.{ending}", up=UP)
    assert surface.own == 2 * len(quads)
    points = np.random.default_rng(0).uniform(-0.8, 0.8, (50, 3)) * [1, 1, 0.3]
    difference = surface.distance(points, points)[0] - direct.distance(points, points)[0]
    if ending == "stl":  # which keeps the diagonals it is given, in single precision
        assert np.abs(difference).max() < 0.02
    else:
        assert np.abs(difference).max() < 1e-7


def test_quads_of_a_file_are_cut_along_the_shorter_diagonal(tmp_path):
    """The ridge of a roof is a diagonal of its quads, the long one for `first`."""
    text = "v 0 0 0\nv 2 0 0\nv 2.5 1 1\nv 0 1 0\nf {}\n"
    surfaces = []
    for first in ("1 2 3 4", "2 3 4 1", "4 3 2 1", "1/1/1 2/1/1 3/1/1 4/1/1"):
        (tmp_path / "roof.obj").write_text("vt 0 0\nvn 0 0 1\n" + text.format(first))
        surface = MeshSurface.read(tmp_path / "roof.obj", up=UP)
        pairs = {
            tuple(sorted(map(tuple, surface.vertices_coords[t].tolist())))
            for t in surface.triangles[: surface.own]
        }
        surfaces.append(pairs)
    ends = {(2.0, 0.0, 0.0), (0.0, 1.0, 0.0)}  # sqrt 5 apart, the others 2.9
    assert all(surface == surfaces[0] for surface in surfaces)
    assert all(ends < set(triangle) for triangle in surfaces[0])


def test_a_mixed_file_of_quads_and_triangles_is_read(tmp_path):
    text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nf 1 2 3 4\nf 2 5 3\n"
    (tmp_path / "mixed.obj").write_text(text)
    assert MeshSurface.read(tmp_path / "mixed.obj").own == 3


def test_what_can_be_repaired_is():
    coords, quads = plate(waves, n=6)
    clean = MeshSurface.from_faces(coords, quads, up=UP)
    triangles = clean.triangles[: clean.own]
    soup = coords[triangles].reshape(-1, 3) + 1e-12 * np.random.default_rng(0).normal(
        size=(3 * len(triangles), 3)
    )
    faces = np.arange(len(soup)).reshape(-1, 3)
    faces[::3] = faces[::3, ::-1]  # every third one wound against the others
    faces = np.vstack([faces, faces[:2], [[0, 0, 1]]])  # two of them twice, and a line
    soup = np.vstack([soup, [[5.0, 5.0, 5.0]]])  # a vertex of no face
    repaired = MeshSurface.from_faces(soup, faces, up=UP)
    assert repaired.own == clean.own
    assert len(repaired.vertices_coords) == len(clean.vertices_coords)
    points = np.random.default_rng(1).uniform(-1, 1, (50, 3))
    assert repaired.distance(points, points)[0] == pytest.approx(
        clean.distance(points, points)[0], abs=1e-10
    )


def test_a_face_without_area_between_others_leaves_no_gap():
    """A vertex in the middle of a side, closed by a triangle on the side."""
    coords = np.array([[0.0, 0, 0], [2, 0, 0], [1, 1, 0], [1, 0, 0], [1, -1, 0]])
    faces = np.array([[0, 1, 2], [0, 3, 1], [0, 4, 3], [3, 4, 1]])
    surface = MeshSurface.from_faces(coords, faces, up=UP)
    assert surface.own == 3
    points = np.array([[1.0, 0, 0.1], [0.5, 0, -0.1]])
    assert surface.distance(points, points)[0] == pytest.approx([0.1, -0.1])
    assert surface.inside(surface.places(np.zeros((1, 2)))).all()


def test_directions_can_be_given():
    coords, quads = plate(waves, width=0.5)
    long = MeshSurface.from_faces(coords, quads, up=UP)
    assert long.frame.axes[1] == pytest.approx([0, 1, 0])
    assert long.frame.half_widths[:2] == pytest.approx([1, 0.5])
    other = MeshSurface.from_faces(coords, quads, up=UP, rows=(-1, 0, 0))
    assert other.frame.axes[1] == pytest.approx([-1, 0, 0])
    assert other.frame.half_widths[:2] == pytest.approx([0.5, 1])
    under = MeshSurface.from_faces(coords, quads, up=(0, 0, -1))
    places = under.places(np.zeros((1, 2)))
    assert under.normal(places)[0, 2] < -0.5
    assert under.distance(np.array([[0.0, 0, -1]]), places)[0] > 0


def _moebius():
    turn = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    middle = np.column_stack([np.cos(turn), np.sin(turn), 0 * turn])
    across = middle * np.cos(turn / 2)[:, None] + np.outer(np.sin(turn / 2), UP)
    coords = np.vstack([middle - 0.2 * across, middle + 0.2 * across])
    i = np.arange(24)
    after = np.roll(i, -1)
    faces = np.column_stack([i, after, after + 24, i + 24])
    faces[-1] = [23, 24, 0, 47]
    return coords, faces


def _tube():
    mesh = trimesh.creation.cylinder(1.0, 3.0, sections=16)
    faces = np.array(mesh.faces)[np.abs(mesh.face_normals[:, 2]) < 0.5]
    return np.array(mesh.vertices), faces


COORDS, QUADS = plate(n=3)
TRIANGLE = np.array([[0, 1, 2]])


@pytest.mark.parametrize(
    ("coords", "faces", "match"),
    [
        (COORDS[:, :2], QUADS, "vertices_coords .*points"),
        (np.where(COORDS == 0, np.nan, COORDS), QUADS, "vertices_coords .*finite.*vertex"),
        (COORDS, QUADS.astype(float), "faces .*whole numbers"),
        (COORDS, np.arange(5)[None], "faces .*Cut larger"),
        (COORDS, QUADS[:0], "triangles = 0"),
        (COORDS, np.broadcast_to(TRIANGLE, (1_000_001, 3)), "triangles = 1000001 .*coarser"),
        (COORDS, QUADS + 7, "faces = 15 .*from 0 to 8"),
        (COORDS, QUADS - 1, "faces = -1 "),
        (COORDS * 1e-9, QUADS, "size of the mesh"),
        (COORDS * 1e9, QUADS, "size of the mesh"),
        (
            COORDS + 1e5,
            QUADS,
            r"from the origin = [0-9.]+ of its sizes .* at most 1000 of its sizes",
        ),
        (COORDS * [1, 0, 0], QUADS, "area of the mesh"),
        (COORDS[:1], np.zeros((1, 3), int), "size of the mesh"),
        (np.vstack([COORDS, COORDS + 5]), np.vstack([QUADS, QUADS + 9]), "pieces .* 8, 8"),
        (COORDS, QUADS[[0, 3]], "pieces of the mesh = 2"),
        (*_moebius(), "one side only"),
        (*_tube(), "up = None"),
        (*ball(1), "up = None .*It is closed"),
    ],
)
def test_meshes_that_cannot_be_followed_are_refused(coords, faces, match):
    with pytest.raises(InvalidValue, match=match):
        MeshSurface.from_faces(coords, faces)


def test_three_faces_at_an_edge_and_touching_corners_are_named():
    coords = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1]])
    with pytest.raises(InvalidValue, match=r"faces at an edge = 3 .*vertices \[0, 1\]"):
        MeshSurface.from_faces(coords, np.array([[0, 1, 2], [1, 0, 3], [0, 1, 4]]))
    # a ring of quads around the middle one, pinched at the corner of two of them
    coords, quads = plate(n=5)
    keep = np.setdiff1d(np.arange(16), [5, 10])
    with pytest.raises(InvalidValue, match=r"rims at a vertex = 2 .*vertex 12"):
        MeshSurface.from_faces(coords, quads[keep], up=UP)


def test_outlines_around_which_no_skirt_can_be_laid_are_refused():
    coords, quads = plate(n=9)
    middle = coords[quads].mean(axis=1)
    horseshoe = ~((np.abs(middle[:, 1]) < 0.6) & (middle[:, 0] > -0.6))
    with pytest.raises(InvalidValue, match=r"outer rim turns back .*rounder outline"):
        MeshSurface.from_faces(coords, quads[horseshoe], up=UP)
    with pytest.raises(InvalidValue, match=r"not star-shaped|outer rims"):
        MeshSurface.from_faces(*_tube(), up=(1, 0, 0))
    coords_of_ball, faces = ball(3)
    legs = coords_of_ball[faces].mean(axis=1) @ np.array([[0.8, 0, -0.6], [-0.8, 0, -0.6]]).T
    with pytest.raises(InvalidValue, match="outer rims = 2"):
        MeshSurface.from_faces(coords_of_ball, faces[(legs < 0.9).all(axis=1)], up=UP)
    with pytest.raises(InvalidValue, match="half_widths"):
        MeshSurface.from_faces(coords, quads, up=(0, 1, 0))
    with pytest.raises(InvalidValue, match="half_widths"):
        MeshSurface.from_faces(coords, quads, up=UP, half_widths=(1.0, 0.0))
    with pytest.raises(InvalidValue, match="rows"):
        MeshSurface.from_faces(coords, quads, up=UP, rows=UP)


def test_places_beyond_the_skirt_are_no_numbers():
    surface = MeshSurface.from_faces(*plate(waves), up=UP)
    uv = np.array([[0.0, 0.1], [9.0, 0.0]])
    places = surface.places(uv)
    assert (places[:, :2] == uv).all()
    assert np.isfinite(places[0]).all()
    assert np.isnan(surface.point(places)[1]).all()
    assert np.isnan(surface.normal(places)[1]).all()
    assert surface.inside(places).tolist() == [True, False]


@pytest.mark.parametrize(
    ("name", "content", "match"),
    [
        ("mesh.gltf", b"{}", "end in .glb, .obj, .off, .ply, .stl"),
        ("mesh.stl", None, "name a file"),
        ("mesh.stl", b"", "readable|at least one face"),
        ("mesh.stl", b"solid nonsense\nfacet\n", "readable|at least one face"),
        ("mesh.ply", b"no ply at all", "readable"),
        ("mesh.obj", b"hello\n", "readable|at least one face"),
        ("mesh.obj", b"v 0 0 0\nv 1 0 0\nv 1 1 0\n", "readable|at least one face"),
        ("mesh.obj", b"v 0 0 0\nv 1 0 0\nv 1 nan 0\nf 1 2 3\n", "finite"),
        ("mesh.obj", b"v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", "area of the mesh"),
        ("mesh.obj", b"v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 9\n", "readable|faces"),
    ],
)
def test_files_that_hold_no_mesh_are_refused(tmp_path, name, content, match):
    if content is not None:
        (tmp_path / name).write_bytes(content)
    with pytest.raises(InvalidValue, match=match):
        MeshSurface.read(tmp_path / name)


def test_a_sheet_grows_on_a_dome_and_lies_on_its_offsets():
    surface = MeshSurface.from_faces(*dome(5, floor=0.6))
    growth = fit_surface(surface, 20, zigzag=5.0, row_step=1.0)
    coords, faces = growth.mesh.vertices_coords, growth.mesh.faces_vertices
    assert growth.status is Status.GROWN
    assert growth.coverage > 0.99
    assert planarity(coords, faces).max() < 1e-13
    assert developability(coords, faces).max() < 1e-13
    distance = np.abs(surface.distance(coords, coords)[0])
    assert np.ptp(distance) < 1e-13
    assert distance[0] > 0.01
