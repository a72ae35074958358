"""CP, OPX, ORI and DXF files in the dialects of the programs that write them.

Lines, letters and their total lengths are those of the source; y is not mirrored and mountains and
valleys are not swapped, as every line is compared with its own, letter by letter.
"""

import functools

import numpy as np
import pytest
from formats.drawing_dialects import BY_NAME, DIALECTS, Source, files, java

from fab.errors import InvalidFile
from fab.formats.drawn.importer import pattern_of_lines
from fab.formats.dxf.reader import read_dxf
from fab.formats.oripa.cp import read_cp
from fab.formats.oripa.opx import read_opx
from fab.formats.oripa.ori import read_ori
from fab.formats.read_options import ReadOptions

READERS = {".cp": read_cp, ".opx": read_opx, ".ori": read_ori, ".orh": read_ori, ".dxf": read_dxf}
FILES = files()


def lengths(lines, letters):
    length = np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1)
    return {letter: length[letters == letter].sum() for letter in sorted(set(letters.tolist()))}


def aligned(lines):
    """Lines with the middle of their box at 0, and the width of the box."""
    low, high = lines.min(axis=(0, 1)), lines.max(axis=(0, 1))
    return lines - (low + high) / 2, (high - low).max()


def ordered(lines, letters):
    """Lines from their lower end, in an order that rounding does not change."""
    turned = lines.copy()
    key = lines[:, :, 0] + np.sqrt(2) * lines[:, :, 1]
    turned[key[:, 0] > key[:, 1]] = lines[key[:, 0] > key[:, 1]][:, ::-1]
    middle = turned.mean(axis=1)
    order = np.lexsort([np.round(middle @ [np.sqrt(3), np.sqrt(5)], 5), letters])
    return turned[order], letters[order]


def test_there_are_as_many_files_as_promised():
    endings = [dialect.ending for dialect, _ in FILES.values()]
    assert endings.count(".cp") >= 20
    assert endings.count(".dxf") >= 10
    assert endings.count(".opx") >= 5


@pytest.mark.parametrize("file", sorted(FILES))
def test_lines_and_letters_of_every_dialect(file, tmp_path):
    dialect, source = FILES[file]
    path = tmp_path / file
    path.write_bytes(dialect.write(source))
    soup = READERS[dialect.ending](path, ReadOptions())
    wanted = dialect.kept(source)
    if dialect.mm_per_unit is None:
        assert soup.mm_per_unit is None
    else:
        assert soup.mm_per_unit == pytest.approx(dialect.mm_per_unit, rel=1e-12)
    assert soup.lines_coords.shape == wanted.lines.shape
    own, size = aligned(soup.lines_coords)
    lines, wanted_size = aligned(wanted.lines)
    # The file holds the whole sheet, even where it leaves some letters out.
    scale = size / wanted_size
    own = own / scale
    found = lengths(own, soup.lines_assignment)
    expected = lengths(lines, wanted.letters)
    assert found.keys() == expected.keys()
    for letter, length in expected.items():
        assert found[letter] == pytest.approx(length, rel=1e-6), letter
    first = ordered(own / wanted_size, soup.lines_assignment)
    second = ordered(lines / wanted_size, wanted.letters)
    np.testing.assert_allclose(first[0], second[0], atol=1e-6)
    assert first[1].tolist() == second[1].tolist()
    assert len(soup.elements) == soup.lines_element.max() + 1


@pytest.mark.parametrize("name", sorted(DIALECTS))
def test_the_comparison_would_see_a_mirror_image_and_swapped_letters(name):
    """Of the spiral, which every dialect is tried with."""
    source = BY_NAME["spiral"]
    lines, size = aligned(source.lines)
    straight = ordered(lines / size, source.letters)[0]
    mirrored = ordered(lines / size * [1, -1], source.letters)[0]
    assert np.abs(straight - mirrored).max() > 0.1
    kept = DIALECTS[name].kept(source)
    if {"M", "V"} <= set(kept.letters.tolist()):
        both = lengths(kept.lines, kept.letters)
        assert abs(both["M"] - both["V"]) > 1e-3 * both["M"]


