"""Triangle meshes of surfaces of every kind, for tests."""

import locale
from contextlib import contextmanager

import numpy as np

from solver.targets.surface_mesh import SurfaceMesh


@contextmanager
def writing_3mf():
    """Keep the locale: lib3mf sets another one, by which later tests would read text as ASCII."""
    before = locale.setlocale(locale.LC_ALL)
    try:
        yield
    finally:
        locale.setlocale(locale.LC_ALL, before)


def grid(f, nu=24, nv=24, *, u=(-1, 1), v=(-1, 1), around=(False, False), twisted=False):
    """Vertices and triangles of f(u, v); `around` closes u or v, twisted with v turned over."""
    us = np.linspace(*u, nu + 1)[: nu + (not around[0])]
    vs = np.linspace(*v, nv + 1)[: nv + (not around[1])]
    uu, vv = np.meshgrid(us, vs, indexing="ij")
    number = np.arange(uu.size).reshape(uu.shape)
    if around[0]:
        first = number[:1, ::-1] if twisted else number[:1]
        number = np.concatenate([number, first])
    if around[1]:
        number = np.concatenate([number, number[:, :1]], axis=1)
    a, b, c, d = (
        part.ravel()
        for part in (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:])
    )
    faces = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    return np.stack(f(uu, vv), axis=-1).reshape(-1, 3), faces


def disc(f, rings=16, sectors=48):
    """Vertices and triangles of f(x, y) over the unit disc."""
    r, t = np.meshgrid(
        np.linspace(0, 1, rings + 1)[1:], 2 * np.pi * np.arange(sectors) / sectors, indexing="ij"
    )
    x = np.concatenate([[0.0], (r * np.cos(t)).ravel()])
    y = np.concatenate([[0.0], (r * np.sin(t)).ravel()])
    number = 1 + np.arange(rings * sectors).reshape(rings, sectors)
    number = np.concatenate([number, number[:, :1]], axis=1)
    fan = np.column_stack([np.zeros(sectors, int), number[0, :-1], number[0, 1:]])
    a, b, c, d = (
        part.ravel()
        for part in (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:])
    )
    ring = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    return np.column_stack(f(x, y)), np.concatenate([fan, ring])


def cap(half_angle, rings=16, sectors=48):
    """A cap of the unit sphere, its half angle in radians."""

    def on_sphere(x, y):
        r = np.hypot(x, y)
        over = np.sin(half_angle * r) / np.where(r > 0, r, 1)
        return x * over, y * over, np.cos(half_angle * r)

    return disc(on_sphere, rings, sectors)


def vase(nu=48, nv=24):
    """A vase of revolution with a waist, both of its ends open."""

    def f(u, v):
        radius = 0.7 + 0.25 * np.sin(2.2 * v + 0.4)
        return radius * np.cos(u), radius * np.sin(u), v

    return grid(f, nu, nv, u=(0, 2 * np.pi), v=(-1.4, 1.4), around=(True, False))


def torus(nu=48, nv=24, major=2.0, minor=0.8):
    def f(u, v):
        out = major + minor * np.cos(v)
        return out * np.cos(u), out * np.sin(u), minor * np.sin(v)

    return grid(f, nu, nv, u=(0, 2 * np.pi), v=(0, 2 * np.pi), around=(True, True))


def moebius(nu=96, nv=8):
    def f(u, v):
        out = 1 + 0.3 * v * np.cos(u / 2)
        return out * np.cos(u), out * np.sin(u), 0.3 * v * np.sin(u / 2)

    return grid(f, nu, nv, u=(0, 2 * np.pi), around=(True, False), twisted=True)


def dome_with_holes():
    """A flat dome with three holes."""
    coords, faces = grid(lambda u, v: (u, v, 0.45 * (1 - 0.7 * u * u - 0.7 * v * v)), 40, 40)
    middle = coords[faces].mean(axis=1)
    inside = np.zeros(len(faces), bool)
    for x, y, r in ((0.4, 0.35, 0.2), (-0.45, 0.1, 0.22), (0.1, -0.5, 0.18)):
        inside |= np.hypot(middle[:, 0] - x, middle[:, 1] - y) < r
    return packed(coords, faces[~inside])


def packed(coords, faces):
    """Without the vertices that no face uses."""
    used, number = np.unique(faces, return_inverse=True)
    return coords[used], number.reshape(-1, 3)


def mesh_of(arrays):
    return SurfaceMesh.of(*arrays)
