"""Triangles as files have them, made clean: what is repaired, what is said, what is refused."""

import numpy as np
import pytest
import surface_meshes as made
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from fab.errors import InvalidFile, Severity
from fab.surfaces.clean_mesh import MOST_TRIANGLES, clean_mesh
from fab.surfaces.soup import with_area
from solver.targets.decimation import decimated
from solver.targets.refinement import refined
from solver.targets.surface_mesh import MeshKind, SurfaceMesh
from solver.targets.triangles import TriangleTree, least_heights

seeds = st.integers(0, 2**32 - 1)


def ball(level=2):
    mesh = trimesh.creation.icosphere(subdivisions=level)
    return np.array(mesh.vertices), np.array(mesh.faces)


def plate(n=12):
    return made.grid(lambda u, v: (u, v, 0.2 * u * v), n, n)


SURFACES = {
    "cap": (made.cap(1.4), MeshKind.DISC),
    "vase": (made.vase(), MeshKind.RING),
    "holes": (made.dome_with_holes(), MeshKind.DISC_WITH_HOLES),
    "ball": (ball(), MeshKind.SPHERE),
    "torus": (made.torus(), MeshKind.TORUS),
    "moebius": (made.moebius(), MeshKind.MOEBIUS),
}


def as_stl(arrays):
    """Every triangle with corners of its own."""
    coords, faces = arrays
    return coords[faces].reshape(-1, 3), np.arange(faces.size).reshape(-1, 3)


def codes(clean):
    return [finding.code for finding in clean.findings]


def text_of(clean, code):
    (finding,) = [f for f in clean.findings if f.code == code]
    return finding.text


def volume(mesh):
    first = mesh.vertices_coords[mesh.faces_vertices[:, 0]]
    return float((first * mesh.doubled_areas).sum() / 6)


@pytest.mark.parametrize("name", SURFACES)
def test_a_sound_mesh_stays_as_it_is(name):
    arrays, kind = SURFACES[name]
    clean = clean_mesh(as_stl(arrays))
    assert clean.mesh.kind is kind
    assert codes(clean) == (["mesh-one-sided"] if kind is MeshKind.MOEBIUS else [])
    areas = np.linalg.norm(made.mesh_of(arrays).doubled_areas, axis=1) / 2
    assert clean.mesh.area == pytest.approx(areas.sum())


@pytest.mark.parametrize("name", SURFACES)
@settings(max_examples=5)
@given(seed=seeds, scale=st.sampled_from([1e-9, 1.0, 1e6]))
def test_shuffled_turned_and_doubled_triangles_give_the_same_surface(name, seed, scale):
    (coords, faces), kind = SURFACES[name]
    rng = np.random.default_rng(seed)
    soup, numbers = as_stl((scale * coords, faces))
    soup = soup + 1e-8 * scale * rng.normal(size=soup.shape)
    turned = rng.random(len(numbers)) < 0.4
    numbers = np.where(turned[:, None], numbers[:, ::-1], numbers)
    numbers = np.concatenate([numbers, numbers[:5, [1, 0, 2]]])[rng.permutation(len(numbers) + 5)]
    before = soup.copy(), numbers.copy()
    clean = clean_mesh((soup, numbers))
    assert np.array_equal(soup, before[0])
    assert np.array_equal(numbers, before[1])
    assert clean.mesh.kind is kind
    assert clean.mesh.area == pytest.approx(scale**2 * made.mesh_of((coords, faces)).area, rel=1e-5)
    assert "mesh-vertices-merged" in codes(clean)
    assert text_of(clean, "mesh-faces-repeated").startswith("5 triangles were there twice")
    if kind is not MeshKind.MOEBIUS:
        assert "mesh-windings" in codes(clean)
    if kind in (MeshKind.SPHERE, MeshKind.TORUS):
        assert volume(clean.mesh) > 0


def test_the_largest_of_several_pieces_is_kept_and_the_share_stated():
    coords, faces = plate()
    other, more = ball(1)
    soup = np.concatenate([coords, 0.1 * other + 5]), np.concatenate([faces, more + len(coords)])
    clean = clean_mesh(soup)
    assert clean.mesh.kind is MeshKind.DISC
    assert clean.mesh.vertices_coords.max() < 2
    text = text_of(clean, "mesh-pieces")
    area = made.mesh_of((coords, faces)).area
    share = area / (area + 0.01 * made.mesh_of((other, more)).area)
    assert f"{100 * share:.3g} %" in text
    assert text.startswith("2 pieces")
    assert "(5, 5, 5)" in text


