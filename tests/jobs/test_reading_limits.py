"""Bounds of readers hold before the work that they bound."""

import contextlib
import json
import time
import tracemalloc

import pytest
from fuzz.trials import watched_opens

from fab.errors import InvalidFile, InvalidJob
from fab.formats import json_files
from fab.formats.json_files import memory_needed, read_json
from fab.formats.meshes.surface import read_surface
from fab.formats.read_options import ReadOptions
from fab.formats.reading import READ, read_pattern_file
from fab.formats.svg.safe_xml import read_xml
from fab.jobs.reading_limits import LIMITS
from fab.settings import DEEPEST, apply_change, parsed_toml
from fab.surfaces.mesh_reader import MESH_ENDINGS
from fab.surfaces.reading import read_surface_mesh
from solver.errors import InvalidState, InvalidValue, OrigamiError

PATTERNS = [limit for limit in LIMITS if set(limit.endings) <= set(READ)]
SURFACES = [limit for limit in LIMITS if limit not in PATTERNS]


def of_size(path, size):
    with path.open("wb") as file:
        file.truncate(size)  # takes no room on the disk
    return path


def test_every_format_has_its_limits():
    assert {ending for limit in PATTERNS for ending in limit.endings} == set(READ)
    surfaces = {ending for limit in SURFACES for ending in limit.endings}
    assert surfaces == {*MESH_ENDINGS, ".step", ".stp"}


@pytest.mark.parametrize("limit", PATTERNS, ids=lambda limit: limit.endings[0])
def test_patterns_over_their_size_are_refused_unread(limit, tmp_path):
    for ending in limit.endings:
        path = of_size(tmp_path / f"a{ending}", limit.largest_bytes + 1)
        tracemalloc.start()
        with pytest.raises(InvalidFile, match=f"over the bound of {limit.largest_bytes}"):
            read_pattern_file(path, ReadOptions())
        taken = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert taken < 10**7


@pytest.mark.parametrize("limit", SURFACES, ids=lambda limit: limit.endings[0])
def test_surfaces_over_their_size_are_refused_unread(limit, tmp_path):
    for ending in limit.endings:
        path = of_size(tmp_path / f"a{ending}", limit.largest_bytes + 1)
        with pytest.raises(InvalidFile, match=f"over the bound of {limit.largest_bytes}"):
            read_surface_mesh(path)


@pytest.mark.parametrize(
    "document",
    [
        {"a": [[0.1 + i, 1.5 * i] for i in range(20_000)]},
        {"a": [[] for _ in range(100_000)]},
        {"a": [{} for _ in range(100_000)]},
        {"a": [{"a": 1.5}] * 100_000},
        {"a": ["word"] * 100_000},
        {"a": list(range(10**9, 10**9 + 100_000))},
        {str(i): i for i in range(50_000)},
        {"a": "x" * 10**6},
        {"a": "é" + "x" * 10**6},
    ],
    ids=[
        "points",
        "lists",
        "empty objects",
        "objects",
        "texts",
        "integers",
        "keys",
        "letters",
        "wide letters",
    ],
)
def test_the_memory_that_json_takes_is_not_more_than_is_estimated(document, tmp_path):
    path = tmp_path / "a.fold"
    for separators in ((",", ":"), (", ", ": ")):
        path.write_text(json.dumps(document, separators=separators, ensure_ascii=False), "utf-8")
        tracemalloc.start()
        read_json(path, 10**8)
        taken = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert taken <= memory_needed(path.read_bytes()) + 10**5


