"""Assembly guides: read back as PDF, measured on paper, and drawn where the seams are."""

import io
import re
from collections import Counter
from dataclasses import replace
from functools import cache

import numpy as np
import pypdfium2
import pytest
from click.testing import CliRunner
from flat_patterns import fan, grid, strips, triangles, turned_strip
from helpers import PATTERNS, TEMPLATES
from hypothesis import given
from hypothesis import strategies as st
from pypdf import PdfReader
from shared_cases import shared_case

from fab import read_pattern
from fab.cli.group import main
from fab.errors import InvalidJob
from fab.jobs.assembly_files import guide_of
from fab.jobs.file_names import SHEETS, left_over
from fab.jobs.job import parse_job
from fab.jobs.job_files import make
from fab.jobs.sheet_files import fabricate
from fab.pattern.crease_pattern import scaled
from fab.sheets.cut_pieces import PatternCopies
from fab.sheets.cutter_settings import CutterSettings
from fab.sheets.sheet_drawings import sheet_drawings
from fab.viewing.assembly.piece_colours import piece_colours
from fab.viewing.assembly.steps import numbers_text
from fab.viewing.drawing import CREASE_INK
from fab.viewing.leaflet import Heading, Row, Step, Table
from fab.viewing.leaflet_pdf import leaflet_pdf_bytes
from fab.viewing.sketch import Area, Image, Lines, Words

STOCK = {"material": "card_300gsm", "machine": "co2_40w_300x200"}
MM = 25.4 / 72
# What A4 and US letter have in common, mm.
COMMON = (210.0, 279.4)


def request_of(**keys):
    return CutterSettings(**{**STOCK, **keys}).request([], page=False)


def guided(*patterns, name="model", **keys):
    """The sheets of some patterns, and the guide to them."""
    request = request_of(**keys)
    wanted = [PatternCopies(f"{name}{number or ''}", each) for number, each in enumerate(patterns)]
    made = sheet_drawings(wanted, name, request)
    return made, guide_of(wanted, name, request, made, made_by="quadfold fabricate")


def sized(name, width_mm):
    pattern, _ = read_pattern(PATTERNS / f"{name}.fold")
    return scaled(pattern, width_mm=width_mm)


def box_net():
    pattern, _ = read_pattern(shared_case("boxnet.fold"))
    return scaled(pattern, width_mm=300.0)


def texts(leaflet):
    pages = PdfReader(io.BytesIO(leaflet_pdf_bytes(leaflet))).pages
    return [page.extract_text() for page in pages]


def flat_map(leaflet):
    """The sketch of the flat pattern."""
    blocks = leaflet.blocks
    at = next(
        k for k, b in enumerate(blocks) if isinstance(b, Heading) and b.text == "Flat pattern"
    )
    assert isinstance(blocks[at + 1], Row)
    return blocks[at + 1].sketches[0]


def seam_numbers(sketch):
    return [mark for mark in sketch.marks if isinstance(mark, Words) and mark.text.isdigit()]


def scale_of(sketch):
    """Paper over pattern, of a caption such as "scale 1 : 2.5"."""
    over, under = re.search(r"scale (\S+) : (\S+?)\.(\s|$)", sketch.caption).groups()[:2]
    return float(over) / float(under)


MODELS = {
    "one piece": lambda: grid(3, 2, 40.0),
    "in pieces": lambda: sized("miura", 520.0),
    "over itself": lambda: turned_strip(24, 1.3),
    "closing": box_net,
    "any letters": lambda: triangles(3, count=14, size=330.0),
    "holes": lambda: grid(4, 4, 40.0, without=[(1, 1)], cuts=[(15, 16)]),
}


@cache
def model(kind):
    """A pattern, its sheets, the guide and its pages."""
    pattern = MODELS[kind]()
    made, guide = guided(pattern)
    return pattern, made, guide, leaflet_pdf_bytes(guide)


