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
from solver.errors import (
    InvalidState,
    InvalidValue,
    require_count,
    require_finite,
    require_number,
    require_positive,
    require_within,
)
from solver.front import Front, Rays
from solver.growth import Growth, Status, Stop, Strip, grow
from solver.mesh import QuadMesh, Side, boundary_loops
from solver.planarise import planarised
from solver.targets.base import Target, ray_hit
from solver.targets.parametric import TurnedTarget
from solver.vectors import BoolArray, FloatArray, IntArray, dot, norm, unit

__all__ = ["fit_surface"]

# Flap angles tried all around the circle; how near the last good one the next is expected; and how
# much more each crease may miss its mirror image there before all are tried again, as 1 - cosine.
_TRIALS = 1441
_NEAR = 0.05
_WORSE = 0.05

# What is tried where it is not given: zigzags in steps of v, distances of rows in thicknesses.
_ZIGZAGS = (3.0, 5.0, 8.0, 2.0, 12.0)
_ROW_STEPS = (1.0, 1.4, 0.7, 2.0, 2.8, 4.0)
# Directions of growth, from u to v, radians.
_TURNS = (0.0, np.pi / 2, np.pi / 4, -np.pi / 4)
# A zigzag may take up this share of the columns, lest it be the sheet.
_ZIGZAG_SHARE = 1 / 3
# A sheet that passes the domain, covers this share of it, and lies beyond it with no more than
# that share of its faces is good enough to look no further: what it misses lies at its sides, where
# a longer seed reaches.
_ENOUGH = 0.95
_BEYOND = 0.3
# Creases longer than this share of the domain's width along u are spikes, not a sheet.
_LONGEST = 0.4
# Sample points of the domain, along u and along v, by which coverage is counted.
_SAMPLES = 100
# Where points of a face are taken, between its corners, to see whether it reaches into the domain.
_WITHIN = np.linspace(0.0, 1.0, 9)
# Parts of an outline's edge that are taken as straight in the surface's parameters.
_PARTS = 4
# Columns added on either side, one number after another, where a trimmed sheet is too narrow.
_EXTRAS = (1, 2, 4, 8, 16)


_MOST_COLUMNS = 1000
_CURE = (
    "Where the length is nan the crease does not meet the other offset nearby. A smaller "
    "thickness, more columns, another zigzag, row_step or turn may reach further."
)


@dataclass(frozen=True)
class _Setting:
    """How a sheet is begun, in steps of v; `extra` columns stand beyond the domain either side."""

    columns: int
    thickness: float
    zigzag: float
    row_step: float
    turn: float
    extra: int = 0


@dataclass(frozen=True)
class _Fit:
    """A grown sheet, the places of its vertices in its grid's order, and its share beyond."""

    growth: Growth
    places: FloatArray
    beyond: float

    @property
    def rank(self) -> tuple[bool, float]:
        """Whether growth passed the domain, and how well it is covered: more is better."""
        return self.growth.status is Status.GROWN, self.covers - self.beyond / 4

    @property
    def covers(self) -> float:
        """Share of the domain under the sheet."""
        assert self.growth.coverage is not None
        return self.growth.coverage

    @property
    def good(self) -> bool:
        """Whether no other setting need be tried."""
        return self.rank[0] and self.covers >= _ENOUGH and self.beyond <= _BEYOND


