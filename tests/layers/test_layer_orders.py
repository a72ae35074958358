from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from flat_patterns import grid
from folded_strips import (
    brute_force_orders,
    brute_force_triangles,
    chosen_order,
    lettered,
    strip,
    triangle_strip,
    twist,
    vertex,
)
from hypothesis import given, settings
from hypothesis import strategies as st

from fab import read_pattern
from fab.layers import layer_orders as module
from fab.layers import satisfaction, solution
from fab.layers.flat_form import flat_form, folds_flat
from fab.layers.layer_findings import inspect_layers
from fab.layers.layer_orders import FoldsFlat, layer_orders
from fab.pattern.crease_pattern import crease_pattern
from fab.pattern.development import develop
from solver import Miura

PATTERNS = Path(__file__).parents[1] / "patterns"


def folded(pattern, letters="U"):
    """A pattern with letters for all its creases, or for each, folded by 180 degrees."""
    inner = pattern.edges_assignment != "B"
    every = np.full(len(inner), "B")
    every[inner] = list(letters) if len(letters) > 1 else letters
    sign = np.where(every == "V", 180.0, np.where(every == "M", -180.0, 0.0))
    return replace(pattern, edges_assignment=every, edges_foldAngle=sign)


def folded_by_letters(pattern):
    """A pattern of any angles, each of its mountains and valleys folded by 180 degrees."""
    sign = np.where(pattern.edges_assignment == "V", 180.0, 0.0)
    sign[pattern.edges_assignment == "M"] = -180.0
    return replace(pattern, edges_foldAngle=sign, folded_coords=None)


def square_map(columns, rows):
    return grid(columns, rows, 10.0)


def states(pattern) -> int:
    found = layer_orders(pattern, seconds=600)
    assert found is not None
    assert found.states_exact
    assert (found.folds_flat is FoldsFlat.YES) == bool(found.states)
    return found.states


# OEIS A000136: strips of stamps; A001415: maps of 2 x n; A001418: n x n.
@pytest.mark.parametrize(
    ("columns", "rows", "orders"),
    [
        *[(n, 1, count) for n, count in ((2, 2), (3, 6), (4, 16), (5, 50), (6, 144), (7, 462))],
        *[(n, 2, count) for n, count in ((2, 8), (3, 60), (4, 320))],
        (3, 3, 1368),
    ],
)
def test_maps_have_as_many_orders_as_are_known(columns, rows, orders):
    assert states(folded(square_map(columns, rows))) == orders


@pytest.mark.parametrize(("columns", "rows", "orders"), [(3, 1, 6), (5, 1, 50), (2, 2, 8)])
def test_letters_divide_the_orders_of_a_map(columns, rows, orders):
    plain = square_map(columns, rows)
    count = int((plain.edges_assignment != "B").sum())
    found = [states(folded(plain, letters)) for letters in product("MV", repeat=count)]
    assert sum(found) == orders
    assert found == found[::-1]  # the sheet turned over


def test_a_miura_folds_flat_in_one_order():
    mesh = Miura(columns=5, rows=4).grow().mesh
    pattern = crease_pattern(mesh, develop(mesh), 10.0)
    flat = replace(pattern, edges_foldAngle=180.0 * np.sign(pattern.edges_foldAngle))
    found = layer_orders(flat)
    assert (found.states, found.states_exact) == (1, True)
    assert len(found.orders) == found.overlaps > 100


strips = st.lists(st.integers(1, 3), min_size=2, max_size=7).flatmap(
    lambda sizes: st.tuples(
        st.just(sizes),
        st.lists(st.sampled_from("MVU"), min_size=len(sizes) - 1, max_size=len(sizes) - 1),
    )
)


@given(strips)
@settings(max_examples=40, deadline=None)
def test_orders_of_strips_are_those_of_brute_force(drawn):
    sizes, letters = drawn
    expected = brute_force_orders(sizes, letters, closed=False)
    pattern = strip(sizes, letters)
    assert states(pattern) == len(expected)
    if expected:
        turned = flat_form(pattern).faces_turned
        assert chosen_order(layer_orders(pattern).orders, turned ^ turned[0]) in expected


