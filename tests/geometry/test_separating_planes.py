"""Planes between bodies never claim more than their exact distance."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fab.geometry.bodies import bodies_of, stacked
from fab.geometry.booleans import manifolds
from fab.geometry.separating_planes import apart_along, apart_at_least, near_pairs


def boxes(corners, sizes):
    square = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])
    parts = []
    for (x, y, z), (a, b, c) in zip(corners, sizes, strict=True):
        ring = square * [a, b] + [x, y]
        solid = stacked(np.stack([ring, ring], axis=1), np.array([0, 4]), np.array([z, z + c]))
        parts.append(solid.mesh(0))
    return bodies_of(parts)


def turned(bodies, seed):
    """Each body turned about its own place at random."""
    rng = np.random.default_rng(seed)
    turns, _ = np.linalg.qr(rng.normal(size=(len(bodies), 3, 3)))
    turns[:, :, 0] *= np.linalg.det(turns)[:, None]
    return bodies.moved(turns, rng.normal(size=(len(bodies), 3)))


@given(st.integers(0, 10_000))
@settings(max_examples=40, deadline=None)
def test_planes_never_claim_more_than_the_exact_distance(seed):
    rng = np.random.default_rng(seed)
    bodies = turned(boxes(rng.uniform(-2, 2, (12, 3)), rng.uniform(0.1, 1.5, (12, 3))), seed)
    pairs = np.array([(i, j) for i in range(12) for j in range(i + 1, 12)])
    solids = manifolds(bodies)
    exact = np.array([solids[i].min_gap(solids[j], 100.0) for i, j in pairs.tolist()])
    bound = apart_at_least(bodies, pairs, np.full(len(pairs), np.inf))
    assert (bound <= exact + 1e-9).all()
    # and they decide nearly all that is to be decided
    apart = exact > 0.05
    assert (bound[apart] > 0.5 * exact[apart]).mean() > 0.95
    normals = rng.normal(size=(len(pairs), 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    assert (apart_along(bodies, pairs, normals) <= exact + 1e-9).all()
    overlap = np.array([(solids[i] ^ solids[j]).volume() for i, j in pairs.tolist()])
    assert (bound[overlap > 1e-9] < 0).all()
    reach = 0.3
    near = {tuple(pair) for pair in near_pairs(bodies, reach).tolist()}
    assert {tuple(p) for p in pairs[exact < reach].tolist()} <= near
    low, high = bodies.boxes()
    wide = ((low[:, None] <= high + reach) & (low <= high[:, None] + reach)).all(axis=2)
    assert near == {tuple(p) for p in pairs.tolist() if wide[tuple(p)]}


def test_planes_between_boxes_are_exact():
    bodies = boxes([[0, 0, 0], [1.5, 0, 0], [0.25, 0.5, 0.75]], [[1, 1, 1]] * 3)
    pairs = np.array([[0, 1], [0, 2], [1, 2]])
    apart = apart_at_least(bodies, pairs, np.array([0.5, 1.0, 1.0]))
    assert apart[:2] == pytest.approx([0.5, -0.25])
    assert apart_along(bodies, pairs[:1], np.array([[np.nan] * 3])).tolist() == [-np.inf]
    assert near_pairs(bodies, 0.4).tolist() == [[0, 2], [1, 2]]
    assert near_pairs(bodies, 0.6).tolist() == [[0, 1], [0, 2], [1, 2]]
    assert near_pairs(boxes([], []), 1.0).shape == (0, 2)
