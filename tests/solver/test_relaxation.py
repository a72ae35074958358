"""Relaxation of whole sheets: exact, near their surfaces, the same every time."""

import os
import subprocess
import sys

import numpy as np
import pytest
from helpers import ROOT
from relaxed_surfaces import VASE, Sphere, bump, bump_sheet, hemisphere, vase_tube

from solver import InvalidState, InvalidValue, Miura, developability, planarity
from solver.hinge_angles import hinge_angles
from solver.quad_hinges import hinges
from solver.relaxation import (
    DevelopableVertices,
    FlatFoldableVertices,
    PlanarFaces,
    PleatedSheet,
    RelaxationStatus,
    SideLengths,
    Soft,
    Wishes,
    pleated_patch,
    pleated_tube,
    prolonged,
    relax,
    relaxed_sheet,
)
from solver.relaxation.neighbours import sides, vertex_rings
from solver.relaxation.projection import projected
from solver.self_intersection import crossing_faces


def exactness(mesh):
    """Largest of planarity and developability, as `solver.measure` has them."""
    coords, faces = mesh.vertices_coords, mesh.faces_vertices
    return max(planarity(coords, faces).max(), developability(coords, faces).max())


def hard_terms(mesh, *, flat=False):
    faces, count = mesh.faces_vertices, len(mesh.vertices_coords)
    terms = [PlanarFaces(faces), DevelopableVertices.of(faces, count)]
    return [*terms, FlatFoldableVertices.of(faces, count)] if flat else terms


def miura():
    mesh = Miura(columns=8, rows=6, fold=0.9).grow().mesh
    edges = sides(mesh.faces_vertices)
    lengths = np.linalg.norm(np.diff(mesh.vertices_coords[edges], axis=1)[:, 0], axis=1)
    return mesh, [Soft(SideLengths(edges, lengths))]


def crossings(mesh):
    return len(crossing_faces(mesh.vertices_coords, *mesh.polygons))


@pytest.mark.parametrize("flat", [False, True])
def test_a_miura_sheet_stays_as_it_is(flat):
    mesh, soft = miura()
    relaxed = relax(mesh.vertices_coords, hard_terms(mesh, flat=flat), soft, 1.0)
    assert relaxed.status is RelaxationStatus.RELAXED
    assert relaxed.rounds == 0
    assert relaxed.hard_residual < 1e-13
    np.testing.assert_array_equal(relaxed.coords, mesh.vertices_coords)


@pytest.mark.parametrize("size", [1e-4, 1e-3, 1e-2])
def test_the_projection_converges_quadratically(size):
    """Each residual is at most a multiple of the square of the one before, down to rounding."""
    mesh, _ = miura()
    moved = mesh.vertices_coords + size * np.random.default_rng(1).normal(size=(63, 3))
    residuals = np.array(projected(moved, hard_terms(mesh), 1.0).residuals)
    assert residuals[-1] <= 1e-13
    assert (residuals[1:] <= _SQUARE * residuals[:-1] ** 2 + 1e-13).all()
    assert len(residuals) <= 5


def test_the_projection_is_the_shortest_way():
    """To first order: what is moved is at right angles to what the constraints leave free."""
    mesh, _ = miura()
    moved = mesh.vertices_coords + 1e-5 * np.random.default_rng(2).normal(size=(63, 3))
    hard = hard_terms(mesh)
    onto = projected(moved, hard, 1.0).coords
    rows = []
    for term in hard:
        gradients = term.linearised(onto).gradients
        dense = np.zeros((len(gradients), 63, 3))
        dense[np.arange(len(gradients))[:, None], term.vertices] = gradients
        rows.append(dense.reshape(len(gradients), -1))
    jacobian, way = np.concatenate(rows), (onto - moved).ravel()
    along = np.linalg.lstsq(jacobian.T, way, rcond=1e-10)[0]
    assert np.linalg.norm(way - jacobian.T @ along) < 1e-3 * np.linalg.norm(way)


# Of the projection near the Miura sheet: a residual over the square of the one before.
_SQUARE = 25.0

