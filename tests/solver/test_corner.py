"""Growth around a concave corner: exactness, a known sheet regrown, and what is refused."""

import json
import re
from dataclasses import replace
from itertools import combinations, pairwise

import numpy as np
import pytest
import shapely
from helpers import TEMPLATES
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from fab.jobs.job import load_job
from fab.jobs.job_files import make
from fab.pattern.crease_pattern import crease_pattern
from fab.pattern.development import develop
from fab.pattern.inspection import measure_pattern
from fab.pattern.overlap import overlapping_faces
from solver import (
    CorneredMiura,
    CornerStrip,
    Crumpled,
    Front,
    InvalidValue,
    Miura,
    QuadMesh,
    RandomTube,
    Side,
    Status,
    Stop,
    Strip,
    developability,
    grow,
    grow_corner,
    grow_part,
    grow_pentagon,
    planarity,
    seeds,
)
from solver.measure import sector_angles
from solver.vectors import angle_between, norm
from solver.vertex import flap_angle_of

seeds_of_randomness = st.integers(0, 2**32 - 1)


def accuracy(mesh: QuadMesh):
    """Planarity, developability, isometry, of faces of any size."""
    return measure_pattern(crease_pattern(mesh, develop(mesh), 1.0))


def assert_exact(mesh: QuadMesh) -> None:
    measured = accuracy(mesh)
    assert measured.planarity_max < 1e-12
    assert measured.developability_max_rad < 1e-12
    assert measured.isometry_max_rel < 1e-10


def miura(columns: int, rows: int) -> np.ndarray:
    mesh = Miura(columns, rows, fold=np.radians(40)).grow().mesh
    return mesh.vertices_coords[mesh.grid]


def like(rows: np.ndarray, base: int, part: slice):
    """The choice of strips that repeats `rows` from row `base` on."""

    def choose(front: Front, strip: int) -> Strip:
        crease = (rows[base + strip + 1] - rows[base + strip])[part]
        at = 1 if len(front.vertices_coords) == len(crease) or part.start == 0 else 2
        u = front.edges_direction
        inner = crease[min(1, len(crease) - 1)]
        return Strip(float(flap_angle_of(-u[at - 1], u[at], inner)), norm(crease), at)

    return choose


def with_hole(rows: np.ndarray, r: int, c: int) -> QuadMesh:
    """The sheet `rows` grown without what is above row r and right of column c."""
    lower = QuadMesh.from_rows(rows[: r + 1])
    growth = grow_part(lower, len(rows) - 1 - r, like(rows, r, slice(0, c + 1)), part=(0, c))
    assert growth.status is Status.GROWN
    return growth.mesh


def lengths_around(rows: np.ndarray, r: int, c: int) -> np.ndarray:
    """Lengths of the new creases around the corner (r, c) of the sheet `rows`."""
    left = norm(rows[r + 1 :, c + 1] - rows[r + 1 :, c])
    return np.concatenate([left[::-1], norm(rows[r + 1, c + 1 :] - rows[r, c + 1 :])])


def seen_from(mesh: QuadMesh, quarter_turns: int) -> QuadMesh:
    return replace(mesh, grid=np.rot90(mesh.grid, quarter_turns).copy())


def jittered(random: np.random.Generator, columns: int, rows: int, r: int, c: int) -> QuadMesh:
    """A sheet near a Miura sheet with random flap angles and lengths, and a corner at (r, c)."""
    design = Miura(columns, rows, random.uniform(0.9, 1.3), random.uniform(0.5, 0.9))
    mesh = design.grow().mesh
    flat = mesh.vertices_coords[mesh.grid]

    def choose(row: int, front: Front) -> Strip:
        u = front.edges_direction
        flap = float(flap_angle_of(-u[0], u[1], flat[row + 1, 1] - flat[row, 1]))
        return Strip(
            flap + random.normal(0, 0.02),
            lambda rays: np.minimum(
                random.uniform(0.9, 1.1, len(rays.directions)), 0.6 * rays.length_bounds
            ),
        )

    lower = QuadMesh.from_rows(flat[:2])
    if r > 1:
        lower = grow(lower, r - 1, lambda front, strip: choose(1 + strip, front)).mesh
    growth = grow_part(lower, rows - r, lambda front, strip: choose(r + strip, front), part=(0, c))
    return growth.mesh


