"""Long runs of the fuzzer.

    python -m tests.fuzz.run --seconds 3600 --seed 1 --out FOLDER
    python -m tests.fuzz.run --seconds 60 --kinds svg,dxf
    python -m tests.fuzz.run --again svg:1:4711

The time is divided among the kinds by their shares. Each kind runs in a process of its own, one
after another, which may have 4 GB more than it begins with; one that crashes, or does not come back
from an input within two minutes of processor time, or waits for as long, is a fault of that input,
and the run goes on behind it. Inputs that
show a fault are saved in the folder with the trace, a few of each fault. `--again` tries one input
once more, and shows what came of it. Exit code 1 where there is a fault.
"""

from __future__ import annotations

import argparse
import faulthandler
import logging
import multiprocessing
import os
import re
import resource
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

sys.path[:0] = [str(Path(__file__).parent.parent), str(Path(__file__).parent.parent.parent)]

import numpy as np
from fuzz.kinds import KINDS
from fuzz.trials import Kind, Trial, generator_of, trial_of

_MORE_BYTES = 4 * 10**9
# How long a process may not answer, of its processor time or of a clock while it has none, and how
# often it tells. On a busy machine one that works may have a few of a hundred seconds.
_LOST_S, _TELLS_S = 120.0, 1.0
_IDLE = 1e-3
_SAVED = 4
# Where files are written, if the system has such a folder: in memory.
_MEMORY = "/dev/shm" if Path("/dev/shm").is_dir() else None


@dataclass
class Tally:
    """What came of the inputs of a kind."""

    inputs: int = 0
    outcomes: Counter[str] = field(default_factory=Counter)
    faults: Counter[str] = field(default_factory=Counter)
    reasons: Counter[str] = field(default_factory=Counter)
    slowest: tuple[float, int] = (0.0, -1)
    most_mb: float = 0.0
    seconds: float = 0.0

    def add(self, number: int, trial: Trial) -> None:
        self.inputs += 1
        self.outcomes[trial.outcome] += 1
        self.slowest = max(self.slowest, (trial.seconds, number))
        self.most_mb = max(self.most_mb, trial.memory_mb)
        if trial.outcome == "refused":
            self.reasons[re.sub(r"[-+.\d][-+.e\d]*|'.*?'|/\S*", "#", trial.text)[:70]] += 1

    def merge(self, other: Tally) -> None:
        self.inputs += other.inputs
        self.outcomes += other.outcomes
        self.faults += other.faults
        self.reasons += other.reasons
        self.slowest = max(self.slowest, other.slowest)
        self.most_mb = max(self.most_mb, other.most_mb)

    def row(self, name: str) -> str:
        rate = self.inputs / self.seconds if self.seconds else 0.0
        return (
            f"{name:<16}{self.inputs:>9}{self.outcomes['refused']:>9}{self.outcomes['taken']:>9}"
            f"{self.slowest[0]:>9.2f}{self.slowest[1]:>9}{self.most_mb:>8.0f}{rate:>8.0f}"
            f"{sum(self.faults.values()):>7}"
        )


HEADER = (
    f"{'kind':<16}{'inputs':>9}{'refused':>9}{'taken':>9}{'slowest':>9}{'number':>9}{'MB':>8}"
    f"{'per s':>8}{'faults':>7}"
)


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument(
        "--kinds", default=",".join(KINDS), help="names with commas; all by default"
    )
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0, help="number of the first input of a kind")
    parser.add_argument("--count", type=int, default=10**9, help="inputs of a kind at most")
    parser.add_argument("--out", type=Path, default=Path("fuzz_faults"))
    parser.add_argument("--reasons", action="store_true", help="how often which refusal came")
    parser.add_argument("--again", help="KIND:SEED:NUMBER of an input")
    arguments = parser.parse_args()
    if arguments.again:
        return once_more(arguments.again)
    names = arguments.kinds.split(",")
    if unknown := sorted(set(names) - set(KINDS)):
        parser.error(f"unknown kinds {', '.join(unknown)}; known are {', '.join(KINDS)}")
    shares = sum(KINDS[name].share for name in names)
    total, found = Tally(), 0
    print(HEADER, flush=True)
    for name in names:
        seconds = arguments.seconds * KINDS[name].share / shares
        run = Run(KINDS[name], arguments.seed, arguments.out)
        tally = run.within(seconds, arguments.first, arguments.count)
        print(tally.row(name), flush=True)
        for key, count in tally.faults.most_common():
            print(f"    {count} x {key}", flush=True)
        if arguments.reasons:
            for reason, count in tally.reasons.most_common(25):
                print(f"    {count:>7} {reason}", flush=True)
        total.merge(tally)
        total.seconds += tally.seconds
        found += sum(tally.faults.values())
    print(total.row("all"), flush=True)
    return int(found > 0)


def prepare(more_bytes: int = _MORE_BYTES) -> None:
    """Let this process have so much more memory, and nothing be printed by libraries."""
    warnings.simplefilter("error")
    warnings.filterwarnings("default", category=DeprecationWarning)
    logging.disable(logging.CRITICAL)
    status = Path("/proc/self/status")
    if more_bytes and status.is_file():
        row = next(line for line in status.read_text().splitlines() if line.startswith("VmSize"))
        limit = int(row.split()[1]) * 1024 + more_bytes
        resource.setrlimit(resource.RLIMIT_AS, (limit, resource.getrlimit(resource.RLIMIT_AS)[1]))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def written(kind: Kind, random: np.random.Generator) -> bytes:
    """An input, made without warnings of what its faults do to numbers."""
    with np.errstate(all="ignore"):
        return kind.written(random)


