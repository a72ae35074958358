"""How does a sheet grow along a surface, between its two offsets (figures 4A, S11 and S12)?

Seed: three zigzag rows across the middle of the surface, in turn on its lower and upper offset,
made planar and developable. Each strip's flap angle is the one whose creases come nearest to the
mirror images of those behind; its lengths reach the other offset. Growth goes both ways until the
surface's domain is passed.

Negative curvature wants shallow folds (rows far apart for the thickness) and large zigzags,
positive curvature steep folds. Rows across directions that are not conjugate drift along
themselves: turn the sheet to the surface's principal directions.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from scipy import ndimage
from scipy.optimize import brentq

from solver.arcs import contain
from solver.errors import InvalidValue, require_count, require_positive, require_within
from solver.front import Front, Rays
from solver.growth import Growth, Status, Stop, Strip, grow
from solver.mesh import QuadMesh, Side, boundary_loops
from solver.planarise import planarised
from solver.targets import Target, ray_hit
from solver.vectors import BoolArray, FloatArray, dot, norm, unit

__all__ = ["fit_surface"]

# Flap angles tried all around the circle; how near the last good one the next is expected; and how
# much more each crease may miss its mirror image there before all are tried again, as 1 - cosine.
_TRIALS = 1441
_NEAR = 0.05
_WORSE = 0.05

# What is tried where it is not given: zigzags in steps of v, distances of rows in thicknesses.
_ZIGZAGS = (3.0, 5.0, 8.0, 2.0, 12.0)
_ROW_STEPS = (1.0, 1.4, 0.7, 2.0, 2.8, 4.0)
# A sheet that passes the domain and covers this share of it is good enough to look no further:
# what it misses lies at its sides, where a longer seed reaches.
_ENOUGH = 0.95
# Sample points of the domain, along u and along v, by which coverage is counted.
_SAMPLES = 100
# Columns added on either side, one number after another, where a trimmed sheet is too narrow.
_EXTRAS = (1, 2, 4, 8, 16)


@dataclass(frozen=True)
class _Setting:
    """How a sheet is begun, in steps of v; `extra` columns stand beyond the domain either side."""

    columns: int
    thickness: float
    zigzag: float
    row_step: float
    extra: int = 0


@dataclass(frozen=True)
class _Fit:
    """A grown sheet, the places of its vertices in the order of its grid, and the coverage."""

    growth: Growth
    places: FloatArray

    @property
    def rank(self) -> tuple[bool, float]:
        """Whether growth passed the domain, and which share of it is covered: more is better."""
        assert self.growth.coverage is not None
        return self.growth.status is Status.GROWN, self.growth.coverage


def fit_surface(
    target: Target,
    columns: int,
    *,
    thickness: float = 1.0,
    zigzag: float | None = None,
    row_step: float | None = None,
    trim: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> Growth:
    """Grow a sheet whose rows lie in turn on both offsets of a surface, until it is covered.

    All lengths are counted in steps of v: the mean distance in space of the seed's points along
    the line u = 0, of which `columns` span the domain.

    Parameters
    ----------
    columns : quads across the domain.
    thickness : distance of the two offsets.
    zigzag, row_step : swing of the seed's rows along u, and their distance. Where one is not
        given, the first that passes the domain is taken, or else the one that covers most of it.
    trim : drop the faces that lie outside the domain altogether, having begun with a longer seed
        where the sheet would miss a part at its sides.
    progress : called with the number of strips grown and about how many are needed.

    Growth that cannot go on ends with a status; the mesh then covers part of the domain, and
    `Growth.coverage` says which share. Raises `InvalidValue` for numbers out of bounds, and for a
    seed that cannot be made.
    """
    require_count("columns", columns, 4, "A front needs vertices to follow a surface.")
    for name, value in (("thickness", thickness), ("zigzag", zigzag), ("row_step", row_step)):
        if value is not None:
            require_within(name, value, 0.0, 1000.0, "It is counted in steps of v.")
    best: _Fit | None = None
    refused: InvalidValue | None = None
    for z, r in _tried(thickness, zigzag, row_step):
        setting = _Setting(columns, thickness, z, r)
        try:
            fit = _grown(target, setting, progress)
        except InvalidValue as error:
            refused = error
            continue
        if best is None or fit.rank > best.rank:
            best, chosen = fit, setting
        if fit.rank >= (True, _ENOUGH):
            break
    if best is None:
        assert refused is not None  # one setting at least was tried
        raise refused
    return _trimmed(target, chosen, best, progress) if trim else best.growth


def _tried(
    thickness: float, zigzag: float | None, row_step: float | None
) -> Iterator[tuple[float, float]]:
    """Zigzags and row steps to try, the mildest first."""
    zigzags = _ZIGZAGS if zigzag is None else (zigzag,)
    row_steps = [thickness * share for share in _ROW_STEPS] if row_step is None else [row_step]
    pairs = product(range(len(zigzags)), range(len(row_steps)))
    return ((zigzags[z], row_steps[r]) for z, r in sorted(pairs, key=lambda p: (sum(p), p)))


def _grown(
    target: Target, setting: _Setting, progress: Callable[[int, int], None] | None
) -> _Fit:
    """A sheet grown both ways from a seed along u = 0."""
    m, extra = setting.columns, setting.extra
    v = 2 / m * np.arange(-extra, m + extra + 1) - 1.0
    step, along_u = _steps(target, m)
    rows = setting.row_step * step / along_u * np.arange(-1, 2)
    swing = setting.zigzag * step / along_u * (np.arange(len(v)) % 2 - 0.5)
    # three rows, so that the seed is not only planar but can go on on both of its sides
    uv = np.stack([np.column_stack([swing + u, v]) for u in rows])
    offsets = np.array([-0.5, 0.5, -0.5]) * setting.thickness * step
    places = target.places(uv.reshape(-1, 2)).reshape(*uv.shape[:2], -1)
    seed = planarised(target, places, offsets)
    if seed is None:
        raise InvalidValue(
            "zigzag, row_step",
            (setting.zigzag, setting.row_step),
            "allow a seed with planar faces across the middle of the surface",
            "Try other ones, a smaller thickness, more columns, or turn the sheet.",
        )
    mesh, places = QuadMesh.from_rows(seed[0]), seed[1]
    expected = 2 + int(2 * along_u / (setting.row_step * step))
    strips, stops = 0, []
    for side, row, ahead in ((Side.TOP, 2, slice(None)), (Side.BOTTOM, 0, slice(None, None, -1))):
        follow = _Follower(target, places[row][ahead], offsets[row])

        def tell(done: int, _: int, before: int = strips) -> None:
            if progress is not None:
                progress(min(before + done, expected), expected)

        growth = grow(mesh, 20 * m, follow.choose, side=side, progress=tell)
        mesh, strips = growth.mesh, strips + growth.strips
        new = np.array([row[ahead] for row in follow.rows[: growth.strips]])
        new = new.reshape(-1, *places.shape[1:])
        places = np.concatenate([places, new] if side is Side.TOP else [new[::-1], places])
        if growth.status is not Status.COVERED:
            way = "up" if side is Side.TOP else "down"
            stops.append((growth.status, f"Along u, {way}wards: {growth.advice}"))
    covers = _coverage(target, [_outline(places)])
    status = stops[0][0] if stops else Status.GROWN
    advice = " ".join(text for _, text in stops)
    return _Fit(Growth(mesh, strips, status, advice, covers), places)


def _steps(target: Target, columns: int) -> tuple[float, float]:
    """The step of v in space, and the mean length of u's unit, both along the line u = 0."""
    h = 1 / columns
    v = np.linspace(-1.0, 1.0, columns + 1)
    line = target.point(target.places(np.column_stack([0 * v, v])))
    step = float(norm(np.diff(line, axis=0)).mean())
    ahead, behind = (target.point(target.places(np.column_stack([u + 0 * v, v]))) for u in (h, -h))
    along_u = float(norm(ahead - behind).mean()) / (2 * h)
    for name, value in (("length of the line u = 0", step), ("width along u", along_u)):
        require_positive(name, value, "The target must be a surface with area, and finite there.")
    return step, along_u


