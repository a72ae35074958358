"""The sheet that drawn lines enclose: its faces, its holes, and what is outside of it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fab.errors import Finding, InvalidFile, Severity, counted
from fab.formats.drawn.border import with_border
from fab.formats.drawn.lines import Faces, Lines, Repair, places_of
from fab.formats.drawn.page_frame import page_frame
from fab.formats.drawn.planar_lines import PlanarLines
from fab.formats.read_options import ReadOptions
from fab.geometry.bridges import bridges
from fab.geometry.planar_graph import without_dangling
from fab.geometry.planar_regions import Regions, points_within, regions_of, walls_passed
from solver.graphs import labels
from solver.vectors import BoolArray, IntArray

__all__ = ["DrawnSheet", "drawn_sheet"]

# Sine of the bend, and share of the diagonal off the whole run, up to which a run is straight.
_STRAIGHT, _OFF_REL = 1e-4, 3e-6


@dataclass(frozen=True)
class DrawnSheet:
    """Faces, and all edges of the sheet.

    Attributes
    ----------
    lines : the sides of the faces and those that end within one.
    kept_as : for each edge of the planar graph the one that it is part of, -1 where it is left out.
    """

    faces: Faces
    lines: Lines
    kept_as: IntArray
    repairs: tuple[Repair, ...]
    findings: tuple[Finding, ...]


def drawn_sheet(
    planar: PlanarLines, options: ReadOptions, tolerance_mm: float, *, joins_runs: bool
) -> DrawnSheet:
    """The sheet of a planar graph: what is reached from outside over one border, or an odd number.

    joins_runs : whether straight runs of one letter and angle become single edges.

    Raises `InvalidFile` for open outlines, and borders within the sheet unless they may be cuts.
    """
    lines, repairs = with_border(planar.lines, tolerance_mm, options)
    kept_as = np.arange(len(lines.planar))
    closed, regions, solid = _solids(lines)
    findings = []
    outside = _outside(lines, closed, regions, solid)
    while True:  # frames around frames
        twice = planar.borders_twice[lines.planar]
        frame = page_frame(lines, closed, regions, outside, twice, tolerance_mm)
        if not frame.any():
            break
        rows = np.flatnonzero(frame)
        text = (
            f"{lines.named(rows)} around the sheet without a crease between them and it: taken for "
            "the frame of a page and left out."
        )
        places = lines.middles(rows)
        repairs.append(Repair("page-frame", Severity.WARNING, text, rows[:0], places))
        kept_as[lines.planar[frame]] = -1
        lines = lines.part(~frame)
        closed, regions, solid = _solids(lines)
        outside = _outside(lines, closed, regions, solid)
    if not solid.any():
        raise InvalidFile(
            f"{lines.path}: its edges enclose no face. Draw the outline of the sheet, or give "
            "--border hull."
        )
    inner = _holes(regions, solid)
    if len(inner):
        ring = regions.corners[regions.offsets[inner[0]] : regions.offsets[inner[0] + 1]]
        text = (
            f"{counted(len(inner), 'face')} with borders on all sides, amid others, "
            f"{'is a hole' if len(inner) == 1 else 'are holes'}, the first around "
            f"{lines.point(lines.coords[ring].mean(axis=0))}."
        )
        bounds = zip(regions.offsets[inner], regions.offsets[inner + 1], strict=True)
        rings = [lines.coords[regions.corners[start:end]] for start, end in bounds]
        middles = np.array([ring.mean(axis=0) for ring in rings])
        findings.append(Finding("hole", Severity.NOTE, text, places=places_of(middles)))
    whole = lines
    lines, cuts = _without_inner_borders(lines, closed, regions, solid, planar, options)
    repairs += cuts
    outside = _outside(lines, closed, regions, solid)
    if outside.any():
        _require_not_enclosed(lines, outside)
        rows = np.flatnonzero(outside)
        start, end = lines.coords[lines.pairs[rows[0]]]
        text = (
            f"{lines.named(rows)} outside of the border: left out, the first from "
            f"{lines.point(start)} to {lines.point(end)}. Draw the border around what belongs to "
            "it."
        )
        places = lines.middles(rows)
        repairs.append(Repair("line-outside", Severity.WARNING, text, rows[:0], places))
        kept_as[lines.planar[outside]] = -1
        lines = lines.part(~outside)
    if joins_runs:
        lines, joined, of = _joined_runs(lines, kept_as)
        repairs += joined
        kept_as = of
    found = (closed, regions, solid) if lines is whole else _solids(lines)
    lines, faces, added = _bridged(lines, *found, len(kept_as))
    repairs += added
    kept_as = np.concatenate([kept_as, lines.planar[lines.planar >= len(kept_as)]])
    return DrawnSheet(faces, lines, kept_as, tuple(repairs), tuple(findings))


def _solids(lines: Lines) -> tuple[BoolArray, Regions, BoolArray]:
    """Which lines enclose regions, those regions, and which of these are the sheet."""
    closed = without_dangling(lines.pairs)
    regions = regions_of(lines.coords, lines.pairs[closed])
    solid = walls_passed(regions, lines.letters[closed] == "B") % 2 == 1
    return closed, regions, solid


def _of_sides(regions: Regions, solid: BoolArray) -> BoolArray:
    """Whether the sheet is on the left and on the right of each closed line, shape (n, 2)."""
    return np.append(solid, False)[regions.sides]


def _holes(regions: Regions, solid: BoolArray) -> IntArray:
    """Regions that are no part of the sheet but lie within it: one for each hole."""
    empty = np.append(~solid, True)
    nodes = np.where(regions.sides < 0, regions.count, regions.sides)
    through = empty[nodes].all(axis=1)
    group = labels(nodes[through], regions.count + 1)
    inner = np.flatnonzero(~solid & (group[:-1] != group[-1]))
    _, first = np.unique(group[inner], return_index=True)
    return np.sort(inner[first])


def _without_inner_borders(
    lines: Lines,
    closed: BoolArray,
    regions: Regions,
    solid: BoolArray,
    planar: PlanarLines,
    options: ReadOptions,
) -> tuple[Lines, list[Repair]]:
    """Borders with the sheet on both sides as cuts, where that is what they mean."""
    inner = np.flatnonzero(closed)[_of_sides(regions, solid).all(axis=1)]
    inner = inner[lines.letters[inner] == "B"]
    if not len(inner):
        return lines, []
    twice = planar.borders_twice[lines.planar[inner]]
    if not twice.all() and options.inner_border != "cut":
        row = int(inner[~twice][0])
        start, end = lines.coords[lines.pairs[row]]
        others = int((~twice).sum()) - 1
        more = f" ({counted(others, 'more such border')})" if others else ""
        raise InvalidFile(
            f"{lines.path}: {lines.name(row)} from {lines.point(start)} to {lines.point(end)} is a "
            f"border (B) with the sheet on both sides{more}. Make it a crease or a cut, or give "
            "--inner-border cut."
        )
    letters = lines.letters.copy()
    letters[inner] = "C"
    repairs = []
    for code, rows, what in (
        ("border-inside", inner[~twice], "a border with faces on both sides is taken"),
        ("border-shared", inner[twice], "borders of two pieces in one place are taken"),
    ):
        if len(rows):
            text = f"{lines.named(rows).removesuffix(',')}: {what} for a cut (C)."
            edges, places = lines.planar[rows], lines.middles(rows)
            repairs.append(Repair(code, Severity.WARNING, text, edges, places))
    return replace(lines, letters=letters), repairs


def _outside(lines: Lines, closed: BoolArray, regions: Regions, solid: BoolArray) -> BoolArray:
    """Which lines have the sheet on neither side."""
    out = np.zeros(len(lines.pairs), bool)
    out[closed] = ~_of_sides(regions, solid).any(axis=1)
    loose = np.flatnonzero(~closed)
    middles = lines.coords[lines.pairs[loose]].mean(axis=1)
    out[loose] = ~np.append(solid, False)[points_within(middles, lines.coords, regions)]
    return out


def _require_not_enclosed(lines: Lines, outside: BoolArray) -> None:
    """Raise `InvalidFile` where lines enclose the border, and more creases beside it than in it.

    Then the border is of a hole or of a letter, and what is around it the outline of the sheet; a
    frame may enclose a sheet and the few lines of a legend.
    """
    folds = np.isin(lines.letters, ["M", "V"])
    creases = np.flatnonzero(outside & folds)
    around = np.flatnonzero(outside & ~np.isin(lines.letters, ["M", "V", "F"]))
    around = around[without_dangling(lines.pairs[around])]
    if not len(creases) or not len(around):
        return
    regions = regions_of(lines.coords, lines.pairs[around])
    borders = np.flatnonzero(~outside & (lines.letters == "B"))
    own = points_within(lines.middles(borders), lines.coords, regions)
    of_creases = points_within(lines.middles(creases), lines.coords, regions)
    both = (of_creases >= 0) & np.isin(of_creases, own)
    length = np.hypot(*(lines.coords[lines.pairs[:, 1]] - lines.coords[lines.pairs[:, 0]]).T)
    if length[creases[both]].sum() <= length[folds & ~outside].sum():
        return
    ring = around[(regions.sides == of_creases[both][0]).any(axis=1)]
    of_hole, of_ring, crease = (
        f"{lines.name(row)} at {lines.place(row)}"
        for row in (borders[0], ring[0], creases[both][0])
    )
    count = int(both.sum())
    raise InvalidFile(
        f"{lines.path}: the border ({of_hole}) is within closed lines that are no border "
        f"({of_ring}), and so {'is' if count == 1 else 'are'} {counted(count, 'crease')} beside "
        f"it, the first {crease}. Make these lines the border, or remove them."
    )


def _joined_runs(lines: Lines, kept_as: IntArray) -> tuple[Lines, list[Repair], IntArray]:
    """Straight runs of one letter and angle as single edges."""
    count = len(lines.coords)
    degree = np.bincount(lines.pairs.ravel(), minlength=count)
    order = np.argsort(lines.pairs.ravel(), kind="stable")
    first = np.searchsorted(lines.pairs.ravel()[order], np.flatnonzero(degree == 2))
    vertex = np.flatnonzero(degree == 2)
    a, b = order[first] // 2, order[first + 1] // 2
    before = lines.coords[lines.pairs[a].sum(axis=1) - vertex] - lines.coords[vertex]
    after = lines.coords[lines.pairs[b].sum(axis=1) - vertex] - lines.coords[vertex]
    size = np.hypot(*before.T) * np.hypot(*after.T)
    turn = np.abs(before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0])
    alike = (lines.letters[a] == lines.letters[b]) & (
        (lines.angles[a] == lines.angles[b]) | np.isnan(lines.angles[[a, b]]).all(axis=0)
    )
    straight = alike & (turn <= _STRAIGHT * size) & ((before * after).sum(axis=1) < 0)
    if not straight.any():
        return lines, [], kept_as
    run = labels(np.column_stack([a, b])[straight], len(lines.pairs))
    members = np.bincount(run)
    rows = np.flatnonzero(members[run] > 1)
    rows = rows[np.argsort(run[rows], kind="stable")]
    starts = np.searchsorted(run[rows], np.unique(run[rows]))
    kept = np.ones(len(lines.pairs), bool)
    pairs = lines.pairs.copy()
    head_of = np.arange(len(kept_as))
    diagonal = float(np.hypot(*np.ptp(lines.coords, axis=0)))
    gone = 0
    named = []
    for own in np.split(rows, starts[1:]):
        ends, times = np.unique(lines.pairs[own], return_counts=True)
        tips = ends[times == 1]
        span = lines.coords[tips[1]] - lines.coords[tips[0]]
        arm = lines.coords[ends] - lines.coords[tips[0]]
        off = np.abs(span[0] * arm[:, 1] - span[1] * arm[:, 0]) / np.hypot(*span)
        if off.max() > _OFF_REL * diagonal:
            continue
        head, follow = lines.coords[pairs[own[0]]]
        pairs[own[0]] = tips if (follow - head) @ span > 0 else tips[::-1]
        kept[own[1:]] = False
        head_of[lines.planar[own]] = lines.planar[own[0]]
        named.append(own[0])
        gone += len(own) - 1
    if not gone:
        return lines, [], kept_as
    place = lines.place(named[0])
    text = (
        f"{counted(gone, 'vertex', 'vertices')} in straight runs of one letter and angle removed, "
        f"the first in {lines.name(named[0])} near {place}."
    )
    repair = Repair("runs-joined", Severity.NOTE, text, lines.planar[named])
    kept_as = np.where(kept_as < 0, -1, head_of[kept_as])
    return replace(lines, pairs=pairs).part(kept), [repair], kept_as


def _faces(regions: Regions, solid: BoolArray) -> Faces:
    """The regions that are the sheet."""
    sizes = np.diff(regions.offsets)
    corners = regions.corners[np.repeat(solid, sizes)]
    offsets = np.concatenate([[0], np.cumsum(sizes[solid])])
    return Faces(corners, offsets, np.arange(len(offsets) - 1))


def _members(owner: IntArray, wanted: IntArray) -> tuple[IntArray, IntArray]:
    """Offsets and places: where each wanted owner is among owners."""
    order = np.argsort(owner, kind="stable")
    rising = np.append(wanted, np.iinfo(np.int64).max)
    offsets = np.searchsorted(owner[order], rising)
    ends = np.searchsorted(owner[order], wanted, "right")
    chosen = [order[i:j] for i, j in zip(offsets[:-1].tolist(), ends.tolist(), strict=True)]
    sizes = np.array([len(part) for part in chosen])
    return np.concatenate([[0], np.cumsum(sizes)]), np.concatenate(chosen)


def _bridged(
    lines: Lines, closed: BoolArray, regions: Regions, solid: BoolArray, first: int
) -> tuple[Lines, Faces, list[Repair]]:
    """The lines with joins (J) that divide faces around islands into simple ones; all faces.

    first : number of the first join in the planar graph.
    """
    broken = regions.broken()
    broken = broken[solid[broken]]
    if not len(broken):
        return lines, _faces(regions, solid), []
    rows = np.flatnonzero(closed)
    loose = np.flatnonzero(~closed)
    middles = lines.coords[lines.pairs[loose]].mean(axis=1)
    place = points_within(middles, lines.coords, regions)
    side, edge = _members(regions.sides.ravel(), broken)
    hold, line = _members(place, broken)
    found = []
    for number, region in enumerate(broken.tolist()):
        around = np.unique(edge[side[number] : side[number + 1]] // 2)
        within = regions.sides[around] == region
        sides = lines.pairs[rows[around]]
        ends = lines.pairs[loose[np.sort(line[hold[number] : hold[number + 1]])]]
        pairs = bridges(lines.coords, sides, within, ends)
        if pairs is None:  # lines that end within the face are in the way: they become sides
            both = np.concatenate([within, np.ones((len(ends), 2), bool)])
            pairs = bridges(lines.coords, np.concatenate([sides, ends]), both, ends[:0])
        if pairs is None:
            ring = regions.corners[regions.offsets[region] : regions.offsets[region + 1]]
            raise InvalidFile(
                f"{lines.path}: the lines in the face around "
                f"{lines.point(lines.coords[ring].mean(axis=0))} are islands. Join them to its "
                "sides by edges of assignment J."
            )
        found.append(pairs)
    pairs = np.concatenate(found)
    count = len(pairs)
    start, end = lines.coords[pairs[0]]
    text = (
        f"{counted(len(broken), 'face')} with islands divided by {counted(count, 'join')} (J), "
        f"which stay flat, the first from {lines.point(start)} to {lines.point(end)}."
    )
    planar = np.arange(first, first + count)
    if lines.element is not None:
        joins = np.full(count, len(lines.elements))
        lines = replace(
            lines,
            elements=(*lines.elements, "a join"),
            element=np.concatenate([lines.element, joins]),
        )
    lines = replace(
        lines,
        pairs=np.concatenate([lines.pairs, pairs]),
        letters=np.concatenate([lines.letters, np.full(count, "J")]),
        angles=np.concatenate([lines.angles, np.zeros(count)]),
        number=np.concatenate([lines.number, np.full(count, -1)]),
        planar=np.concatenate([lines.planar, planar]),
    )
    _, regions, solid = _solids(lines)
    places = lines.coords[pairs].mean(axis=1)
    repair = Repair("island-joined", Severity.WARNING, text, planar, places)
    return lines, _faces(regions, solid), [repair]
