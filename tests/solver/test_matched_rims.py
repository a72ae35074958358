"""Sheets of one surface whose rims are brought together."""

import numpy as np
import trimesh
from surface_meshes import mesh_of

from solver import developability, planarity
from solver.matched_rims import met_rims
from solver.mesh import interior_vertices
from solver.nearest_pairs import nearest_pairs
from solver.relaxation.constraints import MeetingVertices
from solver.surface_sheets import surface_sheets


def rim_points(sheets):
    """Vertices at the rims of sheets, coordinates and faces, and the sheet of each."""
    found = []
    for coords, faces in sheets:
        used = np.bincount(faces.ravel(), minlength=len(coords)) > 0
        found.append(coords[used & ~interior_vertices(faces, len(coords))])
    return np.concatenate(found), np.repeat(np.arange(len(found)), [len(each) for each in found])


def test_vertices_of_two_sheets_of_a_body_meet_and_both_stay_exact(monkeypatch):
    ball = trimesh.creation.icosphere(4, 1.0)
    body = mesh_of((np.array(ball.vertices) * [1.0, 0.8, 0.6], np.array(ball.faces)))
    given = []

    def spied(target, sheets, *choices):
        given.append([(sheet.coords, sheet.faces_vertices) for sheet in sheets])
        return met_rims(target, sheets, *choices)

    monkeypatch.setattr("solver.sheets_meeting.met_rims", spied)
    found = surface_sheets(body, 16)
    assert len(found.sheets) == 2
    assert found.good
    assert found.coverage > 0.99
    assert not len(nearest_pairs(*rim_points(given[0]), 1e-9))  # each alone they do not meet
    made = [(each.mesh.vertices_coords, each.mesh.faces_vertices) for each in found.sheets]
    points, sheet = rim_points(made)
    assert len(nearest_pairs(points, sheet, 1e-9)) > 0.15 * len(points)
    for each, mesh in zip(found.sheets, made, strict=True):
        assert planarity(*mesh).max() < 1e-12
        assert developability(*mesh).max() < 1e-12
        assert each.crossings == 0
        assert each.distance < 1.6 * (each.step / 2 + 0.15 * each.step)


def test_differences_of_vertices_that_meet_have_exact_gradients():
    coords = np.random.default_rng(2).normal(size=(5, 3))
    term = MeetingVertices.of(np.array([[0, 3], [4, 1]]), 0.5)
    move = np.random.default_rng(3).normal(size=coords.shape)
    here, there = term.linearised(coords), term.linearised(coords + move)
    slope = np.einsum("nvc,nvc->n", here.gradients, move[term.vertices])
    np.testing.assert_allclose(there.values - here.values, slope, atol=1e-12)  # they are linear