def test_json_that_does_not_fit_into_memory_is_refused(tmp_path, monkeypatch):
    path = tmp_path / "a.fold"
    path.write_text('{"vertices_coords": [' + "[0.0, 1.0]," * 1000 + "[0, 0]]}")
    monkeypatch.setattr(json_files, "free_bytes", lambda: 200_000)
    with pytest.raises(InvalidFile, match=r"GB of memory, and 0\.0002 GB are free"):
        read_pattern_file(path, ReadOptions())


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16"])
@pytest.mark.parametrize("place", ["<text>{}</text>", '<text x="{}"/>'])
def test_entities_add_no_more_than_their_bound_in_any_encoding(encoding, place, tmp_path):
    path = tmp_path / "a.svg"
    head = f'<?xml version="1.0" encoding="{encoding}"?><!DOCTYPE svg [<!ENTITY a "{"x" * 900}">]>'
    path.write_text(f"{head}<svg>{place.format('&a;' * 3000)}</svg>", encoding)
    with pytest.raises(InvalidFile, match="entities add over 1 MB"):
        read_xml(path)
    path.write_text(f"{head}<svg>{place.format('&a;' * 900)}</svg>", encoding)
    read_xml(path)


def test_many_entities_are_refused_at_once(tmp_path):
    path = tmp_path / "a.svg"
    entities = "".join(f'<!ENTITY a{i} "x">' for i in range(20_000))
    path.write_text(f"<!DOCTYPE svg [{entities}]><svg>{'&a1;' * 100_000}</svg>")
    with pytest.raises(InvalidFile, match="declares over 100 entities"):
        read_xml(path)


def test_opx_files_have_a_bound_on_their_depth(tmp_path):
    path = tmp_path / "a.opx"
    path.write_text("<java>" + "<a>" * 101 + "</a>" * 101 + "</java>")
    with pytest.raises(
        InvalidFile, match=r"a\.opx: has over \d+ elements, or over 100 in each other"
    ):
        read_pattern_file(path, ReadOptions())


def test_tables_have_a_bound_on_their_depth():
    deepest = "x = " + "[" * (DEEPEST - 1) + "]" * (DEEPEST - 1)
    assert parsed_toml(deepest.encode(), "a.toml", "Mend it.")
    for text in ("x = [" + deepest[4:] + "]", "[" + "a." * DEEPEST + "a]\nb = 1"):
        with pytest.raises(InvalidJob, match=f"over {DEEPEST} deep"):
            parsed_toml(text.encode(), "a.toml", "Mend it.")


def test_a_change_of_thousands_of_digits_or_brackets_is_text():
    for value in ("9" * 5000, "[" * 900 + "]" * 900, "[" * 50_000):
        document = {}
        apply_change(document, f"design.rows={value}")
        assert document == {"design": {"rows": value}}


@pytest.mark.parametrize(
    "head", [b"<!a>" * 1000, b"\n" * 4000, b" \r\n" * 1300, b"999\r\na\r\n" * 500, b"g a\r\n" * 800]
)
def test_files_without_an_ending_are_refused_at_once(head, tmp_path):
    """Some patterns of beginnings fitted such files in more ways than there is time for."""
    path = tmp_path / "nameless"
    path.write_bytes(head + b"x")
    with pytest.raises(InvalidFile, match="not a crease pattern"):
        read_pattern_file(path, ReadOptions())


@pytest.mark.parametrize(
    ("head", "ending"),
    [
        (b'<?xml version="1.0"?>\n<!-- <java> -->\n<!DOCTYPE svg [<!ENTITY a "1">]>\n', ".svg"),
        (b"\xef\xbb\xbf\n", ".svg"),
        (b"# by hand\r\n\r\no sheet\r\n", ".obj"),
        (b"999\r\nby hand\r\n  ", ".dxf"),
    ],
)
def test_files_are_known_by_their_beginning(head, ending, tmp_path):
    path = tmp_path / "nameless"
    rest = {".svg": b"<svg ", ".obj": b"v 0 0 0\r\nf 1 2 3\r\n", ".dxf": b"0\r\nSECTION\r\n"}[
        ending
    ]
    path.write_bytes(head + rest)
    with pytest.raises(InvalidFile) as caught:
        read_pattern_file(path, ReadOptions())
    assert "not a crease pattern" not in str(caught.value)


