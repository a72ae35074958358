"""Which crease pattern does a FOLD file of any program hold, and what had to be repaired?

For cutting: no folded form is needed. What can be meant in one way only is repaired, with a finding
that names the edges by their numbers in the file; the rest is refused.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from fab.crease import CreasePattern
from fab.errors import Finding, InvalidFile, Severity
from fab.file_faces import (
    Letters,
    Lines,
    faces_around,
    given_faces,
    listed,
    overlap_findings,
    rebuilt_faces,
    refuse_abutting,
    refuse_open,
)
from fab.fold_file import (
    FULLY_FOLDED,
    flat_coords,
    frame_coords,
    frame_faces,
    frame_list,
    read_frames,
)
from fab.polygons import next_corner
from solver.errors import require_positive
from solver.mesh import edges_of
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = ["read_pattern"]

# FOLD 1.2, frame_unit.
_MM = {"mm": 1.0, "cm": 10.0, "m": 1e3, "in": 25.4, "pt": 25.4 / 72, "um": 1e-3, "nm": 1e-6}
_LETTERS = "BMVFUCJ"
# Which of two letters of the same edge says more.
_RANK = {letter: rank for rank, letter in enumerate("JUFVMCB")}
# Over the diagonal: points nearer to each other, or to a line, lie on it.
_SAME = 1e-8
# Over the largest coordinate, well above its last digit: what the file's own faces keep apart by
# more than this stays apart.
_ROUNDING = 1e-12
_NAMED = 20


def read_pattern(
    path: str | Path, mm_per_unit: float = 1.0
) -> tuple[CreasePattern, tuple[Finding, ...]]:
    """Read the flat sheet of a FOLD file, in millimetres, its lower left corner at the origin.

    mm_per_unit : size of a unit in files that name none.

    The faces that a file lists may lie over each other; `fab.pieces` sets them apart. Without them
    they are found between the edges.

    Raises `InvalidFile` with the place and the cure, among others for faces that cross themselves,
    creases that cross where no faces are listed, outlines that are open, and two letters for one
    edge that exclude each other. Codes of the findings:
    "unit-unknown", "edges-missing", "assignment-missing", "assignment-unknown",
    "fold-angle-missing", "fold-angle-contradicts", "zero-length-edge", "duplicate-edge",
    "vertex-unused", "faces-rebuilt", "hole", "face-clockwise", "face-without-area",
    "border-unmarked", "border-inside", "crease-dangling", "sheet-overlaps",
    "folded-form-differs".
    """
    require_positive("mm_per_unit", mm_per_unit)
    file = Path(path)
    findings: list[Finding] = []
    flat, folded_frame = read_frames(file)
    scale = _scale(file, flat, mm_per_unit, findings)
    coords = flat_coords(file, flat)[:, :2] * scale
    folded = _folded(file, folded_frame, len(coords), findings)
    pairs = _pairs(file, flat, len(coords), findings)
    letters = _letters(file, flat, len(pairs), findings)
    angles = _angles(file, flat, letters, findings)
    near = _SAME * float(np.hypot(*np.ptp(coords, axis=0)))
    rounding = _ROUNDING * float(np.abs(coords).max())
    rows = flat.get("faces_vertices")
    kept, pairs, merged = _distinct(
        file, coords, pairs, letters, rounding if rows else near, findings
    )
    number = np.flatnonzero(kept)
    lines = Lines(file, coords, pairs[kept], letters[kept], angles[kept], number)
    if rows:
        faces, lines = given_faces(lines, rows, merged, rounding, findings)
    else:
        faces = rebuilt_faces(lines, near, findings)
    corners, offsets = faces.corners, faces.offsets
    if not len(faces.number):
        raise InvalidFile(f"{file}: its edges enclose no face. Draw the outline of the sheet.")
    edges = edges_of(corners, offsets)
    source = _places(lines, edges.edges_vertices)
    alone = edges.edges_faces[:, 1] < 0
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
    letters = _with_borders(lines.letters, edges_faces, lines.number, findings)
    angles = np.where(np.isin(letters, ["M", "V", "U"]), lines.angles, 0.0)
    edges_vertices = np.concatenate([edges.edges_vertices, rest.pairs])
    places = np.column_stack([coords, folded * scale])
    places, edges_vertices, corners = _used(places, edges_vertices, corners, merged, findings)
    coords = places[:, :2]
    pattern = CreasePattern(
        coords - coords.min(axis=0),
        edges_vertices,
        edges_faces,
        letters,
        angles,
        corners,
        offsets,
        np.ascontiguousarray(places[:, 2:]) if folded.shape[1] else None,
    )
    return pattern, tuple(findings)


def _folded(
    path: Path, frame: dict[str, Any] | None, count: int, findings: list[Finding]
) -> FloatArray:
    """The folded form's points, shape (nv, 3); (nv, 0) where there is none that fits."""
    if frame is None:
        return np.empty((count, 0))
    coords = frame_coords(path, frame, "folded form")
    if len(coords) == count:
        return coords
    text = f"the folded form has {len(coords)} vertices, the flat sheet {count}: it is left out."
    findings.append(_finding("folded-form-differs", Severity.WARNING, text))
    return np.empty((count, 0))


