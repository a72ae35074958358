"""Dashes: on the crease, symmetrical, inside the margins."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fab.crease import crease_pattern
from fab.development import develop
from fab.paths import Operation
from fab.perforation import PerforationSettings, perforate
from fab.styles import DashStyle, cuts_along
from solver import Miura

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


def test_a_pattern_is_cut_by_letter_and_its_outline_is_closed_once():
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
    assert [f.code for f in findings] == ["crease-too-short"] * 2
    named = {c for f in findings for c in f.creases}
    assert named == set(np.flatnonzero(np.isin(pattern.edges_assignment, ["M", "V"])).tolist())
    assert all(len(layer.segments) == 0 for layer in paths.layers)