CASES = {
    "hemisphere": hemisphere,
    "vase": vase_tube,
    "bump": lambda: bump_sheet(0.5),
    "fine bump": lambda: bump_sheet(0.5, 44),
}


@pytest.mark.parametrize("name", CASES)
def test_sheets_are_exact_and_near_their_surfaces(name):
    target, sheet = CASES[name]()
    fit = relaxed_sheet(target, sheet)
    assert fit.relaxation.status is RelaxationStatus.RELAXED
    assert fit.relaxation.hard_residual <= 1e-12
    assert exactness(fit.mesh) <= 1e-12
    off = np.abs(fit.deviations)
    assert off.mean() <= 0.02
    assert off.max() <= 0.08
    # the deviations are what the surface says of the vertices
    coords = fit.mesh.vertices_coords
    distance = target.distance(coords, target.places(sheet.uv))[0]
    np.testing.assert_allclose(
        (distance - sheet.offsets) / sheet.cell.step, fit.deviations, atol=1e-9
    )
    assert crossings(fit.mesh) == 0
    assert (fit.coarse_rounds > 0) == (sheet.shape[0] > 30)


def test_sheets_reach_to_the_rim_of_their_surface():
    """The sides of the hemisphere's square are at 90 degrees from the pole, and the vase is 2 high:
    no rim is short of them by more than half a step."""
    target, sheet = hemisphere()
    coords = relaxed_sheet(target, sheet).mesh.vertices_coords.reshape(*sheet.shape, 3)
    rim = np.concatenate([coords[0], coords[-1], coords[:, 0], coords[:, -1]])
    height = rim[:, 2] / np.linalg.norm(rim, axis=1)
    swing = sheet.cell.zigzag / 2  # lines swing in and out of the rim
    assert height.max() < swing + sheet.cell.step / 2
    target, sheet = vase_tube()
    coords = relaxed_sheet(target, sheet).mesh.vertices_coords.reshape(*sheet.shape, 3)
    assert coords[0, :, 2].max() < -1 + sheet.cell.step / 2 + sheet.cell.thickness / 2
    assert coords[-1, :, 2].min() > 1 - sheet.cell.step / 2 - sheet.cell.thickness / 2


def test_without_a_rim_to_reach_sheets_draw_back():
    target, sheet = vase_tube()
    coords = relaxed_sheet(target, sheet, Wishes(rim=0.0)).mesh.vertices_coords
    assert np.ptp(coords[:, 2]) < 1.8


def test_the_upper_side_is_on_the_side_of_the_normals():
    """By the diagonals of two by two faces, over which pleats cancel."""
    for target, sheet in (hemisphere(), vase_tube()):
        start = sheet.points(target)
        x = start.reshape(*sheet.shape, 3)
        first, second = x[2:, 2:] - x[:-2, :-2], x[2:, :-2] - x[:-2, 2:]
        up = target.normal(target.places(sheet.uv)).reshape(*sheet.shape, 3)[1:-1, 1:-1]
        assert (np.vecdot(np.cross(first, second), up) > 0).all()
        faces = sheet.mesh(start).faces_vertices
        assert faces[0].tolist() == [0, 1, sheet.shape[1] + 1, sheet.shape[1]]


def test_a_tube_is_closed():
    target, sheet = vase_tube()
    mesh = relaxed_sheet(target, sheet).mesh
    assert mesh.closed
    assert len(mesh.faces_vertices) == 16 * 24
    # all vertices but those of both rims are inside
    assert len(vertex_rings(mesh.faces_vertices, len(mesh.vertices_coords))) == 15 * 24


def test_free_vertices_do_not_follow_the_surface():
    target, sheet = bump_sheet(0.5)
    held = np.zeros(sheet.shape, bool)
    held[2:-2, 2:-2] = True
    fit = relaxed_sheet(target, sheet, held=held.ravel())
    assert fit.relaxation.status is RelaxationStatus.RELAXED
    assert len(fit.deviations) == held.sum()
    whole = relaxed_sheet(target, sheet)
    inner = np.abs(whole.deviations[held.ravel()]).mean()
    assert np.abs(fit.deviations).mean() < inner  # what the rim asked for is no longer paid for


