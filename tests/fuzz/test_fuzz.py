"""A share of each kind of input that is fuzzed; `run.py` beside it makes long runs."""

import signal
import time

import numpy as np
import pytest
from fuzz import run
from fuzz.kinds import KINDS
from fuzz.run import fault_key, tried
from fuzz.table_faults import toml_text
from fuzz.trials import Kind, generator_of, trial_of, watched_opens

from fab.errors import InvalidFile

SEED = 20
# Of processor time; a kind is tried so often at least, slow ones less, and so often at most.
SECONDS = 1.0
LEAST, MOST = 12, 400
SLOW = {"command": 6, "panels": 3, "folded": 3, "made-job": 6, "step": 4, "3mf": 4, "checkpoint": 6}
# Those are tried by a test of their own, with a studio that all of it uses.
STUDIO = {"message"}
# Of few inputs, or of those that mostly are refused, all may end in one way.
ONE_WAY = {*SLOW, "sweep", "stock", "sweep-part"}


@pytest.mark.parametrize("name", sorted(set(KINDS) - STUDIO))
def test_inputs_are_taken_or_refused_in_words(name, tmp_path):
    kind, outcomes = KINDS[name], set()
    tried(kind, SEED, 0, tmp_path)  # loads what it needs
    end = time.process_time() + SECONDS
    for number in range(MOST):
        if number >= SLOW.get(name, LEAST) and time.process_time() > end:
            break
        _, trial = tried(kind, SEED, number, tmp_path)
        assert trial.outcome != "fault", f"{name}:{SEED}:{number}: {trial.text}"
        outcomes.add(trial.outcome)
    assert outcomes == {"taken", "refused"} or name in ONE_WAY


def outcome_of(read, tmp_path, **bounds):
    kind = Kind("test", "a.txt", lambda random: b"x", read, **bounds)
    return trial_of(kind, b"x", generator_of(kind, 1, 1), tmp_path)


def test_what_is_neither_taken_nor_refused_in_words_is_a_fault(tmp_path):
    """The oracle finds crashes, hangs, hunger, other files and words that are none."""

    def refuse(text):
        def read(path, random):
            raise InvalidFile(text)

        return read

    def crash(path, random):
        return {}["x"]

    def hang(path, random):
        while True:
            pass

    def hunger(path, random):
        return str(np.ones(20_000_000).sum())

    def stray(path, random):
        return (path.parent / "b.txt").read_text()

    def waver(path, random, seen=[]):  # noqa: B006
        seen.append(1)
        return str(len(seen))

    (tmp_path / "b.txt").write_text("b")
    assert outcome_of(lambda path, random: "", tmp_path).outcome == "taken"
    assert outcome_of(refuse("a.txt: is damaged. Export it again."), tmp_path).outcome == "refused"
    for text in ("short", "a.txt: is damaged, export it again", "a.txt: MemoryError() in it."):
        assert outcome_of(refuse(text), tmp_path).outcome == "fault"
    assert "KeyError" in outcome_of(crash, tmp_path).text
    assert "over 0.2 s" in outcome_of(hang, tmp_path, seconds=0.2).text
    assert "needs 1" in outcome_of(hunger, tmp_path, memory_mb=50).text
    assert "opens" in outcome_of(stray, tmp_path).text
    assert outcome_of(stray, tmp_path, opens=True).outcome == "taken"
    kind = Kind("test", "a.txt", lambda random: b"x", waver)
    texts = [trial_of(kind, b"x", generator_of(kind, 1, i), tmp_path).text for i in range(200)]
    assert any(text.startswith("read twice it differs") for text in texts)


def test_processes_that_wait_or_never_end_are_lost_and_the_run_goes_on(monkeypatch, tmp_path):
    monkeypatch.setattr(run, "_LOST_S", 0.5)
    monkeypatch.setattr(run, "_TELLS_S", 0.1)

    def read(path, random):
        signal.signal(signal.SIGPROF, signal.SIG_IGN)  # as a library that does not return
        how = path.read_bytes()[0]
        while how == 1:
            pass
        time.sleep(1e6 if how == 2 else 0.0)
        return ""

    kind = Kind("test", "a.bin", lambda random: bytes([random.integers(3)]), read)
    numbers = [kind.written(generator_of(kind, 1, number))[0] for number in range(5)]
    assert {*numbers} == {0, 1, 2}
    tally = run.Run(kind, 1, tmp_path).within(600.0, 0, len(numbers))
    assert sum(tally.faults.values()) == sum(number > 0 for number in numbers)


def test_an_input_is_the_same_whenever_it_is_made():
    for kind in KINDS.values():
        first, second = (kind.written(generator_of(kind, 3, 7)) for _ in range(2))
        assert first == second, kind.name


def test_faults_of_one_cause_have_one_key():
    texts = [
        f'Traceback\n  File "/x/fab/a.py", line 3, in f\n    g({n})\nValueError: {n} is no {n}\n'
        for n in (1, 22)
    ]
    assert len({fault_key(text) for text in texts}) == 1


def test_tables_are_written_as_toml():
    import tomllib

    table = {
        "a": [1, 2.5, "x\x1b"],
        "b": {"c": True, "d": {"e": {"f": "é"}}, "g": {}},
        "h i": -1e300,
    }
    assert tomllib.loads(toml_text(table)) == table


def test_opened_files_are_watched_as_long_as_asked(tmp_path):
    with watched_opens(tmp_path / "a.txt") as strayed:
        (tmp_path / "a.txt").write_text("a")
        (tmp_path / "b.txt").write_text("b")
    (tmp_path / "c.txt").write_text("c")
    assert strayed == [str(tmp_path / "b.txt")]
