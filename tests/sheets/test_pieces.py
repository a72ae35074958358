"""Pieces: complete, apart, on the bed, with tabs and labels that lead back to the folded form."""

import dataclasses
from collections import Counter
from functools import cache

import numpy as np
import pytest
import shapely
from helpers import TEMPLATES, published
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.spatial import Delaunay

from fab.geometry.rings import ring_areas
from fab.jobs.job import load_job
from fab.pattern.crease_pattern import CreasePattern, assignments, crease_pattern, fold_angles_deg
from fab.pattern.development import develop
from fab.pattern.overlap import overlapping_faces
from fab.sheets.labels import highest, number_text, text_box, text_lines, text_width
from fab.sheets.piece_labels import EdgeTexts, piece_labels
from fab.sheets.pieces import Pieces, SheetSplit, split
from fab.sheets.stroke_letters import letter_strokes, writable
from solver import Crumpled, CurvedFold, InvalidValue, Miura, QuadMesh
from solver.mesh import boundary_loops, edges_of


def flat_pattern(coords, polygons) -> CreasePattern:
    """A pattern without folds: polygons counterclockwise in the plane."""
    corners = np.concatenate([np.asarray(p) for p in polygons])
    offsets = np.concatenate([[0], np.cumsum([len(p) for p in polygons])])
    edges = edges_of(corners, offsets)
    angle = np.zeros(len(edges.edges_vertices))
    letter = assignments(angle, edges)
    coords = np.asarray(coords, float)
    return CreasePattern(coords, *dataclasses.astuple(edges), letter, angle, corners, offsets)


def pattern_of(mesh: QuadMesh, scale: float) -> CreasePattern:
    mesh = mesh.cut_open()
    return crease_pattern(mesh, develop(mesh), scale)


@cache
def template(name: str, *changes: str) -> CreasePattern:
    job = load_job(TEMPLATES / f"{name}.toml", changes)
    mesh = job.design.design(job.folder)[0].grow().mesh.cut_open()
    development = develop(mesh)
    return crease_pattern(mesh, development, job.sheet.scale(development, mesh.vertices_coords))


def grid(columns: int, rows: int, size: float, holes=(), triangles=False) -> CreasePattern:
    """Squares, each cut into two triangles where asked for, without those at `holes`."""
    x, y = np.meshgrid(np.arange(columns + 1), np.arange(rows + 1))
    coords = size * np.column_stack([x.ravel(), y.ravel()]).astype(float)
    polygons = []
    for row in range(rows):
        for column in range(columns):
            a = row * (columns + 1) + column
            b, c, d = a + 1, a + columns + 2, a + columns + 1
            if (column, row) not in holes:
                polygons += [(a, b, c), (a, c, d)] if triangles else [(a, b, c, d)]
    return flat_pattern(coords, polygons)


def polygons_of(pattern: CreasePattern) -> np.ndarray:
    ring = np.repeat(np.arange(pattern.face_count), np.diff(pattern.faces_offsets))
    corners = pattern.vertices_coords[pattern.faces_vertices]
    return shapely.polygons(shapely.linearrings(corners, indices=ring))


def areas(pattern: CreasePattern) -> np.ndarray:
    return ring_areas(pattern.vertices_coords[pattern.faces_vertices], pattern.faces_offsets)


def lengths(pattern: CreasePattern, edges) -> np.ndarray:
    ends = pattern.vertices_coords[pattern.edges_vertices[edges]]
    return np.hypot(*(ends[:, 1] - ends[:, 0]).T)


def faces_overlap(pattern: CreasePattern) -> bool:
    """Whether two polygons of a pattern share area: pair by pair, by their common area."""
    shapes = polygons_of(pattern)
    first, second = shapely.STRtree(shapes).query(shapes)
    pairs = first < second
    first, second = first[pairs], second[pairs]
    common = shapely.area(shapely.intersection(shapes[first], shapes[second], grid_size=1e-7))
    return bool((common > 1e-5).any())


