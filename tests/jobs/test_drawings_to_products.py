"""Drawings in the dialects of many programs, from the file to sheets that are cut and folded.

Counts and lengths by letter are those of the source; mountains and valleys are not swapped, which
the folded shape shows; and nothing is mirrored, which the middles of the creases of each letter
show.
"""

import io
from collections import Counter
from dataclasses import dataclass, replace

import ezdxf
import numpy as np
import pytest
from formats import drawing_dialects
from formats.svg import dialects as svg_dialects

from fab.drawings.drawing_files import SheetFormat
from fab.folding.fold_settings import FoldSettings
from fab.formats.pattern_file import resized
from fab.formats.read_options import ReadOptions
from fab.jobs.folding_files import SimulationFormat, simulate
from fab.jobs.reading import read_any
from fab.jobs.sheet_files import fabricate
from fab.pattern.crease_pattern import fold_angles_deg
from fab.sheets.materials import load_machine, load_material
from fab.sheets.sheet_request import SheetRequest

WIDTH_MM = 200.0


@dataclass(frozen=True)
class Drawing:
    """A file, its lines (n, 2, 2) and their letters, and whether it says how far they fold."""

    ending: str
    data: bytes
    lines: np.ndarray
    letters: np.ndarray
    angles: bool = False


def corners(quarters: int = 0) -> svg_dialects.Source:
    """Creases that do not meet, so that each folds by itself; unlike its mirror images.

    quarters : turns by 90 degrees, after which the other side of the sheet is up if they are odd.
    """
    source = svg_dialects.source(
        *[("B", *p, *q) for p, q in zip(*_rim(), strict=True)],
        ("M", 0, 20, 25, 0, -60.0),
        ("V", 100, 0, 100, 80, 60.0),
        ("M", 130, 0, 130, 80, -60.0),
        ("V", 70, 80, 40, 0, 60.0),
    )
    coords = source.coords
    for _ in range(quarters):
        coords = coords[..., ::-1] * [-1, 1]
    if quarters % 2 == 0:
        return replace(source, coords=coords)
    return replace(source.as_letters(M="V", V="M"), coords=coords * [-1, 1], angles=-source.angles)


def _rim():
    points = [(25, 0), (40, 0), (100, 0), (130, 0), (150, 0), (150, 80), (130, 80), (100, 80)]
    points += [(70, 80), (0, 80), (0, 20), (0, 0)]
    return points, [*points[1:], points[0]]


def svg(dialect: str, source: svg_dialects.Source) -> Drawing:
    written = svg_dialects.DIALECTS[dialect](source)
    letters = np.where(written.lines.letters == "?", "U", written.lines.letters)
    return Drawing(".svg", written.text.encode(), written.lines.coords, letters, written.angles)


def drawing(dialect: str, source: svg_dialects.Source) -> Drawing:
    kind = drawing_dialects.DIALECTS[dialect]
    lines = drawing_dialects.Source("pattern", source.coords, source.letters)
    kept = kind.kept(lines)
    return Drawing(kind.ending, kind.write(lines), kept.lines, kept.letters)


SOURCES = {name: (lambda name=name: svg_dialects.lines_of(name)) for name in svg_dialects.NAMES}
SOURCES |= {f"corners_{k}": (lambda k=k: corners(k)) for k in range(4)}
FOLDING = [f"corners_{k}" for k in range(4)]
OTHERS = [name for name in drawing_dialects.DIALECTS if name != "dxf_fusion"]  # one colour alone
FILES = {
    **{
        f"{source}_{dialect}.svg": (svg, dialect, source)
        for dialect in svg_dialects.DIALECTS
        for source in ("bird_base", "pinwheel", "square_twist", *FOLDING)
    },
    **{
        f"{source}_{dialect}": (drawing, dialect, source)
        for dialect in OTHERS
        for source in ("bird_base", *FOLDING[:2])
    },
}


def made(file: str) -> Drawing:
    function, dialect, source = FILES[file]
    return function(dialect, SOURCES[source]())


def read(file: str, folder):
    """What was drawn, and the pattern that was read, 200 mm long."""
    drawn = made(file)
    path = folder / f"drawing{drawn.ending}"
    path.write_bytes(drawn.data)
    options = ReadOptions(fold_deg=60.0 if "corners" in file else None)
    found = resized(read_any([path], options), width_mm=WIDTH_MM)
    lines = drawn.lines - drawn.lines.min(axis=(0, 1))
    return lines * (WIDTH_MM / lines.max()), drawn.letters, found.pattern


def lengths(lines, letters) -> dict[str, float]:
    length = np.hypot(*(lines[:, 1] - lines[:, 0]).T)
    return {str(letter): float(length[letters == letter].sum()) for letter in np.unique(letters)}


