"""Films divided along creases: the same bodies, with more and smaller sides."""

import numpy as np
import pytest
import shapely
from build123d import import_step
from flat_patterns import fan, grid
from thick_sheets import shipped_pattern

from fab.geometry.booleans import manifold_of
from fab.geometry.side_loops import side_loops
from fab.panels.bevelled_panels import PanelSettings
from fab.panels.film_parts import connected, creased_films, film_numbers, film_regions
from fab.panels.hinges import HingeSettings
from fab.panels.step import step_bytes
from fab.panels.thick_sheet import thicken

FILM = HingeSettings(kind="film", relief_mm=0.1)


def on_film(pattern):
    return thicken(pattern, PanelSettings(fold_limit_deg=120.0), FILM)[0]


PATTERNS = {
    "grid": grid(4, 3, 20.0, without=[(1, 1)], cuts=[(6, 7)]),
    "fan": fan(7, 40.0),
    "waterbomb": shipped_pattern("waterbomb", 200.0),
}


@pytest.mark.parametrize("name", PATTERNS)
def test_regions_cover_the_film_each_within_its_face(name):
    sheet = on_film(PATTERNS[name])
    pattern = sheet.pattern
    rings = np.split(pattern.vertices_coords[pattern.faces_vertices], pattern.faces_offsets[1:-1])
    faces = [shapely.Polygon(ring).buffer(1e-9) for ring in rings]
    for number in film_numbers(sheet).tolist():
        mesh = sheet.bodies.mesh(number)
        regions = film_regions(mesh, pattern)
        assert all(faces[face].contains(region) for region, face in regions)
        volume = sum(region.area for region, _ in regions) * sheet.hinge.film_mm
        assert volume == pytest.approx(manifold_of(mesh).volume(), rel=1e-12)


@pytest.mark.parametrize("name", PATTERNS)
def test_divided_films_are_the_same_solids_without_large_sides(name):
    sheet = on_film(PATTERNS[name])
    bodies = creased_films(sheet)
    assert bodies.volumes_mm3() == pytest.approx(sheet.bodies.volumes_mm3(), rel=1e-12)
    for number in film_numbers(sheet).tolist():
        old, new = manifold_of(sheet.bodies.mesh(number)), manifold_of(bodies.mesh(number))
        assert (new - old).volume() + (old - new).volume() < 1e-9
    loops = side_loops(bodies.chosen(film_numbers(sheet)))
    assert loops.outer.all()  # no side has a hole
    assert np.diff(loops.offsets).max() < 60


def test_step_files_of_films_are_read_as_valid_solids(tmp_path):
    sheet = on_film(PATTERNS["fan"])
    (tmp_path / "fan.step").write_bytes(step_bytes(sheet, "fan"))
    made = import_step(tmp_path / "fan.step")
    solids = made.solids()
    assert len(solids) == len(sheet.bodies)
    assert all(solid.is_valid for solid in solids)
    assert sum(solid.volume for solid in solids) == pytest.approx(sheet.bodies.volumes_mm3().sum())


def test_regions_that_share_a_corner_alone_are_apart():
    squares = [shapely.box(x, y, x + 1, y + 1) for x, y in ((0, 0), (1, 0), (2, 1), (5, 5))]
    groups = connected(squares)
    assert sorted(len(group) for group in groups) == [1, 1, 2]
    assert {id(square) for group in groups for square in group} == {id(s) for s in squares}
