"""Every style: on its line, symmetrical, in whole periods, as long as asked for after the beam."""

import numpy as np
import pytest
import shapely
from hypothesis import assume, given
from hypothesis import strategies as st
from pydantic import ValidationError

from fab.errors import InvalidJob
from fab.jobs.job import parse_job
from fab.sheets.crease_cuts import cuts_along, unscaled_length
from fab.sheets.crease_styles import (
    DashDotStyle,
    DashStyle,
    DotStyle,
    EngraveStyle,
    LatticeStyle,
    NoStyle,
    ScoreStyle,
)
from fab.sheets.perforation_settings import PerforationSettings
from solver import InvalidValue

sizes = st.floats(0.05, 20.0)


@st.composite
def styles(draw):
    cut, gap, small = draw(sizes), draw(sizes), draw(sizes)
    return draw(
        st.sampled_from(
            [
                ScoreStyle(),
                EngraveStyle(),
                DashStyle(cut_mm=cut, gap_mm=gap),
                DashDotStyle(cut_mm=cut, dot_mm=small, gap_mm=gap),
                DotStyle(dot_mm=small, pitch_mm=small + gap),
                LatticeStyle(cut_mm=cut + gap, gap_mm=cut, rows=2 + int(cut), pitch_mm=small),
            ]
        )
    )


def share(style, room):
    """Cut length over length of one period, and the period."""
    match style:
        case DashStyle() | LatticeStyle():
            period = style.cut_mm + style.gap_mm
            return style.cut_mm / period, period
        case DashDotStyle():
            period = style.cut_mm + style.dot_mm + 2 * style.gap_mm
            return (style.cut_mm + style.dot_mm) / period, period
        case DotStyle():
            return style.dot_mm / style.pitch_mm, style.pitch_mm
    return 1.0, room


def first_cut(style):
    return style.dot_mm if isinstance(style, DotStyle) else style.cut_mm


@given(styles(), st.floats(0.01, 200.0), st.floats(0, 5), st.floats(0, 5), st.floats(0, 6.28))
def test_cuts_lie_in_the_room_of_their_line_and_are_symmetrical(style, length, low, high, turn):
    direction = np.array([np.cos(turn), np.sin(turn)])
    start = np.array([3.0, -2.0])
    ends = np.array([[start, start + length * direction]])
    cuts = cuts_along(ends, style, np.array([[low, high]]))
    room = length - low - high
    if room < 0.0099999:
        assert len(cuts.segments) == 0
        return
    assume(room > 0.0100001)
    along = (cuts.segments - start) @ direction
    across = (cuts.segments - start) @ [-direction[1], direction[0]]
    half = style.width_mm / 2 if isinstance(style, LatticeStyle) else 0.0
    assert np.abs(across).max() <= half + 1e-9
    assert np.ptp(across, axis=1).max() < 1e-9
    assert along.min() >= low - 1e-9
    assert along.max() <= length - high + 1e-9
    assert (along[:, 1] > along[:, 0]).all()
    for height in np.unique(across.round(6)):
        row = along[np.abs(across[:, 0] - height) < 1e-5]
        row = row[np.argsort(row[:, 0])]
        assert (row[1:, 0] > row[:-1, 1]).all()
        assert row.ravel() + row.ravel()[::-1] == pytest.approx(low + length - high, abs=1e-8)
        wanted, period = share(style, room)
        cut = (row[:, 1] - row[:, 0]).sum()
        if len(row) > 1:  # within one fitted period
            scale = (row[0, 1] - row[0, 0]) / first_cut(style)
            assert abs(cut - wanted * room) <= scale * period + 1e-9
            assert 0.5 < scale < 2.0
    assert (cuts.owner == 0).all()
    assert not cuts.pierced.any()
    union = shapely.union_all(shapely.linestrings(cuts.segments))
    assert shapely.length(union) == pytest.approx(
        shapely.length(shapely.linestrings(cuts.segments)).sum(), rel=1e-9
    )


