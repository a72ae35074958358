"""Crossing faces of folded sheets: exact brute force, counted crossings, contacts that are none."""

from fractions import Fraction
from itertools import combinations, pairwise

import numpy as np
import pytest
from helpers import GRIDS, published
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from solver import QuadMesh
from solver.self_intersection import crossing_faces
from solver.transfer import coupling
from solver.vectors import angle_between, full_turn, unit
from solver.vertex import growth_direction, locked_flap_angles, self_intersects

# Outlines in units of two directions: convex, reflex, notched, needle.
OUTLINES = [
    [(0, 0), (2, 0), (0, 2)],
    [(0, 0), (2, 0), (2, 1), (0, 1)],
    [(0, 0), (3, 0), (1, 1), (0, 3)],
    [(0, 0), (2, 2), (0, 1), (-2, 2)],
    [(0, 0), (4, 0), (4, 1), (3, 1), (3, 3), (1, 3), (1, 1), (0, 1)],
    [(0, 0), (3, 0), (3, 2), (2, 2), (2, 1), (1, 1), (1, 2), (0, 2)],
    [(0, 0), (9, 0), (9, 1)],
]

UP = np.array([0.0, 0.0, 1.0])

turns = st.integers(0, 2**32 - 1).map(lambda seed: Rotation.random(rng=seed).as_matrix())


def csr(faces):
    """Faces of any size as FOLD-named arrays."""
    offsets = np.concatenate([[0], np.cumsum([len(face) for face in faces])])
    return np.concatenate([np.asarray(face, np.int64) for face in faces]), offsets


def crossings_of(polygons):
    """Crossing pairs of polygons that are each given by their corners."""
    coords = np.concatenate([np.asarray(polygon, float) for polygon in polygons])
    _, offsets = csr(polygons)
    return {
        tuple(pair) for pair in crossing_faces(coords, np.arange(len(coords)), offsets).tolist()
    }


def sheet_crossings(rows):
    """Crossing pairs of a patch, shape (R, C, 3)."""
    mesh = QuadMesh.from_rows(np.asarray(rows, float))
    return crossing_faces(mesh.vertices_coords, *csr(mesh.faces_vertices))


def minus(p, q):
    return tuple(a - b for a, b in zip(p, q, strict=True))


def inner(p, q):
    return sum(a * b for a, b in zip(p, q, strict=True))


def product(p, q):
    return tuple(p[i - 2] * q[i - 1] - p[i - 1] * q[i - 2] for i in range(3))


def normal_of(polygon):
    sides = [minus(p, polygon[0]) for p in polygon]
    parts = [product(p, q) for p, q in pairwise(sides)]
    return tuple(map(sum, zip(*parts, strict=True)))


def strictly_inside(point, polygon, normal):
    """Whether a point of its plane lies inside a polygon and not on its outline, exactly."""
    drop = max(range(3), key=lambda i: abs(normal[i]))
    x, y = (i for i in range(3) if i != drop)
    odd = False
    for p, q in zip(polygon, polygon[1:] + polygon[:1], strict=True):
        turn = (q[x] - p[x]) * (point[y] - p[y]) - (q[y] - p[y]) * (point[x] - p[x])
        if turn == 0 and inner(minus(point, p), minus(point, q)) <= 0:
            return False
        if (p[y] > point[y]) != (q[y] > point[y]):
            odd ^= (turn > 0) == (q[y] > p[y])
    return odd


def cross_exactly(first, second):
    """Rational arithmetic: does any point between two cuts of the common line lie inside both?"""
    planes = [(normal_of(p), p[0]) for p in (first, second)]
    line = product(planes[0][0], planes[1][0])
    if not any(line):
        return False
    cuts = set()
    for polygon, (normal, foot) in ((first, planes[1]), (second, planes[0])):
        for p, q in zip(polygon, polygon[1:] + polygon[:1], strict=True):
            hp, hq = inner(minus(p, foot), normal), inner(minus(q, foot), normal)
            if hp == 0:
                cuts.add((inner(p, line), *map(Fraction, p)))
            if hp * hq < 0:
                share = Fraction(hp, hp - hq)
                point = tuple(a + share * (b - a) for a, b in zip(p, q, strict=True))
                cuts.add((inner(point, line), *point))
    ordered = [cut[1:] for cut in sorted(cuts)]
    middles = [tuple((a + b) / 2 for a, b in zip(p, q, strict=True)) for p, q in pairwise(ordered)]
    return any(
        strictly_inside(point, first, planes[0][0]) and strictly_inside(point, second, planes[1][0])
        for point in middles
    )