def test_the_screen_of_oripa_is_the_sheet_from_above(tmp_path):
    """ORIPA's CP file (y downwards) and DXF file (y negated by ORIPA itself) show one drawing."""
    source = BY_NAME["crane"]
    soups = []
    for name in ("cp_oripa", "opx_oripa_2024", "dxf_oripa", "dxf_oriedita"):
        path = tmp_path / f"crane_{name}{DIALECTS[name].ending}"
        path.write_bytes(DIALECTS[name].write(source))
        soups.append(READERS[path.suffix](path, ReadOptions()))
    places = [ordered(aligned(s.lines_coords)[0], s.lines_assignment) for s in soups]
    sizes = [aligned(s.lines_coords)[1] for s in soups]
    for (lines, letters), size in zip(places[1:], sizes[1:], strict=True):
        np.testing.assert_allclose(lines / size, places[0][0] / sizes[0], atol=1e-9)
        assert letters.tolist() == places[0][1].tolist()
    # and of a line from the upper left corner of the screen, the end is at the upper left
    path = tmp_path / "corner.cp"
    path.write_text("1 -200 -200 -200 -100\n2 -200 -200 200 200\n")
    soup = read_cp(path, ReadOptions())
    assert soup.lines_coords[0].tolist() == [[-200, 200], [-200, 100]]
    assert soup.lines_assignment.tolist() == ["B", "M"]


def test_java_prints_doubles_so():
    assert java(9.094947017729283e-15) == "9.094947017729283E-15"
    assert java(2e-14) == "2.0E-14"
    assert java(-200.0) == "-200.0"
    assert java(-0.0) == "-0.0"
    assert java(12345678.0) == "1.2345678E7"


def read_text(tmp_path, text, ending=".cp", options=None):
    path = tmp_path / f"drawing{ending}"
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return READERS[ending](path, options or ReadOptions())


SQUARE = "1 0 0 1 0\n1 1 0 1 1\n1 1 1 0 1\n1 0 1 0 0\n"


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        (SQUARE + "2 0 0 1 1 0 0 1 1\n", r"line 5: 9 columns instead of 5"),
        (SQUARE + "2 0 0 1\n", r"line 5: 4 columns instead of 5"),
        (SQUARE + "\n2 0 0 NaN 1\n", r"line 6: 'NaN' is no finite number"),
        (SQUARE + "2 0 0 Infinity 1\n", r"line 5: 'Infinity' is no finite number"),
        (SQUARE + "2 0 0 1e400 1\n", r"line 5: a number is too large"),
        (SQUARE + "mountain 0 0 1 1\n", r"line 5: 'mountain' is no finite number"),
        ("Lorem ipsum dolor sit amet\n" + SQUARE, r"line 1: 'Lorem' is no finite number"),
        (SQUARE + "2.5 0 0 1 1\n", r"line 5: the type 2\.5 is none of 1 \(border\)"),
        ("# nothing\n", "it has no lines"),
        ("1 2 3\x00", "not a text file"),
        (" \n", "the file is empty"),
    ],
)
def test_cp_files_that_mean_nothing_clear_are_refused_with_the_line(text, wanted, tmp_path):
    with pytest.raises(InvalidFile, match=wanted):
        read_text(tmp_path, text)


def codes(soup):
    return [finding.code for finding in soup.findings]


def test_repairs_of_cp_files_are_reported(tmp_path):
    assert codes(read_text(tmp_path, SQUARE)) == []
    soup = read_text(tmp_path, "// of somebody\n" + SQUARE + "9 0 0 1 1\n0 0 1 1 0\n")
    assert codes(soup) == ["comment-lines", "line-type", "auxiliary-lines"]
    assert soup.lines_assignment.tolist() == ["B"] * 4 + ["F"] * 2
    assert "1 of type 9" in soup.findings[1].text
    assert soup.elements[4] == "line 6"
    assert codes(read_text(tmp_path, "2 0,5 0,5 1,5 2,5\n")) == ["decimal-commas"]
    assert read_text(tmp_path, "2 0,5 0,5 1,5 2,5\n").lines_coords.tolist() == [
        [[0.5, -0.5], [1.5, -2.5]]
    ]
    assert codes(read_text(tmp_path, SQUARE.replace(" ", ";"))) == ["separators"]
    assert codes(read_text(tmp_path, SQUARE.replace("\n", " "))) == ["one-line"]


def test_options_give_letters_of_auxiliary_lines(tmp_path):
    options = ReadOptions(colours={"auxiliary": "U", "border": "C"})
    soup = read_text(tmp_path, SQUARE + "4 0 0 1 1\n", options=options)
    assert soup.lines_assignment.tolist() == ["C"] * 4 + ["U"]


