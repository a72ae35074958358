"""Panels that are alike: found whatever way they lie, and drawn to few templates."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from solver import Miura
from solver.panel_shapes import PanelCount, PanelShapes, different_shapes, shape_lengths
from solver.relaxation.goal_terms import AlikePanels


def polygons(count, corners, seed):
    """Polygons of random shapes, shape (count, corners, 2)."""
    angles = 2 * np.pi * np.arange(corners) / corners
    ring = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return ring + np.random.default_rng(seed).normal(size=(count, corners, 2)) / 5


def moved(polygon, seed):
    """The polygon from another corner, turned and shifted, perhaps turned over."""
    rng = np.random.default_rng(seed)
    angle = rng.uniform(0, 2 * np.pi)
    c, s = np.cos(angle), np.sin(angle)
    out = np.roll(polygon, rng.integers(len(polygon)), axis=0) @ np.array([[c, s], [-s, c]])
    return out[::-1] * [1, -1] if rng.integers(2) else out[:: rng.choice([-1, 1])] + rng.normal()


@given(st.integers(3, 7), st.integers(0, 10_000))
def test_a_panel_is_alike_however_it_lies(corners, seed):
    shapes = polygons(3, corners, seed)
    every = np.stack([moved(shapes[k % 3], seed + k) for k in range(12)])
    lengths = shape_lengths(every)
    assert different_shapes(lengths, 1e-9).tolist() == [0, 1, 2] * 4
    found = PanelShapes.of(lengths, 3)
    assert found.unlike(lengths).max() < 1e-9
    assert len(set(found.nearest(lengths)[:3].tolist())) == 3


def test_no_panel_is_farther_from_its_template_than_it_may_be():
    lengths = shape_lengths(polygons(300, 4, 5))
    before = 301
    for within in (0.0, 0.1, 0.3, 0.6, 2.0):
        template = different_shapes(lengths, within)
        assert (template[template] == template).all()
        count = len(np.unique(template))
        best = PanelShapes(lengths[np.unique(template)])
        assert best.unlike(lengths).max() <= within + 1e-8
        assert count < before
        before = count
    assert before == 1


def test_a_miura_sheet_has_panels_of_one_shape():
    mesh = Miura(columns=6, rows=5).grow().mesh
    lengths = shape_lengths(mesh.vertices_coords[mesh.faces_vertices])
    assert not different_shapes(lengths, 1e-12).any()
    longer = lengths * np.where(np.arange(len(lengths)) < 7, 1.0, 1.01)[:, None]
    assert np.unique(different_shapes(longer, 1e-3)).tolist() == [0, 7]
    assert not different_shapes(longer, 0.1).any()


def test_templates_lie_in_the_middle_of_their_panels():
    """Two clusters of known radius are found, and templates are as near as can be."""
    two = shape_lengths(polygons(2, 4, 1))
    off = np.linspace(-0.01, 0.01, 9)
    lengths = np.concatenate([one + off[:, None] for one in two])
    found = PanelShapes.of(lengths, 2)
    assert found.unlike(lengths).max() == pytest.approx(0.01)
    # the ends of either cluster are farther from each other than from a template
    assert len(np.unique(different_shapes(lengths, 0.0101))) > 2
    assert PanelShapes.of(lengths, 40).unlike(lengths).max() == 0
    known = PanelCount(2, 0.01, PanelShapes(two))
    assert known.templates(lengths).templates is two


def quads(*wide):
    """Vertices and faces of quads that share nothing and have no symmetry."""
    corners = [[[0, 0, k], [w, 0, k], [w, 1.7, k], [0, 1, k]] for k, w in enumerate(wide)]
    return np.array(corners, float).reshape(-1, 3), np.arange(4 * len(wide)).reshape(-1, 4)


def test_gradients_of_alike_panels_are_differences():
    coords, faces = quads(3.0, 4.0, 4.0)
    mean = shape_lengths(coords[faces]).mean(axis=0)
    # the middle between the extremes would be farther from most: the template stays where it is
    term = AlikePanels.of(faces, PanelShapes(mean[None]), 0.1, 0.5)
    here = term.linearised(coords)
    assert here.term.shapes is term.shapes
    assert here.values[[0, 8, 16]] == pytest.approx([-17 / 15, 7 / 15, 7 / 15])
    rng = np.random.default_rng(3)
    for _ in range(5):
        move = rng.normal(size=coords.shape)
        ahead, behind = (term.linearised(coords + s * 1e-6 * move).values for s in (1, -1))
        slope = np.einsum("nvc,nvc->n", here.gradients, move[term.vertices])
        np.testing.assert_allclose((ahead - behind) / 2e-6, slope, atol=1e-8)


def test_templates_follow_their_panels_and_let_alone_what_is_within():
    coords, faces = quads(1.0, 1.2, 3.0, 3.4)
    off = PanelShapes(shape_lengths(quads(1.5, 3.1)[0].reshape(2, 4, 3)))
    near = AlikePanels.of(faces, off, 0.05, 1.0).linearised(coords)
    wide = np.sort(near.term.shapes.templates[:, 0])
    assert wide == pytest.approx([1.1, 3.2])
    assert np.abs(near.values.reshape(4, 8)[:, 0]) == pytest.approx([0.05, 0.05, 0.15, 0.15])
    wider = AlikePanels.of(faces, off, 0.21, 1.0).linearised(coords)
    assert not wider.values.any()
    assert not wider.gradients.any()
