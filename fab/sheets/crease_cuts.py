"""Cuts along creases: where each style cuts, fitted to each crease and made shorter by the kerf.

A style repeats marks (cuts at given places of a period) from one end of the crease's room to the
other; the last period is closed by its first mark, so that every row reads the same from both ends.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fab.drawings.beam import Beam
from fab.sheets.crease_styles import (
    CreaseStyle,
    DashDotStyle,
    DashStyle,
    DotStyle,
    EngraveStyle,
    LatticeStyle,
    NoStyle,
    ScoreStyle,
)
from solver.errors import InvalidValue, require_finite
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = [
    "SHORTEST_CUT_MM",
    "Cuts",
    "cuts_along",
    "require_dashes",
    "require_kerf",
    "unscaled_length",
]

# The room of a crease between its margins must be longer than this to be cut; pierces are drawn as
# cuts of this length.
SHORTEST_CUT_MM = 0.01
# More take a cutter days, and fill the memory.
_MOST_DASHES = 5_000_000
_WIDEST_KERF_MM = 10.0


@dataclass(frozen=True)
class Cuts:
    """Cuts of one style along many lines.

    Attributes
    ----------
    segments : shape (n, 2, 2): cut, end, coordinate, mm.
    owner : the number of each cut's line, shape (n,), rising.
    pierced : which cuts were not longer than the kerf and became pierces, shape (n,).
    """

    segments: FloatArray
    owner: IntArray
    pierced: BoolArray


def cuts_along(
    ends: FloatArray,
    style: CreaseStyle,
    trim_mm: float | FloatArray,
    kerf_mm: float | Beam = 0.0,
    made: int = 0,
) -> Cuts:
    """Cuts along lines, symmetrical in each line's room, with a whole number of periods in it.

    Parameters
    ----------
    ends : shape (n, 2, 2): line, end, coordinate, mm.
    trim_mm : what stays uncut at the ends of the lines; one length, or shape (n, 2). The room is
        the rest of the line.
    kerf_mm : width of the beam, or the beam. It lengthens each cut by half of it at both ends, so
        cuts are drawn shorter by the kerf along them, and gaps and margins come out as asked for.
        Cuts not longer than the kerf are drawn as pierces of 0.01 mm.
    made : number of cuts that the same sheet has already.

    All lengths of a pattern are scaled alike to fit; its first cut begins and its last one ends at
    the ends of the room. A line too short for two cuts has one in the middle of its room, not
    longer than asked for. A line with a room of 0.01 mm or less has none.

    Raises `InvalidValue` for a negative kerf, one that joins cuts, and for more than 5 million
    cuts in all.

    >>> line = np.array([[[0.0, 0.0], [11.0, 0.0]]])
    >>> cuts_along(line, DashStyle(cut_mm=3.0, gap_mm=1.0), 0.0).segments[..., 0].tolist()
    [[0.0, 3.0], [4.0, 7.0], [8.0, 11.0]]
    """
    beam = Beam.of(kerf_mm)
    require_kerf(beam)
    span = ends[:, 1] - ends[:, 0]
    length = np.hypot(span[:, 0], span[:, 1])
    trim = np.broadcast_to(np.asarray(trim_mm, np.float64), (len(ends), 2))
    room = length - trim.sum(axis=1)
    clears = beam.along(span)
    rows = _rows(room, style, float(beam.across(span).max(initial=0.0)), made)
    with np.errstate(divide="ignore", invalid="ignore"):
        direction = span / length[:, None]
    across = direction[:, ::-1] * [-1, 1]
    parts, pierced = [], []
    for row in rows:
        begin = row.begin + trim[row.owner, 0]
        along, short = _drawn(begin, begin + row.length, row.owner, clears[row.owner])
        origin = ends[row.owner, 0]
        if isinstance(style, LatticeStyle):
            origin = origin + row.height_mm[row.owner, None] * across[row.owner]
        parts.append(origin[:, None] + along[:, :, None] * direction[row.owner][:, None])
        pierced.append(short)
    if len(rows) == 1:
        return Cuts(parts[0], rows[0].owner, pierced[0])
    owner = np.concatenate([row.owner for row in rows])
    order = np.argsort(owner, kind="stable")
    return Cuts(np.concatenate(parts)[order], owner[order], np.concatenate(pierced)[order])


def unscaled_length(style: CreaseStyle, near_mm: float, periods: int = 2) -> float:
    """Length of a room of about `near_mm` in which cuts are exactly as long as the style says.

    periods : how many there are at least. Styles without a rhythm fit any room.

    >>> unscaled_length(DashStyle(cut_mm=3.0, gap_mm=1.0), 20.0)
    19.0
    """
    if isinstance(style, ScoreStyle | EngraveStyle | NoStyle):
        return near_mm
    period, marks = _rhythm(style)
    first = float(marks[0, 1])
    return first + period * max(periods, round((near_mm - first) / period))


def require_dashes(count: int) -> None:
    """Raise `InvalidValue` for more than 5 million cuts in all."""
    if count > _MOST_DASHES:
        raise InvalidValue(
            "number of dashes",
            count,
            f"be at most {_MOST_DASHES}",
            "Raise cut_mm and gap_mm, or make the sheet smaller or fewer copies of it.",
        )


def require_kerf(kerf_mm: float | Beam) -> None:
    """Raise `InvalidValue` unless both widths of the kerf are from 0 to 10, and both or none 0."""
    beam = Beam.of(kerf_mm)
    widths = (beam.x_mm, beam.y_mm)
    for width in widths:
        require_finite("kerf_mm", width)
    inside = all(0 <= width <= _WIDEST_KERF_MM for width in widths)
    if not inside or (beam.x_mm == 0) != (beam.y_mm == 0):
        raise InvalidValue(
            "kerf_mm",
            beam.x_mm if beam.is_round else widths,
            f"be from 0 to {_WIDEST_KERF_MM:g}",
            "Give the width of the material that the beam takes away, 0 for a knife.",
        )


@dataclass(frozen=True)
class _Row:
    """Wanted cuts of a row.

    Attributes
    ----------
    owner : the line of each cut; begin, length : where in the room it begins, how long it is, mm;
        shape (m,).
    height_mm : how far to the left of each line the row is, shape (n,).
    """

    owner: IntArray
    begin: FloatArray
    length: FloatArray
    height_mm: FloatArray


def _rows(room: FloatArray, style: CreaseStyle, kerf_mm: float, made: int) -> list[_Row]:
    """The wanted cuts of a style in rooms of these lengths, one row or those of a lattice."""
    period, marks = _rhythm(style)
    first = marks[0, 1]
    repeats, scale = _fitted(room, style, period, first)
    has = (room > SHORTEST_CUT_MM) & (not isinstance(style, NoStyle))
    many = has & (repeats > 0)
    heights = _heights_mm(style, kerf_mm)
    whole = np.where(has, repeats * len(marks) + 1, 0)
    # a line with room for a single cut has it in the first row, moved onto the line
    shifted, beside = np.where(many, repeats, 0), np.where(many, whole, 0)
    counts = [whole, *(shifted if row % 2 else beside for row in range(1, len(heights)))]
    total = made + sum(int(count.sum()) for count in counts)
    require_dashes(total)
    start = np.where(repeats > 0, 0.0, (room - scale * first) / 2)
    rows = []
    for row, (count, height) in enumerate(zip(counts, heights, strict=True)):
        owner = np.repeat(np.arange(len(room)), count)
        turn = np.arange(len(owner)) - np.repeat(np.cumsum(count) - count, count)
        place: float | FloatArray = row % 2 * period / 2
        size: float | FloatArray = first
        if len(marks) > 1:
            turn, mark = np.divmod(turn, len(marks))
            place, size = marks[mark, 0], marks[mark, 1]
        begin = start[owner] + scale[owner] * (turn * period + place)
        rows.append(_Row(owner, begin, scale[owner] * size, np.where(many, height, 0.0)))
    return rows


def _fitted(
    room: FloatArray, style: CreaseStyle, period: float, first: float
) -> tuple[IntArray, FloatArray]:
    """How often the period of a style is repeated in each room, and how it is scaled to fit."""
    if isinstance(style, ScoreStyle | EngraveStyle):
        return np.zeros(len(room), np.int64), room
    with np.errstate(divide="ignore", invalid="ignore"):
        repeats = np.maximum(0, np.rint((room - first) / period)).astype(np.int64)
        fitting = np.where(repeats > 0, repeats * period + first, np.maximum(first, room))
        return repeats, room / fitting


def _heights_mm(style: CreaseStyle, kerf_mm: float) -> FloatArray:
    """How far to the left of a line each row of a style is, shape (rows,)."""
    if not isinstance(style, LatticeStyle):
        return np.zeros(1)
    if style.pitch_mm <= kerf_mm:
        raise InvalidValue(
            "pitch_mm",
            style.pitch_mm,
            f"be greater than kerf_mm = {kerf_mm:g}",
            "Set the rows of the lattice further apart.",
        )
    side = style.width_mm / 2
    return np.linspace(-side, side, style.rows)


def _rhythm(style: CreaseStyle) -> tuple[float, FloatArray]:
    """Period, and the marks in it: where each begins and how long it is, shape (k, 2)."""
    match style:
        case DashStyle() | LatticeStyle():
            return style.cut_mm + style.gap_mm, np.array([[0.0, style.cut_mm]])
        case DashDotStyle():
            dot = style.cut_mm + style.gap_mm
            period = dot + style.dot_mm + style.gap_mm
            return period, np.array([[0.0, style.cut_mm], [dot, style.dot_mm]])
        case DotStyle():
            return style.pitch_mm, np.array([[0.0, style.dot_mm]])
    return 1.0, np.array([[0.0, 1.0]])


def _drawn(
    begin: FloatArray, end: FloatArray, owner: IntArray, kerf_mm: FloatArray
) -> tuple[FloatArray, BoolArray]:
    """What to draw for the wanted cuts of a row, shape (m, 2), and which become pierces (m,).

    kerf_mm : along each cut, shape (m,).
    """
    if not kerf_mm.any():
        return np.stack([begin, end], axis=1), np.zeros(len(begin), bool)
    pierced = end - begin - kerf_mm < SHORTEST_CUT_MM
    half = np.where(pierced, SHORTEST_CUT_MM, end - begin - kerf_mm) / 2
    middle = (begin + end) / 2
    along = np.stack([middle - half, middle + half], axis=1)
    between = (along[1:, 0] - along[:-1, 1])[owner[1:] == owner[:-1]]
    joined = kerf_mm[1:][owner[1:] == owner[:-1]]
    worst = int(np.argmin(between - joined)) if len(between) else 0
    if len(between) and between[worst] <= joined[worst]:
        raise InvalidValue(
            "kerf_mm",
            round(float(joined[worst]), 6),
            f"be less than {between[worst]:.6g}, the length drawn between two cuts",
            "Cuts would join: raise gap_mm or pitch_mm, or take the style score.",
        )
    return along, pierced