@st.composite
def cornered(draw):
    """A random sheet with a concave corner."""
    r, c = draw(st.integers(1, 3)), draw(st.integers(1, 3))
    size = draw(st.tuples(st.integers(1, 4), st.integers(1, 4)))
    random = np.random.default_rng(draw(seeds_of_randomness))
    rows = max(r + size[1], 2)
    try:
        mesh = jittered(random, c + size[0], rows, r, c)
    except InvalidValue:
        assume(False)
    assume(len(mesh.grid) == rows + 1)
    return mesh


def short(rays) -> np.ndarray:
    return np.minimum(1.0, 0.5 * rays.length_bounds)


@settings(max_examples=40)
@given(cornered())
def test_matched_strips_are_exact_until_the_corner_is_filled(mesh):
    holes = mesh.grid < 0
    strips = min(holes.any(axis=0).sum(), holes.any(axis=1).sum())
    try:
        growth = grow_corner(mesh, strips, lambda strip: CornerStrip(short))
    except InvalidValue as error:
        assume(not error.name.startswith("length"))
        raise
    assume(growth.strips > 0)
    assert_exact(growth.mesh)
    old = len(mesh.vertices_coords)
    assert (growth.mesh.vertices_coords[:old] == mesh.vertices_coords).all()
    if growth.strips == strips:
        assert growth.status is Status.GROWN
        assert (growth.mesh.grid >= 0).all()
        assert len(growth.mesh.faces_vertices) == (holes.shape[0] - 1) * (holes.shape[1] - 1)
    else:
        assert f"of {strips}" in growth.advice


@settings(max_examples=40)
@given(cornered(), st.floats(0.05, 0.95))
def test_a_pentagon_is_planar_and_its_sectors_close_the_corner(mesh, share):
    corner = mesh.grid[tuple(np.argwhere(mesh.grid < 0)[0] - [1, 1])]
    growth = grow_pentagon(mesh, CornerStrip(lambda r: np.minimum(1.0, share * r.length_bounds)))
    assume(growth.status is Status.GROWN)
    grown = growth.mesh
    assert grown.pentagons.shape == (1, 5)
    assert grown.pentagons[0, 0] == corner
    assert planarity(grown.vertices_coords, grown.pentagons).max() < 1e-14
    angles = sector_angles(grown.vertices_coords, grown.pentagons)
    assert angles.sum() == pytest.approx(3 * np.pi, abs=1e-12)
    assert angles.max() < np.pi
    quads = grown.faces_vertices == corner
    sectors = sector_angles(grown.vertices_coords, grown.faces_vertices)[quads]
    assert len(sectors) == 3
    assert sectors.sum() + angles[0, 0] == pytest.approx(2 * np.pi, abs=1e-13)
    assert_exact(grown)


@settings(max_examples=25)
@given(
    st.tuples(st.integers(2, 4), st.integers(2, 4)),
    st.tuples(st.floats(0.9, 1.25), st.floats(0.4, 0.9)),
    st.floats(0.05, 0.3),
    st.sampled_from([Side.LEFT, Side.RIGHT]),
)
def test_growth_goes_on_by_ordinary_strips_after_a_pentagon(corner, angles, length, side):
    growth = CorneredMiura(6, 7, *corner, *angles, strips=3, strip_length=length).grow()
    assert (growth.status, growth.strips) == (Status.GROWN, 3)
    mesh = growth.mesh
    width = 6 - corner[0] + 7 - corner[1]
    assert mesh.grid.shape == (4, width)
    assert len(mesh.faces_vertices) == 42 - (6 - corner[0]) * (7 - corner[1]) + 3 * (width - 1) - 1
    assert len(mesh.pentagons) == 1
    assert_exact(mesh)
    more = grow(mesh, 1, lambda front, strip: Strip(2.0, short), side=side).mesh
    assert len(more.faces_vertices) == len(mesh.faces_vertices) + 3
    assert_exact(more)
    with pytest.raises(InvalidValue, match="bottom"):
        grow(more, 1, lambda front, strip: Strip(2.0, 0.1), side=Side.BOTTOM)


@pytest.mark.parametrize(("r", "c"), [(2, 3), (5, 1), (1, 2), (2, 6), (5, 6), (3, 2)])
def test_a_miura_sheet_is_regrown_around_its_corner(r, c):
    rows = miura(7, 6)
    mesh = with_hole(rows, r, c)
    assert (mesh.grid < 0).sum() == (6 - r) * (7 - c)
    strips = min(6 - r, 7 - c)
    growth = grow_corner(
        mesh, strips, lambda strip: CornerStrip(lengths_around(rows, r + strip, c + strip))
    )
    assert growth.status is Status.GROWN
    whole = growth.mesh
    assert np.abs(whole.vertices_coords[whole.grid] - rows).max() < 1e-12
    assert len(whole.faces_vertices) == 42
    assert_exact(whole)
    extended = grow(whole, 1, lambda front, strip: Strip(1.0, 0.1), side=Side.RIGHT)
    assert_exact(extended.mesh)


