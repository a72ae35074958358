"""A generalised Miura sheet between two offsets of a target surface (figures 4A and S11)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.linalg import spsolve

from solver.arcs import contain
from solver.errors import InvalidValue, require_count, require_within
from solver.front import Front, Rays
from solver.growth import Growth, Status, Stop, Strip, grow
from solver.measure import angle_excess
from solver.mesh import QuadMesh, Side, interior_vertices
from solver.targets import ParametricSurface
from solver.transfer import prefix_products
from solver.vectors import BoolArray, FloatArray, IntArray, cross, dot, norm, unit

__all__ = ["SURFACES", "SurfaceFit", "fit_surface"]

# Flap angles tried all around the circle, and near a good one; how near; and what is much worse.
_TRIALS = 1441
_AROUND = 23
_NEAR = 0.05
_WORSE = 1.2


def _waves(u: FloatArray, v: FloatArray) -> FloatArray:
    a = 1.05 * np.pi
    return np.column_stack([u, v, 0.2 * np.sin(a * u) * np.cos(a * v)])


def _wave_derivatives(u: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
    a, one, zero = 1.05 * np.pi, np.ones_like(u), np.zeros_like(u)
    along_u = np.column_stack([one, zero, 0.2 * a * np.cos(a * u) * np.cos(a * v)])
    along_v = np.column_stack([zero, one, -0.2 * a * np.sin(a * u) * np.sin(a * v)])
    return along_u, along_v


def _cylinder(u: FloatArray, v: FloatArray) -> FloatArray:
    return np.column_stack([np.sin(u), v, np.cos(u)])


def _paraboloid(u: FloatArray, v: FloatArray) -> FloatArray:
    return np.column_stack([u, v, 0.4 * (u**2 + v**2)])


def _hypar(u: FloatArray, v: FloatArray) -> FloatArray:
    return np.column_stack([u, v, 0.5 * (u**2 - v**2)])


SURFACES = {
    "cylinder": ParametricSurface(_cylinder),
    "hypar": ParametricSurface(_hypar),
    "paraboloid": ParametricSurface(_paraboloid),
    "waves": ParametricSurface(_waves, _wave_derivatives),
}


@dataclass(frozen=True)
class SurfaceFit:
    """Seed: two planarised zigzag strips across the middle of the surface, between its offsets.

    Flap angle: the one whose creases come nearest to the mirror images of those behind. Lengths:
    up to the other offset surface. Grown both ways until the domain [-1, 1] x [-1, 1] is covered.

    Attributes
    ----------
    surface : the target: waves (figure 4A), cylinder, hypar or paraboloid.
    columns : m, number of quads across, along v.
    thickness : distance of the two offset surfaces, in steps of v (2 / columns).
    zigzag : swing of the rows along u, in steps of v; 2 to 6 grow far on waves.
    row_step : distance of the seed's rows along u, in steps of v. Saddles want larger steps and
        swings: the hypar grows with 8 and 1.4.
    """

    surface: str = "waves"
    columns: int = 40
    thickness: float = 1.0
    zigzag: float = 3.0
    row_step: float = 0.7

    def grow(self, progress: Callable[[int, int], None] | None = None) -> Growth:
        """Grow the sheet. Raises `InvalidValue` for parameters out of bounds."""
        if self.surface not in SURFACES:
            raise InvalidValue(
                "surface", self.surface, f"be one of {', '.join(SURFACES)}", "waves is figure 4A."
            )
        require_count("columns", self.columns, 4, "A front needs vertices to follow a surface.")
        for name, value in (
            ("thickness", self.thickness),
            ("zigzag", self.zigzag),
            ("row_step", self.row_step),
        ):
            require_within(name, value, 0.0, 100.0, "It is counted in steps of v.")
        return fit_surface(
            SURFACES[self.surface],
            self.columns,
            thickness=self.thickness * 2 / self.columns,
            zigzag=self.zigzag * 2 / self.columns,
            row_step=self.row_step * 2 / self.columns,
            progress=progress,
        )


def fit_surface(
    target: ParametricSurface,
    columns: int,
    *,
    thickness: float,
    zigzag: float,
    row_step: float,
    progress: Callable[[int, int], None] | None = None,
) -> Growth:
    """Grow a sheet over u, v in [-1, 1] whose rows lie in turn on both offsets of a surface.

    thickness : distance of the offsets; zigzag, row_step : of the seed's rows along u, as lengths
    of u. Growth that cannot go on ends with a status; the mesh then covers part of the domain.
    """
    v = np.linspace(-1.0, 1.0, columns + 1)
    swing = zigzag * (np.arange(columns + 1) % 2 - 0.5)
    # three rows, so that the seed is not only planar but can go on on both of its sides
    uv = np.stack([np.column_stack([swing + s * row_step, v]) for s in (-1, 0, 1)])
    offsets = np.array([-1.0, 1.0, -1.0]) * thickness / 2
    seed, uv = _planarised(target, uv, offsets)
    mesh = QuadMesh.from_rows(seed)
    most = int(20 * columns)
    strips = 0
    for side, row, way in ((Side.TOP, 2, 1.0), (Side.BOTTOM, 0, -1.0)):
        follow = _Follower(target, uv[row][:: int(way)], offsets[row], way)
        growth = grow(mesh, most, follow.choose, side=side, progress=progress)
        mesh, strips = growth.mesh, strips + growth.strips
        if growth.status is not Status.COVERED:
            advice = f"Towards u = {way:+g}: {growth.advice}"
            return Growth(mesh, strips, growth.status, advice)
    return Growth(mesh, strips)


class _Follower:
    """Chooses strip after strip from one offset surface to the other, until u is past 1 or -1."""

    def __init__(
        self, target: ParametricSurface, uv: FloatArray, offset: float, way: float
    ) -> None:
        self.target = target
        self.uv = uv
        self.offset = offset
        self.way = way
        self.found: dict[int, tuple[float, float]] = {}  # angle and cost by the strip's parity

    def choose(self, front: Front, strip: int) -> Strip | Stop:
        """The next strip, for `solver.growth.grow`."""
        if (self.way * self.uv[:, 0]).min() > 1.0:
            return Stop(Status.COVERED, "The domain is covered.")
        self.offset = -self.offset
        flap_angle = self._flap_angle(front, strip % 2)
        if flap_angle is None:
            return Stop(
                Status.FACES_CROSS,
                f"Strip {strip + 1}: at every flap angle new faces would cross old ones somewhere. "
                "A larger zigzag or row_step gives the front more room.",
            )

        def to_offset(rays: Rays) -> FloatArray:
            lengths, self.uv = self.target.ray_hit(
                rays.vertices_coords, rays.directions, self.offset, self.uv
            )
            return lengths

        return Strip(flap_angle, to_offset)

    def _flap_angle(self, front: Front, parity: int) -> float | None:
        """The free flap angle whose creases mirror those behind best; None where none is free.

        Looked for near that of the strip before the last, and all around only where that has
        become much worse.
        """
        free = front.free_flap_angles()
        if not len(free):
            return None
        cost = self._cost(front)
        known = self.found.get(parity)
        if known is not None:
            angle, value = _lowest(cost, free, known[0], _NEAR, _AROUND)
            if value <= _WORSE * known[1]:
                self.found[parity] = angle, value
                return angle
        angle, value = _lowest(cost, free, np.pi, np.pi, _TRIALS)
        self.found[parity] = angle, value
        return angle

    def _cost(self, front: Front) -> Callable[[FloatArray], FloatArray]:
        """Sum over the creases of 1 - cosine to the wanted direction, for many flap angles."""
        assert front.back is not None  # the seed has faces
        normal = self.target.normal(self.uv[1:-1])
        onward = -front.back
        wanted = unit(onward - 2 * dot(onward, normal)[:, None] * normal)
        # creases are combinations of the vertices' frames, flap angles images of the first one
        frame = (-front.edges_direction[:-1], front.inner, front.normals)
        along_a, along_inner, along_normal = (dot(wanted, w)[:, None] for w in frame)
        matrices = prefix_products(front.couplings, front.deltas)
        rise, run, sin_beta = (w[:, None] for w in (front.rise, front.run, front.sin_beta))

        def cost(trials: FloatArray) -> FloatArray:
            image = matrices @ np.stack([np.sin(trials / 2), np.cos(trials / 2)])
            s2, c2, sc = image[:, 0] ** 2, image[:, 1] ** 2, image[:, 0] * image[:, 1]
            size = s2 + c2
            level = run + 2 * sin_beta * s2 / size
            across = along_inner * (c2 - s2) + along_normal * (2 * sc)
            cosine = (along_a * level + rise * across / size) / np.hypot(rise, level)
            out: FloatArray = (1 - cosine).sum(axis=0)
            return out

        return cost


def _lowest(
    cost: Callable[[FloatArray], FloatArray],
    free: FloatArray,
    middle: float,
    reach: float,
    count: int,
) -> tuple[float, float]:
    """The flap angle of least cost within reach of another, and its cost (inf: none is free).

    Steps of trials, each ten times finer than the one before, down to the width of the minimum
    that rounding leaves.
    """
    best, value = middle, np.inf
    while reach > 1e-9:
        trials = (middle + np.linspace(-reach, reach, count)) % (2 * np.pi)
        values = np.where(contain(free, trials), cost(trials), np.inf)
        place = int(np.argmin(values))
        if values[place] < value:
            best, value = float(trials[place]), float(values[place])
        if not np.isfinite(value):
            break
        reach *= 2.2 / (count - 1)
        middle, count = best, _AROUND
    return best, value


def _planarised(
    target: ParametricSurface, uv: FloatArray, offsets: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Rows with planar quads, developable inner vertices, each on its offset (S27, S28).

    uv : parameters of the rows, shape (R, m + 1, 2). Returns points (R, m + 1, 3) and their uv.
    Gauss-Newton; the vertices move least: each step is the shortest that meets the linearised
    constraints.
    """
    rows, width = uv.shape[:2]
    flat_uv = uv.reshape(-1, 2)
    level = np.repeat(offsets, width)
    points = target.point(flat_uv) + level[:, None] * target.normal(flat_uv)
    quads = QuadMesh.from_rows(points.reshape(rows, width, 3)).faces_vertices
    inside = interior_vertices(quads, len(points))
    scale = float(np.linalg.norm(points[quads[:, 2]] - points[quads[:, 0]], axis=1).max())
    for _ in range(30):
        distance, normal, flat_uv = target.distance(points, flat_uv)
        everywhere = np.arange(len(points))
        parts = [
            _planarity_rows(points, quads, scale),
            _sector_rows(points, quads, inside),
            ((distance - level) / scale, (everywhere, everywhere, normal / scale)),
        ]
        miss = np.concatenate([part[0] for part in parts])
        jacobian = _assembled([(len(part[0]), *part[1]) for part in parts], len(points))
        step = jacobian.T @ spsolve((jacobian @ jacobian.T).tocsc(), -miss)
        points = points + step.reshape(-1, 3)
        if np.abs(step).max() < 1e-15 * scale or not np.isfinite(step).all():
            break
    return points.reshape(rows, width, 3), target.nearest(points, flat_uv).reshape(rows, width, 2)