class _Follower:
    """Chooses strip after strip from one offset to the other, until the domain is passed."""

    def __init__(self, target: Target, places: FloatArray, offset: float) -> None:
        self.target = target
        self.places = places
        self.offset = offset
        self.rows: list[FloatArray] = []  # places of the rows grown
        self.within = True  # whether any vertex of the row before last lies in the domain
        self.found: dict[int, tuple[float, float]] = {}  # angle and cost by the strip's parity

    def choose(self, front: Front, strip: int) -> Strip | Stop:
        """The next strip, for `solver.growth.grow`."""
        before, self.within = self.within, bool(self.target.inside(self.places).any())
        if not before and not self.within:
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
            lengths, self.places = ray_hit(
                self.target, rays.vertices_coords, rays.directions, self.offset, self.places
            )
            self.rows.append(self.places)
            return lengths

        return Strip(flap_angle, to_offset)

    def _flap_angle(self, front: Front, parity: int) -> float | None:
        """The free flap angle whose creases mirror those behind best; None where none is free.

        Looked for near that of the strip before the last, and all around only where it is not
        there any more or has become much worse.
        """
        free = front.free_flap_angles()
        if not len(free):
            return None
        mirror = _Mirror.of(front, self.target.normal(self.places[1:-1]))
        known = self.found.get(parity)
        if known is not None:
            angle = mirror.minimum(known[0] - _NEAR, known[0] + _NEAR)
            if angle is not None and _free(free, angle):
                cost = float(mirror.cost(np.array([angle]))[0])
                if cost <= known[1] + _WORSE * len(front.beta):
                    self.found[parity] = angle, cost
                    return angle
        angle = mirror.best_of(free)
        self.found[parity] = angle, float(mirror.cost(np.array([angle]))[0])
        return angle


