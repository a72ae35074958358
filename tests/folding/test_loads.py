"""Loaded sheets beside exact shapes: elastica, hanging strips, chains, plates, and their forces."""

import json
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from helpers import PATTERNS
from load_references import arc_between, chain_between, elastica, follower_elastica, quads
from scipy.optimize import brentq

from fab import read_pattern
from fab.errors import InvalidJob
from fab.folding.bar_hinge_model import framework
from fab.folding.loads import loaded_sheet
from fab.folding.loads.forces import BarTension, DeadForces, Pressure, rim_forces
from fab.folding.loads.load_settings import LoadSettings
from fab.folding.loads.loaded_sheet import GRAVITY_M_S2, load_sheet
from fab.folding.loads.plate import Plate
from fab.folding.loads.plate_bending import plate_bending
from fab.folding.loads.refined import refined
from fab.folding.loads.supports import chosen_vertices
from fab.folding.quasi_static import fold
from fab.folding.rest import relaxed
from fab.viewing.scene_builders import folding_scene
from solver.vectors import norm

CARD = Plate(0.36, 833.0, 4000.0, 0.0, 0.0)
LENGTH, WIDTH = 200.0, 20.0


def loaded(pattern, plate=CARD, coords=None, **settings):
    frame = framework(pattern)
    flat = frame.vertices_coords * frame.size_mm
    asked = LoadSettings(**{"load_steps": 1, "parts": 1, **settings})
    return load_sheet(frame, flat if coords is None else coords, plate, asked)


def cantilever(cells, **settings):
    """Tip (x, z) of a strip that is held in its first cell, mm from the end of that."""
    cell = LENGTH / cells
    pattern = quads(cells + 1, 1, LENGTH + cell, WIDTH)
    end = [LENGTH + cell - 1e-6, -1.0, LENGTH + cell + 1.0, WIDTH + 1.0]
    pulls = [{"at": [end], "force_n": settings.pop("tip")}] if "tip" in settings else []
    made = loaded(pattern, fixed=[[-1.0, -1.0, cell, WIDTH + 1.0]], pulls=pulls, **settings)
    assert made.last.settled
    tip = made.frame.sheet.pattern.vertices_coords[:, 0] > LENGTH + cell / 2
    x, _, z = made.last.coords[tip].mean(axis=0)
    return np.array([x - cell, z])


def bending_nm2(plate=CARD):
    """E I of the strip."""
    return 1e6 * plate.youngs_modulus_mpa * (1e-3 * plate.thickness_mm) ** 3 / 12 * 1e-3 * WIDTH


@pytest.mark.parametrize("load", ["tip", "weight"])
def test_a_cantilever_converges_to_the_elastica_with_order_two(load):
    line = 1e-3 * CARD.grams_per_m2 * GRAVITY_M_S2 * 1e-3 * WIDTH
    if load == "tip":
        exact = elastica(bending_nm2(), 1e-3 * LENGTH, tip=0.05)
        assert abs(exact[1]) > 0.7 * 1e-3 * LENGTH  # bent far
        given = {"weight": False, "tip": [0.0, 0.0, -0.05]}
    else:
        exact = elastica(bending_nm2(), 1e-3 * LENGTH, line=line)
        given = {"weight": True}
    exact = 1e3 * exact * [1, -1]
    errors = [norm(cantilever(cells, **given) - exact) / LENGTH for cells in (5, 10, 20)]
    assert errors[1] < 0.01
    assert errors[2] < 0.002
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.abs(orders - 2).max() < 0.1


def test_faces_that_are_divided_bend_as_strips_that_are_cut():
    fine = cantilever(10, weight=True)
    divided = cantilever(5, weight=True, parts=2)
    whole = cantilever(5, weight=True)
    exact = elastica(
        bending_nm2(),
        1e-3 * LENGTH,
        line=1e-3 * CARD.grams_per_m2 * GRAVITY_M_S2 * 1e-3 * WIDTH,
    )
    far = abs(whole[1] + 1e3 * exact[1])
    assert abs(divided[1] - fine[1]) < 0.02 * far
    assert abs(divided[1] + 1e3 * exact[1]) < 0.3 * far


