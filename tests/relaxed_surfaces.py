"""Surfaces and sheets of the tests of relaxation."""

import numpy as np

from solver import ParametricSurface, explicit_surface
from solver.relaxation import pleated_patch, pleated_tube


class Sphere:
    """The unit sphere by stereographic projection: |uv| = 1 is the equator."""

    def places(self, uv):
        return uv

    def point(self, places):
        square = (places**2).sum(axis=1)
        return np.column_stack([2 * places, 1 - square]) / (1 + square)[:, None]

    normal = point

    def distance(self, points, guess):
        radius = np.linalg.norm(points, axis=1)
        normal = points / radius[:, None]
        return radius - 1, normal, normal[:, :2] / (1 + normal[:, 2:])

    def inside(self, places):
        return np.ones(len(places), bool)


def bump(height):
    return explicit_surface(lambda x, y: height * np.exp(-2 * (x * x + y * y)))


def _radius(v):
    return 0.5 + 0.18 * np.sin(np.pi * v)


def _slope(v):
    return 0.18 * np.pi * np.cos(np.pi * v)


def _vase(u, v):
    return np.column_stack([_radius(v) * np.cos(np.pi * u), _radius(v) * np.sin(np.pi * u), v])


def _vase_tangents(u, v):
    c, s = np.cos(np.pi * u), np.sin(np.pi * u)
    around = np.pi * _radius(v)[:, None] * np.column_stack([-s, c, 0 * u])
    return around, np.column_stack([_slope(v) * c, _slope(v) * s, 1 + 0 * u])


VASE = ParametricSurface(_vase, _vase_tangents)


def hemisphere(columns=24):
    """A square sheet over the whole hemisphere, its corners at 109 degrees from the pole."""
    sphere = Sphere()
    sizes = {"zigzag": 3.0, "spacing": 1.0, "thickness": 1.0, "stretch": 1.3}
    return sphere, pleated_patch(sphere, columns, **sizes)


def bump_sheet(height, columns=16, **sizes):
    surface = bump(height)
    sizes = {"zigzag": 1.5, "spacing": 1.2, "thickness": 1.2} | sizes
    return surface, pleated_patch(surface, columns, **sizes)


def vase_tube():
    return VASE, pleated_tube(VASE, 24, 16, zigzag=2.0, thickness=1.2)