def test_line_numbers_count_blank_lines(tmp_path):
    soup = read_text(tmp_path, "\n\n" + SQUARE.replace("\n", "\n\n"))
    assert soup.elements == ("line 3", "line 5", "line 7", "line 9")


OPX = """<?xml version="1.0" encoding="UTF-8"?>
<java version="1.5.0_02" class="java.beans.XMLDecoder">
 <object class="oripa.DataSet">
  <void property="lines"><array class="oripa.OriLineProxy" length="2">
   <void index="0"><object class="oripa.OriLineProxy">
    <void property="x1"><double>4.0</double></void></object></void>
   <void index="1"><object class="oripa.OriLineProxy">
    <void property="type"><int>3</int></void>
    <void property="y1"><double>-2.5E0</double></void></object></void>
  </array></void>
  <void property="originalAuthorName"><string>A. Folder</string></void>
  <void property="title"><string>Frog &amp; tree</string></void>
 </object>
</java>
"""


def test_what_java_leaves_out_of_opx_is_zero(tmp_path):
    soup = read_text(tmp_path, OPX, ".opx")
    assert soup.lines_coords.tolist() == [[[0, 0], [4, 0]], [[0, 0], [0, 2.5]]]
    assert soup.lines_assignment.tolist() == ["F", "V"]
    assert soup.title == "Frog & tree, by A. Folder"


BOMB = """<?xml version="1.0"?>
<!DOCTYPE java [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;&a;&a;">]>
<java><object class="oripa.DataSet"><string>&b;</string></object></java>"""
EXTERNAL = """<?xml version="1.0"?>
<!DOCTYPE java [<!ENTITY x SYSTEM "file:///etc/passwd">]><java>&x;</java>"""
RUNS = """<?xml version="1.0"?><java><object class="java.lang.Runtime" method="getRuntime">
<void method="exec"><string>touch /tmp/x</string></void></object></java>"""


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        (BOMB, "document type or entities"),
        (EXTERNAL, "document type or entities"),
        (RUNS, "no data set of ORIPA"),
        (OPX[:400], "not an XML file"),
        (OPX.replace("<int>3</int>", "<int>3.5</int>"), r"line 1: type = '3\.5' is no whole"),
        (OPX.replace("4.0", "NaN"), r"line 0: x1 = 'NaN' is no finite"),
        (OPX.replace("-2.5E0", "1e999"), r"line 1 has a coordinate that is not finite"),
        (OPX.replace("UTF-8", "klingon"), "not an XML file"),
        ('<java><object class="oripa.DataSet"/></java>', "it has no lines"),
    ],
)
def test_opx_files_are_data_and_nothing_else(text, wanted, tmp_path):
    with pytest.raises(InvalidFile, match=wanted):
        read_text(tmp_path, text, ".opx")


def test_lines_that_an_opx_file_announces_and_does_not_have(tmp_path):
    soup = read_text(tmp_path, OPX.replace('length="2"', 'length="5"'), ".opx")
    assert codes(soup) == ["lines-missing", "auxiliary-lines"]


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ('{"lineSegments": [{"a": "0,0", "b": "1;1", "color": "RED_1"}]}', r"\[0\]\.b = '1;1'"),
        ('{"lineSegments": [{"a": "0,0", "b": "NaN,1", "color": "RED_1"}]}', r"\[0\]\.b"),
        ('{"lineSegments": [{"a": "0,0", "b": "1,1", "color": "RED"}]}', r"color = 'RED'"),
        ('{"lineSegments": [7]}', "is no object"),
        ('{"lineSegments": 7}', "no lineSegments"),
        ("{", "not a JSON file"),
        ("{" + '"a":[' * 100_000, "not a JSON file"),
        ("a text", "neither a JSON file of Oriedita nor"),
        ("<線分集合>\n色,1\n座標,1,2,3\n", "line 3: '1,2,3' are not four finite numbers"),
        ("<線分集合>\n色,rot\n", "line 2: 'rot' is no colour"),
    ],
)
def test_ori_files_that_cannot_be_read(text, wanted, tmp_path):
    with pytest.raises(InvalidFile, match=wanted):
        read_text(tmp_path, text, ".ori")


def test_what_takes_no_part_in_folding_is_counted(tmp_path):
    source = Source("x", np.array([[[0, 0], [1, 1.0]]]), np.array(["M"]))
    soup = read_text(tmp_path, DIALECTS["ori_oriedita_v1.1"].write(source), ".ori")
    assert codes(soup) == ["elements-skipped"]
    assert "1 line that takes no part in folding, 1 circle" in soup.findings[0].text
    assert soup.title == ""


