"""Files of surfaces: STL, PLY, OFF and OBJ, read in this process, and GLB, 3MF and STEP.

Those crash their readers, or have them ask for any amount of memory: here they are read by a
process that is forked for each file, with all libraries loaded (GLB files within the bounds of the
run), and one of some dozens by `in_own_process`, as users have it. How such a process ends is no
fault; what it returns is taken on here as the reader does.
"""

from __future__ import annotations

import faulthandler
import functools
import os
import re
import resource
import signal
import time
import zlib
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np
from fuzz.mesh_faults import Random, with_mesh_faults
from fuzz.trials import Kind

from fab.errors import InvalidFile
from fab.formats.meshes.spline_face import SplineFace
from fab.formats.meshes.step_faces import spline_face, step_face
from fab.formats.meshes.surface import read_surface
from fab.outputs import zip_bytes
from fab.surfaces.clean_mesh import clean_mesh
from fab.surfaces.mesh_reader import read_triangles, triangles_of_3mf
from fab.surfaces.reading import read_surface_mesh
from fab.surfaces.step_mesh import step_triangles
from solver.errors import OrigamiError
from solver.targets.mesh import MeshSurface, mesh_arrays
from solver.targets.parametric import ParametricSurface

__all__ = ["MESH_KINDS"]

# One of so many meshes is cleaned and followed, one of so many files read in a process of its own.
_CLEANED, _ITS_OWN = 150, 60
# Of the processes that are forked: seconds of processor time, MB more than this one has.
_SECONDS, _MORE_MB = 10, 1500


@cache
def _meshes() -> tuple[Any, ...]:
    import trimesh

    quads = trimesh.Trimesh([[0, 0, 0], [4, 0, 0], [4, 3, 1], [0, 3, 1]], [[0, 1, 2], [2, 3, 0]])
    return (
        trimesh.creation.box(),
        quads,
        trimesh.creation.icosphere(subdivisions=1),
        trimesh.creation.cylinder(1.0, 2.0, sections=6),
    )


@cache
def _seeds(kind: str) -> tuple[bytes, ...]:
    found: list[bytes] = []
    for mesh in _meshes() if kind in ("stl", "ply", "off", "obj", "glb") else ():
        found.append(_bytes_of(mesh.export(file_type=kind)))
        if kind == "stl":
            found.append(_bytes_of(mesh.export(file_type="stl_ascii")))
        if kind == "ply":
            found.append(_bytes_of(mesh.export(file_type="ply", encoding="ascii")))
    if kind == "obj":
        found.append(
            b"v 0 0 0\nv 4 0 0\nv 4 3 0\nv 0 3 1\nv 8 0 0\nv 8 3 0\nf 1 2 3 4\nf 2 5 6 3\n"
        )
    if kind == "3mf":
        found = [_package(False), _package(True)]
    return tuple(found) if kind != "step" else _models()


def _bytes_of(data: Any) -> bytes:
    return data.encode() if isinstance(data, str) else bytes(data)


def _package(nested: bool) -> bytes:
    """A 3MF file of a tetrahedron, alone or as components that are turned and shifted."""
    corners = ((0, 0, 0), (9, 0, 0), (0, 9, 0), (0, 0, 9))
    sides = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2))
    vertices = "".join(f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in corners)
    triangles = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in sides)
    mesh = f"<mesh><vertices>{vertices}</vertices><triangles>{triangles}</triangles></mesh>"
    objects = f'<object id="1" type="model">{mesh}</object>'
    item = '<item objectid="1"/>'
    if nested:
        turned = 'transform="0 1 0 -1 0 0 0 0 1 5 0 0"'
        parts = f'<component objectid="1"/><component objectid="1" {turned}/>'
        objects += f'<object id="2" type="model"><components>{parts}</components></object>'
        item = f'<item objectid="2" {turned}/>'
    space = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
    model = (
        f'<?xml version="1.0" encoding="UTF-8"?><model unit="millimeter" xmlns="{space}">'
        f"<resources>{objects}</resources><build>{item}</build></model>"
    )
    package = "http://schemas.openxmlformats.org/package/2006"
    types = (
        f'<Types xmlns="{package}/content-types"><Default Extension="rels" '
        'ContentType="application/vnd.openxmlformats-package.relationships+xml"/><Default '
        'Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>'
        "</Types>"
    )
    relations = (
        f'<Relationships xmlns="{package}/relationships"><Relationship Target="/3D/3dmodel.model" '
        'Id="r0" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>'
        "</Relationships>"
    )
    files = {"[Content_Types].xml": types, "_rels/.rels": relations, "3D/3dmodel.model": model}
    return zip_bytes({name: text.encode() for name, text in files.items()})


