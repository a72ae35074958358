"""The designs of the paper against published models and closed forms."""

import numpy as np
import pytest
from helpers import published

from solver import Crumpled, CurvedFold, InvalidValue, Miura, developability, planarity, seeds
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
