"""Random products, of which every format and every figure says the same.

    python -m tests.fuzz.differential --seconds 600 --seed 1
    python -m tests.fuzz.differential --checks solids --count 50

- drawings: sheets of random patterns, materials, machines and wishes: DXF = SVG = PDF line by line,
  LBRN2, HP-GL and G-code by length and box of each operation; lengths, pierces, travel and minutes
  of the report are those of the lines in the SVG files
- solids: thick sheets: STL = 3MF = STEP by volume and box, and so does the report say
- patterns: FOLD in = FOLD out, number by number
- sheets: jobs of random parameters: planarity, isometry, boxes and counts of the report are
  those of the FOLD file
- all: the same bytes when it is made twice

Files are read by readers that share no code with their writers. A number of a check can be tried
again alone with `--first NUMBER --count 1`. Exit code 1 where two disagree.
"""

from __future__ import annotations

import argparse
import io
import json
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any

sys.path[:0] = [str(Path(__file__).parent.parent), str(Path(__file__).parent.parent.parent)]

import flat_patterns
import numpy as np
from fuzz.seeds import patterns
from machine_readers import Stroke, read_grbl, read_lightburn, read_plotter
from sheet_readers import ReadSheet, read_dxf_sheet, read_pdf_sheet, read_svg_sheet
from slicer_readers import Package, read_by_prusa

from fab.catalogue import known_of
from fab.drawings.drawing_files import SheetFormat
from fab.formats.fold.writer import fold_bytes
from fab.formats.pattern_file import PatternFile
from fab.formats.reading import read_pattern_file
from fab.jobs.job import parse_job
from fab.jobs.job_files import make
from fab.jobs.print_files import make_thick
from fab.jobs.sheet_files import fabricate
from fab.jobs.thick_products import ThickFormat
from fab.outputs import Made
from fab.pattern.crease_pattern import CreasePattern, scaled
from fab.printing.printers import load_print_material, load_printer
from fab.printing.thick_settings import PrintWith, ThickSettings
from fab.settings import checked
from fab.sheets.cut_wishes import CutWishes
from fab.sheets.materials import Powers, load_machine, load_material
from fab.sheets.registration import Registration
from fab.sheets.sheet_request import SheetRequest
from solver.errors import OrigamiError

__all__ = ["CHECKS", "Outcome", "compared"]

Random = np.random.Generator
_CUT, _PERFORATED = ("RELIEF", "HOLE", "CUT"), ("MOUNTAIN", "VALLEY")
_TOOLS = ("ENGRAVE", "MOUNTAIN", "VALLEY", "RELIEF", "CUT", "HOLE")
# Units of the last digits in drawings, and of a plotter, mm.
_DIGIT, _PLOTTED = 1e-6, 0.0125 + 1e-9
# Single precision of meshes, over their size.
_SINGLE = 2e-7


@dataclass(frozen=True)
class Outcome:
    """How a comparison ended: "same", "refused" or "fault", with its text."""

    kind: str
    text: str


def _of(random: Random, values: Any) -> Any:
    return values[int(random.integers(len(values)))]


def _random_pattern(random: Random, most_faces: int) -> CreasePattern:
    """A published pattern, or squares, triangles, a fan or a strip that nobody has drawn."""
    kind = random.integers(5)
    if kind == 0:
        return _of(random, [each for each in patterns() if each.face_count <= most_faces])
    if kind == 1:
        columns, rows = (int(n) for n in random.integers(1, 4, 2))
        return flat_patterns.grid(columns, rows, float(random.uniform(5, 60)))
    if kind == 2:
        return flat_patterns.triangles(int(random.integers(10**6)), count=_of(random, (4, 6, 9)))
    if kind == 3:
        return flat_patterns.fan(int(random.integers(3, 8)), float(random.uniform(10, 90)))
    quads = int(random.integers(2, 10))
    return flat_patterns.turned_strip(quads, float(random.uniform(0.0, 1.2)))


