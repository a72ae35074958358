"""The designs of the paper against published models and closed forms."""

import numpy as np
import pytest
from helpers import published

from solver import (
    Crumpled,
    CurvedFold,
    Front,
    InvalidValue,
    Miura,
    Status,
    developability,
    flap_angle_of,
    planarity,
    seeds,
)
from solver.arcs import contain
from solver.vectors import norm


def test_curved_fold_is_the_published_f4d():
    mesh = CurvedFold().grow().mesh
    assert np.abs(mesh.vertices_coords - published("F4D", "fold").reshape(-1, 3)).max() < 1e-12
    assert planarity(mesh.vertices_coords, mesh.faces_vertices).max() < 1e-14
    assert developability(mesh.vertices_coords, mesh.faces_vertices).max() < 1e-13


def test_the_crumpled_sheets_seed_is_that_of_the_published_f4e():
    rows = published("F4E", "fold")
    seed = seeds.corrugated(20, 0.6 * np.pi, 1.2 * np.pi, norm(rows[1] - rows[0]))
    assert np.abs(seed.vertices_coords - rows[:2].reshape(-1, 3)).max() < 1e-15


def test_every_strip_of_the_published_f4e_is_drawn_by_the_printed_recipe():
    """Flap angles clear of the union of crossings; lengths X (1 - k/2 pi)^2, X in (0.1 L, 0.9 L).

    L is one for all creases of a strip, the least distance at which neighbours meet, at most 2.
    """
    rows = published("F4E", "fold")
    shares = []
    for j in range(1, 40):
        front = Front.between(rows[j], rows[j - 1])
        length = norm(rows[j + 1] - rows[j])
        onward = (rows[j + 1] - rows[j]) / length[:, None]
        u = front.edges_direction
        flap_angle = flap_angle_of(-u[:1], u[1:2], onward[1:2])
        assert contain(front.free_flap_angles(), flap_angle).all()
        least = min(front.rays(float(flap_angle[0])).length_bounds.min(), 2.0)
        k = np.concatenate([front.k[:1], front.k, front.k[-1:]])
        shares.append(length / (1 - k / (2 * np.pi)) ** 2 / least)
    assert 0.1 < np.min(shares) < 0.101
    assert 0.899 < np.max(shares) < 0.9


def test_crumpled_sheets_as_printed_have_one_length_limit_a_strip_and_cross_no_old_face():
    mesh = Crumpled(random_seed=5, strips=12, as_printed=True).grow().mesh
    rows = mesh.vertices_coords[mesh.grid]
    assert planarity(mesh.vertices_coords, mesh.faces_vertices).max() < 1e-12
    assert developability(mesh.vertices_coords, mesh.faces_vertices).max() < 1e-12
    shares = []
    for j in range(1, 12):
        front = Front.between(rows[j], rows[j - 1])
        length = norm(rows[j + 1] - rows[j])
        onward = (rows[j + 1] - rows[j]) / length[:, None]
        u = front.edges_direction
        flap_angle = flap_angle_of(-u[:1], u[1:2], onward[1:2])
        rays = front.rays(float(flap_angle[0]))
        assert not front.self_intersections(rays.flap_angles[:, None]).any()
        k = np.concatenate([front.k[:1], front.k, front.k[-1:]])
        least = min(rays.length_bounds.min(), 2.0)
        shares.append(length / (1 - k / (2 * np.pi)) ** 2 / least)
    assert np.min(shares) == pytest.approx(0.1, abs=0.02)
    assert np.max(shares) == pytest.approx(0.9, abs=0.02)


def test_a_printed_recipe_without_a_free_flap_angle_stops_with_advice(monkeypatch):
    monkeypatch.setattr(Front, "free_flap_angles", lambda front: np.empty((0, 2)))
    growth = Crumpled(strips=3, as_printed=True).grow()
    assert (growth.status, growth.strips) == (Status.FACES_CROSS, 0)
    assert "as_printed = false" in growth.advice


def test_the_zigzag_of_s37_as_printed_is_the_mirror_image_of_the_models():
    """The models' vertices swing upwards first; the printed sign has them swing downwards."""
    model = published("F4D", "fold")[0]
    printed = CurvedFold(zigzag=-0.05, strips=1).grow().mesh
    row = printed.vertices_coords[printed.grid[0]]
    x = -1.0 + 0.02 * np.arange(101)
    assert (model[:, 1] + row[:, 1]) / 2 == pytest.approx(x**2, abs=1e-15)
    assert (np.sign(model[:, 1] - x**2) == (-1.0) ** np.arange(101)).all()