def test_pressure_on_a_cantilever_stays_normal_to_it():
    pressure = 5.0
    exact = follower_elastica(bending_nm2(), 1e-3 * LENGTH, pressure * 1e-3 * WIDTH)
    found = [cantilever(cells, weight=False, pressure_pa=pressure) for cells in (10, 20)]
    errors = [norm(tip - 1e3 * exact) / LENGTH for tip in found]
    assert exact[1] > 0.2 * 1e-3 * LENGTH
    assert errors[1] < 0.003
    assert 1.8 < np.log2(errors[0] / errors[1]) < 2.2


@pytest.mark.parametrize("down", [(0.0, -1.0, 0.0), (1.0, 0.0, 0.0)])
def test_a_strip_hung_by_its_end_carries_the_weight_below(down):
    side = "left edge" if down[0] else "top edge"
    rows, columns = (1, 6) if down[0] else (6, 1)
    long, wide = (120.0, 30.0) if down[0] else (30.0, 120.0)
    made = loaded(quads(columns, rows, long, wide), fixed=[side], down=down)
    frame, axis = made.frame, 0 if down[0] else 1
    coords = made.last.coords / frame.size_mm
    ends = frame.bars_vertices
    along = coords[ends[:, 1]] - coords[ends[:, 0]]
    physical = norm(along) / frame.bars_length - 1
    # the frame that was loaded has the stiffness of the plate
    level = np.sort(np.unique(frame.vertices_coords[:, axis]))
    weight = made.weight_n
    assert made.last.reactions_n.sum(axis=0) == pytest.approx(-weight * np.array(down), abs=1e-9)
    for below, above in pairwise(level):
        middle = (below + above) / 2
        first, second = frame.vertices_coords[ends][:, :, axis].T
        crossing = (first < middle) != (second < middle)
        pull = made.bars_stiffness[crossing] * frame.bars_length[crossing] * physical[crossing]
        lower = pull * np.abs(along[crossing, axis]) / norm(along[crossing])
        place = (middle - level[0]) / (level[-1] - level[0])
        beyond = 1 - place if down[0] else place
        # the weight of half a row is at its vertices, which are the level below
        steps = np.round(beyond * (len(level) - 1) - 0.5)
        carried = (steps + 0.5) / (len(level) - 1)
        assert lower.sum() == pytest.approx(weight * carried, rel=1e-6)


def hung(links, shape, **settings):
    """Nodes (x, z) of a strip of free creases between two points, from a shape to begin with."""
    pattern = quads(links, 1, LENGTH, WIDTH, "F")
    begin = shape(links, LENGTH, 0.8 * LENGTH)
    coords = np.zeros((2 * (links + 1), 3))
    coords[:, 1] = np.repeat([0.0, WIDTH], links + 1)
    coords[:, [0, 2]] = np.tile(begin, (2, 1))
    made = loaded(pattern, coords=coords, fixed=["left edge", "right edge"], **settings)
    assert made.last.settled
    both = made.last.coords[:, [0, 2]].reshape(2, links + 1, 2)
    # diagonals of the quads stretch a little more on one side
    assert np.abs(both[0] - both[1]).max() < 1e-4
    return made, both[0]


def test_a_strip_of_free_creases_hangs_as_a_chain_and_at_last_as_a_catenary():
    made, nodes = hung(8, arc_between)
    assert np.abs(nodes - chain_between(8, LENGTH, 0.8 * LENGTH)).max() < 1e-3
    total = made.last.reactions_n.sum(axis=0)
    assert total == pytest.approx([0, 0, made.weight_n], abs=1e-8)
    # of a catenary: 2 a sinh(d / 2 a) = length over the span d, sag a (cosh(d / 2 a) - 1)
    span = 0.8 * LENGTH
    a = brentq(lambda a: 2 * a * np.sinh(span / 2 / a) - LENGTH, 10.0, 1e4)
    sag = a * (np.cosh(span / 2 / a) - 1)
    off = [abs(-hung(links, chain_between)[1][:, 1].min() - sag) for links in (8, 16)]
    assert off[1] < 0.005 * sag
    assert 1.8 < np.log2(off[0] / off[1]) < 2.2