def _drawings(random: Random) -> Callable[[], Made]:
    pattern = scaled(_random_pattern(random, 60), width_mm=float(random.uniform(30, 320)))
    powers = Powers(cut_percent=80, perforate_percent=60, score_percent=15, engrave_percent=12.5)
    machine = load_machine(_of(random, sorted(known_of("cutter"))))
    machine = machine.model_copy(update={"powers": powers})
    material = load_material(_of(random, sorted(known_of("sheet"))))
    wishes = CutWishes(
        bridges=_of(random, (0, 0, 1, 3)),
        closed_slots=bool(random.integers(6) == 0),
        mirror=bool(random.integers(4) == 0),
        tabs=_of(random, ("one side", "one side", "both sides", "slots", "stitches", "none")),
        title=bool(random.integers(5) == 0),
    )
    formats = [SheetFormat.DXF, SheetFormat.SVG, SheetFormat.PDF]
    if random.integers(2):
        formats += [SheetFormat.LBRN2, SheetFormat.PLT, SheetFormat.GCODE]
    choices: dict[str, Any] = {
        "copies": _of(random, (1, 1, 1, 2, 3)),
        "registration": Registration() if random.integers(5) == 0 else None,
        "shared_cuts": bool(random.integers(5) == 0),
    }

    def made() -> Made:
        request = SheetRequest(
            material, machine, formats=formats, page=False, wishes=wishes, **choices
        )
        return fabricate(pattern, "a", request)

    return made


def _compare_drawings(made: Made, random: Random) -> None:
    machine = made.report["machine"]
    material = made.report["material"]
    for sheet in made.report["sheets"]:
        drawings = [name for name in sheet["files"] if not name.endswith("_frame.gcode")]
        sides = sorted({name.rpartition(".")[0] for name in drawings})
        work = []
        for side in sides:
            own = [name for name in drawings if name.rpartition(".")[0] == side]
            data = {name.rpartition(".")[2]: made.files[name] for name in own}
            _compare_files(data, machine)
            work.append(read_svg_sheet(data["svg"]))
        _compare_estimate(sheet, work, machine["speeds"], material)


def _compare_files(data: Mapping[str, bytes], machine: Mapping[str, Any]) -> None:
    """The same lines in all drawings of a side of a sheet."""
    dxf = read_dxf_sheet(data["dxf"])
    for kind, other in (("svg", read_svg_sheet(data["svg"])), ("pdf", read_pdf_sheet(data["pdf"]))):
        assert set(other.lines) == set(dxf.lines), f"{kind}: layers {set(other.lines)}"
        assert np.allclose(other.page, dxf.page, rtol=0, atol=1e-3), f"{kind}: page {other.page}"
        for layer in dxf.lines:
            first, second = (_in_digits(each, layer) for each in (dxf, other))
            assert np.array_equal(first, second), f"{kind}: lines of {layer}"
    readers = {
        "lbrn2": lambda data: read_lightburn(data).strokes,
        "gcode": lambda data: read_grbl(data).strokes,
    }
    for kind in set(readers) & set(data):
        _compare_strokes(kind, readers[kind](data[kind]), dxf, 5e-4)
    if "plt" in data:
        plot = read_plotter(data["plt"])
        width, depth = machine["bed_mm"]
        if depth > width:
            plot = plot.turned_back(width)
        strokes = [replace(each, tool=_TOOLS[int(each.tool) - 1]) for each in plot.strokes]
        _compare_strokes("plt", strokes, dxf, _PLOTTED)


def _in_digits(sheet: ReadSheet, layer: str) -> np.ndarray:
    """Sides of the lines of a layer in units of the last digit, in one order."""
    rows = np.rint(sheet.sides(layer) / _DIGIT).astype(np.int64)
    ends = np.sort(rows.reshape(-1, 2).view("i8,i8").reshape(-1, 2), axis=1)
    rows = ends.view("i8").reshape(-1, 4)
    return rows[np.lexsort(rows.T)]


