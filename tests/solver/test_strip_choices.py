"""Strips chosen one by one: they are those of growth, and others are refused with a bound."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from strategies import patches

from solver import (
    ChosenStrip,
    ClosedCurvedFold,
    Crumpled,
    CurvedFold,
    Front,
    InvalidState,
    InvalidValue,
    Miura,
    Side,
    Status,
    StripByStrip,
    TiltedRings,
    developability,
    grown_strips,
    planarity,
)
from solver.arcs import at_share, contain
from solver.growth_order import faces_strip
from solver.strip_choices import free_arcs_of, grown_strip, nearest_arc, proposed_strip
from solver.vectors import angle_between

ANGLES = st.floats(1e-3, 6.28)


def off(mesh):
    """By how much the sheet misses planarity and developability."""
    coords, faces = mesh.vertices_coords, mesh.faces_vertices
    return max(planarity(coords, faces).max(), developability(coords, faces).max())


@pytest.mark.parametrize(
    ("design", "first", "rows"),
    [
        (CurvedFold(columns=20, step=0.1, strips=6), 1, 2),
        (Crumpled(columns=8, strips=7, as_printed=True), 2, 3),
        (ClosedCurvedFold(strips=4), 1, 2),
    ],
)
def test_a_grown_sheet_is_grown_again_by_its_own_strips(design, first, rows):
    """To rounding, which growth itself carries on from strip to strip."""
    mesh = design.grow().mesh
    chosen = tuple(
        ChosenStrip(Side.TOP, strip.flap_angle, tuple(strip.lengths.tolist()))
        for strip in grown_strips(mesh, rows)
    )
    growth = StripByStrip(replace(design, strips=first), chosen).grow()
    assert growth.status is Status.GROWN
    assert growth.strips == design.grow().strips
    np.testing.assert_array_equal(growth.mesh.faces_vertices, mesh.faces_vertices)
    apart = np.abs(growth.mesh.vertices_coords - mesh.vertices_coords).max()
    assert apart < 1e-9 * np.ptp(mesh.vertices_coords)


@given(patches(), st.sampled_from(list(Side)), ANGLES)
def test_a_flap_angle_is_grown_exactly_or_refused_where_faces_cross(mesh, side, flap_angle):
    try:
        front = Front.of(mesh, side)
    except InvalidValue:
        assume(False)
    rays = front.rays(flap_angle)
    short = 0.3 * np.minimum(rays.length_bounds, 0.1)
    crossing = front.self_intersections(rays.flap_angles[:, None]).any()
    strip = ChosenStrip(side, flap_angle, tuple(short.tolist()))
    if not crossing:
        grown = grown_strip(mesh, strip)
        assert len(grown.faces_vertices) == len(mesh.faces_vertices) + len(front.edges_length)
        assert off(grown) < 1e-11
        return
    with pytest.raises(InvalidValue) as refused:
        grown_strip(mesh, strip, "strip 7")
    assert "strip 7" in refused.value.name
    if isinstance(refused.value, InvalidState):
        assert not len(free_arcs_of(front))
    else:
        assert f"{np.degrees(flap_angle):.9g} deg" in str(refused.value)


@given(patches(), st.floats(0.3, 2.8), st.floats(0.3, 2.8))
def test_boundaries_have_the_angles_that_are_chosen(mesh, first, last):
    """So that a strip may be read off any grown sheet, and grown again."""
    front = Front.of(mesh, Side.TOP)
    free = free_arcs_of(front)
    assume(len(free))
    angle = at_share(free, 0.5)
    chosen = ChosenStrip(Side.TOP, angle, 1.0, (first, last))
    short = tuple((0.3 * np.minimum(chosen.rays(front).length_bounds, 0.1)).tolist())
    grown = grown_strip(mesh, replace(chosen, lengths=short))
    assert off(grown) < 1e-8
    coords = grown.vertices_coords[grown.grid]
    new, edges = coords[-1] - coords[-2], front.edges_direction
    assert angle_between(edges[0], new[0]) == pytest.approx(first)
    assert angle_between(-edges[-1], new[-1]) == pytest.approx(last)


@given(patches(), st.integers(0, 2**32 - 1))
def test_a_length_may_be_all_but_its_bound(mesh, seed):
    front = Front.of(mesh, Side.TOP)
    free = free_arcs_of(front)
    assume(len(free))
    random = np.random.default_rng(seed)
    angle = float(random.choice(free.ravel()) + random.normal(0.0, 0.3)) % (2 * np.pi)
    bounds = front.rays(angle).length_bounds
    assume(contain(free, np.array([angle]))[0] and bounds.min() < 1.0)
    i = int(np.argmin(bounds))
    lengths = np.minimum(0.5 * bounds, 0.1)
    lengths[i] = 0.999999 * bounds[i]
    grown_strip(mesh, ChosenStrip(Side.TOP, angle, tuple(lengths.tolist())))
    lengths[i] = bounds[i]
    with pytest.raises(InvalidValue, match="where neighbouring creases meet") as refused:
        grown_strip(mesh, ChosenStrip(Side.TOP, angle, tuple(lengths.tolist())), "strip 2")
    assert refused.value.name == f"length at vertex {i} of strip 2"
    assert f"{bounds[i]:.9g}" in refused.value.bound


@settings(max_examples=15)
@given(patches(), st.lists(st.sampled_from(list(Side)), min_size=1, max_size=3))
def test_proposals_are_grown_on_any_side(mesh, sides):
    for side in sides:
        try:
            strip = proposed_strip(mesh, side)
        except InvalidValue:  # neighbours in line, or no free angle at all
            continue
        front = Front.of(mesh, side)
        assert not front.self_intersections(front.rays(strip.flap_angle).flap_angles[:, None]).any()
        before, mesh = mesh, grown_strip(mesh, strip)
        np.testing.assert_array_equal(
            mesh.vertices_coords[: len(before.vertices_coords)], before.vertices_coords
        )
        assert off(mesh) < 1e-8  # needles, where there is little room


def test_a_miura_sheet_is_proposed_to_go_on_as_it_began():
    whole = Miura(columns=6, rows=5).grow().mesh
    strips = [ChosenStrip(Side.TOP, np.radians(angle), 1.0) for angle in (135.0, 225.0, 135.0)]
    seed = Miura(columns=6, rows=2)
    mesh = StripByStrip(seed, tuple(strips)).grow().mesh
    assert np.abs(mesh.vertices_coords - whole.vertices_coords).max() < 1e-12
    proposed = proposed_strip(mesh, Side.TOP)  # the same again, or its mirror image
    assert abs(np.degrees(proposed.flap_angle) - 180.0) == pytest.approx(45.0)
    assert proposed.lengths == 1.0


@pytest.mark.parametrize("design", [ClosedCurvedFold(strips=2), TiltedRings(strips=4)])
@pytest.mark.parametrize("side", [Side.TOP, Side.BOTTOM])
def test_rings_take_the_flap_angles_at_which_they_close(design, side):
    mesh = design.grow().mesh
    grown = grown_strip(mesh, proposed_strip(mesh, side))
    assert grown.closed
    assert off(grown) < 1e-11
    closings = Front.of(mesh, side).closings()
    if len(closings.flap_angles):
        beside = closings.flap_angles[0] + 1e-4
        with pytest.raises(InvalidValue, match=f"{np.degrees(closings.flap_angles[0]):.6g}"):
            grown_strip(mesh, ChosenStrip(side, beside, 0.01))
    with pytest.raises(InvalidValue, match="top or bottom"):
        proposed_strip(mesh, Side.LEFT)


def test_the_nearest_arc_is_that_of_the_nearest_end():
    free = np.array([[5.5, 0.5], [1.0, 2.0], [3.0, 4.0]])
    assert [nearest_arc(free, angle)[0] for angle in (0.7, 0.8, 2.4, 2.6, 4.7, 4.8)] == [
        *(5.5, 1.0, 1.0, 3.0, 3.0, 5.5)
    ]


def test_a_seed_is_refused_by_its_own_key_and_one_that_stops_is_all_there_is():
    with pytest.raises(InvalidValue) as refused:
        StripByStrip(Miura(columns=1)).grow()
    assert refused.value.name == "seed.columns"
    stops = CurvedFold(columns=10, step=0.2, k=np.radians(183), strips=60, flap_angle=2.6)
    growth = StripByStrip(stops, (ChosenStrip(),)).grow()
    assert growth.status is stops.grow().status is not Status.GROWN
    assert growth.advice.startswith("In the seed: Strip 19")


def test_strips_on_any_side_are_numbered_in_their_order():
    mesh, faces = Miura(columns=4, rows=2).grow().mesh, [4, 8]
    for side in (Side.TOP, Side.RIGHT, Side.BOTTOM, Side.LEFT, Side.RIGHT, Side.TOP):
        mesh = grown_strip(mesh, proposed_strip(mesh, side))
        faces.append(len(mesh.faces_vertices))
    assert np.cumsum(np.bincount(faces_strip(mesh))).tolist() == faces
    assert (np.diff(faces_strip(mesh)) >= 0).all()
