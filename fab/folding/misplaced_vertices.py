"""Vertices whose fold angles do not close because of where they are: the nearest move that helps.

To first order, the rotations around a vertex change by the turns of its creases in the sheet, and
these by where their ends are. The moves of all vertices that do not close are sought together, as
few and as small as close all of them: a vertex that is off its place opens its neighbours as well.
Where no move of theirs helps, as where two straight lines cross, the ends of their creases are off.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import coo_array, csc_array, diags_array
from scipy.sparse.linalg import splu
from scipy.spatial.transform import Rotation

from fab.pattern.crease_pattern import FLAT_ANGLE_DEG, CreasePattern
from fab.pattern.kinematics import vertices_closure_rad
from fab.pattern.sectors import Sectors, sectors_of
from solver.graphs import labels
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["Misplaced", "OpenVertex", "misplaced_vertices", "open_vertex"]

# Moves beyond this share of the sheet's diagonal say nothing: angles are wrong.
_FARTHEST = 5e-3
# A vertex that moves by a smaller share of the largest move is at its place.
_STILL = 1e-2
# Moves of more vertices are not sought.
_MOST = 5000
# Rounds in which small moves are made smaller, so that few vertices move.
_ROUNDS = 6
# Steps, each to first order; what is left of the closures, relative and absolute, rad.
_STEPS = 4
_CLOSED, _CLOSED_RAD = 1e-2, 1e-6
_DAMPING = 1e-12


@dataclass(frozen=True)
class Misplaced:
    """A vertex that does not close where it is, though its fold angles may be right.

    Attributes
    ----------
    closure_rad : by how much the turns around it miss the identity.
    distance_mm : by how much it is moved where all vertices close, or else an end of its creases; 0
        where others are off.
    kawasaki_deg : alternating sum of its sectors, where all its creases fold by 180 degrees, whose
        angles are right then; None otherwise.
    """

    vertex: int
    closure_rad: float
    distance_mm: float
    kawasaki_deg: float | None


@dataclass(frozen=True)
class OpenVertex:
    """What there is around a vertex that does not close.

    Attributes
    ----------
    creases : number of its creases that fold. flat : whether all of these fold by 180 degrees.
    kawasaki_deg : as of `Misplaced`.
    """

    vertex: int
    creases: int
    flat: bool
    kawasaki_deg: float | None


def misplaced_vertices(pattern: CreasePattern, vertices: IntArray) -> list[Misplaced]:
    """What is off its place of some interior vertices that do not close, in their order.

    Those that edges join are sought together; left out where no moves of up to 0.5 % of the sheet's
    diagonal close them all: there angles are wrong.

    vertices : shape (n,), all that do not close. Cuts must be open.
    """
    if not 0 < len(vertices) <= _MOST:
        return []
    place = np.full(len(pattern.vertices_coords), -1)
    place[vertices] = np.arange(len(vertices))
    joined = place[pattern.edges_vertices]
    group = labels(joined[(joined >= 0).all(axis=1)], len(vertices))
    distance = np.full(len(vertices), np.nan)
    for number in range(int(group.max()) + 1):
        own = group == number
        distance[own] = _distances(pattern, vertices[own])
    missed = vertices_closure_rad(pattern)[vertices]
    sectors = sectors_of(pattern, _creases(pattern))
    around = [_around(pattern, sectors, vertex) for vertex in vertices.tolist()]
    for number in np.flatnonzero(np.isnan(distance)).tolist():
        distance[number] = _of_an_end_mm(pattern, sectors, around[number])
    return [
        Misplaced(each.vertex, float(miss), float(far), each.kawasaki_deg)
        for each, miss, far in zip(around, missed, distance, strict=True)
        if np.isfinite(far)
    ]


def open_vertex(pattern: CreasePattern, vertex: int) -> OpenVertex:
    """What there is around a vertex that does not close. Cuts must be open."""
    return _around(pattern, sectors_of(pattern, _creases(pattern)), vertex)


def _distances(pattern: CreasePattern, vertices: IntArray) -> FloatArray:
    """By how much vertices move where they close, mm, shape (n,); NaN where they do not."""
    size = float(np.hypot(*np.ptp(pattern.vertices_coords, axis=0)))
    missed = float(vertices_closure_rad(pattern)[vertices].max())
    moved = pattern.vertices_coords
    for _ in range(_STEPS):
        moves = _moves(replace(pattern, vertices_coords=moved), vertices)
        moved = moved.copy()
        moved[vertices] += moves
        distance: FloatArray = np.hypot(*(moved - pattern.vertices_coords)[vertices].T)
        if not distance.max() <= _FARTHEST * size:  # NaN too
            break
        left = vertices_closure_rad(replace(pattern, vertices_coords=moved))[vertices]
        if left.max() <= max(_CLOSED * missed, _CLOSED_RAD):
            distance[distance < _STILL * distance.max()] = 0.0
            return distance
    return np.full(len(vertices), np.nan)


def _moves(pattern: CreasePattern, vertices: IntArray) -> FloatArray:
    """Moves of some vertices that close them to first order, mm, shape (n, 2); NaN for none."""
    jacobian, missed = _closures(pattern, vertices)
    weight = np.ones(len(vertices))
    moves = np.zeros((len(vertices), 2))
    for _ in range(_ROUNDS):
        scaled = jacobian @ diags_array(np.repeat(weight, 2))
        normal = (scaled @ jacobian.T).tocsc()
        normal = normal + _DAMPING * normal.diagonal().mean() * diags_array(
            np.ones(normal.shape[0])
        )
        try:
            pull = splu(normal.tocsc()).solve(-missed)
        except RuntimeError:  # singular: no crease around them turns as they move
            return np.full((len(vertices), 2), np.nan)
        moves = (scaled.T @ pull).reshape(-1, 2)
        length = np.hypot(*moves.T)
        weight = length + 1e-3 * length.max(initial=0.0)
        weight /= weight.max(initial=0.0) or 1.0
    return moves


def _closures(pattern: CreasePattern, vertices: IntArray) -> tuple[csc_array, FloatArray]:
    """Derivatives of the closures of some vertices by their places, (3 n, 2 n), and the closures.

    With rotations R_1 ... R_k around a vertex and A_i the product of those before R_i, the product
    turns by (A_i - A_i+1) z for each radian by which crease i turns in the sheet, where it closes.
    """
    sectors = sectors_of(pattern, _creases(pattern))
    place = np.full(len(pattern.vertices_coords), -1)
    place[vertices] = np.arange(len(vertices))
    rows, columns, values = [], [], []
    missed = np.zeros((len(vertices), 3))
    for row, vertex in enumerate(vertices.tolist()):
        ends = slice(*np.searchsorted(sectors.vertices, [vertex, vertex + 1]))
        edges = sectors.edges[ends]
        direction = sectors.directions[ends]
        other = pattern.edges_vertices[edges].sum(axis=1) - vertex
        axis = np.column_stack([np.cos(direction), np.sin(direction), np.zeros(len(edges))])
        angle = np.radians(pattern.edges_foldAngle[edges])
        turns = Rotation.from_rotvec(axis * angle[:, None]).as_matrix()
        product = np.eye(3)
        slopes = np.empty((len(edges), 3))
        for number, turn in enumerate(turns):
            before = product[:, 2]
            product = product @ turn
            slopes[number] = before - product[:, 2]
        missed[row] = Rotation.from_matrix(product).as_rotvec()
        arm = pattern.vertices_coords[other] - pattern.vertices_coords[vertex]
        across = np.column_stack([-axis[:, 1], axis[:, 0]]) / np.hypot(*arm.T)[:, None]
        effect = slopes[:, :, None] * across[:, None, :]
        for column, part in [(row, -effect.sum(axis=0)), *zip(place[other], effect, strict=True)]:
            if column >= 0:
                rows.append(3 * row + np.repeat(np.arange(3), 2))
                columns.append(2 * int(column) + np.tile(np.arange(2), 3))
                values.append(part.ravel())
    shape = (3 * len(vertices), 2 * len(vertices))
    data = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
    return coo_array(data, shape=shape).tocsc(), missed.ravel()


def _creases(pattern: CreasePattern) -> BoolArray:
    out: BoolArray = pattern.edges_joining & (np.abs(pattern.edges_foldAngle) > FLAT_ANGLE_DEG)
    return out


def _around(pattern: CreasePattern, sectors: Sectors, vertex: int) -> OpenVertex:
    ends = slice(*np.searchsorted(sectors.vertices, [vertex, vertex + 1]))
    edges = sectors.edges[ends]
    off = np.abs(np.abs(pattern.edges_foldAngle[edges]) - 180)
    flat = bool((off <= FLAT_ANGLE_DEG).all())
    if len(edges) % 2 or not flat:
        return OpenVertex(vertex, len(edges), flat, None)
    sign = np.where(np.arange(len(edges)) % 2, -1.0, 1.0)
    missed = float(np.degrees(abs(sign @ sectors.angles[ends])))
    return OpenVertex(vertex, len(edges), flat, missed)


def _of_an_end_mm(pattern: CreasePattern, sectors: Sectors, around: OpenVertex) -> float:
    """By how much the end of the shortest crease is off, if Kawasaki's condition is missed by that.

    NaN where it is not known to be so, and where that is far: a crease that turns in the sheet
    changes two sectors.
    """
    if not around.kawasaki_deg:
        return np.nan
    ends = slice(*np.searchsorted(sectors.vertices, [around.vertex, around.vertex + 1]))
    tips = pattern.edges_vertices[sectors.edges[ends]].sum(axis=1) - around.vertex
    arm = pattern.vertices_coords[tips] - pattern.vertices_coords[around.vertex]
    distance = float(np.radians(around.kawasaki_deg) / 2 * np.hypot(*arm.T).min())
    size = float(np.hypot(*np.ptp(pattern.vertices_coords, axis=0)))
    return distance if distance <= _FARTHEST * size else np.nan
