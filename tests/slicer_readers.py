"""What slicers read of a 3MF file, in our own words, after their sources.

PrusaSlicer (src/libslic3r/Format/3mf.cpp) and OrcaSlicer's copy of it read a mesh and a table of
its volumes. They take every component of an object for an object of its own. Bambu Studio and
OrcaSlicer (src/libslic3r/Format/bbs_3mf.cpp) take an object with all its components for one, whose
parts a table names by the numbers of their meshes; they know no ranges of triangles. Both open a
file by the former reader where the model's "Application" names PrusaSlicer (`check_3mf_from_prusa`,
Format/3mf.cpp, as called in Model.cpp).
"""

from __future__ import annotations

import io
import zipfile
from dataclasses import dataclass
from xml.etree import ElementTree

import numpy as np

CORE = "{http://schemas.microsoft.com/3dmanufacturing/core/2015/02}"
PRUSA_TABLE = "Metadata/Slic3r_PE_model.config"
BAMBU_TABLE = "Metadata/model_settings.config"

# Elements that the readers of tables know, with their attributes: those they need, and others.
PRUSA_ELEMENTS = {
    "config": (set(), set()),
    "object": ({"id"}, {"instances_count"}),
    "volume": ({"firstid", "lastid"}, set()),
    "metadata": ({"type", "key", "value"}, set()),
}
BAMBU_ELEMENTS = {
    "config": (set(), set()),
    "object": ({"id"}, set()),
    "part": ({"id", "subtype"}, {"part_guid"}),
    "metadata": ({"key", "value"}, set()),
}
# Keys that OrcaSlicer keeps of PrusaSlicer's table; PrusaSlicer takes any setting of its own.
PRUSA_KEYS = {
    "name",
    "volume_type",
    "matrix",
    "source_file",
    "source_object_id",
    "source_volume_id",
    "source_offset_x",
    "source_offset_y",
    "source_offset_z",
    "extruder",
    "modifier",
}
BAMBU_KEYS = {"name", "module", "matrix", "extruder", "source_file", "mesh_shared"}
VOLUME_TYPES = {"ModelPart", "ParameterModifier", "SupportEnforcer", "SupportBlocker"}
PART_TYPES = {"normal_part", "negative_part", "modifier_part"}


@dataclass(frozen=True)
class ReadPart:
    """A part as a slicer has it: where its corners are on the bed, and what prints it."""

    name: str
    extruder: int
    vertices: np.ndarray
    triangles: np.ndarray


class Package:
    """A 3MF file, read as XML alone."""

    def __init__(self, data: bytes):
        archive = zipfile.ZipFile(io.BytesIO(data))
        self.names = archive.namelist()
        self.model = ElementTree.fromstring(archive.read("3D/3dmodel.model"))
        self.tables = {
            name: ElementTree.fromstring(archive.read(name))
            for name in (PRUSA_TABLE, BAMBU_TABLE)
            if name in self.names
        }
        self.objects = {int(each.get("id")): each for each in self.model.iter(f"{CORE}object")}

    def items(self):
        for item in self.model.iter(f"{CORE}item"):
            yield int(item.get("objectid")), transform_of(item)

    def components(self, number: int):
        for each in self.objects[number].iter(f"{CORE}component"):
            yield int(each.get("objectid")), transform_of(each)

    def mesh(self, number: int):
        mesh = self.objects[number].find(f"{CORE}mesh")
        if mesh is None:
            return None
        vertices = [[float(v.get(k)) for k in "xyz"] for v in mesh.iter(f"{CORE}vertex")]
        triangles = [
            [int(t.get(k)) for k in ("v1", "v2", "v3")] for t in mesh.iter(f"{CORE}triangle")
        ]
        return np.array(vertices), np.array(triangles)

    @property
    def application(self) -> str:
        found = [e.text or "" for e in self.model.iter(f"{CORE}metadata")]
        names = [e.get("name") for e in self.model.iter(f"{CORE}metadata")]
        return dict(zip(names, found, strict=True)).get("Application", "")


def transform_of(node):
    """The matrix of an item or a component, shape (4, 4), which rows of points multiply."""
    text = node.get("transform")
    out = np.eye(4)
    if text is not None:
        out[:, :3] = np.array([float(word) for word in text.split()]).reshape(4, 3)
    return out


def moved(vertices, transform):
    return vertices @ transform[:3, :3] + transform[3, :3]


def metadata(node, kind: str | None = None) -> dict[str, str]:
    return {
        entry.get("key"): entry.get("value")
        for entry in node.findall("metadata")
        if kind is None or entry.get("type") == kind
    }


def read_by_prusa(package: Package) -> list[tuple[str, list[ReadPart]]]:
    """The objects of a file in PrusaSlicer."""
    table = {int(each.get("id")): each for each in package.tables[PRUSA_TABLE].findall("object")}
    out: list[tuple[str, list[ReadPart]]] = []

    def place(number: int, transform) -> None:
        mesh = package.mesh(number)
        if mesh is None:
            for inner, own in package.components(number):
                place(inner, own @ transform)
            return
        vertices, triangles = mesh
        entry = table[number]
        parts = []
        for row, volume in enumerate(entry.findall("volume")):
            first, last = int(volume.get("firstid")), int(volume.get("lastid"))
            assert 0 <= first <= last < len(triangles)
            keys = metadata(volume, "volume")
            extruder = int(keys.get("extruder", metadata(entry, "object").get("extruder", "0")))
            rows = triangles[first : last + 1]
            # a volume keeps the vertices between its least and its greatest number
            low, high = rows.min(), rows.max()
            # the first volume takes the place of its object, which is then that of none
            place_of_volume = transform if row == 0 else np.eye(4)
            corners = moved(vertices[low : high + 1], place_of_volume)
            parts.append(ReadPart(keys["name"], extruder, corners, rows - low))
        out.append((metadata(entry, "object")["name"], parts))

    for number, transform in package.items():
        place(number, transform)
    return out


def read_by_bambu(package: Package) -> list[tuple[str, list[ReadPart]]]:
    """The objects of a file in the own reader of Bambu Studio and OrcaSlicer."""
    table = {int(each.get("id")): each for each in package.tables[BAMBU_TABLE].findall("object")}
    out = []
    for number, transform in package.items():
        entry = table[number]
        listed = {int(part.get("id")): metadata(part) for part in entry.findall("part")}
        waiting, meshes = [(number, np.eye(4))], []
        while waiting:
            inner, within = waiting.pop(0)
            components = list(package.components(inner))
            if components:
                waiting += [(each, own @ within) for each, own in components]
            else:
                meshes.append((inner, within))
        own = metadata(entry)
        parts = []
        for inner, within in meshes:
            vertices, triangles = package.mesh(inner)
            keys = listed.get(inner, {})
            # the only volume of an object prints by the extruder of the object
            extruder = int(own["extruder"])
            if len(meshes) > 1 and int(keys.get("extruder", "0")) > 0:
                extruder = int(keys["extruder"])
            corners = moved(vertices, within @ transform)
            parts.append(ReadPart(keys.get("name", own["name"]), extruder, corners, triangles))
        out.append((own["name"], parts))
    return out


def opened_by_bambu(package: Package) -> list[tuple[str, list[ReadPart]]]:
    """The objects of a file in Bambu Studio or OrcaSlicer, by the reader that they choose."""
    of_prusa = "PrusaSlicer" in package.application
    if of_prusa and "3D/_rels/3dmodel.model.rels" not in package.names:
        return read_by_prusa(package)
    return read_by_bambu(package)