@pytest.mark.parametrize("kind", sorted(MODELS))
def test_every_seam_and_letter_is_in_the_guide_as_the_report_has_it(kind):
    _, made, guide, data = model(kind)
    rows = made.report["glue_up"]
    tables = [block for block in guide.blocks if isinstance(block, Table)]
    listed = [row for table in tables for row in table.rows]
    names = {piece["name"] for piece in made.report["pieces"]}
    assert [int(row[0]) for row in listed] == [row["label"] for row in rows]
    for row, seam in zip(listed, rows, strict=True):
        assert row[1] == f"{seam['length_mm']:.1f}"
        assert set(row[3].split(" - ")) == set(seam["pieces"])
        held = "tape" if seam["tab"] is None else f"tab of {seam['pieces'][seam['tab']]}"
        assert row[4] == held
    # read by a program that is not ours: all of the table, and the letters of all pieces
    read = "\n".join(page.extract_text() for page in PdfReader(io.BytesIO(data)).pages)
    for seam in rows:
        assert re.search(rf"(^|\s){seam['label']}\s", read)
    if len(names) > 1:
        assert names <= set(re.findall(r"\b[A-Z]{1,2}\b", read))
    glued = Counter()
    for step in (block for block in guide.blocks if isinstance(block, Step)):
        for first, _, last in re.findall(r"[Ss]eams? (\d+)( to (\d+))?", step.text):
            glued.update(range(int(first), int(last or first) + 1))
    assert set(glued) <= {row["label"] for row in rows}


@pytest.mark.parametrize("kind", sorted(MODELS))
def test_the_flat_map_has_each_number_at_its_seam_and_the_pattern_at_its_scale(kind):
    pattern, made, guide, _ = model(kind)
    sketch = flat_map(guide)
    scale = scale_of(sketch)
    assert ("lie over each other" in sketch.caption) == (kind == "over itself")
    seams = made.cut[0].pieces.seams
    sides = [(seam, edge) for seam in seams for edge in dict.fromkeys(seam.edges)]
    numbers = seam_numbers(sketch)
    assert Counter(w.text for w in numbers) == Counter(str(seam.label) for seam, _ in sides)
    areas = [mark for mark in sketch.marks if isinstance(mark, Area)]
    outline = np.concatenate([ring for area in areas for ring in area.rings])
    corner = outline.min(axis=0) - pattern.vertices_coords.min(axis=0) * scale
    assert np.ptp(outline, axis=0) == pytest.approx(
        np.ptp(pattern.vertices_coords, axis=0) * scale, abs=0.05
    )
    for mark, (seam, edge) in zip(numbers, sides, strict=True):
        assert mark.text == str(seam.label)
        ends = pattern.vertices_coords[pattern.edges_vertices[edge]]
        there = ends.mean(axis=0) * scale + corner
        beside = 0.7 * mark.size_mm if pattern.edges_faces[edge, 1] < 0 else 0.05
        assert np.hypot(*(np.array(mark.at) - there)) <= beside
    cut = {edge for seam in seams for edge in seam.edges}
    for letter, colour in (("M", CREASE_INK["M"]), ("V", CREASE_INK["V"])):
        within = [e for e in np.flatnonzero(pattern.edges_assignment == letter) if e not in cut]
        lines = [m for m in sketch.marks if isinstance(m, Lines) and m.colour == colour]
        assert sum(len(mark.segments) for mark in lines) == len(within)
        assert all(mark.dashes for mark in lines)  # told apart without colours
    styles = {m.colour: m.dashes for m in sketch.marks if isinstance(m, Lines)}
    if CREASE_INK["M"] in styles and CREASE_INK["V"] in styles:
        assert len(styles[CREASE_INK["M"]]) != len(styles[CREASE_INK["V"]])


@pytest.mark.parametrize("kind", sorted(MODELS))
def test_nothing_is_drawn_outside_of_what_a4_and_letter_have_in_common(kind):
    data = model(kind)[-1]
    document = pypdfium2.PdfDocument(data)
    inside = 10.0 / MM
    for page in document:
        width, height = page.get_size()
        assert (width * MM, height * MM) == pytest.approx(COMMON, abs=0.01)
        for thing in page.get_objects():
            left, low, right, top = thing.get_bounds()
            assert left >= inside - 0.5
            assert low >= inside - 0.5
            assert right <= width - inside + 0.5
            assert top <= height - inside + 0.5
    pages = PdfReader(io.BytesIO(data)).pages
    for page in pages:  # each has the line by which a print is checked
        drawn = page.get_contents().get_data().decode("latin-1")
        lines = re.findall(r"([\d.]+) ([\d.]+) m ([\d.]+) ([\d.]+) l", drawn)
        ends = np.array(lines, float) * MM
        level = (ends[:, 1] == ends[:, 3]) & (ends[:, 1] < 20.0)
        assert np.abs(ends[level, 2] - ends[level, 0] - 50.0).min() < 0.01
    fonts = [
        font
        for page in pages
        for font in (each.get_object() for each in page["/Resources"]["/Font"].values())
    ]
    assert fonts
    assert all("/FontFile2" in font["/FontDescriptor"] for font in fonts)