@pytest.mark.parametrize("ending", [".cp", ".opx", ".ori", ".dxf"])
def test_files_over_the_bound_are_refused_unread(ending, tmp_path):
    path = tmp_path / f"large{ending}"
    with path.open("wb") as stream:
        stream.truncate(300_000_000)
    with pytest.raises(InvalidFile, match="300000000 bytes are over the bound of"):
        READERS[ending](path, ReadOptions())
    with pytest.raises(InvalidFile, match="cannot be read"):
        READERS[ending](tmp_path / f"none{ending}", ReadOptions())
    with pytest.raises(InvalidFile, match="not a file"):
        READERS[ending](tmp_path, ReadOptions())


# Bits, bytes and pieces that break formats of text.
PIECES = [b"", b"\0", b"\xff", b"-", b"1e999", b"NaN", b"<", b"{", b"[", b"\n", b"999999999999"]


def mutated(data: bytes, random: np.random.Generator) -> bytes:
    """The bytes with up to eight pieces replaced, moved, doubled or cut off, or lines changed."""
    if random.random() < 0.5:
        lines = data.split(b"\n")
        for _ in range(int(random.integers(1, 9))):
            one, other = random.integers(0, len(lines), 2)
            piece = PIECES[int(random.integers(0, len(PIECES)))]
            lines[one] = lines[other] if random.random() < 0.5 else piece
        return b"\n".join(lines)
    out = bytearray(data)
    for _ in range(int(random.integers(1, 9))):
        at = int(random.integers(0, len(out) + 1))
        end = min(len(out), at + int(random.choice([0, 1, 2, 8, 64, 512])))
        match int(random.integers(0, 5)):
            case 0:
                out[at:end] = PIECES[int(random.integers(0, len(PIECES)))]
            case 1 if at < len(out):
                out[at] = int(random.integers(0, 256))
            case 2:
                out[at:at] = out[at:end]
            case 3:
                to = int(random.integers(0, len(out) + 1))
                out[to:to] = out[at:end]
            case _:
                del out[at:end]
    return bytes(out)


@functools.cache
def small_files() -> dict[str, bytes]:
    small = BY_NAME["square_twist"]
    return {name: dialect.write(small) for name, dialect in DIALECTS.items()}


def mutations(ending: str, count: int, seed: int = 0):
    """Damaged files of one ending, from all dialects in turn."""
    random = np.random.default_rng(seed)
    names = [name for name, dialect in DIALECTS.items() if dialect.ending == ending]
    for number in range(count):
        yield mutated(small_files()[names[number % len(names)]], random)


@pytest.mark.parametrize("ending", sorted(READERS))
def test_damaged_files_are_read_or_refused(ending, tmp_path):
    path = tmp_path / f"damaged{ending}"
    read, refused = 0, []
    for data in mutations(ending, 100):
        path.write_bytes(data)
        try:
            soup = READERS[ending](path, ReadOptions())
        except InvalidFile as error:
            refused.append(str(error))
            continue
        read += 1
        assert np.isfinite(soup.lines_coords).all()
        assert len(soup.lines_coords) == len(soup.lines_assignment) > 0
    assert 0 < read < 100
    assert all(str(path) in text for text in refused)


IMPORTED = [
    name
    for name, (_, source) in FILES.items()
    if source.name != "spiral" and "fusion" not in name  # no sheets; all lines in one colour
]


@pytest.mark.parametrize("file", IMPORTED)
def test_patterns_through_the_importer(file, tmp_path):
    """Lengths by letter are those of the source; slits that a format calls borders are cuts."""
    dialect, source = FILES[file]
    path = tmp_path / file
    path.write_bytes(dialect.write(source))
    options = ReadOptions(inner_border="cut")
    pattern = pattern_of_lines(READERS[dialect.ending](path, options), options).pattern
    wanted = dialect.kept(source)
    lines = pattern.vertices_coords[pattern.edges_vertices]
    found = lengths(lines / aligned(lines)[1], pattern.edges_assignment)
    expected = lengths(wanted.lines / aligned(wanted.lines)[1], wanted.letters)
    for both in (found, expected):
        both["B"] += both.pop("C", 0.0)
    assert found == pytest.approx(expected, rel=1e-6)