@cache
def _models() -> tuple[bytes, ...]:
    """STEP files of planes, a sphere, a cylinder, a torus, a cut box and a spline."""
    import tempfile

    import build123d as cad

    grid = [[cad.Vector(x, y, 0.1 * x * y) for y in range(4)] for x in range(4)]
    shapes = (
        cad.Face.make_rect(30, 20),
        cad.Solid.make_box(3, 4, 5),
        cad.Solid.make_sphere(5),
        cad.Solid.make_cylinder(3, 9),
        cad.Solid.make_torus(5, 2),
        cad.Solid.make_box(9, 9, 9).cut(cad.Solid.make_cylinder(2, 20)),
        cad.Face.make_surface_from_array_of_points(grid),
    )
    found = []
    with tempfile.TemporaryDirectory() as folder:
        for shape in shapes:
            cad.export_step(cad.Compound([shape]), Path(folder) / "a.step")
            data = (Path(folder) / "a.step").read_bytes()
            found.append(re.sub(rb"'\d{4}-\d\d-\d\dT[\d:]+'", b"'2020-01-01T00:00:00'", data))
    return tuple(found)


def _faulty(kind: str, random: Random) -> bytes:
    seeds = _seeds(kind)
    return with_mesh_faults(random, kind, seeds[int(random.integers(len(seeds)))])


def _mesh(path: Path, random: Random) -> str:
    """Read a mesh; clean and follow some."""
    coords, triangles = read_triangles(path, path.stat().st_size)
    if random.integers(_CLEANED) == 0:
        _follow(path, coords, triangles, random)
    return _said(coords, triangles)


def _glb_read(path: Path, random: Random) -> str:
    if random.integers(10 * _ITS_OWN) == 0:
        coords, triangles = read_triangles(path, path.stat().st_size)
    else:
        found = mesh_arrays(path)  # within the bounds of a run, as of a process of its own
        coords, triangles = found["vertices_coords"], found["faces"]
        if random.integers(_ITS_OWN) == 0:
            MeshSurface.from_faces(coords, triangles)
    return _said(coords, triangles)


def _said(coords: Any, triangles: Any) -> str:
    data = np.ascontiguousarray(coords).tobytes()
    return f"{coords.shape} {triangles.shape} {zlib.crc32(data)}"


def _follow(path: Path, coords: Any, triangles: Any, random: Random) -> None:
    """A mesh is cleaned, or followed as a target."""
    kind = random.integers(3)
    if kind == 0:
        MeshSurface.from_faces(coords, triangles)
    elif kind == 1:
        _require_clean(clean_mesh((coords, triangles)).mesh)
    else:
        read_surface(path)


def _require_clean(mesh: Any) -> None:
    """A surface is finite, and no edge of it has more than two faces."""
    coords, faces = mesh.vertices_coords, mesh.faces_vertices
    assert np.isfinite(coords).all(), "coordinates are finite"
    assert 0 <= faces.min() <= faces.max() < len(coords), "faces name vertices"
    sides = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1)
    _, counts = np.unique(sides, axis=0, return_counts=True)
    assert counts.max() <= 2, "edges have up to two faces"