def test_pressure_bulges_a_strip_of_free_creases_to_an_arc():
    made, nodes = hung(9, chain_between, weight=False, pressure_pa=20.0)
    exact = arc_between(9, LENGTH, 0.8 * LENGTH)
    assert np.abs(nodes - exact).max() < 1e-3
    force = 20.0 * 0.8 * LENGTH * WIDTH * 1e-6
    assert made.last.reactions_n.sum(axis=0) == pytest.approx([0, 0, -force], abs=1e-6)


def test_a_plate_on_its_border_sags_as_the_series_says():
    """Timoshenko: 0.00406 q a^4 / D at the middle of a simply supported square, nu = 0.3."""
    side, plate = 100.0, Plate(1.0, 1000.0, 3000.0, 0.3, 0.0)
    made = loaded(quads(12, 12, side, side), plate, fixed=["border"])
    load = 1e-3 * plate.grams_per_m2 * GRAVITY_M_S2
    exact = 1e3 * 0.00406 * load * (1e-3 * side) ** 4 / plate.bending_stiffness_nm
    assert made.sag_mm == pytest.approx(exact, rel=0.02)
    assert made.sag_mm < 0.02  # far less than its thickness: it bends and does not stretch
    assert made.frame.vertices_coords[made.sag_vertex, :2] == pytest.approx(
        made.frame.vertices_coords[:, :2].mean(axis=0), abs=1e-9
    )


@pytest.mark.parametrize("angle_deg", [0.0, 30.0, 45.0, 90.0])
def test_a_lattice_of_equal_triangles_has_every_constant_curvature_exactly(angle_deg):
    coarse = framework(quads(1, 1, 40.0, 30.0))
    frame = framework(refined(coarse, 6).pattern)
    within = np.ones(len(frame.hinges_vertices), bool)
    free = np.zeros(len(frame.vertices_coords), bool)
    bending = plate_bending(frame, within, 2.0, 0.3, free)
    across = np.array([np.cos(np.radians(angle_deg)), np.sin(np.radians(angle_deg)), 0.0])
    coords = frame.vertices_coords.copy()
    height = 1e-4
    coords[:, 2] = height / 2 * (coords @ across) ** 2
    inner = (bending.sides >= 0).all(axis=1)
    diagonal = np.isclose(frame.vertices_coords[frame.triangles_vertices].mean(axis=1)[:, 1], -1)
    curvature = bending.curvatures(coords)
    # those at the diagonal have a triangle of another lattice beside them
    own = np.isclose(curvature, height, rtol=1e-6)
    assert own[inner].mean() > 0.6
    assert not diagonal.any()


def test_potentials_have_the_gradients_of_their_energies():
    frame = framework(refined(framework(quads(2, 2, 30.0, 20.0)), 2).pattern)
    random = np.random.default_rng(3)
    coords = frame.vertices_coords + 0.02 * random.standard_normal(frame.vertices_coords.shape)
    plates = np.ones(len(frame.hinges_vertices), bool)
    held = np.zeros(len(coords), bool)
    held[:4] = True
    potentials = [
        plate_bending(frame, plates, 1.7, 0.3, held),
        Pressure(frame.triangles_vertices, 0.7),
        DeadForces(random.standard_normal(coords.shape)),
        BarTension(frame),
    ]
    for potential in potentials:
        step = random.standard_normal(coords.shape)
        small = 1e-6
        rise = potential.energy(coords + small * step) - potential.energy(coords - small * step)
        gradient, blocks = potential.linearised(coords)
        assert rise / (2 * small) == pytest.approx(
            float(np.sum(gradient * step)), rel=1e-6, abs=1e-9
        )
        for block in blocks:
            assert np.linalg.eigvalsh(block.matrices).min() > -1e-9 * np.abs(block.matrices).max()


