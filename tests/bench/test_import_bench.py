"""Imported lines against `shapely.node`, without letters and faces, and by number.

    pytest tests/bench/test_import_bench.py --benchmark-only -s

Lines that cross nowhere: the sides of a lattice of distorted squares.
"""

import time
from pathlib import Path

import numpy as np
import shapely

from fab.formats.importer import pattern_of_lines
from fab.formats.line_soup import LineSoup
from fab.geometry.arrangement import arrangement

LARGEST_RATIO, LARGEST_EXPONENT = 20.0, 1.15


def lattice(count):
    side = round((count / 2) ** 0.5)
    x = np.arange(side + 1.0)
    points = np.stack(np.meshgrid(x, x), axis=-1)
    inner = points[1:-1, 1:-1]
    inner += np.random.default_rng(count).uniform(-0.2, 0.2, inner.shape)
    down = np.stack([points[:-1], points[1:]], axis=2).reshape(-1, 2, 2)
    return np.concatenate([down, np.stack([points[:, :-1], points[:, 1:]], 2).reshape(-1, 2, 2)])


def soup_of_lattice(count):
    lines = lattice(count)
    number = np.arange(len(lines))
    rim = ((lines == 0).all(axis=1) | (lines == lines.max()).all(axis=1)).any(axis=1)
    return LineSoup(
        Path("lattice.svg"),
        "lattice",
        lines,
        np.where(rim, "B", "M"),
        np.full(len(lines), -90.0),
        number,
        tuple(map(str, number)),
        1.0,
    )


def seconds(function, *values):
    begin = time.perf_counter()
    function(*values)
    return time.perf_counter() - begin


def test_lines_that_cross_nowhere(benchmark):
    counts, graphs, patterns, nodes = [], [], [], []
    for count in (10_000, 30_000, 100_000, 300_000):
        soup = soup_of_lattice(count)
        lines = soup.lines_coords
        counts.append(len(lines))
        shapes = shapely.multilinestrings(shapely.linestrings(lines))
        nodes.append(min(seconds(shapely.node, shapes) for _ in range(2)))
        graphs.append(min(seconds(arrangement, lines, 0.05) for _ in range(2)))
        patterns.append(min(seconds(pattern_of_lines, soup) for _ in range(2)))
    benchmark.pedantic(pattern_of_lines, args=(soup_of_lattice(1_000),))
    figures = {"lines": counts}
    for name, times in (("graph", graphs), ("pattern", patterns), ("shapely_node", nodes)):
        figures[f"seconds_{name}"] = [round(each, 3) for each in times]
        figures[f"exponent_{name}"] = round(
            float(np.polyfit(np.log(counts), np.log(times), 1)[0]), 2
        )
    figures["pattern_per_shapely_node"] = round(patterns[2] / nodes[2], 2)
    benchmark.extra_info.update(figures)
    print(f"\n{figures}")
    assert figures["pattern_per_shapely_node"] <= LARGEST_RATIO
    assert figures["exponent_pattern"] <= LARGEST_EXPONENT
