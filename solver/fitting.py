"""Surface fitting: a sheet grown between the two offsets of a surface (figures 4A, S11 and S12).

Seed: three zigzag rows across the middle of the surface, in turn on its lower and upper offset,
made planar and developable. Each strip's flap angle is the one whose creases come nearest to the
mirror images of those behind, or the one of least cost S30; its lengths reach the other offset.
Growth goes both ways until the surface's domain is passed.

Negative curvature wants shallow folds (rows far apart for the thickness) and large zigzags,
positive curvature steep folds. Rows across directions that are not conjugate drift along
themselves: turn the sheet to the surface's principal directions.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from solver.coverage import coverage, one_piece, outline, rim
from solver.ending_rows import grow_ending
from solver.errors import (
    InvalidState,
    InvalidValue,
    require_count,
    require_finite,
    require_number,
    require_positive,
    require_within,
)
from solver.following import COSTS, Follower
from solver.growth import Growth, Status, grow
from solver.mesh import QuadMesh, Side, boundary_loops
from solver.planarise import planarised
from solver.targets.base import Target
from solver.targets.parametric import TurnedTarget
from solver.vectors import BoolArray, FloatArray, norm

__all__ = ["fit_surface"]

# What is tried where it is not given: zigzags in steps of v, distances of rows in thicknesses.
_ZIGZAGS = (3.0, 5.0, 8.0, 2.0, 12.0)
_ROW_STEPS = (1.0, 1.4, 0.7, 2.0, 2.8, 4.0)
# Directions of growth, from u to v, radians.
_TURNS = (0.0, np.pi / 2, np.pi / 4, -np.pi / 4)
# A zigzag may take up this share of the columns: a larger one would be the whole sheet.
_ZIGZAG_SHARE = 1 / 3
# A sheet that passes the domain, covers the first share of it, and has no more than the second
# share of its faces beyond it is good enough to look no further: what it misses is at its sides,
# where a longer seed reaches.
_ENOUGH = 0.95
# A sheet whose rows ended must cover this share: there a longer seed reaches no further.
_ENOUGH_ENDED = 0.99
_BEYOND = 0.3
# Creases longer than this share of the domain's width along u are spikes, not a sheet.
_LONGEST = 0.4
# Where points of a face are taken, between its corners, to see whether it reaches into the domain.
_WITHIN = np.linspace(0.0, 1.0, 9)
# As many of the best settings are tried again with lookahead.
_SECOND_TRIES = 6
# Columns added on either side, one number after another, where a trimmed sheet is too narrow.
_EXTRAS = (1, 2, 4, 8, 16)


_MOST_COLUMNS = 1000
_CURE = (
    "Where the length is nan the crease does not meet the other offset nearby. A smaller "
    "thickness, more columns, another zigzag, row_step or turn, rows that may end or lookahead may "
    "reach further."
)


@dataclass(frozen=True)
class _Setting:
    """How a sheet is begun, in steps of v; `extra` columns are beyond the domain on either side."""

    columns: int
    thickness: float
    zigzag: float
    row_step: float
    turn: float
    cost: str
    rows_may_end: bool
    lookahead: bool = False
    extra: int = 0


@dataclass(frozen=True)
class _Fit:
    """A grown sheet, the places of its vertices in its grid's order, and its share beyond.

    Places are NaN where the grid has no vertex.
    """

    growth: Growth
    places: FloatArray
    beyond: float

    @property
    def rank(self) -> tuple[int, float]:
        """Whether growth passed the domain, and how well it is covered: more is better.

        A sheet whose rows ended comes before those that stopped, and is with the whole ones where
        it covers nearly all of the domain.
        """
        level = 0
        if self.growth.status is Status.GROWN:
            whole = bool((self.growth.mesh.grid >= 0).all())
            level = 2 if whole or self.covers >= _ENOUGH_ENDED else 1
        return level, self.covers - self.beyond / 4

    @property
    def covers(self) -> float:
        """Share of the domain under the sheet."""
        assert self.growth.coverage is not None
        return self.growth.coverage

    @property
    def good(self) -> bool:
        """Whether no other setting need be tried."""
        return self.rank[0] == 2 and self.covers >= _ENOUGH and self.beyond <= _BEYOND


def fit_surface(
    target: Target,
    columns: int,
    *,
    thickness: float = 1.0,
    zigzag: float | None = None,
    row_step: float | None = None,
    turn: float | None = None,
    trim: bool = False,
    cost: str = "mirror",
    rows_may_end: bool = False,
    lookahead: bool = False,
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
    trim : drop the faces that are outside the domain at all of 9 x 9 points, having begun with a
        longer seed where the sheet would miss a part at its sides.
    cost : what each flap angle makes least (`COSTS`): "mirror", the creases' distances to the
        mirror images of those behind, or "design_angles", the paper's S30 (`solver.flap_costs`).
    rows_may_end : where a vertex at the side of a front misses its offset, the front goes on
        without it (`solver.ending_rows`), in place of stopping. Sheets that grow whole stay so.
    lookahead : where no choice is good enough, the best of them are tried again, each flap angle
        chosen so that the strip after it misses its offset least: a few times slower.
    progress : called with the number of strips grown and about how many are needed.

    Growth that cannot go on ends with a status; the mesh then covers part of the domain, and
    `Growth.coverage` says which share; `Growth.chosen` what was chosen. Raises `InvalidValue` for
    numbers out of bounds, and `InvalidState` where no seed can be made.

    >>> from solver.targets import explicit_surface
    >>> saddle = explicit_surface(lambda x, y: 0.2 * (x**2 - y**2))
    >>> growth = fit_surface(saddle, 8, zigzag=3.0, row_step=1.4, turn=0.0)
    >>> growth.status, growth.coverage > 0.9
    (<Status.GROWN: 'grown'>, True)
    """
    require_count("columns", columns, 4, "A front needs vertices to follow a surface.")
    if columns > _MOST_COLUMNS:
        raise InvalidValue(
            "columns", columns, f"be at most {_MOST_COLUMNS}", "More would take hours."
        )
    if turn is not None:
        require_finite("turn", turn)
    if cost not in COSTS:
        raise InvalidValue("cost", cost, f"be one of {', '.join(COSTS)}", "mirror is the default.")
    require_number("thickness", thickness)
    for name, value in (("thickness", thickness), ("zigzag", zigzag), ("row_step", row_step)):
        if value is not None:
            require_within(name, value, 0.0, 1000.0, "It is counted in steps of v.")
    settings = [
        _Setting(columns, thickness, *choice, cost, rows_may_end)
        for choice in _choices(columns, thickness, zigzag, row_step, turn)
    ]
    setting, fit = _best_fit(target, settings, lookahead, progress)
    return _trimmed(target, setting, fit, progress) if trim else fit.growth