def test_one_piece_without_seams_takes_a_page_and_all_pages_are_numbered():
    for pattern in (grid(3, 2, 40.0), sized("yoshimura", 200.0), fan(7, 30)):
        _, guide = guided(pattern)
        assert len(texts(guide)) == 1
    pages = texts(model("in pieces")[2])
    assert len(pages) > 1
    for number, page in enumerate(pages, 1):
        assert f"page {number} of {len(pages)}" in page


def test_the_same_pages_are_the_same_bytes_without_dates():
    first = model("closing")[-1]
    assert leaflet_pdf_bytes(guided(MODELS["closing"]())[1]) == first
    document = PdfReader(io.BytesIO(first)).metadata
    assert not {"/CreationDate", "/ModDate"} & set(document)
    # whatever else a program has made with the library before
    from reportlab.pdfgen.canvas import Canvas

    other = Canvas(io.BytesIO())
    other.drawString(10, 10, "other")
    other.save()
    assert leaflet_pdf_bytes(model("closing")[2]) == first


@pytest.mark.parametrize(
    "name",
    [
        "fälten",
        "<b>&amp;</b> %s \\ (x",
        "a\x00b\x1b[31m\n\r\u202ec",
        "\udcff" * 3,
        "折り紙 🦢",
        "w" * 300,
        "(" * 40,
    ],
)
def test_any_name_is_written_as_it_is_and_none_is_obeyed(name):
    guide = replace(model("one piece")[2], title=f"{name}: assembly", made_by=name)
    data = leaflet_pdf_bytes(guide)
    (page,) = PdfReader(io.BytesIO(data)).pages
    text = page.extract_text()
    shown = re.sub(r"[\x00-\x1f\u202e\udcff]", "_", name)
    shown = re.sub(r"[^\x00-\u04ff]", "□", shown)
    assert shown[:60].replace(" ", "") in re.sub(r"\s", "", text)
    assert leaflet_pdf_bytes(guide) == data


def test_several_models_have_their_own_parts_and_colours_of_their_own():
    made, guide = guided(grid(6, 2, 60.0), fan(7, 60), copies=2)
    assert [cut.pieces.pieces[0].name for cut in made.cut] != ["A", "A"]
    headings = [block.text for block in guide.blocks if isinstance(block, Heading)]
    assert {"model", "model1"} <= set(headings)
    assert headings.count("Flat pattern") == 2
    tables = [block for block in guide.blocks if isinstance(block, Table)]
    listed = [int(row[0]) for table in tables for row in table.rows]
    assert listed == [row["label"] for row in made.report["glue_up"]]
    fills = [
        {mark.fill for mark in row.sketches[0].marks if isinstance(mark, Area)}
        for row, before in zip(guide.blocks[1:], guide.blocks, strict=False)
        if isinstance(before, Heading) and before.text == "Flat pattern"
    ]
    assert not fills[0] & fills[1]
    assert "for 2 copies" in "".join(b.text for b in guide.blocks if isinstance(b, Step))


def test_sheets_that_lie_alike_are_shown_once():
    made, guide = guided(grid(3, 2, 60.0), copies=7)
    maps = [
        sketch
        for block in guide.blocks
        if isinstance(block, Row)
        for sketch in block.sketches
        if sketch.caption.startswith("Sheet")
    ]
    told = Counter()
    for sketch in maps:
        numbers = re.match(r"Sheets? ([\d, to]+):", sketch.caption).group(1)
        first, _, last = numbers.partition(" to ")
        each = range(int(first), int(last) + 1) if last else map(int, numbers.split(", "))
        told.update(each)
    assert told == Counter(range(1, len(made.report["sheets"]) + 1))
    assert len(maps) < len(made.report["sheets"])


