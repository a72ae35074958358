"""Interrupts: noted, raised where that does no harm, and told by the exit code."""

import os
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import pytest
from helpers import ROOT

from fab.interrupts import Interrupts, held

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")


@pytest.fixture(autouse=True)
def handled():
    """Signals as a terminal gives them, and as they were afterwards."""
    numbers = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    before = [signal.signal(number, signal.default_int_handler) for number in numbers]
    yield
    for number, handler in zip(numbers, before, strict=True):
        signal.signal(number, handler)


@pytest.mark.parametrize(
    ("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGHUP, 129)]
)
def test_an_interrupt_is_raised_and_says_its_exit_code(number, code):
    interrupts = Interrupts()
    with pytest.raises(KeyboardInterrupt), interrupts:
        os.kill(os.getpid(), number)
    assert interrupts.came == number
    assert interrupts.exit_code == code
    assert signal.getsignal(number) is signal.default_int_handler


def test_a_swallowed_interrupt_is_raised_at_the_next_check():
    interrupts = Interrupts()
    with interrupts:
        interrupts.check()
        with suppress(KeyboardInterrupt):
            os.kill(os.getpid(), signal.SIGINT)
        with pytest.raises(KeyboardInterrupt):
            interrupts.check()


def test_one_that_came_before_is_taken_up_within():
    outer, inner = Interrupts(raises=False), Interrupts()
    with outer:
        os.kill(os.getpid(), signal.SIGTERM)
        with pytest.raises(KeyboardInterrupt), inner:
            pytest.fail("it begins all the same")
        os.kill(os.getpid(), signal.SIGTERM)  # which is noted again, and not raised
    assert inner.exit_code == 143


def test_held_blocks_end_before_an_interrupt_is_raised():
    done = []

    def work():
        with held():
            with held():
                os.kill(os.getpid(), signal.SIGINT)
                done.append("inner")
            done.append("outer")
        done.append("after")

    with pytest.raises(KeyboardInterrupt), Interrupts():
        work()
    assert done == ["inner", "outer"]
    with held():  # and no later block is left for it
        pass


def test_a_signal_that_is_ignored_stays_ignored():
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    interrupts = Interrupts()
    with interrupts:
        os.kill(os.getpid(), signal.SIGHUP)
    assert not interrupts.came
    assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN


def test_the_command_ends_with_its_exit_code_whatever_becomes_of_its_output():
    """A full disk, a closed pipe and no output at all change nothing."""
    words = [sys.executable, "-m", "fab", "templates"]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    reader, writer = os.pipe()
    os.close(reader)
    with Path("/dev/full").open("wb") as full:
        for how in (
            {"stdout": full},
            {"stdout": writer},
            {"preexec_fn": lambda: os.close(1)},
            {"preexec_fn": lambda: [os.close(number) for number in range(3)]},
        ):
            done = subprocess.run(words, env=environment, stderr=subprocess.PIPE, **how)
            assert done.returncode == 0
            assert b"Exception" not in done.stderr
            assert b"Traceback" not in done.stderr
    os.close(writer)
