"""Dashes of creases joined to whole lines, and lines that end near a vertex drawn on to it.

Laser drawings and exploded linetypes have a crease as a row of short lines. A row is made of lines
of one assignment on one straight line whose gaps are alike and whose ends touch nothing else; cuts
and borders are never joined, as rows of slits are patterns of their own.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import shapely

from fab.errors import Finding, Severity
from fab.formats.drawn.line_soup import Letters, LineSoup
from solver.graphs import labels
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["Rows", "extended", "facing", "join_dashes", "of_rows", "rows_of"]

_NEVER_JOINED = ("B", "C", "J")
_LEAST_DASHES = 3
# How many ends near an end are looked at, and then.
_NEIGHBOURS = (9, 64)
# Places in a drawing of unknown precision are off by this, over its size; a dash whose ends are off
# by so much points wrong by twice that over its length, and is no dash where that is over _BEND.
_NOISE_REL = 3e-5
_BEND = 0.05
# Gaps of a row, over their median; wider ones part two rows.
_WIDEST_GAP = 1.6
# Over the gap: nearer to another line an end touches it.
_TOUCH = 0.02
# Over the noise: farther from the line of their row dashes make no row.
_OFF_LINE = 4.0
_CHUNK = 200_000
# Sine of the least angle at which lines meet in a vertex.
_PARALLEL = 1e-3


@dataclass(frozen=True)
class Rows:
    """Rows of dashes among lines.

    Attributes
    ----------
    row : of each line, shape (n,); lines that are no dash are a row of their own.
    ends : of each row, shape (rows, 2, 2).
    dashes : how many lines each row has, shape (rows,).
    gap : the widest of each row, shape (rows,), 0 where there is none.
    """

    row: IntArray
    ends: FloatArray
    dashes: IntArray
    gap: FloatArray


def join_dashes(soup: LineSoup) -> LineSoup:
    """The lines with dashes of creases joined, and a finding of how many.

    An end of a joined row that another line crosses within one gap is drawn on to that line.
    """
    if not len(soup.lines_coords):
        return soup
    size = float(np.ptp(soup.lines_coords.reshape(-1, 2), axis=0).max())
    rows = rows_of(soup, _LEAST_DASHES, _NOISE_REL * size)
    joined = rows.dashes > 1
    if not joined.any():
        return soup
    loose = np.repeat(joined[:, None], 2, axis=1)
    reach = 1.1 * rows.gap
    ends, _ = extended(rows.ends, loose, reach, 0.05 * float(rows.gap[joined].min()), 1)
    count, dashes = int(joined.sum()), int(rows.dashes[joined].sum())
    finding = Finding(
        "dashes-joined",
        Severity.NOTE,
        f"{dashes} dashes in {count} {'row' if count == 1 else 'rows'} are joined to "
        f"{'a whole line' if count == 1 else 'whole lines'}.",
    )
    return of_rows(soup, rows, ends, finding)


def of_rows(soup: LineSoup, rows: Rows, ends: FloatArray, *findings: Finding) -> LineSoup:
    """The drawing with one line for each row; angles that differ within a row are left out."""
    _, first = np.unique(rows.row, return_index=True)
    angles = soup.lines_foldAngle[first].copy()
    unlike = ~(soup.lines_foldAngle == angles[rows.row])
    angles[np.unique(rows.row[unlike])] = np.nan
    return replace(
        soup,
        lines_coords=ends,
        lines_assignment=soup.lines_assignment[first],
        lines_foldAngle=angles,
        lines_element=soup.lines_element[first],
        findings=(*soup.findings, *findings),
    )


def rows_of(soup: LineSoup, least: int, noise: float) -> Rows:
    """The rows of at least `least` dashes that the lines of a drawing make.

    noise : how far the ends of the lines may be from where they are meant.
    """
    coords = soup.lines_coords
    count = len(coords)
    has_length = (coords[:, 0] != coords[:, 1]).any(axis=1)
    dashes = np.flatnonzero(~np.isin(soup.lines_assignment, _NEVER_JOINED) & has_length)
    pairs, gaps = np.empty((0, 2), np.int64), np.empty(0)
    if len(dashes):
        pairs, gaps = _links(coords, soup.lines_assignment, dashes, noise)
    if len(pairs):
        free = _free(coords, pairs, gaps)
        pairs, gaps = pairs[free], gaps[free]
    lines = pairs // 2
    row = labels(lines, count)
    if len(pairs):
        near = gaps <= _WIDEST_GAP * _medians(gaps, row[lines[:, 0]])
        lines, gaps = lines[near], gaps[near]
        row = labels(lines, count)
    _, off = _spans(coords, row)
    sizes = np.bincount(row, minlength=len(off))
    straight = (off <= _OFF_LINE * noise) & (sizes >= least)
    kept = straight[row[lines[:, 0]]]
    row = labels(lines[kept], count)
    ends, _ = _spans(coords, row)
    widest = np.zeros(len(ends))
    np.maximum.at(widest, row[lines[kept, 0]], gaps[kept])
    return Rows(row, ends, np.bincount(row, minlength=len(ends)), widest)


def _links(
    coords: FloatArray, letters: Letters, dashes: IntArray, noise: float
) -> tuple[IntArray, FloatArray]:
    """Ends (2 line + end) that face each other across a gap, shape (m, 2), and the gaps (m,)."""
    found, widths = [np.empty((0, 2), np.int64)], [np.empty(0)]
    alone = _alone(coords)
    span = coords[:, 1] - coords[:, 0]
    length = np.hypot(span[:, 0], span[:, 1])
    for letter in np.unique(letters[dashes]).tolist():
        own = dashes[letters[dashes] == letter]
        own = own[alone[own].any(axis=1)]
        if len(own) < 2:
            continue
        ends = coords[own].reshape(-1, 2)
        along = span[own] / length[own, None]
        outward = np.stack([-along, along], axis=1).reshape(-1, 2)
        best, width = facing(
            ends, outward, np.repeat(own, 2), np.repeat(length[own], 2), noise, alone[own].ravel()
        )
        first = np.flatnonzero(best >= 0)
        mutual = first[(best[best[first]] == first) & (first < best[first])]
        pair = np.column_stack([mutual, best[mutual]])
        found.append(2 * own[pair // 2] + pair % 2)
        widths.append(width[mutual])
    return np.concatenate(found), np.concatenate(widths)


def _alone(coords: FloatArray) -> BoolArray:
    """Which ends are no end of another line, shape (n, 2)."""
    points = coords.reshape(-1, 2)
    grid = np.rint((points - points.min(axis=0)) / max(float(np.ptp(points)), 1e-300) * 1e9)
    _, place, count = np.unique(grid @ [1, 1j], return_inverse=True, return_counts=True)
    return np.asarray(count[place.ravel()] == 1).reshape(-1, 2)


def facing(
    ends: FloatArray,
    outward: FloatArray,
    line: IntArray,
    length: FloatArray,
    noise: float,
    wanted: BoolArray | None = None,
) -> tuple[IntArray, FloatArray]:
    """The nearest end that each wanted end faces, -1 where there is none, and how far away it is.

    Few neighbours are looked at first, and then more of the ends that face none of these, up to
    the gaps found: where many creases meet at small angles, the next dash is far down the list.

    Parameters
    ----------
    ends, outward : shape (n, 2), points and the unit vectors in which their lines would go on.
    line, length : which line each end is of, and how long that is, shape (n,).
    noise : how far ends may be from where they are meant.
    wanted : which ends are asked for, shape (n,); all if None.
    """
    from scipy.spatial import KDTree

    wanted = np.ones(len(ends), bool) if wanted is None else wanted
    bend = np.minimum(2 * noise / length, _BEND)
    tree = KDTree(ends)
    best = np.full(len(ends), -1)
    width = np.full(len(ends), np.inf)
    farthest = np.inf
    for count in _NEIGHBOURS:
        lacking = np.flatnonzero((best < 0) & wanted)
        chunk = _CHUNK // count
        for start in range(0, len(lacking), chunk):
            own = lacking[start : start + chunk]
            distance, other = tree.query(
                ends[own], k=min(count, len(ends)), distance_upper_bound=farthest
            )
            other = np.minimum(other, len(ends) - 1)
            step = ends[other] - ends[own, None]
            u, v = outward[own, None], outward[other]
            ahead = (step * u).sum(axis=2)
            aside = np.abs(step[..., 0] * u[..., 1] - step[..., 1] * u[..., 0])
            turn = np.abs(v[..., 0] * u[..., 1] - v[..., 1] * u[..., 0])
            fits = (ahead > 0) & (aside <= bend[own, None] * ahead + 2 * noise)
            fits &= turn <= bend[own, None] + bend[other]
            fits &= ((v * u).sum(axis=2) < 0) & (line[other] != line[own][:, None])
            distance = np.where(fits, distance, np.inf)
            nearest = distance.argmin(axis=1)
            place = np.arange(len(own))
            width[own] = distance[place, nearest]
            best[own] = np.where(np.isfinite(width[own]), other[place, nearest], -1)
        met = width[np.isfinite(width)]
        farthest = _WIDEST_GAP * float(np.median(met)) if len(met) else 0.0
    return best, width


def _free(coords: FloatArray, pairs: IntArray, gaps: FloatArray) -> BoolArray:
    """Which pairs of ends touch no other line."""
    free: BoolArray = np.ones(len(pairs), bool)
    tree = shapely.STRtree(shapely.linestrings(coords))
    for start in range(0, len(pairs), _CHUNK):
        part = slice(start, start + _CHUNK)
        for side in (0, 1):
            end = pairs[part, side]
            points = shapely.points(coords[end // 2, end % 2])
            which, line = tree.query(points, predicate="dwithin", distance=_TOUCH * gaps[part])
            foreign = (line != pairs[part][which, 0] // 2) & (line != pairs[part][which, 1] // 2)
            free[start + which[foreign]] = False
    return free


def _medians(values: FloatArray, group: IntArray) -> FloatArray:
    """The lower median of each value's group, shape as values."""
    order = np.lexsort((values, group))
    keys, first, size = np.unique(group[order], return_index=True, return_counts=True)
    median = values[order][first + (size - 1) // 2]
    out: FloatArray = median[np.searchsorted(keys, group)]
    return out


def _spans(coords: FloatArray, row: IntArray) -> tuple[FloatArray, FloatArray]:
    """Both ends of each row, shape (rows, 2, 2), and how far its dashes are off their line."""
    order = np.argsort(row, kind="stable")
    first = np.flatnonzero(np.diff(row[order], prepend=-1))
    size = np.diff(np.append(first, len(order)))
    span = coords[:, 1] - coords[:, 0]
    length = np.hypot(span[:, 0], span[:, 1])
    longest = np.lexsort((-length, row))[first]
    origin = coords[longest, 0]
    along = span[longest] / np.maximum(length[longest], np.finfo(float).tiny)[:, None]
    points = coords[order].reshape(-1, 2)
    own = np.repeat(np.arange(len(first)), 2 * size)
    at = ((points - origin[own]) * along[own]).sum(axis=1)
    rank = np.lexsort((at, own))
    low = points[rank[2 * first]]
    high = points[rank[2 * (first + size) - 1]]
    ends = np.stack([low, high], axis=1)
    alone = size == 1
    ends[alone] = coords[longest[alone]]
    chord = ends[:, 1] - ends[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        chord = np.nan_to_num(chord / np.hypot(chord[:, 0], chord[:, 1])[:, None])
    step = points - ends[own, 0]
    aside = np.abs(step[:, 0] * chord[own, 1] - step[:, 1] * chord[own, 0])
    off = np.maximum.reduceat(aside, 2 * first) if len(first) else np.empty(0)
    return ends, off


def extended(
    ends: FloatArray, loose: BoolArray, reach: FloatArray, tolerance: float, support: int
) -> tuple[FloatArray, BoolArray]:
    """Lines with loose ends drawn on to where they meet other lines, and which ends were.

    Parameters
    ----------
    ends : of the lines, shape (n, 2, 2); loose : which of them may move, shape (n, 2).
    reach : how far they may, shape (n,).
    tolerance : meeting points nearer to each other are one.
    support : a meeting point needs other lines that count as many: a line with this point on it
        counts two, one that reaches it by being drawn on counts one.

    Of several points that with the most support is taken, of equal ones the nearest.
    """
    span = ends[:, 1] - ends[:, 0]
    length = np.hypot(span[:, 0], span[:, 1])
    along = span / np.maximum(length, np.finfo(float).tiny)[:, None]
    more = np.where(loose, np.maximum(reach, tolerance)[:, None], tolerance)
    long = np.stack([ends[:, 0] - more[:, :1] * along, ends[:, 1] + more[:, 1:] * along], axis=1)
    which = np.flatnonzero(loose.any(axis=1))
    out, moved = ends.copy(), np.zeros(loose.shape, bool)
    if not len(which):
        return out, moved
    shapes = shapely.linestrings(long)
    mine, other = shapely.STRtree(shapes).query(shapes[which], predicate="intersects")
    mine = which[mine]
    cross = along[mine, 0] * along[other, 1] - along[mine, 1] * along[other, 0]
    fits = (mine != other) & (np.abs(cross) > _PARALLEL)
    mine, other, cross = mine[fits], other[fits], cross[fits]
    apart = ends[other, 0] - ends[mine, 0]
    at = (apart[:, 0] * along[other, 1] - apart[:, 1] * along[other, 0]) / cross
    of_other = (apart[:, 0] * along[mine, 1] - apart[:, 1] * along[mine, 0]) / cross
    on_line = (of_other >= -tolerance) & (of_other <= length[other] + tolerance)
    weight = np.where(on_line, 2, 1)
    side = (at > length[mine] / 2).astype(np.int64)
    ahead = np.where(side == 1, at - length[mine], -at)
    fits = (ahead >= -tolerance) & (ahead <= more[mine, side] + tolerance) & loose[mine, side]
    end, ahead, weight = (2 * mine + side)[fits], ahead[fits], weight[fits]
    if not len(end):
        return out, moved
    order = np.lexsort((ahead, end))
    end, ahead, weight = end[order], ahead[order], weight[order]
    fresh = (np.diff(end, prepend=-1) != 0) | (np.diff(ahead, prepend=-np.inf) > tolerance)
    cluster = np.cumsum(fresh) - 1
    total = np.bincount(cluster, weights=weight)
    first = np.flatnonzero(fresh)
    size = np.diff(np.append(first, len(end)))
    distance = np.add.reduceat(ahead, first) / size
    of_end = end[first]
    best = np.lexsort((distance, -total, of_end))
    best = best[np.diff(of_end[best], prepend=-1) != 0]
    best = best[total[best] >= support]
    line, side = of_end[best] // 2, of_end[best] % 2
    sign = np.where(side == 1, 1.0, -1.0)
    out[line, side] = ends[line, side] + (sign * distance[best])[:, None] * along[line]
    moved[line, side] = True
    return out, moved
