"""Goals of makers: what they measure, and terms that hold them."""

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from relaxed_surfaces import bump_sheet, vase_tube

from solver import InvalidValue, Miura, QuadMesh
from solver.goals import Bounds, Goals, PanelRoom, face_measures
from solver.incircles import incircles
from solver.panel_shapes import PanelCount
from solver.quad_hinges import side_hinges
from solver.relaxation import relaxed_sheet
from solver.relaxation.goal_terms import LeastRooms, LeastSectors

seeds = st.integers(0, 2**32 - 1)


def quads(seed, count=20):
    """Convex quads in the plane, counterclockwise."""
    rng = np.random.default_rng(seed)
    angles = np.sort(rng.uniform(0, np.pi / 2, (count, 4)) * 0.9 + np.arange(4) * np.pi / 2, axis=1)
    flat = np.stack([np.cos(angles), np.sin(angles)], axis=-1) * rng.uniform(0.5, 2, (count, 1, 1))
    return flat @ np.diag(rng.uniform(0.5, 2, 2))


def in_space(flat, seed):
    turn, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    turn[:, 2] *= np.linalg.det(turn)
    return np.concatenate([flat, np.zeros((*flat.shape[:2], 1))], axis=2) @ turn.T + [3.0, 1, 2]


@given(seeds)
def test_the_widest_circle_is_that_of_another_library(seed):
    flat = quads(seed)
    found = incircles(in_space(flat, seed), np.zeros((len(flat), 4)))
    wanted = [
        shapely.maximum_inscribed_circle(shapely.Polygon(quad), tolerance=1e-7).length
        for quad in flat
    ]
    np.testing.assert_allclose(found.radii, wanted, rtol=1e-6)
    np.testing.assert_allclose(found.weights.sum(axis=1), 1.0)


def test_a_circle_behind_setbacks():
    square = np.array([[[0.0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 4, 0]]])
    for back, radius in (
        ([1.0, 1, 1, 1], 1.0),
        ([1.0, 0, 0, 0], 1.5),
        ([0.0, 1, 0, 2], 0.5),
        ([3.0, 0, 3, 0], -1.0),
    ):
        assert incircles(square, np.array([back])).radii[0] == pytest.approx(radius, abs=1e-12)
    point = np.zeros((1, 4, 3))
    assert incircles(point, np.zeros((1, 4))).radii[0] == 0.0


@given(seeds)
def test_circles_change_as_their_gradients_say(seed):
    corners = in_space(quads(seed), seed)
    rng = np.random.default_rng(seed)
    back = rng.uniform(0, 0.1, corners.shape[:2])
    here = incircles(corners, back)
    move, more, step = rng.normal(size=corners.shape), rng.normal(size=back.shape), 1e-6
    ahead = incircles(corners + step * move, back + step * more)
    behind = incircles(corners - step * move, back - step * more)
    change = (ahead.radii - behind.radii) / (2 * step)
    slope = (here.gradients * move).sum(axis=(1, 2)) - (here.weights * more).sum(axis=1)
    # where circles touch all four sides, the three that bound them change
    smooth = ((ahead.weights > 0) == (behind.weights > 0)).all(axis=1)
    assert smooth.mean() > 0.8
    np.testing.assert_allclose(change[smooth], slope[smooth], atol=1e-5, rtol=1e-5)


def room(least, thickness=0.06):
    def setbacks(angles):  # bevels of the side that closes, at two heights
        slope = thickness * np.tan(np.minimum(np.abs(angles), 3.0) / 2)
        return np.stack([0.05 + slope / 2 * (angles < 0), 0.05 + slope * (angles > 0)])

    return PanelRoom(setbacks, least)


def miura(closed=False):
    if not closed:
        return Miura(columns=4, rows=3).grow().mesh
    angle = np.arange(8) * np.pi / 4
    ring = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    rows = ring + np.arange(4)[:, None, None] * np.array([0, 0, 1.0])
    return QuadMesh.from_rows(rows, closed=True)


