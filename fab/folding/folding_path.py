"""In which order do creases fold that lock when all of them fold at once?

A way is found in the space of all hinge angles, where nothing stretches: a chain of stations from
flat to the target, drawn straight at first, then bent until the turns around every vertex close at
every station (belcastro and Hull 2002) and the way is as short as that allows. Along it each crease
has a rate of its own. This is the elastic band of Jonsson, Mills and Jacobsen (1998), with vertices
that close in place of a low energy, and stations kept even as in the string method of E, Ren and
Vanden-Eijnden (2002).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array, csc_array
from scipy.spatial.transform import Rotation

from fab.folding.bar_hinge_model import Framework
from fab.folding.quasi_static import Progress, along, damped, largest_turns, silent
from fab.geometry.rings import next_corner
from fab.pattern.kinematics import next_around
from solver.vectors import FloatArray, IntArray, unit

__all__ = ["Closure", "Way", "closing_way", "hinges_around"]

# Closure grows against length from round to round: the whole way finds its valley first.
_WEIGHTS = (1.0, 3.0, 10.0)
_STEPS = 5
# Between two stations no hinge turns by more.
_FARTHEST_RAD = np.radians(20.0)
# Beyond 180 degrees faces pass through each other: pulled back as strongly as vertices close.
_LIMIT_RAD = np.pi
_LEAST_DAMPING, _MOST_DAMPING = 1e-6, 1e6


@dataclass(frozen=True)
class Way:
    """Hinge angles at stations from flat to the target, radians, shape (n, nh).

    iterations : linear systems solved to find it, each of all stations.
    """

    angles: FloatArray
    iterations: int


def closing_way(frame: Framework, progress: Progress = silent) -> Way:
    """A way along which the vertices close as well as rigid triangles allow."""
    closure = hinges_around(frame)
    way = np.stack([np.zeros_like(frame.hinges_target), frame.hinges_target])
    rounds = [weight for weight in _WEIGHTS for _ in range(_STEPS)]
    for number, weight in enumerate(rounds):
        progress(number, len(rounds))
        way = _bent(closure, _even(way), weight)
    progress(len(rounds), len(rounds))
    return Way(_even(way), len(rounds))


def _even(way: FloatArray) -> FloatArray:
    """Stations as far from each other as the hinge goes that turns the most.

    Without, they slide off to both sides of where vertices hardly close, and the way tears there.
    """
    count = max(2, int(np.ceil(largest_turns(way).sum() / _FARTHEST_RAD)))
    between = [along(way, number / count)[0] for number in range(1, count)]
    return np.stack([way[0], *between, way[-1]])


def _bent(closure: Closure, way: FloatArray, weight: float) -> FloatArray:
    """One damped Gauss-Newton step to a shorter way with less error of closure, times `weight`."""
    residual = _residual(closure, way, weight)
    jacobian = _jacobian(closure, way, weight)
    matrix, slope = (jacobian.T @ jacobian).tocsc(), jacobian.T @ residual
    damping = _LEAST_DAMPING
    while damping < _MOST_DAMPING:
        step = damped(matrix, damping).solve(-slope).reshape(-1, way.shape[1])
        moved = np.concatenate([way[:1], way[1:-1] + step, way[-1:]])
        after = _residual(closure, moved, weight)
        if after @ after < residual @ residual:
            return moved
        damping *= 100
    return way


def _residual(closure: Closure, way: FloatArray, weight: float) -> FloatArray:
    inner = way[1:-1]
    error, _ = closure.errors(inner)
    over = np.sign(inner) * np.maximum(np.abs(inner) - _LIMIT_RAD, 0.0)
    length = np.sqrt(len(way) - 1) * np.diff(way, axis=0)
    return np.concatenate([weight * error.ravel(), weight * over.ravel(), length.ravel()])


def _jacobian(closure: Closure, way: FloatArray, weight: float) -> csc_array:
    """Of the residual by the angles at all stations between the ends."""
    inner = way[1:-1]
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
    pull = np.full(inner.size, np.sqrt(len(way) - 1))
    values = [weight * slopes.ravel(), np.full(len(out), weight), pull, -pull]
    rows_of = [rows, begin + out, after + place, after + hinges + place]
    columns_of = [columns, out, place, place]
    return coo_array(
        (np.concatenate(values), (np.concatenate(rows_of), np.concatenate(columns_of))),
        shape=(after + inner.size + hinges, inner.size),
    ).tocsc()


@dataclass(frozen=True)
class Closure:
    """The hinges around every interior vertex, counterclockwise.

    hinges : shape (m, d); axes : shape (m, d, 3), unit, in the flat sheet, zero behind the last
    hinge of a vertex that has fewer.
    """

    hinges: IntArray
    axes: FloatArray

    def errors(self, angles: FloatArray) -> tuple[FloatArray, FloatArray]:
        """By how much the turns miss the identity, rotation vectors, shape (n, m, 3); and the
        derivatives by the angles of the hinges, shape (n, m, d, 3).

        angles : shape (n, nh). Derivatives are exact where the vertices close.
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
    """The hinges around every interior vertex of the triangulated sheet."""
    triangles, coords = frame.triangles_vertices, frame.vertices_coords
    count = len(coords)
    corners = triangles.ravel()
    following = next_corner(3 * np.arange(len(triangles) + 1))
    before = np.empty_like(following)
    before[following] = np.arange(len(corners))
    beyond = next_around(corners, following, before, count)
    low, high = np.sort(frame.hinges_vertices[:, :2], axis=1).T
    keys = low * count + high
    order = np.argsort(keys)
    one, two = np.sort(np.column_stack([corners, corners[before]]), axis=1).T
    found = np.searchsorted(keys[order], one * count + two).clip(max=len(keys) - 1)
    side = order[found]
    axis = unit(coords[corners[before]] - coords[corners])
    inside = np.ones(count, bool)
    inside[corners[beyond < 0]] = False
    _, start = np.unique(corners, return_index=True)
    start = start[inside[corners[start]]]
    hinges, axes = [], []
    here, going = start.copy(), np.ones(len(start), bool)
    while going.any():
        hinges.append(np.where(going, side[here], 0))
        axes.append(np.where(going[:, None], axis[here], 0.0))
        here = np.where(going, beyond[here], here)
        going &= here != start
    if not hinges:
        return Closure(np.empty((0, 0), np.int64), np.empty((0, 0, 3)))
    return Closure(np.stack(hinges, axis=1), np.stack(axes, axis=1))
