"""Where do the vertices of a sheet go when its hinges turn by given angles, however far?

Linear steps stretch a sheet that turns far. Here every triangle gets a rotation: the product of
the hinges' turns along a tree of triangles, then averaged, so that hinges off the tree come as near
to their angles as the others. The triangles, each turned rigidly, are sewn together by least
squares. Angles that close around every vertex give the folded form itself, after Lipman et al.
(2005), "Linear rotation-invariant coordinates for meshes".
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

__all__ = ["Turner", "turner"]

# Averaging converges as Newton's method does; angles that close need none.
_ROUNDS = 3


@dataclass(frozen=True)
class Turner:
    """What of a framework's turning does not change from state to state.

    tree : of triangles; axes : shape (nh, 3), hinges in the flat sheet, unit.
    """

    frame: Framework
    tree: FaceTree
    axes: FloatArray
    averaging: SuperLU
    sewing: SuperLU

    def coords(self, angles: FloatArray) -> FloatArray:
        """Vertices, shape (nv, 3), of the sheet whose hinges turn by `angles`, shape (nh,).

        The first triangle of each tree stays where it is in the flat sheet, nearly.
        """
        frame = self.frame
        turns = Rotation.from_rotvec(-self.axes * angles[:, None]).as_matrix()
        pose, _ = self.tree.poses(turns, np.zeros_like(self.axes))
        one, two = frame.hinges_triangles.T
        for _ in range(_ROUNDS):
            off = pose[one].swapaxes(1, 2) @ pose[two] @ turns.swapaxes(1, 2)
            vector = np.squeeze(pose[one] @ _logarithm(off)[:, :, None], axis=2)
            pull = frame.hinges_length[:, None] * vector
            change = self.averaging.solve(
                scattered(one, pull, len(pose)) - scattered(two, pull, len(pose))
            )
            pose = Rotation.from_rotvec(change).as_matrix() @ pose
        return self._sewn(pose)

    def _sewn(self, pose: FloatArray) -> FloatArray:
        frame = self.frame
        sides = _triangle_sides(frame.triangles_vertices)
        flat = frame.vertices_coords[sides[..., 1]] - frame.vertices_coords[sides[..., 0]]
        turned = flat @ pose.swapaxes(1, 2)
        pull = (turned * _sewing_weights(frame)[..., None]).reshape(-1, 3)
        start, end = sides.reshape(-1, 2).T
        count = len(frame.vertices_coords)
        coords = self.sewing.solve(scattered(end, pull, count) - scattered(start, pull, count))
        return np.asarray(coords, np.float64)


def turner(frame: Framework) -> Turner:
    """Prepare the turning of a framework: its trees and factors."""
    pairs, lengths = frame.hinges_triangles, frame.hinges_length
    middles = frame.vertices_coords[frame.triangles_vertices].mean(axis=1)[:, :2]
    tree = face_tree(middles, pairs, lengths)
    _, first = np.unique(frame.component, return_index=True)
    sides = _triangle_sides(frame.triangles_vertices).reshape(-1, 2)
    weights = _sewing_weights(frame).ravel()
    ends = frame.vertices_coords[frame.hinges_vertices[:, :2]]
    return Turner(
        frame,
        tree,
        unit(ends[:, 1] - ends[:, 0]),
        splu(_pinned_laplacian(pairs, lengths, len(middles), tree.roots)),
        splu(_pinned_laplacian(sides, weights, len(frame.vertices_coords), first)),
    )


def _triangle_sides(triangles: IntArray) -> IntArray:
    return np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2)


def _sewing_weights(frame: Framework) -> FloatArray:
    """One over the square of each triangle side, shape (nt, 3): alike in relative stretch."""
    sides = _triangle_sides(frame.triangles_vertices)
    flat = frame.vertices_coords[sides[..., 1]] - frame.vertices_coords[sides[..., 0]]
    return np.asarray(1 / (flat**2).sum(axis=2))


def _pinned_laplacian(
    pairs: IntArray, weights: FloatArray, count: int, pinned: IntArray
) -> csc_array:
    one, two = pairs.T
    rows = np.concatenate([one, two, one, two, pinned])
    columns = np.concatenate([one, two, two, one, pinned])
    pin = np.full(len(pinned), weights.mean() if len(weights) else 1.0)
    values = np.concatenate([weights, weights, -weights, -weights, pin])
    return coo_array((values, (rows, columns)), shape=(count, count)).tocsc()


def _logarithm(matrices: FloatArray) -> FloatArray:
    return np.asarray(Rotation.from_matrix(matrices).as_rotvec(), np.float64)