@pytest.mark.parametrize("made", [lambda: bump_sheet(0.3, 10), vase_tube], ids=["patch", "tube"])
def test_gradients_of_the_terms_are_differences(made):
    """On a sheet with planar faces, none of which is a parallelogram."""
    surface, sheet = made()
    mesh = relaxed_sheet(surface, sheet).mesh
    faces, coords = mesh.faces_vertices, mesh.vertices_coords
    size = float(np.linalg.norm(coords[faces[:, 1]] - coords[faces[:, 0]], axis=1).mean())
    rng = np.random.default_rng(1)
    for term in (
        LeastSectors.of(faces, 1.6),
        LeastRooms.of(faces, len(coords), room(size, 0.2 * size), size),
    ):
        here = term.linearised(coords)
        assert np.count_nonzero(here.values) > 100
        dense = np.zeros((len(here.values), len(coords) + 1, 3))
        rows = np.arange(len(here.values))[:, None]
        there = (term.vertices >= 0)[..., None]
        assert not here.gradients[~there[..., 0]].any()
        np.add.at(dense, (rows, term.vertices), np.where(there, here.gradients, 0))
        for _ in range(5):
            move, step = rng.normal(size=coords.shape), 1e-6 * size
            ahead = term.linearised(coords + step * move).values
            behind = term.linearised(coords - step * move).values
            slope = np.einsum("nvc,vc->n", dense[:, :-1], move)
            smooth = np.abs(ahead + behind - 2 * here.values) < 1e-9
            assert smooth.mean() > 0.95  # elsewhere the circle comes to touch another side
            change = (ahead - behind) / (2 * step)
            np.testing.assert_allclose(change[smooth], slope[smooth], atol=1e-4 / size, rtol=1e-4)


def test_sectors_are_negative_where_sides_cross_and_reflex_behind_a_diagonal():
    beyond, angles = np.linspace(-1.0, 0.4, 8), []
    for x in beyond:
        quad = np.array([[x, 0, 0], [0, -1, 0], [2, 0.0, 0], [0, 1, 0]])
        angles.append(LeastSectors(np.array([[0, 1, 2, 3]]), 4.0).linearised(quad).values[0] + 4.0)
    np.testing.assert_allclose(angles, 2 * np.arctan2(1, -beyond))
    bow = np.array([[0.0, 0, 0], [2, 0, 0], [0, 1, 0], [2.5, 1.5, 0]])
    values = LeastSectors.of(np.array([[0, 1, 2, 3]]), 0.3).linearised(bow).values + 0.3
    assert (values < 0).sum() == 2


def test_measures_are_those_of_a_miura_sheet():
    mesh = Miura(columns=4, rows=3, sector_angle=np.pi / 3, fold=np.pi / 4).grow().mesh
    coords, faces = mesh.vertices_coords, mesh.faces_vertices
    found = face_measures(coords, faces, room(0.1))
    lengths = [
        np.linalg.norm(coords[faces[:, k]] - coords[faces[:, k - 1]], axis=1) for k in (1, 2)
    ]
    np.testing.assert_allclose(found.side, np.min(lengths, axis=0))
    heights = np.min(lengths, axis=0).max() * np.sin(np.pi / 3)
    np.testing.assert_allclose(found.inradius, heights / 2)
    np.testing.assert_allclose(found.sector, np.pi / 3)
    assert found.most_fold == pytest.approx(np.pi / 2)
    assert (found.room < found.inradius).all()


def test_hinges_of_sides_have_the_same_ends():
    mesh = miura(closed=True)
    hinges, beside = side_hinges(mesh.faces_vertices, len(mesh.vertices_coords))
    ends = np.stack([mesh.faces_vertices, np.roll(mesh.faces_vertices, -1, axis=1)], axis=-1)
    inner = beside >= 0
    assert (np.sort(hinges[beside[inner], :2]) == np.sort(ends[inner])).all()
    assert np.bincount(beside[inner]).tolist() == [2] * len(hinges)


