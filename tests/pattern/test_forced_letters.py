"""Letters that follow from others: erased ones come back, none against a flat folding."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from flat_patterns import fan, pattern_of
from helpers import PATTERNS
from hypothesis import given
from hypothesis import strategies as st

from fab import read_pattern
from fab.pattern.crease_pattern import crease_pattern
from fab.pattern.development import develop
from fab.pattern.flat_foldability import balanced_letters, foldable_letters
from fab.pattern.forced_letters import forced_letters, with_letters
from fab.pattern.sectors import sectors_of
from solver import Miura

FLAT_FOLDING = ["bird_base", "crane", "waterbomb", "yoshimura"]


def lettered(pattern, letters, fold_deg=180.0):
    angles = np.where(letters == "V", fold_deg, np.where(letters == "M", -fold_deg, 0.0))
    return replace(pattern, edges_assignment=letters, edges_foldAngle=angles, folded_coords=None)


def erased(pattern, which):
    return lettered(pattern, np.where(which, "U", pattern.edges_assignment))


def folding(pattern):
    return pattern.edges_joining & np.isin(pattern.edges_assignment, ["M", "V"])


def miura():
    mesh = Miura(columns=3, rows=3).grow().mesh
    pattern = crease_pattern(mesh, develop(mesh), 20.0)
    return lettered(pattern, pattern.edges_assignment)


def vertex_letters(letters, turns_deg):
    """A vertex whose creases point in given directions."""
    turns = np.radians(turns_deg)
    rim = 50 * np.column_stack([np.cos(turns), np.sin(turns)])
    count = len(turns)
    faces = [[0, 1 + i, 1 + (i + 1) % count] for i in range(count)]
    base = pattern_of(np.vstack([[0.0, 0.0], rim]), faces)
    out = base.edges_assignment.copy()
    ends = [set(pair) for pair in base.edges_vertices.tolist()]
    spokes = [ends.index({0, 1 + i}) for i in range(count)]
    out[spokes] = list(letters)
    return lettered(base, out), spokes


@pytest.mark.parametrize("name", FLAT_FOLDING)
@given(seed=st.integers(0, 2**32 - 1), share=st.floats(0.02, 1.0))
def test_what_follows_is_what_was_erased(name, seed, share):
    pattern, _ = read_pattern(PATTERNS / f"{name}.fold")
    gone = folding(pattern) & (np.random.default_rng(seed).random(len(folding(pattern))) < share)
    found = forced_letters(erased(pattern, gone))
    assert not len(found.contradictory)
    assert not len(found.open_vertices)
    assert gone[found.edges].all()
    assert (found.letters == pattern.edges_assignment[found.edges]).all()
    assert found.free == gone.sum() - len(found.edges)
    again = forced_letters(with_letters(erased(pattern, gone), found))
    assert (len(again.edges), again.free) == (0, found.free)


@pytest.mark.parametrize("name", FLAT_FOLDING)
def test_one_letter_alone_always_follows(name):
    """From Maekawa's condition at either end; angles come back too."""
    pattern, _ = read_pattern(PATTERNS / f"{name}.fold")
    inside = np.ones(len(pattern.vertices_coords), bool)
    inside[pattern.edges_vertices[pattern.edges_faces[:, 1] < 0]] = False
    creases = np.flatnonzero(folding(pattern) & inside[pattern.edges_vertices].any(axis=1))
    assert len(creases) > 10
    for edge in creases.tolist():
        open_ = erased(pattern, np.arange(len(folding(pattern))) == edge)
        found = forced_letters(open_)
        assert found.edges.tolist() == [edge]
        back = with_letters(open_, found)
        assert (back.edges_assignment == pattern.edges_assignment).all()
        assert (back.edges_foldAngle == pattern.edges_foldAngle).all()


def test_without_letters_nothing_follows():
    """Mountains and valleys can always be exchanged."""
    for name in FLAT_FOLDING:
        pattern, _ = read_pattern(PATTERNS / f"{name}.fold")
        found = forced_letters(erased(pattern, folding(pattern)))
        assert (len(found.edges), found.free) == (0, folding(pattern).sum())


@given(st.integers(0, 2**32 - 1))
def test_what_follows_in_a_miura_holds_in_all_its_foldings(seed):
    """All 4,096 letters of its 12 creases are tried at its four vertices.

    Their number is that of Ginepro and Hull, Counting Miura-ori foldings (2014).
    """
    pattern = miura()
    creases = np.flatnonzero(folding(pattern))
    assert len(creases) == 12
    tried = np.array(list(product([False, True], repeat=12)))
    place = np.full(len(pattern.edges_vertices), -1)
    place[creases] = np.arange(12)
    sectors = sectors_of(pattern, folding(pattern))
    fold = np.ones(len(tried), bool)
    for vertex in np.unique(sectors.vertices):
        ends = np.flatnonzero(sectors.vertices == vertex)
        if len(ends) < 4:
            continue
        found = foldable_letters(sectors.angles[ends][None], 1e-9)[0]
        allowed = {tuple(row) for row in balanced_letters(4)[found].tolist()}
        own = tried[:, place[sectors.edges[ends]]]
        fold &= [tuple(row) in allowed for row in own.tolist()]
    foldings = tried[fold]
    assert len(foldings) == 82  # the colourings of its 9 faces by three colours, over 3
    random = np.random.default_rng(seed)
    right = foldings[random.integers(len(foldings))]
    known = random.random(12) < random.random()
    letters = pattern.edges_assignment.copy()
    letters[creases] = np.where(known, np.where(right, "V", "M"), "U")
    found = forced_letters(lettered(pattern, letters))
    possible = foldings[(foldings[:, known] == right[known]).all(axis=1)]
    assert not len(found.contradictory)
    valleys = possible[:, place[found.edges]]
    assert (valleys == (found.letters == "V")).all()


