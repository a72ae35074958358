"""Sheets for surfaces of any topology: exact, without crossings, over all of the surface."""

import numpy as np
import pytest
import trimesh
from surface_meshes import cap, dome_with_holes, grid, mesh_of, torus

from fab.pattern.development import develop
from solver import InvalidState, InvalidValue, QuadMesh, Status, developability, planarity
from solver.designs import SurfaceFit
from solver.goals import Bounds, Goals
from solver.relaxation.laying import Pleats, laid_patch, laid_tube
from solver.relaxation.sheet_fit import relaxed_sheet
from solver.relaxed_fit import joined, relaxed_fit, sampled
from solver.self_intersection import crossing_faces
from solver.surface_cuts import halves
from solver.surface_maps import cylinder_map, disc_map
from solver.surface_sheet import SurfaceSheet
from solver.surface_sheets import surface_sheets
from solver.targets import explicit_surface
from solver.targets.mesh_target import MeshTarget
from solver.targets.surface_mesh import MeshKind


def ball():
    made = trimesh.creation.icosphere(2)
    return mesh_of((np.array(made.vertices), np.array(made.faces)))


def tube():
    def f(u, v):
        out = 1 + 0.1 * np.cos(v)
        return out * np.cos(u), out * np.sin(u), v

    return mesh_of(grid(f, 36, 16, u=(0, 2 * np.pi), v=(-1, 1), around=(True, False)))


def require_made(sheet):
    coords, faces = sheet.mesh.vertices_coords, sheet.mesh.faces_vertices
    assert planarity(coords, faces).max() < 1e-12
    assert developability(coords, faces).max() < 1e-12
    assert len(crossing_faces(coords, *sheet.mesh.polygons)) == sheet.crossings == 0
    assert sheet.coverage >= 0.99
    assert np.abs(sheet.deviations).max() <= 0.15 * sheet.step
    assert sheet.good
    assert sheet.faults == 0
    assert 0 < sheet.least_sector < np.pi / 2


def test_a_cap_is_covered_by_one_exact_sheet():
    mesh = mesh_of(cap(np.pi / 3, 12, 36))
    steps = []
    found = surface_sheets(mesh, 10, progress=lambda done, of: steps.append((done, of)))
    (sheet,) = found.sheets
    require_made(sheet)
    assert found.good
    assert found.coverage > 0.99
    assert sheet.part is mesh
    assert [done for done, _ in steps] == list(range(1, len(steps) + 1))
    assert all(done <= of for done, of in steps)
    again = surface_sheets(mesh, 10).sheets[0].mesh
    np.testing.assert_array_equal(again.vertices_coords, sheet.mesh.vertices_coords)


def test_a_tube_is_covered_by_one_exact_tube():
    found = surface_sheets(tube(), 12)
    (sheet,) = found.sheets
    require_made(sheet)
    assert sheet.mesh.closed
    assert sheet.mesh.grid.shape[1] == 12
    assert found.coverage > 0.99


def test_a_sheet_with_holes_closes_around_them_when_flat():
    """Faces and vertices around a hole can be exact where the sheet is none: lengths tell."""
    mesh = mesh_of(dome_with_holes())
    (sheet,) = surface_sheets(mesh, 16, turns=[0.0]).sheets
    require_made(sheet)
    faces = sheet.mesh.faces_vertices
    vertices, edges = len(np.unique(faces)), len(np.unique(np.sort(_sides(faces), axis=1), axis=0))
    assert vertices - edges + len(faces) <= 0  # some hole is open, those of under a cell are not
    flat = develop(sheet.mesh).vertices_coords
    lengths = [
        np.linalg.norm(coords[ends[:, 0]] - coords[ends[:, 1]], axis=1)
        for coords, ends in ((flat, _sides(faces)), (sheet.mesh.vertices_coords, _sides(faces)))
    ]
    np.testing.assert_allclose(*lengths, rtol=0, atol=1e-11)


