"""Partition of sheets: sets complete, connected, within the room; balanced; bad faces refused."""

from collections import Counter

import numpy as np
import pytest
import shapely
from flat_patterns import pattern_of, triangles, turned_strip
from hypothesis import given, settings
from hypothesis import strategies as st

from fab.layout import partition as search
from fab.layout.face_sets import FaceSets, SheetToDivide, extent, outline, upright
from fab.layout.partition import partition
from fab.pattern.crease_pattern import CreasePattern
from solver.errors import InvalidValue


def grid(columns: int, rows: int, size: float, holes=()) -> CreasePattern:
    """Squares cut into two triangles each, without those at `holes`."""
    x, y = np.meshgrid(size * np.arange(columns + 1), size * np.arange(rows + 1))
    faces = []
    for row in range(rows):
        for column in range(columns):
            a = row * (columns + 1) + column
            b, c, d = a + 1, a + columns + 2, a + columns + 1
            if (column, row) not in holes:
                faces += [[a, b, c], [a, c, d]]
    return pattern_of(np.column_stack([x.ravel(), y.ravel()]), faces)


def strip(count: int, size: float) -> CreasePattern:
    """Squares in a row."""
    coords = [[size * x, size * y] for y in range(2) for x in range(count + 1)]
    faces = [[x, x + 1, count + x + 2, count + x + 1] for x in range(count)]
    return pattern_of(coords, faces)


def sheet_of(pattern: CreasePattern, room_mm: tuple[float, float]) -> SheetToDivide:
    """A sheet whose pieces get no tabs."""
    ends = pattern.vertices_coords[pattern.edges_vertices]
    inner = pattern.edges_faces[:, 1] >= 0
    reach = np.stack([ends, ends], axis=1)
    return SheetToDivide(pattern, inner, reach, ~inner & False, room_mm)


@given(st.integers(0, 10**6), st.floats(90, 200), st.floats(90, 200))
@settings(max_examples=15, deadline=None)
def test_sets_are_complete_connected_and_within_the_room(seed, width, height):
    pattern = triangles(seed, size=200.0)
    sides = np.diff(pattern.vertices_coords[pattern.edges_vertices], axis=1)[:, 0]
    room = (max(width, float(np.hypot(*sides.T).max())), height)
    sheet = sheet_of(pattern, room)
    faces = FaceSets(sheet)
    try:
        sets = partition(sheet)
    except InvalidValue:  # a large triangle
        assert not all(faces.fits(np.array([face])) for face in range(faces.count))
        return
    assert np.sort(np.concatenate(sets)).tolist() == list(range(pattern.face_count))
    assert [int(s[0]) for s in sets] == sorted(int(s[0]) for s in sets)
    for piece in sets:
        assert (np.diff(piece) > 0).all()
        assert len(faces.components(piece)) == 1
        assert not len(faces.pinched(piece))
        points = extent(sheet, piece)
        turn, fits = upright(points, room)
        assert fits
        assert (np.ptp(points @ turn.T, axis=0) <= np.array(room) * (1 + 1e-8)).all()


def test_faces_over_each_other_are_in_different_sets():
    """A strip of two turns, in a room that all of it fits."""
    pattern = turned_strip(40, 2.0)
    sheet = sheet_of(pattern, (1000.0, 1000.0))
    faces = FaceSets(sheet)
    assert len(faces.overlaps)
    sets = partition(sheet)
    assert len(sets) > 1
    assert not any(faces.overlap(piece) for piece in sets)


def test_sets_are_balanced():
    """Of a strip of 10 squares a bed takes at most 6: 5 and 5, not 6 and 4."""
    pattern = strip(10, 10.0)
    sets = partition(sheet_of(pattern, (60.0, 12.0)))
    assert [piece.tolist() for piece in sets] == [[0, 1, 2, 3, 4], [5, 6, 7, 8, 9]]
    for width, expected in ((60.0, [[0, 1, 2, 3, 4], [5, 6, 7, 8, 9]]), (40.0, [])):
        uneven = [np.arange(2), np.arange(2, 10)]
        evened = search._evened(FaceSets(sheet_of(pattern, (width, 12.0))), uneven)
        assert [piece.tolist() for piece in evened] == (expected or [s.tolist() for s in uneven])


