"""All commands read crease patterns of all formats, with the same options and the same refusals."""

import gzip
import json
import re
from collections import Counter

import ezdxf
import numpy as np
import pytest
from click.testing import CliRunner
from folded_strips import strip as folded_strip
from formats.drawing_dialects import DIALECTS, Source
from helpers import PATTERNS

from fab.cli.group import main
from fab.formats.fold.reader import read_fold
from fab.formats.fold.writer import fold_bytes
from fab.formats.reading import READ
from fab.pattern.kinematics import vertices_closure_rad

# A strip of three panels, folded to a step: a mountain at x = 30 and a valley at x = 70.
FLAT = [[x, y, 0] for x in (0, 30, 70, 100) for y in (0, 60)]
STEP = [[x, y, z] for x, z in ((0, 0), (30, 0), (30, -40), (60, -40)) for y in (0, 60)]
SIDES = [(0, 1), (0, 2), (1, 3), (2, 4), (3, 5), (4, 6), (5, 7), (6, 7)]
CREASES = [(2, 3, "M", -90), (4, 5, "V", 90)]
COUNTS = {"B": 8, "M": 1, "V": 1}
SHEET = ["--material", "card_300gsm", "--machine", "co2_60w_600x400", "--only", "dxf"]
THICK = ["--only", "stl", "--set", "panels.thickness_mm=0.8"]
# Formats, and what they do not say of the strip.
FORMATS = ["fold", "svg", "svgz", "dxf", "cp", "opx", "ori", "orh", "obj"]
NO_ANGLES = {"dxf", "cp", "opx", "ori", "orh"}
DIALECT = {"opx": "opx_oripa_2024", "ori": "ori_oriedita_v1.1", "orh": "orh_orihime"}


def run(*words):
    return CliRunner().invoke(main, [str(word) for word in words])


def names_in(folder):
    return sorted(path.name for path in folder.iterdir())


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def strip():
    return {
        "file_spec": 1.2,
        "file_classes": ["singleModel"],
        "frame_classes": ["creasePattern"],
        "frame_unit": "mm",
        "vertices_coords": FLAT,
        "edges_vertices": [*map(list, SIDES), *([a, b] for a, b, _, _ in CREASES)],
        "edges_assignment": ["B"] * len(SIDES) + [letter for _, _, letter, _ in CREASES],
        "edges_foldAngle": [0] * len(SIDES) + [angle for _, _, _, angle in CREASES],
        "faces_vertices": [[2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1] for i in range(3)],
        "file_frames": [
            {
                "frame_classes": ["foldedForm"],
                "frame_parent": 0,
                "frame_inherit": True,
                "frame_unit": "mm",
                "vertices_coords": STEP,
            }
        ],
    }


def written(folder, ending):
    """The strip as a file of a format, 100 mm or units long."""
    source = folder / "strip.fold"
    source.write_text(json.dumps(strip()))
    if ending == "fold":
        return source
    if ending in DIALECT:
        ends = np.array(FLAT, float)[:, :2]
        pairs = [*SIDES, *((a, b) for a, b, _, _ in CREASES)]
        letters = np.array(["B"] * len(SIDES) + [letter for _, _, letter, _ in CREASES])
        drawing = Source("strip", ends[np.array(pairs)], letters)
        path = folder / f"strip.{ending}"
        path.write_bytes(DIALECTS[DIALECT[ending]].write(drawing))
    elif ending == "svgz":
        path = folder / "strip.svgz"
        path.write_bytes(gzip.compress(written(folder, "svg").read_bytes()))
        return path
    else:
        path = folder / f"strip.{ending}"
        result = run("convert", source, path)
        assert result.exit_code == 0, result.output
        path = folder / "strip_flat.obj" if ending == "obj" else path
    source.unlink()
    return path


def options_for(ending):
    return ["--width-mm", "100", *(["--fold-deg", "90"] if ending in NO_ANGLES else [])]


def converted(folder, path, *words):
    """What `convert` makes of a file, and its output."""
    result = run("convert", path, folder / "converted.fold", *words)
    assert result.exit_code == 0, result.output
    return read_fold(folder / "converted.fold").pattern, result.output


