"""Rows of dashes become whole lines, and nothing else does."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fab.formats.drawn.dashes import extended, join_dashes
from fab.formats.drawn.line_soup import LineSoup
from fab.sheets.crease_cuts import cuts_along
from fab.sheets.crease_styles import DashDotStyle, DashStyle, DotStyle


def soup_of(coords, letters, angles=None) -> LineSoup:
    coords = np.asarray(coords, float).reshape(-1, 2, 2)
    count = len(coords)
    return LineSoup(
        Path("drawing.svg"),
        "",
        coords,
        np.array(list(letters)),
        np.full(count, np.nan) if angles is None else np.asarray(angles, float),
        np.arange(count),
        tuple(f"line {n}" for n in range(count)),
        1.0,
    )


def row(start, end, count, gap_share=0.3):
    """Dashes from start to end, with a gap after each but the last."""
    start, end = np.asarray(start, float), np.asarray(end, float)
    period = 1 / (count - gap_share)
    begin = np.arange(count) * period
    t = np.stack([begin, begin + period * (1 - gap_share)], axis=1)
    return start + t[..., None] * (end - start)


def as_set(coords):
    return {tuple(sorted(map(tuple, np.round(line, 6).tolist()))) for line in coords}


@given(
    angle=st.floats(0, 2 * np.pi),
    count=st.integers(3, 40),
    share=st.floats(0.1, 0.7),
    order=st.randoms(use_true_random=False),
)
def test_a_row_is_one_line(angle, count, share, order):
    end = 100 * np.array([np.cos(angle), np.sin(angle)])
    dashes = row((0, 0), end, count, share)
    turn = list(range(count))
    order.shuffle(turn)
    dashes = dashes[turn]
    dashes[::2] = dashes[::2, ::-1]
    found = join_dashes(soup_of(dashes, "M" * count))
    assert len(found.lines_coords) == 1
    assert np.hypot(*(found.lines_coords[0, 1] - found.lines_coords[0, 0])) == pytest.approx(100)
    assert f"{count} dashes in 1 row" in found.findings[0].text


@pytest.mark.parametrize(
    "style",
    [
        DashStyle(cut_mm=3, gap_mm=1),
        DashDotStyle(cut_mm=6, dot_mm=0.5, gap_mm=1.5),
        DotStyle(dot_mm=0.1, pitch_mm=2),
    ],
)
def test_styles_of_creases(style):
    lines = np.array([[[0, 0], [80, 30]], [[0, 40], [80, 41]]], float)
    cuts = cuts_along(lines, style, 0.5, 0.05)
    found = join_dashes(soup_of(cuts.segments, "V" * len(cuts.segments)))
    assert len(found.lines_coords) == 2
    gone = np.hypot(*np.diff(lines, axis=1)[:, 0].T) - np.hypot(
        *np.diff(found.lines_coords, axis=1)[:, 0].T
    )
    assert gone == pytest.approx([1.05, 1.05], abs=0.1)


def test_what_is_no_row_stays():
    apart = [[(0, 0), (5, 0)], [(7, 0), (12, 0)]]  # two alone
    slits = row((0, 10), (50, 10), 6)
    bent = [[(0, 20), (5, 20)], [(7, 20.6), (12, 22)], [(14, 23), (19, 25)]]
    touched = row((0, 40), (50, 40), 4)
    across = [[(x, y), (x, y + 3)] for x, y in touched[:, 1].tolist()]
    coords = np.concatenate([apart, slits, bent, touched, across])
    letters = "MM" + "C" * 6 + "VVV" + "M" * 4 + "V" * 4
    found = join_dashes(soup_of(coords, letters))
    assert as_set(found.lines_coords) == as_set(coords)
    assert found.findings == ()


def test_letters_part_rows_and_wide_gaps_do():
    coords = np.concatenate(
        [row((0, 0), (30, 0), 5), row((32, 0), (60, 0), 5), row((80, 0), (110, 0), 5)]
    )
    found = join_dashes(soup_of(coords, "M" * 5 + "V" * 10))
    assert as_set(found.lines_coords) == {
        ((0, 0), (30, 0)),
        ((32, 0), (60, 0)),
        ((80, 0), (110, 0)),
    }
    assert sorted(found.lines_assignment.tolist()) == ["M", "V", "V"]


def test_angles_that_differ_are_left_out():
    coords = np.concatenate([row((0, 0), (30, 0), 3), row((0, 9), (30, 9), 3)])
    found = join_dashes(soup_of(coords, "M" * 6, [-90, -90, -90, -90, -90, -80]))
    assert sorted(np.nan_to_num(found.lines_foldAngle, nan=1).tolist()) == [-90, 1]


def test_ends_reach_the_point_where_most_lines_meet():
    star = [[(2 * c, 2 * s), (20 * c, 20 * s)] for c, s in ((1, 0), (0.6, 0.8), (-0.8, 0.6))]
    ends = np.array([*star, [(-1, 20), (-1, -20)]], float)
    loose = np.zeros((4, 2), bool)
    loose[:3, 0] = True
    out, moved = extended(ends, loose, np.full(4, 2.5), 1e-6, 2)
    assert moved.tolist() == loose.tolist()
    assert out[:2, 0] == pytest.approx(np.zeros((2, 2)), abs=1e-9)
    # a line that passes comes first where it is all the same
    assert out[2, 0] == pytest.approx([-1, 0.75])


def test_ends_that_meet_nothing_stay():
    ends = np.array([[(0, 0), (10, 0)], [(20, -5), (20, 5)]], float)
    loose = np.ones((2, 2), bool)
    out, moved = extended(ends, loose, np.full(2, 5.0), 1e-6, 1)
    assert out.tolist() == ends.tolist()
    assert not moved.any()