def _forked(function: Callable[[], dict[str, Any]], path: Path) -> dict[str, Any]:
    """The arrays that a function returns in a process that is forked for it.

    Raises `InvalidFile` however else it ends, as `in_own_process` does.
    """
    answer = path.with_suffix(".npz")
    answer.unlink(missing_ok=True)
    child = os.fork()
    if child == 0:
        code = 3
        try:
            faulthandler.disable()  # a crash is one of the ways to end
            signal.setitimer(signal.ITIMER_PROF, 0)
            signal.signal(signal.SIGPROF, signal.SIG_DFL)
            resource.setrlimit(resource.RLIMIT_CPU, (_SECONDS, _SECONDS + 1))
            np.savez(answer, **function())
            code = 0
        except OrigamiError:
            code = 1
        except BaseException:  # a process ends here, whatever there is
            code = 2
        finally:
            os._exit(code)
    end = time.monotonic() + 10 * _SECONDS
    while (done := os.waitpid(child, os.WNOHANG))[0] == 0:
        if time.monotonic() > end:
            os.kill(child, signal.SIGKILL)
        time.sleep(0.002)
    code = os.waitstatus_to_exitcode(done[1])
    if code != 0:
        how = {1: "refused", 2: "an exception", 3: "an exception"}.get(code, f"signal {-code}")
        raise InvalidFile(f"{path}: the process that reads it ended: {how}. Export it again.")
    with np.load(answer, allow_pickle=False) as archive:
        return {name: archive[name] for name in archive.files}


def _package_read(path: Path, random: Random) -> str:
    if random.integers(_ITS_OWN) == 0:
        return str(read_surface_mesh(path).mesh.faces_vertices.shape)
    found = _forked(partial(triangles_of_3mf, str(path)), path)
    if random.integers(3) == 0:
        _require_clean(clean_mesh((found["vertices_coords"], found["faces"])).mesh)
    return str(found["faces"].shape)


def _model_read(path: Path, random: Random) -> str:
    face = None if random.integers(2) else int(random.integers(-1, 7))
    followed = bool(random.integers(2))
    if random.integers(_ITS_OWN) == 0:
        if followed:
            return type(read_surface(path, face)).__name__
        return str(read_surface_mesh(path, face).mesh.faces_vertices.shape)
    if followed:
        spline = SplineFace.of(_forked(partial(step_face, str(path), face), path))
        surface = ParametricSurface(spline.position, spline.derivatives, spline.within)
        u, v = (each.ravel() for each in np.meshgrid(*[np.linspace(-1.2, 1.2, 7)] * 2))
        shapes = [surface.position(u, v).shape, *(d.shape for d in surface.derivatives(u, v))]
        assert shapes == [(49, 3)] * 3, "points and tangents have three coordinates"
        return f"{spline.within(u, v).sum()}"
    numbers = None if face is None else [face]
    found = _forked(partial(step_triangles, str(path), numbers), path)
    if random.integers(3) == 0:
        _require_clean(clean_mesh((found["vertices_coords"], found["faces"])).mesh)
    return str(found["faces"].shape)


def _heavy(kind: str, random: Random) -> bytes:
    """An input of a library that is loaded before the first process is forked."""
    _loaded()
    return _faulty(kind, random)


@functools.cache
def _loaded() -> tuple[Any, ...]:
    import build123d
    import lib3mf
    import shapely

    return build123d, lib3mf, shapely, spline_face


def _kinds() -> list[Kind]:
    found = [
        Kind(name, f"fuzzed.{ending}", partial(_faulty, ending), _mesh, seconds=30.0, share=5.0)
        for name, ending in (
            *(("stl", "stl"), ("ply", "ply"), ("off", "off")),
            ("obj-mesh", "obj"),
        )
    ]
    slow = {"seconds": 60.0, "memory_mb": 800.0, "opens": True}
    any_memory = {"memory_mb": 2500.0}
    return [
        *found,
        Kind("glb", "fuzzed.glb", partial(_faulty, "glb"), _glb_read, **(slow | any_memory)),
        Kind("3mf", "fuzzed.3mf", partial(_heavy, "3mf"), _package_read, **slow),
        Kind("step", "fuzzed.step", partial(_heavy, "step"), _model_read, share=2.0, **slow),
    ]


MESH_KINDS = tuple(_kinds())