def test_a_fin_on_a_surface_comes_off():
    coords, faces = plate()
    across = np.flatnonzero(np.abs(coords[:, 0]) < 1e-9)
    across = across[np.argsort(coords[across, 1])]
    top = len(coords) + np.arange(len(across))
    fin = np.concatenate(
        [
            np.column_stack([across[:-1], across[1:], top[1:]]),
            np.column_stack([across[:-1], top[1:], top[:-1]]),
        ]
    )
    soup = np.concatenate([coords, coords[across] + [0, 0, 0.5]]), np.concatenate([fin, faces])
    clean = clean_mesh(soup)
    assert clean.mesh.kind is MeshKind.DISC
    assert clean.mesh.area == pytest.approx(made.mesh_of((coords, faces)).area)
    assert "12 edges had more than two triangles, up to 3" in text_of(clean, "mesh-branches")
    assert "mesh-pieces" in codes(clean)


def test_sheets_that_cross_along_edges_come_apart():
    flat = made.grid(lambda u, v: (u, v, 0 * u), 8, 8)
    upright = made.grid(lambda u, v: (0 * u, v, 0.9 * u), 8, 8)
    soup = (
        np.concatenate([flat[0], upright[0]]),
        np.concatenate([flat[1], upright[1] + len(flat[0])]),
    )
    clean = clean_mesh(soup)
    assert clean.mesh.kind is MeshKind.DISC
    assert np.abs(clean.mesh.vertices_coords[:, 2]).max() == 0
    assert clean.mesh.area == pytest.approx(4)


def test_cones_that_touch_at_their_tips_come_apart():
    coords, faces = made.disc(lambda x, y: (x, y, np.hypot(x, y)), 4, 24)
    soup = (
        np.concatenate([coords, -coords[:, [1, 0, 2]] * [1, 1, 0.5]]),
        np.concatenate([faces, faces + len(coords)]),
    )
    clean = clean_mesh(soup)
    assert clean.mesh.kind is MeshKind.DISC
    assert clean.mesh.vertices_coords[:, 2].min() == 0
    assert "1 vertex alone, the first at (0, 0, 0)" in text_of(clean, "mesh-parts-touch")


def test_small_holes_are_filled_and_large_ones_kept():
    coords, faces = made.dome_with_holes()
    middle = coords[faces].mean(axis=1)
    gone = np.zeros(len(faces), bool)
    for x, y in ((0.725, -0.725), (-0.725, -0.725)):
        gone[np.argsort(np.hypot(middle[:, 0] - x, middle[:, 1] - y))[:2]] = True
    clean = clean_mesh(made.packed(coords, faces[~gone]))
    assert clean.mesh.kind is MeshKind.DISC_WITH_HOLES
    assert len(clean.mesh.boundary_loops) == 4
    assert clean.mesh.area == pytest.approx(made.mesh_of((coords, faces)).area, rel=1e-3)
    bound = 0.16 * np.sqrt(made.mesh_of(made.packed(coords, faces[~gone])).area)
    assert "2 holes filled" in text_of(clean, "mesh-holes-filled")
    assert f"rims up to {bound:.3g} are" in text_of(clean, "mesh-holes-filled")


def test_a_bent_hole_is_filled_without_folds():
    coords, faces = made.grid(lambda u, v: (u, v, 0 * u), 200, 200)
    middle = coords[faces].mean(axis=1)
    radius = np.hypot(middle[:, 0], middle[:, 1])
    around = (np.abs(radius - 0.03) < 0.007) & (middle[:, 0] < 0.01)
    clean = clean_mesh(made.packed(coords, faces[~around]))
    assert clean.mesh.kind is MeshKind.DISC
    assert clean.mesh.area == pytest.approx(4, abs=1e-12)  # folds would have more
    assert (clean.mesh.doubled_areas[:, 2] > 0).all()


def test_a_closed_body_with_a_small_hole_is_closed():
    coords, faces = ball(3)
    clean = clean_mesh((coords, faces[1:]))
    assert clean.mesh.kind is MeshKind.SPHERE
    assert codes(clean) == ["mesh-holes-filled"]


def test_closed_bodies_that_are_inside_out_are_turned():
    coords, faces = ball()
    clean = clean_mesh((coords + 7, faces[:, ::-1]))
    assert codes(clean) == ["mesh-inside-out"]
    assert volume(clean.mesh) == pytest.approx(4.047, abs=0.01)


