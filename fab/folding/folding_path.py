"""Folding paths: the order in which creases fold where folding all at once gets stuck.

A path is found in the space of all hinge angles, where nothing stretches: a chain of stations from
flat to the target, straight at first, then bent until the rotations around every vertex close at
every station (belcastro and Hull 2002) and the path is as short as that allows. Along it each
crease has a rate of its own. This is the elastic band of Jonsson, Mills and Jacobsen (1998), with
closure of the vertices in place of low energy, and stations kept at equal distances as in the
string method of E, Ren and Vanden-Eijnden (2002).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array, csc_array
from scipy.spatial.transform import Rotation

from fab.folding.bar_hinge_model import Framework
from fab.folding.damped import DampedSystems
from fab.folding.quasi_static import largest_turns, path_at, straight_path
from fab.pattern.kinematics import next_around
from fab.progress import Steps, no_steps
from solver.graphs import EdgeIndex
from solver.polygons import next_corner
from solver.vectors import FloatArray, IntArray, unit

__all__ = ["Closure", "FoldingPath", "closing_path", "hinges_around"]

# The weight of closure against length rises, so that the whole path first finds its valley.
_WEIGHTS = (1.0, 3.0, 10.0)
# Gauss-Newton steps at each weight.
_STEPS = 5
# From one station to the next no hinge turns by more.
_FARTHEST_RAD = np.radians(20.0)
# Beyond 180 degrees faces pass through each other: such angles are pulled back with the weight of
# closure.
_LIMIT_RAD = np.pi
_LEAST_DAMPING, _MOST_DAMPING = 1e-6, 1e6


@dataclass(frozen=True)
class FoldingPath:
    """A path from flat to the target.

    Attributes
    ----------
    angles : shape (n, nh), radians, of all hinges at each station.
    iterations : linear systems solved to find it, each of all stations.
    """

    angles: FloatArray
    iterations: int


def closing_path(frame: Framework, progress: Steps = no_steps) -> FoldingPath:
    """A path along which the vertices close as well as rigid triangles allow.

    progress : called with the Gauss-Newton steps done, and of all.
    """
    closure = hinges_around(frame)
    path = straight_path(frame)
    systems = DampedSystems()
    weights = [weight for weight in _WEIGHTS for _ in range(_STEPS)]
    for number, weight in enumerate(weights):
        progress(number, len(weights))
        path = _improved(closure, _resampled(path), weight, systems)
    progress(len(weights), len(weights))
    return FoldingPath(_resampled(path), len(weights))


def _resampled(path: FloatArray) -> FloatArray:
    """The path with stations at equal distances, measured by `largest_turns`.

    Otherwise stations slide away from where vertices hardly close, and the path tears there.
    """
    count = max(2, int(np.ceil(largest_turns(path).sum() / _FARTHEST_RAD)))
    inner = [path_at(path, number / count)[0] for number in range(1, count)]
    return np.stack([path[0], *inner, path[-1]])


def _improved(
    closure: Closure, path: FloatArray, weight: float, systems: DampedSystems
) -> FloatArray:
    """One damped Gauss-Newton step to a path that is shorter and closes better, times `weight`."""
    residual = _residual(closure, path, weight)
    jacobian = _jacobian(closure, path, weight)
    matrix, slope = (jacobian.T @ jacobian).tocsc(), jacobian.T @ residual
    damping = _LEAST_DAMPING
    while damping < _MOST_DAMPING:
        step = systems.factorised(matrix, damping)(-slope).reshape(-1, path.shape[1])
        stepped = np.concatenate([path[:1], path[1:-1] + step, path[-1:]])
        after = _residual(closure, stepped, weight)
        if after @ after < residual @ residual:
            return stepped
        damping *= 100
    return path


def _residual(closure: Closure, path: FloatArray, weight: float) -> FloatArray:
    """Errors of closure, excess over 180 degrees, and turns from station to station."""
    inner = path[1:-1]
    error, _ = closure.errors(inner)
    over = np.sign(inner) * np.maximum(np.abs(inner) - _LIMIT_RAD, 0.0)
    length = np.sqrt(len(path) - 1) * np.diff(path, axis=0)
    return np.concatenate([weight * error.ravel(), weight * over.ravel(), length.ravel()])


def _jacobian(closure: Closure, path: FloatArray, weight: float) -> csc_array:
    """Of the residual by the angles at all stations between the ends."""
    inner = path[1:-1]
    count, hinges = inner.shape
    _, slopes = closure.errors(inner)
    vertices = len(closure.hinges)
    station = np.arange(count)[:, None, None, None]
    rows = 3 * (station * vertices + np.arange(vertices)[:, None, None]) + np.arange(3)
    columns = station * hinges + closure.hinges[:, :, None]
    rows, columns = (np.broadcast_to(x, slopes.shape).ravel() for x in (rows, columns))
    place = np.arange(inner.size)
    begin = 3 * vertices * count
    after = begin + inner.size
    out = np.flatnonzero(np.abs(inner).ravel() > _LIMIT_RAD)
    pull = np.full(inner.size, np.sqrt(len(path) - 1))
    values = [weight * slopes.ravel(), np.full(len(out), weight), pull, -pull]
    rows_of = [rows, begin + out, after + place, after + hinges + place]
    columns_of = [columns, out, place, place]
    return coo_array(
        (np.concatenate(values), (np.concatenate(rows_of), np.concatenate(columns_of))),
        shape=(after + inner.size + hinges, inner.size),
    ).tocsc()


@dataclass(frozen=True)
class Closure:
    """Closure of the m interior vertices, each with up to d hinges, counterclockwise.

    Attributes
    ----------
    hinges : shape (m, d), 0 after the last hinge of a vertex that has fewer.
    axes : shape (m, d, 3), unit vectors from the vertex along its hinges in the flat sheet; zero
        after the last hinge of a vertex that has fewer.
    """

    hinges: IntArray
    axes: FloatArray

    def errors(self, angles: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Errors of closure, and their derivatives by the angles of the hinges.

        The product of the rotations around each vertex as a rotation vector, shape (n, m, 3), zero
        where the vertex closes; derivatives, shape (n, m, d, 3), are exact where it does.

        angles : shape (n, nh), radians.
        """
        turned = angles[:, self.hinges, None] * self.axes
        turns = Rotation.from_rotvec(turned.reshape(-1, 3)).as_matrix().reshape(*turned.shape, 3)
        product = np.broadcast_to(np.eye(3), (*turned.shape[:2], 3, 3))
        slopes = np.empty_like(turned)
        for number in range(turned.shape[2]):
            slopes[:, :, number] = np.squeeze(product @ self.axes[:, number, :, None], axis=-1)
            product = product @ turns[:, :, number]
        missed = Rotation.from_matrix(product.reshape(-1, 3, 3)).as_rotvec()
        return missed.reshape(*turned.shape[:2], 3), slopes