@pytest.mark.parametrize(
    ("tabs", "done", "listed"),
    [
        ("one side", r"Glue the tabs? of [A-D] under [A-D]", "tab of [A-D]"),
        ("both sides", r"glue them onto each other( at [\d, and to]+)?\.", "two tabs"),
        ("slots", r"Put the tongues? of [A-D] into the slots? of [A-D]", "tongue of [A-D]"),
        ("stitches", r"Sew (them|it|[\d, and to]+) through the holes", r"\d+ stitch(es)?"),
        ("none", r"Tape (them|it|[\d, and to]+) on the lower side", "tape"),
    ],
)
def test_steps_say_what_holds_each_seam(tabs, done, listed):
    made, guide = guided(grid(6, 2, 60.0), tabs=tabs)
    steps = [block for block in guide.blocks if isinstance(block, Step) and "Join" in block.title]
    assert steps
    assert all(re.search(done, step.text) for step in steps), [step.text for step in steps]
    (table,) = [block for block in guide.blocks if isinstance(block, Table)]
    assert any(re.fullmatch(listed, row[4]) for row in table.rows)
    assert all(re.fullmatch(f"{listed}|tape", row[4]) for row in table.rows)
    for row, seam in zip(table.rows, made.report["glue_up"], strict=True):
        if seam.get("stitches"):
            assert row[4].startswith(f"{seam['stitches']} ")


@pytest.mark.parametrize(
    ("kerf", "told"),
    [("0.15", "kerf 0.15 mm"), ("[0.1, 0.2]", "kerf 0.1 x 0.2 mm"), ("0.0", "no kerf")],
)
def test_the_head_says_what_the_sheets_are_made_for(tmp_path, kerf, told):
    shipped = (TEMPLATES / "machines" / "co2_40w_300x200.toml").read_text()
    own = re.sub(r"kerf_mm = [\d.]+", f"kerf_mm = {kerf}", shipped)
    (tmp_path / "own.toml").write_text(own)
    made, guide = guided(grid(3, 2, 40.0), machine=str(tmp_path / "own.toml"))
    facts = dict(guide.blocks[0].rows)
    assert facts["Settings"].partition(",")[0] == told
    assert facts["Material"] == "Card, 300 g/m2, 0.36 mm"
    minutes = sum(sheet["minutes"] for sheet in made.report["sheets"])
    assert facts["Cutting time"] == f"about {minutes:.1f} min in all"
    grams = 0.36 * 833 * 0.12 * 0.08  # of 120 x 80 mm, more or less a kerf
    assert float(facts["Mass"].removesuffix(" g")) == pytest.approx(grams, rel=0.01)
    assert facts["Sheets"] == f"1 of 300 x 200 mm, {0.36 * 833 * 0.06:.3g} g each"


def sheet_box(guide):
    """The box of all pieces on the first sheet, in shares of the paper that it takes."""
    sketch = next(
        sketch
        for block in guide.blocks
        if isinstance(block, Row)
        for sketch in block.sketches
        if sketch.caption.startswith("Sheet 1")
    )
    bed, *pieces = [mark for mark in sketch.marks if isinstance(mark, Area)]
    (frame,) = bed.rings
    rings = np.concatenate([ring for area in pieces for ring in area.rings])
    low, high = frame.min(axis=0), frame.max(axis=0)
    return ((np.array([rings.min(axis=0), rings.max(axis=0)]) - low) / (high - low)).round(4)


def test_sheets_are_shown_as_they_are_cut_and_the_first_step_says_what_is_done_then():
    pattern = grid(6, 2, 60.0)
    wishes = {"plain": {}, "mirror": {"mirror": True}, "bridges": {"bridges": 3}}
    guides = {key: guided(pattern, **keys)[1] for key, keys in wishes.items()}
    first = {
        key: next(block.text for block in guide.blocks if isinstance(block, Step))
        for key, guide in guides.items()
    }
    assert "letters up" in first["plain"]
    assert "turn the pieces over" in first["mirror"]
    assert "by 3 bridges: cut through them" in first["bridges"]
    (left, low), (right, high) = sheet_box(guides["plain"])
    mirrored = sheet_box(guides["mirror"])
    assert mirrored == pytest.approx(np.array([[1 - right, low], [1 - left, high]]), abs=2e-4)
    made, guide = guided(pattern, two_sided=True)
    turn = next(block.text for block in guide.blocks if isinstance(block, Step))
    assert made.report["sheets"][0]["turn"] in turn


