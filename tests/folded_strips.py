"""Strips, vertices and twists that fold flat, and all orders of layers by brute force."""

from __future__ import annotations

from itertools import combinations, pairwise, permutations

import numpy as np
from flat_patterns import pattern_of

from fab.pattern.crease_pattern import CreasePattern


def strip(lengths, letters) -> CreasePattern:
    """Faces in a row, of some lengths, with creases of some letters between them."""
    x = np.concatenate([[0.0], np.cumsum(lengths)])
    count = len(x)
    coords = [[each, y] for y in (0.0, 5.0) for each in x]
    faces = [[i, i + 1, count + i + 1, count + i] for i in range(count - 1)]
    return lettered(coords, faces, letters)


def folded_strip(lengths, angles, width=20.0) -> CreasePattern:
    """Panels in a row, mm, with the fold angles between them, degrees."""
    along = np.concatenate([[0.0], np.cumsum(lengths)])
    count = len(along)
    coords = np.vstack([np.column_stack([along, np.full(count, y)]) for y in (0.0, width)])
    faces = [[i, i + 1, count + i + 1, count + i] for i in range(count - 1)]
    plain = pattern_of(coords, faces, "V")
    across = np.abs(np.diff(plain.edges_vertices, axis=1))[:, 0] == count
    inner = across & (plain.edges_assignment != "B")
    angle = np.zeros(len(inner))
    angle[inner] = np.asarray(angles, float)[plain.edges_vertices[inner].min(axis=1) - 1]
    letters = np.where(inner, np.where(angle > 0, "V", "M"), plain.edges_assignment)
    return pattern_like(plain, letters, angle)


def pattern_like(plain, letters, angle) -> CreasePattern:
    return CreasePattern(
        plain.vertices_coords,
        plain.edges_vertices,
        plain.edges_faces,
        letters.astype("U1"),
        angle,
        plain.faces_vertices,
        plain.faces_offsets,
    )


def vertex(angles_deg, letters) -> CreasePattern:
    """Triangles around one vertex; crease i is between the faces i - 1 and i."""
    turn = np.radians(np.concatenate([[0.0], np.cumsum(angles_deg)[:-1]]))
    rim = np.column_stack([np.cos(turn), np.sin(turn)])
    count = len(turn)
    faces = [[0, 1 + i, 1 + (i + 1) % count] for i in range(count)]
    return lettered(np.vstack([[0.0, 0.0], rim]), faces, letters)


def lettered(coords, faces, letters) -> CreasePattern:
    """Faces with letters of their creases, by the lower and then the higher vertex; folded flat."""
    plain = pattern_of(coords, faces)
    inner = np.flatnonzero(plain.edges_assignment != "B")
    ends = np.sort(plain.edges_vertices[inner], axis=1)
    every = np.full(len(plain.edges_vertices), "B")
    every[inner[np.lexsort(ends.T[::-1])]] = list(letters)
    return pattern_of(coords, faces, every, angle=180.0)


def twist(sides, angle_deg, turns) -> CreasePattern:
    """A regular polygon whose sides are pleats that leave it at an angle to the side.

    turns : of each pleat, 1 or -1: the letters that its vertices then want, where the angle is less
    than that of the polygon; or None for no letters at all.
    """
    at = 2 * np.pi * np.arange(sides) / sides
    corners = np.column_stack([np.cos(at), np.sin(at)]) / (2 * np.sin(np.pi / sides))
    along = np.roll(corners, -1, axis=0) - corners
    cos, sin = np.cos(np.radians(angle_deg)), np.sin(np.radians(angle_deg))
    out = 2.0 * along @ [[cos, -sin], [sin, cos]]
    coords = np.vstack([corners, corners + out, np.roll(corners, -1, axis=0) + out])
    faces = [list(range(sides))]
    wanted = {}
    for i in range(sides):
        j, a, b = (i + 1) % sides, sides + i, 2 * sides + i
        faces += [[i, a, b, j], [j, b, sides + j]]
        letter, other = "VM" if turns is not None and turns[i] > 0 else "MV"
        wanted |= {frozenset((i, j)): letter, frozenset((i, a)): other, frozenset((j, b)): letter}
    plain = pattern_of(coords, faces)
    letters = [
        wanted.get(frozenset(pair), "B") if turns is not None else "U"
        for pair in plain.edges_vertices.tolist()
    ]
    return pattern_of(coords, faces, letters, angle=180.0)