def _sides(faces):
    return np.stack([faces, np.roll(faces, -1, axis=1)], axis=-1).reshape(-1, 2)


def test_places_go_on_around_a_tube():
    flat, period = cylinder_map(tube())
    target = MeshTarget(tube(), flat, period)
    uv = np.column_stack([np.linspace(-0.2, 0.2, 41), np.full(41, 1.0)])
    points = target.point(target.places(uv))
    np.testing.assert_allclose(
        target.point(target.places(uv + np.array([period, 0]))), points, atol=1e-12
    )
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    assert steps.max() < 1.3 * steps.min()  # nowhere held back at the end of the map


def test_places_of_a_ragged_rim_are_those_beside_it():
    """A triangle with all corners on a rim, as scans have them, has no area in the map."""
    plain = tube()
    (one, other), *_ = plain.edges_vertices[plain.rim_edges]
    coords = plain.vertices_coords
    tip = coords[[one, other]].mean(axis=0) + np.array([0.0, 0.0, 0.05 * np.sign(coords[one, 2])])
    faces = np.concatenate([plain.faces_vertices, [[other, one, len(coords)]]])
    ragged = mesh_of((np.concatenate([coords, [tip]]), faces))
    assert ragged.kind is MeshKind.RING
    flat, period = cylinder_map(ragged)
    target = MeshTarget(ragged, flat, period)
    points = target.point(target.places(np.linspace(flat[-1, 0], flat[-1, 1], 9)))
    np.testing.assert_allclose(points, np.linspace(coords[other], coords[one], 9), atol=0.05)


def test_a_ball_takes_two_sheets_or_more():
    mesh = ball()
    steps = []
    found = surface_sheets(
        mesh,
        8,
        turns=[0.0],
        pleats=[Pleats()],
        most_sheets=4,
        progress=lambda done, of: steps.append((done, of)),
    )
    assert steps == sorted(steps)
    assert all(done <= of for done, of in steps)
    assert 2 <= len(found.sheets) <= 4
    assert sum(sheet.part.area for sheet in found.sheets) == pytest.approx(mesh.area)
    assert {sheet.part.kind for sheet in found.sheets} == {MeshKind.DISC}
    assert found.coverage > 0.95
    with pytest.raises(InvalidState, match="closed surface cannot be covered by one sheet"):
        surface_sheets(mesh, 8, most_sheets=1)


def test_a_torus_is_opened_for_a_single_sheet():
    found = surface_sheets(
        mesh_of(torus(24, 12)), 8, most_sheets=1, pleats=[Pleats(zigzag=0.5)], turns=[0.0]
    )
    assert len(found.sheets) == 1
    assert found.sheets[0].part.kind is MeshKind.RING


@pytest.mark.parametrize(
    ("columns", "most", "text"),
    [
        (3, 8, "columns = 3 is out of bounds: it must be from 4 to"),
        (401, 8, "columns = 401 is out of bounds: it must be at most 400"),
        (8, 0, "most_sheets = 0 is out of bounds: it must be from 1 to"),
    ],
)
def test_numbers_out_of_bounds_are_refused(columns, most, text):
    with pytest.raises(InvalidValue, match=text):
        surface_sheets(mesh_of(cap(1.0, 4, 12)), columns, most_sheets=most)


def test_an_interrupted_search_keeps_the_best_so_far():
    mesh = mesh_of(cap(np.pi / 3, 12, 36))
    asked = []

    def interrupted():
        asked.append(True)
        return len(asked) > 3

    found = surface_sheets(mesh, 10, interrupted=interrupted)
    (sheet,) = found.sheets
    assert not found.good
    assert sheet.advice
    assert sheet.rounds < 5
    assert len(asked) < 20
    assert len(sheet.mesh.faces_vertices) > 50