def test_rims_that_meet_are_numbered_on_both_sheets():
    made, guide = guided(strips(0.05, 2, 3), machine="co2_60w_600x400")
    (cut,) = made.cut
    assert cut.meeting is not None
    count = len(cut.meeting.vertices)
    words = Counter(m.text for m in flat_map(guide).marks if isinstance(m, Words))
    assert [words[str(n)] for n in range(1, count + 1)] == [2] * count
    steps = [block for block in guide.blocks if isinstance(block, Step)]
    assert f"{count} numbered points" in steps[-1].text


def test_forms_that_only_angles_give_are_seen_from_two_sides():
    _, guide = guided(box_net(), machine="co2_60w_600x400")
    sketches = [s for block in guide.blocks if isinstance(block, Row) for s in block.sketches]
    forms = [s for s in sketches if any(isinstance(mark, Image) for mark in s.marks)]
    assert len(forms) == 2
    front, behind = ({mark.text for mark in seam_numbers(form)} for form in forms)
    assert front | behind == {str(n) for n in range(1, 8)}  # each seam of a box is seen from one
    for form in forms:
        width, height = form.size_mm
        for mark in form.marks:
            if isinstance(mark, Words):
                assert 0 <= mark.at[0] <= width
                assert 0 <= mark.at[1] <= height


@given(st.sets(st.integers(1, 60), min_size=1))
def test_numbers_in_words_say_all_of_them(numbers):
    told = set()
    for part in re.split(r", | and ", numbers_text(numbers)):
        first, _, last = part.partition(" to ")
        told |= set(range(int(first), int(last or first) + 1))
    assert told == numbers


def test_black_letters_are_read_on_every_colour_and_neighbours_differ_in_grey():
    colours = piece_colours(200)
    linear = np.where(colours <= 0.04045, colours / 12.92, ((colours + 0.055) / 1.055) ** 2.4)
    luminance = linear @ [0.2126, 0.7152, 0.0722]
    assert ((luminance + 0.05) / 0.05).min() > 7.0  # AAA of WCAG
    grey = luminance ** (1 / 2.2)
    assert np.abs(np.diff(grey)).min() > 0.04


def test_the_command_makes_it_where_it_is_asked_for_or_nothing_is(tmp_path):
    file = PATTERNS / "miura.fold"
    words = ["fabricate", str(file), "--width-mm", "200", "--material", STOCK["material"]]
    words += ["--machine", STOCK["machine"], "--quiet", "--out"]
    for only, there in ((None, True), ("assembly", True), ("dxf,svg", False)):
        out = tmp_path / str(only)
        result = CliRunner().invoke(
            main, [*words, str(out), *(() if only is None else ("--only", only))]
        )
        assert result.exit_code == 0, result.output
        assert (out / "miura_assembly.pdf").is_file() is there
        assert (out / "miura_sheets.html").is_file() is (only is None)
    page = (tmp_path / "None" / "miura_sheets.html").read_text()
    assert '<h2 id="assembly">Assembly</h2>' in page
    # what an earlier run left behind is named
    left = left_over([], "miura", [SHEETS], tmp_path / "None")
    assert tmp_path / "None" / "miura_assembly.pdf" in left


def test_a_job_with_a_cutter_makes_it_and_others_cannot():
    job = {"name": "m", "design": {"kind": "miura"}, "sheet": {"width_mm": 250.0}}
    with_cutter = parse_job({**job, "cutter": STOCK})
    assert "assembly" in with_cutter.wanted
    assert "assembly" not in parse_job(job).wanted
    assert parse_job({**job, "cutter": STOCK, "outputs": ["dxf"]}).wanted == ["dxf"]
    made = make(with_cutter, ["assembly"])
    assert next(iter(made.files)) == "m_assembly.pdf"
    pages = PdfReader(io.BytesIO(made.files["m_assembly.pdf"])).pages
    read = "".join(page.extract_text() for page in pages)
    assert "Faces stay flat on the way: all creases move together" in re.sub(r"\s+", " ", read)
    with pytest.raises(InvalidJob, match="assembly: the job names no machine"):
        make(parse_job(job), ["assembly"])


def test_pages_hold_the_guide_too():
    request = CutterSettings(**STOCK).request([])
    made = fabricate(grid(6, 2, 60.0), "m", request)
    page = made.files["m_sheets.html"].decode()
    section = page.split('<h2 id="assembly">')[1].split("</section>")[0]
    for row in made.report["glue_up"]:
        assert f"<td>{row['label']}</td>" in section
        assert f">{row['label']}</text>" in section
