"""Growth from ten thousand to a million quads: cost of a quad, and memory.

pytest tests/bench --benchmark-only -s
"""

import time
import tracemalloc

import numpy as np
import pytest

from solver import Miura, developability, planarity


def sheet(rows: int, columns: int) -> Miura:
    return Miura(columns=columns, rows=rows, fold=np.radians(30))


@pytest.mark.parametrize(
    ("rows", "columns"), [(100, 100), (316, 316), (1000, 1000), (1000, 100), (100, 1000)]
)
def test_cost_of_a_quad(benchmark, rows, columns):
    """`relative_cost` is the cost of a quad over that in the 100 x 100 sheet, grown in turn."""
    quads = rows * columns
    many = max(1, 40_000 // quads)
    small, times = sheet(100, 100), []

    def setup() -> None:
        begin = time.perf_counter()
        for _ in range(4):
            small.grow()
        times.append((time.perf_counter() - begin) / 4)

    def grow_many() -> None:
        for _ in range(many):
            sheet(rows, columns).grow()

    rounds = max(5, 400_000 // (quads * many))
    benchmark.pedantic(grow_many, setup=setup, rounds=rounds, warmup_rounds=1)
    cost = benchmark.stats.stats.median / many / quads
    relative = cost / (np.median(times) / 1e4)
    benchmark.extra_info.update(relative_cost=round(relative, 2))
    print(f"\n{rows} x {columns}: {cost * 1e6:.2f} us per quad, {relative:.2f} of 100 x 100")


def peak(work) -> int:
    """Most bytes held at once beyond those held before."""
    tracemalloc.start()
    try:
        work()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("size", [100, 1000])
def test_memory_of_a_quad(benchmark, size):
    design = sheet(size, size)
    mesh = benchmark.pedantic(design.grow, rounds=1)
    mesh = mesh.mesh
    coords, faces = mesh.vertices_coords, mesh.faces_vertices
    held = sum(array.nbytes for array in (coords, faces, mesh.grid))
    measured = {
        "held": held,
        "growth": peak(design.grow),
        "planarity": peak(lambda: planarity(coords, faces)),
        "developability": peak(lambda: developability(coords, faces)),
    }
    per_quad = {name: round(size_bytes / len(faces)) for name, size_bytes in measured.items()}
    benchmark.extra_info.update(per_quad)
    print(f"\n{size} x {size}, bytes per quad: {per_quad}")
