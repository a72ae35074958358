"""The fewest columns with which a sheet is as fine as wanted."""

import numpy as np
import pytest
from surface_meshes import cap, grid, mesh_of

from solver import Status
from solver.relaxed_fit import relaxed_fit, resolved_fit
from solver.resolution import fewest_columns

BOUNDS = {"first": 14, "least": 4, "most": 400}


@pytest.mark.parametrize("power", [0.7, 1.0, 1.6])
@pytest.mark.parametrize("bound", [0.04, 0.2, 0.9, 2.0])
def test_few_trials_find_columns_that_are_fine_enough_and_not_too_fine(power, bound):
    def size(n):
        return 10.0 / n**power

    found = fewest_columns(lambda n: n, size, bound, **BOUNDS)
    assert len(found.sizes) <= 5
    assert found.sheet == found.columns
    least = int(np.ceil((10.0 / bound) ** (1 / power)))
    if least > 400:  # which is seen without making a sheet of so many
        assert not found.held
        assert list(found.sizes) == [14, 56]
        assert found.columns == 56
        assert found.needed == pytest.approx(least, rel=0.02)
    else:
        assert found.needed is None
        assert found.held
        assert size(found.columns) <= bound
        assert found.columns <= max(4, np.ceil(1.3 * least))


def test_sizes_that_do_not_fall_end_with_the_finest_sheet():
    found = fewest_columns(lambda n: n, lambda n: 1.0 + (n % 7), 0.5, **BOUNDS)
    assert not found.held
    assert found.sizes[found.columns] == min(found.sizes.values())
    assert len(found.sizes) <= 5


@pytest.mark.parametrize("wanted", [{"cell": 3.0}, {"distance": 2.0}])
def test_sheets_are_as_fine_as_wanted(wanted):
    """In a unit of which a hundred are as long as the sheet is wide."""
    mesh = mesh_of(cap(np.pi / 4, 12, 36))
    trials = []

    def fit(columns):
        trials.append(columns)
        return relaxed_fit(mesh, columns, zigzag=2.0, row_step=1.0, turn=0.0)

    def unit(sheet):
        return float(np.ptp(sheet.vertices_coords, axis=0).max()) / 30

    growth = resolved_fit(fit, unit=unit, **wanted)
    assert growth.status is Status.GROWN
    (bound,) = wanted.values()
    reached = growth.chosen["step"] if "cell" in wanted else growth.distance
    assert 0.6 * bound < reached / unit(growth.mesh) <= bound
    assert trials[0] == 14
    assert growth.chosen["columns"] in trials
    fine = resolved_fit(lambda columns: growth, unit=unit, cell=1e-6)
    assert fine.status is Status.NOT_FITTED
    assert "cell = 1e-06 is not reached: 2 sheets tried have" in fine.advice
    assert "columns would be needed, and 400 is the most: allow about" in fine.advice


def test_the_direction_with_the_fewest_columns_is_taken_for_a_distance():
    """Across the shorter side of a long roof, the same columns are much finer."""
    roof = mesh_of(grid(lambda u, v: (3 * u, v, 0.2 * (1 - v * v)), 36, 12))
    given = {"zigzag": 1.0, "row_step": 1.0}
    wide = [relaxed_fit(roof, 8, **given, turn=turn).distance for turn in (np.pi / 2, 0.0)]
    assert max(wide) > 2 * min(wide)
    nearest = relaxed_fit(roof, 8, **given, nearest=True)
    assert nearest.status is Status.GROWN
    assert nearest.distance == min(wide)


def test_the_distance_from_the_surface_is_half_the_thickness_and_the_deviation():
    growth = relaxed_fit(mesh_of(cap(np.pi / 4, 12, 36)), 10, zigzag=2.0, row_step=1.0, turn=0.0)
    half = growth.chosen["step"] * growth.chosen["thickness"] / 2
    largest = np.abs(growth.deviations).max()
    assert half <= growth.distance <= half + largest + 1e-12
    radius = np.linalg.norm(growth.mesh.vertices_coords, axis=1)
    assert half == pytest.approx(np.median(np.abs(radius - 1)), abs=0.02)