def test_a_strip_on_the_middle_leaves_two_corners():
    rows = miura(7, 6)
    lower = QuadMesh.from_rows(rows[:4])
    mesh = grow_part(lower, 3, like(rows, 3, slice(2, 6)), part=(2, 5)).mesh
    assert (mesh.grid[4:] < 0).tolist() == [[True] * 2 + [False] * 4 + [True] * 2] * 3
    mesh = grow_corner(mesh, 2, lambda i: CornerStrip(lengths_around(rows, 3 + i, 5 + i))).mesh
    mirrored = rows[:, ::-1]

    def left(strip: int) -> CornerStrip:
        return CornerStrip(lengths_around(mirrored, 3 + strip, 5 + strip)[::-1])

    mesh = grow_corner(mesh, 2, left, side=Side.LEFT).mesh
    assert np.abs(mesh.vertices_coords[mesh.grid] - rows).max() < 1e-12


@pytest.mark.parametrize("side", Side)
def test_all_corners_of_the_grid_are_alike(side):
    rows = miura(7, 6)
    mesh = with_hole(rows, 2, 3)
    turned = seen_from(mesh, -[Side.TOP, Side.LEFT, Side.BOTTOM, Side.RIGHT].index(side))
    strip = CornerStrip(lambda rays: 0.7 * np.minimum(rays.length_bounds, 1.0))
    straight, around = grow_pentagon(mesh, strip), grow_pentagon(turned, strip, side=side)
    assert (straight.mesh.vertices_coords == around.mesh.vertices_coords).all()
    assert (straight.mesh.grid == around.mesh.grid).all()
    matched = CornerStrip(lengths_around(rows, 2, 3))
    first, second = (
        grow_corner(m, 1, lambda i: matched, side=s).mesh
        for m, s in ((mesh, Side.TOP), (turned, side))
    )
    assert (first.vertices_coords == second.vertices_coords).all()
    assert (first.faces_vertices == second.faces_vertices).all() or side is not Side.TOP


@settings(max_examples=20)
@given(cornered())
def test_a_mirrored_sheet_grows_mirrored(mesh):
    mirror = np.array([1.0, 1.0, -1.0])
    reflected = replace(mesh, vertices_coords=mesh.vertices_coords * mirror)
    strip = CornerStrip(lambda rays: np.minimum(1.0, 0.5 * rays.length_bounds))
    first, second = grow_pentagon(mesh, strip), grow_pentagon(reflected, strip)
    assert first.status is second.status
    assert np.abs(first.mesh.vertices_coords - second.mesh.vertices_coords * mirror).max() < 1e-11
    # left and right exchanged: the mirrored sheet with its upper side kept up
    swapped = replace(
        reflected,
        faces_vertices=mesh.faces_vertices[:, ::-1].copy(),
        grid=mesh.grid[:, ::-1].copy(),
    )
    three = grow_pentagon(swapped, strip, side=Side.LEFT)
    assert three.status is first.status
    if first.status is Status.GROWN:
        rows, other = (g.mesh.vertices_coords[g.mesh.grid] for g in (first, three))
        assert np.abs(rows[:, ::-1] - other * mirror).max() < 1e-11


def test_boundary_angles_at_the_arms_far_ends_are_those_given():
    mesh = with_hole(miura(6, 6), 2, 3)
    grown = grow_pentagon(mesh, CornerStrip(0.2, (1.1, 1.3))).mesh
    (a, b), (c, d) = (
        grown.vertices_coords[grown.grid[:, :2]],
        grown.vertices_coords[grown.grid[:, -2:]],
    )
    assert angle_between(a[1] - a[0], b[0] - a[0]) == pytest.approx(1.1, abs=1e-13)
    assert angle_between(c[0] - c[1], d[1] - c[1]) == pytest.approx(1.3, abs=1e-13)
    ends = with_hole(miura(3, 3), 2, 2)  # both neighbours are corners of the patch
    grown = grow_pentagon(ends, CornerStrip(0.1, (1.1, 1.3))).mesh
    x, p, _, _, q = grown.vertices_coords[grown.pentagons[0]]
    new_q, new_p = grown.vertices_coords[grown.grid[1]]
    assert angle_between(x - q, new_q - q) == pytest.approx(1.1, abs=1e-13)
    assert angle_between(x - p, new_p - p) == pytest.approx(1.3, abs=1e-13)
    assert_exact(grown)


