"""The bar-and-hinge model of a sheet: its bars and hinges, their stiffness, energy and derivatives.

A bar lies along every side of every triangle into which the faces are cut, a hinge along every side
that two triangles share: a crease of the pattern, or a facet crease within a face. With lengths
l and rest lengths l0, fold angles theta and their targets theta*, the energy is

    E = sum_bars k_axial / (2 l0) (l - l0)^2 + sum_hinges k_hinge l0 / 2 (theta - theta*)^2,

the model of Schenk and Guest (2011), with the rotational springs that Ghassaei, Demaine and
Gershenfeld (2018) drive to target angles. Lengths are over the diagonal of the flat sheet, so that
stiffness does not depend on its size; angles are radians, valley positive.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fab.folding.fold_settings import Stiffness
from fab.geometry.rings import by_size
from fab.geometry.triangulation import cap_triangles
from fab.pattern.crease_pattern import CreasePattern
from fab.pattern.kinematics import Kinematics, fold_by_angles, unknown_angles
from fab.pattern.open_cuts import Opened, edges_between, opened
from solver.assembly import NormalAssembly
from solver.errors import InvalidState, InvalidValue
from solver.graphs import labels
from solver.hinge_angles import hinge_angles, hinge_gradients
from solver.mesh import edges_of
from solver.sparse import SymmetricSystem
from solver.vectors import FloatArray, IntArray, cross, norm, scattered

__all__ = [
    "Derivatives",
    "Energy",
    "Framework",
    "framework",
    "hinge_forces",
    "wrapped",
]

# The squares of smaller and larger lengths underflow or overflow.
_SMALLEST_MM, _LARGEST_MM = 1e-100, 1e100


@dataclass(frozen=True)
class Energy:
    """Energy of stretched bars, of hinges that are off their targets, and of potentials.

    In units of stiffness times the size of the sheet. others : of each potential
    (`fab.folding.potentials`); these may be negative.
    """

    bars: float
    hinges: float
    others: tuple[float, ...] = ()

    @property
    def total(self) -> float:
        """That of bars, hinges and potentials together."""
        return self.bars + self.hinges + sum(self.others)

    @property
    def scale(self) -> float:
        """The sum of their absolute values, against which changes are small or large."""
        return self.bars + self.hinges + sum(map(abs, self.others))


@dataclass(frozen=True)
class Derivatives:
    """How bar lengths and hinge angles change with the vertices, the residuals of least squares.

    Attributes
    ----------
    gradients : of bars, shape (nb, 2, 3), and of hinges, shape (nh, 4, 3), by their vertices.
    weights : their stiffness, shapes (nb,) and (nh,).
    values : by how much they are off, shapes (nb,) and (nh,).
    """

    gradients: tuple[FloatArray, FloatArray]
    weights: tuple[FloatArray, FloatArray]
    values: tuple[FloatArray, FloatArray]


@dataclass(frozen=True)
class Framework:
    """Bars and hinges of a crease pattern. Lengths are relative to `size_mm`.

    Attributes
    ----------
    sheet : the pattern with its cuts open; vertices, faces and edges are numbered as in it.
    size_mm : diagonal of the flat sheet's bounding box.
    vertices_coords : shape (nv, 3), the flat sheet, z = 0.
    triangles_vertices, triangles_face : shapes (nt, 3) and (nt,); counterclockwise when flat.
    bars_vertices, bars_length, bars_stiffness : shapes (nb, 2), (nb,) and (nb,), k_axial / l0.
    hinges_vertices : shape (nh, 4): two ends, in the direction of the first triangle, and the
        corners of the first and of the second triangle off the hinge.
    hinges_triangles : shape (nh, 2), the triangles on both sides.
    hinges_edge : shape (nh,), edge of the sheet; -1 for facet creases.
    hinges_length, hinges_stiffness : shape (nh,), the latter k_hinge l0.
    hinges_target : shape (nh,), radians: fold angles of the pattern, 0 for facet creases and
        creases of unknown angle (`fab.pattern.kinematics.unknown_angles`). The latter have no
        stiffness.
    """

    sheet: Opened
    size_mm: float
    vertices_coords: FloatArray
    triangles_vertices: IntArray
    triangles_face: IntArray
    bars_vertices: IntArray
    bars_length: FloatArray
    bars_stiffness: FloatArray
    hinges_vertices: IntArray
    hinges_triangles: IntArray
    hinges_edge: IntArray
    hinges_length: FloatArray
    hinges_stiffness: FloatArray
    hinges_target: FloatArray

    def energy(self, coords: FloatArray, target: FloatArray) -> Energy:
        """Energy at coords, shape (nv, 3), with the hinges driven to `target`, shape (nh,)."""
        stretch = norm(_sides(coords, self.bars_vertices)) - self.bars_length
        off = wrapped(hinge_angles(coords, self.hinges_vertices) - target)
        return Energy(
            float(self.bars_stiffness @ stretch**2) / 2, float(self.hinges_stiffness @ off**2) / 2
        )

    def angles_near(self, coords: FloatArray, target: FloatArray) -> FloatArray:
        """Fold angles of all hinges, radians, each within pi of its target, shape (nh,)."""
        return target + wrapped(hinge_angles(coords, self.hinges_vertices) - target)

    def strains(self, coords: FloatArray) -> FloatArray:
        """Relative stretch of every bar, shape (nb,)."""
        return norm(_sides(coords, self.bars_vertices)) / self.bars_length - 1

    def derivatives(self, coords: FloatArray, target: FloatArray) -> Derivatives:
        """Derivatives of bar lengths and hinge angles at coords, shape (nv, 3)."""
        bar, stretch = _bar_gradients(self, coords)
        hinge, off = _hinge_gradients(self, coords, target)
        return Derivatives(
            (bar, hinge), (self.bars_stiffness, self.hinges_stiffness), (stretch, off)
        )

    def linearised(self, coords: FloatArray, target: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Gradient of the energy, and the Gauss-Newton matrix J' K J in place of its Hessian.

        Shapes (nv, 3), and that of the entries of `assembly.triangle`. J holds the derivatives of
        bar lengths and hinge angles. The matrix is the Hessian where all bars have their rest
        lengths and all hinges their targets.
        """
        here = self.derivatives(coords, target)
        return (
            self.assembly.gradient(here.gradients, here.weights, here.values),
            self.assembly.matrix(here.gradients, here.weights),
        )

    @cached_property
    def assembly(self) -> NormalAssembly:
        """Where bars and hinges are added in the matrix."""
        return NormalAssembly.of(
            len(self.vertices_coords), [self.bars_vertices, self.hinges_vertices]
        )

    @cached_property
    def system(self) -> SymmetricSystem:
        """The analysis of the matrix."""
        return SymmetricSystem(self.assembly.triangle)

    @cached_property
    def component(self) -> IntArray:
        """Number of the connected part of the sheet that each vertex is in, shape (nv,)."""
        return labels(self.bars_vertices, len(self.vertices_coords))

    @cached_property
    def kinematics(self) -> Kinematics:
        """The sheet with rigid faces, folded by the angles of its pattern."""
        return fold_by_angles(self.sheet.pattern)


