"""Surfaces that people make: a dome, a vase, a bowl, and the like, to relax sheets onto.

z is upwards. Those that close around do so where u = -1 meets u = 1.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from solver.targets.base import Target
from solver.targets.parametric import ParametricSurface
from solver.vectors import FloatArray

__all__ = ["SHELLS"]


def _disc(u: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The square of the parameters as the unit disc, by ellipses."""
    return u * np.sqrt(1 - v**2 / 2), v * np.sqrt(1 - u**2 / 2)


def _dome(u: FloatArray, v: FloatArray) -> FloatArray:
    """Half a sphere of radius 1; distances from its top are kept."""
    x, y = _disc(u, v)
    angle = np.pi / 2 * np.hypot(x, y)
    shrunk = np.pi / 2 * np.sinc(angle / np.pi)
    return np.column_stack([shrunk * x, shrunk * y, np.cos(angle)])


def _bowl(u: FloatArray, v: FloatArray) -> FloatArray:
    """Flat at its bottom, 65 degrees steep at its rim of radius 1."""
    x, y = _disc(u, v)
    return np.column_stack([x, y, 0.7 * np.hypot(x, y) ** 3])


def _turned(
    radius: Callable[[FloatArray], FloatArray], half_height: float
) -> Callable[[FloatArray, FloatArray], FloatArray]:
    """Closed around the z axis, its normals outwards, open at both ends."""

    def position(u: FloatArray, v: FloatArray) -> FloatArray:
        r = radius(v)
        return np.column_stack([r * np.cos(np.pi * u), r * np.sin(np.pi * u), half_height * v])

    return position


def _bonnet(u: FloatArray, v: FloatArray) -> FloatArray:
    """Rounded across, lower and narrower at its front (u = 1), with a raised middle."""
    sides = 0.3 * np.abs(v) ** 3
    middle = 0.08 * np.exp(-((v / 0.45) ** 4)) * (1 - 0.5 * u)
    return np.column_stack(
        [1.2 * u, v * (1 - 0.12 * u), 0.3 - 0.07 * (1 + u) ** 2 - sides + middle]
    )


def _canopy(u: FloatArray, v: FloatArray) -> FloatArray:
    """A shell roof that stands on its four corners, with an arch between each two."""
    a = 0.45 * np.pi
    return np.column_stack([1.2 * u, v, 0.6 * np.cos(a * u) + 0.5 * np.cos(a * v)])


def _helmet(u: FloatArray, v: FloatArray) -> FloatArray:
    """Longer than wide, down to the neck at its back (u = -1), higher over the brow (u = 1)."""
    x, y = _disc(u, v)
    radius = np.hypot(x, y)
    along = np.pi / 2 - 0.22 - 0.1 * x
    down = along * radius
    flat = along * np.sinc(down / np.pi)
    return np.column_stack([1.15 * flat * x, 0.95 * flat * y, np.cos(down)])


def _wall_relief(u: FloatArray, v: FloatArray) -> FloatArray:
    """Dunes: ridges that bend as they cross the wall, and flatten out."""
    ridges = np.sin(4.2 * u + 1.1 * np.sin(1.8 * v + 0.4))
    return np.column_stack([1.5 * u, v, 0.14 * ridges * (1 - 0.35 * u * v)])


def _acoustic_panel(u: FloatArray, v: FloatArray) -> FloatArray:
    """A shallow vault, which scatters sound that comes from the room below it or before it."""
    return np.column_stack([1.3 * u, v, -0.16 * u**2 - 0.05 * v**2])


SHELLS: dict[str, Target] = {
    "acoustic_panel": ParametricSurface(_acoustic_panel),
    "bonnet": ParametricSurface(_bonnet),
    "bowl": ParametricSurface(_bowl),
    "canopy": ParametricSurface(_canopy),
    "dome": ParametricSurface(_dome),
    "helmet": ParametricSurface(_helmet),
    "lamp_shade": ParametricSurface(_turned(lambda v: 0.75 - 0.3 * v + 0.08 * v**2, 0.8)),
    "wall_relief": ParametricSurface(_wall_relief),
    "vase": ParametricSurface(_turned(lambda v: 0.6 + 0.2 * np.cos(0.9 * np.pi * (v + 0.3)), 1.3)),
}