def test_pressure_with_the_rim_pushes_each_triangle_along_its_normal():
    frame = framework(quads(2, 2, 30.0, 20.0))
    coords = frame.vertices_coords + 0.1 * np.random.default_rng(5).standard_normal((9, 3))
    triangles = frame.triangles_vertices
    force = -Pressure(triangles, 3.0).linearised(coords)[0] + rim_forces(coords, triangles, 3.0)
    a, b, c = (coords[triangles[:, k]] for k in range(3))
    exact = np.zeros_like(coords)
    np.add.at(exact, triangles.ravel(), np.repeat(3.0 * np.cross(b - a, c - a) / 6, 3, axis=0))
    assert force == pytest.approx(exact, abs=1e-12)


def test_reactions_add_up_to_less_the_load_of_weight_pulls_and_pressure():
    pull = {"at": ["right edge"], "force_n": [0.002, 0.001, -0.003]}
    for given in (
        {"weight": False, "pressure_pa": 5.0},
        {"weight": False, "pressure_pa": 5.0, "pulls": [pull]},
        {"pressure_pa": 5.0, "pulls": [pull]},
    ):
        made = loaded(quads(8, 2, 80.0, 20.0), fixed=[[0.0, 0.0, 10.0, 20.0]], **given)
        assert made.last.settled
        load = norm(made.load_n)
        assert load > 0.001
        assert norm(made.load_n + made.last.reactions_n.sum(axis=0)) < 1e-6 * load
        assert made.weighs == given.get("weight", True)


def test_how_a_sheet_moves_is_up_down_or_to_the_side():
    strip, clamp = quads(8, 2, 80.0, 20.0), [[0.0, 0.0, 10.0, 20.0]]
    assert loaded(strip, fixed=clamp).moved[0] == "sags"
    made = loaded(strip, fixed=clamp, weight=False, pressure_pa=5.0)
    how, far, vertex = made.moved
    assert how == "rises"
    assert far == pytest.approx(made.displacement_mm[:, 2].max())
    assert made.frame.sheet.pattern.vertices_coords[vertex, 0] == pytest.approx(80.0)
    pull = {"at": ["right edge"], "force_n": [0.1, 0.0, 0.0]}
    how, far, _ = loaded(strip, fixed=clamp, weight=False, pulls=[pull]).moved
    assert how == "moves"
    assert 0 < far < 1


def test_a_miura_is_carried_by_the_edge_that_holds_it():
    pattern = read_pattern(PATTERNS / "miura.fold")[0]
    frame = framework(pattern)
    coords = folding_scene(fold(frame), "miura").states_coords[-1]
    plate = Plate(0.36, 833.0, 4000.0, 0.3, 0.5)
    asked = LoadSettings(fixed=["left edge"], load_steps=2, parts=2)
    made = load_sheet(frame, coords, plate, asked)
    assert made.last.settled
    corners = pattern.vertices_coords[pattern.faces_vertices.reshape(-1, 3)]
    area = 1e-6 * float(np.linalg.det(np.diff(corners, axis=1)).sum()) / 2
    weight = 1e-3 * plate.grams_per_m2 * area * GRAVITY_M_S2
    assert made.weight_n == pytest.approx(weight, rel=1e-12)
    assert made.last.reactions_n.sum(axis=0) == pytest.approx([0, 0, weight], abs=1e-8)
    assert 0 < made.sag_mm < 5
    half = load_sheet(frame, coords, plate, asked)
    assert half.last.coords.tobytes() == made.last.coords.tobytes()


