"""Jobs grown by hand: their tables, and what is said of strips that cannot be grown."""

import pytest

from fab.errors import InvalidJob
from fab.jobs.job import parse_job
from fab.jobs.job_files import make
from solver import ChosenStrip, InvalidValue, Miura, Side, StripByStrip

STRIP = {"side": "top", "flap_angle_deg": 100.0, "lengths": 0.5}


def job(*strips, **seed):
    table = {"kind": "miura", "columns": 4, "rows": 2, **seed}
    design = {"kind": "strip_by_strip", "seed": table, "strips": list(strips)}
    return parse_job({"name": "m", "design": design, "sheet": {"width_mm": 90.0}})


def test_the_tables_of_a_job_are_the_design():
    lengths = [0.5, 1, 0.25, 0.5, 0.5]
    design, _ = job(STRIP, {**STRIP, "lengths": lengths}).design.design(None)
    strip = ChosenStrip(Side.TOP, 1.7453292519943295, 0.5)
    other = ChosenStrip(Side.TOP, 1.7453292519943295, (0.5, 1.0, 0.25, 0.5, 0.5))
    assert design == StripByStrip(Miura(columns=4, rows=2), (strip, other))
    made = make(job(STRIP, STRIP), ["fold"])
    assert made.within_tolerance
    assert made.report["counts"]["faces"] == 16
    assert made.report["job"]["design"]["strips"] == [{**STRIP, "boundary_angles_deg": None}] * 2


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"side": "up"}, "design.strips.1.side = 'up'"),
        ({"flap_angle": 1.0}, "Did you mean design.strips.1.flap_angle_deg?"),
        ({"flap_angle_deg": True}, "design.strips.1.flap_angle_deg = True"),
        ({"lengths": "0.5"}, "it must be a number or be a list"),
        ({"lengths": [1.0, "a"]}, "design.strips.1.lengths.1 = 'a'"),
        ({"boundary_angles_deg": [90.0]}, "design.strips.1.boundary_angles_deg has too few values"),
    ],
)
def test_keys_of_a_strip_are_checked_by_place(change, named):
    with pytest.raises(InvalidJob) as refused:
        job(STRIP, {**STRIP, **change})
    assert named in str(refused.value)


@pytest.mark.parametrize(
    ("strip", "named"),
    [
        (
            {"flap_angle_deg": 300.0},
            "flap angle of strip 2 (top side) = 300 deg (5.23598776 rad) is out of bounds: it must "
            "lie between 184.018447 deg (3.21172779 rad) and 280 deg (4.88692191 rad), the nearest",
        ),
        ({"lengths": 0.0}, "length at vertex 0 of strip 2 (top side) = 0 is out of bounds"),
        ({"lengths": [0.5] * 4}, "must be a number or have shape (5,)"),
        ({"boundary_angles_deg": [90.0, 190.0]}, "boundary angle (right) of strip 2 (top side)"),
        (
            {"side": "right", "flap_angle_deg": 240.0, "lengths": 9.0},
            "length at vertex 1 of strip 2 (right side) = 9 is out of bounds: it must be below ",
        ),
    ],
)
def test_a_strip_that_cannot_be_grown_is_named_with_its_bound(strip, named):
    with pytest.raises((InvalidJob, InvalidValue)) as refused:
        make(job(STRIP, {**STRIP, **strip}), ["fold"])
    assert isinstance(refused.value, InvalidJob)
    assert named in str(refused.value)


def test_a_seed_is_refused_by_its_own_key():
    with pytest.raises(InvalidJob, match=r"^design\.seed\.sector_angle_deg: "):
        make(job(STRIP, sector_angle_deg=120.0), ["fold"])
    with pytest.raises(InvalidJob, match=r"design\.seed\.kind = 'miur' must be one of"):
        job(STRIP, kind="miur")