def test_a_sheet_with_a_reflex_face_is_not_good():
    """The constraint of vertices counts such a sector by the angle on its other side."""
    coords = np.stack([*np.mgrid[:3, :3][::-1].astype(float), np.zeros((3, 3))], axis=-1)
    coords[0, 0] = 0.9, 0.9, 0  # beyond the diagonal of its face: the corner at (1, 1) is reflex
    coords[1, 1] = 0.3, 0.3, 0
    mesh = QuadMesh.from_rows(coords)
    flat = QuadMesh.from_rows(np.stack([*np.mgrid[:3, :3][::-1], np.zeros((3, 3))], -1) * 1.0)
    good = surface_sheets(
        mesh_of(grid(lambda u, v: (u, v, 0 * u), 6, 6)), 4, turns=[0.0], pleats=[Pleats()]
    ).sheets[0]
    for sheet, exact in ((flat, True), (mesh, False)):
        values = {name: getattr(good, name) for name in SurfaceSheet.__dataclass_fields__}
        made = SurfaceSheet(**values | {"mesh": sheet})
        assert made.exact is exact
        assert made.good is (exact and good.good)


@pytest.mark.parametrize("turn", [0.0, 0.5])
def test_a_patch_is_laid_over_all_of_the_map(turn):
    mesh = mesh_of(cap(1.0, 8, 24))
    corners = disc_map(mesh)
    target = MeshTarget(mesh, corners)
    sheet = laid_patch(target, 9, Pleats(zigzag=1.0), turn)
    kept = sheet.kept.ravel()
    assert kept.sum() < kept.size  # a disc leaves corners of the grid out
    used = sheet.base.reshape(-1, 2)[np.unique(sheet.faces_vertices)]
    axis = np.array([np.cos(turn), np.sin(turn)])
    wide = np.ptp(corners.reshape(-1, 2) @ axis)
    assert np.ptp(used @ axis) >= wide - 1e-9
    # neighbours along a line are a ninth of the map's width apart, in its direction
    step = np.diff(sheet.base, axis=1).reshape(-1, 2)
    assert step == pytest.approx(np.broadcast_to(axis * wide / 9, step.shape), abs=1e-9)


@pytest.mark.parametrize("off", [-1e-10, 0.0, 1e-10])
def test_a_map_that_is_as_long_as_wide_but_for_rounding_gets_as_many_rows_as_columns(off):
    mesh = mesh_of(grid(lambda u, v: (u, v, 0 * u), 5, 5))
    corners = mesh.vertices_coords[mesh.faces_vertices][..., :2] * [1.0, 1.0 + off]
    assert laid_patch(MeshTarget(mesh, corners), 8, Pleats()).shape == (11, 11)


@pytest.mark.parametrize(("around", "columns"), [(12, 12), (13, 14)])
def test_a_tube_is_laid_evenly_around_from_rim_to_rim(around, columns):
    corners, period = cylinder_map(tube())
    sheet = laid_tube(MeshTarget(tube(), corners), period, around, Pleats())
    assert sheet.shape[1] == columns
    assert sheet.period == (period, 0.0)
    assert sheet.base[0, :, 0] == pytest.approx(period * np.arange(columns) / columns)
    assert sheet.base[0, :, 1] == pytest.approx(0)
    assert sheet.base[-1, :, 1] == pytest.approx(corners[..., 1].max())


@pytest.mark.parametrize("values", [{"zigzag": 0.0}, {"stretch": 0.01}, {"spacing": np.nan}])
def test_cells_out_of_bounds_are_refused(values):
    with pytest.raises(InvalidValue, match=next(iter(values))):
        Pleats(**values)


def test_a_sampled_surface_is_its_largest_piece():
    mesh = sampled(explicit_surface(lambda x, y: 0.2 * (x * x - y * y)))
    assert mesh.kind is MeshKind.DISC
    x, y, z = mesh.vertices_coords.T
    assert z == pytest.approx(0.2 * (x * x - y * y), abs=1e-12)
    assert np.ptp(mesh.vertices_coords, axis=0)[:2] == pytest.approx([2, 2])