def framework(pattern: CreasePattern, stiffness: Stiffness | None = None) -> Framework:
    """Bars and hinges of any pattern: triangles, n-gons, several components, cuts (opened first).

    Each face is cut into triangles. Hinges with the letter J, which join the faces of one panel,
    are as stiff as facet creases.

    Raises `InvalidValue` for a sheet that is not from 1e-100 to 1e100 mm across, and for a triangle
    without area.
    """
    stiffness = stiffness or Stiffness()
    sheet = opened(pattern)
    flat = sheet.pattern.vertices_coords
    size = float(np.hypot(*np.ptp(flat, axis=0)))
    if not _SMALLEST_MM <= size <= _LARGEST_MM:
        bound = f"be from {_SMALLEST_MM:g} to {_LARGEST_MM:g} mm across"
        raise InvalidValue("sheet", f"{size:g} mm", bound, "Give it in another unit.")
    coords = np.column_stack([flat, np.zeros(len(flat))]) / size
    corners, offsets = sheet.pattern.faces_vertices, sheet.pattern.faces_offsets
    triangles, face = _triangles(coords, corners, offsets)
    edges = edges_of(triangles.ravel(), 3 * np.arange(len(triangles) + 1))
    length = norm(_sides(coords, edges.edges_vertices))
    shared = edges.edges_faces[:, 1] >= 0
    ends, beside = edges.edges_vertices[shared], edges.edges_faces[shared]
    across = triangles[beside].sum(axis=2) - ends.sum(axis=1)[:, None]
    crease = np.full(len(ends), -1)
    between = face[beside[:, 0]] != face[beside[:, 1]]
    crease[between] = edges_between(sheet.pattern, ends[between])
    facet = (crease < 0) | (sheet.pattern.edges_assignment[crease] == "J")
    free = unknown_angles(sheet.pattern)[crease]
    kind = np.select([facet, free], [stiffness.facet, 0.0], stiffness.crease)
    target = np.where(facet | free, 0.0, np.radians(sheet.pattern.edges_foldAngle[crease]))
    return Framework(
        sheet,
        size,
        coords,
        triangles,
        face,
        edges.edges_vertices,
        length,
        stiffness.axial / length,
        np.concatenate([ends, across], axis=1),
        beside,
        crease,
        length[shared],
        kind * length[shared],
        target,
    )


