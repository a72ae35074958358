"""Which crease pattern does a FOLD file of any program hold, and what had to be repaired?

No folded form is needed. What can be meant in one way only is repaired, with a finding that names
the edges by their numbers in the file; the rest is refused.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from fab.errors import Finding, InvalidFile, Severity
from fab.formats.fold_faces import (
    Faces,
    Letters,
    Lines,
    faces_around,
    given_faces,
    listed,
    overlap_findings,
    rebuilt_faces,
    refuse_abutting,
    refuse_open,
    sides_of_crossed,
)
from fab.formats.fold_frames import (
    Frames,
    State,
    flat_coords,
    frame_coords,
    frame_faces,
    frame_list,
    read_frames,
)
from fab.geometry.rings import next_corner
from fab.pattern.crease_pattern import CreasePattern, fold_angles_deg
from solver.errors import InvalidValue, require_positive
from solver.mesh import Edges, edges_of
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["PatternFile", "pattern_of", "read_pattern", "read_pattern_file"]

# FOLD 1.2, frame_unit.
_MM = {"mm": 1.0, "cm": 10.0, "m": 1e3, "in": 25.4, "pt": 25.4 / 72, "um": 1e-3, "nm": 1e-6}
_LETTERS = "BMVFUCJ"
# Stands for the letter of an edge in a file without letters, until its fold angle is known.
_UNLETTERED = "?"
# Which of two letters of the same edge says more.
_RANK = {letter: rank for rank, letter in enumerate(_UNLETTERED + "JUFVMCB")}
# Over the diagonal: points nearer to each other, or to a line, lie on it.
_SAME = 1e-8
# Over the largest coordinate, well above its last digit: what the file's own faces keep apart by
# more than this stays apart.
_ROUNDING = 1e-12
_NAMED = 20
# Findings about what is as it was written.
_NO_REPAIRS = ("crease-dangling", "sheet-overlaps")
# What a crease without an angle (null) folds by, degrees, by its letter.
_FULLY_FOLDED = {"M": -180.0, "V": 180.0}
# The side to which a crease folds cannot be measured this near to 180 degrees.
_SIDELESS_DEG = 1e-3


@dataclass(frozen=True)
class PatternFile:
    """What was read from a file.

    Attributes
    ----------
    title : of the file; empty where it has none.
    states : other folded shapes than the folded form, by their titles, in mm.
    findings : what was repaired, assumed or noticed.
    """

    title: str
    pattern: CreasePattern
    states: tuple[State, ...]
    findings: tuple[Finding, ...]


def read_pattern(
    path: str | Path, mm_per_unit: float = 1.0, *, strict: bool = False
) -> tuple[CreasePattern, tuple[Finding, ...]]:
    """The pattern and findings of `read_pattern_file`."""
    read = read_pattern_file(path, mm_per_unit, strict=strict)
    return read.pattern, read.findings


def read_pattern_file(
    path: str | Path, mm_per_unit: float = 1.0, *, strict: bool = False
) -> PatternFile:
    """Read the flat sheet of a FOLD file, in millimetres, its lower left corner at the origin.

    mm_per_unit : size of a unit in files that name none.
    strict : raise `InvalidFile` with the text of the first finding where anything is repaired or
        assumed.

    The faces that a file lists may lie over each other; `fab.pieces` sets them apart. Without them
    they are found between the edges. Fold angles that a file lacks are those of its folded form;
    where there is none, mountains and valleys fold by 180 degrees.

    Raises `InvalidFile` with the place and the cure, among others for faces that cross themselves,
    edges with more than two faces, creases that cross where no faces are listed, outlines that are
    open, fold angles beyond 180 degrees, and two letters for one edge that exclude each other.
    Codes of the findings:
    "unit-unknown", "edges-missing", "assignment-missing", "assignment-unknown",
    "fold-angle-measured", "fold-angle-missing", "fold-angle-contradicts", "zero-length-edge",
    "duplicate-edge", "vertex-unused", "faces-rebuilt", "hole", "face-clockwise",
    "face-without-area", "border-unmarked", "border-inside", "folded-form-differs"; and, as no
    repairs, "crease-dangling", "sheet-overlaps".
    """
    file = Path(path)
    return pattern_of(file, read_frames(file), mm_per_unit, strict=strict)


def pattern_of(
    file: Path, frames: Frames, mm_per_unit: float = 1.0, *, strict: bool = False
) -> PatternFile:
    """As `read_pattern_file`, from the frames of a file; its name stands in the messages."""
    require_positive("mm_per_unit", mm_per_unit)
    findings: list[Finding] = []
    flat = frames.flat
    scale = _scale(file, flat, mm_per_unit, findings)
    coords = flat_coords(file, flat)[:, :2] * scale
    count = len(coords)
    forms = [frame for frame in (frames.folded, *frames.states) if frame is not None]
    shapes = [_folded(file, frame, count, scale, findings) for frame in forms]
    folded = shapes[0] if frames.folded is not None else None
    rows = flat.get("faces_vertices")
    listed_faces = frame_faces(file, rows, count) if rows else None
    pairs = _pairs(file, flat, count, listed_faces, findings)
    letters = _letters(file, flat, len(pairs), findings)
    angles = _stored_angles(file, flat, len(pairs))
    near = _SAME * float(np.hypot(*np.ptp(coords, axis=0)))
    rounding = _ROUNDING * float(np.abs(coords).max())
    reach = np.full(len(pairs), near)
    if listed_faces is not None:
        crossed = sides_of_crossed(coords, *listed_faces, pairs)
        reach = np.where(crossed, near, rounding)
    kept, pairs, merged = _distinct(file, coords, pairs, letters, reach, findings)
    number = np.flatnonzero(kept)
    lines = Lines(file, coords, pairs[kept], letters[kept], angles[kept], number)
    if listed_faces is not None:
        faces, lines = given_faces(lines, *listed_faces, merged, rounding, findings)
    else:
        faces = rebuilt_faces(lines, near, findings)
    corners, offsets = faces.corners, faces.offsets
    if not len(faces.number):
        raise InvalidFile(f"{file}: its edges enclose no face. Draw the outline of the sheet.")
    edges = edges_of(corners, offsets)
    source = _places(lines, edges.edges_vertices)
    alone = edges.edges_faces[:, 1] < 0
    if folded is None:  # it tells lips from what was torn apart
        sides = replace(lines.part(source[alone]), pairs=edges.edges_vertices[alone])
        refuse_abutting(sides, near)
    loose = np.setdiff1d(np.arange(len(lines.pairs)), source)
    lines = lines.part(np.concatenate([source, loose]))
    within = faces_around(lines, faces, edges.edges_faces, near)
    edges_faces = np.concatenate([edges.edges_faces, np.column_stack([within, within])])
    rest = lines.part(np.arange(len(source), len(lines.pairs)))
    refuse_open(rest)
    _note_loose(rest.number, findings)
    findings += overlap_findings(lines, faces, edges)
    lines = _with_angles(lines, faces, edges, folded, flat, findings)
    letters = _with_borders(lines.letters, edges_faces, lines.number, findings)
    angles = np.where(np.isin(letters, ["M", "V", "U"]), lines.angles, 0.0)
    edges_vertices = np.concatenate([edges.edges_vertices, rest.pairs])
    used, edges_vertices, corners = _used(count, edges_vertices, corners, merged, findings)
    coords = coords[used]
    states = [
        (str(frame.get("frame_title", "")), shape[used])
        for frame, shape in zip(forms, shapes, strict=True)
        if shape is not None and frame is not frames.folded
    ]
    pattern = CreasePattern(
        coords - coords.min(axis=0),
        edges_vertices,
        edges_faces,
        letters,
        angles,
        corners,
        offsets,
        None if folded is None else folded[used],
    )
    repairs = [finding for finding in findings if finding.code not in _NO_REPAIRS]
    if strict and repairs:
        raise InvalidFile(f"{file}: {repairs[0].text}")
    return PatternFile(frames.title, pattern, tuple(states), tuple(findings))


def _folded(
    path: Path, frame: dict[str, Any], count: int, scale: float, findings: list[Finding]
) -> FloatArray | None:
    """Points of a folded frame in mm, shape (nv, 3); None where they do not fit.

    scale : of the flat sheet, for frames that name no unit.
    """
    title = str(frame.get("frame_title") or "folded form")
    coords = frame_coords(path, frame, title)
    if len(coords) == count:
        named = frame.get("frame_unit", "unit") != "unit"
        return coords * (_mm(path, frame) if named else scale)
    text = f"the {title} has {len(coords)} vertices, the flat sheet {count}: it is left out."
    findings.append(_finding("folded-form-differs", Severity.WARNING, text))
    return None


def _finding(
    code: str, severity: Severity, text: str, edges: IntArray | Sequence[int] = ()
) -> Finding:
    return Finding(code, severity, text, creases=tuple(int(e) for e in edges[:_NAMED]))


def _scale(path: Path, frame: dict[str, Any], mm_per_unit: float, findings: list[Finding]) -> float:
    if frame.get("frame_unit", "unit") != "unit":
        return _mm(path, frame)
    text = f"the file names no unit: one unit is taken for {mm_per_unit:g} mm."
    findings.append(_finding("unit-unknown", Severity.NOTE, text))
    return mm_per_unit


def _mm(path: Path, frame: dict[str, Any]) -> float:
    unit = frame["frame_unit"]
    if not isinstance(unit, str) or unit not in _MM:
        raise InvalidFile(f"{path}: frame_unit = {unit!r} must be one of unit, {', '.join(_MM)}.")
    return _MM[unit]


def _pairs(
    path: Path,
    frame: dict[str, Any],
    count: int,
    faces: tuple[IntArray, IntArray] | None,
    findings: list[Finding],
) -> IntArray:
    rows = frame_list(path, frame, "edges_vertices", [])
    if not rows:
        if faces is None:
            raise InvalidFile(f"{path}: edges_vertices is missing. Export the file with its edges.")
        for key in ("edges_assignment", "edges_foldAngle"):
            if frame.get(key):
                raise InvalidFile(
                    f"{path}: edges_vertices is missing, so that nobody knows which edges {key} is "
                    f"of. Export the file with its edges, or remove {key}."
                )
        corners, offsets = faces
        text = "edges_vertices is missing: the edges are those of the faces."
        findings.append(_finding("edges-missing", Severity.WARNING, text))
        sides = np.sort(np.column_stack([corners, corners[next_corner(offsets)]]), axis=1)
        return np.unique(sides, axis=0)
    try:
        pairs = np.array(rows)
    except (ValueError, OverflowError):
        pairs = np.array(["ragged"])
    if pairs.shape != (len(rows), 2) or pairs.dtype.kind != "i":
        for number, row in enumerate(rows):
            if not isinstance(row, list) or len(row) != 2 or any(type(v) is not int for v in row):
                raise InvalidFile(f"{path}: edge {number} must have two vertex numbers.")
    bad = np.flatnonzero(((pairs < 0) | (pairs >= count)).any(axis=1))
    if len(bad):
        raise InvalidFile(
            f"{path}: edge {bad[0]} names the vertices {pairs[bad[0]].tolist()}; vertices run from "
            f"0 to {count - 1}."
        )
    return pairs.astype(np.int64)


def _letters(path: Path, frame: dict[str, Any], count: int, findings: list[Finding]) -> Letters:
    found = frame_list(path, frame, "edges_assignment", [])
    if not found:
        text = "edges_assignment is missing: mountains and valleys are those of the fold angles."
        findings.append(_finding("assignment-missing", Severity.WARNING, text))
        return np.full(count, _UNLETTERED)
    if len(found) != count:
        raise InvalidFile(
            f"{path}: {len(found)} entries of edges_assignment for {count} edges. Give one for "
            "each edge, U where it is not known."
        )
    given = np.array([str(letter) for letter in found])
    upper = np.char.upper(given)
    unknown = ~np.isin(upper, list(_LETTERS))
    odd = np.flatnonzero(unknown | (given != upper))
    if len(odd):
        severity = Severity.WARNING if unknown.any() else Severity.NOTE
        text = (
            f"{listed('edge', odd)}: the assignment {found[odd[0]]!r} is none of "
            f"{', '.join(_LETTERS)}; lower case is taken for upper case, anything else for U "
            "(unassigned, not cut)."
        )
        findings.append(_finding("assignment-unknown", severity, text, odd))
    return np.where(unknown, "U", upper).astype("U1")


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
                f"{path}: fold angle {angle} of edge {number} must lie from -180 to 180 degrees."
            )
    return np.array([np.nan if angle is None else angle for angle in found], float)


def _with_angles(
    lines: Lines,
    faces: Faces,
    edges: Edges,
    folded: FloatArray | None,
    frame: dict[str, Any],
    findings: list[Finding],
) -> Lines:
    """The lines with letters and fold angles that agree, the sides of the faces first."""
    letters, angles = lines.letters, lines.angles
    default = np.select([letters == letter for letter in _FULLY_FOLDED], [*_FULLY_FOLDED.values()])
    unlettered = letters == _UNLETTERED
    border = np.zeros(len(letters), bool)
    border[: len(edges.edges_faces)] = edges.edges_faces[:, 1] < 0
    lacking = np.isnan(angles) & ((default != 0) | (letters == "U") | unlettered)
    lacking &= ~border
    if folded is not None and lacking.any():
        measured = np.full(len(angles), np.nan)
        measured[: len(edges.edges_faces)] = _measured(lines.path, faces, edges, folded)
        sideless = (default != 0) & (np.abs(measured) > 180 - _SIDELESS_DEG)
        measured[sideless] = default[sideless]
        which = np.sort(lines.number[lacking & ~np.isnan(measured)])
        text = f"{listed('edge', which)} without fold angle: that of the folded form is taken."
        findings.append(_finding("fold-angle-measured", Severity.NOTE, text, which))
        angles = np.where(lacking, measured, angles)
    missing = np.sort(lines.number[np.isnan(angles) & (default != 0)])
    if len(missing):
        text = f"{listed('edge', missing)} without fold angle: folded by 180 degrees."
        if not frame.get("edges_foldAngle"):
            text = "edges_foldAngle is missing: mountains and valleys fold by 180 degrees."
            missing = missing[:0]
        findings.append(_finding("fold-angle-missing", Severity.NOTE, text, missing))
    signed = np.where(angles > 0, "V", np.where(angles < 0, "M", "F"))
    signed = np.where(border, "B", np.where(np.isnan(angles), "U", signed))
    letters = np.where(unlettered, signed, letters)
    angles = np.where(np.isnan(angles), default, angles)
    wrong = np.flatnonzero((angles * default < 0) | ((letters == "F") & (angles != 0)))
    if len(wrong):
        wrong = wrong[np.argsort(lines.number[wrong])]
        text = (
            f"{listed('edge', lines.number[wrong])}: the sign of the fold angle "
            f"({angles[wrong[0]]:g}) contradicts the assignment {letters[wrong[0]]}; the "
            "assignment holds."
        )
        code = "fold-angle-contradicts"
        findings.append(_finding(code, Severity.WARNING, text, lines.number[wrong]))
        angles[wrong] = np.sign(default[wrong]) * np.abs(angles[wrong])
    return replace(lines, letters=letters, angles=angles)


def _measured(path: Path, faces: Faces, edges: Edges, folded: FloatArray) -> FloatArray:
    try:
        return fold_angles_deg(folded, edges, faces.corners, faces.offsets)
    except InvalidValue as error:
        raise InvalidFile(f"{path}: folded form: {error}") from error


def _distinct(
    path: Path,
    coords: FloatArray,
    pairs: IntArray,
    letters: Letters,
    reach: FloatArray,
    findings: list[Finding],
) -> tuple[BoolArray, IntArray, IntArray]:
    """Which edges stay, their vertices, and for each vertex the one that stands for it.

    reach : edges that are no longer than this have no length, mm, shape (n,).
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    merged = np.arange(len(coords))
    short = np.hypot(*(coords[pairs[:, 1]] - coords[pairs[:, 0]]).T) <= reach
    if short.any():
        one, two = pairs[short].T
        graph = coo_array((np.ones(len(one)), (one, two)), shape=(len(coords), len(coords)))
        _, label = connected_components(graph, directed=False)
        _, first = np.unique(label, return_index=True)
        merged = first[label]
        pairs = merged[pairs]
        which = np.flatnonzero(short)
        text = f"{listed('edge', which)} without length: removed, its ends merged."
        findings.append(_finding("zero-length-edge", Severity.WARNING, text, which))
    kept = pairs[:, 0] != pairs[:, 1]
    key = pairs.min(axis=1) * len(coords) + pairs.max(axis=1)
    known = sorted(_RANK)
    ranks = np.array([_RANK[letter] for letter in known])[np.searchsorted(known, letters)]
    order = np.lexsort((np.arange(len(key)), -ranks, key))
    order = order[kept[order]]
    repeated = np.flatnonzero(key[order][1:] == key[order][:-1]) + 1
    for again in repeated.tolist():
        one, two = order[again - 1], order[again]
        if {str(letters[one]), str(letters[two])} == {"M", "V"}:
            raise InvalidFile(
                f"{path}: edges {two} and {one} join the same vertices, {letters[two]} and "
                f"{letters[one]}. Remove one of them."
            )
    if len(repeated):
        which = np.sort(order[repeated])
        kept[which] = False
        text = f"{listed('edge', which)}: a second edge between the same vertices; removed."
        findings.append(_finding("duplicate-edge", Severity.WARNING, text, which))
    return kept, pairs, merged


