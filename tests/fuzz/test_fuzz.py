"""A short run of the fuzzer for each kind of file; `run.py` beside it makes long ones."""

import time

import pytest
from fuzz.run import tried
from fuzz.seeds import KINDS

SECONDS = 8.0
COUNT = {"svg": 150, "dxf": 60, "cp": 150, "opx": 150, "ori": 150, "fold": 150, "obj": 150}


@pytest.mark.parametrize("kind", KINDS)
def test_fuzzed_files(kind, tmp_path):
    """Every file is read soundly or refused with a sentence; stops after a time, at least 20."""
    end = time.monotonic() + SECONDS
    kinds = set()
    for number in range(COUNT[kind]):
        if number >= 20 and time.monotonic() > end:
            break
        _, outcome = tried(kind, 20, number, tmp_path)
        assert outcome.kind != "fault", f"number {number}: {outcome.text}"
        assert outcome.kind == "read" or len(outcome.text) > 20
        kinds.add(outcome.kind)
    assert kinds == {"read", "refused"}