def test_the_length_that_a_matched_corner_fixes_is_not_free():
    rows = miura(5, 5)
    mesh = with_hole(rows, 2, 2)
    grown = grow_corner(mesh, 1, lambda i: CornerStrip(1.05)).mesh
    assert len(grown.vertices_coords) == len(mesh.vertices_coords) + 5
    assert (grown.grid < 0).sum() == 4
    z = grown.grid[3, 3]
    whole = grow_corner(grown, 2, lambda i: CornerStrip(short)).mesh
    error = developability(whole.vertices_coords, whole.faces_vertices)
    assert error[z] < 1e-13
    # slid along its crease, the vertex beside it keeps all faces planar but z unfit to go on
    moved = grown.vertices_coords.copy()
    q2, w = grown.grid[4, 2], grown.grid[4, 3]
    moved[w] += 0.01 * (moved[w] - moved[q2])
    assert planarity(moved, grown.faces_vertices).max() < 1e-13
    with pytest.raises(InvalidValue, match=f"sector angles at vertex {z}"):
        grow_corner(replace(grown, vertices_coords=moved), 1, lambda i: CornerStrip(short))


def test_the_last_crease_of_a_part_is_that_of_the_full_strip():
    sheet = Crumpled(columns=6, strips=3).grow().mesh
    rows = sheet.vertices_coords[sheet.grid]
    lower = QuadMesh.from_rows(rows[:3])
    full = grow(lower, 1, lambda front, strip: Strip(1.0, 0.02)).mesh
    part = grow_part(lower, 1, lambda front, strip: Strip(1.0, 0.02), part=(0, 3)).mesh
    count = len(lower.vertices_coords)
    assert np.abs(part.vertices_coords[count:] - full.vertices_coords[count : count + 4]).max() == 0
    free = grow(QuadMesh.from_rows(rows[:3, :4]), 1, lambda front, strip: Strip(1.0, 0.02)).mesh
    assert norm(free.vertices_coords[-1] - part.vertices_coords[-1]) > 1e-3  # parallel instead


def test_a_part_as_wide_as_the_front_is_an_ordinary_strip():
    lower = QuadMesh.from_rows(miura(4, 3)[:3])
    strip = Strip(1.0, 0.2, boundary_angles=(1.2, 1.4))
    first = grow(lower, 1, lambda front, _: strip).mesh
    second = grow_part(lower, 1, lambda front, _: strip, part=(0, 4)).mesh
    assert (first.vertices_coords == second.vertices_coords).all()
    assert (first.faces_vertices == second.faces_vertices).all()


def test_progress_and_a_stop_by_choice():
    rows, reported = miura(6, 6), []
    mesh = with_hole(rows, 2, 2)

    def choose(strip: int) -> CornerStrip | Stop:
        if strip == 2:
            return Stop(Status.COVERED, "enough")
        return CornerStrip(lengths_around(rows, 2 + strip, 2 + strip))

    growth = grow_corner(mesh, 4, choose, progress=lambda *steps: reported.append(steps))
    assert (growth.status, growth.strips, growth.advice) == (Status.COVERED, 2, "enough")
    assert reported == [(1, 4), (2, 4)]
    assert (growth.mesh.grid < 0).sum() == 4


ROWS = miura(6, 6)


def stair() -> QuadMesh:
    return grow_part(with_hole(ROWS, 2, 4), 1, lambda f, i: Strip(1.0, 0.1), part=(0, 2)).mesh


def moved_corner() -> QuadMesh:
    mesh = with_hole(ROWS, 2, 3)
    coords = mesh.vertices_coords.copy()
    coords[mesh.grid[3, 3]] += [0.0, 0.0, 0.01]
    return replace(mesh, vertices_coords=coords)


def part_of(mesh: QuadMesh, part, **choice):
    return grow_part(mesh, 1, lambda f, i: Strip(1.0, 0.1, **choice), part=part)