@pytest.mark.parametrize("ending", [".cp", ".orh", ".ori"])
@pytest.mark.parametrize("text", ["\x1c", "\x1f \x85", "\u2003\n", "\ufeff \n"])
def test_files_of_blanks_of_any_kind_are_empty(text, ending, tmp_path):
    path = tmp_path / f"a{ending}"
    path.write_bytes(text.encode())
    with pytest.raises(InvalidFile, match="empty"):
        read_pattern_file(path, ReadOptions())


@pytest.mark.parametrize("data", ["C1 2 3 4 5 6", "Q1 2 3 4L9 9", "A5 5 0 0 1 9 9", "S1 2 3 4"])
def test_curves_of_a_path_that_begins_nowhere_are_not_drawn(data, tmp_path):
    path = tmp_path / "a.svg"
    square = "M0 0H100V100H0Z"
    head = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 200 200">'
    path.write_text(
        f'{head}<path d="{square}" stroke="black"/><path d="{data}" stroke="red"/></svg>'
    )
    read = read_pattern_file(path, ReadOptions())
    assert read.pattern.counts() == {"M": 0, "V": 0, "F": 0, "B": 4}
    assert any("path" in finding.text for finding in read.findings)


@pytest.mark.parametrize(
    ("ending", "text"),
    [
        (".ply", "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
         "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
         "0 0 0\n4 0 0\n4 3 0\n0 3 0\n4 0 1 2 99\n"),
        (".off", "OFF\n4 2 0\n0 0 0\n4 0 0\n4 1e200 0\n0 3 0\n3 0 1 2\n3 2 3 0\n"),
        (".obj", "v 0 0 0\nv 4 0 0\nv 4 1e300 0\nv 0 3 0\nf 1 2 3 4\n"),
    ],
)  # fmt: skip
def test_meshes_of_no_vertices_and_of_any_size_are_refused(ending, text, tmp_path):
    path = tmp_path / f"a{ending}"
    path.write_text(text)
    for read in (read_surface_mesh, read_surface):
        with pytest.raises(OrigamiError, match=r"vert|finite"):
            read(path)


def test_a_glb_file_that_says_it_holds_gigabytes_is_refused_within_its_bounds(tmp_path):
    import trimesh

    data = trimesh.creation.box().export(file_type="glb")
    size = int.from_bytes(data[12:16], "little")
    head = json.loads(data[20 : 20 + size])
    for accessor in head["accessors"]:
        accessor["count"] = 10**11
        accessor.pop("bufferView")  # zeros, as many as it says
    text = json.dumps(head).encode()
    text += b" " * (-len(text) % 4)
    rest = data[20 + size :]
    whole = (12 + 8 + len(text) + len(rest)).to_bytes(4, "little")
    path = tmp_path / "a.glb"
    path.write_bytes(data[:8] + whole + len(text).to_bytes(4, "little") + b"JSON" + text + rest)
    with pytest.raises(OrigamiError, match=r"memory|readable glb|allocate"):
        read_surface_mesh(path)


def test_errors_hold_no_control_characters():
    for error in (
        InvalidFile("a\x1b]0;title\x07\u202e"),
        InvalidJob("\x7f"),
        InvalidValue("x", "\x00", "be \x1b", "No."),
        InvalidState("x", "\x00 is", "No."),
    ):
        assert str(error).isprintable()


def svg_with(text):
    return f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 9 9">{text}</svg>'


