"""Front and back of a sheet coincide when the sheet is turned over."""

import numpy as np
import pytest
import shapely
from flat_patterns import triangles

from fab.dxf import dxf_bytes
from fab.paths import Operation
from fab.perforation import PerforationSettings, perforate
from fab.relief import ReliefSettings
from fab.two_sided import Axis, two_sided
from solver import InvalidValue

BORDER = 4.0 + 2 * 3.0


@pytest.fixture(scope="module")
def paths():
    settings = PerforationSettings(relief=ReliefSettings(web_mm=1.0))
    return perforate(triangles(2), settings)[0]


def turned(points, axis, size):
    """Where a point of the sheet comes to lie when the sheet is turned over."""
    out = points.copy()
    across = 1 if axis == "x" else 0
    out[..., across] = size[across] - out[..., across]
    return out


def lines(layer):
    rings = [shapely.LinearRing(ring) for ring in layer.outlines]
    return shapely.union_all([*shapely.linestrings(layer.segments), *rings])


def by_operation(paths):
    return {layer.operation: layer for layer in paths.layers}


@pytest.mark.parametrize("axis", ["x", "y"])
def test_the_back_turned_over_completes_the_front(paths, axis):
    front, back = two_sided(paths, Axis(axis))
    assert front.size_mm == back.size_mm == pytest.approx(np.array(paths.size_mm) + 2 * BORDER)
    before, f, b = by_operation(paths), by_operation(front), by_operation(back)
    assert set(b) == {Operation.ENGRAVE, Operation.VALLEY}
    assert Operation.VALLEY not in f
    again = turned(b[Operation.VALLEY].segments, axis, back.size_mm)
    assert again == pytest.approx(before[Operation.VALLEY].segments + BORDER, abs=1e-9)
    assert f[Operation.MOUNTAIN].segments == pytest.approx(
        before[Operation.MOUNTAIN].segments + BORDER
    )
    assert lines(f[Operation.CUT]).equals_exact(
        shapely.transform(lines(before[Operation.CUT]), lambda p: p + BORDER), 1e-9, normalize=True
    )
    # the wrong turn does not complete it
    other = turned(b[Operation.VALLEY].segments, "y" if axis == "x" else "x", back.size_mm)
    assert np.abs(other - before[Operation.VALLEY].segments - BORDER).max() > 1.0


@pytest.mark.parametrize("axis", ["x", "y"])
def test_holes_and_axis_meet_their_mirror_image_and_no_other(paths, axis):
    front, back = two_sided(paths, axis)
    rings = by_operation(back)[Operation.ENGRAVE].outlines
    assert len(rings) == 4
    holes = [shapely.Polygon(ring) for ring in rings]
    of_front = [shapely.Polygon(r) for r in by_operation(front)[Operation.RELIEF].outlines[-4:]]
    assert all(a.equals(b) for a, b in zip(holes, of_front, strict=True))
    every = shapely.union_all(holes)
    size = np.array(front.size_mm)
    over = shapely.transform(every, lambda p: turned(p, axis, size))
    assert over.symmetric_difference(every).area < 1e-9
    wrong = shapely.transform(every, lambda p: turned(p, "y" if axis == "x" else "x", size))
    assert wrong.symmetric_difference(every).area > 1.0
    around = shapely.transform(every, lambda p: size - p)
    assert around.symmetric_difference(every).area > 1.0
    # outside the outline, inside the sheet
    inner = shapely.box(BORDER, BORDER, *(size - BORDER))
    assert every.distance(inner) == pytest.approx(3.0, abs=0.005)
    assert shapely.box(3 - 1e-9, 3 - 1e-9, *(size - 3 + 1e-9)).contains(every)
    marks = by_operation(front)[Operation.ENGRAVE].segments[-2:]
    assert marks == pytest.approx(by_operation(back)[Operation.ENGRAVE].segments)
    assert marks == pytest.approx(turned(marks, axis, size))
    assert shapely.distance(shapely.linestrings(marks), inner).min() > 1.0
    assert shapely.distance(shapely.linestrings(marks), every).min() > 1.0


def test_everything_lies_within_the_sheet(paths):
    for side in two_sided(paths):
        for layer in side.layers:
            points = np.concatenate([layer.segments.reshape(-1, 2), *layer.outlines])
            assert points.min() > 0
            assert (points < side.size_mm).all()
        assert dxf_bytes(side)


def test_bad_settings_are_refused(paths):
    with pytest.raises(InvalidValue, match="axis = 'z'"):
        two_sided(paths, "z")
    with pytest.raises(InvalidValue, match="hole_mm"):
        two_sided(paths, hole_mm=0.0)
    with pytest.raises(InvalidValue, match="clearance_mm"):
        two_sided(paths, clearance_mm=-1.0)
