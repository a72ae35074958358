"""Fold a pattern by the project in the current folder, and print what it took as JSON.

    python folding_before.py PATTERN LOADS

For `test_fast_folding_bench`, which runs it in two copies of the project; so it uses only what both
have. LOADS ends the fold after so many loads; 0 for the whole fold.
"""

import json
import resource
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path.cwd()))

from fab import read_pattern
from fab.folding.bar_hinge_model import framework
from fab.folding.quasi_static import fold
from fab.folding.verdict import judge


class Enough(Exception):
    """The loads that are asked for are done."""


def main() -> None:
    frame = framework(read_pattern(Path(sys.argv[1]))[0])
    loads = int(sys.argv[2])

    def progress(done, total):
        if loads and done >= loads:
            raise Enough

    out = {"faces": frame.sheet.pattern.face_count}
    begin = time.process_time(), time.perf_counter()
    try:
        folding = fold(frame, progress=progress)
    except Enough:
        folding = None
    out["cpu_s"] = round(time.process_time() - begin[0], 2)
    out["wall_s"] = round(time.perf_counter() - begin[1], 2)
    out["gb"] = round(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20, 2)
    if folding is not None:
        verdict = judge(folding)
        out |= {"systems": folding.iterations, "reached": verdict.reached}
        out |= {"wrong": verdict.wrong_creases, "off": verdict.off_creases}
        out["crossings"] = [point.crossings for point in verdict.path]
    print(json.dumps(out))


if __name__ == "__main__":
    main()
