"""STL and 3MF files of bodies, read back by other readers."""

import io
import xml.etree.ElementTree as ElementTree
import zipfile
from dataclasses import replace

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from thick_sheets import miura_pattern, shipped_pattern, thick

from fab.geometry.bodies import TriangleMesh
from fab.geometry.booleans import joined_mesh, manifold_of
from fab.panels.body_colours import body_colours
from fab.printing.print_objects import Part, PrintObject, sheet_parts
from fab.printing.stl import body_stls, inspect_stl, stl_bytes
from fab.printing.threemf import threemf_bytes
from solver.errors import InvalidValue

CORE = "{http://schemas.microsoft.com/3dmanufacturing/core/2015/02}"


@pytest.fixture(scope="module")
def sheet():
    return thick(miura_pattern())


SHEETS = {
    "miura, bottom": lambda: thick(miura_pattern()),
    "miura, middle": lambda: thick(miura_pattern(), "middle"),
    "waterbomb": lambda: thick(shipped_pattern("waterbomb", 100.0), "middle"),
    "resch": lambda: thick(shipped_pattern("resch", 200.0)),
    # so large that single precision does not resolve where webs and where panels end
    "large": lambda: thick(shipped_pattern("square_twist", 2500.0)),
    "huge": lambda: thick(shipped_pattern("waterbomb", 9000.0)),
}


@pytest.mark.parametrize("name", SHEETS)
def test_the_joined_stl_needs_no_repair(name):
    sheet = SHEETS[name]()
    joined = joined_mesh(sheet.joining)
    assert inspect_stl(joined) == []
    assert joined.vertices_coords[:, 2].min() == 0.0
    data = stl_bytes(joined)
    back = trimesh.load(io.BytesIO(data), file_type="stl")
    assert len(back.faces) == len(joined.triangles)
    assert back.is_watertight
    assert back.is_winding_consistent
    assert back.body_count == 1
    exact = sheet.bodies.volumes_mm3().sum()
    assert manifold_of(joined).volume() == pytest.approx(exact, rel=1e-9)
    assert back.volume == pytest.approx(exact, rel=1e-5)
    rows = np.frombuffer(data[84:], np.dtype([("n", "<f4", 3), ("p", "<f4", (3, 3)), ("a", "<u2")]))
    corners = rows["p"].astype(float)
    area = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(area, axis=1)
    assert length.min() > 0
    assert rows["n"] == pytest.approx(area / length[:, None], abs=1e-6)


def test_surfaces_that_stl_cannot_hold_are_found():
    tetrahedron = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])

    def found(coords, triangles):
        mesh = TriangleMesh(np.asarray(coords, float), triangles, np.arange(len(triangles)))
        return [finding.text for finding in inspect_stl(mesh)]

    assert found(tetrahedron, faces) == []
    assert "3 edges" in found(tetrahedron, faces[1:])[0]
    # flat to single precision: far from the origin two corners become one
    (text,) = found(tetrahedron * [1, 1, 1e-6] + [0, 0, 1000], faces)
    assert "2 triangles have no area" in text
    # two bodies that share an edge
    both = np.concatenate([tetrahedron, tetrahedron * [-1, -1, 1]])
    (text,) = found(both, np.concatenate([faces, faces + 4]))
    assert "1 edge of the surface is" in text


def test_every_body_has_its_own_stl(sheet):
    data = body_stls(sheet)
    assert data == body_stls(sheet)
    package = zipfile.ZipFile(io.BytesIO(data))
    assert package.namelist() == [f"{name}.stl" for name in sheet.names]
    assert {entry.date_time for entry in package.infolist()} == {(1980, 1, 1, 0, 0, 0)}
    for name, volume in zip(package.namelist(), sheet.bodies.volumes_mm3(), strict=True):
        back = trimesh.load(io.BytesIO(package.read(name)), file_type="stl")
        assert back.is_watertight
        assert back.volume == pytest.approx(volume, rel=1e-4)


def read_model(data: bytes):
    package = zipfile.ZipFile(io.BytesIO(data))
    assert package.testzip() is None
    assert {entry.date_time for entry in package.infolist()} == {(1980, 1, 1, 0, 0, 0)}
    model = ElementTree.fromstring(package.read("3D/3dmodel.model"))
    config = ElementTree.fromstring(package.read("Metadata/Slic3r_PE_model.config"))
    vertices = np.array([[float(v.get(k)) for k in "xyz"] for v in model.iter(f"{CORE}vertex")])
    triangles = np.array(
        [[int(t.get(f"v{k}")) for k in (1, 2, 3)] for t in model.iter(f"{CORE}triangle")]
    )
    return model, config, vertices, triangles


def settings_of(node) -> dict[str, str]:
    return {entry.get("key"): entry.get("value") for entry in node.findall("metadata")}