def counts_of(pattern):
    return {letter: count for letter, count in pattern.counts().items() if count}


def refused(folder, *words):
    """The message of a refusal, after which nothing was written."""
    before = {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}
    result = run(*words)
    assert result.exit_code == 2, result.output
    assert "Traceback" not in result.output
    after = {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}
    assert after == before
    return result.output


@pytest.mark.parametrize("ending", FORMATS)
def test_colours_without_effect_are_told(here, ending):
    _, output = converted(here, written(here, ending), "--colours", "#ff8800=mountain,lost=cut")
    assert "colours-unused: --colours: no line" in output
    assert "'#ff8800', 'lost'" in output


def test_colours_that_one_of_several_files_has_are_not_unused(here):
    slit = '<path d="M20 20H40" stroke="magenta"/>'
    svg(here, RIM, CREASE.format(colour="red"), slit).rename("slit.svg")
    svg(here, RIM, CREASE.format(colour="red")).rename("plain.svg")
    words = ["fabricate", *SHEET, "--dry-run", "--only", "dxf"]
    for files in (["slit.svg", "plain.svg"], ["plain.svg", "slit.svg"]):
        output = run(*words, *files, "--colours", "magenta=cut").output
        assert "colours-unused" not in output
        output = run(*words, *files, "--colours", "magenta=cut,lost=cut").output
        assert "no line of the file has the colour, layer or name 'lost'." in output
    assert "colours-unused" in run(*words, "plain.svg", "--colours", "magenta=cut").output


def test_all_formats_that_are_read_are_tried():
    assert {f".{ending}" for ending in FORMATS} == set(READ)


@pytest.mark.parametrize("ending", FORMATS)
def test_convert_understands_every_format_alike(here, ending):
    pattern, _ = converted(here, written(here, ending), *options_for(ending))
    # OBJ and FOLD files have the vertices that they list; drawings have those of their lines
    counts = counts_of(pattern)
    assert {letter: counts[letter] for letter in "MV"} == {"M": 1, "V": 1}
    ends = pattern.vertices_coords[pattern.edges_vertices]
    length = np.hypot(*(ends[:, 1] - ends[:, 0]).T)
    assert length[pattern.edges_assignment == "B"].sum() == pytest.approx(320, rel=1e-9)
    for _, _, letter, angle in CREASES:
        (row,) = np.flatnonzero(pattern.edges_assignment == letter)
        assert pattern.edges_foldAngle[row] == pytest.approx(angle)
        assert ends[row, :, 0] == pytest.approx([30, 30] if letter == "M" else [70, 70])
        assert sorted(ends[row, :, 1]) == pytest.approx([0, 60], abs=1e-9)


@pytest.mark.parametrize("ending", FORMATS)
def test_fabricate_cuts_every_format_alike(here, ending):
    result = run("fabricate", written(here, ending), *SHEET, *options_for(ending), "--out", "out")
    assert result.exit_code == 0, result.output
    assert "1 piece, 0 seams, 1 sheet" in result.output
    (drawing,) = (here / "out").glob("*_1.dxf")
    layers = Counter(entity.dxf.layer for entity in ezdxf.readfile(drawing).modelspace())
    reference = here / "reference"
    reference.mkdir()
    again = run("fabricate", written(here, "fold"), *SHEET, "--out", reference)
    assert again.exit_code == 0, again.output
    wanted = ezdxf.readfile(reference / "strip_1.dxf").modelspace()
    assert layers == Counter(entity.dxf.layer for entity in wanted)


@pytest.mark.parametrize("ending", FORMATS)
def test_simulate_folds_every_format_alike(here, ending):
    file = written(here, ending)
    result = run("simulate", file, *options_for(ending), "--only", "fold", "--out", "out")
    assert result.exit_code == 0, result.output
    assert "folds to its target" in result.output
    (folded,) = (here / "out").glob("*_folding.fold")
    shape = read_fold(folded).pattern.folded_coords
    # a mountain and a valley of 90 degrees: the outer panels are parallel, 40 mm apart
    assert np.ptp(shape, axis=0) == pytest.approx(
        np.ptp(np.array(STEP), axis=0), abs=1e-5
    ) or sorted(np.linalg.norm(shape - shape[0], axis=1)) == pytest.approx(
        sorted(np.linalg.norm(np.array(STEP) - STEP[0], axis=1)), abs=1e-5
    )


