"""Front and back of a sheet coincide when the sheet is turned over."""

import numpy as np
import pytest
import shapely
from flat_patterns import triangles

from fab.drawings.cut_paths import CutPaths, Operation, joined
from fab.drawings.dxf import dxf_bytes
from fab.sheets.perforation import perforate
from fab.sheets.perforation_settings import PerforationSettings
from fab.sheets.registration import Axis, Registration, how_to_turn, two_sided
from fab.sheets.relief_holes import ReliefSettings
from solver import InvalidValue

MARGIN = 7.0
REGISTRATION = {axis: Registration(Axis(axis)) for axis in "xy"}
BORDER = 4.0 + 2 * 3.0


@pytest.fixture(scope="module")
def paths():
    """A sheet, wider than high, that is free in its margin and border."""
    settings = PerforationSettings(relief=ReliefSettings(web_mm=1.0))
    tight = perforate(triangles(2), settings)[0]
    layers = [layer.moved(np.eye(2), np.full(2, MARGIN + BORDER)) for layer in tight.layers]
    size = np.array(tight.size_mm) + 2 * (MARGIN + BORDER) + np.array([30.0, 0.0])
    return CutPaths(joined(layers), tuple(size.tolist()))


def turned(points, axis, size):
    """Where a point of the sheet is when the sheet is turned over."""
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
    front, back = two_sided(paths, REGISTRATION[axis], MARGIN)
    assert front.size_mm == back.size_mm == paths.size_mm
    before, f, b = by_operation(paths), by_operation(front), by_operation(back)
    assert set(f) == {Operation.ENGRAVE, Operation.MOUNTAIN, Operation.RELIEF}
    assert set(b) == {Operation.ENGRAVE, Operation.VALLEY, Operation.HOLE, Operation.CUT}
    assert (f[Operation.MOUNTAIN].segments == before[Operation.MOUNTAIN].segments).all()
    for operation in (Operation.VALLEY, Operation.HOLE, Operation.CUT):
        again = turned(b[operation].segments, axis, back.size_mm)
        assert again == pytest.approx(before[operation].segments, abs=1e-9)
        rings = zip(b[operation].outlines, before[operation].outlines, strict=True)
        assert all(
            turned(ring, axis, back.size_mm) == pytest.approx(old, abs=1e-9) for ring, old in rings
        )
    # the wrong turn does not complete it
    other = turned(b[Operation.VALLEY].segments, "y" if axis == "x" else "x", back.size_mm)
    assert np.abs(other - before[Operation.VALLEY].segments).max() > 1.0


@pytest.mark.parametrize("axis", ["x", "y"])
def test_no_line_is_made_twice(paths, axis):
    front, back = two_sided(paths, REGISTRATION[axis], MARGIN)
    over = np.array(back.size_mm)
    every = [lines(layer) for layer in front.layers]
    every += [shapely.transform(lines(la), lambda p: turned(p, axis, over)) for la in back.layers]
    total = sum(shape.length for shape in every)
    assert shapely.union_all(every, grid_size=1e-6).length == pytest.approx(total, abs=1e-3)
    made = sum(lines(layer).length for layer in paths.layers)
    added = 4 * np.pi * 4.0 + 4 * 2 * 2.0 + 2 * BORDER / 2
    assert total == pytest.approx(made + added, abs=0.1)


@pytest.mark.parametrize("axis", ["x", "y"])
def test_holes_and_axis_meet_their_mirror_image_and_no_other(paths, axis):
    front, back = two_sided(paths, REGISTRATION[axis], MARGIN, kerf_mm=0.2)
    holes = [shapely.Polygon(r) for r in by_operation(front)[Operation.RELIEF].outlines[-4:]]
    assert [np.ptp(shapely.get_coordinates(hole), axis=0) for hole in holes] == pytest.approx(
        np.full((4, 2), 3.8), abs=0.01
    )
    every = shapely.union_all(holes)
    size = np.array(front.size_mm)
    over = shapely.transform(every, lambda p: turned(p, axis, size))
    assert over.symmetric_difference(every).area < 1e-9
    wrong = shapely.transform(every, lambda p: turned(p, "y" if axis == "x" else "x", size))
    assert wrong.symmetric_difference(every).area > 1.0
    around = shapely.transform(every, lambda p: size - p)
    assert around.symmetric_difference(every).area > 1.0
    # the crosses of the back are in the holes, which are where they were
    crosses = shapely.linestrings(by_operation(back)[Operation.ENGRAVE].segments)
    assert all(hole.buffer(-0.8).contains(crosses).sum() == 2 for hole in holes)
    middles = {(h.centroid.x, h.centroid.y) for h in holes}
    found = {(c.centroid.x, c.centroid.y) for c in crosses}
    assert sorted(found) == pytest.approx(np.array(sorted(middles)))
    # between the margin and the paths
    inner = shapely.box(MARGIN + BORDER, MARGIN + BORDER, *(size - MARGIN - BORDER))
    assert every.distance(inner) == pytest.approx(3.1, abs=0.005)
    marks = by_operation(front)[Operation.ENGRAVE].segments[-2:]
    assert marks == pytest.approx(turned(marks, axis, size))
    assert shapely.box(MARGIN, MARGIN, *(size - MARGIN)).contains(
        shapely.union_all([every.buffer(2.9), *shapely.linestrings(marks)])
    )
    assert shapely.distance(shapely.linestrings(marks), inner).min() > 1.0
    assert shapely.distance(shapely.linestrings(marks), every).min() > 1.0


def test_sheets_are_turned_about_their_longer_side_by_default(paths):
    width, height = paths.size_mm
    assert width > height
    assert Registration().axis_of((width, height)) is Axis.X
    assert Registration().axis_of((height, width)) is Axis.Y
    assert Registration(Axis.Y).axis_of((width, height)) is Axis.Y
    for default, wanted in zip(
        two_sided(paths, Registration(), MARGIN),
        two_sided(paths, REGISTRATION["x"], MARGIN),
        strict=True,
    ):
        assert dxf_bytes(default) == dxf_bytes(wanted)
    assert "upper edge becomes the lower" in how_to_turn("a", Registration(), (width, height))
    assert "left edge becomes the right" in how_to_turn("a", Registration(), (height, width))


def test_bad_settings_are_refused(paths):
    with pytest.raises(InvalidValue, match="axis = 'z'"):
        Registration("z")
    with pytest.raises(InvalidValue, match="hole_mm"):
        Registration(hole_mm=0.0)
    with pytest.raises(InvalidValue, match="clearance_mm"):
        Registration(clearance_mm=-1.0)
    with pytest.raises(InvalidValue, match="margin_mm = -1"):
        two_sided(paths, Registration(), -1.0)
    for kerf_mm in (-0.1, 4.0, np.nan):
        with pytest.raises(InvalidValue, match="kerf_mm"):
            two_sided(paths, Registration(), MARGIN, kerf_mm)


def test_paths_in_the_border_and_sheets_of_nothing_else_are_refused(paths):
    with pytest.raises(InvalidValue, match=r"edges = 17 mm .* at least 18 mm"):
        two_sided(paths, Registration(), MARGIN + 1.0)
    with pytest.raises(InvalidValue, match=r"40 x 39 mm .* at least 40 mm"):
        two_sided(CutPaths((), (40.0, 39.0)), Registration())
    front, back = two_sided(CutPaths((), (40.0, 40.0)), Registration())
    for side in (front, back):
        points = np.concatenate([lines(layer).bounds for layer in side.layers])
        assert points.min() > 0
        assert points.max() < 40
