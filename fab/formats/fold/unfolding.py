"""The flat sheet of a folded form, face after face across common edges."""

from __future__ import annotations

from collections import deque
from pathlib import Path

import numpy as np

from fab.errors import InvalidFile
from fab.formats.drawn.lines import listed
from solver.graphs import labels
from solver.polygons import next_corner
from solver.vectors import BoolArray, FloatArray, IntArray, cross, dot, norm

__all__ = ["unfolded"]

# Of the size: a face may be so far from flat, and corners that are one vertex so far apart.
_FLAT_REL, _CLOSED_REL = 1e-6, 1e-5
# Angles around a vertex that add up to 360 degrees but for this are flat.
_FLAT_RAD = 1e-4
# Between parts that hang together nowhere, of their size.
_GAP_REL = 0.1


def unfolded(
    path: Path, coords: FloatArray, corners: IntArray, offsets: IntArray, cuts: IntArray
) -> FloatArray:
    """Points of the unfolded sheet, shape (nv, 2), seen from the side of the first face's normal.

    coords : of the folded form, shape (nv, 3); corners, offsets : its faces. cuts : pairs of
    vertices between which faces are cut apart, shape (n, 2).

    Raises `InvalidFile` with the vertices that are not flat, the faces that are not, or edges with
    more than two faces.
    """
    count, total = len(offsets) - 1, len(corners)
    size = float(norm(np.ptp(coords, axis=0)))
    local = _in_face_planes(path, coords, corners, offsets, size)
    follow = next_corner(offsets)
    keys = np.minimum(corners, corners[follow]) * len(coords) + np.maximum(corners, corners[follow])
    barred = np.sort(cuts, axis=1) @ [len(coords), 1] if len(cuts) else np.empty(0, np.int64)
    order = np.argsort(keys, kind="stable")
    same = np.flatnonzero(keys[order][1:] == keys[order][:-1])
    if len(same) > 1 and (np.diff(same) == 1).any():
        k = order[same[np.flatnonzero(np.diff(same) == 1)[0]]]
        raise InvalidFile(
            f"{path}: the edge ({corners[k]}, {corners[follow[k]]}) has more than two faces. A "
            "sheet has two at most."
        )
    first, second = order[same], order[same + 1]
    hinge = ~np.isin(keys[first], barred)
    first, second = first[hinge], second[hinge]
    spans = coords[corners[first]] - coords[corners[follow[first]]]
    if not (norm(spans) > _CLOSED_REL * size).all():
        k = first[np.argmin(norm(spans))]
        raise InvalidFile(
            f"{path}: the edge ({corners[k]}, {corners[follow[k]]}) between two faces has no "
            "length in the folded form. Merge both vertices."
        )
    face = np.repeat(np.arange(count), np.diff(offsets))
    placed = _placed(local, corners, offsets, follow, face, first, second)
    placed = _side_by_side(placed, face, labels(face[np.column_stack([first, second])], count))
    out = np.zeros((len(coords), 2))
    out[corners[::-1]] = placed[::-1]
    apart = norm(np.column_stack([placed - out[corners], np.zeros(total)]))
    if apart.max() > _CLOSED_REL * size:
        _refuse(path, coords, corners, offsets, int(corners[apart.argmax()]))
    return out


def _in_face_planes(
    path: Path, coords: FloatArray, corners: IntArray, offsets: IntArray, size: float
) -> FloatArray:
    """Corners of each face in a right-handed frame of its plane, shape (total, 2)."""
    sizes = np.diff(offsets)
    arm = coords[corners] - np.repeat(coords[corners[offsets[:-1]]], sizes, axis=0)
    follow = next_corner(offsets)
    normal = np.add.reduceat(cross(arm, arm[follow]), offsets[:-1])
    length = norm(normal)
    bare = np.flatnonzero(length <= 1e-14 * size**2)
    if len(bare):
        raise InvalidFile(f"{path}: {listed('face', bare)} without area. Remove it.")
    normal /= length[:, None]
    side = arm[follow] - arm
    longest = np.lexsort((norm(side), np.repeat(np.arange(len(sizes)), sizes)))[offsets[1:] - 1]
    u = side[longest] / norm(side[longest])[:, None]
    u -= dot(u, normal)[:, None] * normal
    u /= norm(u)[:, None]
    v = cross(normal, u)
    off = np.maximum.reduceat(np.abs(dot(arm, np.repeat(normal, sizes, axis=0))), offsets[:-1])
    bent = np.flatnonzero(off > _FLAT_REL * size)
    if len(bent):
        raise InvalidFile(
            f"{path}: {listed('face', bent)} of the folded form not flat, the first by "
            f"{off[bent[0]]:.3g}: it cannot be unfolded. Triangulate it, or give the flat sheet."
        )
    u, v = np.repeat(u, sizes, axis=0), np.repeat(v, sizes, axis=0)
    return np.column_stack([dot(arm, u), dot(arm, v)])