def check(pattern: CreasePattern, made: Pieces, chosen: SheetSplit, bed) -> None:
    """Everything that is promised of pieces."""
    pieces, seams = made.pieces, made.seams
    every = np.concatenate([piece.faces[piece.faces >= 0] for piece in pieces])
    assert sorted(every.tolist()) == list(range(pattern.face_count))
    assert len({piece.name for piece in pieces}) == len(pieces)
    room = np.array(bed) - 2 * chosen.margin_mm
    whole_areas = areas(pattern)
    for number, piece in enumerate(pieces):
        own = piece.pattern
        assert own.vertices_coords.min(axis=0) == pytest.approx([0, 0], abs=1e-9)
        assert (own.vertices_coords.max(axis=0) <= room * (1 + 1e-6)).all()
        assert not faces_overlap(own)
        real = piece.faces >= 0
        kept = piece.faces[real]
        assert areas(own)[real] == pytest.approx(whole_areas[kept], rel=1e-6)
        assert (areas(own) > 0).all()
        loops = boundary_loops(own.edges)  # raises where the outline touches itself
        assert sum(len(loop) for loop in loops) == (own.edges_assignment == "B").sum()
        parts = shapely.union_all(shapely.buffer(polygons_of(own), 1e-7, join_style="mitre"))
        assert parts.geom_type == "Polygon"
        assert parts.area == pytest.approx(areas(own).sum(), rel=1e-3)
        if own.folded_coords is not None:
            edges = own.edges
            angles = fold_angles_deg(
                own.folded_coords, edges, own.faces_vertices, own.faces_offsets
            )
            apart = np.abs(angles - own.edges_foldAngle)
            assert np.minimum(apart, 360 - apart).max() < 1e-5
            for i, j in zip(own.faces_offsets[:-1], own.faces_offsets[1:], strict=True):
                face = own.faces_vertices[i:j]
                for step in (1, 2):
                    flat = own.vertices_coords[face] - own.vertices_coords[np.roll(face, step)]
                    bent = own.folded_coords[face] - own.folded_coords[np.roll(face, step)]
                    assert np.linalg.norm(flat, axis=1) == pytest.approx(
                        np.linalg.norm(bent, axis=1), rel=1e-6, abs=1e-6
                    )
        tabs = sum(seam.tab is not None and seam.pieces[seam.tab] == number for seam in seams)
        assert (~real).sum() == tabs
    # an inner edge is a crease of one piece or a seam of two
    inner = set(np.flatnonzero(pattern.edges_faces[:, 1] >= 0).tolist())
    cut = {seam.edges[0] for seam in seams if seam.edges[0] == seam.edges[1]}
    kept = {
        int(edge)
        for piece in pieces
        for edge in piece.edges[
            (piece.pattern.edges_faces[:, 1] >= 0)
            & (piece.pattern.edges_faces[:, 1] < (piece.faces >= 0).sum())
        ]
    }
    assert cut | kept == inner
    assert not cut & kept
    assert [seam.label for seam in seams] == list(range(1, len(seams) + 1))
    written = [Counter(label.text for label in piece.labels) for piece in pieces]
    for piece, count in zip(pieces, written, strict=True):
        count.update(piece.unwritten)
        assert count[piece.name] == 1
    assembled = {0}
    for seam in seams:
        for side in (0, 1):
            piece = pieces[seam.pieces[side]]
            edge = seam.piece_edges[side]
            assert piece.edges[edge] == seam.edges[side]
            assert lengths(piece.pattern, [edge])[0] == pytest.approx(seam.length_mm, rel=1e-6)
            expected = seam.fold_angle_deg if seam.tab == side else 0.0
            assert piece.pattern.edges_foldAngle[edge] == expected
            assert (piece.pattern.edges_faces[edge, 1] >= 0) == (seam.tab == side)
            both = seam.pieces[0] == seam.pieces[1]
            assert written[seam.pieces[side]][number_text(seam.label)] >= 1 + both
        assert set(seam.pieces) & assembled or min(seam.pieces) not in assembled
        assembled |= set(seam.pieces)
    for piece in pieces:
        check_labels(piece)


def check_labels(piece) -> None:
    """Letters can be read, stay on a face and clear of each other."""
    own = piece.pattern
    faces = shapely.buffer(polygons_of(own), 1e-6, join_style="mitre")
    boxes = []
    for label in piece.labels:
        rings = text_lines(label.text, label.height_mm, label.at, label.angle_deg)
        every = np.concatenate(rings)
        assert label.height_mm >= 1
        assert (shapely.covers(faces, shapely.multipoints(every))).any(), "crosses a crease"
        boxes.append(shapely.multipoints(every).convex_hull)
    first, second = shapely.STRtree(boxes).query(boxes, predicate="intersects")
    assert (first == second).all()


