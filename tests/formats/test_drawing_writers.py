"""CP and DXF files that are written, and what readers get back from them."""

import io
from dataclasses import replace

import ezdxf
import numpy as np
import pytest
from flat_patterns import fan, grid, triangles
from helpers import PATTERNS
from hypothesis import given
from hypothesis import strategies as st
from strategies import sheets

from fab import read_pattern
from fab.formats.dxf.reader import read_dxf
from fab.formats.dxf.writer import LAYERS, angles_lost_in_dxf, dxf_bytes
from fab.formats.oripa.cp import cp_bytes, lost_in_cp, read_cp
from fab.formats.read_options import ReadOptions
from fab.pattern.crease_pattern import crease_pattern
from fab.pattern.development import develop


@st.composite
def patterns(draw):
    """Triangles of all letters, and sheets that were grown, at any place."""
    sheet = triangles(draw(st.integers(0, 10_000)), draw(st.integers(4, 40)))
    letters = sheet.edges_assignment.copy()
    for i in draw(st.lists(st.integers(0, len(letters) - 1), max_size=5)):
        letters[i] = draw(st.sampled_from(list(LAYERS)))
    shift = draw(st.floats(-1e3, 1e3)), draw(st.floats(-1e3, 1e3))
    scale = draw(st.floats(1e-3, 1e3))
    coords = sheet.vertices_coords * scale + shift
    return replace(sheet, vertices_coords=coords, edges_assignment=letters)


@given(patterns())
def test_dxf_keeps_every_line_and_letter(pattern):
    soup = read_back(dxf_bytes(pattern, "Größe\n1"), ".dxf")
    np.testing.assert_array_equal(
        soup.lines_coords, pattern.vertices_coords[pattern.edges_vertices]
    )
    assert soup.lines_assignment.tolist() == pattern.edges_assignment.tolist()
    assert soup.mm_per_unit == 1.0
    assert soup.title == "Größe_1"
    assert soup.findings == ()


@given(patterns())
def test_cp_keeps_every_line_and_letter_that_it_can(pattern):
    soup = read_back(cp_bytes(pattern), ".cp")
    coords = pattern.vertices_coords
    middle = (coords.min(axis=0) + coords.max(axis=0)) / 2
    wanted = coords[pattern.edges_vertices] - middle
    np.testing.assert_allclose(soup.lines_coords, wanted, atol=1e-12 * np.abs(coords).max())
    known = {"B": "B", "C": "B", "M": "M", "V": "V"}
    letters = [known.get(letter, "F") for letter in pattern.edges_assignment.tolist()]
    assert soup.lines_assignment.tolist() == letters
    lost = {finding.code: finding for finding in lost_in_cp(pattern)}
    count = int(np.isin(pattern.edges_assignment, ["C", "J", "U"]).sum())
    assert ("lost-in-cp" in lost) == (count > 0)
    if count:
        assert lost["lost-in-cp"].text.startswith(f"{count} ")
    assert ("angles-lost-in-cp" in lost) == bool(angles_lost_in_dxf(pattern))


def read_back(data, ending, _folder=[]):  # noqa: B006 (one folder for all examples)
    import tempfile
    from pathlib import Path

    if not _folder:
        _folder.append(tempfile.TemporaryDirectory())
    path = Path(_folder[0].name) / f"pattern{ending}"
    path.write_bytes(data)
    return {".cp": read_cp, ".dxf": read_dxf}[ending](path, ReadOptions())


@pytest.mark.parametrize("name", sorted(path.stem for path in PATTERNS.glob("*.fold")))
def test_published_patterns_come_back(name):
    pattern, _ = read_pattern(PATTERNS / f"{name}.fold")
    ends = pattern.vertices_coords[pattern.edges_vertices]
    drawn = read_back(dxf_bytes(pattern, name), ".dxf")
    np.testing.assert_array_equal(drawn.lines_coords, ends)
    assert drawn.lines_assignment.tolist() == pattern.edges_assignment.tolist()
    listed = read_back(cp_bytes(pattern), ".cp")
    size = pattern.vertices_coords.max(axis=0)
    np.testing.assert_allclose(listed.lines_coords, ends - size / 2, atol=1e-9)


def test_dxf_files_are_the_same_bytes_each_time_and_sound():
    pattern = grid(4, 3, 25.0)
    data = dxf_bytes(pattern, "grid")
    assert data == dxf_bytes(pattern, "grid")
    document = ezdxf.read(io.StringIO(data.decode()))
    assert not document.audit().has_errors
    assert document.header["$INSUNITS"] == 4
    space = document.modelspace()
    assert len(space) == len(pattern.edges_vertices)
    colours = {layer.dxf.name: layer.color for layer in document.layers}
    assert {colours[name] == colour for name, colour in LAYERS.values()} == {True}
    assert document.header["$EXTMAX"][:2] == (100.0, 75.0)


def test_cp_files_are_as_oriedita_writes_them():
    sheet = fan(4, 10.0, "M")
    lines = cp_bytes(replace(sheet, edges_foldAngle=sheet.edges_foldAngle * 2)).decode().split("\n")
    assert lines[-1] == ""
    assert sorted(line.split()[0] for line in lines[:-1]) == ["1"] * 4 + ["2"] * 4
    assert all(len(line.split()) == 5 for line in lines[:-1])
    flat = replace(sheet, edges_foldAngle=np.sign(sheet.edges_foldAngle) * 180.0)
    assert lost_in_cp(flat) == angles_lost_in_dxf(flat) == ()
    assert angles_lost_in_dxf(sheet)[0].text.startswith("4 creases fold by less than 180 degrees")


@given(sheets())
def test_grown_sheets_come_back(mesh):
    pattern = crease_pattern(mesh, develop(mesh), 100.0)
    ends = pattern.vertices_coords[pattern.edges_vertices]
    np.testing.assert_array_equal(read_back(dxf_bytes(pattern, "x"), ".dxf").lines_coords, ends)