@st.composite
def polygons(draw):
    """A plane polygon with integer corners, so small that many touch each other."""
    small = st.integers(-2, 2)
    u, v = (draw(st.tuples(small, small, small)) for _ in range(2))
    if not any(product(u, v)):
        u, v = (1, 0, 0), (0, 1, draw(small))
    start = draw(st.tuples(small, small, small))
    outline = draw(st.sampled_from(OUTLINES))
    return [
        tuple(s + i * a + j * b for s, a, b in zip(start, u, v, strict=True)) for i, j in outline
    ]


def test_the_exact_judge_distinguishes_crossing_from_touching():
    square = [(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0)]
    assert cross_exactly(square, [(1, 1, -1), (1, 1, 1), (1, 5, 0)])
    assert not cross_exactly(square, [(1, 1, 0), (1, 1, 1), (1, 5, 1)])  # stands on it
    assert not cross_exactly(square, [(2, 0, -1), (2, 0, 1), (2, 5, 0)])  # along its side
    assert not cross_exactly(square, [(0, 0, 0), (1, 0, 0), (0, 1, 0)])  # lies on it


@settings(max_examples=400)
@given(st.lists(polygons(), min_size=2, max_size=5), turns, st.sampled_from([1e-3, 1.0, 1e4]))
def test_crossings_agree_with_rational_arithmetic_however_the_model_is_turned(faces, turn, scale):
    expected = {
        (i, j)
        for (i, first), (j, second) in combinations(enumerate(faces), 2)
        if cross_exactly(first, second)
    }
    assert crossings_of(faces) == expected
    moved = [scale * (np.asarray(face, float) @ turn.T + [7.0, -5.0, 3.0]) for face in faces]
    assert crossings_of(moved) == expected


def test_random_pairs_cross_and_touch_as_rational_arithmetic_says():
    rng = np.random.default_rng(0)
    crossed = touched = 0
    for _ in range(1500):
        first, second = (
            [
                tuple((start + i * u + j * v).tolist())
                for i, j in OUTLINES[rng.integers(len(OUTLINES))]
            ]
            for start, u, v in rng.integers(-2, 3, (2, 3, 3))
        )
        if any(normal_of(first)) and any(normal_of(second)):
            expected = cross_exactly(first, second)
            assert crossings_of([first, second]) == ({(0, 1)} if expected else set())
            crossed += expected
            touched += bool(set(first) & set(second)) and not expected
    assert crossed > 50
    assert touched > 15  # by a shared corner; more of them touch elsewhere


@pytest.mark.parametrize("seed", range(4))
def test_a_degree_4_vertex_crosses_where_its_flap_angle_lies_in_the_crossing_interval(seed):
    rng = np.random.default_rng(seed)
    a, b, c = unit(rng.normal(size=(3, 1000, 3)))
    beta, k = angle_between(a, b), 2 * np.pi - angle_between(b, c) - angle_between(a, c)
    room = (k > beta + 0.02) & (k < 2 * np.pi - beta - 0.02) & (np.abs(np.cos(beta)) < 0.9998)
    a, b, c, beta, k = a[room], b[room], c[room], beta[room], k[room]
    left, right = locked_flap_angles(a, b, c, coupling(beta, k))
    # half of the flap angles anywhere, half from 1e-6 to 0.1 rad beside an end of an interval
    ends = np.stack([left, right, np.zeros(len(a)), np.full(len(a), np.pi)])
    beside = ends[rng.integers(0, 4, len(a)), np.arange(len(a))]
    beside += rng.choice([-1, 1], len(a)) * 10.0 ** rng.uniform(-6, -1, len(a))
    flap = full_turn(np.where(rng.random(len(a)) < 0.5, beside, rng.uniform(0, 2 * np.pi, len(a))))
    clear = (np.abs((flap - ends + np.pi) % (2 * np.pi) - np.pi) > 1e-6).all(axis=0)
    expected = self_intersects(flap, left, right)
    grown = growth_direction(a, b, flap, k)
    faces = csr([[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]])
    for i in np.flatnonzero(clear):
        found = crossing_faces(np.stack([0 * a[i], a[i], c[i], b[i], grown[i]]), *faces)
        assert (len(found) > 0) == expected[i]
        assert set(map(tuple, found.tolist())) <= {(0, 2), (1, 3)}  # never across a crease
    assert 300 < expected[clear].sum() < 700