def fit_surface(
    target: Target,
    columns: int,
    *,
    thickness: float = 1.0,
    zigzag: float | None = None,
    row_step: float | None = None,
    turn: float | None = None,
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
    zigzag, row_step : swing of the seed's rows along u, and their distance.
    turn : direction of growth, from u towards v, radians. Where one of these three is not given,
        the first choice that passes the domain is taken, or else the one that covers most of it.
    trim : drop the faces that lie outside the domain, as 9 x 9 points in each tell, having begun
        with a longer seed where the sheet would miss a part at its sides.
    progress : called with the number of strips grown and about how many are needed.

    Growth that cannot go on ends with a status; the mesh then covers part of the domain, and
    `Growth.coverage` says which share; `Growth.chosen` what was chosen. Raises `InvalidValue` for
    numbers out of bounds, and where no seed can be made.
    """
    require_count("columns", columns, 4, "A front needs vertices to follow a surface.")
    if columns > _MOST_COLUMNS:
        raise InvalidValue(
            "columns", columns, f"be at most {_MOST_COLUMNS}", "More would take hours."
        )
    if turn is not None:
        require_finite("turn", turn)
    require_number("thickness", thickness)
    for name, value in (("thickness", thickness), ("zigzag", zigzag), ("row_step", row_step)):
        if value is not None:
            require_within(name, value, 0.0, 1000.0, "It is counted in steps of v.")
    best: _Fit | None = None
    refused: InvalidValue | None = None
    tries = 0
    for z, r, t in _tried(columns, thickness, zigzag, row_step, turn):
        setting, tries = _Setting(columns, thickness, z, r, t), tries + 1
        try:
            fit = _grown(target, setting, progress)
        except InvalidValue as error:
            refused = refused or error
            continue
        if best is None or fit.rank > best.rank:
            best, chosen = fit, setting
        if fit.good:
            break
    if best is None:
        assert refused is not None  # one setting at least was tried
        if tries == 1:
            raise refused
        raise InvalidState(
            "surface",
            f"none of {tries} choices of zigzag, row_step and turn makes a seed: the surface is "
            "not smooth and shallow enough for a sheet of this thickness",
            f"Try a smaller thickness, more columns, or a part of it. The first failed: {refused}",
        )
    return _trimmed(target, chosen, best, progress) if trim else best.growth


def _tried(
    columns: int,
    thickness: float,
    zigzag: float | None,
    row_step: float | None,
    turn: float | None,
) -> Iterator[tuple[float, float, float]]:
    """Zigzags, row steps and turns to try, the mildest first."""
    largest = max(_ZIGZAG_SHARE * columns, min(_ZIGZAGS))
    zigzags = [z for z in _ZIGZAGS if z <= largest] if zigzag is None else [zigzag]
    row_steps = [thickness * share for share in _ROW_STEPS] if row_step is None else [row_step]
    turns = _TURNS if turn is None else (turn,)
    pairs = product(range(len(zigzags)), range(len(row_steps)))
    for z, r in sorted(pairs, key=lambda pair: (sum(pair), pair)):
        for t in turns:
            yield zigzags[z], row_steps[r], t


def _grown(target: Target, setting: _Setting, progress: Callable[[int, int], None] | None) -> _Fit:
    """A sheet grown both ways from a seed along u = 0."""
    target = TurnedTarget(target, setting.turn) if setting.turn else target
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
        raise InvalidState(
            "zigzag, row_step",
            f"zigzag {setting.zigzag:g} and row_step {setting.row_step:g} make no seed with planar "
            "faces across the middle of the surface",
            "Try other ones, a smaller thickness, more columns, or turn the sheet.",
        )
    mesh, places = QuadMesh.from_rows(seed[0]), seed[1]
    if not target.inside(places.reshape(-1, places.shape[2])).any():
        raise InvalidState(
            "domain", "the domain is nowhere near the line u = 0", "Move it to the middle."
        )
    expected = 2 + int(2 * along_u / (setting.row_step * step))
    strips, stops = 0, []
    for side, row, ahead in ((Side.TOP, 2, slice(None)), (Side.BOTTOM, 0, slice(None, None, -1))):
        follow = _Follower(target, places[row][ahead], offsets[row], _LONGEST * 2 * along_u)

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
    rim = _outline(target, _rim(mesh.vertices_coords[mesh.grid]), _rim(places))
    covers = _coverage(target, [rim])
    status, advice = Status.GROWN, ""
    if stops and covers < 1.0:
        status = stops[0][0]
        advice = " ".join([*(text for _, text in stops), _CURE])
    chosen = {
        "zigzag": setting.zigzag,
        "row_step": setting.row_step,
        "turn_deg": float(np.degrees(setting.turn)),
    }
    uv = places[..., :2]
    middles = (uv[:-1, :-1] + uv[1:, :-1] + uv[:-1, 1:] + uv[1:, 1:]) / 4
    beyond = 1 - float(target.inside(target.places(middles.reshape(-1, 2))).mean())
    growth = Growth(mesh, strips, status, advice, covers, chosen)
    return _Fit(growth, places, beyond)


def _steps(target: Target, columns: int) -> tuple[float, float]:
    """The step of v in space, and the mean length of u's unit, both along the line u = 0."""
    h = 1 / columns
    v = np.linspace(-1.0, 1.0, columns + 1)
    line = target.point(target.places(np.column_stack([0 * v, v])))
    step = float(norm(np.diff(line, axis=0)).mean())
    if not np.isfinite(line).all():
        raise InvalidState(
            "surface",
            "the line u = 0 leaves the surface between v = -1 and v = 1",
            "Turn the sheet, or take a part of the surface without notches there.",
        )
    ahead, behind = (target.point(target.places(np.column_stack([u + 0 * v, v]))) for u in (h, -h))
    along_u = float(norm(ahead - behind).mean()) / (2 * h)
    for name, value in (("length of the line u = 0", step), ("width along u", along_u)):
        require_positive(name, value, "The target must be a surface with area there.")
    return step, along_u


class _Follower:
    """Chooses strip after strip from one offset to the other, until the domain is passed."""

    def __init__(self, target: Target, places: FloatArray, offset: float, longest: float) -> None:
        self.target = target
        self.places = places
        self.offset = offset
        self.longest = longest
        self.rows: list[FloatArray] = []  # places of the rows grown
        self.found: dict[int, tuple[float, float]] = {}  # angle and cost by the strip's parity

    def choose(self, front: Front, strip: int) -> Strip | Stop:
        """The next strip, for `solver.growth.grow`."""
        middles = self.target.places((self.places[1:, :2] + self.places[:-1, :2]) / 2)
        if not self.target.inside(np.concatenate([self.places, middles])).any():
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
            return np.where(lengths < self.longest, lengths, np.nan)

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
        """Normal : of the target at the front's interior vertices, shape (n, 3)."""
        assert front.back is not None  # the seed has faces
        onward = -front.back
        wanted = unit(onward - 2 * dot(onward, normal)[:, None] * normal)
        frame = (-front.edges_direction[:-1], front.inner, front.normals)
        along = [dot(wanted, axis)[:, None] for axis in frame]
        return cls(along[0], along[1], along[2], front)

    def _parts(self, trials: FloatArray) -> tuple[FloatArray, ...]:
        f = self.front
        image = f.transfer_matrices @ np.stack([np.sin(trials / 2), np.cos(trials / 2)])
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
        speed = np.linalg.det(f.transfer_matrices)[:, None] / size  # d alpha / d alpha of the first
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


def _rim(grid: FloatArray) -> FloatArray:
    """Once around a grid (R, C, d), shape (n, d)."""
    return np.concatenate([grid[0], grid[1:, -1], grid[-1, -2::-1], grid[-2:0:-1, 0]])


def _outline(target: Target, points: FloatArray, places: FloatArray) -> FloatArray:
    """Parameters of the surface under a closed line in space, shape (n, 2).

    points : the line's vertices, shape (k, 3); places : nearest to them, shape (k, d).
    """
    ends = np.roll(points, -1, axis=0), np.roll(places, -1, axis=0)
    shares = np.arange(_PARTS)[:, None] / _PARTS
    between = points[:, None] + shares * (ends[0] - points)[:, None]
    guess = (places[:, None] + shares * (ends[1] - places)[:, None]).reshape(-1, places.shape[1])
    uv = target.distance(between.reshape(-1, 3), guess)[2][:, :2]
    return np.where(np.isfinite(uv), uv, guess[:, :2])


def _coverage(target: Target, outlines: list[FloatArray]) -> float:
    """Share of the domain within outlines (n, 2), counted on a grid of its parameters.

    What an outline goes around, however often, is under the sheet for certain.
    """
    grid = (np.arange(_SAMPLES) + 0.5) * (2 / _SAMPLES) - 1.0
    uv = np.stack(np.meshgrid(grid, grid), axis=-1).reshape(-1, 2)
    inside = uv[target.inside(target.places(uv))]
    return float((_windings(outlines, inside) != 0).mean()) if len(inside) else 0.0


def _windings(outlines: list[FloatArray], points: FloatArray) -> IntArray:
    """How often closed outlines (k, 2) go around points (n, 2), counterclockwise."""
    out = np.zeros(len(points), np.int64)
    x, y = points.T
    starts = np.concatenate(outlines)
    ends = np.concatenate([np.roll(outline, -1, axis=0) for outline in outlines])
    for (x0, y0), (x1, y1) in zip(starts.tolist(), ends.tolist(), strict=True):
        turn = (x1 - x0) * (y - y0) - (x - x0) * (y1 - y0)
        if y0 < y1:
            out += (y0 <= y) & (y < y1) & (turn > 0)
        else:
            out -= (y1 <= y) & (y < y0) & (turn < 0)
    return out


def _trimmed(
    target: Target,
    setting: _Setting,
    fit: _Fit,
    progress: Callable[[int, int], None] | None,
) -> Growth:
    """The sheet without faces outside the domain, grown wider first where a part is missing."""
    for extra in _EXTRAS:
        if fit.covers >= 1.0 or fit.growth.status is not Status.GROWN:
            break
        try:
            wider = _grown(target, replace(setting, extra=extra), progress)
        except InvalidValue:
            break
        if wider.growth.status is Status.GROWN and wider.covers > fit.covers:
            fit = wider
    if setting.turn:
        target = TurnedTarget(target, setting.turn)
    places = fit.places
    kept = np.zeros((len(places) - 1, places.shape[1] - 1), bool)
    for s, t in product(_WITHIN, _WITHIN):  # points all over each face
        lower = (1 - t) * places[:-1, :-1, :2] + t * places[:-1, 1:, :2]
        upper = (1 - t) * places[1:, :-1, :2] + t * places[1:, 1:, :2]
        uv = ((1 - s) * lower + s * upper).reshape(-1, 2)
        kept |= target.inside(target.places(uv)).reshape(kept.shape)
    if not kept.any():
        return fit.growth
    mesh = fit.growth.mesh.with_faces(_one_piece(kept))
    under = np.empty((len(mesh.vertices_coords), places.shape[2]))
    stands = mesh.grid >= 0
    under[mesh.grid[stands]] = places[stands]
    outlines = [
        _outline(target, mesh.vertices_coords[loop], under[loop])
        for loop in boundary_loops(mesh.edges)
    ]
    return replace(fit.growth, mesh=mesh, coverage=_coverage(target, outlines))


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
