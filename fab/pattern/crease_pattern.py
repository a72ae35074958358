"""The crease pattern: a flat sheet, its creases, and the direction and angle of each fold.

Arrays carry the names of the FOLD format. Polygons of any size: faces are stored one after another
in `faces_vertices`, and face f is `faces_vertices[faces_offsets[f]:faces_offsets[f + 1]]`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from fab.errors import InvalidJob
from fab.geometry.rings import by_size
from fab.pattern.development import Development
from solver.errors import InvalidState, require_positive
from solver.graphs import labels
from solver.mesh import Edges, QuadMesh
from solver.polygons import face_normals
from solver.vectors import BoolArray, FloatArray, IntArray, cross, dot, unit

__all__ = [
    "FLAT_ANGLE_DEG",
    "CreasePattern",
    "assignments",
    "crease_pattern",
    "fold_angles_deg",
    "scaled",
]

# Creases that fold by less than this are flat (assignment F).
FLAT_ANGLE_DEG = 1e-6


@dataclass(frozen=True)
class CreasePattern:
    """A flat sheet with its creases, in millimetres and degrees. Arrays are read-only.

    Attributes
    ----------
    vertices_coords : shape (nv, 2), mm; faces are counterclockwise seen from +z.
    edges_vertices : shape (ne, 2), unique edges, each in the direction of its first face.
    edges_faces : shape (ne, 2), first and second face; -1 where there is none. An edge that ends
        within a face, as slits do, has that face twice.
    edges_assignment : shape (ne,), "M", "V", "F" or "B"; in patterns of other programs also "U"
        (unassigned), "C" (cut between two faces) and "J" (joins faces that stay flat).
    edges_foldAngle : shape (ne,), degrees in (-180, 180], valley positive, 0 at the boundary.
    faces_vertices, faces_offsets : polygons, see the module; shapes (total,) and (nf + 1,).
    folded_coords : shape (nv, 3), mm, the folded form; None where it is not known.

    >>> from fab.pattern.development import develop
    >>> from solver import Miura
    >>> mesh = Miura(columns=4, rows=3).grow().mesh
    >>> pattern = crease_pattern(mesh, develop(mesh), scale_mm_per_unit=20.0)
    >>> pattern.face_count, pattern.counts()
    (12, {'M': 8, 'V': 9, 'F': 0, 'B': 14})
    """

    vertices_coords: FloatArray
    edges_vertices: IntArray
    edges_faces: IntArray
    edges_assignment: NDArray[np.str_]
    edges_foldAngle: FloatArray  # noqa: N815 (the FOLD format's own name)
    faces_vertices: IntArray
    faces_offsets: IntArray
    folded_coords: FloatArray | None = None

    def __post_init__(self) -> None:
        for name in self.__dataclass_fields__:
            array = getattr(self, name)
            if array is not None:
                array.flags.writeable = False

    @property
    def face_count(self) -> int:
        """Number of faces."""
        return len(self.faces_offsets) - 1

    @cached_property
    def edges(self) -> Edges:
        """Edges with the faces beside them, as the solver names them."""
        return Edges(self.edges_vertices, self.edges_faces)

    @cached_property
    def edges_joining(self) -> BoolArray:
        """Which edges join two different faces, creases and not cuts, shape (ne,)."""
        first, second = self.edges_faces.T
        joining: BoolArray = (second >= 0) & (first != second) & (self.edges_assignment != "C")
        return joining

    @cached_property
    def faces_piece(self) -> IntArray:
        """The piece of the sheet that each face belongs to, shape (nf,)."""
        return labels(self.edges_faces[self.edges_joining], self.face_count)

    def faces_by_size(self) -> Iterator[tuple[IntArray, IntArray]]:
        """For each number n of corners: the faces that have it, and their corners (nf', n)."""
        return by_size(self.faces_vertices, self.faces_offsets)

    def counts(self) -> dict[str, int]:
        """Number of edges by assignment; U, C and J only where they occur."""
        found = {letter: int((self.edges_assignment == letter).sum()) for letter in "MVFBUCJ"}
        return {letter: count for letter, count in found.items() if count or letter in "MVFB"}


def crease_pattern(
    mesh: QuadMesh, development: Development, scale_mm_per_unit: float
) -> CreasePattern:
    """The crease pattern of a grown patch; the scale to millimetres is applied only here.

    Raises `InvalidValue` for a scale that is not positive.
    """
    require_positive("scale_mm_per_unit", scale_mm_per_unit)
    edges = mesh.edges
    faces, offsets = mesh.polygons
    angle = fold_angles_deg(mesh.vertices_coords, edges, faces, offsets)
    return CreasePattern(
        development.vertices_coords * scale_mm_per_unit,
        edges.edges_vertices,
        edges.edges_faces,
        assignments(angle, edges),
        angle,
        faces,
        offsets,
        mesh.vertices_coords * scale_mm_per_unit,
    )


def scaled(
    pattern: CreasePattern, *, width_mm: float | None = None, factor: float | None = None
) -> CreasePattern:
    """The pattern with its longer side `width_mm` long, or `factor` times as large.

    Raises `InvalidJob` where both are given, `InvalidValue` where one is not positive.
    """
    if width_mm is not None and factor is not None:
        raise InvalidJob(f"width {width_mm:g} mm and scale {factor:g}: give one of them.")
    if width_mm is not None:
        require_positive("width_mm", width_mm)
        factor = width_mm / float(np.ptp(pattern.vertices_coords, axis=0).max())
    if factor is None:
        return pattern
    require_positive("scale", factor)
    folded = pattern.folded_coords
    return replace(
        pattern,
        vertices_coords=pattern.vertices_coords * factor,
        folded_coords=None if folded is None else folded * factor,
    )


def assignments(angle_deg: FloatArray, edges: Edges) -> NDArray[np.str_]:
    """Letters M, V, F, B from fold angles: valley positive, mountain negative."""
    letter = np.where(angle_deg > 0, "V", "M")
    letter[np.abs(angle_deg) < FLAT_ANGLE_DEG] = "F"
    letter[edges.edges_faces[:, 1] < 0] = "B"
    return letter


def fold_angles_deg(
    folded_coords: FloatArray, edges: Edges, faces_vertices: IntArray, faces_offsets: IntArray
) -> FloatArray:
    """Deviation from flat at every edge, degrees in (-180, 180], valley positive, shape (ne,).

    atan2((n2 x n1).u, n1.n2), with n1, n2 the normals of the first and second face and u the edge's
    direction in the first; 0 at the boundary, and within `FLAT_ANGLE_DEG` of 0.

    Raises `InvalidState` for an edge without length and a face without area.
    """
    normals = face_normals(folded_coords, faces_vertices, faces_offsets)
    shared = edges.edges_faces[:, 1] >= 0
    ends = folded_coords[edges.edges_vertices[shared]]
    u = unit(ends[:, 1] - ends[:, 0])
    n1, n2 = normals[edges.edges_faces[shared]].swapaxes(0, 1)
    bad = np.flatnonzero(~np.isfinite(dot(n1, n2) + dot(u, u)))
    if len(bad):
        start, end = edges.edges_vertices[shared][bad[0]]
        raise InvalidState(
            "edges",
            f"edge ({start}, {end}) has no length, or is beside a face without area",
            "Merge duplicate vertices and remove degenerate faces.",
        )
    angle = np.zeros(len(shared))
    angle[shared] = np.degrees(np.arctan2(dot(cross(n2, n1), u), dot(n1, n2)))
    angle[np.abs(angle) < FLAT_ANGLE_DEG] = 0.0
    angle[angle == -180.0] = 180.0
    return angle
