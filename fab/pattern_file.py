"""Which crease pattern does a FOLD file of any program hold, and what had to be repaired?

For cutting: no folded form is needed. What can be meant in one way only is repaired, with a finding
that names the edges by their numbers in the file; the rest is refused.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fab.crease import CreasePattern
from fab.errors import Finding, InvalidFile, Severity
from fab.fold_file import (
    FULLY_FOLDED,
    flat_coords,
    frame_coords,
    frame_faces,
    frame_list,
    read_frames,
)
from fab.planar import enclosed_faces, first_crossing, without_dangling
from fab.polygons import next_corner, ring_areas
from solver.errors import InvalidValue, require_positive
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
_NAMED = 20

Letters = NDArray[np.str_]


def read_pattern(
    path: str | Path, mm_per_unit: float = 1.0
) -> tuple[CreasePattern, tuple[Finding, ...]]:
    """Read the flat sheet of a FOLD file, in millimetres, its lower left corner at the origin.

    mm_per_unit : size of a unit in files that name none.

    Raises `InvalidFile` with the place and the cure, among others for creases that cross, outlines
    that are open, and two letters for one edge that exclude each other. Codes of the findings:
    "unit-unknown", "edges-missing", "assignment-missing", "assignment-unknown",
    "fold-angle-missing", "fold-angle-contradicts", "zero-length-edge", "duplicate-edge",
    "vertex-unused", "faces-rebuilt", "hole", "face-clockwise", "face-without-area",
    "border-unmarked", "border-inside", "crease-dangling".
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
    tolerance = _SAME * float(np.hypot(*np.ptp(coords, axis=0)))
    kept, pairs, merged = _distinct(file, coords, pairs, letters, tolerance, findings)
    number = np.flatnonzero(kept)
    pairs, letters, angles = pairs[kept], letters[kept], angles[kept]
    _refuse_crossings(file, coords, pairs, letters, number, tolerance)
    dangling = ~without_dangling(pairs)
    _refuse_open(file, coords, pairs[dangling], letters[dangling], number[dangling])
    if flat.get("faces_vertices"):
        corners, offsets = _given_faces(file, flat["faces_vertices"], coords, merged, findings)
    else:
        corners, offsets = _rebuilt_faces(coords, pairs[~dangling], letters[~dangling], findings)
        _refuse_islands(file, coords, pairs[~dangling], number[~dangling], corners, offsets)
    if len(offsets) == 1:
        raise InvalidFile(f"{file}: its edges enclose no face. Draw the outline of the sheet.")
    try:
        edges = edges_of(corners, offsets)
    except InvalidValue as error:
        raise InvalidFile(f"{file}: {error}") from error
    source = _places(file, edges.edges_vertices, pairs, len(coords))
    loose = np.setdiff1d(np.arange(len(pairs)), source)
    order = np.concatenate([source, loose])
    letters, angles = letters[order], angles[order]
    within = _faces_around(file, coords, pairs[loose], number[loose], corners, offsets)
    edges_faces = np.concatenate([edges.edges_faces, np.column_stack([within, within])])
    _refuse_open(file, coords, pairs[loose], letters[len(source) :], number[loose])
    _note_loose(number[loose], findings)
    letters = _with_borders(letters, edges_faces, number[order], findings)
    angles[~np.isin(letters, ["M", "V", "U"])] = 0.0
    edges_vertices = np.concatenate([edges.edges_vertices, pairs[loose]])
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