@pytest.mark.parametrize("ending", FORMATS)
def test_thicken_makes_the_same_panels_of_every_format(here, ending):
    file = written(here, ending)
    result = run("thicken", file, *THICK, *options_for(ending), "--out", "out", "--dry-run")
    assert result.exit_code == 0, result.output
    assert "3 panels, 2 hinges, 100 x 60 x 0.8 mm" in result.output


@pytest.mark.parametrize("ending", FORMATS)
def test_check_measures_what_has_a_folded_form(here, ending):
    result = run("check", written(here, ending), *options_for(ending))
    assert result.exit_code == 0, result.output
    assert "M:1 V:1 F:0 B:" in result.stdout
    assert "flat faces          folds rigidly" in result.stdout
    has_form = ending in ("fold", "obj")
    assert ("planarity" in result.stdout) == has_form
    assert ("folded form         none to measure" in result.stdout) == (not has_form)
    assert "quadfold:" not in result.stderr


@pytest.mark.parametrize(("letters", "code"), [("VM", 0), ("VV", 1)])
def test_check_ends_with_1_where_a_sheet_without_a_folded_form_is_at_fault(here, letters, code):
    """Of flaps of 30 mm on a face of 10 mm, each covers the crease of the other."""
    (here / "flaps.fold").write_bytes(fold_bytes(folded_strip([30, 10, 30], letters), "flaps"))
    result = run("check", "flaps.fold")
    assert result.exit_code == code, result.output
    assert ("error: cannot-lie-flat" in result.stderr) == (code == 1)
    folding = "none to measure; the FOLD file that `simulate` writes has one"
    assert folding in result.stdout
    run("simulate", "flaps.fold", "--only", "fold", "--out", "out")
    again = run("check", "out/flaps_folding.fold")
    assert "planarity" in again.stdout
    assert "none to measure" not in again.output


@pytest.mark.parametrize("ending", FORMATS)
def test_pictures_show_what_was_understood(here, ending):
    result = run("convert", written(here, ending), "strip.png", *options_for(ending))
    assert result.exit_code == 0, result.output
    data = (here / "strip.png").read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    assert tuple(int.from_bytes(data[at : at + 4], "big") for at in (16, 20)) == (1600, 900)


COMMANDS = {
    "convert": lambda file: ["convert", file, "made.fold"],
    "fabricate": lambda file: ["fabricate", file, *SHEET],
    "simulate": lambda file: ["simulate", file, "--only", "fold"],
    "thicken": lambda file: ["thicken", file, *THICK],
    "check": lambda file: ["check", file],
}
OPTIONS = [
    *("--strict", "--mm-per-unit", "--dpi", "--merge-mm", "--colours", "--border", "--fold-deg"),
    *("--inner-border", "--rigid", "--assign", "--frame", "--width-mm", "--scale"),
]


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_the_options_of_reading(command):
    text = run(command, "--help").output
    assert set(OPTIONS) <= set(re.findall(r"--[a-z-]+", text))


def test_options_that_messages_name_exist():
    """Every option that a message of a reader names is one of the commands that read."""
    from helpers import ROOT

    named = set()
    for path in (ROOT / "fab" / "formats").rglob("*.py"):
        named |= set(re.findall(r"(?<![\w-])--[a-z][a-z-]+", path.read_text(encoding="utf-8")))
    assert named <= set(OPTIONS)
    assert len(named) > 8


# --- each option ---

HEAD = '<svg xmlns="http://www.w3.org/2000/svg" {size} viewBox="0 0 100 60">'
RIM = '<rect width="100" height="60" fill="none" stroke="black"/>'
CREASE = '<line x1="40" y1="0" x2="40" y2="60" stroke="{colour}"/>'