def test_single_faces_are_joined_until_no_two_neighbours_fit_together():
    pattern = grid(9, 7, 20.0, holes=[(4, 3), (5, 3)])
    faces = FaceSets(sheet_of(pattern, (70.0, 50.0)))
    pieces = search._merged(faces, list(np.arange(faces.count)[:, None]))
    every = np.sort(np.concatenate(pieces))
    assert (every == np.arange(faces.count)).all()
    assert all(faces.valid(p) and len(faces.components(p)) == 1 for p in pieces)
    pairs = search._beside(faces, search._owners(faces, pieces))
    assert len(pairs) > len(pieces) > 12
    assert not any(faces.valid(np.concatenate([pieces[i], pieces[j]])) for i, j in pairs)


@given(st.integers(1, 300), st.integers(1, 300), st.integers(1, 300))
def test_the_longest_run_that_fits_is_found_at_a_cost_that_grows_with_its_length(
    count, most, guess
):
    tried = []

    def fits(run):
        tried.append(len(run))
        return len(run) <= most

    assert search._longest(np.arange(count), guess, fits) == min(count, most)
    assert max(tried) <= max(guess, 2 * min(count, most))


@given(st.integers(0, 10**6))
@settings(max_examples=20)
def test_parts_and_outline_of_a_set_are_those_found_from_all_edges(seed):
    random = np.random.default_rng(seed)
    pattern = grid(6, 5, 20.0)
    faces = FaceSets(sheet_of(pattern, (70.0, 50.0)))
    kept = random.permutation(faces.count)[: random.integers(1, faces.count)]
    inside = np.append(np.isin(np.arange(faces.count), kept), False)[pattern.edges_faces]
    edges, side = outline(faces.sheet, kept)
    assert sorted(edges.tolist()) == np.flatnonzero(inside[:, 0] != inside[:, 1]).tolist()
    assert inside[edges, side].all()
    inner = pattern.edges_faces[inside.all(axis=1)]
    parts = faces.components(kept)
    part_of = {face: number for number, part in enumerate(parts) for face in part.tolist()}
    assert sorted(part_of) == sorted(kept.tolist())
    assert all(part_of[first] == part_of[second] for first, second in inner.tolist())
    joins = Counter(part_of[first] for first, _ in inner.tolist())
    assert all(joins[number] >= len(part) - 1 for number, part in enumerate(parts))
    ends = pattern.vertices_coords[pattern.edges_vertices[edges]].reshape(-1, 2)
    hulls = [shapely.MultiPoint(points).convex_hull for points in (ends, extent(faces.sheet, kept))]
    assert hulls[0].equals(hulls[1])


def test_progress_reaches_the_last_face():
    calls = []
    partition(sheet_of(strip(10, 10.0), (60.0, 12.0)), lambda *at: calls.append(at))
    assert [done for done, _ in calls] == sorted(done for done, _ in calls)
    assert calls[-1] == (10, 10)


@pytest.mark.parametrize(
    ("coords", "message"),
    [
        ([[0, 0], [0, 9], [9, 9], [9, 0]], "area of face 0 = -81 mm2"),
        ([[0, 0], [99, 0], [99, 9], [0, 9]], "size of face 0 with its tabs = 9 x 99 mm"),
        ([[0, 0], [40, 40], [40, 0], [0, 50]], "outline of face 0 crosses itself"),
    ],
)
def test_faces_that_cannot_be_pieces_are_refused(coords, message):
    with pytest.raises(InvalidValue, match=message):
        partition(sheet_of(pattern_of(coords, [[0, 1, 2, 3]]), (50.0, 45.0)))