@pytest.mark.parametrize(
    ("act", "message"),
    [
        (lambda: grow_corner(QuadMesh.from_rows(ROWS), 1, CornerStrip), "concave corner"),
        (lambda: grow_pentagon(QuadMesh.from_rows(ROWS), CornerStrip(0.1)), "concave corner"),
        (lambda: grow_corner(with_hole(ROWS, 2, 3), 4, CornerStrip), "be from 1 to 3"),
        (lambda: grow_corner(with_hole(ROWS, 2, 3), 0, CornerStrip), "strips = 0"),
        (
            lambda: grow_corner(with_hole(ROWS, 2, 3), 1, CornerStrip, side=Side.LEFT),
            "concave corner",
        ),
        (lambda: grow_pentagon(stair(), CornerStrip(0.1)), "rectangular hole"),
        (lambda: grow_pentagon(moved_corner(), CornerStrip(0.1)), "sector angles"),
        (lambda: grow_pentagon(with_hole(ROWS, 2, 3), CornerStrip(5.0)), r"length\[\d\].*below"),
        (lambda: grow_pentagon(with_hole(ROWS, 2, 3), CornerStrip(0.0)), r"length\[0\]"),
        (
            lambda: grow_pentagon(with_hole(ROWS, 2, 3), CornerStrip(np.ones(3))),
            r"lengths.*shape \(7,\)",
        ),
        (
            lambda: grow_pentagon(with_hole(ROWS, 2, 3), CornerStrip(0.1, (None, 4.0))),
            r"boundary angle \(right\)",
        ),
        (
            lambda: grow_pentagon(with_hole(ROWS, 2, 3), CornerStrip(0.1, (0.0, None))),
            r"boundary angle \(left\)",
        ),
        (
            lambda: grow_corner(with_hole(ROWS, 2, 3), 1, lambda i: CornerStrip(-1.0)),
            r"length\[\d\].*greater than 0",
        ),
        (
            lambda: grow_corner(with_hole(ROWS, 2, 3), 1, lambda i: CornerStrip(np.nan)),
            r"length\[0\].*greater than 0",
        ),
        (lambda: grow(with_hole(ROWS, 2, 3), 1, lambda f, i: Strip(1.0, 0.1)), "end to end"),
        (lambda: part_of(QuadMesh.from_rows(ROWS[:2]), (0, 7)), "part"),
        (lambda: part_of(QuadMesh.from_rows(ROWS[:2]), (2, 2)), "part"),
        (lambda: part_of(QuadMesh.from_rows(ROWS[:2]), (-2, 2)), "part"),
        (lambda: part_of(with_hole(ROWS, 2, 3), (0, 5)), "part"),
        (
            lambda: grow_part(
                QuadMesh.from_rows(ROWS[:2]), 2, lambda f, i: Strip(1.0, 0.1), part=(0, 1)
            ),
            "part.*3 vertices",
        ),
        (lambda: part_of(seeds.curve(ROWS[0]), (0, 3)), "curve"),
        (lambda: part_of(RandomTube(strips=1).grow().mesh, (0, 3)), "closed"),
        (
            lambda: part_of(QuadMesh.from_rows(ROWS[:2]), (0, 3), boundary_angles=(None, 1.0)),
            r"boundary angle \(right\).*left out",
        ),
    ],
)
def test_misuse_is_named(act, message):
    with pytest.raises(InvalidValue, match=message):
        act()


@pytest.mark.parametrize(
    ("seed", "status", "strips", "advice"),
    [
        (0, Status.GROWN, 3, "^$"),
        (74, Status.CORNER_NOT_CONVEX, 0, "points back into the corner"),
        (7, Status.CORNER_NOT_CONVEX, 1, "Strip 2 of 3: .* points back"),
        (11, Status.CORNER_NOT_MATCHED, 0, "no length beside the corner"),
        (13, Status.CORNER_NOT_MATCHED, 0, "new crease 3 to 1.27449389, beyond"),
        (104, Status.CORNER_NOT_MATCHED, 1, "neighbours do not meet"),
        (14, Status.FACES_CROSS, 0, "cross at the matched corner"),
        (44, Status.FACES_CROSS, 0, "behind the left arm, at vertex 2"),
        (23, Status.FACES_CROSS, 1, "Strip 2 of 3: .* left arm, at vertex 1"),
    ],
)
def test_growth_that_cannot_go_on_keeps_what_it_has_and_says_why(seed, status, strips, advice):
    mesh = jittered(np.random.default_rng(seed), 5, 5, 2, 2)
    growth = grow_corner(mesh, 3, lambda strip: CornerStrip(short))
    assert (growth.status, growth.strips) == (status, strips)
    assert re.search(advice, growth.advice)
    assert len(growth.mesh.faces_vertices) == 16 + {0: 0, 1: 5, 3: 9}[strips]
    assert_exact(growth.mesh)
    if status is Status.CORNER_NOT_MATCHED:  # a pentagon asks for less
        last = grow_pentagon(growth.mesh, CornerStrip(short))
        assert last.status is Status.GROWN
        assert_exact(last.mesh)