def fold_matrix(mesh):
    """Closure of the folds around each interior vertex: rates of fold angles to three sums."""
    coords, faces = mesh.vertices_coords, mesh.faces_vertices
    inner = hinges(faces)
    number = {tuple(sorted(ends)): e for e, ends in enumerate(inner[:, :2].tolist())}
    rings = vertex_rings(faces, len(coords))
    matrix = np.zeros((len(rings), 3, len(inner)))
    for k, (vertex, *ring) in enumerate(rings.tolist()):
        for other in ring:
            e = number[min(vertex, other), max(vertex, other)]
            side = coords[other] - coords[vertex]
            matrix[k, :, e] = side / np.linalg.norm(side)
    return matrix.reshape(-1, len(inner))


def test_a_rigid_sheet_has_one_degree_of_freedom_and_others_none():
    """Of faces that stay plane, by the rank of the closure around all interior vertices."""
    target, sheet = bump_sheet(0.2, 10)
    freedom = {}
    for rigid in (True, False):
        fit = relaxed_sheet(target, sheet, Wishes(rigid=rigid))
        assert fit.relaxation.status is RelaxationStatus.RELAXED
        assert exactness(fit.mesh) <= 1e-12
        freedom[rigid] = np.linalg.svd(fold_matrix(fit.mesh), compute_uv=False)[::-1]
    assert fold_matrix(fit.mesh).shape[0] >= fold_matrix(fit.mesh).shape[1]
    assert freedom[True][0] < 1e-12
    assert freedom[True][1] > 1e-4
    assert freedom[False][0] > 1e-5


def test_the_folds_of_a_rigid_sheet_keep_their_ratios():
    """At a flat-foldable vertex opposite creases fold by one angle, and tan of half the angles of
    both pairs have a ratio of the sectors alone: if that fits around every face in one state, it
    fits in all (Tachi 2009)."""
    target, sheet = bump_sheet(0.2)
    mesh = relaxed_sheet(target, sheet, Wishes(rigid=True)).mesh
    coords, faces = mesh.vertices_coords, mesh.faces_vertices
    inner = hinges(faces)
    fold = dict(
        zip(
            map(tuple, np.sort(inner[:, :2], axis=1).tolist()),
            hinge_angles(coords, inner),
            strict=True,
        )
    )
    rings = vertex_rings(faces, len(coords))
    angles = np.array([[fold[min(v, w), max(v, w)] for w in ring] for v, *ring in rings.tolist()])
    np.testing.assert_allclose(np.abs(angles[:, 0]), np.abs(angles[:, 2]), atol=1e-11)
    np.testing.assert_allclose(np.abs(angles[:, 1]), np.abs(angles[:, 3]), atol=1e-11)
    spokes = coords[rings[:, 1:]] - coords[rings[:, :1]]
    size = np.linalg.norm(spokes, axis=2)
    cosine = np.vecdot(spokes, np.roll(spokes, -1, axis=1)) / (size * np.roll(size, -1, axis=1))
    a, b = np.arccos(cosine[:, 0]), np.arccos(cosine[:, 1])
    ratio = np.abs(np.tan(angles[:, 1] / 2) / np.tan(angles[:, 0] / 2))
    plus, minus = (
        np.abs(np.cos((a + b) / 2) / np.cos((a - b) / 2)),
        np.abs(np.sin((a - b) / 2) / np.sin((a + b) / 2)),
    )
    near = [np.minimum(np.abs(ratio / m - 1), np.abs(ratio * m - 1)) for m in (plus, minus)]
    assert np.minimum(*near).max() < 1e-9


def test_the_rigid_sheet_follows_its_surface_only_about():
    target, sheet = bump_sheet(0.2)
    off = [
        np.abs(relaxed_sheet(target, sheet, Wishes(rigid=rigid)).deviations).mean()
        for rigid in (False, True)
    ]
    assert off[0] < off[1] < 0.08


def test_folds_keep_to_their_bound():
    target, sheet = bump_sheet(0.5)
    steep = {}
    for most in (None, np.radians(150)):
        mesh = relaxed_sheet(target, sheet, Wishes(most_fold=most)).mesh
        folds = np.abs(hinge_angles(mesh.vertices_coords, hinges(mesh.faces_vertices)))
        steep[most] = np.degrees(folds.max())
    assert steep[None] > 155
    assert steep[np.radians(150)] < 153