def grid(columns, rows):
    """A flat sheet of unit squares in z = 0, shape (rows + 1, columns + 1, 3)."""
    x, y = np.meshgrid(np.arange(columns + 1.0), np.arange(rows + 1.0))
    return np.stack([x, y, 0 * x], axis=-1)


def quads(*patches):
    """Faces of several patches, one after another, each by its corners."""
    meshes = [QuadMesh.from_rows(patch) for patch in patches]
    return np.concatenate([mesh.vertices_coords[mesh.faces_vertices] for mesh in meshes])


@given(turns)
def test_a_sheet_pushed_through_another_crosses_it_along_one_line(turn):
    upright = grid(3, 3)[..., [2, 0, 1]] + [2.3, 0.4, -1.5]  # y from 0.4 to 3.4, x = 2.3
    found = crossings_of(quads(grid(5, 4), upright) @ turn.T)
    # faces of column 2 against the middle row, wherever their spans of y have length in common
    assert found == {(5 * row + 2, 20 + 3 + i) for i in range(3) for row in (i, i + 1)}


@pytest.mark.parametrize(("points", "step"), [(5, 2), (7, 2), (7, 3), (11, 5)])
def test_a_strip_wound_into_a_star_crosses_itself_where_the_star_does(points, step):
    angle = 2 * np.pi * step / points * np.arange(points + 1)
    outline = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=-1)
    found = sheet_crossings(np.stack([outline, outline + UP]))
    assert len(found) == points * (step - 1)


def test_a_wound_strip_that_keeps_clear_of_itself_does_not_cross():
    angle = np.linspace(0, 8 * np.pi, 200)
    spiral = np.stack([angle * np.cos(angle), angle * np.sin(angle), 0 * angle], axis=-1)
    assert len(sheet_crossings(np.stack([spiral, spiral + UP]))) == 0


def miura(columns, rows, fold, sector=np.pi / 3):
    """The Miura sheet in closed form (Schenk and Guest, PNAS 2013, equations 1 to 4)."""
    root = np.sqrt(1 + (np.cos(fold) * np.tan(sector)) ** 2)
    i, j = np.meshgrid(np.arange(columns + 1), np.arange(rows + 1))
    x = i * np.cos(fold) * np.tan(sector) / root
    y = j * np.sqrt(1 - (np.sin(fold) * np.sin(sector)) ** 2) + i % 2 / root
    return np.stack([x, y, j % 2 * np.sin(fold) * np.sin(sector)], axis=-1)


@given(
    st.floats(0.0, np.pi / 2) | st.floats(-9, -1).map(lambda e: np.pi / 2 - 10**e),
    st.floats(0.2, 1.5),
    turns,
)
def test_a_miura_sheet_crosses_itself_at_no_fold(fold, sector, turn):
    assert len(sheet_crossings(miura(5, 6, fold, sector) @ turn.T)) == 0


@given(turns, st.floats(-14, -11))
def test_layers_of_a_flat_folded_sheet_in_contact_do_not_cross(turn, noise):
    flat = miura(6, 5, np.pi / 2)
    wing = flat[-1:] + np.array([2.0, 0.3, 0.0])  # one more row, that stands off the stack
    rows = np.concatenate([flat, wing]) @ turn.T
    rows += 10**noise * np.random.default_rng(0).normal(size=rows.shape)
    assert len(sheet_crossings(rows)) == 0