def hinges_around(frame: Framework) -> Closure:
    """The hinges around every interior vertex of the triangulated sheet; none around holes."""
    triangles, coords = frame.triangles_vertices, frame.vertices_coords
    count = len(coords)
    corners = triangles.ravel()
    following = next_corner(3 * np.arange(len(triangles) + 1))
    before = np.empty_like(following)
    before[following] = np.arange(len(corners))
    beyond = next_around(corners, following, before, count)
    index = EdgeIndex.of(frame.hinges_vertices[:, :2], count)
    side = index.find(np.column_stack([corners, corners[before]]))  # -1 at the border
    axis = unit(coords[corners[before]] - coords[corners])
    inside = np.ones(count, bool)
    inside[corners[beyond < 0]] = False
    _, start = np.unique(corners, return_index=True)
    start = start[inside[corners[start]]]
    hinges, axes = [], []
    corner, going = start.copy(), np.ones(len(start), bool)
    while going.any():
        hinges.append(np.where(going, side[corner], 0))
        axes.append(np.where(going[:, None], axis[corner], 0.0))
        corner = np.where(going, beyond[corner], corner)
        going &= corner != start
    if not hinges:
        return Closure(np.empty((0, 0), np.int64), np.empty((0, 0, 3)))
    return Closure(np.stack(hinges, axis=1), np.stack(axes, axis=1))
