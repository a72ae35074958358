"""Faces that a FOLD file lists, and those of them in which its other lines are.

They stay as they are, over each other or not: only faces that cannot be parts of one flat sheet
are refused.
"""

from __future__ import annotations

from typing import NoReturn

import numpy as np
import shapely

from fab.errors import Finding, InvalidFile, Severity, first_few
from fab.formats.drawn.lines import Faces, Lines, listed
from fab.geometry.planar_graph import first_abutting, first_crossing
from fab.geometry.rings import ring_areas
from fab.pattern.overlap import overlapping_faces
from solver.graphs import labels
from solver.mesh import Edges
from solver.polygons import next_corner
from solver.vectors import BoolArray, FloatArray, IntArray

__all__ = [
    "faces_around",
    "given_faces",
    "overlap_findings",
    "refuse_abutting",
    "sides_of_crossed",
]

_MARKED = ("B", "C")


def sides_of_crossed(
    coords: FloatArray, corners: IntArray, offsets: IntArray, pairs: IntArray
) -> BoolArray:
    """Which of the edges are sides of a face that crosses itself, shape (n,)."""
    crossed = np.repeat(_are_crossed(coords, corners, offsets), np.diff(offsets))
    sides = np.column_stack([corners, corners[next_corner(offsets)]])[crossed]
    out: BoolArray = np.isin(
        *(ends.min(axis=1) * len(coords) + ends.max(axis=1) for ends in (pairs, sides))
    )
    return out


def _are_crossed(coords: FloatArray, corners: IntArray, offsets: IntArray) -> BoolArray:
    own = np.repeat(np.arange(len(offsets) - 1), np.diff(offsets))
    rings = shapely.linearrings(coords[corners], indices=own)
    out: BoolArray = ~shapely.is_valid(shapely.polygons(rings))
    return out


def given_faces(
    lines: Lines,
    corners: IntArray,
    offsets: IntArray,
    merged: IntArray,
    rounding: float,
) -> tuple[Faces, Lines, list[Finding]]:
    """The faces that a file lists, all counterclockwise, the lines that are left, and findings.

    corners, offsets : of the faces as in the file. merged : for each vertex the one that it became.
    rounding : of the coordinates, mm. A face has no area where its corners are on a line but for
    rounding, however small the face is; it is removed with the edges of no other face.

    Raises `InvalidFile` for faces that cross themselves or that are listed twice, and for two on
    the same side of their common edge, as in a folded sheet.
    """
    findings = []
    count = len(offsets) - 1
    corners = merged[corners]
    own = np.repeat(np.arange(count), np.diff(offsets))
    following = corners[next_corner(offsets)]
    stays = corners != following
    sides = np.column_stack([corners, following])[stays]
    corners, own = corners[stays], own[stays]
    sizes = np.bincount(own, minlength=count)
    full = sizes >= 3
    has_area, areas = np.zeros(count, bool), np.zeros(count)
    if full.any():
        rings = lines.coords[corners[full[own]]]
        bounds = np.concatenate([[0], np.cumsum(sizes[full])])
        areas[full] = ring_areas(rings, bounds)
        has_area[full] = _heights(rings, bounds) > rounding
    empty = np.flatnonzero(~has_area)
    if len(empty):
        text = f"{listed('face', empty)} without area: removed."
        findings.append(_of_faces("face-without-area", Severity.WARNING, text, empty))
    turned = np.flatnonzero(has_area & (areas < 0))
    if len(turned):
        text = f"{len(turned)} of {count} faces are clockwise, the first is {turned[0]}: turned."
        findings.append(_of_faces("face-clockwise", Severity.NOTE, text, turned))
    place = np.arange(len(corners))
    order = np.lexsort((np.where(areas[own] < 0, -place, place), own))
    kept = has_area[own]
    faces = Faces(
        corners[order][kept],
        np.concatenate([[0], np.cumsum(sizes[has_area])]),
        np.flatnonzero(has_area),
    )
    keys = lines.keys(sides)
    gone = np.setdiff1d(keys[~kept], keys[kept])
    lines = lines.part(~np.isin(lines.keys(), gone))
    _refuse_broken(lines, faces)
    return faces, lines, findings