def _free(free: FloatArray, angle: float) -> bool:
    return bool(contain(free, np.array([angle % (2 * np.pi)]))[0])


@dataclass(frozen=True)
class _Mirror:
    """How far the creases of a strip are from the mirror images of those behind.

    Creases are combinations of the vertices' frames, flap angles images of the first one.

    Attributes
    ----------
    along_a, along_inner, along_normal : the wanted directions in the frames, shape (n, 1).
    front : the front, its vertices' numbers in columns.
    """

    along_a: FloatArray
    along_inner: FloatArray
    along_normal: FloatArray
    front: Front

    @classmethod
    def of(cls, front: Front, normal: FloatArray) -> _Mirror:
        """normal : of the target at the front's interior vertices, shape (n, 3)."""
        assert front.back is not None  # the seed has faces
        onward = -front.back
        wanted = unit(onward - 2 * dot(onward, normal)[:, None] * normal)
        frame = (-front.edges_direction[:-1], front.inner, front.normals)
        return cls(*(dot(wanted, axis)[:, None] for axis in frame), front)

    def _parts(self, trials: FloatArray) -> tuple[FloatArray, ...]:
        f = self.front
        image = f.prefixes @ np.stack([np.sin(trials / 2), np.cos(trials / 2)])
        squares = image * image
        size = squares[:, 0] + squares[:, 1]
        cosine = (squares[:, 1] - squares[:, 0]) / size
        sine = 2 * image[:, 0] * image[:, 1] / size
        level = (f.run + f.sin_beta)[:, None] - f.sin_beta[:, None] * cosine
        return size, cosine, sine, level, np.hypot(f.rise[:, None], level)

    def cost(self, trials: FloatArray) -> FloatArray:
        """Sum over the creases of 1 - cosine to the wanted direction, shape (q,)."""
        _, cosine, sine, level, length = self._parts(trials)
        across = self.along_inner * cosine + self.along_normal * sine
        match = (self.along_a * level + self.front.rise[:, None] * across) / length
        out: FloatArray = (1 - match).sum(axis=0)
        return out

    def slope(self, trial: float) -> float:
        """Derivative of the cost with respect to the first flap angle, exact."""
        f = self.front
        size, cosine, sine, level, length = self._parts(np.array([trial]))
        rise = f.rise[:, None]
        across = self.along_inner * cosine + self.along_normal * sine
        turned = self.along_normal * cosine - self.along_inner * sine
        opening = -rise * f.sin_beta[:, None] * sine / length**2  # d theta1 / d alpha
        match = opening * (level * across - rise * self.along_a) / length + rise * turned / length
        speed = np.linalg.det(f.prefixes)[:, None] / size  # d alpha / d alpha of the first
        return -float((match * speed).sum())

    def minimum(self, low: float, high: float) -> float | None:
        """A flap angle between two others at which the cost is least; None where it falls out."""
        if not self.slope(low) < 0 < self.slope(high):
            return None
        return float(brentq(self.slope, low, high, xtol=1e-13))

    def best_of(self, free: FloatArray) -> float:
        """The free flap angle of least cost all around: the best of many trials, then polished."""
        trials = np.linspace(0.0, 2 * np.pi, _TRIALS, endpoint=False)
        inside = contain(free, trials)
        if not inside.any():  # arcs narrower than the trials' distance
            trials, inside = _middles(free), np.ones(len(free), bool)
        best = float(trials[np.argmin(np.where(inside, self.cost(trials), np.inf))])
        spread = 2 * np.pi / _TRIALS
        polished = self.minimum(best - spread, best + spread)
        return best if polished is None or not _free(free, polished) else polished