def test_a_fit_is_told_as_growth():
    growth = relaxed_fit(mesh_of(cap(np.pi / 3, 12, 36)), 10, turn=0.0, zigzag=2.0)
    assert growth.status is Status.GROWN
    assert growth.advice == ""
    assert growth.coverage > 0.99
    assert growth.chosen["turn_deg"] == 0.0
    assert growth.chosen["zigzag"] == 2.0
    assert len(growth.deviations)


def test_a_surface_that_no_sheet_follows_is_told_with_advice(monkeypatch):
    monkeypatch.setattr("solver.relaxed_fit.PLEATS", (Pleats(),))
    bad = relaxed_fit(mesh_of(cap(np.pi / 3, 8, 24)), 4, turn=0.0, thickness=12.0)
    assert bad.status is Status.NOT_FITTED
    assert bad.advice


def test_joined_patches_keep_their_faces_and_grids():
    first, second = (
        QuadMesh.from_rows(
            np.stack([*np.mgrid[:rows, :columns].astype(float), np.full((rows, columns), z)], -1)
        )
        for rows, columns, z in ((3, 4, 0.0), (2, 5, 7.0))
    )
    both = joined([first, second])
    assert both.grid.shape == (6, 5)
    assert (both.grid[:3, 4] == -1).all()
    assert (both.grid[3] == -1).all()
    assert both.grid[4:].tolist() == (second.grid + 12).tolist()
    assert len(both.faces_vertices) == len(first.faces_vertices) + len(second.faces_vertices)
    corners = both.vertices_coords[both.faces_vertices]
    np.testing.assert_array_equal(corners[:6], first.vertices_coords[first.faces_vertices])
    np.testing.assert_array_equal(corners[6:], second.vertices_coords[second.faces_vertices])


@pytest.mark.parametrize(
    ("values", "text"),
    [
        ({"thickness": 0.0}, "thickness = 0 is out of bounds"),
        ({"zigzag": -1.0}, "zigzag = -1 is out of bounds"),
        ({"row_step": 0.0}, "row_step = 0 is out of bounds"),
        ({"turn": np.inf}, "turn = inf is out of bounds"),
        ({"columns": 3}, "columns = 3 is out of bounds"),
        ({"cost": "design_angles"}, "cost = design_angles is .* mirror for a relaxed sheet"),
        ({"rows_may_end": True}, "rows_may_end = True .* false for a relaxed sheet.*method = grow"),
        ({"lookahead": True}, "lookahead = True .* false for a relaxed sheet"),
        ({"method": "melt"}, "method = melt is .* one of auto, grow, relax"),
        ({"method": "grow"}, "method = grow is .* relax for a SurfaceMesh"),
    ],
)
def test_designs_name_the_value_that_relaxation_cannot_use(values, text):
    with pytest.raises(InvalidValue, match=text):
        SurfaceFit(**{"surface": mesh_of(cap(np.pi / 3, 8, 24)), "columns": 10} | values).grow()


def test_a_noisy_surface_is_followed_smoothed_and_told_by_how_much():
    clean = mesh_of(cap(0.8, 40, 120))
    noise = 0.01 * np.random.default_rng(7).normal(size=clean.vertices_coords.shape)
    noisy = mesh_of((clean.vertices_coords + noise, clean.faces_vertices))
    growth = relaxed_fit(noisy, 12, turn=0.0, zigzag=2.0)
    assert growth.status is Status.GROWN
    assert growth.chosen["smoothing_length"] > 0.1
    assert 0.01 < growth.chosen["smoothing_moved"] < 0.06  # four or five deviations of the noise
    quiet = relaxed_fit(clean, 12, turn=0.0, zigzag=2.0)
    assert not [name for name in quiet.chosen if name.startswith("smoothing")]
    # of the vertices over the surface, distances from it as it was given
    target = MeshTarget(noisy)
    points = growth.mesh.vertices_coords
    given = target.distance(points, target.unknown(len(points)))[0]
    assert np.isin(growth.distances, given).all()
    assert 0.75 * len(points) < len(growth.distances) < len(points)  # few are beyond its rim
    assert np.abs(np.abs(growth.distances) - growth.chosen["step"] / 2).max() > 0.015
    # vertices are about half a thickness from the true sphere, not from the noise
    radius = np.linalg.norm(growth.mesh.vertices_coords, axis=1)
    off = np.abs(np.abs(radius - 1) - growth.chosen["step"] / 2) / growth.chosen["step"]
    assert np.median(off) < 0.05