def test_a_length_out_of_bounds_in_a_later_strip_ends_growth():
    rows = miura(6, 6)

    def choose(strip: int) -> CornerStrip:
        lengths = lengths_around(rows, 2 + strip, 2 + strip)
        return CornerStrip(lengths if strip == 0 else -lengths)

    growth = grow_corner(with_hole(rows, 2, 2), 2, choose)
    assert (growth.status, growth.strips) == (Status.LENGTH_NOT_POSITIVE, 1)
    assert "Strip 2 of 2: at new crease 0 the length must be finite" in growth.advice


def test_an_arm_without_room_to_fold_says_which():
    mesh = with_hole(miura(6, 6), 2, 2)
    coords = mesh.vertices_coords.copy()
    a, b, c = mesh.grid[2, 3:6]
    coords[b] = (coords[a] + coords[c]) / 2  # the right arm goes straight on
    growth = grow_pentagon(replace(mesh, vertices_coords=coords), CornerStrip(0.1))
    assert (growth.status, growth.strips) == (Status.FRONT_NOT_FOLDABLE, 0)
    assert "right arm" in growth.advice


def test_faces_of_any_size_that_overlap_are_found_as_by_brute_force():
    mesh = CorneredMiura(8, 8, strips=4, strip_length=0.9, fold=np.radians(30)).grow().mesh
    flat = develop(mesh).vertices_coords.copy()
    far, *rest = np.roll(mesh.pentagons[0], -2)
    flat[far] += 8 * (flat[far] - flat[rest].mean(axis=0))  # the pentagon over its neighbours
    corners, offsets = mesh.polygons
    shapes = [shapely.Polygon(flat[corners[i:j]]) for i, j in pairwise(offsets)]
    expected = {
        (i, j)
        for i, j in combinations(range(len(shapes)), 2)
        if shapes[i].is_valid
        and shapes[j].is_valid
        and shapes[i].intersection(shapes[j]).area > 1e-9 * min(shapes[i].area, shapes[j].area)
    }
    expected |= {(i, i) for i, shape in enumerate(shapes) if not shape.is_valid}
    found = overlapping_faces(flat, corners, offsets, mesh.edges)
    assert {tuple(pair) for pair in found.tolist()} == expected
    assert sum(len(shapes) - 1 in pair for pair in expected) > 3


def test_the_design_reports_progress_and_may_end_with_the_pentagon():
    reported = []
    CorneredMiura(strips=3).grow(lambda *steps: reported.append(steps))
    assert reported == [(1, 3), (2, 3), (3, 3)]
    growth = CorneredMiura(strips=1).grow()
    assert (growth.status, growth.strips) == (Status.GROWN, 1)
    assert growth.mesh.grid.shape == (2, 12)


def test_files_of_the_design_have_the_pentagon():
    made = make(load_job(TEMPLATES / "cornered_miura.toml"), ["fold", "stl"])
    document = json.loads(made.files["cornered_miura.fold"])
    assert sorted({len(face) for face in document["faces_vertices"]}) == [4, 5]
    assert sum(len(face) == 5 for face in document["faces_vertices"]) == 1
    assert made.report["solids"]["panels"] == len(document["faces_vertices"]) == 97


@pytest.mark.parametrize(
    ("change", "name"),
    [
        ({"corner_column": 1}, "corner_column"),
        ({"corner_column": 10}, "corner_column"),
        ({"corner_row": 9}, "corner_row"),
        ({"strips": 0}, "strips"),
        ({"strips": 7, "matched": True}, "strips"),
        ({"strip_length": -1.0}, "strip_length"),
        ({"columns": 1}, "corner_column"),
        ({"fold": 2.0}, "fold"),
    ],
)
def test_parameters_of_the_design_out_of_bounds_are_named(change, name):
    with pytest.raises(InvalidValue, match=name):
        CorneredMiura(**change).grow()


def test_the_design_fills_its_corner_where_quads_match():
    growth = CorneredMiura(matched=True, strips=6, strip_length=1.05).grow()
    assert (growth.status, growth.strips) == (Status.GROWN, 6)
    assert (growth.mesh.grid >= 0).all()
    assert len(growth.mesh.faces_vertices) == 100
    assert len(growth.mesh.pentagons) == 0
    assert_exact(growth.mesh)