def _compare_strokes(kind: str, strokes: list[Stroke], dxf: ReadSheet, rounding: float) -> None:
    """Lengths and boxes of operations, with points off by up to a rounding."""
    by_layer: dict[str, list[np.ndarray]] = {}
    for stroke in strokes:
        by_layer.setdefault(stroke.tool, []).append(stroke.points)
    assert set(by_layer) == set(dxf.lines), f"{kind}: operations {sorted(by_layer)}"
    other = ReadSheet(by_layer, dxf.page)
    for layer, lines in dxf.lines.items():
        count = sum(len(line) for line in lines)
        bound = 2 * np.sqrt(2) * rounding * count
        lengths = dxf.length(layer), other.length(layer)
        assert abs(lengths[0] - lengths[1]) <= bound, f"{kind}: {layer} is {lengths} mm long"
        first, second = (_box(each.lines[layer]) for each in (dxf, other))
        assert np.abs(first - second).max() <= rounding + _DIGIT, f"{kind}: box of {layer}"


def _box(lines: list[np.ndarray]) -> np.ndarray:
    points = np.concatenate(lines)
    return np.array([points.min(axis=0), points.max(axis=0)])


def _compare_estimate(
    sheet: Mapping[str, Any],
    sides: list[ReadSheet],
    speeds: Mapping[str, float],
    material: Mapping[str, Any],
) -> None:
    """Lengths, pierces, travel and time, by the lines of all sides in the order of their files."""
    lengths = {
        "cut_mm": sum(side.length(*_CUT) for side in sides),
        "perforate_mm": sum(side.length(*_PERFORATED) for side in sides),
        "engrave_mm": sum(side.length("ENGRAVE") for side in sides),
    }
    layers = (*_PERFORATED, *_CUT)
    through = [line for side in sides for layer in layers for line in side.lines.get(layer, [])]
    order = [line for side in sides for own in side.lines.values() for line in own]
    count = sum(map(len, order))
    for key, length in lengths.items():
        assert abs(sheet[key] - length) <= 1e-4 + 2 * _DIGIT * count, f"{key}: {length}"
    assert sheet["pierces"] == len(through), f"pierces: {len(through)}"
    travel = sum(map(_travel, sides))
    assert abs(sheet["travel_mm"] - travel) <= 1e-4 + 4 * _DIGIT * len(order), f"travel: {travel}"
    ratio = material["cut_speed_ratio"]
    seconds = (
        lengths["cut_mm"] / (speeds["cut_mm_s"] * ratio)
        + lengths["perforate_mm"] / (speeds["perforate_mm_s"] * ratio)
        + lengths["engrave_mm"] / speeds["engrave_mm_s"]
        + travel / speeds["travel_mm_s"]
        + len(through) * speeds["pierce_s"]
    )
    assert abs(sheet["minutes"] - seconds / 60) <= 1e-4 * max(1.0, seconds), f"{seconds / 60} min"


def _travel(sheet: ReadSheet) -> float:
    """From the origin to the first line, and from each line to the next."""
    lines = [line for own in sheet.lines.values() for line in own]
    ends = [np.zeros(2), *(line[-1] for line in lines)]
    starts = [line[0] for line in lines]
    return sum(float(np.hypot(*(b - a))) for a, b in zip(ends, starts, strict=False))


def _solids(random: Random) -> Callable[[], Made]:
    pattern = _random_pattern(random, 12)
    pattern = scaled(pattern, width_mm=float(random.uniform(40, 180)))
    kind = _of(random, ("web", "web", "film", "knuckle", "none"))
    panels: dict[str, Any] = {"thickness_mm": round(float(random.uniform(0.8, 3.0)), 2)}
    if kind == "knuckle":
        panels["axis"] = "middle"
    tables = {"panels": panels, "hinges": {"kind": kind}}
    settings = checked(ThickSettings, tables, "a", "Give it.")
    print_with = PrintWith()
    if random.integers(3) == 0:
        printer = load_printer(_of(random, sorted(known_of("printer"))))
        print_with = PrintWith(printer, load_print_material(_of(random, sorted(known_of("print")))))
    formats = [ThickFormat.STL, ThickFormat.THREEMF, ThickFormat.STEP]

    def made() -> Made:
        return make_thick(pattern, "a", settings, print_with=print_with, formats=formats)

    return made


