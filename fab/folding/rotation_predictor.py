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
from scipy.spatial.transform import Rotation

from fab.folding.bar_hinge_model import Framework
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
    """

    frame: Framework
    tree: FaceTree
    axes: FloatArray
    averaging: SuperLU
    joining: SuperLU

    def coords(self, angles: FloatArray) -> FloatArray:
        """Vertices of the sheet whose hinges turn by `angles`, shape (nh,), radians.

        Shape (nv, 3), relative to the size of the framework. The root of each tree stays nearly
        where it is in the flat sheet.
        """
        frame = self.frame
        turns = Rotation.from_rotvec(-self.axes * angles[:, None]).as_matrix()
        pose, _ = self.tree.poses(turns, np.zeros_like(self.axes))
        first, second = frame.hinges_triangles.T
        for _ in range(_ROUNDS):
            off = pose[first].swapaxes(1, 2) @ pose[second] @ turns.swapaxes(1, 2)
            vector = np.squeeze(pose[first] @ _rotation_vectors(off)[:, :, None], axis=2)
            pull = frame.hinges_length[:, None] * vector
            change = self.averaging.solve(
                scattered(first, pull, len(pose)) - scattered(second, pull, len(pose))
            )
            pose = Rotation.from_rotvec(change).as_matrix() @ pose
        return self._joined(pose)

    def _joined(self, pose: FloatArray) -> FloatArray:
        """Vertices whose sides are, by least squares, those of the rotated triangles."""
        frame = self.frame
        sides = _triangle_sides(frame.triangles_vertices)
        flat = frame.vertices_coords[sides[..., 1]] - frame.vertices_coords[sides[..., 0]]
        turned = flat @ pose.swapaxes(1, 2)
        pull = (turned * _side_weights(frame)[..., None]).reshape(-1, 3)
        start, end = sides.reshape(-1, 2).T
        count = len(frame.vertices_coords)
        coords = self.joining.solve(scattered(end, pull, count) - scattered(start, pull, count))
        return np.asarray(coords, np.float64)


def rotation_predictor(frame: Framework) -> RotationPredictor:
    """The trees and factors of a framework."""
    pairs, lengths = frame.hinges_triangles, frame.hinges_length
    middles = frame.vertices_coords[frame.triangles_vertices].mean(axis=1)[:, :2]
    tree = face_tree(middles, pairs, lengths)
    _, first = np.unique(frame.component, return_index=True)
    sides = _triangle_sides(frame.triangles_vertices).reshape(-1, 2)
    weights = _side_weights(frame).ravel()
    ends = frame.vertices_coords[frame.hinges_vertices[:, :2]]
    return RotationPredictor(
        frame,
        tree,
        unit(ends[:, 1] - ends[:, 0]),
        splu(_pinned_laplacian(pairs, lengths, len(middles), tree.roots)),
        splu(_pinned_laplacian(sides, weights, len(frame.vertices_coords), first)),
    )


def _triangle_sides(triangles: IntArray) -> IntArray:
    """Both ends of every side, shape (nt, 3, 2)."""
    return np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2)


def _side_weights(frame: Framework) -> FloatArray:
    """Inverse square of each triangle side, shape (nt, 3): equal strain costs the same."""
    sides = _triangle_sides(frame.triangles_vertices)
    flat = frame.vertices_coords[sides[..., 1]] - frame.vertices_coords[sides[..., 0]]
    return np.asarray(1 / (flat**2).sum(axis=2))


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


def _rotation_vectors(matrices: FloatArray) -> FloatArray:
    return np.asarray(Rotation.from_matrix(matrices).as_rotvec(), np.float64)
