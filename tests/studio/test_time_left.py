"""Time that is left of exports: exact where stages keep their shares."""

import pytest

from fab.studio.time_left import TimeLeft, run_stages


class Seconds:
    def __init__(self):
        self.now = 100.0

    def __call__(self):
        return self.now


def test_stages_that_keep_their_shares_are_foretold_exactly():
    clock = Seconds()
    left = TimeLeft({"a": 1.0, "b": 3.0}, clock)
    assert left("grow", 0, 1) is None
    clock.now += 50  # growth, which says nothing of the rest
    assert left("a", 0, 1) is None
    clock.now += 2  # twice as long as it was
    assert left("b", 0, 1) == pytest.approx(6.0)
    clock.now += 3
    assert left("b", 1, 2) == pytest.approx(3.0)
    clock.now += 3
    assert left("b", 1, 1) == pytest.approx(0.0)


def test_a_stage_that_goes_on_after_another_takes_nothing_back():
    clock = Seconds()
    left = TimeLeft({"inspect": 1.0, "clearance": 1.0, "step": 2.0}, clock)
    left("inspect", 0, 1)
    clock.now += 2
    assert left("clearance", 1, 1) == pytest.approx(2.0)
    assert left("inspect", 1, 1) == pytest.approx(6.0)


def test_other_stages_count_by_their_steps():
    clock = Seconds()
    left = TimeLeft({}, clock)
    assert left("split", 0, 10) is None
    clock.now += 4
    assert left("split", 1, 5) == pytest.approx(16.0)
    assert left("nest", 0, 3) is None
    clock.now += 1
    assert left("nest", 1, 2) == pytest.approx(1.0)
    assert left("write", 0, 0) is None


def test_only_stages_of_formats_that_are_made_count():
    assert list(run_stages(["fold", "svg"])) == []
    assert list(run_stages(["png", "html"])) == ["png", "html"]
    assert "step" not in run_stages(["stl"])
    assert {"states", "thick png", "step"} <= set(run_stages(["step", "png"]))
