"""Axes, their combinations and constraints: the values of every variation."""

import re
import time
from itertools import product

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fab.errors import InvalidJob
from fab.sweeps.axes import Axis, axes_of
from fab.sweeps.constraints import Constraint
from fab.sweeps.sweep_settings import load_sweep
from fab.sweeps.variations import Variations, variations_of


def swept(tmp_path, text, head='name = "s"\nbase = "miura"\n'):
    path = tmp_path / "s.toml"
    path.write_text(head + text)
    sweep = load_sweep(path)
    return sweep, variations_of(sweep, "s.toml")


@given(st.lists(st.integers(1, 4), min_size=1, max_size=4))
def test_a_grid_has_every_combination_once_the_last_axis_fastest(sizes):
    axes = [Axis(f"a.k{i}", tuple(range(size))) for i, size in enumerate(sizes)]
    whole = 1
    for size in sizes:
        whole *= size
    found = [tuple(v.values.values()) for v in Variations(tuple(axes), "grid", whole)]
    assert found == list(product(*(axis.values for axis in axes)))


@given(
    st.floats(-100, 100),
    st.floats(0.1, 100),
    st.integers(2, 30),
    st.integers(-9, 9),
    st.integers(1, 5),
)
def test_steps_have_both_ends_and_equal_distances(first, length, steps, low, step):
    table = {"a": {"from": first, "to": first + length, "steps": steps}}
    table["b"] = {"from": low, "to": low + step * (steps - 1), "steps": steps}
    floats, whole = axes_of(table, "s")
    assert floats.values[0] == first
    assert floats.values[-1] == pytest.approx(first + length)
    gaps = [b - a for a, b in zip(floats.values, floats.values[1:], strict=False)]
    assert gaps == pytest.approx([length / (steps - 1)] * (steps - 1))
    assert whole.values == tuple(range(low, low + step * (steps - 1) + 1, step))
    assert all(type(value) is int for value in whole.values)


def test_zip_takes_values_side_by_side_and_constraints_leave_out(tmp_path):
    text = 'combine = "zip"\n[axes]\ndesign.columns = [4, 6, 8]\ndesign.rows = [3, 2, 5]\n'
    _, zipped = swept(tmp_path, text)
    pairs = [(v.values["design.columns"], v.values["design.rows"]) for v in zipped]
    assert pairs == [(4, 3), (6, 2), (8, 5)]
    less = 'constraints = ["design.columns <= 2 * design.rows"]\n'
    _, fewer = swept(tmp_path, less + text)
    assert [v.number for v in fewer] == [0, 2]
    assert fewer.whole == 3


def test_a_latin_hypercube_has_each_axis_spread_evenly_and_is_the_same_again(tmp_path):
    text = (
        'combine = "latin_hypercube"\ncount = 40\nseed = 3\n[axes]\n'
        "design.fold_deg = { from = 20.0, to = 60.0, steps = 2 }\ndesign.columns = [2, 11]\n"
    )
    _, first = swept(tmp_path, text)
    values = [v.values for v in first]
    cells = sorted(int((v["design.fold_deg"] - 20.0) / 1.0) for v in values)
    assert cells == list(range(40))
    columns = [v["design.columns"] for v in values]
    assert {columns.count(n) for n in range(2, 12)} == {4}
    assert [v.values for v in swept(tmp_path, text)[1]] == values


@pytest.mark.parametrize(
    ("given", "values"),
    [
        ("fold_deg = { from = 20, to = 70, steps = 5 }", (20.0, 32.5, 45.0, 57.5, 70.0)),
        ("fold_deg = { from = 0.1, to = 0.7, steps = 7 }", (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7)),
        ("fold_deg = [30, 45.5]", (30.0, 45.5)),
        ("rows = { from = 2.0, to = 8.0, steps = 3 }", (2, 5, 8)),
        ("rows = { from = 8, to = 2, steps = 3 }", (8, 5, 2)),
        ("rows = [2.0, 3]", (2, 3)),
    ],
)
def test_values_are_whole_where_the_key_takes_nothing_else(tmp_path, given, values):
    _, found = swept(tmp_path, f"[axes]\ndesign.{given}\n")
    assert found.axes[0].values == values
    assert [type(value) for value in found.axes[0].values] == [type(value) for value in values]


def test_numbers_are_drawn_between_whole_ends_too_where_the_key_takes_any(tmp_path):
    drawn = (
        "fold_deg = { random = [20, 70], count = 9 }\ndesign.rows = { random = [2, 6], count = 9 }"
    )
    _, found = swept(tmp_path, f'combine = "zip"\n[axes]\ndesign.{drawn}\n')
    angles, rows = ([v.values[key] for v in found] for key in ("design.fold_deg", "design.rows"))
    assert not any(angle.is_integer() for angle in angles)
    assert all(type(row) is int for row in rows)
    cube = 'combine = "latin_hypercube"\ncount = 9\n[axes]\n'
    _, found = swept(tmp_path, f"{cube}design.fold_deg = [20, 70]\ndesign.rows = [2, 6]\n")
    angles, rows = ([v.values[key] for v in found] for key in ("design.fold_deg", "design.rows"))
    assert not any(angle.is_integer() for angle in angles)
    assert all(type(row) is int for row in rows)


