"""Terms of relaxation: their gradients, and what they measure."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from relaxed_surfaces import Sphere, bump_sheet

from solver import Miura, QuadMesh, developability, planarity
from solver.hinge_angles import hinge_angles
from solver.measure import sector_angles
from solver.quad_hinges import hinges
from solver.relaxation import (
    DevelopableVertices,
    FlatFoldableVertices,
    FoldBounds,
    LeastDistances,
    PlanarFaces,
    SideLengths,
    SurfaceOffsets,
)
from solver.relaxation.neighbours import opposite_pairs, sides, vertex_rings
from solver.relaxation.sheet_fit import Wishes, sheet_terms

seeds = st.integers(0, 2**32 - 1)
# A corner of a cube: three faces around a vertex, each beside two others.
CUBE_FACES = np.array([[0, 1, 2, 3], [0, 4, 5, 1], [0, 3, 6, 4]])
CUBE = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1]])


def crumpled(seed, closed=False):
    """A Miura sheet, or a tube, with every vertex moved."""
    rng = np.random.default_rng(seed)
    if closed:
        angle = np.arange(6) * np.pi / 3
        ring = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
        rows = ring + np.arange(4)[:, None, None] * np.array([0, 0, 1.0])
        mesh = QuadMesh.from_rows(rows, closed=True)
    else:
        mesh = Miura(columns=4, rows=3).grow().mesh
    return mesh.vertices_coords + 0.1 * rng.normal(size=(len(mesh.vertices_coords), 3)), mesh


def terms(coords, faces, seed):
    rng = np.random.default_rng(seed)
    count = len(coords)
    pairs, edges = opposite_pairs(faces, count), sides(faces)
    held = np.arange(0, count, 2)
    unit = coords / np.linalg.norm(coords, axis=1)[:, None]
    return [
        PlanarFaces(faces),
        DevelopableVertices.of(faces, count),
        FlatFoldableVertices.of(faces, count),
        SideLengths(edges, 0.5 + rng.random(len(edges))),
        LeastDistances(pairs, 1 + 2 * rng.random(len(pairs))),
        FoldBounds.of(faces, coords, 0.2),
        SurfaceOffsets(Sphere(), held[:, None], rng.normal(size=len(held)), 0.3, unit[held, :2]),
    ]


@given(seeds, st.booleans())
def test_gradients_are_differences(seed, closed):
    coords, mesh = crumpled(seed, closed)
    coords = coords + np.array([3.0, 2.0, 4.0])  # away from the centre of the sphere
    step = 1e-6
    for term in terms(coords, mesh.faces_vertices, seed):
        here = term.linearised(coords)
        dense = np.zeros((len(here.values), len(coords) + 1, 3))
        rows = np.arange(len(here.values))[:, None]
        dense[rows, term.vertices] = np.where((term.vertices >= 0)[..., None], here.gradients, 0)
        rng = np.random.default_rng(seed)
        for _ in range(3):
            move = rng.normal(size=coords.shape)
            change = (
                term.linearised(coords + step * move).values
                - term.linearised(coords - step * move).values
            ) / (2 * step)
            slope = np.einsum("nvc,vc->n", dense[:, :-1], move)
            smooth = here.values != 0 if isinstance(term, LeastDistances | FoldBounds) else True
            np.testing.assert_allclose(
                np.where(smooth, change, 0), np.where(smooth, slope, 0), atol=2e-6, rtol=2e-6
            )


@given(seeds, st.booleans())
def test_hard_terms_vanish_where_the_measures_do(seed, closed):
    coords, mesh = crumpled(seed, closed)
    faces, count = mesh.faces_vertices, len(coords)
    term = DevelopableVertices.of(faces, count)
    sums = np.zeros(count)
    sums[term.vertices[:, 0]] = np.abs(term.linearised(coords).values)
    if np.all(sector_angles(coords, faces) < np.pi):
        np.testing.assert_allclose(sums, developability(coords, faces), atol=1e-13)
    # the triple product is the gap between the diagonals times the size of their cross product
    first, second = (coords[faces[:, k + 2]] - coords[faces[:, k]] for k in (0, 1))
    d, e = (np.linalg.norm(diagonal, axis=1) for diagonal in (first, second))
    gap = planarity(coords, faces) * np.maximum(d, e)
    area = np.linalg.norm(np.cross(first, second), axis=1)
    values = PlanarFaces(faces).linearised(coords).values
    np.testing.assert_allclose(np.abs(values), 4 * gap * area / (d**2 + e**2) ** 1.5, atol=1e-14)


def test_rings_are_those_of_grids_tubes_and_other_meshes():
    cube = vertex_rings(CUBE_FACES, 7)
    assert cube.tolist() == [[0, 1, 3, 4, -1]]
    assert np.isclose(DevelopableVertices(cube).linearised(CUBE).values[0], -np.pi / 2, atol=1e-15)
    assert len(FlatFoldableVertices.of(CUBE_FACES, 7).vertices) == 0
    tube = crumpled(0, closed=True)[1]
    rings = vertex_rings(tube.faces_vertices, 24)
    assert (rings[:, 0] == np.arange(6, 18)).all()
    at_seam = rings[rings[:, 0] == 6][0, 1:].tolist()
    start = at_seam.index(7)
    assert at_seam[start:] + at_seam[:start] == [7, 12, 11, 0]


def test_pairs_two_apart_are_those_of_the_grid():
    grid = np.arange(20).reshape(4, 5)
    mesh = QuadMesh.from_rows(np.random.default_rng(0).normal(size=(4, 5, 3)))
    pairs = opposite_pairs(mesh.faces_vertices, 20)
    wanted = [*zip(grid[:, :-2].ravel(), grid[:, 2:].ravel(), strict=True)]
    wanted += zip(grid[:-2].ravel(), grid[2:].ravel(), strict=True)
    assert sorted(map(tuple, np.sort(pairs, axis=1).tolist())) == sorted(wanted)
    tube = crumpled(0, closed=True)[1]
    assert len(opposite_pairs(tube.faces_vertices, 24)) == 4 * 6 + 2 * 6


def test_fold_angles_are_those_of_a_miura_sheet():
    """Creases along the rows fold by twice the fold of the faces; for the others tan(half the
    angle) is less by the cosine of the sector angle (Tachi 2009)."""
    mesh = Miura(columns=4, rows=4, sector_angle=np.pi / 3, fold=np.pi / 4).grow().mesh
    inner = hinges(mesh.faces_vertices)
    angles = np.abs(hinge_angles(mesh.vertices_coords, inner))
    rows = inner[:, 0] // 5 == inner[:, 1] // 5
    np.testing.assert_allclose(angles[rows], np.pi / 2, atol=1e-12)
    # tan of half the angles of a flat-foldable vertex are in the ratio cos(sector) (Tachi 2009)
    np.testing.assert_allclose(
        np.tan(angles[~rows] / 2), np.tan(np.pi / 4) * np.cos(np.pi / 3), atol=1e-12
    )


def test_a_fold_beyond_180_degrees_is_not_near_minus_180():
    """Two squares about a common edge, the second folded by 200 degrees: 20 degrees through the
    first."""
    coords = np.array([[0.0, 0, 0], [0, 1, 0], [1, 0, 0], [1, 1, 0], [0, 0, 0], [0, 0, 0]])
    faces = np.array([[0, 2, 3, 1], [4, 0, 1, 5]])
    folded = {}
    for turn in (120, 200):
        a = np.radians(turn)
        arm = np.array([-np.cos(a), 0, np.sin(a)])
        folded[turn] = coords.copy()
        folded[turn][4], folded[turn][5] = arm, arm + np.array([0, 1.0, 0])
    bound = FoldBounds.of(faces, folded[120], np.radians(160))
    assert bound.linearised(folded[120]).values.tolist() == [0.0]
    assert np.degrees(bound.linearised(folded[200]).values) == pytest.approx(40)
    assert np.degrees(hinge_angles(folded[200], bound.vertices)) == pytest.approx(-160)


def test_fold_angles_are_followed_through_all_turns():
    """A fold the other way, past 90, 180 and 270 degrees: the bound grows with no jump."""
    bound = None
    over = []
    for turn in range(30, -331, -15):
        a = np.radians(turn)
        arm = np.array([-np.cos(a), 0, np.sin(a)])
        coords = np.array([[0.0, 0, 0], [0, 1, 0], [1, 0, 0], [1, 1, 0], arm, arm + np.eye(3)[1]])
        bound = bound or FoldBounds.of(
            np.array([[0, 2, 3, 1], [4, 0, 1, 5]]), coords, np.radians(160)
        )
        linear = bound.linearised(coords)
        bound = linear.term
        over.append(float(np.degrees(linear.values[0])))
    assert over == pytest.approx([max(0, abs(turn) - 160) for turn in range(30, -331, -15)])


def test_folds_are_followed_from_where_a_relaxation_begins():
    """Though the pleats have been turned inside out since they were laid."""
    surface, sheet = bump_sheet(0.3, 10)
    laid = sheet.points(surface)
    inside_out = replace(sheet, swing=-sheet.swing).points(surface)
    for start in (None, inside_out):
        _, soft = sheet_terms(surface, sheet, Wishes(), start=start)
        (folds,) = [wish.term for wish in soft if isinstance(wish.term, FoldBounds)]
        begun = hinge_angles(laid if start is None else start, folds.vertices)
        np.testing.assert_array_equal(folds.angles, begun)