@given(styles(), st.floats(30.0, 200.0), st.floats(0.01, 0.5))
def test_what_the_beam_leaves_is_what_was_asked_for(style, length, kerf):
    ends = np.array([[[0.0, 0.0], [length, 0.0]]])
    wanted = cuts_along(ends, style, 0.5)
    try:
        drawn = cuts_along(ends, style, 0.5, kerf)
    except InvalidValue:  # a kerf that joins cuts, see below
        return
    long = np.diff(wanted.segments[..., 0])[:, 0] >= kerf + 0.0100001
    assert not drawn.pierced[long].any()
    grown = drawn.segments + np.array([[[-kerf / 2, 0.0], [kerf / 2, 0.0]]])
    assert grown[~drawn.pierced] == pytest.approx(wanted.segments[~drawn.pierced], abs=1e-9)
    # pierces are centred where the cut was wanted
    assert drawn.segments.mean(axis=1) == pytest.approx(wanted.segments.mean(axis=1), abs=1e-9)
    assert np.diff(drawn.segments[drawn.pierced][..., 0]) == pytest.approx(0.01, abs=1e-9)


def test_patterns_in_numbers():
    ends = np.array([[[0.0, 0.0], [21.0, 0.0]]])

    def xs(style, kerf=0.0):
        return cuts_along(ends, style, 0.5, kerf).segments[..., 0]

    assert xs(ScoreStyle()) == pytest.approx(np.array([[0.5, 20.5]]))
    dashes = DashStyle(cut_mm=4.0, gap_mm=1.0 + 1 / 3)
    begin = 0.5 + 16 / 3 * np.arange(4)
    assert xs(dashes) == pytest.approx(np.stack([begin, begin + 4.0], axis=1))
    assert xs(dashes, 0.2) == pytest.approx(np.stack([begin + 0.1, begin + 3.9], axis=1))
    # 4 + 1 + 1 + 1 twice, and a closing dash of 4: 18 units on 20 mm
    unit = 20 / 18
    begin = 0.5 + unit * np.array([0, 5, 7, 12, 14])
    size = unit * np.array([4, 1, 4, 1, 4])
    dash_dot = DashDotStyle(cut_mm=4.0, dot_mm=1.0, gap_mm=1.0)
    assert xs(dash_dot) == pytest.approx(np.stack([begin, begin + size], axis=1))
    dots = xs(DotStyle(dot_mm=0.5, pitch_mm=3.9))
    assert dots.mean(axis=1) == pytest.approx(0.75 + 3.9 * np.arange(6))
    assert len(cuts_along(ends, NoStyle(), 0.5).segments) == 0


def test_a_lattice_has_its_rows_shifted_by_half_a_period():
    ends = np.array([[[0.0, 0.0], [0.0, 20.0]], [[0.0, 0.0], [5.0, 0.0]]])
    style = LatticeStyle(cut_mm=6.0, gap_mm=1.0, rows=3, pitch_mm=1.5)
    cuts = cuts_along(ends, style, 0.0)
    assert cuts.owner.tolist() == [0] * 8 + [1]
    rows = cuts.segments[:8, 0, 0]
    assert rows == pytest.approx([1.5] * 3 + [0.0] * 2 + [-1.5] * 3)
    assert cuts.segments[:8, 0, 1] == pytest.approx([0, 7, 14, 3.5, 10.5, 0, 7, 14])
    # the short line has one cut of all its room, on the line
    assert cuts.segments[8] == pytest.approx(ends[1])


@pytest.mark.parametrize("kerf", [-0.1, float("nan"), float("inf"), 11.0])
def test_bad_kerfs_are_refused(kerf):
    with pytest.raises(InvalidValue, match="kerf_mm"):
        cuts_along(np.zeros((1, 2, 2)), ScoreStyle(), 0.5, kerf)


def test_a_kerf_that_joins_cuts_is_refused():
    ends = np.array([[[0.0, 0.0], [50.0, 0.0]]])
    with pytest.raises(InvalidValue, match=r"kerf_mm = 0\.5 .*Cuts would join"):
        cuts_along(ends, DotStyle(dot_mm=0.1, pitch_mm=0.4), 0.5, 0.5)
    lattice = LatticeStyle(cut_mm=6.0, gap_mm=1.0, rows=3, pitch_mm=0.3)
    with pytest.raises(InvalidValue, match=r"pitch_mm = 0\.3 .*greater than kerf_mm = 0\.3"):
        cuts_along(ends, lattice, 0.5, 0.3)


def test_too_many_cuts_are_refused():
    ends = np.tile(np.array([[[0.0, 0.0], [1000.0, 0.0]]]), (200, 1, 1))
    style = LatticeStyle(cut_mm=0.02, gap_mm=0.01, rows=2, pitch_mm=1.0)
    with pytest.raises(InvalidValue, match=r"number of dashes = .* at most 5000000"):
        cuts_along(ends, style, 0.5)


