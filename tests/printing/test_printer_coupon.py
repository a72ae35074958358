"""The test print of a printer: exact gaps, sound bodies, numbers that tell them apart."""

import io
import json
from itertools import combinations

import numpy as np
import pytest
import shapely
import trimesh
from click.testing import CliRunner

from fab.catalogue import known_of
from fab.cli.group import main
from fab.errors import Severity
from fab.geometry.booleans import manifolds, section
from fab.jobs.printer_coupon_files import CouponFormat, make_printer_coupon
from fab.printing.printer_coupon import printer_coupon
from fab.printing.printers import load_print_material, load_printer
from fab.printing.raised_digits import number_outline
from solver.errors import InvalidValue

PRINTER = load_printer("prusa_mk4s")
PP = load_print_material("pp_filament")


def plates(coupon, above_mm):
    """Each plate with its plugs, from left to right, as figures at a height."""
    figures = [section(coupon.bodies.mesh(i), above_mm) for i in range(len(coupon.bodies))]
    with_holes = [figure for figure in figures if len(getattr(figure, "interiors", ())) > 5]
    for plate in with_holes:
        hull = shapely.convex_hull(plate)
        plugs = [figure for figure in figures if figure is not plate and hull.contains(figure)]
        yield plate, sorted(plugs, key=lambda plug: plug.centroid.x)


def test_plugs_have_exactly_the_gaps_that_are_raised_beside_them():
    coupon = printer_coupon(PRINTER, PP)
    assert [each.gap_mm for each in coupon.gaps[:7]] == [0.1, 0.15, 0.2, 0.25, 0.3, 0.4, 0.5]
    both = list(plates(coupon, 1.0))
    assert len(both) == 2
    tried = iter(coupon.gaps)
    for plate, plugs in both:
        for plug in plugs:
            gap = plate.distance(plug)
            assert 0 <= gap - next(tried).gap_mm < 0.01  # polygons in place of circles
    assert next(tried, None) is None


def test_the_plate_with_the_notch_is_cut_back_at_the_bed():
    coupon = printer_coupon(PRINTER, PP)
    drawn = np.array([0.1, 0.15, 0.2, 0.25, 0.3, 0.4, 0.5])
    for above in (0.05, 0.14):
        plain, cut = plates(coupon, above)
        for (plate, plugs), wider in ((plain, 0.0), (cut, 2 * PRINTER.first_layer_mm)):
            gaps = [plate.distance(plug) for plug in plugs]
            assert gaps == pytest.approx(drawn + wider, abs=0.01)
    assert shapely.area(shapely.convex_hull(cut[0])) - shapely.Polygon(cut[0].exterior).area > 3.0
    powder = printer_coupon(load_printer("sls_nylon"), None)
    assert not any(each.cut_back for each in powder.gaps)
    assert "notch" not in " ".join(powder.reading)


@pytest.mark.parametrize("name", known_of("printer"))
def test_every_printer_has_one_of_sound_bodies_that_stay_apart(name):
    printer = load_printer(name)
    made = make_printer_coupon(printer, PP, f"coupon_{name}")
    assert made.findings == ()
    coupon = printer_coupon(printer, PP)
    assert coupon.bodies.vertices_coords[:, 2].min() == pytest.approx(0)
    volumes = coupon.bodies.volumes_mm3()
    for solid, volume in zip(manifolds(coupon.bodies), volumes, strict=True):
        assert solid.volume() == pytest.approx(volume)
    mesh = trimesh.load_mesh(io.BytesIO(made.files[f"coupon_{name}.stl"]), file_type="stl")
    assert mesh.is_watertight
    assert mesh.body_count == len(coupon.bodies)
    assert mesh.volume == pytest.approx(volumes.sum(), rel=1e-6)
    sides = sorted(made.report["bounding_box_mm"]["print"][:2])
    assert (np.array(sides) <= np.sort(printer.room_mm)).all()
    z = 1.5 * printer.layer_mm
    figures = [section(coupon.bodies.mesh(i), z) for i in range(len(coupon.bodies))]
    least = min(one.distance(other) for one, other in combinations(figures, 2))
    assert least >= min(each.gap_mm for each in coupon.gaps) - 1e-6


def test_webs_are_whole_layers_and_as_long_as_the_strain_of_the_material_wants():
    coupon = printer_coupon(PRINTER, PP)
    assert [each.web_mm for each in coupon.webs] == [0.2, 0.4, 0.6, 0.8]
    for each in coupon.webs:
        assert each.strain == pytest.approx(each.web_mm * np.pi / 2 / (2 * each.length_mm))
        assert each.strain <= PP.strain_max + 1e-9
    stiff = printer_coupon(PRINTER, PP.model_copy(update={"strain_max": PP.strain_max / 2}))
    assert stiff.webs[3].length_mm == pytest.approx(2 * coupon.webs[3].length_mm)


def test_a_bed_that_is_too_small_is_refused_with_the_size_that_would_do():
    small = PRINTER.model_copy(update={"bed_mm": (70.0, 70.0)})
    with pytest.raises(InvalidValue, match="bed = 60 x 60 mm"):
        printer_coupon(small, PP)


def test_numbers_differ_and_have_one_part_for_each_digit():
    outlines = [number_outline(digit, 0.8) for digit in range(10)]
    for one, other in combinations(outlines, 2):
        assert shapely.symmetric_difference(one, other).area >= 0.8 * 0.8
    assert len(shapely.get_parts(number_outline(105, 0.8))) == 3


def test_the_same_print_has_the_same_bytes():
    one, other = (make_printer_coupon(PRINTER, PP, "coupon") for _ in range(2))
    assert dict(one.files) == dict(other.files)


def test_the_command_says_how_to_read_it(tmp_path):
    run = ["coupon", "--printer", "prusa_mk4s", "--material", "pp_filament", "--out", str(tmp_path)]
    done = CliRunner().invoke(main, [*run, "--only", "3mf"])
    assert done.exit_code == 0, done.output
    names = {path.name for path in tmp_path.iterdir()}
    name = "coupon_prusa_mk4s_pp_filament"
    assert names == {f"{name}.3mf", f"{name}_report.json"}
    report = json.loads((tmp_path / f"{name}_report.json").read_text())
    for number, sentence in enumerate(report["how_to_read"], 1):
        assert f"{number}. {sentence}" in done.output
    both = CliRunner().invoke(main, [*run, "--machine", "co2_60w_600x400"])
    assert both.exit_code == 2
    assert "--machine and --printer exclude each other" in both.output
    assert CliRunner().invoke(main, [*run, "--only", "dxf"]).exit_code == 2


def test_one_format_alone_is_made():
    made = make_printer_coupon(PRINTER, None, "test", [CouponFormat.STL])
    assert list(made.files) == ["test.stl", "test_report.json"]
    assert made.report["material"] is None
    assert all(finding.severity is not Severity.ERROR for finding in made.findings)