def svg(folder, *inside, size='width="100mm" height="60mm"'):
    path = folder / "drawing.svg"
    path.write_text(HEAD.format(size=size) + "".join(inside) + "</svg>")
    return path


def box_of(pattern):
    return np.ptp(pattern.vertices_coords, axis=0).tolist()


def test_strict_refuses_repairs_and_no_facts(here):
    words = ["--fold-deg", "90", "--strict"]
    joined = here / "joined.cp"
    joined.write_text(
        "# a comment\n1 0 0 40 0\n1 40 0 100 0\n1 100 0 100 60\n1 100 60 40 60\n1 40 60 0 60\n"
        "1 0 60 0 0\n2 40 0 40 60\n4 40 0 100 60\n4 40 0 0 60\n"
    )
    pattern, output = converted(here, joined, *words)
    assert counts_of(pattern) == {"B": 6, "M": 1, "F": 2}
    assert {"comment-lines", "auxiliary-lines", "unit-unknown"} <= set(
        re.findall(r"note: ([a-z-]+):", output)
    )
    loose = here / "loose.cp"
    loose.write_text(joined.read_text().replace("2 40 0 40 60", "2 40 0 40 59.99"))
    assert "ends-joined" in converted(here, loose, "--fold-deg", "90")[1]
    for command in COMMANDS.values():
        output = refused(here, *command(loose), *words)
        assert "joined to others up to 0.01 mm away" in output
        assert "--strict refuses this" in output


def test_units_of_drawings_without_one(here):
    drawing = svg(here, RIM, CREASE.format(colour="red"), size="")
    pattern, output = converted(here, drawing)
    assert box_of(pattern) == pytest.approx([100 * 25.4 / 96, 60 * 25.4 / 96])
    assert "note: unit-unknown" in output
    for words, width in (
        (["--mm-per-unit", "2"], 200),
        (["--dpi", "72"], 100 * 25.4 / 72),
        (["--width-mm", "50"], 50),
        (["--mm-per-unit", "2", "--scale", "0.1"], 20),
    ):
        pattern, output = converted(here, drawing, *words)
        assert box_of(pattern) == pytest.approx([width, 0.6 * width])
        assert ("unit-unknown" in output) == (words[0] == "--width-mm")
    for words, done in (
        (["--width-mm", "50"], "The longer side of the sheet was then made 50 mm long"),
        (["--scale", "2"], "The sheet was then made 2 times as large"),
    ):
        _, output = converted(here, drawing, *words)
        note = next(line for line in output.splitlines() if "unit-unknown" in line)
        assert f"0.264583 mm. {done}, as asked for." in note
        assert "Give" not in note
    output = refused(here, "convert", drawing, "a.fold", "--mm-per-unit", "2", "--dpi", "72")
    assert "--mm-per-unit 2 and --dpi 72: give one of them" in output
    for words in (["--mm-per-unit", "0"], ["--dpi", "-1"], ["--mm-per-unit", "nan"]):
        assert "must be finite and greater than 0" in refused(
            here, "convert", drawing, "a.fold", *words
        )


@pytest.mark.parametrize("ending", ["svg", "dxf", "fold"])
def test_a_unit_of_the_file_comes_first_and_says_so(here, ending):
    pattern, output = converted(here, written(here, ending), "--mm-per-unit", "25.4")
    assert box_of(pattern) == pytest.approx([100, 60])
    assert "note: unit-named" in output
    assert "--scale 25.4" in output


def test_ends_within_the_tolerance_are_joined(here):
    drawing = svg(here, RIM, '<line x1="40" y1="2" x2="40" y2="60" stroke="red"/>')
    assert "crease-dangling" in converted(here, drawing)[1]
    pattern, output = converted(here, drawing, "--merge-mm", "2.5")
    assert "ends-extended" in output
    assert counts_of(pattern) == {"B": 6, "M": 1}
    assert "under half the drawing's diagonal" in refused(
        here, "convert", drawing, "a.fold", "--merge-mm", "90"
    )