def test_vertices_are_chosen_by_number_place_and_name():
    pattern = quads(3, 2, 30.0, 20.0)
    folded = np.column_stack([pattern.vertices_coords, pattern.vertices_coords[:, 0] / 10])
    numbers = np.arange(12)

    def chosen(*choices):
        found = chosen_vertices(pattern, numbers, folded, np.array([0, 0, -1.0]), choices, "fix")
        return np.flatnonzero(found).tolist()

    assert chosen("left edge") == [0, 4, 8]
    assert chosen("right edge") == chosen("highest") == [3, 7, 11]
    assert chosen("lowest") == [0, 4, 8]
    assert chosen("top edge") == [8, 9, 10, 11]
    assert chosen("bottom edge", 5) == [0, 1, 2, 3, 5]
    assert chosen("corners") == [0, 3, 8, 11]
    assert chosen("border") == [0, 1, 2, 3, 4, 7, 8, 9, 10, 11]
    assert chosen([9.0, 5.0, 21.0, 25.0]) == chosen([21.0, 25.0, 9.0, 5.0]) == [5, 6, 9, 10]
    with pytest.raises(InvalidJob, match="numbered from 0 to 11"):
        chosen(12)
    with pytest.raises(InvalidJob, match=r"no vertex is in this region.*\[0, 0, 30, 20\] mm"):
        chosen([11.0, 1.0, 12.0, 2.0])


def edged(path, places, edges, letters):
    """A pattern file of vertices, edges between them and their letters, its faces found."""
    document = {
        "file_spec": 1.1,
        "frame_unit": "mm",
        "vertices_coords": places,
        "edges_vertices": edges,
        "edges_assignment": list(letters),
    }
    path.write_text(json.dumps(document))
    return read_pattern(path)[0]


def held_places(pattern, *choices):
    """Where a sheet whose cuts are open is held, and whether all copies of a place are."""
    sheet = framework(pattern).sheet
    flat = sheet.pattern.vertices_coords
    folded = np.column_stack([flat, np.zeros(len(flat))])
    down = np.array([0, 0, -1.0])
    found = chosen_vertices(sheet.pattern, sheet.vertices_source, folded, down, choices, "fix")
    held, free = (set(map(tuple, flat[which].tolist())) for which in (found, ~found))
    assert not held & free
    return held


def test_edges_and_border_are_those_of_the_whole_flat_sheet(tmp_path):
    path = tmp_path / "sheet.fold"
    strip = [*((10.0 * k, 0.0) for k in range(5)), *((40.0 - 10 * k, 10.0) for k in range(5))]
    around = [[k, (k + 1) % 10] for k in range(10)]
    cut = edged(path, strip, [*around, [1, 8], [2, 7], [3, 6]], "B" * 10 + "VCV")
    assert held_places(cut, "left edge") == {(0, 0), (0, 10)}
    assert held_places(cut, "right edge") == {(40, 0), (40, 10)}
    assert held_places(cut, "top edge") == set(strip[5:])
    assert held_places(cut, "corners") == {(0, 0), (40, 0), (40, 10), (0, 10)}
    assert held_places(cut, "border") == set(strip)
    one = [(0.0, 0.0), (20.0, 0.0), (20.0, 10.0), (0.0, 10.0)]
    apart = one + [(x + 40, y) for x, y in one]
    rings = [[k, (k + 1) % 4] for k in range(4)]
    pieces = edged(path, apart, rings + [[a + 4, b + 4] for a, b in rings], "B" * 8)
    assert held_places(pieces, "left edge") == {(0, 0), (0, 10)}
    assert held_places(pieces, "right edge") == {(60, 0), (60, 10)}
    assert held_places(pieces, "bottom edge") == {(x, y) for x, y in apart if y == 0}
    assert held_places(pieces, "border") == set(apart)
    assert held_places(pieces, "corners") == {(0, 0), (60, 0), (60, 10), (0, 10)}


