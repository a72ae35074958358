"""Long runs of the fuzzer of the studio.

    python tests/fuzz/studio_run.py --messages 5000 --sets 1000 --seconds 1800 --seed 1

Malformed messages, then random parameters of a template of each design. Nothing but refusals and
sheets may come back, no file may change outside the studio's folder, and the worker's memory is
bounded. Exit code 1 where there is a fault.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterable
from pathlib import Path

sys.path[:0] = [str(Path(__file__).parent.parent), str(Path(__file__).parent.parent.parent)]

from fuzz.studio_faults import (
    HOST,
    MOST_BYTES,
    Designs,
    Outcome,
    answered,
    designs,
    files_under,
    malformed,
    numbered,
    peak_bytes,
)
from starlette.testclient import TestClient

from fab.studio.app import Studio, studio_app


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--messages", type=int, default=5000)
    parser.add_argument("--sets", type=int, default=1000, help="of each design")
    parser.add_argument("--seconds", type=float, default=1800)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("designs", nargs="*", help="such as surface_fit; all where none is named")
    arguments = parser.parse_args()
    chosen = {kind: designs()[kind] for kind in arguments.designs or designs()}
    share = arguments.seconds / (1 + len(chosen))  # for messages, and for each design
    faults: list[str] = []
    with tempfile.TemporaryDirectory() as outside:
        folder = Path(outside) / "studio"
        folder.mkdir()
        (folder / "link").symlink_to(outside)
        (Path(outside) / "x.toml").write_text("outside")
        studio = Studio(folder, "token")
        with TestClient(studio_app(studio, frozenset({HOST})), f"http://{HOST}/token/") as client:
            before = around(folder)
            outcomes = (
                answered(client, malformed(generator))
                for generator in numbered(arguments.seed, arguments.messages)
            )
            faults += told("messages", outcomes, share)
            if around(folder) != before:
                faults.append("a file outside the folder has changed")
            tried = Designs(client)
            for kind, template in chosen.items():
                outcomes = (
                    tried.grown(template, generator)
                    for generator in numbered(arguments.seed, arguments.sets)
                )
                faults += told(kind, outcomes, share)
                process = studio.worker._process
                peak = peak_bytes(process.pid) if process is not None else 0
                print(f"    worker: at most {peak / 1e6:.0f} MB", flush=True)
                if peak > MOST_BYTES:
                    faults.append(f"{kind}: the worker had {peak / 1e9:.1f} GB")
    for fault in faults:
        print(fault)
    return int(bool(faults))


def around(folder: Path) -> dict[str, str]:
    """Files beside the folder, not those in it."""
    every = files_under(folder.parent)
    return {name: digest for name, digest in every.items() if not name.startswith("studio/")}


def told(what: str, outcomes: Iterable[Outcome], seconds: float) -> list[str]:
    """Count the outcomes of some seconds, say which was the slowest, and give the faults."""
    end = time.monotonic() + seconds
    kinds: Counter[str] = Counter()
    slowest = Outcome("", "", 0.0)
    faults = []
    for outcome in outcomes:
        kinds[outcome.kind] += 1
        slowest = max(slowest, outcome, key=lambda each: each.seconds)
        if outcome.kind in ("fault", "slow"):
            faults += [outcome.text] if outcome.kind == "fault" else []
            print(f"  {outcome.text[:600]}", flush=True)
        if time.monotonic() > end:
            break
    counts = ", ".join(f"{count} {kind}" for kind, count in sorted(kinds.items()))
    print(f"{what}: {counts}; slowest {slowest.seconds:.2f} s ({slowest.text[:100]!r})", flush=True)
    return faults


if __name__ == "__main__":
    sys.exit(main())