def test_colours_and_layers_have_the_meaning_that_is_given(here):
    drawing = svg(
        here,
        RIM,
        CREASE.format(colour="#ff8800"),
        '<g id="my folds"><line x1="70" y1="0" x2="70" y2="60" stroke="#aaa"/></g>',
    )
    pattern, output = converted(here, drawing)
    assert counts_of(pattern) == {"B": 8, "U": 2}
    assert '--colours "#ff8800=mountain"' in output
    words = ["--colours", "#f80=mountain,my folds=valley", "--fold-deg", "90"]
    pattern, _ = converted(here, drawing, *words)
    assert counts_of(pattern) == {"B": 8, "M": 1, "V": 1}
    for text, match in (
        ("#ff8800", "must be a colour or name, =, and an assignment"),
        ("#ff8800=mountan", "Did you mean mountain"),
        ("#f8=cut", "must be #rgb or #rrggbb"),
    ):
        assert match in refused(here, "convert", drawing, "a.fold", "--colours", text)


def test_border_of_a_drawing_without_one(here):
    drawing = svg(here, *(f'<path d="M{d}" stroke="red"/>' for d in ("0 0 100 60", "0 60 100 0")))
    assert "--border hull" in refused(here, "convert", drawing, "a.fold")
    pattern, output = converted(here, drawing, "--border", "hull")
    assert counts_of(pattern) == {"B": 4, "M": 4}
    assert "border-hull" in output


def test_border_inside_of_the_sheet(here):
    drawing = svg(here, RIM, CREASE.format(colour="black"))
    assert "--inner-border cut" in refused(here, "convert", drawing, "a.fold")
    pattern, output = converted(here, drawing, "--inner-border", "cut")
    assert counts_of(pattern) == {"B": 6, "C": 1}
    assert "border-inside" in output


def test_refusals_say_what_could_not_be_read(here):
    drawing = svg(here, '<path d="M0 0L100 0L100 60L0 x" stroke="black"/>')
    output = refused(here, "convert", drawing, "a.fold")
    assert "the data of 1 shape cannot be read to the end" in output


def test_fold_angles_where_none_are_given(here):
    drawing = svg(here, RIM, CREASE.format(colour="red"))
    for words, angle in ((["--fold-deg", "75"], -75), ([], -180)):
        pattern, output = converted(here, drawing, *words)
        assert set(pattern.edges_foldAngle) == {0, angle}
        assert ("fold-angle-missing" in output) == (not words)
    for angle in ("0", "181", "nan"):
        words = ["--fold-deg", angle]
        assert "fold_deg" in refused(here, "convert", drawing, "a.fold", *words)


def miura_without_angles(here):
    """A Miura pattern without fold angles and folded form, and its document."""
    source = json.loads((PATTERNS / "miura.fold").read_text())
    source.pop("file_frames", None)
    source.pop("edges_foldAngle", None)
    path = here / "miura.fold"
    path.write_text(json.dumps(source))
    return path, source


def test_fold_angles_of_a_rigid_fold(here):
    path, _ = miura_without_angles(here)
    flat, _ = converted(here, path, "--fold-deg", "60")
    folding = np.isin(flat.edges_assignment, ["M", "V"])
    assert set(np.abs(flat.edges_foldAngle[folding])) == {60}
    pattern, output = converted(here, path, "--fold-deg", "60", "--rigid")
    assert "note: rigid-fold" in output
    assert "fold-angle-missing" not in output
    angles = np.abs(pattern.edges_foldAngle[folding])
    assert angles.max() == pytest.approx(60, abs=1e-6)
    assert len(np.unique(np.round(angles, 6))) == 2  # of a Miura fold: two kinds of creases
    assert np.nanmax(vertices_closure_rad(pattern)) < 1e-9
    assert (np.sign(pattern.edges_foldAngle) == np.sign(flat.edges_foldAngle)).all()