@pytest.mark.parametrize(
    ("letters", "turns", "forced"),
    [
        ("UVVV", [0, 90, 180, 270], "M"),
        ("UVMU", [0, 90, 180, 270], ""),
        ("UVUU", [0, 70, 120, 230], "M"),  # the smallest sector has both letters
        ("VUUU", [0, 70, 120, 230], "V"),
        ("UVMU", [0, 70, 120, 230], ""),
        ("UUMU", [0, 70, 120, 230], "V"),
        ("UM", [30, 210], "M"),  # a crease that runs through
    ],
)
def test_what_follows_at_one_vertex(letters, turns, forced):
    pattern, spokes = vertex_letters(letters, turns)
    found = forced_letters(pattern)
    assert "".join(found.letters) == forced
    assert not len(found.contradictory)
    assert {letters[spokes.index(edge)] for edge in found.edges} <= {"U"}


@pytest.mark.parametrize(
    ("letters", "turns", "contradictory", "open_vertices"),
    [
        ("VVMMUU", [0, 60, 120, 180, 240, 300], 0, 0),
        ("VVUU", [0, 90, 180, 270], 0, 0),
        ("MMMU", [0, 70, 120, 230], 1, 0),  # both sides of the smallest sector are mountains
        ("UUMU", [0, 70, 121, 230], 0, 1),
        ("UUM", [0, 120, 240], 0, 1),
        ("UUMUU", [0, 72, 144, 216, 288], 0, 1),
    ],
)
def test_vertices_that_do_not_fold_flat_say_nothing(letters, turns, contradictory, open_vertices):
    pattern, _ = vertex_letters(letters, turns)
    found = forced_letters(pattern)
    assert len(found.contradictory) == contradictory
    assert len(found.open_vertices) == open_vertices
    if contradictory or open_vertices:
        assert not len(found.edges)


def test_creases_of_other_angles_say_nothing():
    pattern, _ = vertex_letters("UVVV", [0, 90, 180, 270])
    assert len(forced_letters(pattern).edges) == 1
    half = replace(pattern, edges_foldAngle=pattern.edges_foldAngle / 2)
    assert len(forced_letters(half).edges) == 0
    found = forced_letters(half, 90.0)
    assert len(found.edges) == 1
    assert with_letters(half, found, 90.0).edges_foldAngle[found.edges].tolist() == [-90.0]


def test_a_contradiction_between_vertices_ends_there():
    """Two vertices that need the crease between them with different letters: neither is heard."""
    coords = [[0, 0], [10, 0], [-10, 10], [0, 10], [10, 10], [20, 10], [0, 20], [10, 20]]
    faces = [[0, 1, 4, 3], [0, 3, 2], [2, 3, 6], [3, 4, 7, 6], [4, 1, 5], [4, 5, 7]]
    base = pattern_of(coords, faces)
    edges = [tuple(sorted(pair)) for pair in base.edges_vertices.tolist()]

    def found(**given):
        letters = base.edges_assignment.copy()
        for pair, letter in zip(
            [(0, 3), (2, 3), (3, 6), (3, 4), (1, 4), (4, 5), (4, 7)], given["of"], strict=True
        ):
            letters[edges.index(pair)] = letter
        return forced_letters(lettered(base, letters))

    assert "".join(found(of="VVVUVVV").letters) == "M"
    assert "".join(found(of="VVVUMMU").letters) == "MV"
    against = found(of="VVVUMMM")
    assert against.contradictory.tolist() == [3, 4]
    assert len(against.edges) == 0


@pytest.mark.parametrize(
    ("letters", "forced"),
    [
        ("V" * 8 + "M" * 5 + "U", "M"),
        ("V" * 6 + "M" * 7 + "U", "M"),
        ("V" * 6 + "M" * 6 + "UU", ""),
        ("V" * 8 + "M" * 4 + "UU", "MM"),
        ("V" * 7 + "M" * 5 + "UU", ""),
    ],
)
def test_vertices_of_many_creases_obey_maekawa(letters, forced):
    """14 creases, so that 6 or 8 are valleys."""
    pattern, _ = vertex_letters(letters, np.arange(14) * 360 / 14)
    found = "".join(forced_letters(pattern).letters)
    assert found == forced


def test_maekawa_alone_agrees_with_all_letters_where_sectors_are_equal():
    """The general rule for many creases, against the list for six equal sectors."""
    from fab.pattern.forced_letters import _Vertices

    hexagon = fan(6, 50.0)
    listed = foldable_letters(np.full((1, 6), np.pi / 3), 1e-9)
    creases = np.arange(6)[None]
    assert len(hexagon.edges_vertices) == 12
    for may in product([(True, False), (False, True), (True, True)], repeat=6):
        own = np.array(may).T
        exact = _Vertices(np.zeros(1, int), creases, listed).choices(own)
        alone = _Vertices(np.zeros(1, int), creases, None).choices(own)
        assert (exact == alone).all()
