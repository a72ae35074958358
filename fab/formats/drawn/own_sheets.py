"""Our own sheets back again: dashes, margins, relief holes and kerf of a drawing taken away.

A sheet has a layer for each operation (`fab.drawings`), its creases as dashes that end a margin
before their vertices, and its outlines moved outwards by half of the kerf. Neither margin nor kerf
is written in the file: they follow from where creases meet each other and the outline.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import shapely
from scipy.spatial import KDTree

from fab.errors import Finding, Severity, counted
from fab.formats.drawn.dashes import extended, facing, of_rows, rows_of
from fab.formats.drawn.line_soup import Letters, LineSoup
from fab.formats.drawn.own_cuts import shared_sides, without_bridges, without_slots
from fab.formats.drawn.own_lattices import without_lattices
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["OPERATIONS", "recovered_sheet"]

# Layers of a sheet, in the order in which they are drawn.
OPERATIONS = ("ENGRAVE", "MOUNTAIN", "VALLEY", "RELIEF", "HOLE", "CUT")
_LETTERS = {"ENGRAVE": "U", "MOUNTAIN": "M", "VALLEY": "V", "HOLE": "C", "CUT": "C"}
# Ends reach for their vertices in steps, so that the nearest ones are found first, mm.
_REACHES_MM = (0.3, 0.6, 1.2, 2.5, 5.0, 10.0, 20.0)
# Files have six digits after the point; a short dash points less exactly.
_NOISE_MM = 2e-6
_NEAR_MM = 2e-3
# Lines that meet count one each, a line that passes counts two.
_SUPPORT = 2
_WIDEST_KERF_MM = 10.0
_LEAST_KERF_MM = 1e-3
_AGREE_MM = 1e-3
_LEAST_SINE = 0.1
# Sine of the least angle of two chords of a curve; those that turn less are on one line.
_LEAST_BEND = 2e-6
# Pairs of creases that are asked for a kerf.
_TRIALS = 500


def recovered_sheet(
    soup: LineSoup,
    operations: Sequence[str],
    closed: Sequence[bool],
    bent: Sequence[bool],
    given: Sequence[str | None],
) -> LineSoup:
    """The pattern of a sheet: whole creases that reach their vertices, outlines, slits.

    operations : the layer of each element; closed : whether it is an outline; bent : whether it is
    one line of several sides, such as a stroke of a letter; given : the assignment that the user
    gives it, if any.

    Labels and relief holes are left out with a count. Flat creases that are not drawn cannot come
    back.
    """
    soup, closed, slots = without_slots(soup, operations, closed)
    soup, closed, bridges = without_bridges(soup, operations, closed)
    soup, around, between = shared_sides(soup, operations, closed)
    layer = np.array(operations, dtype=object)[soup.lines_element]
    ring = np.array(closed, dtype=bool)[soup.lines_element]
    letters = np.array([_LETTERS.get(str(name), "U") for name in layer.tolist()], dtype="U1")
    outline = ring & np.isin(layer, ["HOLE", "CUT"])
    letters[outline | around] = "B"
    letters[between] = "C"
    asked = np.array([letter or "" for letter in given], dtype="U1")[soup.lines_element]
    letters = np.where(asked != "", asked, letters)
    one = ring | np.array(bent, dtype=bool)[soup.lines_element]
    label = one & (layer == "ENGRAVE")
    hole = layer == "RELIEF"
    findings = []
    holes = len(np.unique(soup.lines_element[hole]))
    marks = len(np.unique(soup.lines_element[label]))
    undone = (
        (holes, "relief hole"),
        (marks, "engraved line of letters"),
        (bridges, "bridge of outlines"),
        (slots, "closed slot of creases"),
    )
    for count, what in undone:
        if count:
            first, _, rest = what.partition(" of ")
            name = first + ("" if count == 1 else "s") + (f" of {rest}" if rest else "")
            findings.append(
                Finding(
                    "sheet-addition", Severity.NOTE, f"left out of our own sheet: {count} {name}."
                )
            )
    if between.any():
        text = "pieces of our own sheet that share sides stay side by side, with cuts between them."
        findings.append(Finding("sheet-addition", Severity.NOTE, text))
    if not (outline | around).any():
        text = (
            "our own sheet has no closed outline, as where its machine has a [knife] with an "
            "offset, an overcut or a lead-in: its cuts are paths of the knife, not the outlines of "
            "pieces. Read the FOLD file, or a sheet that was made without [knife]."
        )
        findings.append(Finding("knife-paths", Severity.WARNING, text))
    rings = [
        soup.lines_coords[soup.lines_element == e, 0] for e in np.unique(soup.lines_element[hole])
    ]
    kept = ~(hole | label)
    angles = np.where(np.isin(letters, ["M", "V"]), soup.lines_foldAngle, np.nan)
    soup = replace(
        soup,
        lines_coords=soup.lines_coords[kept],
        lines_assignment=letters[kept],
        lines_foldAngle=angles[kept],
        lines_element=soup.lines_element[kept],
    )
    rows = rows_of(soup, 2, _NOISE_MM)
    rows, hinges = without_lattices(rows, soup.lines_coords, soup.lines_assignment)
    if hinges:
        text = (
            f"our own sheet has {counted(hinges, 'living hinge')}: each is taken for the crease in "
            "its middle."
        )
        findings.append(Finding("sheet-addition", Severity.NOTE, text))
    soup_rows = of_rows(soup, rows, rows.ends)
    ends, letters = rows.ends, soup_rows.lines_assignment
    if engraved := _count_within(ends[letters == "U"], ends[letters == "B"]):
        text = (
            f"{counted(engraved, 'engraved crease')} of our own sheet: unassigned, as the drawing "
            "does not say which fold they are. Give --colours ENGRAVE=valley, or mountain."
        )
        findings.append(Finding("engraved-unassigned", Severity.WARNING, text))
    crease = ~np.isin(letters, ["B", "C"])
    border = letters == "B"
    if border.any() and crease.any():
        exact = _exact(ends, rows.dashes, letters)
        # of pieces that share sides none is moved: those between two have material on both sides
        half = None if around.any() else _half_kerf(ends, crease, border, exact, rings)
        if half is None:
            findings.append(
                Finding(
                    "kerf-unknown",
                    Severity.NOTE,
                    "the kerf for which the outlines were drawn does not show in the drawing: the "
                    "sheet may be larger than the pattern by the kerf of the machine.",
                )
            )
        elif half > _LEAST_KERF_MM:
            ends = _inset(ends, border, soup_rows.lines_element, half)
            findings.append(
                Finding(
                    "kerf-removed",
                    Severity.NOTE,
                    f"the outlines were drawn for a kerf of {2 * half:.4g} mm, as the creases that "
                    "meet them show: moved back by half of it.",
                )
            )
    ends, open_ends = _to_vertices(ends, crease)
    dashes = int(rows.dashes[rows.dashes > 1].sum())
    joined = int((rows.dashes > 1).sum())
    if joined:
        text = f"{dashes} dashes of our own sheet are joined to {counted(joined, 'crease')}"
        findings.append(
            Finding("dashes-joined", Severity.NOTE, f"{text}, drawn on to their vertices.")
        )
    if open_ends:
        findings.append(
            Finding(
                "crease-end-open",
                Severity.WARNING,
                f"{open_ends} {'end' if open_ends == 1 else 'ends'} of creases meet no other line "
                f"within {_REACHES_MM[-1]:g} mm: left as drawn.",
            )
        )
    return of_rows(soup, rows, ends, *findings)


def _count_within(lines: FloatArray, outlines: FloatArray) -> int:
    """How many lines have their middle within outlines: registration crosses are beside them."""
    if not len(lines) or not len(outlines):
        return 0
    pieces = shapely.STRtree(shapely.get_parts(shapely.polygonize(shapely.linestrings(outlines))))
    middles = shapely.points(lines.mean(axis=1))
    return len(np.unique(pieces.query(middles, predicate="within")[0]))


def _to_vertices(ends: FloatArray, crease: BoolArray) -> tuple[FloatArray, int]:
    """Creases drawn on to where they meet, and how many of their ends meet nothing.

    Chords of a curve meet in pairs, which are found before lines that are farther away.
    """
    loose = np.repeat(crease[:, None], 2, axis=1)
    for reach in _REACHES_MM:
        ends, moved = extended(ends, loose, np.full(len(ends), reach), _NEAR_MM, _SUPPORT)
        loose &= ~moved
        ends, moved = _bends(ends, loose, reach)
        loose &= ~moved
    ends, closed = _straight_through(ends, loose)
    loose &= ~closed
    for reach in _REACHES_MM:
        ends, moved = extended(ends, loose, np.full(len(ends), reach), _NEAR_MM, 1)
        loose &= ~moved
    return ends, int(loose.sum())


def _outward(
    ends: FloatArray, which: BoolArray
) -> tuple[IntArray, IntArray, FloatArray, FloatArray, FloatArray]:
    """Some ends of lines: the line and side of each, its point, the way out of it, the length."""
    line, side = np.nonzero(which)
    points = ends[line, side]
    span = points - ends[line, 1 - side]
    length = np.hypot(span[:, 0], span[:, 1])
    return line, side, points, span / length[:, None], length


def _bends(ends: FloatArray, loose: BoolArray, reach: float) -> tuple[FloatArray, BoolArray]:
    """Loose ends that meet each other first moved to where they do, and which these are."""
    out, moved = ends.copy(), np.zeros(loose.shape, bool)
    line, side, start, along, _ = _outward(ends, loose)
    if len(line) < 2:
        return out, moved
    rays = shapely.linestrings(np.stack([start, start + reach * along], axis=1))
    mine, other = shapely.STRtree(rays).query(rays, predicate="intersects")
    sine = along[mine, 0] * along[other, 1] - along[mine, 1] * along[other, 0]
    fits = (line[mine] != line[other]) & (np.abs(sine) > _LEAST_BEND)
    mine, other, sine = mine[fits], other[fits], sine[fits]
    apart = start[other] - start[mine]
    ahead = (apart[:, 0] * along[other, 1] - apart[:, 1] * along[other, 0]) / sine
    order = np.lexsort((ahead, mine))
    order = order[np.diff(mine[order], prepend=-1) != 0]
    nearest = np.full(len(line), -1)
    nearest[mine[order]] = other[order]
    way = np.zeros(len(line))
    way[mine[order]] = ahead[order]
    pair = np.flatnonzero(nearest >= 0)
    pair = pair[nearest[nearest[pair]] == pair]
    out[line[pair], side[pair]] = start[pair] + way[pair, None] * along[pair]
    moved[line[pair], side[pair]] = True
    return out, moved


def _straight_through(ends: FloatArray, loose: BoolArray) -> tuple[FloatArray, BoolArray]:
    """Loose ends that face each other on one line moved to their middle, and which these are."""
    out, closed = ends.copy(), np.zeros(loose.shape, bool)
    line, side, points, outward, length = _outward(ends, loose)
    if len(line) < 2:
        return out, closed
    other, gap = facing(points, outward, line, length, _NOISE_MM)
    pair = np.flatnonzero((other >= 0) & (gap <= 2 * _REACHES_MM[-1]))
    pair = pair[other[other[pair]] == pair]
    out[line[pair], side[pair]] = (points[pair] + points[other[pair]]) / 2
    closed[line[pair], side[pair]] = True
    return out, closed


def _exact(ends: FloatArray, dashes: IntArray, letters: Letters) -> BoolArray:
    """Which rows end just a margin before their vertices.

    A crease with room for one dash alone has it in the middle, as long as was asked for: farther
    from its vertices. So the longest rows of one line each are left out, unless all of a letter
    are as long, and end as far from their vertices as each other.
    """
    length = np.hypot(*(ends[:, 1] - ends[:, 0]).T)
    exact: BoolArray = dashes > 1
    for letter in np.unique(letters):
        own = letters == letter
        alone = own & (dashes == 1)
        if alone.any():
            shorter = alone & (length < length[alone].max() - _AGREE_MM)
            exact |= shorter if shorter.any() or (own & exact).any() else alone
    return exact


def _half_kerf(
    ends: FloatArray,
    crease: BoolArray,
    border: BoolArray,
    exact: BoolArray,
    holes: Sequence[FloatArray],
) -> float | None:
    """Half of the kerf by which outlines were moved; None where it does not show.

    A crease ends m before its vertex. To an outline that was moved by h, and that it meets at the
    angle a, it is m + h / sin a; to other creases at a vertex within, m. A vertex with a hole is
    farther by the radius, which was drawn smaller.
    """
    within = np.concatenate([ends[crease], ends[~crease & ~border]])
    known = np.concatenate([exact[crease], exact[~crease & ~border]])
    count = len(within)
    loose = np.zeros((count, 2), bool)
    loose[: int(crease.sum())] = True
    reached: FloatArray = np.full(loose.shape, np.inf)
    parts = [np.empty((0, 3))]
    for reach in _REACHES_MM:
        out, moved = extended(within, loose, np.full(count, reach), _NEAR_MM, 1)
        loose &= ~moved
        step = np.hypot(*np.moveaxis(out - within, 2, 0))
        reached[moved] = step[moved]
        told = moved & known[:, None]
        parts.append(_of_holes(out[told], step[told], holes))
    parts.append(_to_outlines(within[known], reached[known], ends[border]))
    return _agreed(np.concatenate(parts))


def _of_holes(points: FloatArray, step: FloatArray, holes: Sequence[FloatArray]) -> FloatArray:
    """Equations of creases that end `step` before these points, some of which are in round holes.

    Those in holes of other shapes are left out: what the kerf does to them is only nearly known.
    """
    rows = np.column_stack([np.ones(len(step)), np.zeros(len(step)), step])
    if not holes or not len(points):
        return rows
    centres = np.array([hole.mean(axis=0) for hole in holes])
    radii = [np.hypot(*(hole - c).T) for hole, c in zip(holes, centres, strict=True)]
    size = np.array([radius.max() for radius in radii])
    is_round = np.array([np.ptp(radius) < _AGREE_MM and len(radius) >= 16 for radius in radii])
    flatness = np.cos(np.pi / np.array([len(hole) for hole in holes]))
    apart, which = KDTree(centres).query(points)
    inside = apart < size[which]
    rows[inside, 1] = 1 / flatness[which[inside]]
    rows[inside, 2] -= size[which[inside]]
    out: FloatArray = rows[~inside | is_round[which]]
    return out


def _to_outlines(lines: FloatArray, reached: FloatArray, walls: FloatArray) -> FloatArray:
    """Equations of creases that meet an outline at or soon after they meet other creases.

    reached : how far each end is from these, infinite where it meets none, shape (n, 2).
    """
    line, side, start, along, _ = _outward(lines, np.ones(reached.shape, bool))
    far = np.minimum(reached[line, side] + _WIDEST_KERF_MM, _REACHES_MM[-1])
    rays = shapely.linestrings(np.stack([start, start + far[:, None] * along], axis=1))
    ray, wall = shapely.STRtree(shapely.linestrings(walls)).query(rays, predicate="intersects")
    direction = walls[wall, 1] - walls[wall, 0]
    direction /= np.hypot(direction[:, 0], direction[:, 1])[:, None]
    sine = along[ray, 0] * direction[:, 1] - along[ray, 1] * direction[:, 0]
    fits = np.abs(sine) > _LEAST_SINE
    ray, wall, direction, sine = ray[fits], wall[fits], direction[fits], sine[fits]
    apart = walls[wall, 0] - start[ray]
    at = (apart[:, 0] * direction[:, 1] - apart[:, 1] * direction[:, 0]) / sine
    order = np.lexsort((at, ray))
    order = order[np.diff(ray[order], prepend=-1) != 0]
    return np.column_stack([np.ones(len(order)), 1 / np.abs(sine[order]), at[order]])


def _agreed(system: FloatArray) -> float | None:
    """The h of most equations m + s h = d, rows (1, s, d); None where they do not settle it.

    Of several with as many the least.
    """
    generator = np.random.default_rng(0)
    best, most, least = None, 2, np.inf
    slants = np.unique(np.round(system[:, 1], 6))
    if len(slants) < 2:
        return None
    for _ in range(_TRIALS):
        first, second = generator.integers(len(system), size=2)
        lean = system[first, 1] - system[second, 1]
        if abs(lean) < 1e-3:
            continue
        half = (system[first, 2] - system[second, 2]) / lean
        margin = system[first, 2] - half * system[first, 1]
        if not (0 <= half <= _WIDEST_KERF_MM / 2 and margin >= half - _AGREE_MM):
            continue
        off = np.abs(margin + half * system[:, 1] - system[:, 2])
        agree = off <= _AGREE_MM
        better = (-agree.sum(), half) < (-most, least - _AGREE_MM)
        if len(np.unique(np.round(system[agree, 1], 6))) >= 2 and better and agree.sum() > 2:
            most, least = int(agree.sum()), half
            fit = np.linalg.lstsq(system[agree, :2], system[agree, 2], rcond=None)[0]
            best = float(fit[1])
    return best if most > len(system) / 4 else None


def _inset(ends: FloatArray, border: BoolArray, element: np.ndarray, half: float) -> FloatArray:
    """The outlines moved towards their material by `half`, corner by corner."""
    out = ends.copy()
    for own in np.unique(element[border]).tolist():
        lines = np.flatnonzero(border & (element == own))
        ring = ends[lines, 0]
        # material is on the left of outer rings and of holes alike
        span = np.roll(ring, -1, axis=0) - ring
        along = span / np.hypot(span[:, 0], span[:, 1])[:, None]
        normal = np.column_stack([-along[:, 1], along[:, 0]])
        before = np.roll(normal, 1, axis=0)
        corner = half * (normal + before) / (1 + (normal * before).sum(axis=1))[:, None]
        moved = ring + corner
        out[lines, 0], out[lines, 1] = moved, np.roll(moved, -1, axis=0)
    return out
