"""Imported lines against `shapely.node`, without letters and faces, and by number.

    pytest tests/bench/test_import_bench.py --benchmark-only -s

Lines that cross nowhere: the sides of a lattice of distorted squares. Lines that cross often, or
are on each other, take bounded time and memory.
"""

import time
import tracemalloc
from pathlib import Path

import numpy as np
import shapely

from fab.errors import InvalidFile
from fab.formats.drawn.importer import pattern_of_lines
from fab.formats.drawn.line_soup import LineSoup
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
    begin = time.process_time()
    function(*values)
    return time.process_time() - begin


def test_lines_that_cross_nowhere(benchmark):
    counts, graphs, patterns, nodes = [], [], [], []
    for count in (10_000, 40_000, 100_000, 160_000):
        soup = soup_of_lattice(count)
        lines = soup.lines_coords
        counts.append(len(lines))
        shapes = shapely.multilinestrings(shapely.linestrings(lines))
        nodes.append(min(seconds(shapely.node, shapes) for _ in range(3)))
        graphs.append(min(seconds(arrangement, lines, 0.05) for _ in range(3)))
        patterns.append(min(seconds(pattern_of_lines, soup) for _ in range(3)))
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


def framed(lines):
    """Mountains within a square of 100."""
    corners = np.array([[0, 0], [100, 0], [100, 100], [0, 100]], float)
    coords = np.concatenate([np.stack([corners, np.roll(corners, -1, axis=0)], axis=1), lines])
    number = np.arange(len(coords))
    letters = np.where(number < 4, "B", "M")
    angles = np.full(len(coords), -90.0)
    names = tuple(map(str, number))
    return LineSoup(Path("soup.svg"), "soup", coords, letters, angles, number, names, 1.0)


def grid(count):
    at, low, high = (np.arange(count) + 0.5) * 100 / count, np.zeros(count), np.full(count, 100.0)
    upright = np.stack([np.column_stack([at, low]), np.column_stack([at, high])], axis=1)
    return np.concatenate([upright, upright[..., ::-1]])


def short_lines(count, length=140):
    """About twice as many crossings as lines; of half the length many parts that do not meet."""
    random = np.random.default_rng(count)
    middles, turn = random.uniform(2, 98, (count, 2)), random.uniform(0, np.pi, count)
    arm = length / np.sqrt(count) * np.column_stack([np.cos(turn), np.sin(turn)])
    return np.clip(np.stack([middles - arm, middles + arm], axis=1), 0, 100)


def scratches(count):
    """Loose lines, one in each cell of a lattice, and a triangle amid them."""
    random, side = np.random.default_rng(count), int(np.ceil(np.sqrt(count)))
    cells = np.column_stack(np.divmod(np.arange(count), side))
    middles, turn = cells + random.uniform(0.4, 0.6, (count, 2)), random.uniform(0, np.pi, count)
    arm = 0.1 * np.column_stack([np.cos(turn), np.sin(turn)])
    corners = 0.05 * np.array([[0, 0], [1, 0], [0, 1]]) + side // 2
    island = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)
    loose = np.stack([middles - arm, middles + arm], axis=1)
    return np.concatenate([loose, island]) * 100 / side


def star(count, noise):
    random = np.random.default_rng(count)
    turn = np.arange(count) * np.pi / count
    arm = 45 * np.column_stack([np.cos(turn), np.sin(turn)])
    middle = 50 + random.normal(size=(count, 2)) * noise
    return np.stack([middle - arm, middle + arm], axis=1)


def on_one_line(count):
    ends = np.random.default_rng(count).uniform(0, 100, (count, 2))
    return np.stack([ends, np.full((count, 2), 50.0)], axis=2)


SOUPS = {
    "grid of 300 x 300": (grid(300), False),
    "10,000 lines with 22,000 crossings": (short_lines(10_000), False),
    "10,000 lines in many parts": (short_lines(10_000, 60), False),
    "30,000 scratches around an island": (scratches(30_000), False),
    "300 lines through one point": (star(300, 0.0), False),
    "300 lines through almost one point": (star(300, 1e-3), False),
    "300 lines near to one point": (star(300, 0.05), False),
    "300 on one line": (on_one_line(300), False),
    "10,000 on one line": (on_one_line(10_000), True),
    "100,000 across each other": (np.random.default_rng(0).uniform(0, 100, (100_000, 2, 2)), True),
}
LONGEST_S, MOST_MB = 30.0, 1000


def test_lines_that_cross_often(benchmark):
    """Bounded time and memory: a pattern, or a refusal before much of both is spent."""
    figures = {}
    for name, (lines, refused) in SOUPS.items():
        soup = framed(lines)
        tracemalloc.start()
        begin = time.process_time()
        try:
            edges = len(pattern_of_lines(soup).pattern.edges_vertices)
        except InvalidFile:
            edges = 0
        taken, peak = time.process_time() - begin, tracemalloc.get_traced_memory()[1] / 1e6
        tracemalloc.stop()
        figures[name] = f"{taken:.2f} s, {peak:.0f} MB, {edges} edges"
        assert (edges == 0) == refused, name
        assert taken <= LONGEST_S, name
        assert peak <= MOST_MB, name
    benchmark.pedantic(pattern_of_lines, args=(framed(grid(10)),))
    benchmark.extra_info.update(figures)
    print(f"\n{figures}")
