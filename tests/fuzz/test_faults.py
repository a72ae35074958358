"""Commands interrupted and run in broken surroundings; `faults.py` beside it makes long runs."""

import random
import sys

import pytest
from fuzz.fault_kinds import FAULTS, broken
from fuzz.fault_worlds import COMMANDS, World, whole_of
from fuzz.faults import interrupted

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="looks into /proc")

CHOSEN = {command.name: command for command in COMMANDS if command.name in ("run", "new")}
# Those that want no disk of their own.
KINDS = ("links to nothing", "folder that links to itself", "two runs at once", "closed streams")
KINDS = (*KINDS, "files of at most 4 kB", "vanishing folder")


@pytest.fixture(scope="module")
def wholes(tmp_path_factory):
    folder = tmp_path_factory.mktemp("whole")
    return {name: whole_of(command, folder, None) for name, command in CHOSEN.items()}


@pytest.mark.parametrize(("name", "kill"), [("run", False), ("run", True), ("new", False)])
def test_interrupted_commands_leave_whole_files_and_nothing_else(wholes, name, kill, tmp_path):
    world = World.of(tmp_path / "world")
    what, found = interrupted(wholes[name], world, random.Random(4), kill=kill)
    assert not found, what


@pytest.mark.parametrize("name", KINDS)
def test_broken_surroundings_leave_whole_files_and_nothing_else(wholes, name, tmp_path):
    (fault,) = (each for each in FAULTS if (each.name, each.command) == (name, "run"))
    assert not broken(fault, wholes, World.of(tmp_path / "world"), random.Random(1))


def test_every_command_is_interrupted():
    from fab.cli.group import main

    assert {command.words[0] for command in COMMANDS} == set(main.commands)