@pytest.mark.parametrize(
    ("table", "match"),
    [
        ({"kind": "dots", "dot_mm": 2.0, "pitch_mm": 2.0}, "dot_mm = 2 must be below pitch_mm"),
        (
            {"kind": "lattice", "cut_mm": 1.0, "gap_mm": 1.0, "rows": 3, "pitch_mm": 1.0},
            "gap_mm = 1 must be below cut_mm",
        ),
        (
            {"kind": "lattice", "cut_mm": 2.0, "gap_mm": 1.0, "rows": 1, "pitch_mm": 1.0},
            "greater than or equal to 2",
        ),
        ({"kind": "score", "cut_mm": 1.0}, "Extra inputs"),
        ({"kind": "perforate"}, "'perforate'"),
        ({"cut_mm": -1.0, "gap_mm": 1.0}, "greater than or equal to 0.01"),
    ],
)
def test_bad_styles_are_refused(table, match):
    with pytest.raises(ValidationError, match=match):
        PerforationSettings.model_validate({"mountain": table})


def test_a_table_without_a_kind_means_dashes():
    settings = PerforationSettings.model_validate({"mountain": {"cut_mm": 2.0, "gap_mm": 1.0}})
    assert settings.mountain == DashStyle(cut_mm=2.0, gap_mm=1.0)
    again = PerforationSettings.model_validate(settings.model_dump(mode="json"))
    assert again == settings


JOB = {"name": "sheet", "design": {"kind": "miura"}, "sheet": {"width_mm": 60.0}}


@pytest.mark.parametrize(
    ("table", "match"),
    [
        ({"mountain": {"cut_mm": 1.0, "gap": 1.0}}, r"mountain\.gap is not a known key.*gap_mm\?"),
        (
            {"valley": {"kind": "lattise"}},
            r"perforation\.valley\.kind = 'lattise' must be one of .*Did you mean lattice\?",
        ),
        ({"flat": 3}, r"perforation\.flat = 3 must be a table"),
        (
            {"mountain": {"kind": "dots", "dot_mm": 2.0, "pitch_mm": 1.0}},
            r"perforation\.mountain: dot_mm = 2 must be below pitch_mm",
        ),
        (
            {"bands": [{"from_deg": 0.0, "to_deg": 30.0, "valley": {"kind": "dots", "dot": 1.0}}]},
            r"perforation\.bands\.0\.valley\.dot is not a known key.*dot_mm",
        ),
        (
            {"bands": [{"from_deg": 0, "to_deg": 30}, {"from_deg": 20, "to_deg": 40}]},
            "bands from 0 to 30 and from 20 to 40 degrees overlap",
        ),
        ({"bands": [{"from_deg": 30, "to_deg": 30}]}, "from_deg = 30 must be below to_deg = 30"),
        ({"bands": [{"from_deg": 30, "to_deg": 200}]}, r"bands\.0\.to_deg = 200 is out of bounds"),
        (
            {"relief": {"shape": "square", "web_mm": 1.0}},
            r"relief\.shape = 'square' is out of bounds",
        ),
        ({"relief": {"web_mm": 0.0}}, r"relief\.web_mm = 0\.0 is out of bounds"),
    ],
)
def test_bad_tables_of_a_job_are_refused_by_their_key(table, match):
    with pytest.raises(InvalidJob, match=match):
        parse_job({**JOB, "perforation": table})


@pytest.mark.parametrize(
    ("style", "period", "first"),
    [
        (DashStyle(cut_mm=3.0, gap_mm=1.0), 4.0, 3.0),
        (DotStyle(dot_mm=0.4, pitch_mm=1.5), 1.5, 0.4),
        (DashDotStyle(cut_mm=3.0, dot_mm=0.5, gap_mm=1.0), 5.5, 3.0),
        (LatticeStyle(cut_mm=6.0, gap_mm=2.0, rows=3, pitch_mm=1.0), 8.0, 6.0),
    ],
)
@pytest.mark.parametrize("near_mm", [0.1, 20.0, 33.3])
def test_rooms_of_whole_periods_leave_cuts_as_long_as_asked_for(style, period, first, near_mm):
    room = unscaled_length(style, near_mm)
    assert (room - first) / period == pytest.approx(max(2, round((near_mm - first) / period)))
    cuts = cuts_along(np.array([[[0.0, 0.0], [room, 0.0]]]), style, 0.0).segments
    lengths = np.ptp(cuts[..., 0], axis=1)
    assert lengths.max() == pytest.approx(first, abs=1e-12)
    assert unscaled_length(ScoreStyle(), near_mm) == near_mm
