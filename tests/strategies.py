"""Random geometry for the property tests."""

from __future__ import annotations

import numpy as np
from hypothesis import assume
from hypothesis import strategies as st

from solver import CurvedFold, Front, InvalidValue, QuadMesh, Side, Strip, grow, seeds
from solver.vectors import angle_between

unit_floats = st.floats(0.0, 1.0)


@st.composite
def vertices(draw):
    """A degree-4 vertex: beta, k inside their intervals (5 % away from the ends), a flap angle."""
    beta = draw(st.floats(0.1, np.pi - 0.1))
    share = draw(st.floats(0.05, 0.95))
    k = beta + share * (2 * np.pi - 2 * beta)
    flap_angle = draw(st.floats(0.0, 2 * np.pi, exclude_max=True))
    return beta, k, flap_angle


@st.composite
def frames(draw):
    """Unit vectors a, b at a given angle, in random orientation: a function of beta."""
    seed = draw(st.integers(0, 2**32 - 1))
    rotation, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    rotation *= np.sign(np.linalg.det(rotation))

    def of(beta: float) -> tuple[np.ndarray, np.ndarray]:
        a = rotation @ np.array([1.0, 0.0, 0.0])
        b = rotation @ np.array([np.cos(beta), np.sin(beta), 0.0])
        return a[None], b[None]

    return of


@st.composite
def patches(draw):
    """A folded patch grown from a curve."""
    design = CurvedFold(
        columns=draw(st.integers(3, 9)),
        step=draw(st.floats(0.05, 0.2)),
        zigzag=draw(st.floats(0.03, 0.2)),
        k=np.radians(draw(st.floats(176.0, 184.0))),
        flap_angle=np.radians(draw(st.floats(110.0, 250.0))),
        crease_length=draw(st.floats(0.01, 0.05)),
        strips=draw(st.integers(1, 5)),
    )
    try:
        mesh: QuadMesh = design.grow().mesh
    except InvalidValue:
        assume(False)
    return mesh


@st.composite
def curves(draw):
    """A random zigzag in space and its k: a front that is only a curve, (m + 1, 3) and (m - 1,).

    Every vertex turns, and k stays 5 % of its interval away from the ends.
    """
    columns = draw(st.integers(2, 12))
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    points = np.zeros((columns + 1, 3))
    points[:, 0] = np.arange(columns + 1)
    points[:, 1] = 0.7 * (np.arange(columns + 1) % 2)
    points += random.uniform(-0.4, 0.4, points.shape)
    edges = np.diff(points, axis=0)
    beta = angle_between(-edges[:-1], edges[1:])
    assume((np.sin(beta) > 0.1).all())
    return points, beta + random.uniform(0.05, 0.95, columns - 1) * (2 * np.pi - 2 * beta)


@st.composite
def fronts(draw):
    """The front of a grown patch, or a random curve in space."""
    if draw(st.booleans()):
        return Front.on_curve(*draw(curves()))
    return Front.of(draw(patches()), Side.TOP)


@st.composite
def sheets(draw):
    """Up to four strips grown from a random curve, each at a random flap angle."""
    points, k = draw(curves())
    flap_angles = draw(st.lists(st.floats(0.1, 6.18), min_size=2, max_size=4))

    def choose(_front, strip):
        return Strip(flap_angles[strip], lambda rays: np.minimum(0.3 * rays.length_bounds, 0.5))

    return grow(seeds.curve(points), len(flap_angles), choose, k=k).mesh
