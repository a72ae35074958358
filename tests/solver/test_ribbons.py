"""Ribbons that lie flat on a chosen curve: the choice of k is the choice of the flat front."""

import numpy as np
import pytest

from fab.pattern.development import develop
from solver import InvalidValue, ShapedRibbon, developability, planarity
from solver.designs import shaped_ribbon
from solver.designs.shaped_ribbon import OUTLINES, chords
from solver.vectors import norm


def turned_onto(points: np.ndarray, target: np.ndarray) -> np.ndarray:
    """Complex `points` moved onto `target` by the best rotation and shift."""
    a, b = points - points.mean(), target - target.mean()
    turn = np.vdot(a, b)
    return a * turn / abs(turn) + target.mean()


def offset_from(outline: str, points: np.ndarray) -> np.ndarray:
    """How far complex points of the plane miss the curve's own equation, relative to its slope."""
    if outline == "ellipse":
        return points.real**2 + (points.imag / 0.6) ** 2 - 1
    if outline == "wave":
        return points.imag - 1.5 * np.sin(points.real)
    reach = 4 * np.pi  # of the spiral's angle, measured by its radius
    return np.abs(np.exp(1j * (np.angle(points) - reach * (np.abs(points) - 0.4))) - 1)


@pytest.mark.parametrize("outline", OUTLINES)
@pytest.mark.parametrize(("steps", "accuracy"), [(16, 1e-13), (400, 1e-11), (2000, 1e-10)])
def test_ribbons_lie_flat_on_their_outline(outline, steps, accuracy):
    mesh = ShapedRibbon(outline, steps).grow().mesh
    coords, faces = mesh.vertices_coords, mesh.faces_vertices
    assert len(faces) == steps
    assert planarity(coords, faces).max() < 1e-12
    assert developability(coords, faces).max() == 0  # a strip has no inner vertex
    development = develop(mesh)
    assert development.isometry_max_rel < 1e-10
    assert len(development.overlaps) == 0
    wanted = chords(OUTLINES[outline], norm(np.diff(coords[mesh.grid[0]], axis=0)))
    assert np.abs(offset_from(outline, wanted)).max() < 1e-13
    flat = development.vertices_coords @ [1, 1j]
    front = flat[mesh.grid[0]]
    scale = np.abs(np.diff(wanted)).sum() / np.abs(np.diff(front)).sum()
    assert np.abs(turned_onto(front * scale, wanted) - wanted).max() < accuracy


def test_the_new_row_runs_beside_the_outline_at_one_distance():
    mesh = ShapedRibbon("wave", 40, random_seed=3).grow().mesh
    flat = develop(mesh).vertices_coords @ [1, 1j]
    front, row = flat[mesh.grid]
    along = np.diff(front)
    bisector = 1j * (along[1:] / np.abs(along[1:]) + along[:-1] / np.abs(along[:-1]))
    width = ((row - front)[1:-1] / (bisector / np.abs(bisector))).real
    assert np.ptp(width) < 1e-12
    assert width.min() > 0


@pytest.mark.parametrize("outline", OUTLINES)
def test_chords_of_any_ratios_reach_from_end_to_end(outline):
    sizes = np.random.default_rng(5).uniform(0.5, 1.5, 200)
    points = chords(OUTLINES[outline], sizes)
    assert np.ptp(np.log(np.abs(np.diff(points)) / sizes)) < 1e-12
    assert points[[0, -1]] == pytest.approx(OUTLINES[outline](np.array([0.0, 1.0]))[0])


def test_chords_of_a_circle_subtend_their_own_angles():
    turn = 5.0
    points = chords(
        lambda t: (np.exp(1j * turn * t), 1j * turn * np.exp(1j * turn * t)), np.ones(50)
    )
    assert points == pytest.approx(np.exp(1j * turn * np.arange(51) / 50), abs=1e-13)


@pytest.mark.parametrize(
    ("design", "name"),
    [
        (ShapedRibbon(outline="star"), "outline = star .* ellipse, spiral, wave"),
        (ShapedRibbon(steps=2), "steps"),
        (ShapedRibbon(width_share=1.0), "width_share"),
        (ShapedRibbon(random_seed=-1), "random_seed"),
    ],
)
def test_parameters_out_of_bounds_are_named(design, name):
    with pytest.raises(InvalidValue, match=name):
        design.grow()


def test_walks_without_room_to_fold_are_drawn_anew_and_given_up_with_the_cure(monkeypatch):
    design = ShapedRibbon("spiral", steps=8)
    assert len(design.grow().mesh.faces_vertices) == 8
    monkeypatch.setattr(shaped_ribbon, "_DRAWS", 1)
    with pytest.raises(InvalidValue, match=r"of 8 steps has room to fold .* Use more steps"):
        design.grow()