def hinge_forces(frame: Framework, coords: FloatArray, target: FloatArray) -> FloatArray:
    """Forces of the hinges alone on the vertices, shape (nv, 3).

    target : shape (nh,), radians.
    """
    gradient, off = _hinge_gradients(frame, coords, target)
    pull = -(frame.hinges_stiffness * off)[:, None, None] * gradient
    return scattered(frame.hinges_vertices.ravel(), pull.reshape(-1, 3), len(frame.vertices_coords))


def wrapped(angle: FloatArray) -> FloatArray:
    """The same angles, radians, from -pi to pi.

    Of the difference to a target: an angle that has passed 180 degrees is then near 180, not -180.

    >>> np.degrees(wrapped(np.radians([190.0, -30.0]))).round(6).tolist()
    [-170.0, -30.0]
    """
    out: FloatArray = angle - 2 * np.pi * np.round(angle / (2 * np.pi))
    return out


def _sides(coords: FloatArray, pairs: IntArray) -> FloatArray:
    return coords[pairs[:, 1]] - coords[pairs[:, 0]]


def _bar_gradients(frame: Framework, coords: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Gradient of every bar's length, shape (nb, 2, 3), and its stretch, shape (nb,)."""
    side = _sides(coords, frame.bars_vertices)
    length = norm(side)
    along = side / length[:, None]
    return np.stack([-along, along], axis=1), length - frame.bars_length


def _hinge_gradients(
    frame: Framework, coords: FloatArray, target: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Gradient of every hinge's angle, shape (nh, 4, 3), and by how much it is off its target."""
    gradient = hinge_gradients(coords, frame.hinges_vertices)
    off = wrapped(hinge_angles(coords, frame.hinges_vertices) - target)
    return gradient, off


def _triangles(
    coords: FloatArray, corners: IntArray, offsets: IntArray
) -> tuple[IntArray, IntArray]:
    """Triangles of all faces, shape (nt, 3), and the face of each, rising."""
    triangles, faces = [], []
    for face, rings in by_size(corners, offsets):
        cut = cap_triangles(coords[rings][..., :2])
        triangles.append(np.take_along_axis(rings[:, None, :], cut, axis=2).reshape(-1, 3))
        faces.append(np.repeat(face, cut.shape[1]))
    vertices, face = np.concatenate(triangles), np.concatenate(faces)
    order = np.argsort(face, kind="stable")
    vertices, face = vertices[order], face[order]
    twice = cross(
        coords[vertices[:, 1]] - coords[vertices[:, 0]],
        coords[vertices[:, 2]] - coords[vertices[:, 0]],
    )[:, 2]
    degenerate = np.flatnonzero(~(twice > 0))
    if len(degenerate):
        raise InvalidState(
            "faces",
            f"a triangle of face {face[degenerate[0]]} has no area",
            "Merge corners that coincide, or remove the face.",
        )
    return vertices, face
