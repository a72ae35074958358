"""Tours against nearest neighbours alone and a lower bound, and their time by number of lines.

    pytest tests/bench --benchmark-only -s

The lower bound is the shortest tree that joins all lines and the head, the lines themselves free:
every tour of all lines is such a tree. All figures are in the benchmark's `extra_info`.
"""

import time

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import minimum_spanning_tree
from scipy.spatial import Delaunay

from fab.drawings.cut_paths import CutPaths, Layer, Operation
from fab.sheets.crease_cuts import cuts_along
from fab.sheets.crease_styles import DashStyle
from fab.sheets.cutting_order import tour
from fab.sheets.tours import nearest_neighbours, travel_mm

HEAD = np.zeros(2)


def scattered(count):
    """Short lines anywhere."""
    rng = np.random.default_rng(count)
    begin = rng.uniform(0, 4 * count**0.5, (count, 2))
    angle = rng.uniform(0, 2 * np.pi, count)
    return np.stack([begin, begin + 3 * np.column_stack([np.cos(angle), np.sin(angle)])], axis=1)


def perforated(count):
    """Dashes on about that many places of a zigzag grid of creases, 20 mm apart."""
    side = round((count / 10) ** 0.5)
    x, y = np.meshgrid(np.arange(side + 1) * 20.0, np.arange(side + 1) * 20.0)
    grid = np.stack([x + 6 * (np.arange(side + 1) % 2)[:, None], y], axis=-1)
    across = np.stack([grid[:, :-1], grid[:, 1:]], axis=2).reshape(-1, 2, 2)
    along = np.stack([grid[:-1], grid[1:]], axis=2).reshape(-1, 2, 2)
    creases = np.concatenate([across, along])
    return cuts_along(creases, DashStyle(cut_mm=3.0, gap_mm=1.0), 0.5).segments


def tree_length(segments):
    """Length of the shortest tree over the head and all lines, the lines free."""
    points = np.concatenate([segments.reshape(-1, 2), HEAD[None]])
    triangles = Delaunay(points).simplices
    sides = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    line = np.minimum(np.arange(len(points)) // 2, len(segments))
    low, high = np.sort(line[sides], axis=1).T
    far = np.hypot(*(points[sides[:, 0]] - points[sides[:, 1]]).T)
    # several links of the same two lines would be added up: the shortest counts
    order = np.lexsort([far, high, low])
    low, high, far = low[order], high[order], far[order]
    first = np.r_[True, (np.diff(low) != 0) | (np.diff(high) != 0)] & (low != high)
    size = len(segments) + 1
    graph = coo_array((far[first], (low[first], high[first])), shape=(size, size)).tocsr()
    return float(minimum_spanning_tree(graph).sum())


@pytest.mark.parametrize("lines", [scattered, perforated])
def test_tours(benchmark, lines):
    sizes, seconds, alone, bound = [], [], [], []
    for count in (1_000, 10_000, 100_000):
        segments = lines(count)
        paths = CutPaths((Layer(Operation.VALLEY, segments),), (1.0, 1.0))
        begin = time.perf_counter()
        toured = tour(paths).layers[0].segments
        seconds.append(time.perf_counter() - begin)
        ends, number = segments.reshape(-1, 2), np.arange(2 * len(segments))
        entries = nearest_neighbours(ends, number // 2, number ^ 1, HEAD)
        nearest = np.stack([ends[entries], ends[entries ^ 1]], axis=1)
        travel = travel_mm(toured, HEAD)
        sizes.append(len(segments))
        alone.append(round(travel / travel_mm(nearest, HEAD), 3))
        bound.append(round(travel / tree_length(segments), 3))
    benchmark.pedantic(tour, args=(CutPaths((Layer(Operation.VALLEY, lines(1_000)),), (1, 1)),))
    assert max(alone) < 1 <= min(bound)
    exponent = round(float(np.polyfit(np.log(sizes), np.log(seconds), 1)[0]), 2)
    seconds = [round(s, 2) for s in seconds]
    figures = {"lines": sizes, "seconds": seconds, "exponent": exponent}
    figures |= {"per_nearest_neighbours": alone, "per_lower_bound": bound}
    benchmark.extra_info.update(figures)
    print(f"\n{lines.__name__}: {figures}")