def test_creases_without_a_letter_are_assigned_where_there_is_one_choice(here):
    """Maekawa: of four creases at a vertex three are alike, so the fourth follows."""
    path, source = miura_without_angles(here)
    letters = list(source["edges_assignment"])
    whole, _ = converted(here, path)
    folding = [i for i, letter in enumerate(letters) if letter.upper() in "MV"]
    source["edges_assignment"] = [
        "U" if i == folding[len(folding) // 2] else letter for i, letter in enumerate(letters)
    ]
    path.write_text(json.dumps(source))
    pattern, output = converted(here, path)
    assert counts_of(pattern)["U"] == 1
    assert "give --assign" in output
    pattern, output = converted(here, path, "--assign")
    assert counts_of(pattern) == counts_of(whole)
    assert pattern.edges_assignment.tolist() == whole.edges_assignment.tolist()


def test_one_of_several_patterns_is_chosen(here):
    first, second = strip(), strip()
    second["vertices_coords"] = [[2 * x, y, z] for x, y, z in FLAT]
    first["file_frames"] = [{k: v for k, v in second.items() if k != "file_frames"}]
    path = here / "two.fold"
    path.write_text(json.dumps(first))
    pattern, output = converted(here, path)
    assert box_of(pattern) == [100, 60]
    assert "the file has 2 crease patterns: the first is read. Give --frame 2" in output
    pattern, output = converted(here, path, "--frame", "2")
    assert box_of(pattern) == [200, 60]
    assert "several-patterns" not in output
    for command in COMMANDS.values():
        assert "--frame 3: the file has 2 crease patterns" in refused(
            here, *command(path), "--frame", "3"
        )
    drawing = svg(here, RIM)
    assert "has 1 crease pattern. Give 1" in refused(
        here, "convert", drawing, "a.fold", "--frame", "2"
    )


def test_sizes_are_for_one_side_alone(here):
    drawing = svg(here, RIM, CREASE.format(colour="red"))
    for command in COMMANDS.values():
        output = refused(here, *command(drawing), "--width-mm", "50", "--scale", "2")
        assert "give one of them" in output


def test_jobs_take_no_options_of_drawings(here):
    assert run("new", "miura").exit_code == 0
    for words in (["--width-mm", "50"], ["--strict"], ["--fold-deg", "90"]):
        assert "a job says itself" in refused(here, "simulate", "miura.toml", *words)


def test_names_of_files_do_not_steer_the_terminal(here):
    name = "a\x1b]0;title\x07b.svg"
    svg(here, RIM, CREASE.format(colour="red")).rename(here / name)
    for command in COMMANDS.values():
        result = run(*command(here / name))
        assert all(letter.isprintable() or letter == "\n" for letter in result.output)


# --- what cannot be read ---

NINE = "1 0 0 1 0 5 6 7 8\n"


def _dxf(unit, size):
    import io

    document = ezdxf.new("R2007")
    document.units = unit
    space = document.modelspace()
    corners = [(0, 0), (size, 0), (size, size), (0, size), (0, 0)]
    if size:
        space.add_lwpolyline(corners, dxfattribs={"layer": "BORDER"})
    stream = io.StringIO()
    document.write(stream)
    return stream.getvalue()


def _many():
    """A million lines and one."""
    return HEAD.format(size="") + '<path stroke="red" d="M0 0' + "L1 0L0 1" * 500_001 + '"/></svg>'


BAD = {
    "unknown.xyz": ("nothing", "not a crease pattern. Files that are read: .fold, .svg"),
    "picture.svg": (
        HEAD.format(size="") + '<image width="9" height="9" href="data:,"/></svg>',
        "a picture of pixels. Trace it",
    ),
    "bomb.svg": (
        f'<!DOCTYPE svg [<!ENTITY a "aa"><!ENTITY b "&a;&a;">]>{HEAD.format(size="")}&b;</svg>',
        "bomb.svg: ",
    ),
    "empty.dxf": (_dxf(4, 0), "no lines, arcs, splines or polylines"),
    "nine.cp": (NINE, "line 1: 9 columns instead of 5"),
    "nan.cp": ("1 0 0 nan 0\n", "line 1"),
    "kilometres.dxf": (_dxf(7, 1), "mm large; its longer side must be"),
    "empty.cp": ("", "empty"),
    "broken.opx": ("<java><object", "broken.opx: "),
    "broken.ori": ("{", "broken.ori: "),
    "broken.fold": ("{", "not a JSON file"),
}


@pytest.mark.parametrize("name", BAD)
@pytest.mark.parametrize("command", COMMANDS)
def test_bad_files_are_refused_and_nothing_is_written(here, name, command):
    text, match = BAD[name]
    (here / name).write_text(text)
    if name == "kilometres.dxf" and command in ("convert", "simulate", "check"):
        return  # not made of material
    assert match in refused(here, *COMMANDS[command](name))


def test_a_drawing_in_metres_has_its_size(here):
    (here / "metres.dxf").write_text(_dxf(6, 0.2))
    pattern, _ = converted(here, here / "metres.dxf")
    assert box_of(pattern) == pytest.approx([200, 200])


def test_a_million_lines_are_refused(here):
    (here / "many.svg").write_text(_many())
    assert "over the bound of 1000000" in refused(here, "convert", "many.svg", "a.fold")


@pytest.mark.parametrize("target", ["a.stl", "a", "a.fodl", "a.opx"])
def test_endings_that_are_not_written_are_refused(here, target):
    output = refused(here, "convert", svg(here, RIM), target)
    assert "must end in .fold, .svg, .dxf, .cp, .obj or .png" in output
    assert ("Did you mean .fold?" in output) == (target == "a.fodl")


def test_what_a_format_has_no_place_for_is_reported(here):
    source = svg(here, RIM, '<line x1="40" y1="10" x2="40" y2="50" stroke="#0f0"/>')
    assert "warning: lost-in-cp" in run("convert", source, "a.cp").output
    strip_ = written(here, "fold")
    assert "warning: angles-lost-in-cp" in run("convert", strip_, "b.cp").output
    assert "warning: angles-lost-in-dxf" in run("convert", strip_, "b.dxf").output
    assert "lost" not in run("convert", strip_, "b.svg").output


@pytest.mark.parametrize(("size", "stroke"), [(1.0, 0.005), (20.0, 0.1), (100.0, 0.2), (1e4, 0.2)])
def test_lines_of_small_drawings_are_thin(here, size, stroke):
    """Stroke widths in millimetres: those of ordinary sizes are what they were."""
    file = written(here, "fold")
    assert run("convert", file, "a.svg", "--width-mm", size).exit_code == 0
    text = (here / "a.svg").read_text()
    width = float(re.search(r'width="([\d.e+-]+)mm"', text)[1])
    box = float(re.search(r'viewBox="0 0 ([\d.e+-]+) ', text)[1])
    assert width == size
    assert float(re.search(r'stroke-width="([\d.e+-]+)"', text)[1]) * width / box == (
        pytest.approx(stroke)
    )


def test_the_same_from_python(here):
    import fab

    drawing = svg(here, RIM, CREASE.format(colour="#ff8800"), size="")
    options = fab.ReadOptions(mm_per_unit=1.0, colours={"#ff8800": "V"}, fold_deg=90.0)
    pattern, findings = fab.read_pattern(drawing, options)
    assert counts_of(pattern) == {"B": 6, "V": 1}
    assert box_of(pattern) == [100, 60]
    assert {finding.code for finding in findings} == {"lines-split"}
    made = fab.convert(fab.read_any([drawing], options), here / "a.dxf")
    fab.write(made, here)
    assert (here / "a.dxf").is_file()
    with pytest.raises(fab.InvalidJob, match="give one file, or two OBJ files"):
        fab.read_any([])


@pytest.mark.parametrize("size", [("--scale", "1e-300"), ("--width-mm", "1e9")])
@pytest.mark.parametrize("command", ["convert", "check"])
def test_sizes_that_nothing_can_be_made_of_are_refused(here, command, size):
    file = str(PATTERNS / "square_twist.fold")
    result = run(command, file, *(["a.cp"] if command == "convert" else []), *size)
    assert result.exit_code == 2
    assert "its longer side must be from 0.1 to 100000 mm. Give --width-mm 100" in result.stderr
    assert not list(here.iterdir())
