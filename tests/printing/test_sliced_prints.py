"""Prints in PrusaSlicer: two materials, and gaps that stay open in the first layer."""

import pytest
import shapely
from sliced_layers import least_gap_mm, printed_islands, sliced, wants_slicer
from thick_sheets import book, miura_pattern, thick

from fab.jobs.print_files import ThickFormat, make_thick
from fab.printing.bed_place import BedPlace
from fab.printing.print_objects import PrintObject, sheet_parts
from fab.printing.printers import load_printer
from fab.printing.thick_settings import thick_settings
from fab.printing.threemf import threemf_bytes

# PrusaSlicer rounds its paths by this.
RESOLUTION_MM = 0.0125


@wants_slicer
def test_panels_and_hinges_are_printed_by_two_extruders(tmp_path):
    sheet = thick(miura_pattern())
    place = BedPlace(20.0, (90.0, 80.0))
    path = tmp_path / "miura.3mf"
    whole = PrintObject("miura", tuple(sheet_parts(sheet)), place)
    path.write_bytes(threemf_bytes([whole], "miura"))
    lines = sliced(path, "--nozzle-diameter", "0.4,0.4", "--dont-arrange")
    assert {"T0", "T1"} <= set(lines)
    # both lie where they belong, and hinges between their panels
    # lines of both touch within the rounding of paths
    islands = shapely.union_all(shapely.buffer(printed_islands(lines, 1), 0.05)).buffer(-0.05)
    points = place.moved(sheet.bodies.vertices_coords[:, :2])
    corners = [*points.min(axis=0), *points.max(axis=0)]
    assert islands.bounds == pytest.approx(corners, abs=0.3)  # corners are rounded
    assert islands.geom_type == "Polygon"


@wants_slicer
@pytest.mark.parametrize("angle_deg", [35.0, 90.0])
def test_knuckles_keep_the_least_gap_when_the_first_layer_has_spread(tmp_path, angle_deg):
    changes = (
        "panels.axis=middle",
        "panels.thickness_mm=3.2",
        "hinges.kind=knuckle",
        "hinges.knuckle_mm=3.0",
    )
    settings = thick_settings(changes, "prusa_mk4s", "pp_filament")
    printer = load_printer("prusa_mk4s")
    with_printer = settings.print_with()
    formats = [ThickFormat.THREEMF]
    made = make_thick(book(angle_deg), "book", settings, print_with=with_printer, formats=formats)
    path = tmp_path / "book.3mf"
    path.write_bytes(made.files["book_thick.3mf"])
    islands = printed_islands(sliced(path), 1)
    assert len(islands) >= 2
    kept = least_gap_mm(islands) - 2 * printer.first_layer_mm
    assert kept >= printer.least_gap_mm - RESOLUTION_MM