@pytest.mark.parametrize(
    "bounds",
    [
        {"least_side": 0.85},
        {"least_inradius": 0.38},
        {"least_sector": np.radians(35)},
        {"most_fold": np.radians(150)},
    ],
    ids=lambda bounds: next(iter(bounds)),
)
def test_a_sheet_comes_within_the_goals_of_its_maker(bounds):
    """Lengths in steps of the sheet that is made without goals, and misses each of them."""
    mesh = mesh_of(cap(np.pi / 3, 12, 36))
    given = {"pleats": [Pleats()], "turns": [0.0], "most_sheets": 1}
    (free,) = surface_sheets(mesh, 10, **given).sheets

    def goals(step):
        return Goals(Bounds(**bounds), unit=lambda sheet, folded: step)

    (held,) = surface_sheets(mesh, 10, goals=goals(free.step), **given).sheets
    require_made(held)
    wanted = goals(free.step).of(held.mesh, held.mesh.vertices_coords)
    for sheet, missed in ((free, True), (held, False)):
        measures = wanted.measures(sheet.mesh.vertices_coords, sheet.mesh.faces_vertices)
        assert wanted.misses(measures).any() == missed
    assert held.missed == 0


@pytest.mark.parametrize("bounds", [Bounds(least_side=2.0), Bounds(least_inradius=0.7)])
def test_lengths_that_no_face_has_room_for_cost_no_further_relaxation(bounds, monkeypatch):
    """The whole dome is as wide."""
    done = []

    def counted(*arguments, **named):
        done.append(0)
        return relaxed_sheet(*arguments, **named)

    monkeypatch.setattr("solver.surface_sheets.relaxed_sheet", counted)
    mesh = mesh_of(cap(np.pi / 4, 12, 36))
    surface_sheets(mesh, 8)
    without = len(done)
    (sheet,) = surface_sheets(mesh, 8, goals=Goals(bounds)).sheets
    assert sheet.good
    assert sheet.far
    assert sheet.missed > 0.4
    assert len(done) == 2 * without


def test_goals_that_cannot_be_reached_are_missed_by_a_stated_share():
    mesh = mesh_of(cap(np.pi / 3, 12, 36))
    goals = Goals(Bounds(least_sector=np.radians(80)))
    given = {"pleats": [Pleats()], "turns": [0.0], "most_sheets": 1}
    (sheet,) = surface_sheets(mesh, 8, goals=goals, **given).sheets
    require_made(sheet)
    assert 0 < sheet.missed == pytest.approx(1 - sheet.least_sector / np.radians(80))
    (free,) = surface_sheets(mesh, 8, **given).sheets
    assert sheet.least_sector > free.least_sector


def test_narrow_cells_reach_around_half_a_torus_from_its_outer_to_its_inner_equator():
    part = halves(mesh_of(torus(48, 24, 2.0, 0.8)))[0]
    narrow = Pleats(zigzag=0.1, spacing=0.4, thickness=0.5, stretch=1.2)
    (sheet,) = surface_sheets(part, 38, pleats=[narrow]).sheets
    assert sheet.good
    assert sheet.mesh.closed
    require_made(sheet)