def _heights(rings: FloatArray, offsets: IntArray) -> FloatArray:
    """Distance from the longest side to the corner farthest from its line, of each face."""
    span = rings[next_corner(offsets)] - rings
    length = np.hypot(*span.T)
    own = np.repeat(np.arange(len(offsets) - 1), np.diff(offsets))
    longest = np.lexsort((length, own))[offsets[1:] - 1]
    along = (span[longest] / length[longest, None])[own]
    arm = rings - rings[longest][own]
    off = np.abs(along[:, 0] * arm[:, 1] - along[:, 1] * arm[:, 0])
    out: FloatArray = np.maximum.reduceat(off, offsets[:-1])
    return out


def _of_faces(code: str, severity: Severity, text: str, faces: IntArray) -> Finding:
    return Finding(code, severity, text, panels=first_few(faces))


def _refuse_broken(lines: Lines, faces: Faces) -> None:
    """Raise `InvalidFile` for faces that are no part of a flat sheet."""
    if not len(faces.number):
        return
    own = np.repeat(np.arange(len(faces.number)), np.diff(faces.offsets))
    crossed = np.flatnonzero(_are_crossed(lines.coords, faces.corners, faces.offsets))
    if len(crossed):
        raise InvalidFile(
            f"{lines.path}: {listed('face', faces.number[crossed])}: the sides cross or touch "
            "each other. Put its corners in order, split it, or write its coordinates with more "
            "digits."
        )
    following = faces.corners[next_corner(faces.offsets)]
    forth = faces.corners * len(lines.coords) + following
    order = np.argsort(forth, kind="stable")
    again = np.flatnonzero(forth[order][1:] == forth[order][:-1])
    if not len(again):
        return
    sides = order[again], order[again + 1]
    owners = own[sides[0]], own[sides[1]]
    first = int(np.lexsort(owners[::-1])[0])
    f, g = int(owners[0][first]), int(owners[1][first])
    names = f"faces {faces.number[f]} and {faces.number[g]}"
    if set(faces.ring(f).tolist()) == set(faces.ring(g).tolist()):
        raise InvalidFile(f"{lines.path}: {names} have the same corners. Remove one of them.")
    side = sides[0][first]
    raise InvalidFile(
        f"{lines.path}: {names} lie on the same side of their common edge "
        f"({faces.corners[side]}, {following[side]}), as in a folded sheet. Give the flat sheet, "
        "and no edge more than two faces."
    )


def _refuse_crossings(lines: Lines, near: float) -> None:
    found = first_crossing(lines.coords, lines.pairs, near, np.isin(lines.letters, _MARKED))
    if found is not None:
        first, second, (x, y) = found
        raise InvalidFile(
            f"{lines.path}: edges {lines.number[first]} and {lines.number[second]} meet at "
            f"({x:.6g}, {y:.6g}) mm without a common vertex there. Split both at that point, or "
            "remove one."
        )


def _within(
    points: FloatArray, coords: FloatArray, corners: IntArray, offsets: IntArray
) -> tuple[IntArray, IntArray]:
    """Points, and faces that they are inside of, a row for each such pair."""
    own = np.repeat(np.arange(len(offsets) - 1), np.diff(offsets))
    shapes = shapely.polygons(shapely.linearrings(coords[corners], indices=own))
    point, face = shapely.STRtree(shapes).query(shapely.points(points), "within")
    return point, face