def _placed(
    local: FloatArray,
    corners: IntArray,
    offsets: IntArray,
    follow: IntArray,
    face: IntArray,
    first: IntArray,
    second: IntArray,
) -> FloatArray:
    """Corners of all faces in one plane: each beside the face that it is reached from."""
    neighbours: list[list[tuple[int, int]]] = [[] for _ in range(len(offsets) - 1)]
    for own, other in zip(
        np.concatenate([first, second]).tolist(),
        np.concatenate([second, first]).tolist(),
        strict=True,
    ):
        neighbours[face[own]].append((own, other))
    z = local[:, 0] + 1j * local[:, 1]
    out = np.zeros(len(z), complex)
    side = np.zeros(len(offsets) - 1, np.int64)  # -1 for faces that are turned over
    for root in range(len(side)):
        if side[root]:
            continue
        side[root] = 1
        out[offsets[root] : offsets[root + 1]] = z[offsets[root] : offsets[root + 1]]
        waiting = deque([root])
        while waiting:
            at = waiting.popleft()
            for own, other in neighbours[at]:
                new = int(face[other])
                if side[new]:
                    continue
                forth = corners[own] == corners[other]  # both faces run along the edge alike
                side[new] = -side[at] if forth else side[at]
                mine = slice(offsets[new], offsets[new + 1])
                shape = z[mine] if side[new] > 0 else z[mine].conj()
                low = offsets[new]
                a, b = shape[other - low], shape[follow[other] - low]
                p, q = out[own], out[follow[own]]
                p, q = (p, q) if forth else (q, p)
                turn = (q - p) / (b - a)
                turn /= abs(turn)
                out[mine] = (p + q) / 2 + turn * (shape - (a + b) / 2)
                waiting.append(new)
    return np.column_stack([out.real, out.imag])


def _side_by_side(placed: FloatArray, face: IntArray, part: IntArray) -> FloatArray:
    """Parts that hang together nowhere, one right of the other."""
    own = part[face]
    if not own.any():
        return placed
    out = placed.copy()
    at = 0.0
    gap = _GAP_REL * float(np.ptp(placed, axis=0).max())
    for number in range(int(part.max()) + 1):
        rows = own == number
        low, high = placed[rows].min(axis=0), placed[rows].max(axis=0)
        out[rows] += [at - low[0], -low[1]]
        at += high[0] - low[0] + gap
    return out


def _refuse(
    path: Path, coords: FloatArray, corners: IntArray, offsets: IntArray, vertex: int
) -> None:
    """Raise `InvalidFile` with the vertices whose angles do not add up, or where it closes."""
    follow = next_corner(offsets)
    before = np.empty_like(follow)
    before[follow] = np.arange(len(follow))
    to, back = coords[corners[follow]] - coords[corners], coords[corners[before]] - coords[corners]
    angle = np.arctan2(norm(cross(to, back)), dot(to, back))
    total = np.bincount(corners, angle, minlength=len(coords))
    around = _interior(corners, corners[follow], len(coords))
    bad = np.flatnonzero(around & (np.abs(total - 2 * np.pi) > _FLAT_RAD))
    if len(bad):
        raise InvalidFile(
            f"{path}: it does not unfold into a flat sheet: "
            f"{listed('vertex', bad, 'vertices')} not flat, the angles around the first add up to "
            f"{np.degrees(total[bad[0]]):.4g} degrees. Cut it "
            "open there, or give the flat sheet."
        )
    raise InvalidFile(
        f"{path}: it does not unfold into a flat sheet without a cut: it closes on itself at "
        f"vertex {vertex}. Cut it open (edges of assignment C, or separate vertices)."
    )


def _interior(start: IntArray, end: IntArray, count: int) -> BoolArray:
    """Vertices all edges of which have two faces."""
    keys = np.minimum(start, end) * count + np.maximum(start, end)
    pairs, times = np.unique(keys, return_counts=True)
    out = np.zeros(count, bool)
    out[start] = True
    rim = pairs[times == 1]
    out[rim // count] = False
    out[rim % count] = False
    return out