@st.composite
def vertices(draw):
    """Sectors in degrees of a vertex that Kawasaki's condition lets fold, and letters."""
    degree = draw(st.sampled_from([4, 6]))
    halves = [
        draw(st.lists(st.integers(1, 6), min_size=degree // 2, max_size=degree // 2))
        for _ in range(2)
    ]
    total = [sum(half) for half in halves]
    sizes = [0] * degree
    sizes[::2] = [each * total[1] for each in halves[0]]
    sizes[1::2] = [each * total[0] for each in halves[1]]
    letters = draw(st.lists(st.sampled_from("MVU"), min_size=degree, max_size=degree))
    return sizes, letters


@given(vertices())
@settings(max_examples=25, deadline=None)
def test_orders_of_single_vertices_are_those_of_brute_force(drawn):
    sizes, letters = drawn
    angles = 360.0 * np.array(sizes) / sum(sizes)
    expected = brute_force_orders(sizes, letters, closed=True)
    assert states(vertex(angles, letters)) == len(expected)


# 2 C(2n, n - 1) for 2n equal sectors.
@pytest.mark.parametrize(
    ("sectors", "assignments"),
    [
        *[([90] * 4, 8), ([60, 60, 120, 120], 6), ([40, 60, 140, 120], 4)],
        *[([60] * 6, 30), ([45] * 8, 112)],
    ],
)
def test_vertices_fold_with_as_many_letters_as_hull_counts(sectors, assignments):
    """T. Hull, The combinatorics of flat folds: a survey (2002)."""
    every = product("MV", repeat=len(sectors))
    found = [states(vertex(sectors, letters)) for letters in every]
    assert sum(count > 0 for count in found) == assignments


@pytest.mark.parametrize(("angle_deg", "alike"), [(25.0, 1), (29.9, 1), (30.1, 0), (45.0, 0)])
def test_pleats_of_a_steep_triangle_fold_unless_all_turn_alike(angle_deg, alike):
    """The clause of M. Bern and B. Hayes, The complexity of flat origami (1996)."""
    for turns in product((1, -1), repeat=3):
        expected = alike if len(set(turns)) == 1 else 1
        assert states(twist(3, angle_deg, turns)) == expected
    assert states(twist(3, angle_deg, None)) == 6 + 2 * alike


box_pleats = st.lists(st.integers(0, 2), min_size=1, max_size=6).flatmap(
    lambda places: st.tuples(
        st.just(places),
        st.lists(st.sampled_from("MVUU"), min_size=len(places), max_size=len(places)),
    )
)


@given(box_pleats)
@settings(max_examples=40, deadline=None)
def test_orders_of_strips_of_a_box_pleat_are_those_of_brute_force(drawn):
    places, letters = drawn
    places = [p for p, q in zip(places, [-1, *places], strict=False) if p != q]
    letters = letters[: len(places)]
    pattern = triangle_strip(places, letters)
    assert states(pattern) == brute_force_triangles(places, letters)


def test_flaps_that_both_cover_the_other_crease_cannot_lie_flat():
    found = layer_orders(strip([3, 1, 3], "VV"))
    assert found.folds_flat is FoldsFlat.NO
    assert (found.states, found.faces) == (0, (0, 1, 2))
    assert not len(found.orders)
    (finding,) = inspect_layers(found)
    assert (finding.code, finding.severity, finding.panels) == (
        "cannot-lie-flat",
        "error",
        (0, 1, 2),
    )
    assert "faces 0, 1 and 2 alone" in finding.text
    assert found.text() == "folds flat: no, because of faces 0, 1 and 2"
    # creases without letters may fold or not: no error
    free = layer_orders(strip([3, 1, 3, 1], "VVU"))
    assert (free.folds_flat, free.assumed) == (FoldsFlat.NO, 1)
    (finding,) = inspect_layers(free)
    assert finding.severity == "warning"
    assert "1 crease of unknown angle" in finding.text
    # a part of a longer strip, and no other face, is to blame
    longer = layer_orders(strip([2, 2, 2, 2, 3, 1, 3, 2], "MVMVVVM"))
    assert set(longer.faces) <= {3, 4, 5, 6}
    assert len(longer.faces) == 3


def test_each_face_that_is_blamed_is_needed():
    rng = np.random.default_rng(5)
    blamed = 0
    for _ in range(30):
        sizes = rng.integers(1, 4, 6).tolist()
        letters = rng.choice(["M", "V"], 5).tolist()
        found = layer_orders(strip(sizes, letters))
        if found.folds_flat is FoldsFlat.YES:
            continue
        first, last = min(found.faces), max(found.faces)
        # those between are there as well: they hold the others together
        part = strip(sizes[first : last + 1], letters[first:last])
        assert layer_orders(part).folds_flat is FoldsFlat.NO
        blamed += 1
    assert blamed > 5


def test_pieces_and_faces_joined_by_flat_creases_are_ordered_by_themselves():
    coords = [[x, y] for y in (0.0, 5.0) for x in (0.0, 10.0, 20.0, 30.0)]
    row = [[i, i + 1, i + 5, i + 4] for i in range(3)]
    both = [*coords, *[[x, y + 20.0] for x, y in coords]]
    two = lettered(both, [*row, *[[v + 8 for v in face] for face in row]], "UUUU")
    assert states(two) == 36
    assert layer_orders(two).parts == (6, 6)
    # a crease that does not fold joins the first two squares: one fold is left
    plain = lettered(coords, row, "FV")
    found = layer_orders(plain)
    assert found.states == 1
    assert found.orders[:, :2].tolist() == [[1, 2]]
    wide = layer_orders(lettered([[2 * x, y] for x, y in coords], row, "VF"))
    assert wide.orders[:, :2].tolist() == [[0, 1]]


def test_patterns_that_do_not_fold_flat_have_no_layers():
    assert layer_orders(grid(3, 3, 10.0)) is None  # right angles
    assert layer_orders(vertex([90, 90, 100, 80], "VVVM")) is None  # misses Kawasaki's condition
    assert not folds_flat(folded(grid(2, 1, 10.0), "F"))


def test_given_orders_are_taken_where_a_sheet_can_have_them():
    pattern = folded(square_map(4, 1))
    first = layer_orders(pattern)
    other = first.orders * [1, 1, -1]
    assert layer_orders(pattern, other).orders.tolist() == other.tolist()
    assert layer_orders(pattern, other).given is True
    # both flaps on one side of the middle one: each covers the crease of the other
    both = [[0, 1, 1], [2, 1, 1]]
    assert layer_orders(strip([2, 3, 2], "UU"), np.array(both)).given is True
    assert layer_orders(strip([3, 2, 3], "UU"), np.array(both[:1])).given is True
    assert layer_orders(strip([3, 2, 3], "UU"), np.array(both)).given is False
    wrong = layer_orders(strip([3, 3], "V"), np.array([[0, 1, -1]]))
    assert (wrong.given, wrong.given_faces) == (False, (0, 1))
    (finding,) = inspect_layers(wrong)
    assert (finding.code, finding.panels) == ("face-orders-contradict", (0, 1))


def test_what_takes_too_long_is_undecided():
    found = layer_orders(folded(square_map(3, 3)), seconds=0.0)
    assert found.folds_flat is FoldsFlat.UNDECIDED
    assert found.states is None
    assert "within 0 s" in found.text()
    (finding,) = inspect_layers(found)
    assert (finding.code, finding.severity) == ("layers-undecided", "warning")


def test_without_the_library_layers_are_undecided(monkeypatch):
    def missing(*_):
        raise ImportError("pysat")

    monkeypatch.setattr(satisfaction, "SatSolver", missing)
    found = layer_orders(folded(square_map(3, 1)))
    assert found.folds_flat is FoldsFlat.UNDECIDED
    assert "pip install python-sat" in found.reason


def test_too_many_triples_are_taken_one_after_another(monkeypatch):
    """What holds of all triples is found from those that solutions violate."""
    maps = [folded(square_map(4, 2)), *[strip([3, 1, 3, 2], letters) for letters in ("VVM", "VMV")]]
    every = [layer_orders(pattern).folds_flat for pattern in maps]
    assert len(set(every)) == 2
    monkeypatch.setattr(solution, "_MOST_TRIPLES", -1)
    again = [layer_orders(pattern) for pattern in maps]
    assert [each.folds_flat for each in again] == every
    assert [each.states_exact for each in again if each.states] == [False] * sum(
        each == "yes" for each in every
    )
    pattern = maps[0]
    monkeypatch.undo()
    assert layer_orders(pattern, again[0].orders).given is True


def test_where_counting_ends_a_lower_bound_is_given(monkeypatch):
    monkeypatch.setattr(solution, "_WORK", 100)
    monkeypatch.setattr(solution, "_WRITTEN", 50)
    found = layer_orders(folded(square_map(3, 3)))
    assert (found.states, found.states_exact) == (50, False)
    assert found.text().startswith("folds flat: yes, its layers have at least 50 orders")


def test_vertices_that_are_off_leave_layers_undecided_or_right(monkeypatch):
    """Noise that closes moves no layers; edges that miss each other by more are not guessed."""
    rng = np.random.default_rng(2)
    pattern = folded(square_map(3, 2))
    for noise in (1e-9, 1e-7):
        coords = pattern.vertices_coords + rng.normal(0, noise, pattern.vertices_coords.shape)
        found = layer_orders(replace(pattern, vertices_coords=coords))
        assert found.folds_flat is FoldsFlat.UNDECIDED or found.states == 60
    monkeypatch.setattr(module, "_REACHES", ())
    assert "not exact enough" in layer_orders(pattern).reason


@pytest.mark.parametrize(
    ("name", "orders"), [("bird_base", 16), ("crane", 5), ("waterbomb", 1), ("yoshimura", 0)]
)
def test_coordinates_of_few_digits_change_no_answer(name, orders):
    """Rounded to 1e-5 of the sheet, as drawing programs write them: no sliver stays."""
    pattern = folded_by_letters(read_pattern(PATTERNS / f"{name}.fold")[0])
    size = np.hypot(*np.ptp(pattern.vertices_coords, axis=0))
    for digits in (1e-6, 1e-5):
        coords = np.round(pattern.vertices_coords / (digits * size)) * digits * size
        assert states(replace(pattern, vertices_coords=coords)) == orders


def test_the_same_pattern_has_the_same_order_every_time():
    pattern = folded(square_map(3, 3))
    first, second = layer_orders(pattern), layer_orders(pattern)
    assert first.orders.tobytes() == second.orders.tobytes()
    assert first.report() == second.report()
