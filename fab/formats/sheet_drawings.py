"""Our own sheets back again: dashes, margins, relief holes and kerf of a drawing taken away.

A sheet has a layer for each operation (`fab.drawings`), its creases as dashes that end a margin
before their vertices, and its outlines moved outwards by half of the kerf. Neither margin nor kerf
is written in the file: they follow from where creases meet each other and the outline.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fab.errors import Finding, Severity
from fab.formats.dashes import extended, of_rows, rows_of
from fab.formats.line_soup import LineSoup
from solver.vectors import BoolArray, FloatArray

__all__ = ["OPERATIONS", "recovered_sheet"]

# Layers of a sheet, in the order in which they are drawn.
OPERATIONS = ("ENGRAVE", "MOUNTAIN", "VALLEY", "RELIEF", "CUT")
_LETTERS = {"ENGRAVE": "U", "MOUNTAIN": "M", "VALLEY": "V", "CUT": "C"}
# Ends reach for their vertices in steps, so that the nearest ones are found first, mm.
_REACHES_MM = (0.3, 0.6, 1.2, 2.5, 5.0, 10.0, 20.0)
# Files have six digits after the point; a short dash points less exactly.
_NEAR_MM = 2e-3
# Lines that meet count one each, a line that passes counts two.
_SUPPORT = 2
_WIDEST_KERF_MM = 10.0
_LEAST_KERF_MM = 1e-3
_AGREE_MM = 1e-3
_TRIALS = 8


def recovered_sheet(soup: LineSoup, operations: Sequence[str], closed: Sequence[bool]) -> LineSoup:
    """The pattern of a sheet: whole creases that reach their vertices, outlines, slits.

    operations : the layer of each element; closed : whether it is an outline.

    Labels and relief holes are left out with a count. Flat creases that are not drawn cannot come
    back.
    """
    layer = np.array(operations, dtype=object)[soup.lines_element]
    ring = np.array(closed, dtype=bool)[soup.lines_element]
    letters = np.array([_LETTERS.get(str(name), "U") for name in layer.tolist()], dtype="U1")
    outline = ring & (layer == "CUT")
    letters[outline] = "B"
    label = ring & (layer == "ENGRAVE")
    hole = layer == "RELIEF"
    findings = []
    holes = len(np.unique(soup.lines_element[hole]))
    marks = len(np.unique(soup.lines_element[label]))
    for count, what in ((holes, "relief hole"), (marks, "engraved outline of letters")):
        if count:
            first, _, rest = what.partition(" of ")
            name = first + ("" if count == 1 else "s") + (f" of {rest}" if rest else "")
            findings.append(
                Finding(
                    "sheet-addition", Severity.NOTE, f"left out of our own sheet: {count} {name}."
                )
            )
    kept = ~(hole | label)
    angles = np.where(np.isin(letters, ["M", "V"]), soup.lines_foldAngle, np.nan)
    soup = replace(
        soup,
        lines_coords=soup.lines_coords[kept],
        lines_assignment=letters[kept],
        lines_foldAngle=angles[kept],
        lines_element=soup.lines_element[kept],
    )
    rows = rows_of(soup, 2)
    soup_rows = of_rows(soup, rows, rows.ends)
    ends, letters = rows.ends, soup_rows.lines_assignment
    crease = ~np.isin(letters, ["B", "C"])
    border = letters == "B"
    if border.any() and crease.any():
        half = _half_kerf(ends, crease, border)
        if half > _LEAST_KERF_MM:
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
    text = f"{dashes} dashes of our own sheet are joined to {int((rows.dashes > 1).sum())} creases"
    findings.append(Finding("dashes-joined", Severity.NOTE, f"{text}, drawn on to their vertices."))
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


def _to_vertices(ends: FloatArray, crease: BoolArray) -> tuple[FloatArray, int]:
    """Creases drawn on to where they meet, and how many of their ends meet nothing."""
    loose = np.repeat(crease[:, None], 2, axis=1)
    for reach in _REACHES_MM:
        ends, moved = extended(ends, loose, np.full(len(ends), reach), _NEAR_MM, _SUPPORT)
        loose &= ~moved
        if not loose.any():
            return ends, 0
    for reach in _REACHES_MM:
        ends, moved = extended(ends, loose, np.full(len(ends), reach), _NEAR_MM, 1)
        loose &= ~moved
    return ends, int(loose.sum())


def _half_kerf(ends: FloatArray, crease: BoolArray, border: BoolArray) -> float:
    """Half of the kerf by which outlines were moved; 0 where it does not show.

    A crease ends m before its vertex. To an outline that was moved by h, and that it meets at the
    angle a, it is m + h / sin a; to other creases at a vertex within, m.
    """
    within = np.concatenate([ends[crease], ends[~crease & ~border]])
    lines = np.concatenate([within, ends[border]])
    loose = np.zeros((len(lines), 2), bool)
    loose[: int(crease.sum())] = True
    rows: list[FloatArray] = []
    for reach in _REACHES_MM:
        count = len(within)
        out, moved = extended(within, loose[:count], np.full(count, reach), _NEAR_MM, _SUPPORT)
        step = np.hypot(*np.moveaxis(out - within, 2, 0))[moved]
        rows.append(np.column_stack([np.ones(len(step)), np.zeros(len(step)), step]))
        at_border, slant = _to_outlines(lines, loose & ~_padded(moved, len(lines)), count, reach)
        rows.append(np.column_stack([np.ones(len(slant)), slant, at_border]))
        loose[:count] &= ~moved
        if len(at_border):
            break
    system = np.concatenate(rows)
    return _agreed(system)


def _padded(mask: BoolArray, count: int) -> BoolArray:
    out: BoolArray = np.zeros((count, 2), bool)
    out[: len(mask)] = mask
    return out


def _to_outlines(
    lines: FloatArray, loose: BoolArray, count: int, reach: float
) -> tuple[FloatArray, FloatArray]:
    """How far the loose ends of the first `count` lines are from the outlines that follow them,
    along the line, and 1 / sin of the angle there.
    """
    import shapely

    line, side = np.nonzero(loose[:count])
    if not len(line):
        return np.empty(0), np.empty(0)
    start = lines[line, side]
    span = lines[line, side] - lines[line, 1 - side]
    along = span / np.hypot(span[:, 0], span[:, 1])[:, None]
    rays = shapely.linestrings(np.stack([start, start + reach * along], axis=1))
    walls = lines[count:]
    ray, wall = shapely.STRtree(shapely.linestrings(walls)).query(rays, predicate="intersects")
    direction = walls[wall, 1] - walls[wall, 0]
    direction /= np.hypot(direction[:, 0], direction[:, 1])[:, None]
    sine = along[ray, 0] * direction[:, 1] - along[ray, 1] * direction[:, 0]
    fits = np.abs(sine) > 0.1
    ray, wall, direction, sine = ray[fits], wall[fits], direction[fits], sine[fits]
    apart = walls[wall, 0] - start[ray]
    at = (apart[:, 0] * direction[:, 1] - apart[:, 1] * direction[:, 0]) / sine
    order = np.lexsort((at, ray))
    order = order[np.diff(ray[order], prepend=-1) != 0]
    return at[order], 1 / np.abs(sine[order])


def _agreed(system: FloatArray) -> float:
    """The h of most equations m + s h = d, rows (1, s, d); 0 where they do not settle it."""
    if len(system) < 2:
        return 0.0
    generator = np.random.default_rng(0)
    best, most = 0.0, 2
    slants = np.unique(np.round(system[:, 1], 6))
    if len(slants) < 2:
        return 0.0
    for _ in range(_TRIALS * 32):
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
        if len(np.unique(np.round(system[agree, 1], 6))) >= 2 and agree.sum() > most:
            most = int(agree.sum())
            fit = np.linalg.lstsq(system[agree, :2], system[agree, 2], rcond=None)[0]
            best = float(fit[1])
    return best if most > len(system) / 4 else 0.0


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