def tried(kind: Kind, seed: int, number: int, folder: Path) -> tuple[bytes, Trial]:
    """An input of a run, and what came of it."""
    random = generator_of(kind, seed, number)
    data = written(kind, random)
    return data, trial_of(kind, data, random, folder)


def once_more(name: str) -> int:
    """Try an input again in this process, and show what came of it."""
    kind, seed, number = name.split(":")
    prepare()
    with tempfile.TemporaryDirectory() as folder:
        data, trial = tried(KINDS[kind], int(seed), int(number), Path(folder))
    sys.stdout.flush()
    sys.stdout.buffer.write(data[:3000] + b"\n")
    print(f"{trial.outcome} in {trial.seconds:.3f} s, {trial.memory_mb:.0f} MB: {trial.text}")
    return int(trial.outcome == "fault")


@dataclass(frozen=True)
class Run:
    """A run of a kind; faults are saved in a folder."""

    kind: Kind
    seed: int
    out: Path

    def within(self, seconds: float, first: int, count: int) -> Tally:
        """Run for some seconds, or so many inputs."""
        self.data(first)  # loads what it needs, once
        tally, begin = Tally(), time.monotonic()
        end, last = begin + seconds, first + count
        while first < last and time.monotonic() < end:
            first = self._slice(tally, first, last, end)
        tally.seconds = time.monotonic() - begin
        return tally

    def _slice(self, tally: Tally, first: int, last: int, end: float) -> int:
        """Run a process until it is done or lost; the number of the input to go on with."""
        context = multiprocessing.get_context("fork")
        at = context.Value("q", first, lock=False)
        here, there = context.Pipe(duplex=False)
        process = context.Process(target=_work, args=(self, there, at, last, end), daemon=False)
        process.start()
        there.close()
        alive, worked = time.monotonic(), _worked_s(process.pid)
        shown = first
        while True:
            if here.poll(_TELLS_S):
                try:
                    told = here.recv()
                except EOFError:
                    break
                tally.merge(told)
            if at.value != shown:
                shown, alive, worked = at.value, time.monotonic(), _worked_s(process.pid)
            waited, used = time.monotonic() - alive, _worked_s(process.pid) - worked
            if used > _LOST_S or (waited > _LOST_S and used < _IDLE * waited):
                process.kill()
                break
        process.join(10)
        here.close()
        if process.exitcode == 0:
            return last if at.value >= last else 2**62
        number = at.value
        how = f"the process did not come back for {_LOST_S:g} s"
        if process.exitcode and process.exitcode != -9:
            how = f"the process ended with {process.exitcode}"
        tally.inputs += 1
        self.saved(tally, number, self.data(number), how)
        return number + 1

    def data(self, number: int) -> bytes:
        """An input; nothing for one that cannot be made, which is a fault of its maker."""
        try:
            return written(self.kind, generator_of(self.kind, self.seed, number))
        except Exception:
            return b""

    def saved(self, tally: Tally, number: int, data: bytes, text: str) -> None:
        """Count a fault, and save its input if there are few of it yet."""
        key = fault_key(text)
        tally.faults[key] += 1
        stem = re.sub(r"[^A-Za-z0-9]+", "_", f"{self.kind.name} {key}")[:90]
        self.out.mkdir(parents=True, exist_ok=True)
        if len(list(self.out.glob(f"{stem}*.txt"))) < _SAVED:
            name = f"{stem}_{self.seed}_{number}"
            (self.out / f"{name}{Path(self.kind.file).suffix or '.bin'}").write_bytes(data)
            (self.out / f"{name}.txt").write_text(f"{self.kind.name}:{self.seed}:{number}\n{text}")


def _worked_s(process: int | None) -> float:
    """Processor time of a process; 0 where the system does not say."""
    try:
        fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return 0.0
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def fault_key(text: str) -> str:
    """What faults of one cause have in common: the last line and the place in our own code."""
    lines = [line.strip() for line in text.strip().splitlines()] or [""]
    places = [line for line in lines if line.startswith("File")]
    own = [line for line in places if re.search(r"/(fab|solver)/", line)] or places
    plain = re.sub(r"[-+.\d][-+.e\d]*|'.*?'|\".*?\"|/\S*", "#", lines[-1] if places else lines[0])
    if not own:
        return plain[:90]
    found = re.search(r"([^/\"]+)\", line (\d+), in (\S+)", own[-1])
    return f"{plain[:80]} | {' '.join(found.groups()) if found else own[-1][-60:]}"


def _work(run: Run, connection: Connection, at: Any, last: int, end: float) -> None:
    """What a process of a run does: inputs one after another, told once a second."""
    prepare()
    run.out.mkdir(parents=True, exist_ok=True)
    with (
        (run.out / "crashes.log").open("a") as log,
        tempfile.TemporaryDirectory(dir=_MEMORY) as folder,
    ):
        faulthandler.enable(log)
        quiet = os.open(os.devnull, os.O_WRONLY)
        os.dup2(quiet, 1)
        os.dup2(quiet, 2)
        tally, told = Tally(), time.monotonic()
        for number in range(at.value, last):
            at.value = number
            try:
                data, trial = tried(run.kind, run.seed, number, Path(folder))
            except Exception:
                data, trial = b"", Trial("fault", traceback.format_exc(), 0.0, 0.0)
            tally.add(number, trial)
            if trial.outcome == "fault":
                run.saved(tally, number, data, trial.text)
            now = time.monotonic()
            if now > told + _TELLS_S or now > end or number == last - 1:
                connection.send(tally)
                tally, told = Tally(), now
            if now > end:
                break
    connection.close()
    for child in multiprocessing.active_children():
        child.kill()
    os._exit(0)


if __name__ == "__main__":
    sys.exit(main())