def _planarity_rows(
    points: FloatArray, quads: IntArray, scale: float
) -> tuple[FloatArray, tuple[IntArray, IntArray, FloatArray]]:
    """Volume of each quad over scale^3, with (constraint, vertex, gradient) triples."""
    p = points[quads]
    e = (p[:, 1:] - p[:, :1]) / scale
    slopes = [cross(e[:, 1], e[:, 2]), cross(e[:, 2], e[:, 0]), cross(e[:, 0], e[:, 1])]
    gradients = np.stack([-(slopes[0] + slopes[1] + slopes[2]), *slopes], axis=1) / scale
    constraint = np.repeat(np.arange(len(quads)), 4)
    return dot(e[:, 0], slopes[0]), (constraint, quads.ravel(), gradients.reshape(-1, 3))


def _sector_rows(
    points: FloatArray, quads: IntArray, inside: BoolArray
) -> tuple[FloatArray, tuple[IntArray, IntArray, FloatArray]]:
    """Angle excess of each inner vertex, with (constraint, vertex, gradient) triples."""
    excess = angle_excess(points, quads, inside)[inside]
    number = np.cumsum(inside) - 1
    corner = quads.ravel()
    ends = np.roll(quads, -1, axis=1).ravel(), np.roll(quads, 1, axis=1).ravel()
    keep = inside[corner]
    corner, after, before = corner[keep], ends[0][keep], ends[1][keep]
    u, v = points[after] - points[corner], points[before] - points[corner]
    size_u, size_v = norm(u)[:, None], norm(v)[:, None]
    u, v = u / size_u, v / size_v
    cosine = dot(u, v)[:, None]
    sine = norm(cross(u, v))[:, None]
    by_u, by_v = (cosine * u - v) / (size_u * sine), (cosine * v - u) / (size_v * sine)
    constraint = np.tile(number[corner], 3)
    vertex = np.concatenate([after, before, corner])
    return excess, (constraint, vertex, np.concatenate([by_u, by_v, -by_u - by_v]))


def _assembled(parts: list[tuple[int, IntArray, IntArray, FloatArray]], count: int) -> csr_array:
    """One sparse Jacobian of all constraints over the 3 x count coordinates."""
    rows, columns, values = [], [], []
    begin = 0
    for size, constraint, vertex, gradient in parts:
        rows.append(np.repeat(constraint + begin, 3))
        columns.append((3 * vertex[:, None] + np.arange(3)).ravel())
        values.append(gradient.ravel())
        begin += size
    entries = np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))
    return csr_array(entries, shape=(begin, 3 * count))