def test_misses_are_shares_of_bounds():
    mesh = Miura(columns=4, rows=3, sector_angle=np.pi / 3, fold=np.pi / 4).grow().mesh
    coords, faces = mesh.vertices_coords, mesh.faces_vertices
    found = face_measures(coords, faces, room(0.5))
    side, radius, space = (float(x.min()) for x in (found.side, found.inradius, found.room))
    met = Bounds(side, radius, np.pi / 3, np.pi / 2, room(space))
    assert not met.misses(found).any()
    assert met.fine(found).all()
    over = Bounds(2 * side, 4 * radius, np.pi / 2, np.pi / 4, room(2 * space))
    np.testing.assert_allclose(over.misses(found), [0.5, 0.75, 1 / 3, 1 / 3, 0.5, 0])
    assert not over.fine(found).any()
    beyond = over.beyond(found, over)
    assert beyond.least_side > 3 * side
    assert beyond.least_sector > np.pi / 2 + np.pi / 6
    assert np.pi / 8 <= beyond.most_fold < np.pi / 4
    assert beyond.panels.radius > 3 * space
    again = over.beyond(found, beyond)
    assert again.least_side - beyond.least_side == pytest.approx(beyond.least_side - 2 * side)
    assert met.beyond(found, beyond).least_side == beyond.least_side
    halfway = over.beyond(found, beyond, 0.5)
    assert halfway.least_side == pytest.approx(1.5 * side)
    assert halfway.most_fold == pytest.approx(3 * np.pi / 8)
    assert met.beyond(found, beyond, 0.5).least_side == side
    assert not Bounds().misses(found).any()


def test_bounds_that_half_of_the_faces_are_far_from_are_out_of_reach():
    mesh = Miura(columns=4, rows=3).grow().mesh
    found = face_measures(mesh.vertices_coords, mesh.faces_vertices, room(0.1))
    side, space = float(np.median(found.side)), float(np.median(found.room))
    near = Bounds(least_side=1.4 * side, least_sector=1.5, panels=room(1.4 * space))
    assert not near.out_of_reach(found)
    for bounds in (
        Bounds(least_side=1.5 * side),
        Bounds(least_inradius=1.5 * float(np.median(found.inradius))),
        Bounds(panels=room(1.5 * space)),
    ):
        assert bounds.out_of_reach(found)
        assert bounds.far(found)
    assert not Bounds(least_side=1.2 * side).far(found)
    assert Bounds(most_fold=np.pi / 8).far(found)


def test_panels_that_differ_from_their_templates_are_missed_and_aimed_at():
    coords = np.array([[0.0, 0, 0], [2, 0, 0], [5, 0, 0], [0, 2, 0], [2, 2, 0], [5, 2, 0]])
    faces = np.array([[0, 1, 4, 3], [1, 2, 5, 4]])
    wanted = Bounds(alike=PanelCount(1, 0.125))
    found = wanted.measures(coords, faces)
    np.testing.assert_allclose(found.unlike, 0.5)  # sides of 2 and 3, and a template of 2.5
    np.testing.assert_allclose(wanted.misses(found), [0, 0, 0, 0, 0, 0.75])
    assert not wanted.fine(found).any()
    assert wanted.beyond(found, Bounds()).alike.within == 0.0625  # no nearer than half of it
    assert wanted.beyond(found, Bounds(), 0.5).alike.within == 0.3125
    enough = Bounds(alike=PanelCount(1, 0.5))
    assert not enough.misses(enough.measures(coords, faces)).any()
    square = wanted.with_templates(coords[:, [0, 1, 2]], faces[:1])
    np.testing.assert_allclose(square.measures(coords, faces).unlike[0], 0.0)
    assert square.faces_fine(coords, faces).tolist() == [True, False]
    assert Goals(wanted).of(miura(), coords, larger=2.0).alike.within == 0.25
    assert Goals(wanted).angles() == Bounds()


def test_lengths_of_goals_are_in_the_unit_of_the_sheet():
    mesh = miura()
    goals = Goals(
        Bounds(2.0, 1.0, 0.5, 2.0, room(3.0)), unit=lambda sheet, folded: np.ptp(folded[:, 0])
    )
    wide = float(np.ptp(mesh.vertices_coords[:, 0]))
    found = goals.of(mesh, mesh.vertices_coords, larger=2.0)
    assert (found.least_side, found.least_inradius) == pytest.approx((4 * wide, 2 * wide))
    assert (found.least_sector, found.most_fold) == (0.5, 2.0)
    assert found.panels.radius == pytest.approx(6 * wide)
    np.testing.assert_allclose(
        found.panels.at(np.ones(2)), 2 * wide * goals.bounds.panels.at(np.ones(2))
    )
    assert goals.angles() == Bounds(least_sector=0.5, most_fold=2.0)
    for bad in (Bounds(least_side=-1.0), Bounds(least_sector=2.0), Bounds(most_fold=4.0)):
        with pytest.raises(InvalidValue):
            Goals(bad)
