"""Bending of faces as elastic plates, each cut into triangles.

Each triangle is bent by a constant curvature, which the angles at its three sides give: at the
middle of a side the sheet's normal lies between those of both triangles, in proportion to their
heights (Grinspun, Gingold, Reisman and Zorin 2006, with normals that are not free). With sides e_i,
turned by a quarter t_i, and the angle phi_i from the triangle's normal to that at side i,

    K = sum_i phi_i / (A |e_i|) t_i t_i',    E = A D / 2 (nu tr(K)^2 + (1 - nu) tr(K^2)).

On any lattice of equal triangles this is exact for every constant curvature, in which a
bar-and-hinge model is up to three times too stiff. Where a side ends the plate (a border, a
crease), its angle is that of least energy: no moment acts across it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fab.folding.bar_hinge_model import Framework, wrapped
from solver.assembly import Blocks
from solver.graphs import EdgeIndex
from solver.hinge_angles import hinge_angles, hinge_gradients
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["PlateBending", "plate_bending"]


@dataclass(frozen=True)
class PlateBending:
    """Energy of bent faces, a potential (`fab.folding.potentials`).

    Attributes
    ----------
    hinges_vertices : shape (nh, 4), sides within plates, as those of a framework.
    sides : shape (nt, 3), the hinge at each side of each triangle; -1 where the plate ends.
    stiffness : shape (nt, 3, 3): the energy is half the square of the angles at the sides in it.
    shapes : shape (nt, 3, 2, 2), curvature of each triangle for an angle of 1 rad at a side.
    vertices : shape (nt, 6), all that the angles of a triangle depend on; -1 for none.
    places : shape (nt, 3, 4), of each hinge's vertices among the six.
    """

    hinges_vertices: IntArray
    sides: IntArray
    stiffness: FloatArray
    shapes: FloatArray
    vertices: IntArray
    places: IntArray

    def energy(self, coords: FloatArray) -> float:
        """At coords, shape (nv, 3), relative to the size of the framework."""
        angles = self._angles(coords)
        return float(np.einsum("ti,tij,tj->", angles, self.stiffness, angles)) / 2

    def linearised(self, coords: FloatArray) -> tuple[FloatArray, list[Blocks]]:
        """Gradient, shape (nv, 3), and Gauss-Newton curvature."""
        angles = self._angles(coords)
        moments = np.einsum("tij,tj->ti", self.stiffness, angles)
        slopes = np.zeros((len(self.sides), 3, 6, 3))
        every = hinge_gradients(coords, self.hinges_vertices)
        triangle = np.arange(len(self.sides))
        for side in range(3):
            hinge = self.sides[:, side]
            own = np.where((hinge >= 0)[:, None, None], every[hinge], 0.0)
            for corner in range(4):
                # of two sides that share a corner beyond them, both are added
                slopes[triangle, side, self.places[:, side, corner]] += own[:, corner]
        pulls = np.einsum("ti,tikc->tkc", moments, slopes)
        gradient = np.zeros_like(coords)
        used = self.vertices >= 0
        np.add.at(gradient, self.vertices[used], pulls[used])
        rows = slopes.reshape(len(slopes), 3, 18)
        matrices = rows.transpose(0, 2, 1) @ self.stiffness @ rows
        return gradient, [Blocks(self.vertices, matrices)]

    def longest_step(self, coords: FloatArray, step: FloatArray) -> float:  # noqa: ARG002
        """Nothing hinders a step."""
        return 1.0

    def curvatures(self, coords: FloatArray) -> FloatArray:
        """Largest absolute principal curvature of every triangle, over the framework's size."""
        bent = np.einsum("ti,tiab->tab", self._angles(coords), self.shapes)
        half = (bent[:, 0, 0] + bent[:, 1, 1]) / 2
        spread = np.hypot((bent[:, 0, 0] - bent[:, 1, 1]) / 2, bent[:, 0, 1])
        return np.asarray(np.abs(half) + spread)

    def _angles(self, coords: FloatArray) -> FloatArray:
        """At the sides of all triangles, shape (nt, 3), 0 where the plate ends."""
        angles = wrapped(hinge_angles(coords, self.hinges_vertices))
        return np.where(self.sides >= 0, np.append(angles, 0.0)[self.sides], 0.0)


