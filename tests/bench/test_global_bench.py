"""Growth against global optimisation: the same folded wavy sheet, from the same unplanarised rows.

    pytest tests/bench --benchmark-only -s

Both make a sheet of the same number of quads between two offsets of the wavy surface of figure 4A.
Growth takes two planarised strips in the middle (counted) and every flap angle's search (counted).
The global methods move all vertices of the zigzag rows on both offsets at once until quads are
planar and inner vertices developable, with exact sparse Jacobians:

- `least_squares`: scipy's trust-region reflective method; steps by lsmr.
- Gauss-Newton: the shortest step that meets the linearised constraints, by sparse LU.

Growth keeps every vertex on its offset; the global methods are free to leave it.
"""

import time
from dataclasses import dataclass

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.sparse import csr_array
from scipy.sparse.linalg import splu

from solver import QuadMesh, Status, SurfaceFit, developability, planarity
from solver.designs.surface_fit import SURFACES
from solver.measure import angle_excess
from solver.mesh import interior_vertices
from solver.vectors import cross, dot, norm

# What the sheets' planarity and developability, in radians, must reach whichever way they are made.
WANTED = 1e-12
# Both converge quadratically: after a step this small, in steps of v, nothing but rounding is left.
LAST_STEP = 1e-9
# Swing of the rows in steps of v (see `SurfaceFit`).
ZIGZAG = 2.0


@dataclass(frozen=True)
class Constraints:
    """Planarity of quads and developability of inner vertices, as functions of all coordinates.

    Dimensionless: volumes of the quads' tetrahedra over scale^3, angle excesses in radians;
    coordinates are counted in scale.
    """

    quads: np.ndarray
    inside: np.ndarray

    def miss(self, x: np.ndarray) -> np.ndarray:
        points = x.reshape(-1, 3)
        e = points[self.quads[:, 1:]] - points[self.quads[:, :1]]
        volume = dot(e[:, 0], cross(e[:, 1], e[:, 2]))
        excess = angle_excess(points, self.quads, self.inside)[self.inside]
        return np.concatenate([volume, excess])

    def jacobian(self, x: np.ndarray) -> csr_array:
        points, quads = x.reshape(-1, 3), self.quads
        e = points[quads[:, 1:]] - points[quads[:, :1]]
        slopes = [cross(e[:, 1], e[:, 2]), cross(e[:, 2], e[:, 0]), cross(e[:, 0], e[:, 1])]
        by_corner = np.stack([-(slopes[0] + slopes[1] + slopes[2]), *slopes], axis=1)
        # angle at a corner by its two ends: perpendicular to each side, over its length
        keep = self.inside[quads]
        number = len(quads) + np.cumsum(self.inside) - 1
        corner = quads[keep]
        after, before = np.roll(quads, -1, axis=1)[keep], np.roll(quads, 1, axis=1)[keep]
        u, v = points[after] - points[corner], points[before] - points[corner]
        size_u, size_v = norm(u)[:, None], norm(v)[:, None]
        u, v = u / size_u, v / size_v
        cosine, sine = dot(u, v)[:, None], norm(cross(u, v))[:, None]
        by_u, by_v = (cosine * u - v) / (size_u * sine), (cosine * v - u) / (size_v * sine)
        rows = np.concatenate([np.repeat(np.arange(len(quads)), 4), np.tile(number[corner], 3)])
        vertices = np.concatenate([quads.ravel(), after, before, corner])
        values = np.concatenate([by_corner.reshape(-1, 3), by_u, by_v, -by_u - by_v])
        columns = 3 * vertices[:, None] + np.arange(3)
        shape = (len(quads) + int(self.inside.sum()), x.size)
        return csr_array((values.ravel(), (np.repeat(rows, 3), columns.ravel())), shape=shape)