@pytest.mark.parametrize("columns", [2, 7, 60])
@pytest.mark.parametrize("fold_deg", [5.0, 45.0, 85.0])
def test_miura_is_the_exact_miura_ori(columns, fold_deg):
    gamma, fold, rows = np.radians(65), np.radians(fold_deg), 40
    design = Miura(columns, rows, gamma, fold, zigzag_length=1.2, crease_length=0.7)
    mesh = design.grow().mesh
    lean = np.sqrt(1 - (np.sin(fold) * np.sin(gamma)) ** 2)
    j, i = np.mgrid[: rows + 1, : columns + 1]
    exact = np.stack(
        [
            i * 1.2 * np.cos(fold) * np.sin(gamma) / lean,
            j * 0.7 * lean + (i % 2) * 1.2 * np.cos(gamma) / lean,
            (j % 2) * 0.7 * np.sin(fold) * np.sin(gamma),
        ],
        axis=-1,
    )
    assert np.abs(mesh.vertices_coords[mesh.grid] - exact).max() < 1e-7
    assert planarity(mesh.vertices_coords, mesh.faces_vertices).max() < 1e-12
    assert developability(mesh.vertices_coords, mesh.faces_vertices).max() < 1e-12


def test_crumpled_repeats_with_its_seed_and_changes_with_another():
    one, again, other = (Crumpled(random_seed=s, strips=6).grow().mesh for s in (3, 3, 4))
    assert (one.vertices_coords == again.vertices_coords).all()
    assert not np.allclose(one.vertices_coords, other.vertices_coords)


@pytest.mark.parametrize("random_seed", range(8))
def test_crumpled_sheets_of_any_seed_are_sheets(random_seed):
    growth = Crumpled(random_seed=random_seed).grow()
    mesh = growth.mesh
    assert growth.strips == 39
    assert planarity(mesh.vertices_coords, mesh.faces_vertices).max() < 1e-10
    assert developability(mesh.vertices_coords, mesh.faces_vertices).max() < 1e-10


def test_crumpled_creases_shrink_with_the_power():
    mean = [
        norm(np.diff(m.vertices_coords[m.grid], axis=0)).mean()
        for m in (Crumpled(power=p, strips=12).grow().mesh for p in (0.0, 1.0, 2.0))
    ]
    assert mean[0] > 1.5 * mean[1] > 2.2 * mean[2]


@pytest.mark.parametrize(
    ("design", "name"),
    [
        (CurvedFold(columns=1), "columns"),
        (CurvedFold(zigzag=0.0), "zigzag"),
        (CurvedFold(zigzag=np.nan), "zigzag"),
        (CurvedFold(step=-1.0), "step"),
        (CurvedFold(crease_length=0.0), "crease_length"),
        (CurvedFold(strips=0), "strips"),
        (CurvedFold(k=7.0), r"k\[0\]"),
        (Miura(rows=1), "rows"),
        (Miura(columns=1), "columns"),
        (Miura(fold=0.0), "fold"),
        (Miura(fold=np.pi / 2), "fold"),
        (Miura(sector_angle=2.0), "sector_angle"),
        (Miura(zigzag_length=-1.0), "zigzag_length"),
        (Miura(crease_length=np.inf), "crease_length"),
        (Crumpled(beta=0.0), "beta"),
        (Crumpled(beta=3.0, k=2.0), "k"),
        (Crumpled(strips=1), "strips"),
        (Crumpled(power=-1.0), "power"),
        (Crumpled(seed_deviation=np.nan), "seed_deviation"),
        (Crumpled(length_limit=0.0), "length_limit"),
        (Crumpled(random_seed=-1), "random_seed"),
        (Crumpled(columns=10**30), "columns"),
        (Crumpled(columns=6.0), "columns"),
        (Crumpled(columns="6"), "columns"),
        (Crumpled(strips=True), "strips"),
        (Crumpled(random_seed=0.5), "random_seed"),
        (Crumpled(beta=None), "beta"),
        (Crumpled(k="1"), "k"),
        (Crumpled(power="2"), "power"),
        (CurvedFold(zigzag="0.1"), "zigzag"),
        (CurvedFold(flap_angle=None), "flap_angle"),
        (CurvedFold(flap_angle=np.array([1.0, 2.0])), "flap_angle"),
        (CurvedFold(crease_length=[0.1]), "crease_length"),
        (Miura(sector_angle=1j), "sector_angle"),
        (Miura(sector_angle=1e-300), "front"),
        (CurvedFold(strips=900_000), "quads to grow"),
        (Miura(zigzag_length=1e300), "zigzag_length"),
    ],
)
def test_parameters_out_of_bounds_are_named(design, name):
    with pytest.raises(InvalidValue, match=name):
        design.grow()
