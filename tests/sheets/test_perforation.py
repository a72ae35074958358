"""Dashes on whole patterns: on their creases, outside all margins, nothing covered twice."""

import re

import numpy as np
import pytest
import shapely
from flat_patterns import fan, grid, pattern_of, triangles
from hypothesis import given, settings
from hypothesis import strategies as st

from fab.drawings.cut_paths import Operation
from fab.errors import Severity
from fab.pattern.crease_pattern import crease_pattern
from fab.pattern.development import develop
from fab.sheets.crease_cuts import cuts_along
from fab.sheets.crease_styles import (
    DashDotStyle,
    DashStyle,
    DotStyle,
    EngraveStyle,
    LatticeStyle,
    NoStyle,
    ScoreStyle,
)
from fab.sheets.perforation import cut_layers, perforate
from fab.sheets.perforation_settings import FoldBand, PerforationSettings
from fab.sheets.relief_holes import ReliefSettings
from solver import InvalidValue, Miura

sizes = st.floats(0.05, 20.0)


@given(st.floats(0.01, 300.0), sizes, sizes, st.floats(0.0, 5.0), st.floats(0, 6.28))
def test_dashes_of_a_crease(length, cut, gap, margin, turn):
    direction = np.array([np.cos(turn), np.sin(turn)])
    ends = np.array([[[3.0, -2.0], [3.0, -2.0] + length * direction]])
    cuts_ = cuts_along(ends, DashStyle(cut_mm=cut, gap_mm=gap), margin)
    segments, owner = cuts_.segments, cuts_.owner
    span = np.linalg.norm(ends[0, 1] - ends[0, 0])
    if span - 2 * margin <= 0.0100001:
        assert len(segments) == 0 or span - 2 * margin > 0.01
        return
    along = (segments - ends[0, 0]) @ direction
    across = (segments - ends[0, 0]) @ [-direction[1], direction[0]]
    assert np.abs(across).max() < 1e-9
    assert along.min() >= margin - 1e-9
    if len(along) > 1:
        assert along.ravel()[0] == pytest.approx(margin, abs=1e-9)
        assert along.ravel()[-1] == pytest.approx(span - margin, abs=1e-9)
    else:
        assert along[0, 1] - along[0, 0] <= cut + 1e-9
    assert (np.diff(along.ravel()) > 0).all()
    assert along.ravel() + along.ravel()[::-1] == pytest.approx(span, abs=1e-8)
    cuts = along[:, 1] - along[:, 0]
    gaps = along[1:, 0] - along[:-1, 1]
    assert np.ptp(cuts) < 1e-8
    if len(gaps):
        assert gaps / cuts[0] == pytest.approx(gap / cut, rel=1e-6)
        # fitted by at most half a period
        assert len(cuts) == pytest.approx((span - 2 * margin + gap) / (cut + gap), abs=0.5 + 1e-9)
    assert (owner == 0).all()


def test_dashes_of_many_creases_are_those_of_each():
    random = np.random.default_rng(0)
    ends = random.uniform(0, 50, (40, 2, 2))
    style = DashStyle(cut_mm=2.0, gap_mm=0.7)
    cuts = cuts_along(ends, style, 0.4)
    for i in range(40):
        alone = cuts_along(ends[i : i + 1], style, 0.4)
        assert cuts.segments[cuts.owner == i] == pytest.approx(alone.segments, abs=1e-12)


def test_a_pattern_is_cut_by_assignment_and_its_outline_is_closed_once():
    mesh = Miura(columns=4, rows=3).grow().mesh
    pattern = crease_pattern(mesh, develop(mesh), 20.0)
    paths, findings = perforate(pattern, PerforationSettings())
    assert findings == []
    mountain, valley, cut = paths.layers
    assert [layer.operation for layer in paths.layers] == [
        Operation.MOUNTAIN,
        Operation.VALLEY,
        Operation.CUT,
    ]
    assert len(cut.segments) == 0
    (outline,) = cut.outlines
    assert len(outline) == 14
    x, y = outline.T
    area = np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) / 2
    assert area == pytest.approx(12 * 400 * np.sin(np.radians(60)), rel=1e-12)
    assert paths.size_mm == pytest.approx(pattern.vertices_coords.max(axis=0).tolist())
    for layer, letter in ((mountain, "M"), (valley, "V")):
        lines = pattern.vertices_coords[pattern.edges_vertices[pattern.edges_assignment == letter]]
        middles = layer.segments.mean(axis=1)
        a, b = lines[None, :, 0], lines[None, :, 1]
        off = (
            np.abs(
                np.linalg.det(
                    np.stack(
                        [
                            np.broadcast_to(b - a, (len(middles), len(lines), 2)),
                            middles[:, None] - a,
                        ],
                        axis=-2,
                    )
                )
            )
            / 20
        )
        assert off.min(axis=1).max() < 1e-9


