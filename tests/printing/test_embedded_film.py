"""Films laid into the middle of panels: what is printed, when it pauses, what is refused."""

import io
import zipfile
from xml.etree import ElementTree

import lib3mf
import numpy as np
import pytest
import shapely
import trimesh
from sliced_layers import sliced, wants_slicer
from thick_sheets import book, miura_pattern, scaled_to

from fab.errors import InvalidJob, Severity
from fab.geometry.booleans import section
from fab.jobs.print_files import ThickFormat, make_thick
from fab.panels.bevelled_panels import PanelSettings
from fab.panels.hinges import HingeSettings
from fab.panels.thick_sheet import thicken
from fab.printing.pauses import film_pause
from fab.printing.thick_settings import thick_settings

EMBEDDED = ("hinges.kind=film", "hinges.embedded=true", "panels.fold_limit_deg=120.0")
PAUSES = "Metadata/Prusa_Slicer_custom_gcode_per_print_z.xml"


def made(*changes, machine="prusa_mk4s", formats=(ThickFormat.STL, ThickFormat.THREEMF)):
    settings = thick_settings((*EMBEDDED, *changes), machine, "pla_filament")
    pattern = scaled_to(miura_pattern(), 120.0)
    return make_thick(pattern, "m", settings, print_with=settings.print_with(), formats=formats)


def notes(of):
    return {finding.code: finding for finding in of.findings}


def test_panels_are_printed_whole_and_the_film_is_not():
    of = made()
    assert of.within_tolerance
    solids = of.report["solids"]
    assert solids["laid_mm3"] == solids["flexible_mm3"] > 0
    mesh = trimesh.load_mesh(io.BytesIO(of.files["m_thick.stl"]), file_type="stl")
    assert mesh.body_count == solids["panels"] == 16
    printed = solids["volume_mm3"] - solids["laid_mm3"]
    assert mesh.volume == pytest.approx(printed, rel=1e-6)
    assert np.ptp(mesh.vertices[:, 2]) == pytest.approx(1.6, abs=1e-6)
    density = of.report["material"]["density_kg_m3"]
    assert solids["mass_g"] == pytest.approx(printed * density * 1e-6)
    archive = zipfile.ZipFile(io.BytesIO(of.files["m_thick.3mf"]))
    table = ElementTree.fromstring(archive.read("Metadata/Slic3r_PE_model.config"))
    assert len(table.findall("object/volume")) == 1
    assert "one-material" not in notes(of)


@pytest.mark.parametrize("angle_deg", [-75.0, 60.0])
def test_the_film_fills_the_gaps_between_panels_at_the_height_of_their_axes(angle_deg):
    hinge = HingeSettings(kind="film", embedded=True, film_mm=0.2)
    sheet, findings = thicken(book(angle_deg), PanelSettings(), hinge)
    assert findings == []
    assert sheet.panels.heights_mm == (-0.8, 0.8)
    assert sheet.laid.tolist() == [False, False, True]
    film = sheet.bodies.mesh(2).vertices_coords
    assert (film[:, 2].min(), film[:, 2].max()) == pytest.approx((-0.1, 0.1))
    around = shapely.union_all([section(sheet.bodies.mesh(i), 0.0) for i in range(3)])
    assert around.area == pytest.approx(40 * 20, abs=0.02)
    gap = section(sheet.bodies.mesh(2), 0.0)
    assert gap.area == pytest.approx(20 * 2 * sheet.panels.setbacks.axis_mm.max(), abs=0.02)


def test_the_print_pauses_at_the_whole_layer_below_the_middle():
    of = made()
    assert of.report["solids"]["pause"] == {
        "z_mm": 0.8,
        "after_layer": 4,
        "layer_mm": 0.2,
        "off_mm": 0.0,
    }
    text = notes(of)["pause-for-film"].text
    assert "pause the print at z = 0.8 mm, after layer 4 of 0.2 mm" in text
    thick = made("panels.thickness_mm=1.8")
    assert thick.report["solids"]["pause"]["after_layer"] == 4
    assert "lies 0.1 mm below the middle" in notes(thick)["film-off-middle"].text
    assert "film-off-middle" not in notes(of)
    heavy = made("hinges.film_mm=0.3")
    assert notes(heavy)["film-too-thick"].severity == Severity.WARNING
    assert "film-too-thick" not in notes(of)


def test_pauses_are_in_files_with_a_known_printer_alone(tmp_path):
    archive = zipfile.ZipFile(io.BytesIO(made().files["m_thick.3mf"]))
    codes = ElementTree.fromstring(archive.read(PAUSES)).findall("code")
    assert [(code.get("print_z"), code.get("type")) for code in codes] == [("1", "1")]
    unknown = made(machine=None)
    assert unknown.report["solids"]["pause"] is None
    assert PAUSES not in zipfile.ZipFile(io.BytesIO(unknown.files["m_thick.3mf"])).namelist()
    path = tmp_path / "m.3mf"
    path.write_bytes(made().files["m_thick.3mf"])
    model = lib3mf.get_wrapper().CreateModel()
    reader = model.QueryReader("3mf")
    reader.ReadFromFile(str(path))
    assert reader.GetWarningCount() == 0


@wants_slicer
def test_prusaslicer_pauses_between_the_fourth_and_the_fifth_layer(tmp_path):
    path = tmp_path / "m.3mf"
    path.write_bytes(made().files["m_thick.3mf"])
    lines = sliced(path)
    (pause,) = [number for number, line in enumerate(lines) if line.strip() == "M601"]
    assert sum(line.startswith(";LAYER_CHANGE") for line in lines[:pause]) == 5
    after = [line for line in lines[pause:] if " E" in line and " X" in line]
    before = [line for line in lines[:pause] if line.startswith(";Z:")]
    assert before[-1] == ";Z:1"
    assert after


def test_other_films_have_no_pause():
    settings = thick_settings(("hinges.kind=film",))
    sheet, _ = thicken(book(40.0), settings.panels, settings.hinges)
    assert not sheet.laid.any()
    assert film_pause(sheet, 0.2) is None


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        (("hinges.embedded=true",), "films alone are embedded"),
        (("hinges.kind=film", "hinges.embedded=true", "hinges.film_mm=0.8"), "below half"),
        (("hinges.kind=film", "hinges.embedded=true", "panels.axis=middle"), "Leave panels.axis"),
    ],
)
def test_what_does_not_go_together_is_refused(changes, text):
    with pytest.raises(InvalidJob, match=text):
        thick_settings(changes)


def test_panels_of_less_than_two_layers_pause_after_the_first():
    thin = made("panels.thickness_mm=0.3", "hinges.film_mm=0.1")
    assert thin.report["solids"]["pause"]["after_layer"] == 1
    assert "lies 0.05 mm above the middle" in notes(thin)["film-off-middle"].text
