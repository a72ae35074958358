"""Commands that are interrupted, killed and run in broken surroundings, again and again.

    python -m tests.fuzz.faults --interruptions 200 --faults 50 --seed 1

Each interruption stops a command at a random moment of its known duration: Ctrl-C, SIGTERM or a
closed terminal, or SIGKILL. Afterwards every file is whole or the older one, nothing is left
elsewhere, and a second run makes what one makes that nothing disturbs. Fault runs meet full disks,
read-only and vanishing folders, links, clocks that jump and other broken surroundings.
Exit code 1 where anything is wrong. `--only NAME` takes some commands or faults alone.
"""

from __future__ import annotations

import argparse
import random
import shutil
import signal
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

_TESTS = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(_TESTS), str(_TESTS.parent)]

from fuzz.fault_kinds import FAULTS, broken  # noqa: E402
from fuzz.fault_worlds import (  # noqa: E402
    COMMANDS,
    OLD,
    STOPS,
    Command,
    Run,
    Whole,
    World,
    faults_of,
    prepared,
    run_to_end,
    tree,
    whole_of,
)

__all__ = ["interrupted", "main", "warm_home", "wholes_of"]


def warm_home(folder: Path) -> Path:
    """A home in which libraries have their caches."""
    world = World.of(folder / "warm")
    for name in ("run loaded", "figure"):
        run_to_end(world, next(command for command in COMMANDS if command.name == name))
    return world.path / "home"


def wholes_of(commands: Sequence[Command], folder: Path, warm: Path) -> dict[str, Whole]:
    """What each command makes that nothing disturbs."""
    out = {}
    for command in commands:
        out[command.name] = whole_of(command, folder, warm)
        print(f"{command.name}: {out[command.name].seconds:.1f} s", flush=True)
    return out


@contextmanager
def world_of(folder: Path, warm: Path) -> Iterator[World]:
    """A new world, and its end."""
    place = Path(tempfile.mkdtemp(dir=folder)) / "world"
    try:
        yield World.of(place, warm)
    finally:
        shutil.rmtree(place.parent, ignore_errors=True)


def interrupted(
    whole: Whole, world: World, numbers: random.Random, *, kill: bool
) -> tuple[str, list[str]]:
    """Stop a command at a random moment, and run it again: what happened, and what is wrong."""
    command = whole.command
    prepared(command, world)
    out = world.path / command.out
    if numbers.random() < 0.5 and not command.kept and command.name not in ("new", "settings"):
        for name in whole.files:
            if whole.files[name] != b"folder" and not (out / name).exists():
                (out / name).parent.mkdir(parents=True, exist_ok=True)
                (out / name).write_bytes(OLD)
    before = tree(world.path)
    number = signal.SIGKILL if kill else numbers.choice(list(STOPS))
    group = numbers.random() < 0.5
    run = Run(world, command)
    time.sleep(numbers.uniform(0.0, whole.seconds))
    sent, early = run.stop(number, group=group)
    ended = run.ended()
    ended.before = early
    codes = {whole.code} if not sent else {whole.code, -number, STOPS.get(number, 137)}
    if command.serves and sent:
        codes = {0, -number, STOPS.get(number, 137)} if early or kill else {0, STOPS[number]}
    elif sent and not early and not kill:
        codes.discard(-number)
    if early and not kill:
        codes.add(1)  # the interpreter itself was interrupted, before our first line
    what = f"{command.name}: {signal.Signals(number).name}{' to the group' if group else ''}"
    how = "too late" if not sent else "before the first line" if early else f"code {ended.code}"
    found = faults_of(
        world, whole, before, ended, codes=sorted(codes), is_complete=False, killed=kill
    )
    again = run_to_end(world, command)
    found += [
        f"run again: {text}"
        for text in faults_of(
            world, whole, before, again, codes=command.again or (whole.code,), is_complete=True
        )
    ]
    return f"{what}, {how}", found


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--interruptions", type=int, default=200)
    parser.add_argument("--kills", type=int, default=60, help="of the interruptions, by SIGKILL")
    parser.add_argument("--faults", type=int, default=len(FAULTS))
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", action="append", default=[], help="a command or a fault")
    options = parser.parse_args()
    numbers = random.Random(options.seed)
    wrong, outcomes = 0, Counter[str]()
    faults = [f for f in FAULTS if not options.only or f.name in options.only][: options.faults]
    needed = {f.command for f in faults} | {f.other for f in faults if f.other}
    every = {c.name for c in COMMANDS if not options.only or c.name in options.only}
    chosen = [
        c for c in COMMANDS if c.name in needed or (options.interruptions and c.name in every)
    ]
    with tempfile.TemporaryDirectory(prefix="faults-") as name:
        folder = Path(name)
        warm = warm_home(folder)
        wholes = wholes_of(chosen, folder, warm)
        stopped = [c for c in chosen if c.name in every]
        for count in range(options.interruptions if stopped else 0):
            whole = wholes[stopped[count % len(stopped)].name]
            kill = count * options.kills % max(options.interruptions, 1) < options.kills
            with world_of(folder, warm) as world:
                what, found = interrupted(whole, world, numbers, kill=kill)
            outcomes[what.rpartition(", ")[2]] += 1
            wrong += bool(found)
            print(f"{count + 1}. {what}", *found, sep="\n    ", flush=True)
        for count, fault in enumerate(faults):
            with world_of(folder, warm) as world:
                found = broken(fault, wholes, world, numbers)
            outcomes["fault runs"] += 1
            wrong += bool(found)
            print(f"fault {count + 1}. {fault.name}", *found, sep="\n    ", flush=True)
    print(f"{dict(outcomes)}: {wrong} of them with something lost, stray or wrong")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
