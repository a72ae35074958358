"""Folds in contact that are cut short and go on: the same bits, also in turn."""

from dataclasses import fields

import numpy as np
import pytest
from flat_patterns import grid
from folded_strips import folded_strip
from helpers import PATTERNS

from fab import read_pattern
from fab.errors import Finding
from fab.folding.bar_hinge_model import framework
from fab.folding.checkpoints import FoldCheckpoints
from fab.folding.contact import past_contact
from fab.folding.contact.contact_fold import fold_in_contact
from fab.folding.contact.fold_orders import fold_orders
from fab.folding.contact.work import Work
from fab.folding.fold_settings import FoldSettings, Stiffness
from fab.folding.simulation import fold_and_judge
from fab.jobs.folding_files import simulate

WORK = 1e9


class CutShort(Exception):
    """Stands for whatever ends a process."""


class Cut(FoldCheckpoints):
    """One that ends the fold after it was kept so many times."""

    def __init__(self, folder, most, told=lambda _: None):
        super().__init__(folder, "x", told, every_s=0.0)
        self.left = most

    def keep(self, reached):
        super().keep(reached)
        self.left -= 1
        if not self.left:
            raise CutShort


def flaps():
    """The long flap lies under the short one: they fold one after the other."""
    return folded_strip([34.0, 40.0, 20.0], [178.0, 160.0])


def roll():
    return folded_strip([10.0 + 2.0 * (number // 2) for number in range(8)], [90.0] * 7)


def stuck():
    """Its flaps stop each other in any order."""
    return folded_strip([30.0] * 3, [150.0] * 2)


def bits(folding):
    """All that a fold consists of, to the last bit."""
    states = [
        tuple(
            value.tobytes() if isinstance(value, np.ndarray) else value
            for value in (getattr(state, field.name) for field in fields(state))
        )
        for state in folding.states
    ]
    return states, folding.in_turn, folding.stopped, folding.layers_rel


@pytest.mark.parametrize(
    ("pattern", "thickness_mm"),
    [
        (read_pattern(PATTERNS / "bird_base.fold")[0], 0.0),
        (roll(), 0.2),
        (stuck(), 0.0),
    ],
    ids=["bird base", "roll", "stuck"],
)
def test_a_fold_in_contact_goes_on_with_the_same_bits(pattern, thickness_mm, tmp_path):
    def run(checkpoint=None):
        work = Work(WORK)
        # what has been folded before leaves nothing in the framework
        made = fold_in_contact(
            framework(pattern), 4, thickness_mm, work=work, checkpoint=checkpoint
        )
        return bits(made), work.left

    kept = Cut(tmp_path / "whole", 0)
    whole = run(kept)
    loads = -kept.left
    assert loads >= 4
    assert whole == run(FoldCheckpoints(tmp_path / "whole", "x"))  # which is over
    for number in (1, loads // 2, loads - 1, loads):
        folder = tmp_path / str(number)
        with pytest.raises(CutShort):
            run(Cut(folder, number))
        told = []
        assert run(FoldCheckpoints(folder, "x", told.append)) == whole
        assert "goes on at" in told[0]


@pytest.mark.parametrize(("pattern", "contact"), [(flaps, None), (stuck, True)])
def test_orders_of_folding_that_are_cut_short_again_and_again_end_with_the_same_bytes(
    pattern, contact, tmp_path
):
    def run(checkpoint=None):
        settings = FoldSettings(contact=contact)
        return simulate(pattern(), "x", settings, formats=["fold"], checkpoint=checkpoint).files

    whole, told, cuts, folds = run(), [], 0, 0
    while True:
        kept = Cut(tmp_path, 15, told.append)
        try:
            files = run(kept)
            break
        except CutShort:
            cuts += 1
            assert cuts < 10
            folds = len(list(tmp_path.iterdir()))
    assert cuts > 2
    assert folds > 2  # without contact, all at once, and in turn
    assert files == whole
    assert sum("goes on at" in text for text in told) > cuts
    kept.remove()
    assert not list(tmp_path.iterdir())


def test_work_that_was_spent_before_counts(tmp_path, monkeypatch):
    def run(checkpoint=None):
        pattern = read_pattern(PATTERNS / "bird_base.fold")[0]
        return fold_and_judge(pattern, FoldSettings(steps=4, contact=True), checkpoint=checkpoint)

    whole = Work(WORK)
    fold_in_contact(framework(read_pattern(PATTERNS / "bird_base.fold")[0]), 4, work=whole)
    for share in (0.5, 0.9):
        most = share * (WORK - whole.left)
        monkeypatch.setattr(past_contact, "_MOST_PAIRS", most)
        folding, _, findings = run()
        assert "contact-not-finished" in [each.code for each in findings]
        folder, cuts = tmp_path / str(share), 0
        while True:
            try:
                again, _, found = run(Cut(folder, 4))
                break
            except CutShort:
                cuts += 1
                assert cuts < 20
        assert cuts > 1
        assert bits(again) == bits(folding)
        assert found == findings


def test_other_sheets_settings_and_orders_take_nothing_up(tmp_path):
    frame = framework(roll())
    orders = list(fold_orders(frame))
    first = Cut(tmp_path, 0)
    fold_in_contact(frame, 2, 0.2, work=Work(WORK), checkpoint=first)
    (file,) = tmp_path.iterdir()
    quads = framework(grid(2, 1, 10.0), Stiffness(facet=0.7))
    for pattern, rest in (
        (frame, {"steps": 3, "thickness_mm": 0.2, "work": Work(WORK)}),
        (frame, {"steps": 2, "thickness_mm": 0.3, "work": Work(WORK)}),
        (frame, {"steps": 2, "thickness_mm": 0.2, "work": Work(2 * WORK)}),
        (frame, {"steps": 2, "thickness_mm": 0.2, "work": Work(WORK), "path": orders[0]}),
        (framework(roll(), Stiffness(crease=0.5)), {"steps": 2, "thickness_mm": 0.2}),
        (quads, {"steps": 2, "thickness_mm": 0.2, "work": Work(WORK)}),
    ):
        told = []
        fold_in_contact(pattern, **rest, checkpoint=FoldCheckpoints(tmp_path, "x", told.append))
        assert not told
    assert list(tmp_path.iterdir()) == [file]


def test_a_damaged_file_is_told_and_the_fold_begins_anew(tmp_path):
    frame = framework(stuck())
    whole = fold_in_contact(frame, 2)
    fold_in_contact(frame, 2, checkpoint=Cut(tmp_path, 0))
    (file,) = tmp_path.iterdir()
    data = file.read_bytes()
    flipped = bytearray(data)
    flipped[data.index(b"carried_low.npy") + 200] ^= 1
    for wrong in (data[:-1], bytes(flipped)):
        file.write_bytes(wrong)
        told = []
        again = fold_in_contact(frame, 2, checkpoint=FoldCheckpoints(tmp_path, "x", told.append))
        (finding,) = told
        assert isinstance(finding, Finding)
        assert finding.code == "checkpoint-unusable"
        assert bits(again) == bits(whole)
