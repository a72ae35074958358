"""A million dashes to DXF against the bare writing of its bytes, and against ezdxf's modelspace.

pytest tests/bench/test_writers_bench.py --benchmark-only -s
"""

import io
import time
import tracemalloc

import ezdxf
import numpy as np

from fab.drawings.cut_paths import CutPaths, Layer, Operation
from fab.drawings.dxf import dxf_bytes, write_dxf


def dashes(count: int) -> CutPaths:
    ends = np.random.default_rng(0).uniform(0, 900, (count, 2, 2))
    half = count // 2
    layers = Layer(Operation.MOUNTAIN, ends[:half]), Layer(Operation.VALLEY, ends[half:])
    return CutPaths(layers, (900.0, 900.0))


def seconds(work) -> float:
    begin = time.perf_counter()
    work()
    return time.perf_counter() - begin


def test_a_million_dashes_cost_little_more_than_their_bytes(benchmark, tmp_path):
    paths = dashes(1_000_000)
    data = dxf_bytes(paths)
    target = tmp_path / "sheet.dxf"

    def bare() -> None:
        with target.open("wb", buffering=0) as file:
            file.write(data)

    def streamed() -> None:
        with target.open("wb", buffering=0) as file:
            write_dxf(file, paths)

    floor, whole = [], []
    for _ in range(7):  # in turn, each over the same removed file, so that both meet the same disk
        for work, taken in ((bare, floor), (streamed, whole)):
            taken.append(seconds(work))
            assert target.stat().st_size == len(data)
            target.unlink()
    ratio = float(np.median(whole) / np.median(floor))
    benchmark.pedantic(streamed, rounds=3)
    tracemalloc.start()
    streamed()
    peak = tracemalloc.get_traced_memory()[1] / len(data)
    tracemalloc.stop()
    figures = {
        "ratio": round(ratio, 2),
        "megabytes": round(len(data) / 1e6),
        "peak": round(peak, 2),
    }
    benchmark.extra_info.update(figures)
    print(f"\nDXF of a million dashes: {figures} (peak memory in sizes of the file)")
    assert ratio < 5
    assert peak < 0.1


def test_a_hundred_thousand_dashes_against_the_modelspace_of_ezdxf(benchmark):
    paths = dashes(100_000)

    def modelspace() -> None:
        document = ezdxf.new("R2000")
        space = document.modelspace()
        for layer in paths.layers:
            for start, end in layer.segments.tolist():
                space.add_line(start, end, dxfattribs={"layer": layer.operation})
        document.write(io.StringIO())

    slow = seconds(modelspace)
    benchmark.pedantic(lambda: dxf_bytes(paths), rounds=5, warmup_rounds=1)
    ratio = slow / benchmark.stats.stats.median
    benchmark.extra_info.update(ratio=round(ratio, 1))
    print(f"\nezdxf's modelspace takes {ratio:.0f} times as long")
    assert ratio > 20
