"""CAD solids and their files for 100 to 6400 panels, against the barest way to write them.

pytest tests/bench/test_solids_bench.py --benchmark-only -s
"""

import io
import time
import tracemalloc
import zipfile
from functools import partial

import numpy as np
import pytest
from flat_patterns import grid

from fab.panels.bevelled_panels import PanelSettings
from fab.panels.hinges import HingeSettings
from fab.panels.step import step_bytes
from fab.panels.thick_sheet import ThickSheet, thicken
from fab.pattern.crease_pattern import CreasePattern, crease_pattern
from fab.pattern.development import develop
from fab.printing.print_objects import PrintObject, sheet_parts
from fab.printing.threemf import threemf_bytes
from solver import Miura

SIDES = (10, 20, 40, 80)


def miura(side: int) -> CreasePattern:
    mesh = Miura(columns=side, rows=side).grow().mesh
    development = develop(mesh)
    return crease_pattern(mesh, development, 10 * side / np.ptp(development.vertices_coords))


def sheet_of(side: int) -> ThickSheet:
    panels = PanelSettings(thickness_mm=0.8, gap_mm=0.4)
    return thicken(miura(side), panels, HingeSettings(web_mm=0.2, relief_mm=0.1))[0]


def seconds(work) -> float:
    begin = time.perf_counter()
    work()
    return time.perf_counter() - begin


def peak_bytes() -> int:
    """Largest memory of this process so far."""
    resource = pytest.importorskip("resource")
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


# Corners of a hexahedron: four below, four above, counterclockwise.
_SIDES = ((3, 2, 1, 0), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))


def bare_step(corners: np.ndarray) -> bytes:
    """Hexahedra, shape (n, 8, 3), from shared edges and explicit planes, in a bare writer."""
    from OCP.BRep import BRep_Builder
    from OCP.BRepBuilderAPI import (
        BRepBuilderAPI_MakeEdge,
        BRepBuilderAPI_MakeFace,
        BRepBuilderAPI_MakeVertex,
        BRepBuilderAPI_MakeWire,
    )
    from OCP.gp import gp_Dir, gp_Pln, gp_Pnt
    from OCP.Interface import Interface_Static
    from OCP.STEPControl import STEPControl_StepModelType, STEPControl_Writer
    from OCP.TopoDS import TopoDS, TopoDS_Compound, TopoDS_Shell, TopoDS_Solid

    builder = BRep_Builder()
    whole = TopoDS_Compound()
    builder.MakeCompound(whole)
    sides = corners[:, _SIDES]
    normals = np.cross(sides[:, :, 2] - sides[:, :, 0], sides[:, :, 3] - sides[:, :, 1])
    for points, planes in zip(corners.tolist(), normals.tolist(), strict=True):
        places = [gp_Pnt(*point) for point in points]
        vertices = [BRepBuilderAPI_MakeVertex(place).Vertex() for place in places]
        edges: dict[tuple[int, int], object] = {}
        shell = TopoDS_Shell()
        builder.MakeShell(shell)
        for ring, normal in zip(_SIDES, planes, strict=True):
            wire = BRepBuilderAPI_MakeWire()
            for a, b in zip(ring, ring[1:] + ring[:1], strict=True):
                if (b, a) in edges:
                    wire.Add(TopoDS.Edge(edges[b, a].Reversed()))
                else:
                    edges[a, b] = BRepBuilderAPI_MakeEdge(vertices[a], vertices[b]).Edge()
                    wire.Add(edges[a, b])
            plane = gp_Pln(places[ring[0]], gp_Dir(*normal))
            builder.Add(shell, BRepBuilderAPI_MakeFace(plane, wire.Wire(), True).Face())
        shell.Closed(True)
        solid = TopoDS_Solid()
        builder.MakeSolid(solid)
        builder.Add(solid, shell)
        builder.Add(whole, solid)
    writer = STEPControl_Writer()
    Interface_Static.SetIVal_s("write.surfacecurve.mode", 0)
    writer.Transfer(whole, STEPControl_StepModelType.STEPControl_AsIs)
    stream = io.BytesIO()
    writer.WriteStream(stream)
    return stream.getvalue()