def test_creases_too_short_for_their_margins_are_named():
    mesh = Miura(columns=4, rows=3).grow().mesh
    pattern = crease_pattern(mesh, develop(mesh), 20.0)
    paths, findings = perforate(pattern, PerforationSettings(margin_mm=10.0))
    assert [(f.code, f.severity) for f in findings] == [("crease-too-short", Severity.ERROR)]
    counts = pattern.counts()
    counted = f"{counts['M']} of {counts['M']} mountain and {counts['V']} of {counts['V']} valley"
    assert findings[0].text.startswith(counted)
    folded = np.isin(pattern.edges_assignment, ["M", "V"])
    assert findings[0].creases == tuple(np.flatnonzero(folded).tolist())
    assert all(len(layer.segments) == 0 for layer in paths.layers)


LATTICE = LatticeStyle(cut_mm=4.0, gap_mm=1.0, rows=3, pitch_mm=0.8)
WIDE = {"cut_mm": 6.0, "gap_mm": 2.0, "rows": 6, "pitch_mm": 1.5}
STYLES = [
    ScoreStyle(),
    DashStyle(cut_mm=2.0, gap_mm=1.0),
    DashDotStyle(cut_mm=2.0, dot_mm=0.5, gap_mm=0.7),
    DotStyle(dot_mm=0.3, pitch_mm=1.5),
    LATTICE,
    EngraveStyle(),
]


def folded_patterns():
    mesh = Miura(columns=4, rows=3).grow().mesh
    turn = np.arange(6) * np.pi / 3
    ring = 30 * np.column_stack([np.cos(turn), np.sin(turn)])
    hexagons = np.vstack([ring, ring[[4, 5, 0, 1]] + [30 * 1.5, 30 * np.sqrt(0.75)]])
    return {
        "miura": crease_pattern(mesh, develop(mesh), 20.0),
        "triangles": triangles(3),
        "n-gons": pattern_of(hexagons, [[0, 1, 2, 3, 4, 5], [1, 0, 8, 9]]),
        "pieces": grid(5, 4, 15.0, [(2, 0), (2, 1), (2, 2), (2, 3)]),
        "holes and cuts": grid(5, 4, 15.0, [(1, 1), (2, 2)], [(20, 21), (21, 22), (15, 21)]),
        "fan": fan(11, 40.0),
    }


def assert_sound(pattern, layers, findings, settings, kerf):
    """Cuts lie on creases, outside all margins, meet nothing, and nothing is covered twice."""
    of = {layer.operation: layer for layer in layers}
    segments = np.concatenate(
        [layer.segments for layer in layers if layer.operation is not Operation.CUT]
    )
    if not len(segments):
        return 0
    crease = (pattern.edges_faces[:, 1] >= 0) & np.isin(
        pattern.edges_assignment, ["M", "V", "F", "U"]
    )
    creases = shapely.linestrings(pattern.vertices_coords[pattern.edges_vertices[crease]])
    off = shapely.distance(shapely.union_all(creases), shapely.points(segments.mean(axis=1)))
    styles = (settings.mountain, settings.valley, settings.flat, settings.unassigned)
    widths = [style.width_mm / 2 for style in styles if isinstance(style, LatticeStyle)]
    assert off.max() <= max(widths, default=0.0) + 1e-9
    # the beam widens what is drawn; pierces reach out by their finding's word
    cuts = shapely.linestrings(segments)
    used = pattern.vertices_coords[np.unique(pattern.faces_vertices)]
    near = shapely.distance(shapely.multipoints(used), cuts).min()
    pierced = "cut-shorter-than-kerf" in {finding.code for finding in findings}
    assert near >= settings.margin_mm - (kerf / 2 if pierced else -kerf / 2) - 1e-9
    rings = [ring for layer in layers for ring in layer.outlines]
    sides = [np.stack([ring, np.roll(ring, -1, axis=0)], axis=1) for ring in rings]
    every = shapely.linestrings(np.concatenate([segments, of[Operation.CUT].segments, *sides]))
    union = shapely.length(shapely.union_all(every))
    assert shapely.length(every).sum() == pytest.approx(union, rel=1e-9)
    first, second = shapely.STRtree(every).query(cuts, predicate="intersects")
    assert (first == second).all()
    if Operation.RELIEF in of:
        holes = shapely.union_all([shapely.Polygon(r) for r in of[Operation.RELIEF].outlines])
        least = settings.margin_mm - (kerf / 2 if pierced else 0.0)
        assert shapely.distance(holes, cuts).min() >= least - 1e-9
    return len(segments)