def _compare_solids(made: Made, random: Random) -> None:
    import trimesh

    if made.report["plates"] is not None or "a_thick.stl" not in made.files:
        return
    if any(finding.code == "joined-invalid" for finding in made.findings):
        return  # bodies that overlap: an error says that their union is smaller, and by how much
    found: dict[str, tuple[float, np.ndarray]] = {}
    mesh = trimesh.load(io.BytesIO(made.files["a_thick.stl"]), file_type="stl")
    found["stl"] = float(mesh.volume), np.asarray(mesh.extents)
    package = Package(made.files["a_thick.3mf"])
    parts = [part for _, each in read_by_prusa(package) for part in each]
    solids = [trimesh.Trimesh(part.vertices, part.triangles) for part in parts]
    bounds = np.array([solid.bounds for solid in solids])
    box = bounds[:, 1].max(axis=0) - bounds[:, 0].min(axis=0)
    found["3mf"] = sum(float(solid.volume) for solid in solids), box
    found["step"] = _step_solids(made.files["a_thick.step"])
    figures = made.report["solids"]
    laid = figures["laid_mm3"]
    found["report"] = figures["volume_mm3"], np.array(made.report["bounding_box_mm"]["print"])
    volume, box = found["report"]
    size = float(np.linalg.norm(box))
    area = size * size
    for kind, (other, sides) in found.items():
        near = abs(other - volume) <= area * size * _SINGLE + 1e-6 * volume
        near |= kind == "step" and abs(other - volume - laid) <= 1e-6 * volume
        assert near, f"{kind}: {other} mm3, not {volume}"
        assert np.abs(np.sort(sides) - np.sort(box)).max() <= 2 * size * _SINGLE + 2e-6, (
            f"{kind}: {sides} mm, not {box}"
        )


def _step_solids(data: bytes) -> tuple[float, np.ndarray]:
    """Volume and box of the solids of a STEP file, as OpenCASCADE measures them."""
    import build123d as cad

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.step"
        path.write_bytes(data)
        model = cad.import_step(path)
    solids = model.solids()
    corners = np.array([[*vertex.center()] for solid in solids for vertex in solid.vertices()])
    return sum(float(solid.volume) for solid in solids), np.ptp(corners, axis=0)


def _patterns(random: Random) -> Callable[[], Made]:
    pattern = scaled(_random_pattern(random, 400), width_mm=float(random.uniform(10, 1000)))
    angles = pattern.edges_foldAngle * random.uniform(0.2, 1.0)
    # without vertices of no edge, and faces that are clockwise
    pattern = _read(fold_bytes(replace(pattern, edges_foldAngle=angles), "a")).pattern

    def made() -> Made:
        return Made({"a.fold": fold_bytes(pattern, "a")}, {"pattern": pattern}, ())

    return made


def _compare_patterns(made: Made, random: Random) -> None:
    pattern, data = made.report["pattern"], made.files["a.fold"]
    document = json.loads(data)
    corners = [
        pattern.faces_vertices[start:end].tolist() for start, end in pairwise(pattern.faces_offsets)
    ]
    assert document["faces_vertices"] == corners, "faces of the file"
    flat = np.pad(pattern.vertices_coords, ((0, 0), (0, 1)))
    assert document["vertices_coords"] == flat.tolist(), "vertices of the file"
    for key in ("edges_vertices", "edges_assignment"):
        assert document[key] == getattr(pattern, key).tolist(), f"{key} of the file"
    angles = np.array([0.0 if x is None else x for x in document["edges_foldAngle"]])
    assert np.array_equal(angles, pattern.edges_foldAngle), "angles of the file"
    read = _read(data)
    assert fold_bytes(read.pattern, read.title) == data, "FOLD in is not FOLD out"


def _read(data: bytes) -> PatternFile:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.fold"
        path.write_bytes(data)
        return read_pattern_file(path)


@cache
def _kinds() -> tuple[dict[str, Any], ...]:
    return (
        {"kind": "miura", "columns": (3, 9), "rows": (3, 9), "fold_deg": (5.0, 85.0)},
        {"kind": "rigid_miura", "columns": (3, 9), "rows": (3, 9)},
        {"kind": "cornered_miura"},
        {"kind": "curved_fold"},
        {"kind": "random_tube", "random_seed": (0, 50)},
    )


