"""Flat crease patterns of all kinds for the tests: triangles, n-gons, pieces, holes, cuts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial import Delaunay

from fab.pattern.crease_pattern import CreasePattern
from solver.mesh import edges_of


def pattern_of(coords, faces, letter="M", cuts=(), angle=90.0) -> CreasePattern:
    """Faces as lists of corners; `letter` for all creases or for each; `cuts` as pairs."""
    corners = np.array([v for face in faces for v in face], np.int64)
    offsets = np.concatenate([[0], np.cumsum([len(face) for face in faces])]).astype(np.int64)
    edges = edges_of(corners, offsets)
    count = len(edges.edges_vertices)
    letters = np.broadcast_to(np.array(letter), count).astype("U1")
    letters[edges.edges_faces[:, 1] < 0] = "B"
    pairs = {tuple(sorted(pair)) for pair in cuts}
    for i, pair in enumerate(np.sort(edges.edges_vertices, axis=1).tolist()):
        if tuple(pair) in pairs:
            letters[i] = "C"
    sign = np.where(letters == "V", 1.0, np.where(letters == "M", -1.0, 0.0))
    return CreasePattern(
        np.asarray(coords, float),
        edges.edges_vertices,
        edges.edges_faces,
        letters,
        sign * np.broadcast_to(angle, count),
        corners,
        offsets,
    )


def fan(sides: int, radius: float, letter="M") -> CreasePattern:
    """Triangles around one vertex (the first), which has that many creases."""
    turn = np.arange(sides) * 2 * np.pi / sides
    rim = radius * np.column_stack([np.cos(turn), np.sin(turn)])
    faces = [[0, 1 + i, 1 + (i + 1) % sides] for i in range(sides)]
    return pattern_of(np.vstack([[0.0, 0.0], rim]), faces, letter)


def fan_of(sectors, letters):
    """A vertex with these sectors, and the edges of its creases in their order."""
    turns = np.concatenate([[0.0], np.cumsum(sectors)[:-1]])
    rim = 50 * np.column_stack([np.cos(turns), np.sin(turns)])
    count = len(sectors)
    base = pattern_of(
        np.vstack([[0.0, 0.0], rim]), [[0, 1 + i, 1 + (i + 1) % count] for i in range(count)]
    )
    ends = [set(pair) for pair in base.edges_vertices.tolist()]
    spokes = [ends.index({0, 1 + i}) for i in range(count)]
    assignment = base.edges_assignment.copy()
    assignment[spokes] = list(letters)
    return replace(base, edges_assignment=assignment), spokes


def grid(columns: int, rows: int, size: float, without=(), cuts=()) -> CreasePattern:
    """Squares, some left out by (column, row); vertices are numbered row after row."""
    across = columns + 1
    x, y = np.meshgrid(np.arange(across) * size, np.arange(rows + 1) * size)
    faces = [
        [r * across + c, r * across + c + 1, (r + 1) * across + c + 1, (r + 1) * across + c]
        for r in range(rows)
        for c in range(columns)
        if (c, r) not in set(without)
    ]
    return pattern_of(np.column_stack([x.ravel(), y.ravel()]), faces, "V", cuts)


def triangles(seed: int, count: int = 30, size: float = 200.0) -> CreasePattern:
    """Delaunay triangles of random points, without needles, random letters and fold angles."""
    random = np.random.default_rng(seed)
    coords = random.uniform(0, size, (count, 2))
    faces = Delaunay(coords).simplices
    arm = coords[faces[:, 1:]] - coords[faces[:, :1]]
    area = arm[:, 0, 0] * arm[:, 1, 1] - arm[:, 0, 1] * arm[:, 1, 0]
    faces = np.where(area[:, None] > 0, faces, faces[:, ::-1])
    sides = coords[faces] - coords[np.roll(faces, 1, axis=1)]
    height = np.abs(area) / np.hypot(sides[..., 0], sides[..., 1]).max(axis=1)
    faces = faces[height > size / 50].tolist()
    edges = len(pattern_of(coords, faces).edges_vertices)
    letters = random.choice(["M", "V", "F", "U", "C"], edges, p=[0.4, 0.4, 0.08, 0.08, 0.04])
    return pattern_of(coords, faces, letters, angle=random.uniform(0, 180, edges))


def turned_strip(quads: int, turns: float, rows: int = 1, seed: int | None = None) -> CreasePattern:
    """Rows of quads around a centre, counterclockwise, the first again over itself after one turn.

    seed : of the distances from the centre; without it every row is 40 wide, the first 60 away.
    """
    angle = turns * 2 * np.pi * np.arange(quads + 1) / quads
    distance = 60.0 + 40.0 * np.arange(rows + 1)[:, None] + np.zeros(quads + 1)
    if seed is not None:
        distance += np.random.default_rng(seed).uniform(-15, 15, distance.shape)
    coords = np.stack([distance * np.cos(angle), distance * np.sin(angle)], axis=-1).reshape(-1, 2)
    across = quads + 1
    faces = [
        [r * across + c, (r + 1) * across + c, (r + 1) * across + c + 1, r * across + c + 1]
        for r in range(rows)
        for c in range(quads)
    ]
    return pattern_of(coords, faces, "V")


def stars(count: int, seed: int, size: float = 60.0) -> list[np.ndarray]:
    """Outlines of concave pieces of four to eleven corners, seen whole from their middle."""
    rng = np.random.default_rng(seed)
    out = []
    for _ in range(count):
        corners = rng.integers(4, 12)
        angle = (np.arange(corners) + rng.uniform(0, 0.8, corners)) * 2 * np.pi / corners
        radius = size / 2 * rng.uniform(0.4, 1, corners)
        out.append(radius[:, None] * np.column_stack([np.cos(angle), np.sin(angle)]))
    return out


def strips(gap, *rows) -> CreasePattern:
    """A Miura sheet 6 quads wide in sheets of some rows each, `gap` apart, 20 mm a unit."""
    from fab.jobs.grow import unfolded
    from fab.jobs.job import SheetSize
    from solver import Miura, QuadMesh
    from solver.relaxed_fit import joined

    whole = Miura(columns=6, rows=sum(rows)).grow().mesh
    parts, start = [], 0
    for number, count in enumerate(rows):
        grid = whole.grid[start : start + count + 1]
        parts.append(QuadMesh.from_rows(whole.vertices_coords[grid] + [0, 0, number * gap]))
        start += count
    return unfolded(joined(parts), SheetSize(scale_mm_per_unit=20.0))[1]