def _middles(arcs: FloatArray) -> FloatArray:
    start, end = arcs.T
    out: FloatArray = (start + ((end - start) % (2 * np.pi)) / 2) % (2 * np.pi)
    return out


def _outline(places: FloatArray) -> FloatArray:
    """Parameters around a patch, once, shape (n, 2); places (R, C, d)."""
    uv = places[:, :, :2]
    return np.concatenate([uv[0], uv[1:, -1], uv[-1, -2::-1], uv[-2:0:-1, 0]])


def _coverage(target: Target, outlines: list[FloatArray]) -> float:
    """Share of the domain within outlines (n, 2), counted on a grid of its parameters."""
    grid = (np.arange(_SAMPLES) + 0.5) * (2 / _SAMPLES) - 1.0
    uv = np.stack(np.meshgrid(grid, grid), axis=-1).reshape(-1, 2)
    inside = uv[target.inside(target.places(uv))]
    return float(_enclosed(outlines, inside).mean()) if len(inside) else 0.0


def _enclosed(outlines: list[FloatArray], points: FloatArray) -> BoolArray:
    """Whether points (n, 2) lie within closed outlines (k, 2): an odd number of sides to pass."""
    out = np.zeros(len(points), bool)
    x, y = points.T
    starts = np.concatenate(outlines)
    ends = np.concatenate([np.roll(outline, -1, axis=0) for outline in outlines])
    for (x0, y0), (x1, y1) in zip(starts.tolist(), ends.tolist(), strict=True):
        spans = (y0 <= y) != (y1 <= y)
        out ^= spans & ((x - x0) * (y1 - y0) < (y - y0) * (x1 - x0)) ^ (spans & (y1 < y0))
    return out


def _trimmed(
    target: Target,
    setting: _Setting,
    fit: _Fit,
    progress: Callable[[int, int], None] | None,
) -> Growth:
    """The sheet without faces outside the domain, grown wider first where a part is missing."""
    for extra in _EXTRAS:
        if fit.rank >= (True, 1.0) or not fit.rank[0]:
            break
        try:
            wider = _grown(target, replace(setting, extra=extra), progress)
        except InvalidValue:
            break
        if wider.rank > fit.rank:
            fit = wider
    places = fit.places
    inside = target.inside(places.reshape(-1, places.shape[2])).reshape(places.shape[:2])
    middles = (places[:-1, :-1] + places[1:, :-1] + places[:-1, 1:] + places[1:, 1:]) / 4
    kept = target.inside(target.places(middles[..., :2].reshape(-1, 2))).reshape(middles.shape[:2])
    kept |= inside[:-1, :-1] | inside[1:, :-1] | inside[:-1, 1:] | inside[1:, 1:]
    if not kept.any():
        return fit.growth
    mesh = fit.growth.mesh.with_faces(_one_piece(kept))
    uv = np.empty((len(mesh.vertices_coords), 2))
    stands = mesh.grid >= 0
    uv[mesh.grid[stands]] = places[stands][:, :2]
    covers = _coverage(target, [uv[loop] for loop in boundary_loops(mesh.edges)])
    return replace(fit.growth, mesh=mesh, coverage=covers)


def _one_piece(kept: BoolArray) -> BoolArray:
    """The largest piece of the cells kept, filled up where two of them touch in a corner alone."""
    labels, _ = ndimage.label(kept)
    out: BoolArray = labels == np.bincount(labels[kept]).argmax()
    while True:
        a, b, c, d = out[:-1, :-1], out[:-1, 1:], out[1:, :-1], out[1:, 1:]
        rising, falling = b & c & ~a & ~d, a & d & ~b & ~c
        if not (rising | falling).any():
            return out
        a |= rising
        b |= falling