@pytest.mark.parametrize("kerf", [0.0, 0.2])
@pytest.mark.parametrize("relief", [None, ReliefSettings(web_mm=1.5)])
@pytest.mark.parametrize("style", STYLES, ids=lambda style: style.kind)
def test_cuts_lie_on_creases_outside_all_margins_and_cover_nothing_twice(style, relief, kerf):
    chosen = PerforationSettings(
        mountain=style, valley=style, flat=style, unassigned=style, margin_mm=0.6, relief=relief
    )
    for name, pattern in folded_patterns().items():
        layers, findings = cut_layers(pattern, chosen, kerf)
        assert assert_sound(pattern, layers, findings, chosen, kerf) > 0, name


@settings(max_examples=60)
@given(st.data(), st.integers(0, 10_000), st.floats(0.1, 1.5), st.floats(0.0, 0.4))
def test_mixed_styles_never_meet(data, seed, margin, kerf):
    mixed = st.sampled_from([*STYLES, NoStyle(), LatticeStyle(**WIDE)])
    relief = st.sampled_from([None, ReliefSettings(web_mm=2.0, shape="polygon")])
    chosen = PerforationSettings(
        mountain=data.draw(mixed),
        valley=data.draw(mixed),
        flat=data.draw(mixed),
        unassigned=data.draw(mixed),
        margin_mm=margin,
        relief=data.draw(relief),
    )
    pattern = triangles(seed, 25)
    layers, findings = cut_layers(pattern, chosen, kerf)
    assert_sound(pattern, layers, findings, chosen, kerf)


def test_the_total_cut_length_follows_the_ratio():
    pattern = triangles(1, 60, 800.0)
    style = DashStyle(cut_mm=2.0, gap_mm=1.0)
    settings = PerforationSettings(mountain=style, valley=ScoreStyle(), margin_mm=0.5)
    paths, _ = perforate(pattern, settings)
    ends = pattern.vertices_coords[pattern.edges_vertices]
    length = np.hypot(*(ends[:, 1] - ends[:, 0]).T) - 1.0
    drawn = [
        np.hypot(*(layer.segments[:, 1] - layer.segments[:, 0]).T).sum() for layer in paths.layers
    ]
    letters = pattern.edges_assignment
    of = dict(zip([layer.operation for layer in paths.layers], drawn, strict=True))
    assert of[Operation.VALLEY] == pytest.approx(length[letters == "V"].sum())
    assert of[Operation.ENGRAVE] == pytest.approx(length[letters == "U"].sum())
    mountains = letters == "M"
    wanted = 2 / 3 * length[mountains].sum()
    assert abs(of[Operation.MOUNTAIN] - wanted) <= 3.0 * 1.5 * mountains.sum()
    assert of[Operation.MOUNTAIN] > wanted  # each crease begins and ends with a cut


def test_styles_by_fold_angle():
    pattern = fan(8, 40.0, "V")
    angle = np.where(pattern.edges_faces[:, 1] >= 0, 0.0, 0.0)
    shared = np.flatnonzero(pattern.edges_faces[:, 1] >= 0)
    angle[shared] = [0.0, 10.0, 29.999, 30.0, 90.0, 120.0, 179.0, 180.0]
    arrays = {name: getattr(pattern, name) for name in pattern.__dataclass_fields__}
    pattern = type(pattern)(**{**arrays, "edges_foldAngle": angle})
    bands = [
        FoldBand(from_deg=120, to_deg=180, valley=NoStyle()),
        FoldBand(from_deg=0, to_deg=30, mountain=NoStyle(), valley=EngraveStyle()),
    ]
    settings = PerforationSettings(valley=ScoreStyle(), bands=bands)
    layers, findings = cut_layers(pattern, settings)
    assert findings == []
    assert [(layer.operation, len(layer.segments)) for layer in layers] == [
        (Operation.ENGRAVE, 3),
        (Operation.MOUNTAIN, 0),
        (Operation.VALLEY, 2),
        (Operation.CUT, 0),
    ]


def test_edges_with_one_face_are_outlines_whatever_their_assignment():
    pattern = grid(2, 1, 20.0)
    letters = np.full(len(pattern.edges_vertices), "M")
    arrays = {name: getattr(pattern, name) for name in pattern.__dataclass_fields__}
    layers, _ = cut_layers(
        type(pattern)(**{**arrays, "edges_assignment": letters}),
        PerforationSettings(mountain=ScoreStyle()),
    )
    assert len(layers[0].segments) == 1
    assert len(layers[-1].outlines) == 1


