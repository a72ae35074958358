"""Search for the best variations: known optima, Pareto fronts, conditions, and going on."""

import tomllib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from fab.errors import InvalidJob
from fab.jobs.job import load_job
from fab.jobs.job_files import make
from fab.sweeps.pareto import pareto_front
from fab.sweeps.sweep_run import run_sweep
from fab.sweeps.sweep_settings import load_sweep
from fab.sweeps.sweep_table import choose

pytest.importorskip("optuna", reason="optuna is not installed")
pytestmark = pytest.mark.usefixtures("here")

# A sheet whose longer side when flat is twice a function of its keys, and a constant, in mm; its
# shorter side falls with x.
PROBLEM = """
from dataclasses import dataclass
from solver import Miura

@dataclass(frozen=True)
class Problem:
    shape: str = "bowl"
    x: float = 0.0
    y: float = 0.0
    n: int = 0

    def grow(self, progress=None):
        x, y, n = self.x, self.y, self.n
        value = {
            "bowl": 1 + (x - 0.3) ** 2 + (y + 0.2) ** 2,
            "valley": 1 + 5 * (y - x * x) ** 2 + (1 - x) ** 2,
            "steps": 1 + abs(n - 7) + 0.5 * (n % 2 == 0) + x * x,
        }[self.shape]
        return Miura(columns=2, rows=2, crease_length=value, zigzag_length=0.3 - 0.05 * x).grow()
"""
JOB = 'name = "p"\nsheet = { scale_mm_per_unit = 1.0 }\ndesign = { kind = "problem.py:Problem" }\n'
BOWL = "design.x = { from = -2.0, to = 2.0, steps = 2 }\ndesign.y = [-1.5, 1.5]"


def searched(folder, search, axes, head="", jobs=2):
    (folder / "problem.py").write_text(PROBLEM)
    (folder / "base.toml").write_text(JOB)
    (folder / "s.toml").write_text(
        f'name = "s"\nbase = "base.toml"\n{head}search = {{ {search} }}\n[axes]\n{axes}\n'
    )
    return run_sweep(load_sweep(folder / "s.toml", allow_code=True), folder / "out", jobs=jobs)


def rows_of(folder):
    chosen = choose(folder / "out/results.parquet", whole=True)
    return [dict(zip(chosen.columns, row, strict=True)) for row in chosen.rows]


@pytest.mark.parametrize(
    ("shape", "axes", "at", "least"),
    [
        ("bowl", {"x": (-2.0, 2.0), "y": (-2.0, 2.0)}, {"x": 0.3, "y": -0.2}, 0.03),
        ("valley", {"x": (-2.0, 2.0), "y": (-1.0, 3.0)}, {"x": 1.0, "y": 1.0}, 0.1),
        ("steps", {"x": (-1.0, 1.0), "n": (0, 40)}, {"x": 0.0, "n": 7}, 0.1),
    ],
)
def test_known_optima_are_found_and_random_ones_of_equal_cost_are_worse(
    tmp_path, shape, axes, at, least
):
    trials = 60
    steps = "".join(
        f"design.{key} = {{ from = {low}, to = {high}, steps = 5 }}\n"
        for key, (low, high) in axes.items()
    )
    changed = f'design.shape = ["{shape}"]\n{steps}'
    result = searched(
        tmp_path, f'minimise = ["flat.x_mm"], trials = {trials}, seed = 1', changed, jobs=1
    )
    assert result.variations == trials
    assert result.best == ("best.toml",)
    found = tomllib.loads((tmp_path / "out/best.toml").read_text())["design"]
    functions = {
        "bowl": lambda x, y: (x - 0.3) ** 2 + (y + 0.2) ** 2,
        "valley": lambda x, y: 5 * (y - x * x) ** 2 + (1 - x) ** 2,
        "steps": lambda x, n: np.abs(n - 7) + 0.5 * (n % 2 == 0) + x * x,
    }
    over = functions[shape](*(found[key] for key in axes))
    assert over < least
    assert all(abs(found[key] - value) < 0.6 for key, value in at.items())
    numbers = np.random.default_rng(0)
    draws = [
        numbers.integers(low, high, (500, trials), endpoint=True)
        if isinstance(low, int)
        else numbers.uniform(low, high, (500, trials))
        for low, high in axes.values()
    ]
    assert over < np.median(functions[shape](*draws).min(axis=1))  # of 500 random searches


def test_the_winner_is_a_job_that_gives_its_row(tmp_path):
    searched(tmp_path, 'minimise = ["flat.x_mm"], trials = 8', BOWL)
    (tmp_path / "best.toml").write_bytes((tmp_path / "out/best.toml").read_bytes())
    report = make(load_job(tmp_path / "best.toml", allow_code=True), []).report
    least = min(row["flat.x_mm"] for row in rows_of(tmp_path))
    assert report["bounding_box_mm"]["flat"][0] == least


def test_a_search_goes_on_where_it_was_and_runs_nothing_twice(tmp_path):
    first = searched(tmp_path, 'minimise = ["flat.x_mm"], trials = 10', BOWL)
    before = rows_of(tmp_path)
    again = searched(tmp_path, 'minimise = ["flat.x_mm"], trials = 10', BOWL)
    assert rows_of(tmp_path) == before
    assert (first.begun_with, again.begun_with) == (0, 10)
    more = searched(tmp_path, 'minimise = ["flat.x_mm"], trials = 16', BOWL)
    assert (more.variations, more.begun_with) == (16, 10)
    assert rows_of(tmp_path)[:10] == before
    other = searched(tmp_path, 'maximise = ["flat.x_mm"], trials = 5', BOWL)
    assert (other.variations, other.begun_with) == (5, 0)