def test_a_slit_is_no_seam_and_an_edge_to_be_cut_joins_nothing():
    pattern = grid(2, 2, 40.0)
    slit = np.array(
        [
            [0, 0],
            [40, 0],
            [80, 0],
            [0, 40],
            [40, 40],
            [80, 40],
            [0, 80],
            [40, 80],
            [80, 80],
            [40, 0],
        ]
    )
    polygons = [(0, 1, 4, 3), (9, 2, 5, 4), (3, 4, 7, 6), (4, 5, 8, 7)]
    slitted = flat_pattern(slit, polygons)
    folded = np.column_stack([slit, np.zeros(10)]).astype(float)
    slitted = dataclasses.replace(slitted, folded_coords=folded)
    made, findings = split(slitted, SheetSplit(), (100.0, 100.0))
    assert (len(made.pieces), made.seams, findings) == (1, (), [])
    middle = (pattern.edges_faces[:, 1] >= 0) & (
        pattern.vertices_coords[pattern.edges_vertices][:, :, 0] == 40
    ).all(axis=1)
    letter = np.where(middle, "C", pattern.edges_assignment)
    cut = dataclasses.replace(pattern, edges_assignment=letter)
    made, (finding,) = split(cut, SheetSplit(), (100.0, 100.0))
    assert [len(piece.faces) for piece in made.pieces] == [2, 2]
    assert made.seams == ()
    assert "2 pieces that share no edge" in finding.text
    assert "Glue" not in finding.text


def carried(made: Pieces) -> list[int]:
    return [sum(s.tab is not None and s.pieces[s.tab] == n for s in made.seams) for n in range(9)]


def test_a_sheet_that_fits_is_one_piece_in_its_best_box():
    turn = np.array([[0.6, -0.8], [0.8, 0.6]])
    pattern = grid(3, 2, 30.0)
    leaning = dataclasses.replace(pattern, vertices_coords=pattern.vertices_coords @ turn.T + 7)
    for turned in (pattern, leaning):
        made, findings = split(turned, SheetSplit(margin_mm=5), (100.0, 70.0))
        assert findings == []
        assert made.seams == ()
        check(turned, made, SheetSplit(margin_mm=5), (100, 70))
        assert np.ptp(made.pieces[0].pattern.vertices_coords, axis=0) == pytest.approx([90, 60])
    made, _ = split(pattern, SheetSplit(margin_mm=5), (99.9, 70.0))
    assert len(made.pieces) == 2
    made, _ = split(pattern, SheetSplit(margin_mm=5), (70.0, 100.0))  # turned by a quarter
    assert len(made.pieces) == 1


def test_two_squares_have_one_seam_whose_tab_is_exact():
    pattern = grid(2, 1, 40.0)
    made, findings = split(pattern, SheetSplit(margin_mm=0, tab_mm=8), (60.0, 60.0))
    assert [finding.code for finding in findings] == ["sheet-split"]
    (seam,) = made.seams
    assert (seam.label, seam.pieces, seam.length_mm, seam.fold_angle_deg) == (1, (0, 1), 40, 0)
    bearer = made.pieces[seam.pieces[seam.tab]]
    assert areas(bearer.pattern).tolist() == pytest.approx([1600, (40 + 24) / 2 * 8])
    assert sorted(bearer.pattern.counts().values()) == [0, 0, 1, 6]
    other = made.pieces[seam.pieces[1 - seam.tab]]
    assert areas(other.pattern).tolist() == pytest.approx([1600])
    check(pattern, made, SheetSplit(margin_mm=0, tab_mm=8), (60, 60))


def test_as_few_pieces_as_the_area_allows_and_equal():
    pattern = grid(12, 8, 10.0)
    plain = SheetSplit(margin_mm=0, tabs="none")
    made, _ = split(pattern, plain, (60.0, 40.0))
    assert [len(piece.faces) for piece in made.pieces] == [24] * 4
    check(pattern, made, plain, (60, 40))
    made, _ = split(pattern, plain, (59.9, 40.0))
    assert len(made.pieces) > 4
    made, _ = split(pattern, plain, (200.0, 30.0))
    assert len(made.pieces) == 3
    assert sorted(len(piece.faces) for piece in made.pieces)[0] >= 24


def test_tabs_can_be_left_out():
    pattern = grid(4, 1, 30.0)
    made, findings = split(pattern, SheetSplit(tabs="none"), (75.0, 75.0))
    assert [finding.code for finding in findings] == ["sheet-split"]
    assert all(seam.tab is None for seam in made.seams)
    assert [piece.pattern.face_count for piece in made.pieces] == [2, 2]


def test_tabs_are_shared_fairly_where_both_sides_have_room():
    made, _ = split(grid(8, 2, 30.0), SheetSplit(), (85.0, 85.0))
    per_piece = [n for n in carried(made) if n]
    assert max(per_piece) - min(per_piece) <= 2


