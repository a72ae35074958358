"""Crossing faces against verification: one pass of planarity and developability over the sheet.

    pytest tests/bench --benchmark-only

The ratio of both medians and the exponent of the cost are in the benchmark's `extra_info`.
"""

import time

import numpy as np
import pytest

from solver import Miura, developability, planarity
from solver.self_intersection import crossing_faces


def sheets(faces: int, crossed: bool):
    """A Miura sheet of about so many faces, or two halves of that pushed through each other."""
    side = round((faces / 2 if crossed else faces) ** 0.5)
    mesh = Miura(columns=side, rows=side, fold=np.radians(60)).grow().mesh
    coords, quads = mesh.vertices_coords, mesh.faces_vertices
    if not crossed:
        return coords, quads
    middle = coords.mean(axis=0)
    other = (coords - middle)[:, [2, 0, 1]] + middle + [0.013, 0.017, 0.019]
    return np.concatenate([coords, other]), np.concatenate([quads, quads + len(coords)])


def seconds(ask, rounds: int) -> float:
    taken = []
    for _ in range(rounds):
        begin = time.perf_counter()
        ask()
        taken.append(time.perf_counter() - begin)
    return float(np.median(taken))


@pytest.mark.parametrize("crossed", [False, True])
def test_crossings_against_verification(benchmark, crossed):
    sizes = np.array([1_000, 10_000, 80_000])
    costs, ratios, pairs = [], [], []
    for size in sizes:
        coords, quads = sheets(size, crossed)
        corners, offsets = quads.ravel(), np.arange(len(quads) + 1) * 4

        def check(coords=coords, corners=corners, offsets=offsets):
            return crossing_faces(coords, corners, offsets)

        def verify(coords=coords, quads=quads):
            return max(planarity(coords, quads).max(), developability(coords, quads).max())

        costs.append(seconds(check, 3))
        ratios.append(round(costs[-1] / seconds(verify, 5), 1))
        pairs.append(len(check()))
    benchmark.pedantic(check, rounds=3)
    assert pairs[0] > 0 if crossed else pairs == [0, 0, 0]
    exponent = float(np.polyfit(np.log(sizes), np.log(costs), 1)[0])
    benchmark.extra_info.update(per_verification=ratios, exponent=round(exponent, 2), pairs=pairs)
    print(f"\ncrossing / verification = {ratios}, exponent {exponent:.2f}, pairs {pairs}")
