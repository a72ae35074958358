"""Long runs of the fuzzer.

    python tests/fuzz/run.py --kind svg --count 10000 --seed 1 --out FOLDER

Each file is read in this process, with up to 10 s of time and 1 GB of memory more than the process
had at its start. Files that show a fault are saved in the folder with the trace of the fault.
"""

from __future__ import annotations

import argparse
import re
import resource
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

sys.path[:0] = [str(Path(__file__).parent.parent), str(Path(__file__).parent.parent.parent)]

import numpy as np
from fuzz.oracle import Outcome, options_of, outcome_of
from fuzz.seeds import KINDS, fuzzed

_MORE_BYTES = 10**9


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kind", choices=KINDS, required=True)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--out", type=Path, default=Path("fuzz_faults"))
    args = parser.parse_args()
    bound_memory()
    kinds: Counter[str] = Counter()
    codes: Counter[str] = Counter()
    faults: Counter[str] = Counter()
    reasons: Counter[str] = Counter()
    slowest, slow = 0.0, -1
    begin = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        for number in range(args.first, args.first + args.count):
            data, outcome = tried(args.kind, args.seed, number, Path(folder))
            kinds[outcome.kind] += 1
            if outcome.kind == "fault":
                last = outcome.text.strip().splitlines()
                at = [line.strip() for line in last if line.strip().startswith("File")][-1]
                key = f"{last[-1][:60]} | {at.rpartition('/')[2][:80]}"
                faults[key] += 1
                if faults[key] <= 5:
                    name = f"{args.kind}_{args.seed}_{number}"
                    args.out.mkdir(parents=True, exist_ok=True)
                    (args.out / f"{name}.{args.kind}").write_bytes(data)
                    (args.out / f"{name}.txt").write_text(outcome.text)
                    print(f"{name}: {key}", flush=True)
            elif outcome.kind == "refused":
                reasons[re.sub(r"[-+.\d][-+.e\d]*|'.*?'", "#", outcome.text)[-90:]] += 1
            if outcome.kind == "read":
                codes.update(outcome.findings)
            if outcome.seconds > slowest:
                slowest, slow = outcome.seconds, number
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(
        f"{args.kind} seed {args.seed}: {args.count} files, {dict(kinds)}, slowest {slowest:.2f} s "
        f"(number {slow}), peak {peak:.0f} MB, {time.perf_counter() - begin:.0f} s"
    )
    print("  findings:", dict(codes.most_common()))
    print("  refused most:", reasons.most_common(12))
    for key, count in faults.most_common():
        print(f"  {count} x {key}")


def bound_memory() -> None:
    """Let the process have 1 GB more than it has with all its libraries."""
    import ezdxf.recover  # noqa: F401
    import shapely  # noqa: F401
    import svgelements  # noqa: F401

    import fab.formats.dxf.reader
    import fab.formats.svg.reader  # noqa: F401

    status = Path("/proc/self/status")
    if status.is_file():
        row = next(line for line in status.read_text().splitlines() if line.startswith("VmSize"))
        limit = int(row.split()[1]) * 1024 + _MORE_BYTES
        resource.setrlimit(resource.RLIMIT_AS, (limit, limit))


def tried(kind: str, seed: int, number: int, folder: Path) -> tuple[bytes, Outcome]:
    """One file of a run, and what came of it."""
    data = fuzzed(kind, seed, number)
    path = folder / f"fuzzed.{kind}"
    path.write_bytes(data)
    options = options_of(np.random.default_rng([seed, 99, number]))
    return data, outcome_of(path, options, thorough=number % 3 == 0)


if __name__ == "__main__":
    main()