def test_mitres_stay_within_the_face_that_is_glued_to():
    """Across the seam is a flat triangle with angles of 30 degrees, so the mitre is smaller."""
    height = 20 * np.tan(np.radians(30))
    coords = [[0, 0], [40, 0], [40, 40], [0, 40], [20, -height]]
    pattern = flat_pattern(coords, [(0, 1, 2, 3), (0, 4, 1)])
    plain = SheetSplit(margin_mm=0, tab_mm=6)
    made, _ = split(pattern, plain, (50.0, 50.0))
    check(pattern, made, plain, (50, 50))
    (seam,) = made.seams
    assert seam.pieces[seam.tab] == 0
    assert areas(made.pieces[0].pattern)[1] == pytest.approx(6 * (40 - 6 / np.tan(np.radians(29))))


@pytest.mark.parametrize("tab_angle_deg", [10.0, 45.0, 90.0])
@pytest.mark.parametrize("tab_mm", [1.0, 8.0, 30.0])
def test_tabs_of_every_shape_overlap_nothing(tab_angle_deg, tab_mm):
    pattern = pattern_of(Miura(columns=6, rows=6).grow().mesh, 25.0)
    chosen = SheetSplit(tab_mm=tab_mm, tab_angle_deg=tab_angle_deg)
    made, _ = split(pattern, chosen, (130.0, 130.0))
    assert len(made.pieces) > 1
    assert any(seam.tab is not None for seam in made.seams)
    check(pattern, made, chosen, (130, 130))


@given(
    st.integers(2, 9),
    st.integers(2, 9),
    st.floats(35, 80),
    st.floats(10, 80),
    st.floats(75, 200),
    st.floats(75, 200),
)
@settings(max_examples=12, deadline=None)
def test_miura_sheets_on_any_bed(columns, rows, sector, fold, width, height):
    design = Miura(
        columns=columns, rows=rows, sector_angle=np.radians(sector), fold=np.radians(fold)
    )
    pattern = pattern_of(design.grow().mesh, 25.0)
    made, _ = split(pattern, SheetSplit(), (width, height))
    check(pattern, made, SheetSplit(), (width, height))


@given(st.integers(0, 1000), st.floats(180, 260))
@settings(max_examples=5, deadline=None)
def test_crumpled_sheets_on_any_bed(seed, width):
    mesh = Crumpled(random_seed=seed, columns=8, strips=8).grow().mesh
    pattern = pattern_of(mesh, 1.0)
    pattern = pattern_of(mesh, 330.0 / pattern.vertices_coords.max())
    made, _ = split(pattern, SheetSplit(), (width, width / 1.3))
    check(pattern, made, SheetSplit(), (width, width / 1.3))


@given(st.data())
@settings(max_examples=6, deadline=None)
def test_triangles_with_holes(data):
    places = st.tuples(st.integers(0, 6), st.integers(0, 5))
    holes = data.draw(st.sets(places, max_size=20))
    pattern = grid(7, 6, 20.0, holes, triangles=True)
    bed = data.draw(st.floats(62, 160)), data.draw(st.floats(62, 160))
    made, _ = split(pattern, SheetSplit(), bed)
    check(pattern, made, SheetSplit(), bed)


def test_a_hole_stays_a_hole_and_squares_that_touch_at_a_corner_come_apart():
    ring = grid(3, 3, 30.0, holes=[(1, 1)])
    made, _ = split(ring, SheetSplit(), (200.0, 200.0))
    assert len(made.pieces) == 1
    assert len(boundary_loops(made.pieces[0].pattern.edges)) == 2
    check(ring, made, SheetSplit(), (200, 200))
    touching = grid(2, 2, 30.0, holes=[(0, 0), (1, 1)])
    made, _ = split(touching, SheetSplit(), (200.0, 200.0))
    assert [len(piece.faces) for piece in made.pieces] == [1, 1]
    pinched = grid(4, 3, 30.0, holes=[(1, 1), (2, 2)])  # one part that touches itself inside
    made, _ = split(pinched, SheetSplit(), (200.0, 200.0))
    assert len(made.pieces) == 2
    check(pinched, made, SheetSplit(), (200, 200))


@pytest.fixture(scope="module")
def curled() -> CreasePattern:
    """The curved fold with k = 187.2 degrees, whose development overlaps itself."""
    return pattern_of(CurvedFold().grow().mesh, 150.0)