def guess(rows: int, columns: int, row_step: float) -> QuadMesh:
    """Zigzag rows on both offsets, as growth's seed before it is planarised, all over the sheet."""
    step = 2 / columns
    v = (np.arange(columns + 1) - columns / 2) * step
    swing = ZIGZAG * step * (np.arange(columns + 1) % 2 - 0.5)
    along = (np.arange(rows + 1) - rows / 2) * row_step * step
    uv = np.stack([np.add.outer(along, swing), np.broadcast_to(v, (rows + 1, columns + 1))], -1)
    level = np.repeat(np.where(np.arange(rows + 1) % 2, 0.5, -0.5) * step, columns + 1)
    target, flat = SURFACES["waves"], uv.reshape(-1, 2)
    points = target.point(flat) + level[:, None] * target.normal(flat)
    return QuadMesh.from_rows(points.reshape(rows + 1, columns + 1, 3))


def residuals(coords: np.ndarray, quads: np.ndarray) -> tuple[float, float]:
    return float(planarity(coords, quads).max()), float(developability(coords, quads).max())


def by_least_squares(constraints: Constraints, x: np.ndarray) -> tuple[np.ndarray, int]:
    solved = least_squares(
        constraints.miss,
        x,
        constraints.jacobian,
        method="trf",
        tr_solver="lsmr",
        tr_options={"atol": 1e-12, "btol": 1e-12, "maxiter": 20_000},
        ftol=None,
        xtol=LAST_STEP / np.linalg.norm(x),
        gtol=None,
        max_nfev=100,
    )
    return solved.x, solved.nfev


def by_gauss_newton(constraints: Constraints, x: np.ndarray) -> tuple[np.ndarray, int]:
    last, steps = np.inf, 0
    while last > LAST_STEP and steps < 100:
        jacobian = constraints.jacobian(x)
        step = jacobian.T @ splu((jacobian @ jacobian.T).tocsc()).solve(-constraints.miss(x))
        x, last, steps = x + step, float(np.linalg.norm(step)), steps + 1
    return x, steps


@pytest.mark.parametrize(("columns", "row_step"), [(20, 0.8), (40, 1.0)])
def test_growth_against_global_optimisation(benchmark, columns, row_step):
    design = SurfaceFit(columns=columns, zigzag=ZIGZAG, row_step=row_step)
    growth = benchmark.pedantic(design.grow, rounds=5, warmup_rounds=1)
    grown, mesh = benchmark.stats.stats.median, growth.mesh
    assert growth.status is Status.GROWN
    rows = len(mesh.grid) - 1
    start = guess(rows, columns, row_step)
    quads = start.faces_vertices
    assert quads.shape == mesh.faces_vertices.shape
    print(f"\n{rows} x {columns} quads grown in {grown * 1e3:.0f} ms")
    for name, known in (("growth", mesh), ("guess", start)):
        flat, bent = residuals(known.vertices_coords, known.faces_vertices)
        print(f"{name}: planarity {flat:.1e}, developability {bent:.1e}")

    constraints = Constraints(quads, interior_vertices(quads, len(start.vertices_coords)))
    x = (start.vertices_coords * columns / 2).ravel()
    for name, method in (("Gauss-Newton", by_gauss_newton), ("least_squares", by_least_squares)):
        begin = time.perf_counter()
        solved, steps = method(constraints, x)
        ratio = (time.perf_counter() - begin) / grown
        flat, bent = residuals(solved.reshape(-1, 3), quads)
        benchmark.extra_info[name] = {
            "global_per_growth": round(ratio, 1),
            "planarity": flat,
            "developability": bent,
        }
        print(
            f"{name} / growth = {ratio:.1f}, {steps} steps, planarity {flat:.1e}, "
            f"developability {bent:.1e}, moved by {np.abs(solved - x).max():.2f} steps of v"
        )
        assert max(flat, bent) < WANTED


def test_the_jacobian_is_that_of_the_constraints():
    mesh = guess(6, 8, 1.0)
    constraints = Constraints(
        mesh.faces_vertices, interior_vertices(mesh.faces_vertices, len(mesh.vertices_coords))
    )
    x = (mesh.vertices_coords * 4).ravel()
    way = np.random.default_rng(0).normal(size=x.size)
    slope = (constraints.miss(x + 1e-6 * way) - constraints.miss(x - 1e-6 * way)) / 2e-6
    assert constraints.jacobian(x) @ way == pytest.approx(slope, rel=1e-6, abs=1e-8)