def test_threemf_is_one_object_with_a_volume_for_each_material(sheet):
    name = 'name with "<&>"'
    model, config, vertices, triangles = read_model(
        threemf_bytes([PrintObject(name, tuple(sheet_parts(sheet)))], name)
    )
    assert model.get("unit") == "millimeter"
    (thing,) = model.iter(f"{CORE}object")
    assert thing.get("name") == name
    assert [item.get("objectid") for item in model.iter(f"{CORE}item")] == [thing.get("id")]
    (entry,) = config.findall("object")
    assert entry.get("id") == thing.get("id")
    assert settings_of(entry)["name"] == name
    volumes = entry.findall("volume")
    table = [settings_of(volume) for volume in volumes]
    assert [(row["name"], row["extruder"]) for row in table] == [("panels", "1"), ("hinges", "2")]
    exact = sheet.bodies.volumes_mm3()
    material = np.array(
        [int(t.get("p1", thing.get("pindex"))) for t in model.iter(f"{CORE}triangle")]
    )
    end = 0
    for number, (volume, soft) in enumerate(zip(volumes, (False, True), strict=True)):
        assert int(volume.get("firstid")) == end
        end = int(volume.get("lastid")) + 1
        part = trimesh.Trimesh(vertices, triangles[int(volume.get("firstid")) : end])
        assert part.is_watertight
        assert part.volume == pytest.approx(exact[sheet.flexible == soft].sum(), rel=1e-6)
        assert (material[int(volume.get("firstid")) : end] == number).all()
    assert end == len(triangles)
    assert vertices[:, 2].min() == 0
    bases = [base.get("name") for base in model.iter(f"{CORE}base")]
    assert bases == ["panels", "hinges"]


def test_parts_are_named_by_what_is_flexible(sheet):
    def parts(**changes):
        return [(part.name, part.extruder) for part in sheet_parts(replace(sheet, **changes))]

    none = np.full(len(sheet.bodies), -1)
    assert parts(flexible=none > 0) == [("panels", 1)]
    assert parts(creases=none) == [("panels", 1), ("film", 2)]
    (film,) = sheet_parts(replace(sheet, creases=none, flexible=none < 0))
    assert film.extruder == 2
    assert body_colours(replace(sheet, creases=none))[-1] == film.colour


def test_threemf_of_one_part_is_one_volume(sheet):
    joined = joined_mesh(sheet.joining)
    data = threemf_bytes([PrintObject("miura", (Part("sheet", joined, 1),))], "miura")
    _, config, vertices, triangles = read_model(data)
    assert vertices == pytest.approx(joined.vertices_coords, abs=1e-6)
    assert (triangles == joined.triangles).all()
    assert len(config.findall("object/volume")) == 1
    assert trimesh.Trimesh(vertices, triangles).is_watertight


def test_threemf_keeps_objects_apart(sheet):
    parts = sheet_parts(sheet)
    objects = [PrintObject("A", tuple(parts)), PrintObject("B", tuple(reversed(parts)))]
    model, config, _, _ = read_model(threemf_bytes(objects, "plate"))
    things = list(model.iter(f"{CORE}object"))
    assert [thing.get("name") for thing in things] == ["A", "B"]
    numbers = [thing.get("id") for thing in things]
    assert [item.get("objectid") for item in model.iter(f"{CORE}item")] == numbers
    assert [entry.get("id") for entry in config.findall("object")] == numbers
    assert [base.get("name") for base in model.iter(f"{CORE}base")] == ["panels", "hinges"]
    for thing, entry, order in zip(things, config, (parts, parts[::-1]), strict=True):
        triangles = list(thing.iter(f"{CORE}triangle"))
        assert max(int(t.get("v1")) for t in triangles) < len(list(thing.iter(f"{CORE}vertex")))
        names = [settings_of(volume)["name"] for volume in entry.findall("volume")]
        assert names == [part.name for part in order]
        own = int(thing.get("pindex"))
        soft = np.array([int(t.get("p1", own)) for t in triangles])
        first = len(order[0].mesh.triangles)
        assert set(soft[:first]) == {own}
        assert set(soft[first:]) == {1 - own}
        assert int(entry.findall("volume")[1].get("firstid")) == first


def test_threemf_needs_triangles():
    with pytest.raises(InvalidValue, match="no object has a triangle"):
        threemf_bytes([], "nothing")


@settings(max_examples=30)
@given(st.lists(st.floats(-1e4, 1e4), min_size=12, max_size=12), st.integers(1, 4))
def test_threemf_keeps_any_coordinates_to_a_millionth(numbers, extruder):
    coords = np.array(numbers).reshape(4, 3)
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    part = Part("one", TriangleMesh(coords, faces, np.arange(4)), extruder)
    _, config, vertices, triangles = read_model(
        threemf_bytes([PrintObject("any", (part, part))], "any")
    )
    assert vertices == pytest.approx(np.tile(coords, (2, 1)), abs=5.001e-7)
    assert (triangles == np.concatenate([faces, faces + 4])).all()
    rows = [settings_of(volume) for volume in config.findall("object/volume")]
    assert [row["extruder"] for row in rows] == 2 * [str(extruder)]