def test_a_sheet_that_overlaps_itself_comes_apart_on_any_bed(curled):
    faces = curled.faces_vertices, curled.faces_offsets
    assert len(overlapping_faces(curled.vertices_coords, *faces, curled.edges)) > 0
    assert faces_overlap(curled)
    bed = tuple(curled.vertices_coords.max(axis=0) + 100)
    made, findings = split(curled, SheetSplit(), bed)
    covered = shapely.union_all(polygons_of(curled), grid_size=1e-6).area
    assert len(made.pieces) == np.ceil(areas(curled).sum() / covered) == 3  # turns
    assert "sheet-split" in [finding.code for finding in findings]
    check(curled, made, SheetSplit(), bed)


def test_the_published_curved_fold():
    mesh = QuadMesh.from_rows(published("F4D", "fold"))
    pattern = pattern_of(mesh, 150.0)
    bed = (400.0, 300.0)
    made, _ = split(pattern, SheetSplit(), bed)
    assert len(made.pieces) <= 8
    check(pattern, made, SheetSplit(), bed)


def test_the_brownian_ribbon():
    pattern = template("brownian_ribbon_400", "sheet.width_mm=40000")
    made, _ = split(pattern, SheetSplit(), (4800.0, 2400.0))
    assert len(made.seams) == len(made.pieces) - 1
    assert all(seam.tab is not None for seam in made.seams)
    check(pattern, made, SheetSplit(), (4800, 2400))


def test_the_trefoil_closes_with_tabs():
    pattern = template("trefoil_knot")
    made, _ = split(pattern, SheetSplit(), (1000.0, 200.0))
    assert len(made.pieces) == 1
    assert len(made.seams) == 8
    assert all(seam.edges[0] != seam.edges[1] for seam in made.seams)
    assert all(seam.tab is not None for seam in made.seams)
    check(pattern, made, SheetSplit(), (1000, 200))
    made, _ = split(pattern, SheetSplit(), (340.0, 200.0))
    assert len(made.pieces) == 3
    assert len(made.seams) == 24
    check(pattern, made, SheetSplit(), (340, 200))


def test_nested_cones_close_with_tabs():
    pattern = template("nested_cones", "design.strips=5", "design.sides=24")
    closing = len(pattern.edges_faces[pattern.edges_faces[:, 1] < 0]) - 2 * 24
    bed = tuple(pattern.vertices_coords.max(axis=0) + 40)
    made, _ = split(pattern, SheetSplit(), bed)
    assert len(made.pieces) == 1
    assert len(made.seams) == closing / 2 == 6
    check(pattern, made, SheetSplit(), bed)
    made, _ = split(pattern, SheetSplit(), (330.0, 330.0))
    assert len(made.pieces) > 2
    check(pattern, made, SheetSplit(), (330, 330))


def test_an_unclosed_sheet_has_no_closing_seam_nor_one_that_is_folded_flat():
    """Negative controls: a book whose pages lie on each other is not a tube."""
    pattern = pattern_of(Miura().grow().mesh, 10.0)
    made, _ = split(pattern, SheetSplit(), (500.0, 500.0))
    assert made.seams == ()
    book = grid(2, 1, 40.0)
    folded = np.column_stack([40 - np.abs(book.vertices_coords[:, 0] - 40), np.zeros(6)])
    folded = np.column_stack([folded[:, 0], book.vertices_coords[:, 1], np.zeros(6)])
    flat_folded = dataclasses.replace(book, folded_coords=folded)
    made, _ = split(flat_folded, SheetSplit(), (500.0, 500.0))
    assert made.seams == ()


def test_a_prism_closes_with_the_angle_of_its_other_edges():
    turn = 2 * np.pi * np.arange(6) / 5
    rim = 50 * np.column_stack([np.cos(turn), np.sin(turn)])
    folded = np.concatenate([np.column_stack([rim, np.full(6, z)]) for z in (0.0, 40.0)])
    pattern = grid(5, 1, 1.0)
    side = 100 * np.sin(np.pi / 5)
    flat = pattern.vertices_coords * [side, 40.0]
    angle = fold_angles_deg(folded, pattern.edges, pattern.faces_vertices, pattern.faces_offsets)
    pattern = dataclasses.replace(
        pattern,
        vertices_coords=flat,
        folded_coords=folded,
        edges_foldAngle=angle,
        edges_assignment=assignments(angle, pattern.edges),
    )
    made, _ = split(pattern, SheetSplit(), (400.0, 100.0))
    (seam,) = made.seams
    assert abs(seam.fold_angle_deg) == pytest.approx(72)
    assert seam.fold_angle_deg == pytest.approx(angle[np.argmax(np.abs(angle))])
    check(pattern, made, SheetSplit(), (400, 100))