def _places(lines: Lines, sides: IntArray) -> IntArray:
    """Which of the lines each side of the faces is."""
    keys, wanted = lines.keys(), lines.keys(sides)
    order = np.argsort(keys)
    place: IntArray = order[np.minimum(np.searchsorted(keys[order], wanted), len(keys) - 1)]
    lacking = np.flatnonzero(keys[place] != wanted)
    if len(lacking):
        one, two = sides[lacking[0]]
        raise InvalidFile(
            f"{lines.path}: edges_vertices lacks the side ({one}, {two}) of a face. Add it."
        )
    return place


def _note_loose(number: IntArray, findings: list[Finding]) -> None:
    if len(number):
        names = listed("edge", np.sort(number))
        text = f"{names} ends within a face: it can be cut, but not folded flat."
        findings.append(_finding("crease-dangling", Severity.WARNING, text, np.sort(number)))


def _with_borders(
    letters: Letters, edges_faces: IntArray, number: IntArray, findings: list[Finding]
) -> Letters:
    """B on all edges with one face, and on no others."""
    alone = edges_faces[:, 1] < 0
    unmarked = np.sort(number[alone & (letters != "B")])
    if len(unmarked):
        text = f"{listed('edge', unmarked)} with a face on one side alone: taken for border (B)."
        findings.append(_finding("border-unmarked", Severity.WARNING, text, unmarked))
    inside = np.sort(number[~alone & (letters == "B")])
    if len(inside):
        text = (
            f"{listed('edge', inside)}: a border with faces on both sides is taken for a cut (C)."
        )
        findings.append(_finding("border-inside", Severity.WARNING, text, inside))
    return np.where(alone, "B", np.where(letters == "B", "C", letters))


def _used(
    count: int, pairs: IntArray, corners: IntArray, merged: IntArray, findings: list[Finding]
) -> tuple[BoolArray, IntArray, IntArray]:
    """Which vertices are the end of an edge; pairs and corners with these numbered anew."""
    used = np.zeros(count, bool)
    used[pairs] = True
    unused = np.flatnonzero(~used & (merged == np.arange(count)))
    if len(unused):
        text = f"{len(unused)} vertices without edges, the first is {unused[0]}: removed."
        findings.append(_finding("vertex-unused", Severity.NOTE, text))
    place = np.cumsum(used) - 1
    return used, place[pairs], place[corners]