@pytest.mark.parametrize("rim", [False, True])
def test_flat_triangles_leave_no_gaps(rim):
    """Edges with corners in their middle, which STL files have where two flat faces meet."""
    coords, faces = plate(6)
    mesh = made.mesh_of((coords, faces))
    edges = np.flatnonzero(mesh.rim_edges if rim else ~mesh.rim_edges)[::7]
    faces = faces.tolist()
    points = coords.tolist()
    for edge in edges:
        half = mesh.edges_halves[edge, 0]
        corner = np.roll(mesh.faces_vertices[half // 3], -(half % 3)).tolist()
        middle = len(points)
        points.append(mesh.vertices_coords[mesh.edges_vertices[edge]].mean(axis=0).tolist())
        place = faces.index(mesh.faces_vertices[half // 3].tolist())
        faces[place] = [corner[0], middle, corner[2]]
        faces += [[middle, corner[1], corner[2]], [corner[0], corner[1], middle]]
    soup = np.array(points), np.array(faces)
    clean = clean_mesh(soup)
    assert clean.mesh.kind is MeshKind.DISC
    assert clean.mesh.area == pytest.approx(mesh.area)
    assert f"{len(edges)} triangle" in text_of(clean, "mesh-faces-without-area")
    assert least_heights(clean.mesh.vertices_coords, clean.mesh.faces_vertices).min() > 1e-3


def test_flat_triangles_on_one_another_end():
    line = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0], [0, 1, 0]])
    faces = np.array([[0, 1, 3], [0, 3, 2], [0, 1, 2], [0, 3, 4]])
    soup, findings = with_area((line, faces))
    assert least_heights(*soup).min() > 0.1
    assert [f.code for f in findings] == ["mesh-faces-without-area"]


def test_a_surface_that_passes_through_itself_is_reported():
    def tunnel(u, v):
        angle = 1.2 * np.pi * u
        return np.sin(angle) * (1 + 0.0 * v) + 0.5 * u, v, np.cos(angle) + 0.3 * u * u

    clean = clean_mesh(made.grid(tunnel, 40, 6))
    crossing = [f for f in clean.findings if f.code == "mesh-crosses-itself"]
    loop = made.mesh_of(made.grid(tunnel, 40, 6))
    x = loop.vertices_coords[:, 0]
    assert x.max() > 1  # it does bend back
    assert len(crossing) == 1
    assert crossing[0].severity is Severity.WARNING


@pytest.mark.parametrize(
    ("soup", "says"),
    [
        ((np.zeros((0, 3)), np.zeros((0, 3), int)), "no triangles"),
        ((np.eye(3), np.array([[0, 1, 3]])), "names vertex 3; there are 3 vertices"),
        ((np.array([[0.0, 0, 0], [np.nan, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]])), "not finite"),
        ((np.array([[0.0, 0, 0], [np.inf, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]])), "not finite"),
        ((np.ones((3, 3)), np.array([[0, 1, 2]])), "in one place"),
        ((np.arange(9.0).reshape(3, 3), np.array([[0, 1, 2]])), "none of its triangles"),
    ],
)
def test_what_is_no_surface_is_refused(soup, says):
    with pytest.raises(InvalidFile, match=says):
        clean_mesh(soup)


def test_vertices_that_no_face_uses_may_be_anything():
    coords, faces = plate()
    clean = clean_mesh((np.concatenate([coords, [[np.nan] * 3]]), faces))
    assert clean.findings == ()


def test_large_meshes_are_decimated_to_what_is_stated():
    coords, faces = made.torus(400, 150)
    clean = clean_mesh((coords, faces))
    assert clean.mesh.kind is MeshKind.TORUS
    assert len(faces) > MOST_TRIANGLES >= len(clean.mesh.faces_vertices) > 0.99 * MOST_TRIANGLES
    assert text_of(clean, "mesh-decimated").startswith("120000 triangles decimated to 100000")


@pytest.mark.parametrize("name", ["cap", "vase", "holes", "ball", "torus"])
def test_decimation_keeps_kind_and_converges(name):
    mesh = made.mesh_of(SURFACES[name][0])
    count = len(mesh.faces_vertices)
    gaps = []
    for most in (count // 2, count // 8):
        few = decimated(mesh, most)
        assert few.mesh.kind is mesh.kind
        assert most - 2 <= len(few.mesh.faces_vertices) <= most
        gaps.append(few.distances.max())
    assert gaps[0] < gaps[1] < 0.2


@pytest.mark.parametrize("name", SURFACES)
def test_refinement_keeps_the_surface(name):
    mesh = made.mesh_of(SURFACES[name][0])
    fine = refined(mesh, 0.05, 10**6)
    ends = fine.vertices_coords[fine.edges_vertices]
    assert np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1).max() < 0.1
    assert fine.kind is mesh.kind
    assert fine.area == pytest.approx(mesh.area)
    tree = TriangleTree.of(mesh.vertices_coords, mesh.faces_vertices)
    assert tree.nearest(fine.vertices_coords)[0].max() < 1e-12
    assert len(refined(mesh, 0.05, len(mesh.faces_vertices) + 3).faces_vertices) == len(
        mesh.faces_vertices
    )


def test_strips_as_long_as_a_cylinder_get_vertices_in_between():
    coords, faces = made.grid(
        lambda u, v: (np.cos(u), np.sin(u), 4 * v), 80, 1, u=(0, 2 * np.pi), around=(True, False)
    )
    fine = clean_mesh((coords, faces)).mesh
    assert fine.kind is MeshKind.RING
    assert len(fine.faces_vertices) < 2 * 80 * 64
    assert len(np.unique(fine.vertices_coords[:, 2].round(9))) > 20


@settings(max_examples=60)
@given(seed=seeds)
def test_any_soup_gives_a_surface_or_a_refusal(seed):
    rng = np.random.default_rng(seed)
    count = int(rng.integers(3, 12))
    coords = np.round(rng.normal(size=(count, 3)) * rng.integers(1, 3, 3), int(rng.integers(0, 3)))
    faces = rng.integers(0, count, (int(rng.integers(1, 60)), 3))
    try:
        clean = clean_mesh((coords, faces))
    except InvalidFile:
        return
    mesh = clean.mesh
    SurfaceMesh.of(mesh.vertices_coords, mesh.faces_vertices)
    assert least_heights(mesh.vertices_coords, mesh.faces_vertices).min() > 0
    a, b, c = (coords[faces[:, k]] for k in range(3))
    whole = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
    assert "mesh-holes-filled" in codes(clean) or mesh.area <= whole * (1 + 1e-9)
    assert mesh.kind is not MeshKind.SPHERE or volume(mesh) > -1e-12


def test_noise_that_turns_triangles_over_is_distinguished_from_crossings():
    coords, faces = made.grid(lambda u, v: (u, v, 0.3 * u * v), 50, 50)
    noisy = coords + 0.03 * np.random.default_rng(0).normal(size=coords.shape)
    assert codes(clean_mesh((noisy, faces))) == ["mesh-neighbours-cross"]


def test_wide_faces_beside_needles_do_not_multiply():
    """A box with a rounded rim, as CAD programs have it."""
    angle = np.linspace(0, np.pi / 2, 20)
    rim = np.concatenate([[[-10, 0.1]], np.column_stack([np.sin(angle), np.cos(angle)]) * 0.1])
    coords = np.array([[x, y, z] for x, z in rim for y in (-10.0, 10.0)])
    n = len(rim)
    faces = np.array(
        [
            f
            for k in range(n - 1)
            for f in ((2 * k, 2 * k + 1, 2 * k + 3), (2 * k, 2 * k + 3, 2 * k + 2))
        ]
    )
    fine = clean_mesh((coords, faces)).mesh
    ends = fine.vertices_coords[fine.edges_vertices]
    assert np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1).max() < 1.5 * fine.size / 32
    needles, wide = 38 * 2 * 32, 2 * 32**2
    assert len(fine.faces_vertices) < needles + wide


@pytest.mark.parametrize(("sizes", "moved"), [(90.0, False), (1e6, True)])
def test_a_surface_far_from_the_origin_is_moved_there_by_what_is_stated(sizes, moved):
    coords, faces = plate()
    size = np.linalg.norm(np.ptp(coords, axis=0))
    shift = sizes * size * np.array([0.6, 0.0, -0.8])
    clean = clean_mesh((coords + shift, faces))
    assert ("mesh-moved" in [finding.code for finding in clean.findings]) == moved
    expected = coords if moved else coords + shift
    box = [(c.min(axis=0), c.max(axis=0)) for c in (clean.mesh.vertices_coords, expected)]
    np.testing.assert_allclose(*box, rtol=0, atol=1e-14 * sizes)
    if moved:
        stated = ", ".join(f"{x:.12g}" for x in shift)
        assert f"is about ({stated}), 1000000 times its size" in text_of(clean, "mesh-moved")