def test_random_values_lie_within_their_bounds_and_follow_the_seed():
    table = {"a": {"random": [1.0, 2.0], "count": 50, "seed": 4}}
    (first,), (again,) = axes_of(table, "s"), axes_of(table, "s")
    assert first.values == again.values
    assert all(1 <= value <= 2 for value in first.values)
    assert len(set(first.values)) == 50
    (other,) = axes_of({"a": {**table["a"], "seed": 5}}, "s")
    assert other.values != first.values


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[axes]\n", "axes is empty"),
        ("[axes]\ndesign.rows = []\n", "has 0 values, must have 1 to"),
        ("[axes]\ndesign.rows = 4\n", "must be a list of values"),
        ("[axes]\ndesign.rows = [2, 2]\n", "2 is listed twice"),
        ('[axes]\ndesign.rows = [2, 3]\n"design.rows" = [2, 4]\n', "design.rows is there 2 times"),
        (
            'combine = "latin_hypercube"\ncount = 5000001\n[axes]\n'
            "design.rows = [2, 3]\ndesign.columns = [2, 3]\n",
            "count = 5000001 must be at most 5000000",
        ),
        ("[axes]\ndesign.rows = [[1, 2]]\n", "must be a number, text, true or false"),
        (
            "[axes]\ndesign.rows = { from = 2, to = 8, steps = 5 }\n",
            "from 2 to 8 in 5 steps are no whole numbers. Take steps = 4 or 7",
        ),
        ("[axes]\ndesign.rows = { from = 2.5, to = 8, steps = 5 }\n", "2.5 must be a whole number"),
        ("[axes]\ndesign.rows = { from = 2, to = 2, steps = 3 }\n", "both 2: write [2]"),
        ("[axes]\ndesign.rows = { form = 2, to = 4, steps = 3 }\n", "Known here: from, steps, to."),
        (f"[axes]\ndesign.rows = [{10**30}]\n", "must be within +-9223372036854775807"),
        (
            f"[axes]\ndesign.rows = {{ random = [1, {10**30}], count = 2 }}\n",
            "must be within +-9223372036854775807",
        ),
        (
            "[axes]\ndesign.fold_deg = { from = -1e308, to = 1e308, steps = 3 }\n",
            "must be within +-1e+300",
        ),
        (
            'combine = "latin_hypercube"\ncount = 1_000_000_000\n[axes]\na.b = [1]\n',
            "count = 1000000000 must be at most 10000000",
        ),
        ("[axes]\ndesign.rows = { from = 1, to = 4 }\n", "steps is missing"),
        ("[axes]\ndesign.rows = { random = [4, 1], count = 3 }\n", "lower value first"),
        ('combine = "zip"\n[axes]\na.b = [1]\na.c = [1, 2]\n', "axes of equal length"),
        ("count = 4\n[axes]\na.b = [1]\n", "a Latin hypercube needs count"),
        ('constraints = ["a.b <"]\n[axes]\na.b = [1]\n', "is no condition"),
        ('constraints = ["a.c < 1"]\n[axes]\na.b = [1]\n', "a.c is no axis. Did you mean a.b?"),
        ('measure = ["folds"]\n[axes]\na.b = [1]\n', "measure.0"),
        ('base2 = "x"\n[axes]\na.b = [1]\n', "base2"),
    ],
)
def test_what_is_wrong_is_named(tmp_path, text, words):
    with pytest.raises(InvalidJob, match=re.escape(words)):
        swept(tmp_path, text)


def test_too_many_variations_are_refused_with_their_count(tmp_path):
    text = "[axes]\n" + "".join(
        f"design.k{i} = {{ from = 0.0, to = 1.0, steps = 1000 }}\n" for i in range(3)
    )
    with pytest.raises(InvalidJob, match="has 1000000000 variations"):
        swept(tmp_path, text)
    many = "[axes]\n" + "".join(f"design.k{i} = [0.0]\n" for i in range(1000))
    with pytest.raises(InvalidJob, match="has 1000 axes, must have at most 50"):
        swept(tmp_path, many)


def test_long_lists_take_no_time_that_grows_with_their_square(tmp_path):
    begin = time.process_time()
    text = f"[axes]\ndesign.rows = {list(range(2, 100_002))}\n"
    assert swept(tmp_path, text)[1].whole == 100_000
    assert time.process_time() - begin < 10


def test_constraints_of_texts_and_endless_numbers_are_refused():
    keys = ["design.rows", "design.kind"]
    values = {"design.rows": 3, "design.kind": "miura"}
    for text in ("kind <= 'x'", "rows <= 9**999", "rows ** 9999999 < 1", "'x' * 9999999 > kind"):
        constraint = Constraint(text, keys)
        with pytest.raises(InvalidJob, match=r"^constraint .*: cannot be evaluated: .+\.$"):
            constraint.excess(values)
    with pytest.raises(InvalidJob, match="has 5000 letters, must have at most 1000"):
        Constraint("rows < 2" + " " * 4992, keys)


def test_constraints_run_no_code():
    for text in ("__import__('os').system('true')", "a.b.__class__", "(lambda: 1)()"):
        with pytest.raises(InvalidJob):
            Constraint(text, ["a.b"]).holds({"a.b": 1})
