"""Triangles as files have them: vertices merged, faces without an area and repeated ones left out.

A soup is a pair of arrays: vertex coordinates (nv, 3) and the corners of the triangles (nf, 3).
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from scipy.spatial import cKDTree

from fab.errors import Finding, InvalidFile, Severity, counted
from solver.graphs import labels
from solver.targets.triangles import least_heights, triangle_edges
from solver.vectors import LARGEST, SMALLEST, BoolArray, FloatArray, IntArray, norm

__all__ = ["Soup", "checked", "merged", "packed", "place_text", "with_area", "without_repeats"]

Soup: TypeAlias = tuple[FloatArray, IntArray]

# Vertices nearer than this are one, triangles of less height have no area, in sizes of the mesh.
_SAME = 1e-6
_FLAT = 1e-7
# Neighbours are split in turn where flat triangles lie side by side; what is left is dropped.
_MOST_ROUNDS = 50
_NO_AREA = "none of its triangles has an area. Export it again."


def place_text(point: FloatArray, digits: int = 6) -> str:
    """A point in space as findings name it.

    >>> place_text(np.array([1.0, 0.25, -3e-7]))
    '(1, 0.25, -3e-07)'
    """
    return f"({', '.join(f'{x:.{digits}g}' for x in point.tolist())})"


def packed(soup: Soup) -> Soup:
    """Without the vertices that no face uses; the others keep their order."""
    used, number = np.unique(soup[1], return_inverse=True)
    return soup[0][used], number.reshape(-1, 3)


def checked(soup: Soup) -> Soup:
    """The used vertices as float64 about zero where they can be, and faces that name them.

    Raises `InvalidFile`, without the file's name, for what is empty, damaged or not finite.
    """
    coords, faces = np.asarray(soup[0], np.float64), np.asarray(soup[1], np.int64)
    if not len(faces):
        raise InvalidFile("it holds no triangles. Export the mesh with its faces.")
    if faces.min() < 0 or faces.max() >= len(coords):
        number = int(faces.min() if faces.min() < 0 else faces.max())
        have = counted(len(coords), "vertex", "vertices")
        raise InvalidFile(f"a face names vertex {number}; there are {have}. Export it again.")
    coords, faces = packed((coords, faces))
    lost = ~(np.abs(coords) <= LARGEST).all(axis=1)
    if lost.any():
        which = coords[int(np.flatnonzero(lost)[0])]
        bad = counted(int(lost.sum()), "vertex is", "vertices are")
        bound = f"finite and within {LARGEST:g}"
        raise InvalidFile(f"{bad} not {bound}, such as {place_text(which)}. Export it again.")
    if not _size(coords) >= SMALLEST:
        raise InvalidFile("all of its vertices are in one place. Export it again.")
    return coords, faces


def _size(coords: FloatArray) -> float:
    return float(norm(np.ptp(coords, axis=0)))


def merged(soup: Soup) -> tuple[Soup, list[Finding]]:
    """Vertices within 1e-6 of the size made one; faces that then name a vertex twice are dropped.

    Vertices at the very same place are merged without a word: STL files have nothing else. Raises
    `InvalidFile` where no face is left.
    """
    coords, faces = soup
    _, first, number = np.unique(coords, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first, kind="stable")  # vertices keep their order
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    coords, faces = coords[first[order]], rank[number.ravel()][faces]
    findings = []
    bound = _SAME * _size(coords)
    pairs = cKDTree(coords).query_pairs(bound, output_type="ndarray")
    if len(pairs):
        group = labels(pairs, len(coords))
        _, kept = np.unique(group, return_index=True)
        gaps = norm(coords[pairs[:, 0]] - coords[pairs[:, 1]])
        widest = int(gaps.argmax())
        less = len(coords) - len(kept)
        where = place_text(coords[pairs[widest, 0]])
        text = (
            f"{counted(less, 'vertex', 'vertices')} merged with others up to {gaps[widest]:.3g} "
            f"away, the farthest at {where}: vertices within {bound:.3g} are one."
        )
        findings.append(Finding("mesh-vertices-merged", Severity.NOTE, text))
        coords, faces = coords[kept], group[faces]
    faces = faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)]
    if not len(faces):
        raise InvalidFile(_NO_AREA)
    return packed((coords, faces)), findings


def without_repeats(soup: Soup) -> tuple[Soup, list[Finding]]:
    """Each triangle once, whichever way it is wound."""
    coords, faces = soup
    _, first = np.unique(np.sort(faces, axis=1), axis=0, return_index=True)
    again = len(faces) - len(first)
    if not again:
        return soup, []
    kept = np.zeros(len(faces), bool)
    kept[first] = True
    where = place_text(coords[faces[~kept][0]].mean(axis=0))
    were = counted(again, "triangle was", "triangles were")
    text = f"{were} there twice, the first at {where}: one of each is kept."
    return (coords, faces[kept]), [Finding("mesh-faces-repeated", Severity.NOTE, text)]


def with_area(soup: Soup) -> tuple[Soup, list[Finding]]:
    """Triangles flatter than 1e-7 of the size left out, so that no gap is left.

    The middle corner of a flat triangle is on its longest edge: the triangles beyond that edge are
    split there. Raises `InvalidFile` where nothing is left.
    """
    coords, faces = soup
    bound = _FLAT * _size(coords)
    count, where = 0, ""
    for _ in range(_MOST_ROUNDS):
        flat = _flat(coords, faces, bound)
        if not flat.any():
            break
        if not count:
            where = place_text(coords[faces[flat][0]].mean(axis=0))
        before = int(flat.sum())
        faces = _split_at_flat(coords, faces, np.flatnonzero(flat))
        count += max(before - int(_flat(coords, faces, bound).sum()), 0)
    flat = _flat(coords, faces, bound)
    count += int(flat.sum())
    faces = faces[~flat]
    if not len(faces):
        raise InvalidFile(_NO_AREA)
    if not count:
        return soup, []
    text = (
        f"{counted(count, 'triangle', 'triangles')} less than {bound:.3g} high left out, "
        f"the first at {where}; neighbours are split where they had a corner."
    )
    return packed((coords, faces)), [Finding("mesh-faces-without-area", Severity.NOTE, text)]


def _flat(coords: FloatArray, faces: IntArray, bound: float) -> BoolArray:
    out: BoolArray = ~(least_heights(coords, faces) > bound)
    return out


def _split_at_flat(coords: FloatArray, faces: IntArray, flat: IntArray) -> IntArray:
    """Faces without some of the flat ones, neighbours beyond their longest edges split."""
    _, edges = triangle_edges(faces, len(coords))
    p = coords[faces[flat]]
    longest = norm(np.roll(p, -1, axis=1) - p).argmax(axis=1)
    edge = edges[flat, longest]
    _, one = np.unique(edge, return_index=True)  # one flat triangle at an edge at a time
    flat, longest, edge = flat[one], longest[one], edge[one]
    middle = faces[flat, (longest + 2) % 3]
    # all faces at these edges but the flat ones themselves
    place = np.searchsorted(edge, edges.ravel()).clip(max=len(edge) - 1)
    half = np.flatnonzero(edge[place] == edges.ravel())
    owner = place[half]
    others = half // 3 != flat[owner]
    half, owner = half[others], owner[others]
    # a face is split once at a time, and one that goes is not split
    free = ~np.isin(half // 3, flat)
    _, once = np.unique(np.where(free, half // 3, -1 - np.arange(len(half))), return_index=True)
    single = np.zeros(len(half), bool)
    single[once] = True
    held = np.zeros(len(flat), bool)
    held[owner[~(free & single)]] = True
    if held.all():
        held[:] = False  # they lie on one another: they go, and their neighbours stay
        half, owner = half[:0], owner[:0]
    ready = ~held[owner]
    half, owner = half[ready], owner[ready]
    face, corner = half // 3, half % 3
    first, second = faces[face].copy(), faces[face].copy()
    rows = np.arange(len(face))
    first[rows, (corner + 1) % 3] = middle[owner]
    second[rows, corner] = middle[owner]
    kept = np.ones(len(faces), bool)
    kept[flat[~held]] = False
    kept[face] = False
    return np.concatenate([faces[kept], first, second])
