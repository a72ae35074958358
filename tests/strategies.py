"""Random geometry for the property tests."""

from __future__ import annotations

import numpy as np
from hypothesis import assume
from hypothesis import strategies as st

from solver import CurvedFold, InvalidValue, QuadMesh

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
