"""The crease pattern in a FOLD file of any program, and what had to be repaired.

No folded form is needed. What can be meant in one way only is repaired, with a finding that names
the edges by their numbers in the file; the rest is refused. Faces that a file lists stay as they
are, over each other or not; without them, its edges are lines of a drawing to the importer.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from fab.errors import Finding, InvalidFile, Severity, counted, first_few
from fab.formats.coordinate_bounds import require_range
from fab.formats.drawn.importer import (
    findings_of,
    imported_lines,
    pattern_of_sheet,
)
from fab.formats.drawn.letters import unused_colours
from fab.formats.drawn.line_soup import LETTERS, UNLETTERED, Letters
from fab.formats.drawn.lines import Faces, Lines, listed, places_of
from fab.formats.drawn.planar_lines import DrawnLines, ranks_of
from fab.formats.drawn.sheet_pattern import sheet_pattern
from fab.formats.fold.face_orders import read_face_orders
from fab.formats.fold.faces import (
    faces_around,
    given_faces,
    overlap_findings,
    refuse_abutting,
    sides_of_crossed,
)
from fab.formats.fold.frames import (
    Frames,
    frame_coords,
    frame_faces,
    frame_list,
    frame_pairs,
    frame_title,
    read_frames,
)
from fab.formats.pattern_file import PatternFile
from fab.formats.read_options import ReadOptions
from fab.formats.source_files import shown
from fab.formats.strictness import require_no_repairs
from fab.formats.units import unit_named, unit_unknown
from fab.geometry.arrangement import Arrangement
from fab.geometry.rings import ring_areas
from solver.graphs import labels
from solver.mesh import Edges, edges_of
from solver.polygons import next_corner
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["pattern_of", "read_fold"]

# FOLD 1.2, frame_unit.
_MM = {"mm": 1.0, "cm": 10.0, "m": 1e3, "in": 25.4, "pt": 25.4 / 72, "um": 1e-3, "nm": 1e-6}
_DEFAULT_MM = 1.0
# Over the diagonal: points nearer to each other, or to a line, are on it.
_SAME = 1e-8
# Over the largest coordinate, well above its last digit: what the file's own faces keep apart by
# more than this stays apart.
_ROUNDING = 1e-12
# Over the folded form: points of one vertex there may be so far apart.
_FOLDED_REL = 1e-6


def read_fold(path: str | Path, options: ReadOptions | None = None) -> PatternFile:
    """Read the flat sheet of a FOLD file, in millimetres, its lower left corner at the origin.

    The faces that a file lists may lie over each other; `fab.sheets.pieces` sets them apart.
    Without them the importer finds them between the edges. Fold angles that a file lacks are those
    of its folded form; where there is none, mountains and valleys fold by `options.fold_deg`.

    Raises `InvalidFile` with the place and the cure, among others for faces that cross themselves,
    edges with more than two faces, outlines that are open, borders within the sheet, fold angles
    beyond 180 degrees, two letters for one edge that exclude each other; and with the first finding
    where `options.strict` and anything is repaired or assumed.

    Codes of the findings, beside those of the importer (`pattern_of_lines`): "unit-unknown",
    "several-patterns", "flat-form-taken", "unfolded", "side-assumed", "edges-missing",
    "assignment-missing", "assignment-unknown", "fold-angle-measured", "fold-angle-missing",
    "fold-angle-contradicts", "fold-angle-zero", "zero-length-edge", "duplicate-edge",
    "vertices-merged", "vertex-unused", "faces-rebuilt", "face-clockwise", "face-without-area",
    "border-unmarked", "border-inside", "folded-form-differs", "face-orders-unknown"; and, as no
    repairs, "crease-dangling", "frame-turned", "frames-left-out", "hole",
    "merge-unused", "sheet-overlaps".
    """
    options = ReadOptions() if options is None else options
    file = Path(path)
    return pattern_of(file, read_frames(file, options), options)


def pattern_of(file: Path, frames: Frames, options: ReadOptions) -> PatternFile:
    """As `read_fold`, from the frames of a file, whose name is in the messages."""
    findings = [*frames.findings, *unused_colours(options.colours, ())]
    flat = frames.flat
    scale, found = _scale(file, flat, options)
    findings += found
    coords = frames.coords * scale
    require_range(file, coords, "crease pattern in mm")
    count = len(coords)
    forms = [frame for frame in (frames.folded, *frames.states) if frame is not None]
    shapes = []
    for frame in forms:
        shape, found = _folded(file, frame, count, scale)
        shapes.append(shape)
        findings += found
    folded = shapes[0] if frames.folded is not None else None
    rows = flat.get("faces_vertices")
    faces = frame_faces(file, rows, count) if rows else None
    by_angles = folded is not None or bool(flat.get("edges_foldAngle"))
    lines, merged, found = _lines(file, flat, coords, faces, by_angles=by_angles)
    findings += found
    given: Faces | None = None
    none_given = "" if flat.get("edges_foldAngle") else "edges_foldAngle is missing"
    if faces is None:
        drawn = DrawnLines(coords[lines.pairs], lines, lines.pairs)
        sheet, planar = imported_lines(drawn, options, joins_runs=False)
        count_faces = counted(len(sheet.faces.number), "face")
        text = f"faces_vertices is missing: {count_faces} found between the edges."
        findings.append(Finding("faces-rebuilt", Severity.NOTE, text))
        source, found = _vertices_merged(lines, planar.graph)
        findings += found
        moved = []
        for shape in shapes:
            shape, found = _moved(shape, lines, planar.graph)
            moved.append(shape)
            findings += found
        shapes = moved
        folded = shapes[0] if frames.folded is not None else None
        made = pattern_of_sheet(sheet, folded, options, none_given=none_given)
        findings += findings_of(sheet, made)
        unused = np.setdiff1d(np.arange(count), [*np.unique(lines.pairs), *source])
    else:
        if options.merge_mm is not None:
            text = (
                f"--merge-mm {options.merge_mm:g} has no effect: the file lists its faces, and "
                "vertices are joined in drawings alone."
            )
            findings.append(Finding("merge-unused", Severity.WARNING, text))
        rounding = _ROUNDING * float(np.abs(coords).max())
        near = _SAME * _diagonal(coords)
        given, lines, found = given_faces(lines, *faces, merged, rounding)
        findings += found
        if not len(given.number):
            raise InvalidFile(f"{file}: its edges enclose no face. Draw the outline of the sheet.")
        if folded is None:  # it tells lips from what was torn apart
            _refuse_abutting(lines, edges_of(given.corners, given.offsets), near)

        def around(ordered: Lines, edges_faces: IntArray) -> IntArray:
            return faces_around(ordered, given, edges_faces, near)

        made = sheet_pattern(lines, given, around, folded, options, none_given=none_given)
        findings += overlap_findings(made.lines, given, made.edges)
        findings += made.findings
        unused = np.flatnonzero(~made.used)
    unused = unused[merged[unused] == unused]
    if len(unused):
        noun = counted(len(unused), "vertex", "vertices")
        text = f"{noun} without edges, the first is {unused[0]}: removed."
        findings.append(Finding("vertex-unused", Severity.NOTE, text))
    states = [
        (frame_title(frame), shape[made.used])
        for frame, shape in zip(forms, shapes, strict=True)
        if shape is not None and frame is not frames.folded
    ]
    orders, found = _face_orders(frames, coords, faces, given)
    findings += found
    require_no_repairs(file, findings, options)
    return PatternFile(
        frames.title,
        made.pattern,
        tuple(states),
        tuple(findings),
        frames.patterns,
        scale,
        made.origin,
        orders,
    )


def _face_orders(
    frames: Frames,
    coords: FloatArray,
    faces: tuple[IntArray, IntArray] | None,
    given: Faces | None,
) -> tuple[IntArray, list[Finding]]:
    """Rows of faceOrders of the folded form, or of the sheet, by the faces of the pattern."""
    rows = [frame.get("faceOrders") for frame in (frames.folded, frames.flat) if frame is not None]
    rows = [each for each in rows if each]
    if not rows or faces is None or given is None:
        return np.empty((0, 3), np.int64), []
    corners, offsets = faces
    turned = ring_areas(coords[corners], offsets) < 0
    return read_face_orders(rows[0], len(offsets) - 1, given.number, turned[given.number])


def _diagonal(coords: FloatArray) -> float:
    return float(np.hypot(*np.ptp(coords, axis=0)))


def _lines(
    file: Path,
    flat: dict[str, Any],
    coords: FloatArray,
    faces: tuple[IntArray, IntArray] | None,
    *,
    by_angles: bool,
) -> tuple[Lines, IntArray, list[Finding]]:
    """Edges of the file, each once and with length, what each vertex became, and findings."""
    pairs, findings = _pairs(file, flat, len(coords), faces)
    letters, found = _letters(file, flat, len(pairs), by_angles=by_angles)
    findings += found
    angles = _stored_angles(file, flat, len(pairs))
    near = _SAME * _diagonal(coords)
    reach = np.full(len(pairs), near)
    if faces is not None:
        crossed = sides_of_crossed(coords, *faces, pairs)
        reach = np.where(crossed, near, _ROUNDING * float(np.abs(coords).max()))
    kept, pairs, merged, found = _distinct(file, coords, pairs, letters, reach)
    findings += found
    number = np.flatnonzero(kept)
    place = np.arange(len(number))
    lines = Lines(file, coords, pairs[kept], letters[kept], angles[kept], number, place)
    return lines, merged, findings


def _refuse_abutting(lines: Lines, edges: Edges, near: float) -> None:
    alone = edges.edges_vertices[edges.edges_faces[:, 1] < 0]
    keys, wanted = lines.keys(), lines.keys(alone)
    order = np.argsort(keys)
    place = order[np.searchsorted(keys[order], wanted).clip(max=len(keys) - 1)]
    known = keys[place] == wanted
    refuse_abutting(replace(lines.part(place[known]), pairs=alone[known]), near)


def _vertices_merged(lines: Lines, graph: Arrangement) -> tuple[IntArray, list[Finding]]:
    """Vertices of the file that stand in the pattern, and what is reported of the others."""
    ends = graph.ends_vertex[: len(lines.pairs)]  # a hull may follow
    named = ends >= 0
    source = np.full(len(graph.vertices_coords), len(lines.coords))
    np.minimum.at(source, ends[named], lines.pairs[named])
    gone = np.setdiff1d(lines.pairs[named], source)
    if not len(gone):
        return source, []
    place = lines.point(lines.coords[gone[0]])
    several = len(gone) > 1
    text = (
        f"{listed('vertex', gone, 'vertices')} in the {'places' if several else 'place'} of "
        f"{'others' if several else 'another'}, the first at {place}: merged."
    )
    places = places_of(lines.coords[gone])
    return source, [Finding("vertices-merged", Severity.WARNING, text, places=places)]


def _moved(
    shape: FloatArray | None, lines: Lines, graph: Arrangement
) -> tuple[FloatArray | None, list[Finding]]:
    """A folded shape for the vertices of the planar graph: new ones are between those of edges."""
    if shape is None:
        return None, []
    count = len(graph.vertices_coords)
    line, edge = graph.line_pairs
    drawn = line < len(lines.pairs)  # a hull may follow
    line, vertex = np.repeat(line[drawn], 2), graph.edges_vertices[edge[drawn]].ravel()
    start, end = graph.lines_coords[line].swapaxes(0, 1)
    span = end - start
    share = ((graph.vertices_coords[vertex] - start) * span).sum(axis=1) / (span**2).sum(axis=1)
    ends = graph.ends_vertex[line]
    share = np.where(vertex == ends[:, 0], 0.0, np.where(vertex == ends[:, 1], 1.0, share))
    first, second = shape[lines.pairs[line]].swapaxes(0, 1)
    exact = np.where((share == 1.0)[:, None], second, first)
    points = np.where(
        ((share == 0.0) | (share == 1.0))[:, None], exact, first + share[:, None] * (second - first)
    )
    out = np.zeros((count, 3))
    out[vertex[::-1]] = points[::-1]
    apart = np.sqrt(((points - out[vertex]) ** 2).sum(axis=1))
    size = float(np.sqrt((np.ptp(shape, axis=0) ** 2).sum()))
    if apart.max(initial=0.0) <= _FOLDED_REL * size:
        return out, []
    worst = int(vertex[int(apart.argmax())])
    text = (
        f"edges that meet at {lines.point(graph.vertices_coords[worst])} in the flat sheet are up "
        f"to {apart.max():.3g} mm apart in the folded form: the folded form is left out."
    )
    return None, [Finding("folded-form-differs", Severity.WARNING, text)]


def _folded(
    path: Path, frame: dict[str, Any], count: int, scale: float
) -> tuple[FloatArray | None, list[Finding]]:
    """Points of a folded frame in mm, shape (nv, 3); None where they do not fit.

    scale : of the flat sheet, for frames that name no unit.
    """
    title = frame_title(frame) or "folded form"
    coords = frame_coords(path, frame, title)
    if len(coords) == count:
        named = frame.get("frame_unit", "unit") != "unit"
        return coords * (_mm(path, frame) if named else scale), []
    text = f"the {title} has {len(coords)} vertices, the flat sheet {count}: it is left out."
    return None, [_finding("folded-form-differs", Severity.WARNING, text)]


def _finding(
    code: str,
    severity: Severity,
    text: str,
    edges: IntArray | Sequence[int] = (),
    places: FloatArray | None = None,
) -> Finding:
    marked = () if places is None else places_of(places)
    return Finding(code, severity, text, creases=first_few(edges), places=marked)


def _scale(path: Path, frame: dict[str, Any], options: ReadOptions) -> tuple[float, list[Finding]]:
    if frame.get("frame_unit", "unit") != "unit":
        named = _mm(path, frame)
        return named, unit_named(named, options)
    if options.mm_per_unit is not None:
        return options.mm_per_unit, []
    return _DEFAULT_MM, [unit_unknown("the file names no unit: one unit", _DEFAULT_MM)]


def _briefly(value: Any) -> str:
    """A value of the file for a message, short whatever it is."""
    return str(value) if isinstance(value, float | int | None) else shown(str(value))


def _mm(path: Path, frame: dict[str, Any]) -> float:
    unit = frame["frame_unit"]
    if not isinstance(unit, str) or unit not in _MM:
        raise InvalidFile(
            f"{path}: frame_unit = {_briefly(unit)} must be one of unit, {', '.join(_MM)}."
        )
    return _MM[unit]


def _pairs(
    path: Path, frame: dict[str, Any], count: int, faces: tuple[IntArray, IntArray] | None
) -> tuple[IntArray, list[Finding]]:
    if frame_list(path, frame, "edges_vertices", []):
        return frame_pairs(path, frame, count), []
    if faces is None:
        raise InvalidFile(f"{path}: edges_vertices is missing. Export the file with its edges.")
    for key in ("edges_assignment", "edges_foldAngle"):
        if frame.get(key):
            raise InvalidFile(
                f"{path}: edges_vertices is missing, so that nobody knows which edges {key} is "
                f"of. Export the file with its edges, or remove {key}."
            )
    corners, offsets = faces
    text = "the file lists no edges (edges_vertices): they are the sides of its faces."
    sides = np.sort(np.column_stack([corners, corners[next_corner(offsets)]]), axis=1)
    return np.unique(sides, axis=0), [_finding("edges-missing", Severity.WARNING, text)]


def _letters(
    path: Path, frame: dict[str, Any], count: int, *, by_angles: bool
) -> tuple[Letters, list[Finding]]:
    """Letters of the edges; by_angles: whether fold angles give those that the file lacks."""
    found = frame_list(path, frame, "edges_assignment", [])
    if not found:
        text = (
            "the file has no assignments (edges_assignment): mountains and valleys are those of "
            "the fold angles."
            if by_angles
            else "the file has neither assignments (edges_assignment) nor fold angles: no crease "
            "is a mountain or a valley."
        )
        found_none = _finding("assignment-missing", Severity.WARNING, text)
        return np.full(count, UNLETTERED), [found_none]
    if len(found) != count:
        raise InvalidFile(
            f"{path}: {len(found)} entries of edges_assignment for {count} edges. Give one for "
            "each edge, U where it is not known."
        )
    # longer words are none of them, and would make the array as wide as they are
    given = np.array([str(letter)[:2] for letter in found])
    upper = np.char.upper(given)
    unknown = ~np.isin(upper, list(LETTERS))
    odd = np.flatnonzero(unknown | (given != upper))
    findings = []
    if len(odd):
        severity = Severity.WARNING if unknown.any() else Severity.NOTE
        text = (
            f"{listed('edge', odd)}: the assignment {_briefly(found[odd[0]])} is none of "
            f"{', '.join(LETTERS)}; lower case is taken for upper case, anything else for U "
            "(unassigned, not cut)."
        )
        findings.append(_finding("assignment-unknown", severity, text, odd))
    return np.where(unknown, "U", upper).astype("U1"), findings


def _stored_angles(path: Path, frame: dict[str, Any], count: int) -> FloatArray:
    """Fold angles of the file, degrees, NaN where it has none, shape (count,)."""
    found = frame_list(path, frame, "edges_foldAngle", [])
    if not found:
        return np.full(count, np.nan)
    if len(found) != count:
        raise InvalidFile(
            f"{path}: {len(found)} entries of edges_foldAngle for {count} edges. Give one for each "
            "edge, null where it is not known."
        )
    for number, angle in enumerate(found):
        if angle is not None and not (type(angle) in (int, float) and -180 <= angle <= 180):
            raise InvalidFile(
                f"{path}: fold angle {_briefly(angle)} of edge {number} must be from -180 to 180 "
                "degrees."
            )
    return np.array([np.nan if angle is None else angle for angle in found], float)


def _distinct(
    path: Path,
    coords: FloatArray,
    pairs: IntArray,
    letters: Letters,
    reach: FloatArray,
) -> tuple[BoolArray, IntArray, IntArray, list[Finding]]:
    """Which edges stay, their vertices, what each vertex became, and findings.

    reach : edges that are no longer than this have no length, mm, shape (n,).
    """
    findings = []
    merged = np.arange(len(coords))
    short = np.hypot(*(coords[pairs[:, 1]] - coords[pairs[:, 0]]).T) <= reach
    if short.any():
        label = labels(pairs[short], len(coords))
        _, first = np.unique(label, return_index=True)
        merged = first[label]
        pairs = merged[pairs]
        which = np.flatnonzero(short)
        text = f"{listed('edge', which)} without length: removed, its ends merged."
        places = coords[pairs[which, 0]]
        findings.append(_finding("zero-length-edge", Severity.WARNING, text, which, places))
    kept = pairs[:, 0] != pairs[:, 1]
    key = pairs.min(axis=1) * len(coords) + pairs.max(axis=1)
    order = np.lexsort((np.arange(len(key)), -ranks_of(letters), key))
    order = order[kept[order]]
    repeated = np.flatnonzero(key[order][1:] == key[order][:-1]) + 1
    for again in repeated.tolist():
        first_edge, second = order[again - 1], order[again]
        if {str(letters[first_edge]), str(letters[second])} == {"M", "V"}:
            raise InvalidFile(
                f"{path}: edges {second} and {first_edge} join the same vertices, "
                f"{letters[second]} and {letters[first_edge]}. Remove one of them."
            )
    if len(repeated):
        which = np.sort(order[repeated])
        kept[which] = False
        text = f"{listed('edge', which)}: a second edge between the same vertices; removed."
        places = coords[pairs[which]].mean(axis=1)
        findings.append(_finding("duplicate-edge", Severity.WARNING, text, which, places))
    return kept, pairs, merged, findings
