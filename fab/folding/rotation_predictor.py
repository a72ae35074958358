"""Prediction of a sheet whose hinges turn by given angles, however far.

Linear steps stretch a sheet that turns far. So every triangle gets a rotation instead: the product
of the hinges' turns along a tree of triangles, then averaged, so that hinges off the tree come as
near to their angles as the others. The rotated triangles are joined into a sheet by least squares.
Angles that close around every vertex give the folded form itself. After Lipman et al. (2005),
"Linear rotation-invariant coordinates for meshes".
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array, csc_array
from scipy.sparse.linalg import SuperLU, splu

from fab.folding.bar_hinge_model import Framework
from fab.folding.unit_quaternions import (
    inverse,
    matrices,
    of_vectors,
    product,
    turned,
    vectors_of,
)
from fab.pattern.face_tree import FaceTree, face_tree
from solver.vectors import FloatArray, IntArray, scattered, unit

__all__ = ["RotationPredictor", "rotation_predictor"]

# Averaging converges as Newton's method does; angles that close need none.
_ROUNDS = 3


@dataclass(frozen=True)
class RotationPredictor:
    """Trees and factors that predict a framework's states, the same for all of them.

    Attributes
    ----------
    tree : of triangles.
    axes : shape (nh, 3), unit vectors along the hinges in the flat sheet.
    averaging : factors of the graph Laplacian of the triangles, which averages rotations.
    joining : factors of that of the vertices, which joins rotated triangles.
    sides, weights : of the triangles: both ends of each, shape (nt, 3, 2), and the inverse of its
        square, shape (nt, 3), so that equal strain costs the same.
    """

    frame: Framework
    tree: FaceTree
    axes: FloatArray
    averaging: SuperLU
    joining: SuperLU
    sides: IntArray
    weights: FloatArray

    def coords(self, angles: FloatArray) -> FloatArray:
        """Vertices of the sheet whose hinges turn by `angles`, shape (nh,), radians.

        Shape (nv, 3), relative to the size of the framework. The root of each tree stays nearly
        where it is in the flat sheet.
        """
        frame = self.frame
        turns = of_vectors(-self.axes.T * angles)
        back = inverse(turns)
        pose = self._along_tree(turns)
        first, second = frame.hinges_triangles.T
        for _ in range(_ROUNDS):
            here = pose[:, first]
            off = product(product(inverse(here), pose[:, second]), back)
            pull = (frame.hinges_length * turned(here, vectors_of(off))).T
            change = self.averaging.solve(
                scattered(first, pull, pose.shape[1]) - scattered(second, pull, pose.shape[1])
            )
            pose = product(of_vectors(change.T), pose)
        return self._joined(matrices(pose))

    def _along_tree(self, turns: FloatArray) -> FloatArray:
        """Rotation of every triangle, by products along the tree, doubling the stride."""
        parent, below = self.tree.parent, self.tree.link >= 0
        pose = np.zeros((4, len(parent)))
        pose[3] = 1.0
        own = turns[:, self.tree.link[below]]
        pose[:, below] = np.where(self.tree.forward[below], own, inverse(own))
        while (parent != parent[parent]).any():
            pose = product(pose[:, parent], pose)
            parent = parent[parent]
        return pose

    def _joined(self, pose: FloatArray) -> FloatArray:
        """Vertices whose sides are, by least squares, those of the rotated triangles."""
        flat, count = self.frame.vertices_coords, len(self.frame.vertices_coords)
        along = flat[self.sides[..., 1]] - flat[self.sides[..., 0]]
        pull = ((along @ pose.swapaxes(1, 2)) * self.weights[..., None]).reshape(-1, 3)
        start, end = self.sides.reshape(-1, 2).T
        coords = self.joining.solve(scattered(end, pull, count) - scattered(start, pull, count))
        return np.asarray(coords, np.float64)


def rotation_predictor(frame: Framework) -> RotationPredictor:
    """The trees and factors of a framework."""
    pairs, lengths = frame.hinges_triangles, frame.hinges_length
    middles = frame.vertices_coords[frame.triangles_vertices].mean(axis=1)[:, :2]
    tree = face_tree(middles, pairs, lengths)
    _, first = np.unique(frame.component, return_index=True)
    sides = _triangle_sides(frame.triangles_vertices)
    along = frame.vertices_coords[sides[..., 1]] - frame.vertices_coords[sides[..., 0]]
    weights = 1 / (along**2).sum(axis=2)
    count = len(frame.vertices_coords)
    ends = frame.vertices_coords[frame.hinges_vertices[:, :2]]
    return RotationPredictor(
        frame,
        tree,
        unit(ends[:, 1] - ends[:, 0]),
        _factors(_pinned_laplacian(pairs, lengths, len(middles), tree.roots)),
        _factors(_pinned_laplacian(sides.reshape(-1, 2), weights.ravel(), count, first)),
        sides,
        weights,
    )


def _triangle_sides(triangles: IntArray) -> IntArray:
    """Both ends of every side, shape (nt, 3, 2)."""
    return np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2)


def _pinned_laplacian(
    pairs: IntArray, weights: FloatArray, count: int, pinned: IntArray
) -> csc_array:
    """Laplacian of a weighted graph of `count` nodes, regular by one pinned node in each part."""
    first, second = pairs.T
    rows = np.concatenate([first, second, first, second, pinned])
    columns = np.concatenate([first, second, second, first, pinned])
    pin = np.full(len(pinned), weights.mean() if len(weights) else 1.0)
    values = np.concatenate([weights, weights, -weights, -weights, pin])
    return coo_array((values, (rows, columns)), shape=(count, count)).tocsc()


def _factors(laplacian: csc_array) -> SuperLU:
    # for three right sides at a time, which `solver.sparse` does not take
    return splu(laplacian, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
