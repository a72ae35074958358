"""Panels and hinges of different materials: what is loaded, what is weighed, what is warned of."""

import io
import zipfile
from xml.etree import ElementTree

import numpy as np
import pytest
from thick_sheets import book, miura_pattern, scaled_to

from fab.errors import InvalidJob, Severity
from fab.jobs.print_files import ThickFormat, make_thick
from fab.printing.thick_settings import thick_settings

TWO = ("printer.panel_material=pla_filament", "printer.hinge_material=tpu_95a_filament")


def made(*changes, machine="prusa_mk4s", material=None):
    settings = thick_settings(changes, machine, material)
    formats = [ThickFormat.THREEMF]
    return make_thick(
        book(90.0), "book", settings, print_with=settings.print_with(), formats=formats
    )


def codes(of):
    return {finding.code: finding.severity for finding in of.findings}


def test_each_material_is_that_of_both_where_nothing_else_is_said():
    both = thick_settings((), None, "pp_filament").print_with()
    assert both.panels == both.hinges
    assert both.material_count == 1
    hinges = thick_settings(TWO[1:], None, "pla_filament").print_with()
    assert hinges.panels == thick_settings(TWO, None, None).print_with().panels
    assert hinges.material_count == 2
    alone = thick_settings(TWO[1:]).print_with()
    assert alone.panels is None
    assert alone.material_count == 1
    with pytest.raises(InvalidJob, match="hinge"):
        thick_settings(("printer.hinge_material=hinge",)).print_with()


def test_the_strain_of_webs_is_that_of_the_hinges_material():
    settings = thick_settings(TWO)
    print_with = settings.print_with()
    assert settings.printed(print_with).hinges.strain_max == print_with.hinges.strain_max
    assert "hinge-breaks" not in codes(made(*TWO, machine="bambu_x1c"))
    assert "hinge-breaks" in codes(made(material="pla_filament"))


def test_mass_is_that_of_each_material():
    of = made(*TWO, machine="bambu_x1c")
    solids = of.report["solids"]
    soft = solids["flexible_mm3"]
    rigid = solids["volume_mm3"] - soft
    densities = [of.report[key]["density_kg_m3"] for key in ("material", "hinge_material")]
    assert densities[0] != densities[1]
    assert solids["mass_g"] == pytest.approx((rigid * densities[0] + soft * densities[1]) * 1e-6)
    assert solids["hinge_mass_g"] == pytest.approx(soft * densities[1] * 1e-6)
    unknown = made(TWO[1]).report["solids"]
    assert unknown["mass_g"] is None
    assert unknown["hinge_mass_g"] is not None
    rigid_alone = made(TWO[0], "hinges.kind=none").report["solids"]
    assert rigid_alone["mass_g"] > 0
    assert rigid_alone["hinge_mass_g"] == 0


def test_two_materials_want_two_extruders():
    found = codes(made(*TWO))
    assert found["too-few-extruders"] == Severity.WARNING
    assert "one-material" not in found
    assert "one-material" in codes(made(material="pp_filament"))
    assert not {"too-few-extruders", "one-material"} & set(codes(made(*TWO, machine="bambu_x1c")))


@pytest.mark.parametrize(
    ("machine", "changes", "slicer"),
    [
        ("prusa_mk4s", (), "prusa"),
        ("bambu_x1c", (), "bambu"),
        ("bambu_x1c", ("printer.slicer=prusa",), "prusa"),
        (None, ("printer.slicer=bambu",), "bambu"),
        (None, (), "prusa"),
    ],
)
def test_files_are_laid_out_for_the_slicer_of_the_printer_in_the_middle_of_its_bed(
    machine, changes, slicer
):
    archive = zipfile.ZipFile(io.BytesIO(made(*changes, machine=machine).files["book_thick.3mf"]))
    assert ("Metadata/model_settings.config" in archive.namelist()) == (slicer == "bambu")
    model = ElementTree.fromstring(archive.read("3D/3dmodel.model"))
    (item,) = (node for node in model.iter() if node.tag.endswith("}item"))
    if machine is None:
        assert item.get("transform") is None
        return
    corners = np.array(
        [
            [float(node.get(key)) for key in "xy"]
            for node in model.iter()
            if node.tag.endswith("}vertex")
        ]
    )
    shift = np.zeros(2)
    assert (item.get("transform") is not None) == (slicer == "bambu")
    if slicer == "bambu":
        shift = np.array([float(word) for word in item.get("transform").split()])[9:11]
    middle = (corners.min(axis=0) + corners.max(axis=0)) / 2 + shift
    bed = {"prusa_mk4s": (250, 210), "bambu_x1c": (256, 256)}[machine]
    assert middle == pytest.approx(np.array(bed) / 2, abs=1e-5)


def test_sheets_in_parts_have_no_dovetails_and_say_so():
    settings = thick_settings(TWO, "bambu_a1_mini", None)
    formats = [ThickFormat.THREEMF]
    pattern = scaled_to(miura_pattern(), 250.0)
    of = make_thick(pattern, "m", settings, print_with=settings.print_with(), formats=formats)
    found = [finding for finding in of.findings if finding.code == "web-not-anchored"]
    assert [finding.severity for finding in found] == [Severity.WARNING]
    assert "printed in parts" in found[0].text
    assert {finding.severity for finding in of.findings} <= {Severity.NOTE, Severity.WARNING}
    assert len(of.report["plates"]["plates"]) == len(of.files) - 1
    archive = zipfile.ZipFile(io.BytesIO(of.files["m_thick_plate_1.3mf"]))
    assert "Metadata/model_settings.config" in archive.namelist()
