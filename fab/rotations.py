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
from scipy.sparse.csgraph import breadth_first_order, connected_components, minimum_spanning_tree
from scipy.sparse.linalg import SuperLU, splu
from scipy.spatial.transform import Rotation

from fab.framework import Framework
from solver.vectors import FloatArray, IntArray, unit

__all__ = ["Turner", "turner"]

# Averaging converges as Newton's method does; angles that close need none.
_ROUNDS = 3


@dataclass(frozen=True)
class Turner:
    """What of a framework's turning does not change from state to state.

    Attributes
    ----------
    parent, parent_hinge, parent_first : tree of triangles, shape (nt,): the triangle above each,
        the hinge between them (-1 at roots, which are their own parents), and whether the triangle
        above is the first of that hinge.
    axes : shape (nh, 3), hinges in the flat sheet, unit.
    """

    frame: Framework
    parent: IntArray
    parent_hinge: IntArray
    parent_first: FloatArray
    axes: FloatArray
    averaging: SuperLU
    sewing: SuperLU

    def coords(self, angles: FloatArray) -> FloatArray:
        """Vertices, shape (nv, 3), of the sheet whose hinges turn by `angles`, shape (nh,).

        The first triangle of each tree stays where it is in the flat sheet, nearly.
        """
        frame = self.frame
        turns = Rotation.from_rotvec(-self.axes * angles[:, None]).as_matrix()
        pose = self._along_tree(turns)
        one, two = frame.hinges_triangles.T
        for _ in range(_ROUNDS):
            off = pose[one].swapaxes(1, 2) @ pose[two] @ turns.swapaxes(1, 2)
            vector = np.squeeze(pose[one] @ _logarithm(off)[:, :, None], axis=2)
            pull = frame.hinges_length[:, None] * vector
            change = self.averaging.solve(_scattered(one, pull, len(pose)) - _scattered(two, pull, len(pose)))
            pose = Rotation.from_rotvec(change).as_matrix() @ pose
        return self._sewn(pose)

    def _along_tree(self, turns: FloatArray) -> FloatArray:
        """Rotation of every triangle: products along the tree, by doubling the stride."""
        pose = np.broadcast_to(np.eye(3), (len(self.parent), 3, 3)).copy()
        below = self.parent_hinge >= 0
        turn = turns[self.parent_hinge[below]]
        first = self.parent_first[below].astype(bool)
        pose[below] = np.where(first[:, None, None], turn, turn.swapaxes(1, 2))
        above = self.parent
        while (above != above[above]).any():
            pose = pose[above] @ pose
            above = above[above]
        return pose

    def _sewn(self, pose: FloatArray) -> FloatArray:
        frame = self.frame
        sides = _triangle_sides(frame.triangles_vertices)
        flat = frame.vertices_coords[sides[..., 1]] - frame.vertices_coords[sides[..., 0]]
        turned = flat @ pose.swapaxes(1, 2)
        pull = (turned * _sewing_weights(frame)[..., None]).reshape(-1, 3)
        start, end = sides.reshape(-1, 2).T
        count = len(frame.vertices_coords)
        coords = self.sewing.solve(_scattered(end, pull, count) - _scattered(start, pull, count))
        return np.asarray(coords, np.float64)


def turner(frame: Framework) -> Turner:
    """Prepare the turning of a framework: its trees and factors."""
    count = len(frame.triangles_vertices)
    one, two = frame.hinges_triangles.T
    shape = (count, count)
    # long hinges first: their turn is known best
    graph = coo_array((1 / frame.hinges_length, (one, two)), shape=shape).tocsr()
    tree = minimum_spanning_tree(graph)
    tree = tree + tree.T
    _, piece = connected_components(tree, directed=False)
    roots = _roots(frame, piece)
    parent = np.arange(count)
    for root in roots.tolist():
        order, above = breadth_first_order(tree, root, directed=False)
        parent[order[1:]] = above[order[1:]]
    hinge = coo_array((np.arange(1, len(one) + 1), (one, two)), shape=shape).tocsr()
    pairs = np.arange(count), parent
    forward = np.asarray(hinge[parent, pairs[0]]).ravel()
    backward = np.asarray(hinge[pairs[0], parent]).ravel()
    number = np.maximum(forward, backward) - 1
    _, first_vertex = np.unique(frame.component, return_index=True)
    sides = _triangle_sides(frame.triangles_vertices).reshape(-1, 2)
    ends = frame.vertices_coords[frame.hinges_vertices[:, :2]]
    return Turner(
        frame,
        parent,
        number,
        forward.astype(np.float64),
        unit(ends[:, 1] - ends[:, 0]),
        splu(_pinned_laplacian(np.column_stack([one, two]), frame.hinges_length, count, roots)),
        splu(
            _pinned_laplacian(
                sides, _sewing_weights(frame).ravel(), len(frame.vertices_coords), first_vertex
            )
        ),
    )


def _roots(frame: Framework, piece: IntArray) -> IntArray:
    """In each piece the triangle nearest to its middle, so that the tree stays low."""
    middle = frame.vertices_coords[frame.triangles_vertices].mean(axis=1)
    count = np.bincount(piece)
    mean = np.stack([np.bincount(piece, c) for c in middle.T], axis=1) / count[:, None]
    far = np.hypot(*(middle - mean[piece])[:, :2].T)
    order = np.lexsort([far, piece])
    _, first = np.unique(piece[order], return_index=True)
    return np.asarray(order[first], np.int64)


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


def _scattered(places: IntArray, vectors: FloatArray, count: int) -> FloatArray:
    return np.stack([np.bincount(places, column, count) for column in vectors.T], axis=1)


def _logarithm(matrices: FloatArray) -> FloatArray:
    return np.asarray(Rotation.from_matrix(matrices).as_rotvec(), np.float64)