def _listed(numbers: IntArray) -> str:
    more = f" and {len(numbers) - 5} more" if len(numbers) > 5 else ""
    return f"{'edges' if len(numbers) > 1 else 'edge'} {', '.join(map(str, numbers[:5]))}{more}"


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
        raise InvalidFile(f"{path}: {len(found)} edges_assignment for {count} edges.")
    given = np.array([str(letter) for letter in found])
    upper = np.char.upper(given)
    unknown = ~np.isin(upper, list(_LETTERS))
    odd = np.flatnonzero(unknown | (given != upper))
    if len(odd):
        severity = Severity.WARNING if unknown.any() else Severity.NOTE
        text = (
            f"{_listed(odd)}: the assignment {found[odd[0]]!r} is none of {', '.join(_LETTERS)}; "
            "lower case is taken for upper case, anything else for U (unassigned, not cut)."
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
            f"{path}: {len(found)} entries of edges_foldAngle for {len(letters)} edges."
        )
    for number, angle in enumerate(found):
        if angle is not None and not (type(angle) in (int, float) and -180 <= angle <= 180):
            raise InvalidFile(
                f"{path}: fold angle {angle} of edge {number} must lie from -180 to 180 degrees."
            )
    angles = np.array([np.nan if angle is None else angle for angle in found], float)
    missing = np.flatnonzero(np.isnan(angles) & folds)
    if len(missing):
        text = f"{_listed(missing)} without fold angle: folded by 180 degrees."
        findings.append(_finding("fold-angle-missing", Severity.NOTE, text, missing))
    angles = np.where(np.isnan(angles), default, angles)
    wrong = np.flatnonzero((angles * default < 0) | ((letters == "F") & (angles != 0)))
    if len(wrong):
        text = (
            f"{_listed(wrong)}: the sign of the fold angle ({angles[wrong[0]]:g}) contradicts the "
            f"assignment {letters[wrong[0]]}; the assignment holds."
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
        text = f"{_listed(which)} without length: removed, its ends merged."
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
        text = f"{_listed(which)}: a second edge between the same vertices; removed."
        findings.append(_finding("duplicate-edge", Severity.WARNING, text, which))
    return kept, pairs, merged


def _refuse_crossings(
    path: Path,
    coords: FloatArray,
    pairs: IntArray,
    letters: Letters,
    number: IntArray,
    tolerance: float,
) -> None:
    found = first_crossing(coords, pairs, tolerance, np.isin(letters, ["B", "C"]))
    if found is not None:
        one, two, (x, y) = found
        raise InvalidFile(
            f"{path}: edges {number[one]} and {number[two]} meet at ({x:.6g}, {y:.6g}) mm without "
            "a common vertex there. Split both at that point, or remove one."
        )


def _refuse_open(
    path: Path, coords: FloatArray, pairs: IntArray, letters: Letters, number: IntArray
) -> None:
    borders = np.flatnonzero(letters == "B")
    if len(borders):
        x, y = coords[pairs[borders[0], 1]]
        raise InvalidFile(
            f"{path}: the outline is open at edge {number[borders[0]]}, near ({x:.6g}, {y:.6g}) mm."
            " Close it, or make the edge a cut (C)."
        )


def _given_faces(
    path: Path, faces: Any, coords: FloatArray, merged: IntArray, findings: list[Finding]
) -> tuple[IntArray, IntArray]:
    corners, offsets = frame_faces(path, faces, len(coords))
    corners = merged[corners]
    own = np.repeat(np.arange(len(offsets) - 1), np.diff(offsets))
    stays = corners != corners[next_corner(offsets)]
    corners, own = corners[stays], own[stays]
    sizes = np.bincount(own, minlength=len(offsets) - 1)
    areas = np.zeros(len(sizes))
    full = sizes >= 3
    corners, own = corners[full[own]], own[full[own]]
    areas[full] = ring_areas(coords[corners], np.concatenate([[0], np.cumsum(sizes[full])]))
    least = _SAME * np.ptp(coords, axis=0).max() ** 2
    empty = np.flatnonzero(np.abs(areas) <= least)
    if len(empty):
        text = f"face {', '.join(map(str, empty[:5]))} without area: removed."
        findings.append(
            Finding(
                "face-without-area", Severity.WARNING, text, panels=tuple(empty[:_NAMED].tolist())
            )
        )
    turned = np.flatnonzero(areas < -least)
    if len(turned):
        text = (
            f"{len(turned)} of {len(areas)} faces are clockwise, the first is {turned[0]}: turned."
        )
        findings.append(
            Finding("face-clockwise", Severity.NOTE, text, panels=tuple(turned[:_NAMED].tolist()))
        )
    place = np.arange(len(corners))
    clockwise = areas[own] < 0
    order = np.lexsort((np.where(clockwise, -place, place), own))
    solid = np.abs(areas) > least
    corners = corners[order][solid[own]]
    return corners, np.concatenate([[0], np.cumsum(sizes[solid])])


def _rebuilt_faces(
    coords: FloatArray, pairs: IntArray, letters: Letters, findings: list[Finding]
) -> tuple[IntArray, IntArray]:
    """Bounded faces of the edges, less the holes: those with borders alone around them, beyond
    which there are faces everywhere.
    """
    corners, offsets = enclosed_faces(coords, pairs)
    count = len(offsets) - 1
    text = f"faces_vertices is missing: {count} faces were found between the edges."
    findings.append(_finding("faces-rebuilt", Severity.NOTE, text))
    if not count:
        return corners, offsets
    following = corners[next_corner(offsets)]
    forth = corners * len(coords) + following
    back = following * len(coords) + corners
    keys = np.sort(pairs[letters == "B"] @ [[len(coords), 1], [1, len(coords)]], axis=None)
    border = np.isin(forth, keys)
    inside = np.isin(back, forth)
    hole = np.logical_and.reduceat(border & inside, offsets[:-1])
    if hole.any():
        text = f"{int(hole.sum())} faces with borders on all sides, amid others, are holes."
        findings.append(_finding("hole", Severity.NOTE, text))
    sizes = np.diff(offsets)
    return corners[np.repeat(~hole, sizes)], np.concatenate([[0], np.cumsum(sizes[~hole])])


def _places(path: Path, sides: IntArray, pairs: IntArray, count: int) -> IntArray:
    """Which of `pairs` each side of the faces is."""
    keys = pairs.min(axis=1) * count + pairs.max(axis=1)
    order = np.argsort(keys)
    wanted = sides.min(axis=1) * count + sides.max(axis=1)
    place: IntArray = order[np.minimum(np.searchsorted(keys[order], wanted), len(keys) - 1)]
    lacking = np.flatnonzero(keys[place] != wanted)
    if len(lacking):
        one, two = sides[lacking[0]]
        raise InvalidFile(f"{path}: edges_vertices lacks the side ({one}, {two}) of a face.")
    return place


def _faces_around(
    path: Path,
    coords: FloatArray,
    pairs: IntArray,
    number: IntArray,
    corners: IntArray,
    offsets: IntArray,
) -> IntArray:
    """The face that each edge, no side of any, lies in."""
    out = _around(coords[pairs].mean(axis=1), coords, corners, offsets)
    outside = np.flatnonzero(out < 0)
    if len(outside):
        raise InvalidFile(
            f"{path}: edge {number[outside[0]]} lies outside of all faces. Remove it, or close "
            "the outline around it."
        )
    return out


def _around(
    points: FloatArray, coords: FloatArray, corners: IntArray, offsets: IntArray
) -> IntArray:
    """The face that each point lies inside of, -1 for none, shape (n,)."""
    import shapely

    out = np.full(len(points), -1)
    if len(points):
        sizes = np.diff(offsets)
        owner = np.repeat(np.arange(len(sizes)), sizes)
        rings = shapely.linearrings(coords[corners], indices=owner)
        tree = shapely.STRtree(shapely.polygons(rings))
        point, face = tree.query(shapely.points(points), "within")
        out[point] = face
    return out


def _refuse_islands(
    path: Path,
    coords: FloatArray,
    pairs: IntArray,
    number: IntArray,
    corners: IntArray,
    offsets: IntArray,
) -> None:
    """Faces have no holes: what lies within one must hang together with its sides."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    graph = coo_array((np.ones(len(pairs)), pairs.T), shape=(len(coords), len(coords)))
    _, label = connected_components(graph, directed=False)
    parts, first = np.unique(label[pairs[:, 0]], return_index=True)
    if len(parts) == 1 or len(offsets) == 1:
        return
    within = _around(coords[pairs[first, 0]], coords, corners, offsets)
    if (within >= 0).any():
        edge = number[first[np.argmax(within >= 0)]]
        x, y = coords[pairs[first[np.argmax(within >= 0)], 0]]
        raise InvalidFile(
            f"{path}: the lines around edge {edge}, near ({x:.6g}, {y:.6g}) mm, are an island in a "
            "face. Join them to its sides by an edge of assignment J."
        )


def _note_loose(number: IntArray, findings: list[Finding]) -> None:
    if len(number):
        text = f"{_listed(np.sort(number))} ends within a face: it can be cut, but not folded flat."
        findings.append(_finding("crease-dangling", Severity.WARNING, text, np.sort(number)))


def _with_borders(
    letters: Letters, edges_faces: IntArray, number: IntArray, findings: list[Finding]
) -> Letters:
    """B on all edges with one face, and on no others."""
    alone = edges_faces[:, 1] < 0
    unmarked = np.sort(number[alone & (letters != "B")])
    if len(unmarked):
        text = f"{_listed(unmarked)} with a face on one side alone: taken for border (B)."
        findings.append(_finding("border-unmarked", Severity.WARNING, text, unmarked))
    inside = np.sort(number[~alone & (letters == "B")])
    if len(inside):
        text = f"{_listed(inside)}: a border with faces on both sides is taken for a cut (C)."
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