def plate_bending(
    frame: Framework, plates: BoolArray, stiffness: float, poissons_ratio: float, held: BoolArray
) -> PlateBending:
    """The bending of a framework's triangles.

    Parameters
    ----------
    plates : shape (nh,), which hinges are within plates; the others end them.
    stiffness : of bending, moment per width and curvature, in the frame's units (newtons where it
        is divided by the size of the sheet in metres).
    held : shape (nv,), vertices that do not move: triangles between three of them do not bend.
    """
    triangles, flat = frame.triangles_vertices, frame.vertices_coords
    following = triangles[:, [1, 2, 0]]
    index = EdgeIndex.of(frame.hinges_vertices[:, :2], len(flat))
    sides = index.find(np.stack([triangles, following], axis=2).reshape(-1, 2)).reshape(-1, 3)
    sides = np.where((sides >= 0) & np.append(plates, False)[sides], sides, -1)
    along = (flat[following] - flat[triangles])[..., :2]
    length = np.hypot(along[..., 0], along[..., 1])
    area = (along[:, 0, 0] * along[:, 1, 1] - along[:, 0, 1] * along[:, 1, 0]) / 2
    height = 2 * area[:, None] / length
    rigid: BoolArray = np.asarray(held[triangles].all(axis=1))
    share = _shares(frame.hinges_triangles, sides, height, rigid)
    across = np.stack([along[..., 1], -along[..., 0]], axis=2)
    shapes = (across[..., :, None] * across[..., None, :]) / (area[:, None] * length)[
        ..., None, None
    ]
    shapes = shapes * np.where(rigid[:, None], 0.0, 1.0)[..., None, None]
    trace = np.trace(shapes, axis1=2, axis2=3)
    # K : K of two sides, and the product of their traces
    double = np.einsum("tiab,tjab->tij", shapes, shapes)
    both = trace[:, :, None] * trace[:, None, :]
    matrix = poissons_ratio * both + (1 - poissons_ratio) * double
    matrix = _without_moments(matrix * (stiffness * area)[:, None, None], sides < 0)
    matrix = matrix * share[:, :, None] * share[:, None, :]
    vertices, places = _corners(frame.hinges_vertices, triangles, sides)
    shapes = shapes * share[:, :, None, None]
    return PlateBending(frame.hinges_vertices, sides, matrix, shapes, vertices, places)


def _shares(beside: IntArray, sides: IntArray, height: FloatArray, rigid: BoolArray) -> FloatArray:
    """The share of each hinge's angle that bends each triangle beside it, shape (nt, 3)."""
    own = np.zeros((len(beside), 2))
    triangle = np.arange(len(sides))
    for side in range(3):
        hinge = sides[:, side]
        there = hinge >= 0
        second = beside[hinge[there], 1] == triangle[there]
        own[hinge[there], second.astype(int)] = np.where(rigid, 0.0, height[:, side])[there]
    total = own.sum(axis=1)
    out = np.zeros(sides.shape)
    for side in range(3):
        hinge = sides[:, side]
        used = (hinge >= 0) & (np.append(total, 0.0)[hinge] > 0)
        second = (beside[hinge[used], 1] == triangle[used]).astype(int)
        out[used, side] = own[hinge[used], second] / total[hinge[used]]
    return out


def _without_moments(matrix: FloatArray, ends: BoolArray) -> FloatArray:
    """The matrices, shape (nt, 3, 3), where the angles at some sides are those of least energy."""
    out = matrix.copy()
    for side in range(3):
        pivot = out[:, side, side]
        done = ends[:, side] & (pivot > 0)
        row = out[:, side, :]
        scale = np.where(done, 1 / np.where(pivot > 0, pivot, 1.0), 0.0)
        out = out - scale[:, None, None] * row[:, :, None] * row[:, None, :]
    gone = ends[:, :, None] | ends[:, None, :]
    return np.where(gone, 0.0, out)


def _corners(
    hinges_vertices: IntArray, triangles: IntArray, sides: IntArray
) -> tuple[IntArray, IntArray]:
    """The vertices that the angles of each triangle depend on, and the places of each hinge's."""
    count = len(triangles)
    own = np.where((sides >= 0)[..., None], hinges_vertices[sides], -1)
    vertices = np.concatenate([triangles, np.full((count, 3), -1)], axis=1)
    places = np.zeros((count, 3, 4), np.int64)
    for side in range(3):
        for corner in range(4):
            vertex = own[:, side, corner]
            same = vertices[:, : 4 + side] == vertex[:, None]
            known = same[:, :3].any(axis=1) | same[:, 3:].any(axis=1)
            fresh = (vertex >= 0) & ~known
            vertices[fresh, 3 + side] = vertex[fresh]
            found = (vertices == vertex[:, None]).argmax(axis=1)
            places[:, side, corner] = np.where(vertex >= 0, found, 0)
    return vertices, places