def _sheets(random: Random) -> Callable[[], Made]:
    chosen = dict(_of(random, _kinds()))
    design = {
        key: value
        if isinstance(value, str)
        else int(random.integers(value[0], value[1] + 1))
        if isinstance(value[0], int)
        else float(random.uniform(*value))
        for key, value in chosen.items()
    }
    width = float(random.uniform(20, 900))
    job = parse_job(
        {"name": "a", "design": design, "sheet": {"width_mm": width}, "outputs": ["fold"]}
    )
    return lambda: make(job)


def _compare_sheets(made: Made, random: Random) -> None:
    """What the report says of exactness, from the points of the file alone."""
    document, report = json.loads(made.files["a.fold"]), made.report
    flat = np.array(document["vertices_coords"])
    folded = np.array(document["file_frames"][0]["vertices_coords"])
    ends = np.array(document["edges_vertices"])
    faces = document["faces_vertices"]
    letters = Counter(document["edges_assignment"])
    assert report["counts"]["vertices"] == len(flat), "vertices"
    assert report["counts"]["faces"] == len(faces), "faces"
    assert {k: n for k, n in report["counts"]["creases"].items() if n} == dict(letters), "creases"
    for key, points in (("flat", flat), ("folded", folded)):
        box = np.ptp(points, axis=0)[: len(report["bounding_box_mm"][key])]
        assert np.abs(box - report["bounding_box_mm"][key]).max() <= 1e-6, f"box {key}: {box}"
    lengths = [np.linalg.norm(p[ends[:, 0]] - p[ends[:, 1]], axis=1) for p in (flat, folded)]
    off = float(np.abs(lengths[0] / lengths[1] - 1).max())
    assert off <= max(1e-9, 2 * report["isometry_max_rel"]), f"isometry: {off}"
    size = float(np.linalg.norm(np.ptp(folded, axis=0)))
    bent = 0.0
    for face in faces:
        points = folded[face] - folded[face].mean(axis=0)
        bent = max(bent, float(np.linalg.svd(points, compute_uv=False)[-1]) / size)
    assert bent <= max(1e-9, 4 * report["planarity_max"]), f"planarity: {bent}"


CHECKS: dict[str, tuple[Callable[[Random], Callable[[], Made]], Callable[[Made, Random], None]]] = {
    "drawings": (_drawings, _compare_drawings),
    "solids": (_solids, _compare_solids),
    "patterns": (_patterns, _compare_patterns),
    "sheets": (_sheets, _compare_sheets),
}


def compared(check: str, seed: int, number: int) -> Outcome:
    """Make one random product, compare all of it; one of three is made twice."""
    random = np.random.default_rng([seed, sorted(CHECKS).index(check), number])
    prepared, compare = CHECKS[check]
    try:
        try:
            make_it = prepared(random)
            made = make_it()
        except OrigamiError as error:
            return Outcome("refused", str(error))
        compare(made, random)
        if random.integers(3) == 0:
            again = make_it()
            first, second = (_without_seconds(each.files) for each in (made, again))
            assert first == second, "made twice it differs"
    except Exception:
        return Outcome("fault", traceback.format_exc())
    return Outcome("same", "")


def _without_seconds(files: Mapping[str, bytes]) -> dict[str, bytes]:
    """All files but reports, which say how long it took."""
    return {name: data for name, data in files.items() if not name.endswith("_report.json")}


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seconds", type=float, default=120.0)
    parser.add_argument("--checks", default=",".join(CHECKS))
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--count", type=int, default=10**9)
    arguments = parser.parse_args()
    names = arguments.checks.split(",")
    faults = 0
    for name in names:
        end = time.monotonic() + arguments.seconds / len(names)
        outcomes: Counter[str] = Counter()
        for number in range(arguments.first, arguments.first + arguments.count):
            if time.monotonic() > end:
                break
            outcome = compared(name, arguments.seed, number)
            outcomes[outcome.kind] += 1
            if outcome.kind == "fault":
                print(f"{name} {number}: {outcome.text}", flush=True)
        faults += outcomes["fault"]
        counts = ", ".join(f"{count} {kind}" for kind, count in sorted(outcomes.items()))
        print(f"{name}: {counts}", flush=True)
    return int(faults > 0)


if __name__ == "__main__":
    sys.exit(main())