def _finding(
    code: str, severity: Severity, text: str, edges: IntArray | Sequence[int] = ()
) -> Finding:
    return Finding(code, severity, text, creases=tuple(int(e) for e in edges[:_NAMED]))


def _scale(path: Path, frame: dict[str, Any], mm_per_unit: float, findings: list[Finding]) -> float:
    unit = frame.get("frame_unit", "unit")
    if unit != "unit":
        if not isinstance(unit, str) or unit not in _MM:
            raise InvalidFile(
                f"{path}: frame_unit = {unit!r} must be one of unit, {', '.join(_MM)}."
            )
        return _MM[unit]
    text = f"the file names no unit: one unit is taken for {mm_per_unit:g} mm."
    findings.append(_finding("unit-unknown", Severity.NOTE, text))
    return mm_per_unit


def _pairs(path: Path, frame: dict[str, Any], count: int, findings: list[Finding]) -> IntArray:
    rows = frame_list(path, frame, "edges_vertices", [])
    if not rows:
        if not frame.get("faces_vertices"):
            raise InvalidFile(f"{path}: edges_vertices is missing. Export the file with its edges.")
        for key in ("edges_assignment", "edges_foldAngle"):
            if frame.get(key):
                raise InvalidFile(
                    f"{path}: edges_vertices is missing, so that nobody knows which edges {key} is "
                    f"of. Export the file with its edges, or remove {key}."
                )
        corners, offsets = frame_faces(path, frame["faces_vertices"], count)
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
        angles = frame_list(path, frame, "edges_foldAngle", [])
        if len(angles) != count:
            return np.full(count, "U")
        signs = [np.sign(a) if isinstance(a, int | float) else 0 for a in angles]
        return np.array(["U", "V", "M"])[np.array(signs, dtype=np.int64)]
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


def _angles(
    path: Path, frame: dict[str, Any], letters: Letters, findings: list[Finding]
) -> FloatArray:
    """Fold angles that agree with the letters: the file's own, or fully folded ones."""
    default = np.select([letters == letter for letter in FULLY_FOLDED], list(FULLY_FOLDED.values()))
    found = frame_list(path, frame, "edges_foldAngle", [])
    folds = default != 0
    if not found:
        if folds.any():
            text = "edges_foldAngle is missing: mountains and valleys fold by 180 degrees."
            findings.append(_finding("fold-angle-missing", Severity.NOTE, text))
        return default.astype(float)
    if len(found) != len(letters):
        raise InvalidFile(
            f"{path}: {len(found)} entries of edges_foldAngle for {len(letters)} edges. Give one "
            "for each edge, null where it is not known."
        )
    for number, angle in enumerate(found):
        if angle is not None and not (type(angle) in (int, float) and -180 <= angle <= 180):
            raise InvalidFile(
                f"{path}: fold angle {angle} of edge {number} must lie from -180 to 180 degrees."
            )
    angles = np.array([np.nan if angle is None else angle for angle in found], float)
    missing = np.flatnonzero(np.isnan(angles) & folds)
    if len(missing):
        text = f"{listed('edge', missing)} without fold angle: folded by 180 degrees."
        findings.append(_finding("fold-angle-missing", Severity.NOTE, text, missing))
    angles = np.where(np.isnan(angles), default, angles)
    wrong = np.flatnonzero((angles * default < 0) | ((letters == "F") & (angles != 0)))
    if len(wrong):
        text = (
            f"{listed('edge', wrong)}: the sign of the fold angle ({angles[wrong[0]]:g}) "
            f"contradicts the assignment {letters[wrong[0]]}; the assignment holds."
        )
        findings.append(_finding("fold-angle-contradicts", Severity.WARNING, text, wrong))
        angles[wrong] = np.sign(default[wrong]) * np.abs(angles[wrong])
    return angles


def _distinct(
    path: Path,
    coords: FloatArray,
    pairs: IntArray,
    letters: Letters,
    tolerance: float,
    findings: list[Finding],
) -> tuple[BoolArray, IntArray, IntArray]:
    """Which edges stay, their vertices, and for each vertex the one that stands for it."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    merged = np.arange(len(coords))
    short = np.hypot(*(coords[pairs[:, 1]] - coords[pairs[:, 0]]).T) <= tolerance
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
    rank = np.array([_RANK[letter] for letter in _LETTERS])
    place = np.argsort(list(_LETTERS))
    ranks = rank[place[np.searchsorted(sorted(_LETTERS), letters)]]
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
    coords: FloatArray,
    pairs: IntArray,
    corners: IntArray,
    merged: IntArray,
    findings: list[Finding],
) -> tuple[FloatArray, IntArray, IntArray]:
    """Vertices that are the end of an edge, numbered anew in their order."""
    used = np.zeros(len(coords), bool)
    used[pairs] = True
    unused = np.flatnonzero(~used & (merged == np.arange(len(coords))))
    if len(unused):
        text = f"{len(unused)} vertices without edges, the first is {unused[0]}: removed."
        findings.append(_finding("vertex-unused", Severity.NOTE, text))
    place = np.cumsum(used) - 1
    return coords[used], place[pairs], place[corners]