def test_the_bound_of_folds_is_what_keeps_a_fine_sheet_from_crossing_itself():
    target, sheet = bump_sheet(1.0, 24)
    assert crossings(relaxed_sheet(target, sheet).mesh) == 0
    assert crossings(relaxed_sheet(target, sheet, Wishes(most_fold=None)).mesh) > 0


_SCRIPT = """
import sys
sys.path.insert(0, {tests!r})
from relaxed_surfaces import bump_sheet
from solver.relaxation import relaxed_sheet
import hashlib
mesh = relaxed_sheet(*bump_sheet(0.5, 40)).mesh
print(hashlib.sha256(mesh.vertices_coords.tobytes()).hexdigest())
"""


def test_the_same_bits_every_time_with_any_number_of_threads():
    script = _SCRIPT.format(tests=str(ROOT / "tests"))
    found = set()
    for threads in ("1", "2"):
        names = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "RAYON_NUM_THREADS")
        environment = os.environ | dict.fromkeys(names, threads)
        done = subprocess.run(
            [sys.executable, "-c", script],
            capture_output=True,
            text=True,
            check=True,
            env=environment,
            cwd=ROOT,
        )
        found.add(done.stdout.strip())
    assert len(found) == 1
    assert len(found.pop()) == 64


def test_super_lu_leads_to_a_sheet_as_good(monkeypatch):
    """Rounding differs, and the search stops while the soft terms still gain a little."""
    target, sheet = bump_sheet(0.5)
    usual = relaxed_sheet(target, sheet)
    monkeypatch.setitem(sys.modules, "rslab", None)
    other = relaxed_sheet(target, sheet)
    assert other.relaxation.status is RelaxationStatus.RELAXED
    assert exactness(other.mesh) <= 1e-12
    off, wanted = np.abs(other.deviations).mean(), np.abs(usual.deviations).mean()
    assert off == pytest.approx(wanted, rel=0.2)


def test_an_interrupted_search_keeps_its_best():
    target, sheet = hemisphere()
    seen = []
    fit = relaxed_sheet(
        target,
        sheet,
        progress=lambda number, residual: seen.append((number, residual)),
        interrupted=lambda: len(seen) >= 12,
    )
    relaxed = fit.relaxation
    assert relaxed.status is RelaxationStatus.STOPPED
    assert "12 rounds" in relaxed.advice
    assert [number for number, _ in seen] == list(range(1, 13))
    assert relaxed.history[1:] == tuple(residual for _, residual in seen)
    assert relaxed.hard_residual == relaxed.history[-1] < relaxed.history[0]
    # the search can be taken up again from there
    again = relaxed_sheet(target, sheet, start=relaxed.coords)
    assert again.relaxation.status is RelaxationStatus.RELAXED


def test_too_few_rounds_are_reported():
    fit = relaxed_sheet(*hemisphere(), rounds=3)
    assert fit.relaxation.status is RelaxationStatus.NOT_CONVERGED
    assert fit.relaxation.rounds == 3
    assert "After 3 rounds" in fit.relaxation.advice


def test_what_cannot_be_exact_is_stuck():
    """Five squares around a vertex with all their sides and diagonals: its sectors are fixed."""
    angle = np.arange(5) * 2 * np.pi / 5
    spokes = np.column_stack([np.cos(angle), np.sin(angle), 0.3 * (-1.0) ** np.arange(5)])
    corners = spokes + np.roll(spokes, -1, axis=0)
    coords = np.concatenate([np.zeros((1, 3)), spokes, corners])
    i = np.arange(5)
    faces = np.stack([0 * i, 1 + i, 6 + i, 1 + (i + 1) % 5], axis=1)
    pairs = np.concatenate([faces[:, [0, 1]], faces[:, [1, 3]]])
    fixed = SideLengths(pairs, np.repeat([1.0, np.sqrt(2)], 5))
    relaxed = relax(coords, [DevelopableVertices.of(faces, 11), fixed], [], 1.0)
    assert relaxed.status in (RelaxationStatus.STUCK, RelaxationStatus.NOT_CONVERGED)
    assert relaxed.hard_residual > 0.01
    assert "larger cell" in relaxed.advice