def brute_force_triangles(places, letters) -> int:
    """The number of orders of a strip of equal triangles that are folded onto one of them.

    places : which of its three sides each crease is; letters : of creases, or U.
    """
    count, found = len(places) + 1, 0
    creases = list(zip(range(count - 1), range(1, count), places, strict=True))
    for height in permutations(range(count)):
        right = all(
            letter == "U" or (height[b] > height[a]) == ((letter == "V") == (a % 2 == 0))
            for (a, b, _), letter in zip(creases, letters, strict=True)
        )
        found += right and not any(
            x == y and interleaved(sorted((height[a], height[b])), sorted((height[c], height[d])))
            for (a, b, x), (c, d, y) in combinations(creases, 2)
        )
    return found


def interleaved(one, other) -> bool:
    """Whether one interval has one end in another, and one outside."""
    return one[0] < other[0] < one[1] < other[1] or other[0] < one[0] < other[1] < one[1]


def triangle_strip(places, letters) -> CreasePattern:
    """Right triangles, each the mirror image of the last one in its side of that number."""
    coords = [(0.0, 0.0), (10.0, 0.0), (0.0, 10.0)]
    corner = [0, 1, 2]
    faces = [list(corner)]
    for side in places:
        a, b = (corner[(side + k) % 3] for k in (0, 1))
        start, along = np.array(coords[a]), np.subtract(coords[b], coords[a])
        arm = np.subtract(coords[corner[(side + 2) % 3]], start)
        image = start + 2 * along * (arm @ along) / (along @ along) - arm
        corner[(side + 2) % 3] = len(coords)
        coords.append(tuple(image))
        faces.append(list(corner) if len(faces) % 2 == 0 else corner[::-1])
    plain = pattern_of(coords, faces)
    every = np.full(len(plain.edges_vertices), "B")
    for number, edge in enumerate(plain.edges_faces.tolist()):
        if min(edge) >= 0:
            every[number] = letters[min(edge)]
    return pattern_of(coords, faces, every, angle=180.0)


def brute_force_orders(sizes, letters, closed: bool) -> set[frozenset[tuple[int, int]]]:
    """All orders of faces that are folded onto one line, by trying all permutations.

    Each is the set of pairs (lower, upper) of faces that overlap. sizes : of the faces, integers.
    letters : of creases; crease i is after face i, or before it where the strip is closed.
    """
    count = len(sizes)
    steps = [size * (1 if i % 2 == 0 else -1) for i, size in enumerate(sizes)]
    ends = np.concatenate([[0], np.cumsum(steps)]).tolist()
    spans = [(min(a, b), max(a, b)) for a, b in pairwise(ends)]
    creases = [(i, i + 1, ends[i + 1]) for i in range(count - 1)]
    if closed:
        assert ends[-1] == 0
        creases = [((i - 1) % count, i, ends[i]) for i in range(count)]
    over = [
        (i, j)
        for i, j in combinations(range(count), 2)
        if min(spans[i][1], spans[j][1]) > max(spans[i][0], spans[j][0])
    ]
    found = set()
    for order in permutations(range(count)):
        if fits(order, spans, creases, letters):
            found.add(frozenset((i, j) if order[i] < order[j] else (j, i) for i, j in over))
    return found


def fits(height, spans, creases, letters) -> bool:
    """Whether layers at some heights pass through no crease and have the letters of all."""
    for (a, b, _), letter in zip(creases, letters, strict=True):
        up = height[b] > height[a]
        if letter != "U" and up != ((letter == "V") == (a % 2 == 0)):
            return False
    for a, b, x in creases:
        low, high = sorted((height[a], height[b]))
        for face, span in enumerate(spans):
            if span[0] < x < span[1] and low < height[face] < high:
                return False
    for (a, b, x), (c, d, y) in combinations(creases, 2):
        same_side = (spans[a][0] == x) == (spans[c][0] == y)
        if x == y and same_side and len({a, b, c, d}) == 4:
            low, high = sorted((height[a], height[b]))
            if (low < height[c] < high) != (low < height[d] < high):
                return False
    return True


def chosen_order(rows, turned) -> frozenset[tuple[int, int]]:
    """Pairs (lower, upper) of rows of faceOrders; turned : whether each face looks down."""
    return frozenset(
        (g, f) if (side > 0) != turned[g] else (f, g) for f, g, side in np.asarray(rows).tolist()
    )