def test_unknown_assignments_are_refused():
    pattern = pattern_of([[0, 0], [9, 0], [9, 9], [0, 9]], [[0, 1, 2], [0, 2, 3]], "X")
    with pytest.raises(InvalidValue, match=r"assignment of edge \d = 'X' .* M, V, F, U, B, C, J"):
        cut_layers(pattern, PerforationSettings())


@pytest.mark.parametrize("kerf", [-0.2, float("nan")])
def test_a_bad_kerf_is_refused(kerf):
    with pytest.raises(InvalidValue, match="kerf_mm"):
        cut_layers(grid(2, 1, 20.0), PerforationSettings(), kerf)


def test_cuts_shorter_than_the_kerf_are_named():
    settings = PerforationSettings(valley=DotStyle(dot_mm=0.15, pitch_mm=2.0))
    layers, (finding,) = cut_layers(grid(2, 1, 20.0), settings, 0.2)
    assert finding.code == "cut-shorter-than-kerf"
    assert len(finding.creases) == 1
    assert re.match(r"\d+ cuts on 1 crease are not longer than the kerf \(0\.2 mm\)", finding.text)
    segments = layers[1].segments
    assert np.hypot(*(segments[:, 1] - segments[:, 0]).T) == pytest.approx(0.01)
    _, findings = cut_layers(grid(2, 1, 20.0), settings, 0.1)
    assert findings == []


def test_a_sheet_anywhere_is_moved_to_the_origin_with_its_kerf():
    pattern = grid(3, 2, 20.0)
    arrays = {name: getattr(pattern, name) for name in pattern.__dataclass_fields__}
    moved = {**arrays, "vertices_coords": pattern.vertices_coords - [400.0, 7.0]}
    paths, _ = perforate(type(pattern)(**moved), PerforationSettings(), 0.2)
    assert paths.size_mm == pytest.approx((60.2, 40.2))
    (ring,) = paths.layers[-1].outlines
    assert ring.min(axis=0) == pytest.approx([0.0, 0.0])
    assert ring.max(axis=0) == pytest.approx(paths.size_mm)


def test_lattices_begin_where_they_clear_the_bisector():
    """At a right angle a band of half width h begins h cot 45 = h after the vertex."""
    pattern = grid(2, 2, 60.0)
    layers, findings = cut_layers(pattern, PerforationSettings(valley=LATTICE, margin_mm=0.5))
    assert findings == []
    centre = layers[1].segments - [60.0, 60.0]
    right = centre[(centre[..., 0] > 0).all(axis=1) & (np.abs(centre[..., 1]) < 1).all(axis=1)]
    assert right[..., 0].min() == pytest.approx(0.8 + 0.5)
    # at the outline, which is square to it, only the margin is left
    assert right[..., 0].max() == pytest.approx(60.0 - 0.5)


def test_lattices_too_wide_for_their_faces_are_left_out_and_named():
    wide = LatticeStyle(cut_mm=4.0, gap_mm=1.0, rows=12, pitch_mm=1.0)
    pattern = grid(12, 1, 10.0)
    layers, findings = cut_layers(pattern, PerforationSettings(valley=wide, margin_mm=0.1))
    assert [f.code for f in findings] == ["lattices-meet"]
    assert findings[0].severity == Severity.ERROR
    assert set(findings[0].creases) == set(np.flatnonzero(pattern.edges_assignment == "V").tolist())
    assert len(layers[1].segments) == 0
    # a row less each side, and they fit
    fits = LatticeStyle(cut_mm=4.0, gap_mm=1.0, rows=10, pitch_mm=1.0)
    layers, findings = cut_layers(pattern, PerforationSettings(valley=fits, margin_mm=0.1))
    assert findings == []
    assert len(layers[1].segments) > 0


def test_a_single_crease_is_named_in_the_singular():
    pattern = grid(2, 1, 20.0)
    _, (finding,) = cut_layers(pattern, PerforationSettings(margin_mm=10.0))
    assert finding.text == (
        "1 of 1 valley creases leaves nothing between its margins (20 mm, and what relief holes "
        "and lattices take) and stays uncut. It is 20 mm long. Lower margin_mm, or make the sheet "
        "at least 1.01 times as large."
    )
    wide = LatticeStyle(cut_mm=4.0, gap_mm=1.0, rows=60, pitch_mm=1.0)
    _, (finding,) = cut_layers(pattern, PerforationSettings(valley=wide, margin_mm=0.1))
    assert finding.text.startswith("1 lattice would meet other lines across a face and stays uncut")


def test_nothing_is_drawn_between_faces_that_are_one():
    pattern = pattern_of([[0, 0], [9, 0], [9, 9], [0, 9]], [[0, 1, 2], [0, 2, 3]], "J")
    paths, findings = perforate(pattern, PerforationSettings())
    assert not findings
    assert sum(len(layer.segments) for layer in paths.layers) == 0