def test_vertices_without_a_nearest_point_are_refused():
    class Lost(Sphere):
        def distance(self, points, guess):
            distance, normal, places = super().distance(points, guess)
            return np.where(np.arange(len(points)) == 7, np.nan, distance), normal, places

    sheet = hemisphere(8)[1]
    with pytest.raises(
        InvalidState, match=r"1 of \d+ residuals of SurfaceOffsets .* vertices \[7\]"
    ):
        relaxed_sheet(Lost(), sheet)


def test_bad_arguments_are_refused():
    mesh, soft = miura()
    with pytest.raises(InvalidValue, match="step"):
        relax(mesh.vertices_coords, hard_terms(mesh), soft, 0.0)
    with pytest.raises(InvalidValue, match="vertices of a term"):
        relax(mesh.vertices_coords[:-1], hard_terms(mesh), soft, 1.0)
    with pytest.raises(InvalidValue, match="zigzag"):
        pleated_patch(Sphere(), 10, zigzag=-1.0, spacing=1.0, thickness=1.0)
    with pytest.raises(InvalidValue, match="be even around a tube"):
        pleated_tube(VASE, 9, 4, zigzag=1.0, thickness=1.0)
    sheet = bump_sheet(0.5)[1]
    with pytest.raises(InvalidValue, match="both have shape"):
        PleatedSheet(sheet.base, sheet.swing[1:], sheet.cell)


def test_pleated_sheets_are_flat_miura_sheets_over_a_plane():
    """A sheet over a plane with the cell's own lengths meets all terms from the start."""
    plane = bump(0.0)
    sheet = pleated_patch(plane, 12, zigzag=1.5, spacing=1.2, thickness=1.2, stretch=1.0)
    fit = relaxed_sheet(plane, sheet)
    assert fit.relaxation.rounds == 0
    assert np.abs(fit.deviations).max() < 1e-12
    for values in fit.relaxation.soft_values:
        assert np.abs(values).max() < 1e-12


@pytest.mark.parametrize("case", [lambda: bump_sheet(0.0, 24), vase_tube])
def test_prolongation_keeps_linear_moves_and_halves_alternating_ones(case):
    target, fine = case()
    half = fine.halved()
    rows = half.shape[0]
    assert half.cell.step == pytest.approx(2 * fine.cell.step, rel=0.1)
    signs, again = half.parities, fine.parities
    smooth, alternating = np.array([0.1, 0.2, 0.3]), np.array([0.01, 0.02, 0.03])
    down = np.linspace(0, 1, rows)[:, None, None]
    moved = down * smooth + signs[0][:, :, None] * alternating
    start = prolonged(half, half.points(target) + moved.reshape(-1, 3), fine, target)
    share = fine.cell.along / half.cell.along
    wanted = np.linspace(0, 1, fine.shape[0])[:, None, None] * smooth
    wanted = wanted + share * again[0][:, :, None] * alternating
    np.testing.assert_allclose(start - fine.points(target), wanted.reshape(-1, 3), atol=1e-12)


def test_coarse_starts_save_rounds_on_the_fine_sheet():
    target, sheet = bump_sheet(0.5, 44)
    begun = relaxed_sheet(target, sheet)
    alone = relaxed_sheet(target, sheet, start=sheet.points(target))
    assert begun.relaxation.rounds < alone.relaxation.rounds
    assert np.abs(begun.deviations).mean() <= 1.05 * np.abs(alone.deviations).mean()


@pytest.mark.parametrize(("case", "straight"), [(hemisphere, 73), (vase_tube, 37)])
def test_steps_that_follow_the_bend_of_the_constraints_are_fewer(case, straight):
    """Than those along their tangents alone, of which as many were counted."""
    fit = relaxed_sheet(*case())
    assert fit.relaxation.status is RelaxationStatus.RELAXED
    assert fit.relaxation.rounds <= 0.8 * straight
