"""Surfaces with formulas as triangles: closed where their sides meet, open elsewhere."""

import numpy as np
import pytest

from solver.designs.surface_fit import SURFACES
from solver.errors import InvalidState
from solver.relaxed_fit import sampled
from solver.targets.parametric import ParametricSurface
from solver.targets.surface_mesh import MeshKind


def around(u, v):
    return np.cos(np.pi * u), np.sin(np.pi * u)


def torus(u, v):
    c, s = around(u, v)
    r = 2 + 0.5 * np.cos(np.pi * v)
    return np.column_stack([r * c, r * s, 0.5 * np.sin(np.pi * v)])


def ball(u, v):
    c, s = around(u, v)
    r = np.cos(np.pi / 2 * v)
    return np.column_stack([r * c, r * s, np.sin(np.pi / 2 * v)])


def cap(u, v):  # v = 1 is the pole, v = -1 the equator
    return ball(u, (v + 1) / 2)


def moebius(u, v):
    c, s = around(u, v)
    r = 1 + 0.3 * v * np.cos(np.pi / 2 * u)
    return np.column_stack([r * c, r * s, 0.3 * v * np.sin(np.pi / 2 * u)])


def tube(u, v):
    c, s = around(u, v)
    return np.column_stack([c, s, v])


def slit(u, v):  # a tube whose sides are a hair apart
    return tube(u * (1 - 1e-4), v)


@pytest.mark.parametrize(
    ("position", "kind", "area"),
    [
        (tube, MeshKind.RING, 4 * np.pi),
        (slit, MeshKind.DISC, 4 * np.pi),
        (torus, MeshKind.TORUS, 4 * np.pi**2),
        (ball, MeshKind.SPHERE, 4 * np.pi),
        (cap, MeshKind.DISC, 2 * np.pi),
        (moebius, MeshKind.MOEBIUS, None),
    ],
)
def test_surfaces_that_close_on_themselves_are_closed(position, kind, area):
    mesh = sampled(ParametricSurface(position))
    assert mesh.kind is kind
    if area is not None:  # facets are inside by less than the square of their angle
        assert area * (1 - 0.002) < mesh.area <= area * (1 + 1e-9)


def test_the_side_that_normals_are_on_is_that_of_the_formula():
    mesh = sampled(ParametricSurface(tube))
    corners = mesh.vertices_coords[mesh.faces_vertices]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert ((normals * corners.mean(axis=1))[:, :2].sum(axis=1) > 0).all()


def test_parts_within_a_domain_are_kept_and_the_largest_piece_is_taken():
    def flat(u, v):
        return np.column_stack([u, v, 0 * u])

    mesh = sampled(ParametricSurface(flat, within=lambda u, v: (u < -0.5) | (u > 0)))
    assert mesh.kind is MeshKind.DISC
    assert mesh.vertices_coords[:, 0].min() > 0
    assert mesh.area == pytest.approx(2 * (1 - 1 / 48))
    with pytest.raises(InvalidState, match="no part of it"):
        sampled(ParametricSurface(flat, within=lambda u, v: u > 2))


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("acoustic_panel", MeshKind.DISC),
        ("bonnet", MeshKind.DISC),
        ("bowl", MeshKind.DISC),
        ("canopy", MeshKind.DISC),
        ("dome", MeshKind.DISC),
        ("helmet", MeshKind.DISC),
        ("lamp_shade", MeshKind.RING),
        ("vase", MeshKind.RING),
        ("wall_relief", MeshKind.DISC),
    ],
)
def test_named_shells_have_their_kind(name, kind):
    assert sampled(SURFACES[name]).kind is kind


def test_the_dome_is_half_a_sphere():
    mesh = sampled(SURFACES["dome"])
    assert np.linalg.norm(mesh.vertices_coords, axis=1) == pytest.approx(1.0)
    assert mesh.vertices_coords[mesh.boundary_loops[0], 2] == pytest.approx(0.0, abs=1e-12)
    assert mesh.area == pytest.approx(2 * np.pi, rel=1e-3)