def test_a_sheet_that_is_held_on_a_line_or_in_a_point_can_swing():
    strip = quads(8, 2, 80.0, 20.0)

    def held(*choices):
        made = loaded(strip, fixed=list(choices), down=(1.0, 0.0, 0.0))
        return [found.tolist() for _, found in made.swinging]

    assert held("left edge") == [[0, 9, 18]]
    assert held(9) == [[9]]
    assert held(0, 20) == [[0, 20]]
    assert held("left edge", 1) == []
    assert held([0.0, 0.0, 10.0, 20.0]) == []
    assert held("border") == []


def test_a_pull_on_vertices_that_are_all_held_is_refused():
    strip = quads(8, 2, 80.0, 20.0)
    pull = {"at": ["left edge"], "force_n": (0.0, 0.0, 0.1)}
    with pytest.raises(InvalidJob, match=r"loads\.pulls\.0\.at: all vertices .* are held"):
        loaded(strip, fixed=["left edge"], pulls=[pull])
    assert loaded(strip, fixed=[[0.0, 0.0, 10.0, 15.0]], pulls=[pull]).last.settled


def test_pressure_on_a_sheet_that_swings_is_given_up(monkeypatch):
    rests = []

    def counted(*given, **more):
        rests.append(relaxed(*given, **more))
        return rests[-1]

    monkeypatch.setattr(loaded_sheet, "relaxed", counted)
    made = loaded(quads(8, 2, 80.0, 20.0), fixed=["left edge"], weight=False, pressure_pa=3.0)
    assert not made.last.settled
    assert len(rests) < 8  # of 30 rounds and two with softer bars


def test_inner_slits_and_holes_are_no_border(tmp_path):
    path = tmp_path / "sheet.fold"
    outline = [(0.0, 0.0), (30.0, 0.0), (60.0, 0.0), (60.0, 40.0), (30.0, 40.0), (0.0, 40.0)]
    around = [[k, (k + 1) % 6] for k in range(6)]
    slit = [(30.0, 10.0), (30.0, 20.0), (30.0, 30.0)]
    across = [[1, 6], [6, 7], [7, 8], [8, 4]]
    assert held_places(edged(path, outline + slit, around + across, "BBBBBBVCCV"), "border") == set(
        outline
    )
    # slit from the outline
    assert held_places(edged(path, outline + slit, around + across, "BBBBBBCCVV"), "border") == set(
        outline
    )
    square = [(20.0, 10.0), (20.0, 30.0), (40.0, 30.0), (40.0, 10.0)]
    ring = [[6, 7], [7, 8], [8, 9], [9, 6]]
    spokes = [[0, 6], [5, 7], [3, 8], [2, 9]]
    hole = edged(path, outline + square, around + ring + spokes, "B" * 10 + "VMVM")
    assert held_places(hole, "border") == set(outline)
    assert held_places(hole, "left edge") == {(0, 0), (0, 40)}
    assert held_places(hole, [15.0, 5.0, 45.0, 35.0]) == set(square)


def test_a_piece_that_nothing_holds_is_refused():
    first, second = quads(1, 1, 10.0, 10.0), quads(1, 1, 10.0, 10.0)
    both = replace(
        first,
        vertices_coords=np.concatenate(
            [first.vertices_coords, second.vertices_coords + np.array([20, 0])]
        ),
        edges_vertices=np.concatenate([first.edges_vertices, second.edges_vertices + 4]),
        edges_faces=np.concatenate(
            [first.edges_faces, np.where(second.edges_faces >= 0, second.edges_faces + 1, -1)]
        ),
        edges_assignment=np.tile(first.edges_assignment, 2),
        edges_foldAngle=np.tile(first.edges_foldAngle, 2),
        faces_vertices=np.concatenate([first.faces_vertices, second.faces_vertices + 4]),
        faces_offsets=np.array([0, 4, 8]),
    )
    said = r"1 of the 2 pieces.*no vertex of the piece in \[20, 0, 30, 10\] mm.*it would fall"
    for held in (0, "left edge"):
        with pytest.raises(InvalidJob, match=said):
            loaded(both, fixed=[held])
    assert loaded(both, fixed=["left edge", [20.0, 0.0, 20.0, 10.0]]).last.settled
