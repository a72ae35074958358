"""Strips and sheets whose shape under load is known, and these shapes."""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from fab.pattern.crease_pattern import CreasePattern
from solver.mesh import edges_of


def quads(columns, rows, width, height, letter="J") -> CreasePattern:
    """A rectangle of equal quads; letter : of the edges between them."""
    x, y = np.linspace(0, width, columns + 1), np.linspace(0, height, rows + 1)
    coords = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    number = np.arange(len(coords)).reshape(rows + 1, columns + 1)
    faces = np.stack(
        [number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]], axis=-1
    ).reshape(-1, 4)
    offsets = 4 * np.arange(len(faces) + 1)
    edges = edges_of(faces.ravel(), offsets)
    letters = np.where(edges.edges_faces[:, 1] < 0, "B", letter)
    return CreasePattern(
        coords,
        edges.edges_vertices,
        edges.edges_faces,
        letters,
        np.zeros(len(letters)),
        faces.ravel(),
        offsets,
    )


def _shot(slopes, length, moment):
    """Ends (theta, curvature, x, z) of rods from a clamp, whose free end has no moment."""

    def end(curvature):
        made = solve_ivp(
            slopes, (0, length), [0, curvature, 0, 0], rtol=1e-11, atol=1e-13, method="DOP853"
        )
        return made.y[:, -1]

    return end(brentq(lambda k: end(k)[1], 0, moment, xtol=1e-13))


def elastica(stiffness, length, tip=0.0, line=0.0):
    """Tip (x, z down) of a cantilever under a force at its tip and one along its length.

    stiffness : E I. tip : N; line : N per length. EI theta'' = -(P + q (L - s)) cos(theta).
    """

    def slopes(s, state):
        theta, curvature = state[:2]
        pull = tip + line * (length - s)
        return [curvature, -pull * np.cos(theta) / stiffness, np.cos(theta), np.sin(theta)]

    return _shot(slopes, length, 2 * (tip + line * length) * length / stiffness)[2:]


def follower_elastica(stiffness, length, line):
    """Tip (x, z) of a cantilever under a force along its length that stays normal to it.

    The shear force is the normal part of that beyond: with the force from s to the end as
    (x(L) - x(s), ...) turned by a quarter, EI theta'' = -q (r(L) - r(s)) . t(s). Found by iteration
    over its tip.
    """
    at = np.array([length, 0.0])
    for _ in range(200):

        def slopes(s, state, at=at):
            theta, curvature, x, z = state
            along = np.array([np.cos(theta), np.sin(theta)])
            shear = line * float((at - [x, z]) @ along)
            return [curvature, -shear / stiffness, along[0], along[1]]

        found = _shot(slopes, length, 2 * line * length**2 / stiffness)[2:]
        if np.abs(found - at).max() < 1e-12 * length:
            break
        at = found
    return found


def chain_between(links, length, span):
    """Nodes (x, z) of a chain of equal links of equal weight hung between two points.

    Each node carries one weight: tan(phi_i) = c (i - (n - 1) / 2), c from the span.
    """
    place = np.arange(links) - (links - 1) / 2

    def directions(c):
        angle = np.arctan(c * place)
        return np.stack([np.cos(angle), np.sin(angle)], axis=1)

    def missed(c):
        return directions(c)[:, 0].sum() * length / links - span

    c = brentq(missed, 1e-9, 1e3, xtol=1e-15)
    return np.concatenate([[[0.0, 0.0]], np.cumsum(directions(c) * length / links, axis=0)])


def arc_between(links, length, span):
    """Nodes (x, z) of a chain of equal links on a circle between two points, upwards."""

    def turned(half):
        return np.sin(links * half) / np.sin(half) * length / links - span

    half = brentq(turned, 1e-6, np.pi / links, xtol=1e-15)
    angle = half * (links - 1 - 2 * np.arange(links))
    steps = np.stack([np.cos(angle), np.sin(angle)], axis=1) * length / links
    return np.concatenate([[[0.0, 0.0]], np.cumsum(steps, axis=0)])
