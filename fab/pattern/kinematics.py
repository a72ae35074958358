"""Kinematics of rigid faces: the shape that fold angles alone give, and where they do not close.

Every face is carried along a tree of faces by rigid turns about the creases between them. Where
angles close, the turns around every interior vertex multiply to the identity (belcastro and Hull
2002), and it does not matter which creases lie on the tree.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from fab.pattern.crease_pattern import CreasePattern
from fab.pattern.face_tree import face_tree
from fab.pattern.open_cuts import edges_between
from solver.graphs import EdgeIndex
from solver.polygons import next_corner
from solver.vectors import BoolArray, FloatArray, IntArray, norm, scattered, unit

__all__ = ["Kinematics", "fold_by_angles", "next_around", "unknown_angles", "vertices_closure_rad"]


@dataclass(frozen=True)
class Kinematics:
    """A sheet of rigid faces, folded by its angles.

    Attributes
    ----------
    folded_coords : shape (nv, 3), mm: means over the faces around a vertex. The face in the middle
        of each piece lies as in the flat sheet.
    vertices_closure_rad : shape (nv,), by how much the turns around each interior vertex miss the
        identity; NaN at the border, and at unassigned creases and slits, which turn freely.
    gap_mm : largest distance of a vertex from the places that its faces give to it.
    gap_rad : largest angle by which two faces miss the angle of their crease. Angles may close
        around every vertex and still not around a hole.
    """

    folded_coords: FloatArray
    vertices_closure_rad: FloatArray
    gap_mm: float
    gap_rad: float

    @property
    def closure_max_rad(self) -> float:
        """Largest error of closure; 0 for a sheet without interior vertices."""
        known = self.vertices_closure_rad[np.isfinite(self.vertices_closure_rad)]
        return float(known.max(initial=0.0))


def fold_by_angles(pattern: CreasePattern) -> Kinematics:
    """Fold rigid faces by `edges_foldAngle`. Cuts between faces must be open (`opened`).

    A square folded to a right angle along its diagonal:

    >>> from fab.pattern.crease_pattern import CreasePattern
    >>> from solver.mesh import edges_of
    >>> corners, offsets = np.array([0, 1, 2, 0, 2, 3]), np.array([0, 3, 6])
    >>> edges = edges_of(corners, offsets)
    >>> joined = edges.edges_faces[:, 1] >= 0
    >>> square = CreasePattern(
    ...     np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]]),
    ...     edges.edges_vertices,
    ...     edges.edges_faces,
    ...     np.where(joined, "V", "B"),
    ...     np.where(joined, 90.0, 0.0),
    ...     corners,
    ...     offsets,
    ... )
    >>> bool(fold_by_angles(square).folded_coords[3, 2].round(9) == 7.071067812)
    True
    """
    flat = np.column_stack([pattern.vertices_coords, np.zeros(len(pattern.vertices_coords))])
    turning = np.flatnonzero((pattern.edges_faces[:, 1] >= 0) & ~unknown_angles(pattern))
    ends = flat[pattern.edges_vertices[turning]]
    along = ends[:, 1] - ends[:, 0]
    angle = np.radians(pattern.edges_foldAngle[turning])
    turns = Rotation.from_rotvec(-unit(along) * angle[:, None]).as_matrix().reshape(-1, 3, 3)
    shifts = ends[:, 0] - np.squeeze(turns @ ends[:, 0][:, :, None], axis=2)
    corners, offsets = pattern.faces_vertices, pattern.faces_offsets
    sizes = np.diff(offsets)
    centres = np.add.reduceat(pattern.vertices_coords[corners], offsets[:-1]) / sizes[:, None]
    tree = face_tree(centres, pattern.edges_faces[turning], norm(along))
    turn, shift = tree.poses(turns, shifts)
    face = np.repeat(np.arange(len(sizes)), sizes)
    placed = np.squeeze(turn[face] @ flat[corners][:, :, None], axis=2) + shift[face]
    number = np.bincount(corners, minlength=len(flat))
    folded = np.where(
        number[:, None] > 0,
        scattered(corners, placed, len(flat)) / np.maximum(number, 1)[:, None],
        flat,
    )
    gap = norm(placed - folded[corners]).max(initial=0.0)
    first, second = pattern.edges_faces[turning].T
    missed = _angles(turn[first] @ turns @ turn[second].swapaxes(1, 2)).max(initial=0.0)
    return Kinematics(folded, vertices_closure_rad(pattern), float(gap), float(missed))


def unknown_angles(pattern: CreasePattern) -> BoolArray:
    """Edges about which faces turn freely: cuts, and unassigned ones without an angle."""
    letters = pattern.edges_assignment
    free = (letters == "C") | ((letters == "U") & (pattern.edges_foldAngle == 0))
    return np.asarray(free, np.bool_)


def vertices_closure_rad(pattern: CreasePattern) -> FloatArray:
    """Angle of the product of all turns around every vertex, counterclockwise, shape (nv,).

    NaN where nothing has to close: at the border, cuts, and unassigned creases without an angle.
    """
    flat = np.column_stack([pattern.vertices_coords, np.zeros(len(pattern.vertices_coords))])
    corners, offsets = pattern.faces_vertices, pattern.faces_offsets
    count = len(flat)
    following = next_corner(offsets)
    before = np.empty_like(following)
    before[following] = np.arange(len(corners))
    beyond = next_around(corners, following, before, count)
    sides = edges_between(pattern, np.column_stack([corners, corners[before]]))
    angle = np.radians(pattern.edges_foldAngle[sides])
    axis = flat[corners[before]] - flat[corners]
    border = np.zeros(count, bool)
    border[corners[(beyond < 0) | unknown_angles(pattern)[sides]]] = True
    _, start = np.unique(corners, return_index=True)
    start = start[~border[corners[start]]]
    product = np.broadcast_to(np.eye(3), (len(start), 3, 3)).copy()
    corner = start.copy()
    going = np.ones(len(start), bool)
    while going.any():
        at = corner[going]
        turn = Rotation.from_rotvec(unit(axis[at]) * angle[at][:, None]).as_matrix()
        product[going] = product[going] @ turn
        corner[going] = beyond[at]
        going &= corner != start
    out = np.full(count, np.nan)
    out[corners[start]] = _angles(product)
    return out


def _angles(matrices: FloatArray) -> FloatArray:
    """Angles of rotation matrices, shape (n, 3, 3), none included."""
    return np.array(Rotation.from_matrix(matrices).magnitude() if len(matrices) else [], float)


def next_around(corners: IntArray, following: IntArray, before: IntArray, count: int) -> IntArray:
    """The corner of the next face counterclockwise around the same vertex; -1 at the border."""
    sides = EdgeIndex.of(np.column_stack([corners, corners[following]]), count, directed=True)
    # the same side, walked by the face beyond it
    return sides.find(np.column_stack([corners, corners[before]]))