@pytest.mark.parametrize("width", [1e-2, 1e-4, 1e-6, 1e-8])
@pytest.mark.parametrize("noise", [0.0, 1e-14, 1e-12])
def test_needles_that_lie_on_one_another_do_not_cross(width, noise):
    rng = np.random.default_rng(0)
    angle, middle = rng.random((100, 1)) * np.pi, rng.random((100, 2))
    along = np.hstack([np.cos(angle), np.sin(angle)])
    across = width * np.hstack([-np.sin(angle), np.cos(angle)])
    flat = middle[:, None] + np.stack([-along, along, along + across, across - along], axis=1)
    needles = np.concatenate([flat, np.zeros((100, 4, 1))], axis=2)
    needles += noise * rng.normal(size=needles.shape)
    wing = np.array([[5.0, 5, 5], [6, 5, 5], [6, 6, 7], [5, 6, 7]])
    turned = np.concatenate([needles, wing[None]]) @ Rotation.random(rng=1).as_matrix()
    assert crossings_of(turned) == set()


def test_needles_that_pierce_one_another_cross():
    lying = [(-1, -1e-4, 0), (1, -1e-4, 0), (1, 1e-4, 0), (-1, 1e-4, 0)]
    upright = [(0.3, -1, -1e-4), (0.3, 1, -1e-4), (0.3, 1, 1e-4), (0.3, -1, 1e-4)]
    assert crossings_of([lying, upright]) == {(0, 1)}


@pytest.mark.parametrize(("depth", "count"), [(1e-11, 0), (1e-8, 2), (1e-3, 2), (-1e-3, 0)])
def test_a_roof_that_stands_on_a_sheet_crosses_it_once_it_dips_in_by_more_than_rounding(
    depth, count
):
    side = [[0.5, 0.2, -depth], [2.5, 0.2, -depth], [2.5, 0.2, 1.0], [0.5, 0.2, 1.0]]
    floor = [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [3.0, 2.0, 0.0], [0.0, 2.0, 0.0]]
    other = [[x, y + 1.0, z] for x, y, z in side]
    assert len(crossings_of([floor, side, other])) == count


@given(st.integers(0, 2**32 - 1), st.floats(0.0, 0.3))
def test_a_bumpy_sheet_over_the_plane_never_crosses_itself(seed, height):
    rows = grid(6, 5)
    rows[..., 2] = height * np.random.default_rng(seed).normal(size=rows.shape[:2])  # bent faces
    assert len(sheet_crossings(rows)) == 0


def test_pairs_are_sorted_and_the_same_for_any_order_of_faces():
    rng = np.random.default_rng(4)
    triangles = rng.normal(size=(200, 3, 3))
    expected = crossings_of(triangles)
    order = rng.permutation(200)
    place = np.argsort(order)
    found = crossing_faces(triangles[order].reshape(-1, 3), *csr(np.arange(600).reshape(200, 3)))
    assert len(expected) > 1000
    assert (found[:, 0] < found[:, 1]).all()
    assert found.tolist() == sorted(found.tolist())
    assert {tuple(sorted(place[list(pair)])) for pair in expected} == set(
        map(tuple, found.tolist())
    )


def test_looking_up_few_faces_at_a_time_changes_nothing(monkeypatch):
    triangles = np.random.default_rng(5).normal(size=(100, 3, 3))
    expected = crossings_of(triangles)
    monkeypatch.setattr("solver.self_intersection._FACES_AT_ONCE", 7)
    assert len(expected) > 200
    assert crossings_of(triangles) == expected


def test_a_face_without_area_crosses_nothing():
    assert (
        crossings_of([[(0, 0, 0), (2, 0, 0), (0, 2, 0)], [(1, 1, -1), (0, 0, 0), (-1, -1, 1)]])
        == set()
    )


@pytest.mark.parametrize("name", GRIDS)
def test_published_models_cross_themselves_only_in_the_random_ribbon(name):
    found = sheet_crossings(published(name, "fold")).tolist()
    ribbon = [[16, 19], [114, 163], [115, 163], [122, 143], [180, 197]]
    assert found == (ribbon if name == "F4F" else [])
