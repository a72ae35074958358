"""Surface fitting at the published full size, search included, against verification passes.

pytest tests/bench --benchmark-only
"""

import time

import numpy as np

from solver import Status, SurfaceFit, developability, planarity


def test_full_size_fit_against_verification(benchmark):
    design = SurfaceFit(columns=320, row_step=1.2)
    growth = benchmark.pedantic(design.grow, rounds=1)
    assert growth.status is Status.GROWN
    coords, faces = growth.mesh.vertices_coords, growth.mesh.faces_vertices
    passes = []
    for _ in range(5):
        begin = time.perf_counter()
        worst = max(planarity(coords, faces).max(), developability(coords, faces).max())
        passes.append(time.perf_counter() - begin)
    ratio = benchmark.stats.stats.median / np.median(passes)
    benchmark.extra_info.update(growth_per_verification=round(ratio, 1), worst=float(worst))
    print(f"\n320 x {len(faces) // 320} quads: fit / verification = {ratio:.1f}, {worst:.1e}")
