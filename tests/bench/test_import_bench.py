"""Planar graphs of lines against `shapely.node`, which gives no letters, and by number of lines.

    pytest tests/bench/test_import_bench.py --benchmark-only -s

Lines that cross nowhere: the sides of a lattice of distorted squares.
"""

import time

import numpy as np
import shapely

from fab.geometry.arrangement import arrangement

LARGEST_RATIO, LARGEST_EXPONENT = 20.0, 1.15


def lattice(count):
    side = round((count / 2) ** 0.5)
    x = np.arange(side + 1.0)
    points = np.stack(np.meshgrid(x, x), axis=-1)
    points += np.random.default_rng(count).uniform(-0.2, 0.2, points.shape)
    down = np.stack([points[:-1], points[1:]], axis=2).reshape(-1, 2, 2)
    return np.concatenate([down, np.stack([points[:, :-1], points[:, 1:]], 2).reshape(-1, 2, 2)])


def seconds(function, *values):
    begin = time.perf_counter()
    function(*values)
    return time.perf_counter() - begin


def test_planar_graphs(benchmark):
    counts, own, nodes = [], [], []
    for count in (1_000, 10_000, 100_000, 400_000):
        lines = lattice(count)
        counts.append(len(lines))
        own.append(min(seconds(arrangement, lines, 0.05) for _ in range(2)))
        nodes.append(seconds(shapely.node, shapely.multilinestrings(shapely.linestrings(lines))))
    benchmark.pedantic(arrangement, args=(lattice(1_000), 0.05))
    exponent = round(float(np.polyfit(np.log(counts[1:]), np.log(own[1:]), 1)[0]), 2)
    ratio = round(own[2] / nodes[2], 2)
    figures = {"lines": counts, "seconds": [round(s, 3) for s in own], "exponent": exponent}
    figures |= {"per_shapely_node": ratio}
    benchmark.extra_info.update(figures)
    print(f"\n{figures}")
    assert ratio <= LARGEST_RATIO
    assert exponent <= LARGEST_EXPONENT