def test_several_goals_give_a_front_of_jobs(tmp_path):
    """From x = 0.3 on the longer side grows with x, and the shorter one falls."""
    axes = "design.x = { from = 0.0, to = 1.5, steps = 2 }\ndesign.y = [-0.2]\n"
    result = searched(tmp_path, 'minimise = ["flat.x_mm", "flat.y_mm"], trials = 20', axes)
    rows = rows_of(tmp_path)
    values = np.array([[row["flat.x_mm"], row["flat.y_mm"]] for row in rows])
    front = pareto_front(values)
    assert len(result.best) == len(np.unique(values[front], axis=0)) > 1
    on_front = {row["design.x"] for row, on in zip(rows, front, strict=True) if on}
    assert all(x > 0.2 for x in on_front)
    texts = [(tmp_path / "out" / name).read_text() for name in result.best]
    assert {tomllib.loads(text)["design"]["x"] for text in texts} == on_front


def test_conditions_are_met_by_the_best(tmp_path):
    axes = "design.x = { from = -2.0, to = 2.0, steps = 2 }\ndesign.y = [-0.2]"
    search = 'minimise = ["flat.x_mm"], conditions = ["flat.y_mm >= 0.55"], trials = 30'
    searched(tmp_path, search, axes)
    found = tomllib.loads((tmp_path / "out/best.toml").read_text())["design"]
    (best,) = [row for row in rows_of(tmp_path) if row["design.x"] == found["x"]]
    allowed = [row["flat.x_mm"] for row in rows_of(tmp_path) if row["flat.y_mm"] >= 0.55]
    assert best["flat.y_mm"] >= 0.55
    assert best["flat.x_mm"] == min(allowed)
    assert len(allowed) < 30


def test_a_journal_whose_last_line_was_begun_is_gone_on_with_and_a_damaged_one_refused(tmp_path):
    search = 'minimise = ["flat.x_mm"], trials = {}'
    searched(tmp_path, search.format(4), BOWL)
    before, journal = rows_of(tmp_path), tmp_path / "out/search.journal"
    whole = journal.read_bytes()
    journal.write_bytes(whole + whole.splitlines()[-1][:9])
    assert searched(tmp_path, search.format(6), BOWL).begun_with == 4
    assert rows_of(tmp_path)[:4] == before
    first, _, rest = whole.partition(b"\n")
    for data in (b"{}\n", b"x\n" + whole, first + b"\n[]\n" + rest, b"\xff\n", whole[9:]):
        journal.write_bytes(data)
        with pytest.raises(InvalidJob, match=r"search\.journal: is damaged. Delete it: the search"):
            searched(tmp_path, search.format(6), BOWL)
    journal.unlink()
    assert searched(tmp_path, search.format(6), BOWL).begun_with == 0


def test_variations_that_constraints_leave_out_are_not_run(tmp_path):
    head = 'constraints = ["design.x < 0"]\n'
    searched(tmp_path, 'minimise = ["flat.x_mm"], trials = 20', BOWL, head)
    rows = rows_of(tmp_path)
    assert 0 < len(rows) < 20
    assert all(row["design.x"] < 0 for row in rows)


@pytest.mark.parametrize(
    ("search", "words"),
    [
        ("trials = 5", "minimise and maximise are empty"),
        (
            'minimise = ["facets"], trials = 5',
            "facets is no column of numbers in the table. Did you",
        ),
        (
            'minimise = ["faces"], maximise = ["faces"], trials = 5',
            "both in minimise and in maximise",
        ),
        ('minimise = ["faces"], conditions = ["faces <"], trials = 5', "is no condition"),
        ('minimise = ["growth.status"], trials = 5', "growth.status is no column of numbers"),
        ('minimise = ["faces"]', "trials is missing"),
        (
            'minimise = ["sheets.minutes"], trials = 5',
            "sheets.minutes is not measured. Add measure = ['sheets']",
        ),
        (
            'minimise = ["faces"], conditions = ["mass_g < 5"], trials = 5',
            "solids.mass_g is not measured. Add measure = ['thick']",
        ),
    ],
)
def test_what_is_wrong_with_a_search_is_named(tmp_path, search, words):
    with pytest.raises(InvalidJob) as raised:
        searched(tmp_path, search, BOWL)
    assert words in str(raised.value)


def test_a_search_takes_no_combination_and_says_when_nothing_is_the_best(tmp_path):
    goal = 'minimise = ["flat.x_mm"], conditions = ["flat.x_mm < 0"], trials = 3'
    head = 'combine = "latin_hypercube"\ncount = 3\n'
    with pytest.raises(InvalidJob, match="a search proposes the variations itself"):
        searched(tmp_path, goal, BOWL, head)
    result = searched(tmp_path, goal, BOWL)
    assert result.best == ()
    assert "no trial was made that meets the conditions" in "\n".join(result.lines())


@given(
    arrays(
        float,
        st.tuples(st.integers(1, 30), st.integers(1, 3)),
        elements=st.integers(0, 5).map(float),
    )
)
def test_a_front_is_what_nothing_beats_and_beats_all_else(values):
    front = pareto_front(values)
    assert front.any()
    for row, on in zip(values, front, strict=True):
        beats = (values <= row).all(axis=1) & (values < row).any(axis=1)
        assert on == (not beats.any())
        assert on or (beats & front).any()