@given(st.integers(0, 10**6), st.floats(260, 400), st.floats(2, 20))
@settings(max_examples=4, deadline=None)
def test_triangles_between_random_points(seed, width, tab_mm):
    random = np.random.default_rng(seed)
    points = random.uniform(0, 500, (random.integers(60, 120), 2))
    corners = Delaunay(points).simplices
    size = ring_areas(points[corners].reshape(-1, 2), 3 * np.arange(len(corners) + 1))
    corners[size < 0] = corners[size < 0, ::-1]
    sides = np.linalg.norm(points[corners] - points[np.roll(corners, 1, axis=1)], axis=2)
    plain = (np.abs(size) > 50) & (sides.max(axis=1) < 200) & (random.random(len(corners)) < 0.9)
    pattern = flat_pattern(points, corners[plain].tolist())
    chosen = SheetSplit(tab_mm=tab_mm)
    made, _ = split(pattern, chosen, (width, 260.0))
    check(pattern, made, chosen, (width, 260))


def test_names_are_where_they_cross_no_crease_and_as_high_as_there_is_room():
    """On one of two squares joined by a strip; on a long face the name is turned."""
    coords = [[0, 0], [30, 0], [30, 30], [0, 30], [35, 0], [35, 30], [65, 0], [65, 30]]
    pattern = flat_pattern(coords, [(0, 1, 2, 3), (1, 4, 5, 2), (4, 6, 7, 5)])
    made, _ = split(pattern, SheetSplit(), (200.0, 200.0))
    (name,) = made.pieces[0].labels
    assert (name.text, name.height_mm, name.angle_deg) == ("A", 8.0, 0.0)
    assert name.at[0] == pytest.approx(15, abs=1)
    assert abs(name.at[1] - 32.5) == pytest.approx(17.5, abs=1)
    slope = flat_pattern([[0, 0], [60, 60], [57, 63], [-3, 3]], [(0, 1, 2, 3)])
    room = polygons_of(slope)[0]
    level, along = (
        highest("ABC", np.array([28.5, 31.5]), angle, room) for angle in (0.0, np.pi / 4)
    )
    assert along == pytest.approx(3 * np.sqrt(2) / 1.2)
    assert along > 2 * level


@given(st.integers(0, 10**6), st.floats(0, 7))
def test_the_highest_text_touches_the_room_and_stays_inside(seed, slant):
    random = np.random.default_rng(seed)
    angle = np.sort(random.uniform(0, 2 * np.pi, 9))
    assume(np.diff([*angle, angle[0] + 2 * np.pi]).max() < 3)
    radius = random.uniform(5, 20, 9)
    room = shapely.Polygon(np.column_stack([radius * np.cos(angle), radius * np.sin(angle)]))
    height = highest("B7", np.zeros(2), slant, room)
    for share, inside in ((1 - 1e-9, True), (1 + 1e-6, False)):
        half = share * height * np.array([(text_width("B7") + 0.4) / 2, 0.6])
        box = shapely.affinity.rotate(shapely.box(*-half, *half), slant, (0, 0), use_radians=True)
        assert room.covers(box) == inside


@pytest.mark.parametrize("text", ["A", "J", "Q", "17", "JQ"])
def test_letters_lie_in_their_box(text):
    every = np.concatenate(text_lines(text, 1.0, (0.0, 0.0), 0.0))
    assert (np.abs(every).max(axis=0) < np.array(text_box(text)) / 2).all()


@given(st.integers(0, 10**6), st.floats(0, 7))
def test_the_highest_text_on_a_line_touches_the_room_and_stays_inside(seed, slant):
    """Its middle is one height above the middle of a side of the room."""
    random = np.random.default_rng(seed)
    angle = np.pi * np.sort(random.uniform(0.05, 0.95, 7))
    radius = random.uniform(3, 20, 7)
    upper = np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])
    half = random.uniform(1, 20)
    turn = np.array([[np.cos(slant), np.sin(slant)], [-np.sin(slant), np.cos(slant)]])
    anchor = random.uniform(-50, 50, 2)
    room = shapely.Polygon(np.vstack([[[-half, 0], [half, 0]], upper]) @ turn + anchor)
    assume(room.is_valid)
    height = highest("17", anchor, slant, room, 1.0)
    for share, inside in ((0.3, True), (1 - 1e-6, True), (1 + 1e-6, False)):
        h, w = share * height, (text_width("17") + 0.4) / 2
        corners = h * np.array([[-w, 0.4], [w, 0.4], [w, 1.6], [-w, 1.6]])
        assert room.covers(shapely.Polygon(corners @ turn + anchor)) == inside


