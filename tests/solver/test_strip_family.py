"""A strip as a function of its flap angle, against strips that are grown."""

from itertools import pairwise

import numpy as np
import pytest

from fab.pattern.crease_pattern import fold_angles_deg
from solver import Crumpled, CurvedFold, Front, Side, seeds
from solver.arcs import contain
from solver.strip_family import special_at_first, strip_family
from solver.vertex_family import special_flap_angles


@pytest.fixture
def mesh():
    return Crumpled(columns=6, strips=3, random_seed=7).grow().mesh


def test_folds_are_those_of_grown_strips(mesh):
    front = Front.of(mesh, Side.TOP)
    trials = np.linspace(0.1, 6.2, 9)
    family = strip_family(front, trials)
    for n, trial in enumerate(trials):
        rays = front.rays(trial)
        np.testing.assert_allclose(family.directions[:, n], rays.directions[1:-1], atol=1e-12)
        np.testing.assert_allclose(
            np.sin(family.vertices_flap_angle[:, n]), np.sin(rays.flap_angles), atol=1e-12
        )
        grown = mesh.extended(Side.TOP, rays.row(0.3 * np.minimum(rays.length_bounds, 1))[None])
        angles = fold_angles_deg(grown.vertices_coords, grown.edges, *grown.polygons)
        pairs = [tuple(sorted(pair)) for pair in grown.edges.edges_vertices.tolist()]
        angle = dict(zip(pairs, angles, strict=True))
        x, z = grown.grid[-2].tolist(), grown.grid[-1].tolist()
        front_folds = [angle[tuple(sorted(pair))] for pair in pairwise(x)]
        crease_folds = [angle[tuple(sorted(pair))] for pair in zip(x[1:-1], z[1:-1], strict=True)]
        np.testing.assert_allclose(np.degrees(family.front_folds[:, n]), front_folds, atol=1e-9)
        np.testing.assert_allclose(np.degrees(family.crease_folds[:, n]), crease_folds, atol=1e-9)


def test_free_flap_angles_are_what_no_vertex_forbids(mesh):
    front = Front.of(mesh, Side.TOP)
    family = strip_family(front, np.linspace(1e-3, 6.282, 1000))
    crossing = front.self_intersections(family.vertices_flap_angle)
    inside = np.stack([contain(arcs, family.flap_angles) for arcs in family.crossing])
    np.testing.assert_array_equal(inside, crossing)
    np.testing.assert_array_equal(contain(family.free, family.flap_angles), ~crossing.any(axis=0))


def test_special_choices_are_carried_to_the_first_vertex(mesh):
    front = Front.of(mesh, Side.TOP)
    own = special_flap_angles(front)
    for name, firsts in special_at_first(front).items():
        wanted = np.column_stack(own[name])
        assert firsts.shape == wanted.shape
        for vertex, choice in zip(*np.nonzero(np.isfinite(wanted)), strict=True):
            flaps = strip_family(front, firsts[vertex, [choice]]).vertices_flap_angle
            miss = flaps[vertex, 0] - wanted[vertex, choice]
            assert abs(np.remainder(miss + np.pi, 2 * np.pi) - np.pi) < 1e-9


def test_a_front_that_is_a_curve_has_no_folds_along_it():
    curve = CurvedFold(columns=6, strips=1).grow().mesh.vertices_coords[:7]
    front = Front.of(seeds.curve(curve), Side.TOP, 1.04 * np.pi)
    family = strip_family(front, 5)
    assert np.isnan(family.front_folds).all()
    assert np.isfinite(family.crease_folds).all()
    assert family.crossing.shape == (0, 2, 2)
    np.testing.assert_array_equal(family.free, [[0, 2 * np.pi]])
    assert set(special_at_first(front)) == {"equal angles"}