def test_step_costs_little_more_than_a_bare_writer(benchmark):
    from OCP.Message import Message, Message_Gravity

    for printer in Message.DefaultMessenger_s().Printers():
        printer.SetTraceLevel(Message_Gravity.Message_Fail)
    step_bytes(sheet_of(2), "first")  # imports
    taken, floors, peaks = [], [], []
    for side in SIDES:
        sheet = sheet_of(side)
        hexahedra = sheet.bodies.vertices_coords.reshape(-1, 8, 3)
        assert len(hexahedra) == len(sheet.bodies)
        rounds = 3 if side < 40 else 1
        ours, floor = [], []
        for _ in range(rounds):  # in turn, so that both meet the same machine
            floor.append(seconds(partial(bare_step, hexahedra)))
            ours.append(seconds(partial(step_bytes, sheet, "sheet")))
        taken.append(min(ours))
        floors.append(min(floor))
        peaks.append(round(peak_bytes() / 1e9, 2))
    ratios = [round(ours / bare, 2) for ours, bare in zip(taken, floors, strict=True)]
    panels = [side * side for side in SIDES]
    exponent = float(np.polyfit(np.log(panels), np.log(taken), 1)[0])
    figures = {
        "panels": panels,
        "seconds": [round(value, 2) for value in taken],
        "ratios": ratios,
        "exponent": round(exponent, 2),
        "peak_gigabytes": peaks,
    }
    benchmark.extra_info.update(figures)
    print(f"\nsolids and STEP: {figures}")
    small = sheet_of(10)
    benchmark.pedantic(lambda: step_bytes(small, "sheet"), rounds=3)
    assert max(ratios) < 1.5
    assert exponent < 1.1


def test_threemf_costs_little_more_than_its_bytes(benchmark):
    taken, floors = [], []
    for side in SIDES:
        parts = [PrintObject("sheet", tuple(sheet_parts(sheet_of(side))))]
        data = threemf_bytes(parts, "sheet")
        with zipfile.ZipFile(io.BytesIO(data)) as package:
            files = {name: package.read(name) for name in package.namelist()}

        def bare(files=files) -> None:
            with zipfile.ZipFile(io.BytesIO(), "w", zipfile.ZIP_DEFLATED) as package:
                for name, text in files.items():
                    package.writestr(name, text)

        ours, floor = [], []
        for _ in range(5):
            floor.append(seconds(bare))
            ours.append(seconds(partial(threemf_bytes, parts, "sheet")))
        taken.append(float(np.median(ours)))
        floors.append(float(np.median(floor)))
    tracemalloc.start()
    threemf_bytes(parts, "sheet")
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    panels = [side * side for side in SIDES]
    exponent = float(np.polyfit(np.log(panels), np.log(taken), 1)[0])
    figures = {
        "panels": panels,
        "seconds": [round(value, 3) for value in taken],
        "ratios": [round(ours / bare, 2) for ours, bare in zip(taken, floors, strict=True)],
        "exponent": round(exponent, 2),
        "peak_megabytes": round(peak / 1e6),
        "megabytes": round(len(data) / 1e6, 1),
    }
    benchmark.extra_info.update(figures)
    print(f"\n3MF: {figures}")
    benchmark.pedantic(lambda: threemf_bytes(parts, "sheet"), rounds=3)
    assert max(figures["ratios"]) < 2
    assert exponent < 1.1


def test_step_files_of_films_cost_as_much_for_each_face(benchmark):
    """`relative_cost` is the cost of a face of 20 x 20 over that of 10 x 10 in the same run."""
    hinge = HingeSettings(kind="film")
    small, large = (thicken(grid(n, n, 20.0), PanelSettings(), hinge)[0] for n in (10, 20))
    step_bytes(small, "small")  # OpenCASCADE is loaded
    begin = time.process_time()
    step_bytes(small, "small")
    before = time.process_time() - begin
    begin = time.process_time()
    benchmark.pedantic(step_bytes, args=(large, "large"), rounds=1)
    relative = (time.process_time() - begin) / (4 * before)
    benchmark.extra_info.update(relative_cost=round(relative, 2))
    print(f"\n400 faces on a film: {relative:.2f} of the cost of a face of 100")
    assert relative < 2