def test_numbers_are_as_high_as_their_faces_let_them_be():
    """Two rows of flat faces: the name, and a number on each side of the seam."""
    coords = [[0, 0], [40, 0], [40, 3], [0, 3], [40, 6], [0, 6]]
    pattern = flat_pattern(coords, [(0, 1, 2, 3), (3, 2, 4, 5)])
    made, _ = split(pattern, SheetSplit(margin_mm=0, tabs="none"), (41.0, 5.0))
    numbers = [label for piece in made.pieces for label in piece.labels if label.text == "1"]
    assert [label.height_mm for label in numbers] == pytest.approx([3 / 1.6] * 2)


def test_names_run_on_after_z():
    made, _ = split(grid(28, 1, 30.0), SheetSplit(tabs="none"), (42.0, 42.0))
    assert [piece.name for piece in made.pieces][-3:] == ["Z", "AA", "AB"]


def test_splitting_is_repeatable_and_leaves_the_pattern_untouched(curled):
    before = curled.vertices_coords.copy()
    first, _ = split(curled, SheetSplit(), (900.0, 300.0))
    second, _ = split(curled, SheetSplit(), (900.0, 300.0))
    assert first.seams == second.seams
    for p, q in zip(first.pieces, second.pieces, strict=True):
        assert (p.pattern.vertices_coords == q.pattern.vertices_coords).all()
        assert p.labels == q.labels
    assert (curled.vertices_coords == before).all()


def test_seams_without_room_for_a_tab_are_named():
    made, findings = split(grid(4, 1, 1.1), SheetSplit(margin_mm=0, tab_mm=1), (3.5, 3.5))
    (finding,) = [f for f in findings if f.code == "tab-no-room"]
    assert set(finding.creases) == {seam.edges[0] for seam in made.seams}
    (finding,) = [f for f in findings if f.code == "label-too-small"]
    assert "4 labels are left out" in finding.text
    assert "letters of 1 mm" in finding.text
    assert all(piece.labels == () for piece in made.pieces)
    assert made.pieces[0].unwritten == ("A", "1")


@pytest.mark.parametrize(
    ("bed", "name"),
    [
        (
            (50.0, 49.0),
            "size of face 1 with its tabs = 46 x 38 mm .* fit 39 x 38 mm, the bed of 50 x 49 mm "
            r"less 5.5 mm on each side \(margin 5 mm, mitres of the cut 0.5 mm\)",
        ),
        ((11.0, 100.0), r"bed width = 11 mm .* 2 x 5.5 mm, what is kept free \(margin 5 mm, "),
        ((10.0, 100.0), "bed width = 10 mm"),
        ((100.0, -1.0), "bed height"),
        ((np.nan, 100.0), "bed width"),
    ],
)
def test_beds_that_are_too_small_are_refused(bed, name):
    with pytest.raises(InvalidValue, match=name):
        split(grid(4, 4, 30.0), SheetSplit(mitre_mm=0.5), bed)


def test_faces_that_cannot_be_cut_out_are_refused():
    bow = flat_pattern([[0, 0], [50, 0], [0, 40], [60, 50]], [(0, 1, 2, 3)])
    with pytest.raises(InvalidValue, match="face 0"):
        split(bow, SheetSplit(), (200.0, 200.0))
    clockwise = flat_pattern([[0, 0], [50, 0], [0, 40]], [(0, 2, 1)])
    with pytest.raises(InvalidValue, match="area of face 0"):
        split(clockwise, SheetSplit(), (200.0, 200.0))


def test_the_checks_see_what_is_wrong():
    """Negative controls of the tests themselves: pieces put back together, and a shifted tab."""
    pattern = grid(4, 2, 30.0)
    chosen = SheetSplit()
    made, _ = split(pattern, chosen, (95.0, 95.0))
    check(pattern, made, chosen, (95, 95))
    with pytest.raises(AssertionError):
        check(pattern, made, chosen, (60, 60))
    with pytest.raises(AssertionError):
        check(pattern, Pieces(made.pieces[:-1], made.seams), chosen, (95, 95))
    bearer = next(i for i, piece in enumerate(made.pieces) if (piece.faces < 0).any())
    piece = made.pieces[bearer]
    coords = piece.pattern.vertices_coords.copy()
    coords[-2:] += 3 * (coords[:-2].mean(axis=0) - coords[-2:].mean(axis=0))
    wrong = dataclasses.replace(
        piece, pattern=dataclasses.replace(piece.pattern, vertices_coords=coords)
    )
    pieces = (*made.pieces[:bearer], wrong, *made.pieces[bearer + 1 :])
    with pytest.raises(AssertionError):
        check(pattern, Pieces(pieces, made.seams), chosen, (95, 95))


