"""3MF files keep two materials in each slicer, as its reader takes them, and please lib3mf."""

from dataclasses import replace

import lib3mf
import numpy as np
import pytest
import trimesh
from slicer_readers import (
    BAMBU_ELEMENTS,
    BAMBU_KEYS,
    BAMBU_TABLE,
    PART_TYPES,
    PRUSA_ELEMENTS,
    PRUSA_KEYS,
    PRUSA_TABLE,
    VOLUME_TYPES,
    Package,
    opened_by_bambu,
    read_by_bambu,
    read_by_prusa,
)
from thick_sheets import miura_pattern, thick

from fab.printing.bed_place import BedPlace
from fab.printing.print_objects import Part, PrintObject, sheet_parts
from fab.printing.threemf import threemf_bytes

PLACE = BedPlace(30.0, (120.0, 95.5))


@pytest.fixture(scope="module")
def sheet():
    return thick(miura_pattern(), axis="middle")


@pytest.fixture(scope="module")
def objects(sheet):
    parts = tuple(sheet_parts(sheet, "PLA", "TPU"))
    return [PrintObject('a "<&>" b', parts, PLACE), PrintObject("B", parts[::-1])]


@pytest.fixture(scope="module", params=["prusa", "bambu"])
def package(request, objects):
    data = threemf_bytes(objects, "plate", request.param)
    return request.param, data, Package(data)


def expected(each):
    return [(part.name, part.extruder) for part in each.parts]


def require_same(found, objects):
    assert [name for name, _ in found] == [each.name for each in objects]
    for (_, parts), each in zip(found, objects, strict=True):
        assert [(part.name, part.extruder) for part in parts] == expected(each)
        for part, own in zip(parts, each.parts, strict=True):
            mesh = trimesh.Trimesh(part.vertices, part.triangles)
            assert mesh.is_watertight
            coords = own.mesh.vertices_coords
            turned = np.column_stack([each.place.moved(coords[:, :2]), coords[:, 2]])
            assert part.vertices == pytest.approx(turned, abs=1e-5)
            assert (part.triangles == own.mesh.triangles).all()


def test_every_slicer_keeps_parts_and_extruders(package, objects):
    slicer, _, read = package
    require_same(opened_by_bambu(read), objects)
    if slicer == "prusa":
        require_same(read_by_prusa(read), objects)
    else:
        require_same(read_by_bambu(read), objects)
        # PrusaSlicer, which takes components for objects, still prints each by its extruder
        single = [
            PrintObject(part.name, (part,), each.place) for each in objects for part in each.parts
        ]
        require_same(read_by_prusa(read), single)


@pytest.mark.parametrize("count", [1, 2])
def test_parts_alone_keep_their_extruder(sheet, count):
    (film,) = sheet_parts(replace(sheet, creases=np.full(len(sheet.bodies), -1)))[1:]
    alone = [PrintObject(f"film {number}", (film,)) for number in range(count)]
    for slicer, read in (("prusa", read_by_prusa), ("bambu", read_by_bambu)):
        require_same(read(Package(threemf_bytes(alone, "film", slicer))), alone)


def test_tables_have_what_their_readers_take_and_nothing_else(package):
    _, _, read = package
    known = {
        PRUSA_TABLE: (PRUSA_ELEMENTS, PRUSA_KEYS, "volume"),
        BAMBU_TABLE: (BAMBU_ELEMENTS, BAMBU_KEYS, "part"),
    }
    for path, table in read.tables.items():
        elements, keys, inner = known[path]
        for node in table.iter():
            needed, others = elements[node.tag]
            assert needed <= set(node.attrib) <= needed | others
            if node.tag == "metadata":
                assert node.get("key") in keys
        for node in table.findall("object"):
            assert int(node.get("id")) in read.objects
            for part in node.findall(inner):
                found = {entry.get("key"): entry.get("value") for entry in part}
                assert {"name", "extruder"} <= set(found)
                if path == PRUSA_TABLE:
                    assert found["volume_type"] in VOLUME_TYPES
                    assert {entry.get("type") for entry in part} == {"volume"}
                else:
                    assert part.get("subtype") in PART_TYPES
                    assert int(part.get("id")) in read.objects


def test_lib3mf_reads_all_without_a_warning(package, objects, tmp_path):
    slicer, data, _ = package
    path = tmp_path / "plate.3mf"
    path.write_bytes(data)
    model = lib3mf.get_wrapper().CreateModel()
    reader = model.QueryReader("3mf")
    reader.SetStrictModeActive(True)
    reader.ReadFromFile(str(path))
    assert [reader.GetWarning(i) for i in range(reader.GetWarningCount())] == []
    parts = sum(len(each.parts) for each in objects)
    whole = slicer == "prusa"
    assert model.GetMeshObjects().Count() == (len(objects) if whole else parts)
    assert model.GetComponentsObjects().Count() == (0 if whole else len(objects))
    assert model.GetBuildItems().Count() == len(objects)
    groups = model.GetBaseMaterialGroups()
    assert groups.MoveNext()
    group = groups.GetCurrentBaseMaterialGroup()
    names = {group.GetName(number) for number in group.GetAllPropertyIDs()}
    assert names == {"panels: PLA", "hinges: TPU"}
    items = model.GetBuildItems()
    assert items.MoveNext()
    fields = np.array(items.GetCurrent().GetObjectTransform().Fields)
    if whole:  # its coordinates are those of its place
        assert not items.GetCurrent().HasObjectTransform()
        return
    assert fields[:2, :2] == pytest.approx(np.array([[3**0.5, 1], [-1, 3**0.5]]) / 2)
    assert fields[3] == pytest.approx([120.0, 95.5, 0.0])


def test_a_material_is_named_once_for_all_parts_of_it(objects):
    mesh = objects[0].parts[0].mesh
    same = [PrintObject(str(k), (Part("panels", mesh, 1, material="PLA"),)) for k in range(3)]
    read = Package(threemf_bytes(same, "plate"))
    bases = [node.get("name") for node in read.model.iter() if node.tag.endswith("}base")]
    assert bases == ["panels: PLA"]