def _best_fit(
    target: Target,
    settings: list[_Setting],
    lookahead: bool,
    progress: Callable[[int, int], None] | None,
) -> tuple[_Setting, _Fit]:
    """The first setting that is good, or else the best of all, and its sheet.

    lookahead : whether the best settings are tried again with it where none is good.
    """
    best: tuple[_Setting, _Fit] | None = None
    tried: list[tuple[tuple[int, float], _Setting]] = []
    refused: InvalidValue | None = None
    for setting in settings:
        try:
            fit = _grown(target, setting, progress)
        except InvalidValue as error:
            refused = refused or error
            tried.append(((0, -1.0), setting))
            continue
        tried.append((fit.rank, setting))
        if best is None or fit.rank > best[1].rank:
            best = setting, fit
        if fit.good:
            return best
    if lookahead:
        tried.sort(key=lambda found: found[0], reverse=True)  # stable: the first of equals leads
        for _, setting in tried[:_SECOND_TRIES]:
            again = replace(setting, lookahead=True)
            try:
                fit = _grown(target, again, progress)
            except InvalidValue:
                continue
            if best is None or fit.rank > best[1].rank:
                best = again, fit
            if fit.good:
                break
    if best is None:
        assert refused is not None  # one setting at least was tried
        if len(settings) == 1:
            raise refused
        raise InvalidState(
            "surface",
            f"none of {len(settings)} choices of zigzag, row_step and turn makes a seed: the "
            "surface is not smooth and shallow enough for a sheet of this thickness",
            f"Try a smaller thickness, more columns, or a part of it. The first failed: {refused}",
        )
    return best