def test_numbers_that_are_others_upside_down_have_a_full_stop():
    turned = {"0": "0", "1": "1", "6": "9", "8": "8", "9": "6"}
    stopped = [n for n in range(1, 1000) if number_text(n) != str(n)]
    assert stopped[:10] == [6, 9, 16, 18, 19, 61, 66, 68, 81, 86]
    for n in range(1, 1000):
        assert number_text(n) == f"{n}{'.' * (n in stopped)}"
        read = "".join(turned.get(digit, "?") for digit in reversed(str(n)))
        other = "?" not in read and read[0] != "0" and int(read) != n
        assert other == (n in stopped)
    assert len(text_lines("6.", 4.0, (0.0, 0.0), 0.0)) == len(text_lines("6", 4.0, (0, 0), 0)) + 1


def test_letters_have_their_height_middle_and_direction():
    rings = text_lines("A1", 4.0, (10.0, 20.0), 0.0)
    every = np.concatenate(rings)
    assert np.ptp(every[:, 1]) == pytest.approx(4.0, rel=0.1)
    assert (every.min(axis=0) + every.max(axis=0)) / 2 == pytest.approx([10, 20])
    assert np.ptp(every[:, 0]) > np.ptp(every[:, 1])
    upward = np.concatenate(text_lines("A1", 4.0, (10.0, 20.0), 90.0))
    arm = every - [10, 20]
    assert upward == pytest.approx(np.column_stack([10 - arm[:, 1], 20 + arm[:, 0]]))
    assert all(len(line) > 2 for line in rings)
    mirrored = np.concatenate(text_lines("A1", 4.0, (10.0, 20.0), 0.0, mirrored=True))
    assert mirrored == pytest.approx(every * [-1, 1] + [20, 0])


def test_every_printable_character_has_strokes_and_others_a_line_below():
    for code in range(33, 127):
        assert letter_strokes(chr(code)), chr(code)
    for letter in "ÄÖÜäöüßéèñçåøæ":
        assert writable(letter) == letter
        assert len(letter_strokes(letter)) >= 1
    assert writable("a\u0308") == "ä"
    assert writable("紙 1") == "_ 1"
    assert letter_strokes("") == letter_strokes(" ") == ()


def test_progress_is_reported_up_to_the_last_face_and_can_interrupt():
    pattern = grid(12, 12, 30.0)
    seen = []
    made, _ = split(pattern, SheetSplit(), (150.0, 120.0), lambda *steps: seen.append(steps))
    assert len(seen) > len(made.pieces) > 1
    assert {total for _, total in seen} == {2 * pattern.face_count}
    assert [done for done, _ in seen] == sorted(done for done, _ in seen)
    assert sum(0 < done < pattern.face_count for done, _ in seen) > 1
    assert seen[-1] == (288, 288)

    def stop(*_):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        split(pattern, SheetSplit(), (150.0, 120.0), stop)


def test_pieces_that_may_not_turn_are_divided_until_they_fit_as_they_are():
    strip, bed = grid(2, 12, 10.0), (130.0, 60.0)
    whole, _ = split(strip, SheetSplit(margin_mm=0.0), bed)
    assert len(whole.pieces) == 1  # it lies along the bed
    kept, _ = split(strip, SheetSplit(margin_mm=0.0, rotations_deg=(0.0, 180.0)), bed)
    assert len(kept.pieces) == 3
    for piece in kept.pieces:
        assert (np.ptp(piece.pattern.vertices_coords, axis=0) <= bed).all()
        assert np.ptp(piece.pattern.vertices_coords, axis=0)[0] == pytest.approx(20.0)


def test_faces_that_openings_take_whole_have_no_room_for_labels():
    pattern = grid(2, 1, 10.0)
    sides = np.array([[[0.0, 0.0], [10.0, 0.0]], [[10.0, 0.0], [20.0, 0.0]]])
    seams = EdgeTexts(("1", "2"), np.arange(2), sides)
    first = np.array([[-1.0, -1.0], [10.5, -1.0], [10.5, 11.0], [-1.0, 11.0]])
    name, one, two = piece_labels(pattern, "A", 2, seams, 2.0, [first])
    assert one is None
    assert min(name.at[0], two.at[0]) > 10.5
    both = [first, first + np.array([10.0, 0.0])]
    assert piece_labels(pattern, "A", 2, seams, 2.0, both) == (None, None, None)
