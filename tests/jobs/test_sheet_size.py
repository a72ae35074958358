"""Sizes of a sheet: of its flat form, of its folded form, or of a unit of the design."""

import numpy as np
import pytest

from fab.errors import InvalidJob
from fab.jobs.job import parse_job
from fab.jobs.job_files import Format, from_mesh, make

MIURA = {"kind": "miura", "columns": 4, "rows": 3}


def boxes(**size):
    made = make(parse_job({"name": "m", "design": MIURA, "sheet": size}), [Format.FOLD])
    box = made.report["bounding_box_mm"]
    return np.array(box["flat"]), np.array(box["folded"])


def test_each_size_is_what_it_says():
    for size in (1.0, 250.0):
        assert max(boxes(width_mm=size)[0]) == pytest.approx(size, rel=1e-5)
        assert max(boxes(folded_width_mm=size)[1]) == pytest.approx(size, rel=1e-5)
        assert boxes(folded_height_mm=size)[1][2] == pytest.approx(size, rel=1e-5)


def test_sizes_of_one_sheet_agree():
    flat, folded = boxes(scale_mm_per_unit=20.0)
    for size in (
        {"width_mm": max(flat)},
        {"folded_width_mm": max(folded)},
        {"folded_height_mm": folded[2]},
    ):
        assert boxes(**size)[0] == pytest.approx(flat, rel=1e-5)
        assert boxes(**size)[1] == pytest.approx(folded, rel=1e-5)


def test_the_longest_side_may_be_the_height():
    rows = [[[x, 0.4 * (x % 2), 4.0 * y] for x in range(3)] for y in range(2)]
    made = from_mesh(rows, folded_width_mm=80.0).make(["fold"])
    assert made.report["bounding_box_mm"]["folded"] == pytest.approx([40.0, 8.0, 80.0])


def test_a_folded_sheet_without_height_has_none_to_be_sized_by():
    rows = [[[x, 0.4 * (x % 2) + y, 0.0] for x in range(3)] for y in range(2)]
    with pytest.raises(InvalidJob, match=r"folded_height_mm = 50: .* flat along z.* width_mm"):
        from_mesh(rows, folded_height_mm=50.0)


@pytest.mark.parametrize(
    ("size", "message"),
    [
        ({}, "no size, give exactly one of width_mm, .*folded_width_mm, folded_height_mm"),
        (
            {"width_mm": 90.0, "folded_height_mm": 5.0},
            "width_mm = 90.0 and folded_height_mm = 5.0 are given, give exactly one",
        ),
        ({"folded_width_mm": 0.0}, "sheet.folded_width_mm = 0.0 .*greater than 0"),
        ({"folded_height_mm": float("nan")}, "sheet.folded_height_mm = nan"),
    ],
)
def test_one_size_is_to_be_given(size, message):
    with pytest.raises(InvalidJob, match=message):
        parse_job({"name": "m", "design": MIURA, "sheet": size})