LONG = {
    "cp": (".cp", "2 {} 0 5 5\n"),
    "cp with commas": (".cp", "2 0,5 {} 0 0\n"),
    "orh": (".orh", "<線分集合>\n番号,1\n色,1\n<tpp>1</tpp>座標,{},1,2,3\n"),
    "ori": (".ori", '{{"lineSegments": [{{"a": "{}, 1", "b": "1, 1", "color": "RED_1"}}]}}'),
    "opx": (
        ".opx",
        '<java><object class="oripa.DataSet"><void><array class="oripa.OriLineProxy" length="1">'
        '<void index="0"><object class="oripa.OriLineProxy"><void property="x0"><double>{}</double>'
        "</void></object></void></array></void></object></java>",
    ),
    "size": (".svg", '<svg xmlns="http://www.w3.org/2000/svg" width="{}"><path d="M0 0H9"/></svg>'),
    "line": (".svg", svg_with('<line x1="{}" x2="9" stroke="red"/>')),
    "points": (".svg", svg_with('<polyline points="{} 1 2 3" stroke="red"/>')),
    "path": (".svg", svg_with('<path d="M{} 1L2 3" stroke="red"/>')),
    "curve": (".svg", svg_with('<path d="M{} 1C2 3 4 5 6 7" stroke="red"/>')),
    "transform": (".svg", svg_with('<g transform="scale({})"><path d="M0 0H9"/></g>')),
    "style": (".svg", svg_with('<path d="M0 0H9" style="stroke:{};stroke-width:{}"/>')),
    "rule": (".svg", svg_with('<style>path{{stroke:{}}} {} > g</style><path d="M0 0H9"/>')),
    "dashes": (".svg", svg_with('<path d="M0 0H9" stroke="red" stroke-dasharray="{}"/>')),
    "dxf": (
        ".dxf",
        "0\nSECTION\n2\nENTITIES\n0\nLINE\n8\n{}\n10\n{}\n20\n0\n11\n9\n21\n9\n0\nENDSEC\n",
    ),
    "obj": (".obj", "v {} 0 0\nf 1 2 3\n"),
    "fold": (".fold", '{{"file_spec": {}, "vertices_coords": [[{}, 0]]}}'),
}


@pytest.mark.parametrize("word", ["1" * 50_000 + "x", "1" + " " * 50_000 + "!", "1." * 25_000])
@pytest.mark.parametrize("name", LONG)
def test_long_words_take_no_longer_than_others(name, word, tmp_path):
    """Some patterns of numbers took a time that grew with the square of their digits."""
    ending, text = LONG[name]
    path = tmp_path / f"a{ending}"
    path.write_text(text.format(word, word))
    begin = time.process_time()
    with contextlib.suppress(InvalidFile):
        read_pattern_file(path, ReadOptions())
    assert time.process_time() - begin < 3.0


@pytest.mark.parametrize("key", ["vertices_coords", "edges_vertices", "edges_assignment"])
def test_one_long_text_among_numbers_takes_no_memory_for_each_of_them(key, tmp_path):
    """An array of texts is as wide as its longest: of 4000 rows and a text of 1 MB, 16 GB."""
    side = 32
    corners = [[float(i % side), float(i // side)] for i in range(side * side)]
    edges = [[i, i + 1] for i in range(side * side - 1) if (i + 1) % side]
    document = {
        "vertices_coords": corners,
        "edges_vertices": edges,
        "edges_assignment": ["B"] * len(edges),
    }
    document[key][5] = "x" * 10**6 if key == "edges_assignment" else ["x" * 10**6, 0]
    path = tmp_path / "a.fold"
    path.write_text(json.dumps(document))
    tracemalloc.start()
    with pytest.raises(InvalidFile) as caught:
        read_pattern_file(path, ReadOptions())
    taken = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert taken < 3 * 10**7
    assert len(str(caught.value)) < 1000


def test_meshes_do_not_open_the_files_that_they_name(tmp_path):
    """A material, and its picture, beside an OBJ file."""
    (tmp_path / "a.mtl").write_text("newmtl m\nmap_Kd a.png\n")
    path = tmp_path / "a.obj"
    path.write_text("mtllib a.mtl\nv 0 0 0\nv 4 0 0\nv 4 3 0\nusemtl m\nf 1 2 3\n")
    with watched_opens(path) as strayed:
        read_surface_mesh(path)
    assert not [name for name in strayed if name.startswith(str(tmp_path))]
