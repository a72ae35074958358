"""Line soup of any drawing made into a planar crease pattern.

Lines are split where they cross, ends are joined within a tolerance, what lies twice is taken
once, the border is found, and every repair is a finding with its place. No line is dropped without
one.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import shapely

from fab.errors import Finding, InvalidFile, Severity
from fab.formats.coordinate_bounds import require_range
from fab.formats.drawn.line_soup import LETTERS, UNLETTERED, LineSoup, require_few_lines
from fab.formats.drawn.lines import Lines, Repair
from fab.formats.drawn.planar_lines import DrawnLines, PlanarLines, planar_lines
from fab.formats.drawn.sheet import DrawnSheet, drawn_sheet
from fab.formats.drawn.sheet_pattern import SheetPattern, sheet_pattern
from fab.formats.drawn.tolerance import tolerance_of
from fab.formats.pattern_file import PatternFile
from fab.formats.read_options import ReadOptions
from fab.formats.strictness import require_no_repairs, with_lost
from fab.formats.units import unit_unknown
from fab.geometry.planar_regions import Regions, points_within
from solver.errors import InvalidValue, require_positive
from solver.vectors import FloatArray, IntArray

__all__ = [
    "findings_of",
    "imported_lines",
    "pattern_of_lines",
    "pattern_of_sheet",
]

_DEFAULT_MM = 1.0


def pattern_of_lines(soup: LineSoup, options: ReadOptions | None = None) -> PatternFile:
    """The crease pattern of the lines of a drawing, in millimetres.

    Raises `InvalidFile` with the place and the cure for what can be meant in more than one way, or
    for the first repair where `options.strict`. Codes of the findings, beside those of the reader:
    "unit-unknown", "ends-joined", "ends-extended", "lines-bent", "duplicate-line",
    "lines-overlap", "zero-length-line", "border-hull", "border-found", "border-unmarked",
    "border-inside", "border-shared", "page-frame", "line-outside", "island-joined",
    "fold-angle-missing", "fold-angle-contradicts", "fold-angle-zero"; and, as no repairs,
    "fold-deg-unused", "lines-split", "runs-joined", "hole", "crease-dangling",
    "letters-assignable", "letters-assigned", "letters-contradict".
    """
    options = ReadOptions() if options is None else options
    if soup.border_is_cut:
        options = replace(options, inner_border="cut")
    findings = list(soup.findings)
    scale = soup.mm_per_unit
    if scale is None:
        scale = _DEFAULT_MM if options.mm_per_unit is None else options.mm_per_unit
        if options.mm_per_unit is None:
            findings.append(unit_unknown("the file names no unit: one unit", scale))
    require_positive("mm_per_unit", scale)
    lines = _lines_of(soup)
    coords = soup.lines_coords
    require_range(soup.path, coords.reshape(-1, 2), "drawing")
    coords = coords * scale
    require_range(soup.path, coords.reshape(-1, 2), "drawing in mm")
    given = "" if (~np.isnan(soup.lines_foldAngle)).any() else "the drawing gives no fold angles"
    drawn = DrawnLines(coords, lines)
    try:
        sheet, _ = imported_lines(drawn, options, joins_runs=True)
        made = pattern_of_sheet(sheet, None, options, none_given=given)
    except InvalidFile as error:
        raise InvalidFile(with_lost(str(error), soup.findings)) from error
    findings += findings_of(sheet, made)
    require_no_repairs(soup.path, findings, options)
    return PatternFile(
        soup.title, made.pattern, (), tuple(findings), mm_per_unit=scale, origin=made.origin
    )


def _lines_of(soup: LineSoup) -> Lines:
    count = len(soup.lines_coords)
    if not count:
        raise InvalidFile(f"{soup.path}: no lines. Draw the creases and the border as lines.")
    require_few_lines(soup.path, count)
    unknown = ~np.isin(soup.lines_assignment, [*LETTERS, UNLETTERED])
    if unknown.any():
        letter = soup.lines_assignment[unknown][0]
        raise InvalidValue("lines_assignment", letter, f"be one of {LETTERS}", "Name it U.")
    number = np.arange(count)
    return Lines(
        soup.path,
        np.empty((0, 2)),
        np.empty((count, 2), np.int64),
        soup.lines_assignment,
        soup.lines_foldAngle,
        number,
        number,
        soup.elements,
        soup.lines_element,
        soup.downwards,
    )


def imported_lines(
    drawn: DrawnLines, options: ReadOptions, *, joins_runs: bool
) -> tuple[DrawnSheet, PlanarLines]:
    """The sheet of drawn lines, and the planar graph that it was found in."""
    named = drawn.named
    if not len(drawn.coords):
        raise InvalidFile(
            f"{named.path}: no line has a length. Draw the creases and the border as lines."
        )
    element = named.number if named.element is None else named.element
    repairs: tuple[Repair, ...] = ()
    if options.border == "hull" and not (named.letters == "B").any():
        drawn, text = _with_hull(drawn)
        element = np.concatenate([element, np.full(len(drawn.coords) - len(element), -1)])
        repairs = (Repair("border-hull", Severity.WARNING, text, np.empty(0, np.int64)),)
    tolerance = tolerance_of(drawn.coords, element, options.merge_mm)
    planar = planar_lines(drawn, tolerance)
    sheet = drawn_sheet(planar, options, tolerance.mm, joins_runs=joins_runs)
    return replace(sheet, repairs=repairs + planar.repairs + sheet.repairs), planar


def _with_hull(drawn: DrawnLines) -> tuple[DrawnLines, str]:
    """The lines and their convex hull as border, and what is reported of it."""
    named = drawn.named
    hull = shapely.convex_hull(shapely.multipoints(drawn.coords.reshape(-1, 2)))
    if hull.geom_type != "Polygon":
        raise InvalidFile(f"{named.path}: all lines are on one line: no border is around them.")
    ring = shapely.get_coordinates(hull)
    count = len(ring) - 1
    text = f"no line is a border: the convex hull of all lines is taken, {count} edges."
    sides = np.stack([ring[:-1], ring[1:]], axis=1)
    highest = int(named.number.max()) + 1
    more = replace(
        named,
        pairs=np.concatenate([named.pairs, np.zeros((count, 2), np.int64)]),
        letters=np.concatenate([named.letters, np.full(count, "B")]),
        angles=np.concatenate([named.angles, np.zeros(count)]),
        number=np.concatenate([named.number, highest + np.arange(count)]),
        planar=np.concatenate([named.planar, highest + np.arange(count)]),
    )
    if named.element is not None:
        own = np.full(count, len(named.elements))
        more = replace(
            more,
            elements=(*named.elements, "the convex hull"),
            element=np.concatenate([named.element, own]),
        )
    vertices = drawn.vertices
    if vertices is not None:
        new = int(vertices.max()) + 1 + np.arange(2 * count).reshape(-1, 2)
        vertices = np.concatenate([vertices, new])
    return DrawnLines(np.concatenate([drawn.coords, sides]), more, vertices), text


def pattern_of_sheet(
    sheet: DrawnSheet, folded: FloatArray | None, options: ReadOptions, *, none_given: str
) -> SheetPattern:
    """The pattern of a drawn sheet; see `sheet_pattern`."""
    faces = sheet.faces

    def around(lines: Lines, edges_faces: IntArray) -> IntArray:
        middles = lines.coords[lines.pairs[len(edges_faces) :]].mean(axis=1)
        nowhere = np.empty((0, 2), np.int64)
        regions = Regions(faces.corners, faces.offsets, nowhere, nowhere[:, 0])
        return points_within(middles, lines.coords, regions)

    return sheet_pattern(sheet.lines, faces, around, folded, options, none_given=none_given)


def findings_of(sheet: DrawnSheet, made: SheetPattern) -> list[Finding]:
    """All findings about a sheet, with the numbers of the pattern's edges."""
    row = np.full(len(sheet.kept_as) + 1, -1)
    row[made.lines.planar] = np.arange(len(made.lines.planar))
    numbers = row[sheet.kept_as]  # the last entry is that of what is left out
    repairs = [repair.finding(numbers) for repair in sheet.repairs]
    return [*repairs, *sheet.findings, *made.findings]
