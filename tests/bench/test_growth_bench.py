"""Growth against verification: one pass of planarity and developability over the same mesh.

    pytest tests/bench --benchmark-only

The ratio of both medians is in the benchmark's `extra_info`.
"""

import time

import numpy as np
import pytest

from solver import Miura, developability, planarity


def verify(mesh) -> float:
    coords, faces = mesh.vertices_coords, mesh.faces_vertices
    return max(planarity(coords, faces).max(), developability(coords, faces).max())


@pytest.mark.parametrize(("size", "rounds"), [(100, 60), (1000, 5)])
def test_growth_against_verification(benchmark, size, rounds):
    design = Miura(columns=size, rows=size, fold=np.radians(30))
    mesh = design.grow().mesh
    passes = []

    def setup() -> None:
        """Verify between any two growths, so that both see the machine in the same state."""
        begin = time.perf_counter()
        verify(mesh)
        passes.append(time.perf_counter() - begin)

    benchmark.pedantic(design.grow, setup=setup, rounds=rounds, warmup_rounds=1)
    assert len(mesh.faces_vertices) == size * size
    ratio = benchmark.stats.stats.median / np.median(passes)
    worst = float(verify(mesh))
    benchmark.extra_info.update(growth_per_verification=round(ratio, 2), worst=worst)
    print(f"\n{size} x {size}: growth / verification = {ratio:.2f}, residual {worst:.1e}")