def middles(lines, letters) -> np.ndarray:
    """The middle of all lines of each letter, by their lengths."""
    length = np.hypot(*(lines[:, 1] - lines[:, 0]).T)
    return np.array(
        [
            np.average(lines[letters == letter].mean(axis=1), axis=0, weights=length[own])
            for letter in np.unique(letters)
            if len(own := np.flatnonzero(letters == letter))
        ]
    )


def test_there_are_as_many_files_as_promised():
    """Of each kind, those that are folded as well."""
    endings = Counter(made(file).ending for file in FILES if "corners" in file)
    assert endings[".svg"] >= 40
    assert endings[".cp"] >= 20
    assert endings[".dxf"] >= 10
    assert endings[".opx"] >= 5


@pytest.fixture(scope="module")
def request_of_whole_lines() -> SheetRequest:
    """Sheets without kerf and margins, creases whole: what is drawn is as long as the pattern."""
    material = load_material("card_300gsm")
    whole = material.perforation.model_copy(update={"margin_mm": 0.0})
    machine = load_machine("co2_60w_600x400")
    return SheetRequest(
        material.model_copy(update={"perforation": whole}),
        machine.model_copy(update={"kerf_mm": 0.0, "profile": "whole_lines"}),
        formats=[SheetFormat.DXF],
    )


@pytest.mark.parametrize("file", FILES)
def test_sheets_have_the_lines_of_the_drawing(file, tmp_path, request_of_whole_lines):
    lines, letters, pattern = read(file, tmp_path)
    ends = pattern.vertices_coords[pattern.edges_vertices]
    found, wanted = lengths(ends, pattern.edges_assignment), lengths(lines, letters)
    assert found == pytest.approx(wanted, rel=1e-6)
    assert middles(ends, pattern.edges_assignment) == pytest.approx(
        middles(lines, letters), abs=1e-6 * WIDTH_MM
    )
    if "cp_oripa" not in file:  # it leaves out facet creases: valleys on both sides are one
        counts = Counter(pattern.edges_assignment.tolist())
        assert [counts[k] for k in "MV"] == [(letters == k).sum() for k in "MV"]
    sheet = fabricate(pattern, "sheet", request_of_whole_lines)
    assert len(sheet.report["pieces"]) == 1
    document = ezdxf.read(io.StringIO(sheet.files["sheet_1.dxf"].decode()))
    cut: Counter[str] = Counter()
    for entity in document.modelspace():
        cut[entity.dxf.layer] += length_of(entity)
    assert cut["MOUNTAIN"] == pytest.approx(wanted.get("M", 0.0), rel=1e-6)
    assert cut["VALLEY"] == pytest.approx(wanted.get("V", 0.0), rel=1e-6)
    assert cut["CUT"] + cut["HOLE"] == pytest.approx(wanted["B"] + wanted.get("C", 0.0), rel=1e-6)


def length_of(entity) -> float:
    if entity.dxftype() == "LINE":
        return (entity.dxf.end - entity.dxf.start).magnitude
    points = np.array([(x, y) for x, y, *_ in entity.get_points()])
    closed = np.concatenate([points, points[:1]]) if entity.closed else points
    return float(np.hypot(*np.diff(closed, axis=0).T).sum())


@pytest.mark.parametrize("file", [file for file in FILES if "corners" in file])
def test_the_folded_sheet_has_mountains_where_they_were_drawn(file, tmp_path):
    """The sides to which creases fold are measured in the simulated shape, not in the pattern."""
    lines, letters, pattern = read(file, tmp_path)
    folded = simulate(pattern, "sheet", FoldSettings(steps=4), formats=[SimulationFormat.FOLD])
    assert folded.report["verdict"]["reached"], folded.report["verdict"]
    (tmp_path / "folded.fold").write_bytes(folded.files["sheet_folding.fold"])
    shape = read_any([tmp_path / "folded.fold"]).pattern
    angles = fold_angles_deg(
        shape.folded_coords, shape.edges, shape.faces_vertices, shape.faces_offsets
    )
    ends = shape.vertices_coords[shape.edges_vertices]
    at = ends.mean(axis=1)
    for letter, sign in (("M", -1), ("V", 1)):
        for middle in lines[letters == letter].mean(axis=1):
            crease = int(np.argmin(np.hypot(*(at - middle).T)))
            assert np.hypot(*(at[crease] - middle)) < 1e-6 * WIDTH_MM
            assert angles[crease] == pytest.approx(60 * sign, abs=1e-4)


def test_the_comparison_would_see_swaps_and_mirror_images():
    source = corners(0)
    swapped = np.array([{"M": "V", "V": "M"}.get(k, k) for k in source.letters.tolist()])
    assert lengths(source.coords, swapped) != pytest.approx(lengths(source.coords, source.letters))
    for flip in ([1, -1], [-1, 1]):
        mirrored = source.coords * flip
        mirrored -= mirrored.min(axis=(0, 1))
        difference = middles(mirrored, source.letters) - middles(source.coords, source.letters)
        assert np.abs(difference).max() > 1