def _choices(
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
    step, along_u = _steps(target, setting.columns)
    offsets = np.array([-0.5, 0.5, -0.5]) * setting.thickness * step
    mesh, places = _seed(target, setting, offsets, step, along_u)
    expected = 2 + int(2 * along_u / (setting.row_step * step))
    strips, stops, ends = 0, [], []
    for side, row, ahead in ((Side.TOP, 2, slice(None)), (Side.BOTTOM, 0, slice(None, None, -1))):
        longest = _LONGEST * 2 * along_u
        follow = Follower(
            target,
            places[row][ahead],
            offsets[row],
            longest,
            cost=setting.cost,
            lookahead=setting.lookahead,
        )

        def report(done: int, _: int, before: int = strips) -> None:
            if progress is not None:
                progress(min(before + done, expected), expected)

        direction = "upwards" if side is Side.TOP else "downwards"
        most = 20 * setting.columns
        firsts: tuple[int, ...] = ()
        if setting.rows_may_end:
            ended = grow_ending(mesh, most, follow, side=side, progress=report)
            growth, firsts = ended.growth, ended.firsts
            if ended.ended is not None:
                ends.append((ended.ended.status, f"Along u, {direction}: {ended.ended.advice}"))
        else:
            growth = grow(mesh, most, follow.choose, side=side, progress=report)
            firsts = (0,) * growth.strips
        mesh, strips = growth.mesh, strips + growth.strips
        new = np.full((growth.strips, *places.shape[1:]), np.nan)
        for under, first, found in zip(new, firsts, follow.rows, strict=False):
            under[first : first + len(found)] = found
        new = new[:, ahead]
        places = np.concatenate([places, new] if side is Side.TOP else [new[::-1], places])
        if growth.status is not Status.COVERED:
            stops.append((growth.status, f"Along u, {direction}: {growth.advice}"))
    covers = coverage(target, _outlines(target, mesh, places))
    status, advice = Status.GROWN, ""
    if (stops and covers < 1.0) or (ends and covers < _ENOUGH):
        status = (stops or ends)[0][0]
        advice = " ".join([*(text for _, text in stops or ends), _CURE])
    chosen = {
        "zigzag": setting.zigzag,
        "row_step": setting.row_step,
        "turn_deg": float(np.degrees(setting.turn)),
    }
    uv = places[..., :2]
    middles = (uv[:-1, :-1] + uv[1:, :-1] + uv[:-1, 1:] + uv[1:, 1:]) / 4
    middles = middles[_cells(mesh)]
    beyond = 1 - float(target.inside(target.places(middles)).mean())
    growth = Growth(mesh, strips, status, advice, covers, chosen)
    return _Fit(growth, places, beyond)


def _cells(mesh: QuadMesh) -> BoolArray:
    """Which cells of a grown sheet's grid are faces, shape (R - 1, C - 1)."""
    held = mesh.grid >= 0
    out: BoolArray = held[:-1, :-1] & held[1:, :-1] & held[:-1, 1:] & held[1:, 1:]
    return out


def _outlines(target: Target, mesh: QuadMesh, places: FloatArray) -> list[FloatArray]:
    """Parameters of the surface under the outline of a sheet; places in its grid's order."""
    held = mesh.grid >= 0
    if held.all():
        return [outline(target, rim(mesh.vertices_coords[mesh.grid]), rim(places))]
    under = np.empty((len(mesh.vertices_coords), places.shape[2]))
    under[mesh.grid[held]] = places[held]
    loops = boundary_loops(mesh.edges)
    return [outline(target, mesh.vertices_coords[loop], under[loop]) for loop in loops]


def _seed(
    target: Target, setting: _Setting, offsets: FloatArray, step: float, along_u: float
) -> tuple[QuadMesh, FloatArray]:
    """Three zigzag rows along u = 0 on these offsets, and the places of their vertices.

    step : of v in space; along_u : length in space of u's unit.

    Three, so that the seed is not only planar but can go on at both of its sides.
    """
    m, extra = setting.columns, setting.extra
    v = 2 / m * np.arange(-extra, m + extra + 1) - 1.0
    rows = setting.row_step * step / along_u * np.arange(-1, 2)
    swing = setting.zigzag * step / along_u * (np.arange(len(v)) % 2 - 0.5)
    uv = np.stack([np.column_stack([swing + u, v]) for u in rows])
    places = target.places(uv.reshape(-1, 2)).reshape(*uv.shape[:2], -1)
    seed = planarised(target, places, offsets)
    if seed is None:
        raise InvalidState(
            "zigzag, row_step",
            f"zigzag {setting.zigzag:g} and row_step {setting.row_step:g} make no seed with planar "
            "faces across the middle of the surface",
            "Try other ones, a smaller thickness, more columns, or turn the sheet.",
        )
    coords, places = seed
    if not target.inside(places.reshape(-1, places.shape[2])).any():
        raise InvalidState(
            "domain", "the domain is nowhere near the line u = 0", "Move it to the middle."
        )
    return QuadMesh.from_rows(coords), places


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
    held = _cells(fit.growth.mesh)
    uv = fit.places[..., :2]
    corners = [uv[:-1, :-1][held], uv[:-1, 1:][held], uv[1:, :-1][held], uv[1:, 1:][held]]
    reaching: BoolArray = np.zeros(len(corners[0]), bool)
    for s, t in product(_WITHIN, _WITHIN):  # points all over each face
        lower = (1 - t) * corners[0] + t * corners[1]
        upper = (1 - t) * corners[2] + t * corners[3]
        reaching |= target.inside(target.places((1 - s) * lower + s * upper))
    if not reaching.any():
        return fit.growth
    kept = np.zeros(held.shape, bool)
    kept[held] = reaching
    mesh = fit.growth.mesh.with_faces(one_piece(kept, held))
    return replace(
        fit.growth, mesh=mesh, coverage=coverage(target, _outlines(target, mesh, fit.places))
    )