def faces_around(lines: Lines, faces: Faces, edges_faces: IntArray, near: float) -> IntArray:
    """The face that each line but the first ones, which are sides of faces, is in.

    Lines that meet elsewhere than in a corner are in the same face. Where faces are over each other
    it is the one that has a corner in common with them.

    edges_faces : the faces beside the lines that are sides, shape (m, 2).

    Raises `InvalidFile` for lines that leave their face, end on a side of it or cross each other,
    and for those that may be in either of two faces.
    """
    count = len(edges_faces)
    loose = lines.part(np.arange(count, len(lines.pairs)))
    out = np.full(len(loose.pairs), -1)
    if not len(out):
        return out
    middles = lines.coords[loose.pairs].mean(axis=1)
    line, face = _within(middles, lines.coords, faces.corners, faces.offsets)
    order = np.argsort(line, kind="stable")
    around = np.split(face[order], np.searchsorted(line[order], np.arange(1, len(out))))
    plain = np.array([len(found) == 1 for found in around])
    out[plain] = [found[0] for found in around if len(found) == 1]
    for members in _by_value(_groups(loose.pairs, faces.corners, len(lines.coords))):
        unclear = members[~plain[members]]
        if not len(unclear):
            continue
        candidates = set.intersection(*(set(around[i].tolist()) for i in members.tolist()))
        if len(candidates) > 1:
            ends = loose.pairs[members]
            candidates = {f for f in candidates if np.isin(ends, faces.ring(f)).any()}
        if len(candidates) != 1:
            _refuse_place(loose.part(unclear), around[unclear[0]], faces)
        out[unclear] = candidates.pop()
    beside = np.concatenate([edges_faces.T.ravel(), out])
    edge = np.concatenate([np.arange(count), np.arange(count), np.arange(count, len(lines.pairs))])
    mixed = np.isin(beside, out)
    for members in _by_value(beside[mixed]):
        _refuse_crossings(lines.part(edge[mixed][members]), near)
    return out


def _by_value(values: IntArray) -> list[IntArray]:
    """Places of each value that occurs, rising."""
    order = np.argsort(values, kind="stable")
    return np.split(order, np.flatnonzero(np.diff(values[order])) + 1)


def _groups(pairs: IntArray, corners: IntArray, count: int) -> IntArray:
    """Number of the group of each line: those that meet elsewhere than in a corner are one."""
    fresh = count + np.arange(pairs.size).reshape(pairs.shape)
    nodes = np.where(np.isin(pairs, corners), fresh, pairs)
    return labels(nodes, count + pairs.size)[nodes[:, 0]]


def _refuse_place(lines: Lines, around: IntArray, faces: Faces) -> NoReturn:
    x, y = lines.coords[lines.pairs[0]].mean(axis=0)
    place = f"{lines.path}: edge {lines.number[0]}, near ({x:.6g}, {y:.6g}) mm,"
    if len(around) > 1:
        several = listed("face", faces.number[np.sort(around)])
        raise InvalidFile(
            f"{place} lies in {several}, which lie over each other. Let it begin in a corner of "
            "its own face alone."
        )
    raise InvalidFile(
        f"{place} lies inside of no face. Remove it, split it where it crosses others, or close "
        "the outline around it."
    )


def refuse_abutting(lines: Lines, near: float) -> None:
    """Raise `InvalidFile` where lines, each with a face on its left alone, run along each other.

    Lips of a cut may, where both are marked as borders or cuts.
    """
    found = first_abutting(lines.coords, lines.pairs, near, np.isin(lines.letters, _MARKED))
    if found is not None:
        first, second, (x, y) = found
        raise InvalidFile(
            f"{lines.path}: edges {lines.number[first]} and {lines.number[second]} lie on each "
            f"other at ({x:.6g}, {y:.6g}) mm, each with a face on one side alone. Let the faces "
            "on both sides have the same vertices there, or make both edges borders (B)."
        )


def overlap_findings(lines: Lines, faces: Faces, edges: Edges) -> list[Finding]:
    """What is reported of faces that are over each other."""
    pairs = overlapping_faces(lines.coords, faces.corners, faces.offsets, edges)
    if not len(pairs):
        return []
    which = np.unique(pairs)
    first, second = faces.number[pairs[0]]
    x, y = lines.coords[faces.ring(int(pairs[0, 0]))].mean(axis=0)
    text = (
        f"the sheet overlaps itself: {len(which)} of {len(faces.number)} faces lie over others, "
        f"the first are {first} and {second}, near ({x:.6g}, {y:.6g}) mm. They have to be cut as "
        "different pieces."
    )
    return [_of_faces("sheet-overlaps", Severity.NOTE, text, faces.number[which])]
