"""Files that a machine follows line by line, read back and measured against the DXF of the run."""

from io import StringIO

import ezdxf
import numpy as np
import pytest
import shapely
from helpers import PATTERNS
from machine_readers import Stroke, lengths_by_tool, read_grbl, read_lightburn, read_plotter

from fab import read_pattern
from fab.drawings.cut_paths import CutPaths, Layer, Operation, polylines
from fab.drawings.cut_settings import CutSetting
from fab.drawings.drawing_files import SheetFormat
from fab.drawings.gcode import gcode_bytes
from fab.drawings.lightburn import lightburn_bytes
from fab.drawings.plotter import plotter_bytes
from fab.jobs.sheet_files import fabricate
from fab.pattern.crease_pattern import scaled
from fab.sheets.cutting_order import tour
from fab.sheets.materials import Powers, load_machine, load_material
from fab.sheets.registration import Registration
from fab.sheets.sheet_request import SheetRequest
from solver import InvalidState

POWERS = Powers(cut_percent=80, perforate_percent=60, score_percent=15, engrave_percent=12.5)
# Machine, material, pattern, width in mm, copies: dashes, living hinges, letters, a deep bed.
CASES = [
    ("co2_60w_600x400", "card_300gsm", "square_twist", 180.0, 3),
    ("diode_10w_400x400", "plywood_3mm", "miura", 300.0, 1),
    ("knife_a4", "copy_paper_80gsm", "yoshimura", 500.0, 1),
]


def made_of(machine, material, name, width_mm, copies=1, kind="lbrn2", **choices):
    """What is made, with powers, and the DXF of the same run."""
    pattern, _ = read_pattern(PATTERNS / f"{name}.fold")
    cutter = load_machine(machine).model_copy(update={"powers": POWERS} | choices.pop("of", {}))
    request = SheetRequest(
        load_material(material),
        cutter,
        copies,
        formats=[SheetFormat.DXF, SheetFormat(kind)],
        page=False,
        **choices,
    )
    return fabricate(scaled(pattern, width_mm=width_mm), name, request), request


def dxf_lengths(data):
    """Length of all lines on each layer of a DXF file."""
    out = {}
    for entity in ezdxf.read(StringIO(data.decode())).modelspace():
        if entity.dxftype() == "LINE":
            length = (entity.dxf.end - entity.dxf.start).magnitude
        else:
            points = [(x, y) for x, y, *_ in entity.get_points()]
            length = (shapely.LinearRing if entity.closed else shapely.LineString)(points).length
        out[entity.dxf.layer] = out.get(entity.dxf.layer, 0.0) + length
    return out


def drawings_of(made, ending):
    """Pairs of a DXF file and the file of that ending beside it."""
    stems = [name.removesuffix(".dxf") for name in made.files if name.endswith(".dxf")]
    assert stems
    return [(made.files[f"{stem}.dxf"], made.files[f"{stem}.{ending}"]) for stem in stems]


def in_order(tools):
    """The operations are those of the work, in its order, each in one go."""
    runs = [tool for i, tool in enumerate(tools) if i == 0 or tool != tools[i - 1]]
    return runs == [operation for operation in Operation if operation in runs]


def frees_pieces_last(strokes):
    """Of closed cuts, none comes after one that it is inside of."""
    rings = [shapely.Polygon(s.points) for s in strokes if s.tool == Operation.CUT]
    return not any(
        first.contains(second.representative_point())
        for number, first in enumerate(rings)
        for second in rings[number + 1 :]
        if first.area > second.area
    )


@pytest.mark.parametrize("case", CASES)
def test_lightburn_projects_are_the_drawing_with_the_settings_of_machine_and_material(case):
    made, request = made_of(*case)
    assert not [f for f in made.findings if f.code == "power-unset"]
    for drawing, data in drawings_of(made, "lbrn2"):
        project = read_lightburn(data)
        wanted = dxf_lengths(drawing)
        assert lengths_by_tool(project.strokes) == pytest.approx(wanted, abs=1e-3)
        assert {"MOUNTAIN", "VALLEY", "CUT"} <= set(wanted)
        assert in_order([stroke.tool for stroke in project.strokes])
        assert frees_pieces_last(project.strokes)
        points = np.concatenate([stroke.points for stroke in project.strokes])
        assert (points >= 0).all()
        assert (points <= request.machine.bed_mm).all()
        speeds, powers = request.speeds, POWERS
        for name, speed, power in [
            ("MOUNTAIN", speeds.perforate_mm_s, powers.perforate_percent),
            ("CUT", speeds.cut_mm_s, powers.cut_percent),
        ]:
            layer = project.layers[name]
            assert float(layer["speed"]) == pytest.approx(speed)
            assert float(layer["minPower"]) == float(layer["maxPower"]) == power
        assert list(project.layers) == [o for o in Operation if o in project.layers]
        assert project.notes.get("ShowOnLoad") == "0"
        assert project.planner["Optimize_ByLayer"] == 0  # first of all
        assert project.planner["Optimize_ReduceTravel"] == 0


def test_dashes_are_lines_for_machines_whose_software_perforates_too():
    made, request = made_of(*CASES[1])
    assert request.machine.profile == "whole_lines"
    ((_, data),) = drawings_of(made, "lbrn2")
    pattern, _ = read_pattern(PATTERNS / "miura.fold")
    creases = int((pattern.edges_assignment == "M").sum())
    strokes = [s for s in read_lightburn(data).strokes if s.tool == "MOUNTAIN"]
    assert len(strokes) > 2 * creases


def test_unknown_powers_are_left_to_lightburn_and_reported():
    made, _ = made_of(*CASES[0], of={"powers": Powers(cut_percent=80)})
    (finding,) = [f for f in made.findings if f.code == "power-unset"]
    assert "no power for MOUNTAIN, VALLEY:" in finding.text
    ((_, data),) = drawings_of(made, "lbrn2")
    project = read_lightburn(data)
    assert "maxPower" not in project.layers["MOUNTAIN"]
    assert project.layers["CUT"]["maxPower"] == "80"
    assert project.notes.get("ShowOnLoad") == "1"
    assert "MOUNTAIN, power; VALLEY, power." in project.notes.get("Notes")


def test_scores_have_a_power_of_their_own():
    made, request = made_of(*CASES[0][:4], registration=Registration())
    front = read_lightburn(made.files["square_twist_1_front.lbrn2"])
    assert float(front.layers["MOUNTAIN"]["maxPower"]) == POWERS.score_percent
    assert request.cut_settings[Operation.CUT].power_percent == POWERS.cut_percent
    bands = {"bands": [{"from_deg": 0.0, "to_deg": 30.0, "valley": {"kind": "score"}}]}
    material = request.material
    table = type(material.perforation).model_validate(material.perforation.model_dump() | bands)
    mixed = SheetRequest(
        material.model_copy(update={"perforation": table}),
        request.machine,
        formats=[SheetFormat.LBRN2],
    )
    assert mixed.cut_settings[Operation.VALLEY].power_percent is None
    assert mixed.cut_settings[Operation.MOUNTAIN].power_percent == POWERS.perforate_percent


def test_lines_that_meet_are_one_and_titles_are_escaped():
    steps = np.array([[[0.0, 0], [1, 0]], [[1, 0], [1, 1]], [[3, 0], [4, 0]]])
    square = np.array([[5.0, 5], [9, 5], [9, 9], [5, 9]])
    layer = Layer(Operation.CUT, steps, (square,))
    assert [len(line) for line in polylines(layer)] == [3, 2, 5]
    data = lightburn_bytes(CutPaths((layer,), (10, 10)), 'a "<&>\x00')
    project = read_lightburn(data)
    assert [s.points.tolist() for s in project.strokes][2] == [*square.tolist(), square[0].tolist()]
    assert 'a "<&>_, on a bed of 10 x 10 mm' in project.notes.get("Notes")
    assert data == lightburn_bytes(CutPaths((layer,), (10, 10)), 'a "<&>\x00')
    assert "speed" not in project.layers["CUT"]
    assert polylines(Layer(Operation.CUT)) == []


TOOLS = {
    1: Operation.ENGRAVE,
    2: Operation.MOUNTAIN,
    3: Operation.VALLEY,
    4: Operation.RELIEF,
    5: Operation.CUT,
    6: Operation.HOLE,
}
ROUNDED = 0.0125 + 1e-9


@pytest.mark.parametrize("case", CASES)
def test_plotter_files_are_the_drawing_within_their_rounding(case):
    """Every line of the project for LightBurn is there, its points off by at most half a unit."""
    made, request = made_of(*case, kind="plt")
    exact, _ = made_of(*case)
    width, depth = request.machine.bed_mm
    for (drawing, data), (_, project) in zip(
        drawings_of(made, "plt"), drawings_of(exact, "lbrn2"), strict=True
    ):
        plot = read_plotter(data)
        if depth > width:
            # back from the feed of the roll to the drawing
            plot = plot.turned_back(width)
        assert (plot.moves >= 0).all()
        assert (plot.moves <= request.machine.bed_mm).all()
        wanted = read_lightburn(project).strokes
        assert [TOOLS[int(s.tool)] for s in plot.strokes] == [s.tool for s in wanted]
        for stroke, line in zip(plot.strokes, wanted, strict=True):
            assert np.abs(stroke.points - line.points).max() <= ROUNDED
        lengths = lengths_by_tool(plot.strokes)
        sides = {t: sum(len(s.points) for s in plot.strokes if s.tool == t) for t in lengths}
        for tool, length in lengths.items():
            bound = sides[tool] * 2 * np.sqrt(2) * ROUNDED
            assert length == pytest.approx(dxf_lengths(drawing)[TOOLS[int(tool)]], abs=bound)
        speeds = request.speeds
        assert plot.speeds["5"] == max(1, round(speeds.cut_mm_s / 10))
        assert plot.speeds["2"] == max(1, round(speeds.perforate_mm_s / 10))


def test_pages_of_plotters_lie_along_the_feed_and_are_not_mirrored():
    """A bed 20 wide and 50 deep: its upper left corner is the origin, its depth the x axis."""
    line = np.array([[[2.0, 3], [2, 13.01]]])
    layer = Layer(Operation.CUT, line)
    plot = read_plotter(plotter_bytes(CutPaths((layer,), (20, 50))))
    assert plot.strokes[0].points.tolist() == [[3, 18], [13, 18]]
    assert plot.speeds == {}
    flat = plotter_bytes(CutPaths((Layer(Operation.VALLEY), layer), (50, 20)))
    assert flat == b"IN;PA;\nPU;SP5;\nPU80,120;PD80,520;\nPU0,0;SP0;\n"


@pytest.mark.parametrize("case", CASES)
def test_gcode_is_the_drawing_at_the_feeds_and_powers_of_the_machine(case):
    made, request = made_of(*case, kind="gcode", of={"s_max": 255.0})
    for drawing, data in drawings_of(made, "gcode"):
        run = read_grbl(data)
        assert lengths_by_tool(run.strokes) == pytest.approx(dxf_lengths(drawing), abs=1e-3)
        assert in_order([stroke.tool for stroke in run.strokes])
        assert frees_pieces_last(run.strokes)
        assert (run.moves >= 0).all()
        assert (run.moves <= request.machine.bed_mm).all()
        assert run.moves[-1].tolist() == [0, 0]
        wanted = request.cut_settings
        for tool, (power, feed) in run.settings.items():
            assert feed == pytest.approx(60 * wanted[tool].speed_mm_s)
            assert power == pytest.approx(2.55 * wanted[tool].power_percent)
        margin = request.machine.margin_mm
        assert run.moves[1:-1].min() >= margin - 1e-6


@pytest.mark.parametrize("case", CASES)
def test_the_run_around_the_lines_has_no_power_and_touches_them(case):
    made, _ = made_of(*case, kind="gcode")
    stems = [name.removesuffix("_frame.gcode") for name in made.files if "_frame" in name]
    assert len(stems) == len(made.report["sheets"])
    for stem in stems:
        frame = read_grbl(made.files[f"{stem}_frame.gcode"])
        assert frame.strokes == []
        lines = np.concatenate([s.points for s in read_grbl(made.files[f"{stem}.gcode"]).strokes])
        corners = frame.moves[1:-1]
        assert len(corners) == 5
        assert (corners[0] == corners[-1]).all()
        assert corners.min(axis=0) == pytest.approx(lines.min(axis=0), abs=1e-6)
        assert corners.max(axis=0) == pytest.approx(lines.max(axis=0), abs=1e-6)
        steps = np.diff(corners, axis=0)
        assert ((steps == 0).sum(axis=1) == 1).all()


def test_gcode_without_a_power_is_refused_with_its_cure():
    with pytest.raises(InvalidState, match=r"no powers\.cut_percent.*Give cut_percent"):
        made_of(*CASES[0], kind="gcode", of={"powers": Powers()})
    with pytest.raises(InvalidState, match=r"power of MOUNTAIN is not known.*perforate_percent"):
        made_of(*CASES[0], kind="gcode", of={"powers": Powers(cut_percent=80)})


def nested():
    """A square in a ring in a frame, the largest first, and another beside them."""
    square = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])
    rings = (60 * square + 1, 40 * square + 10, 10 * square + 20, 10 * square + [70, 1])
    return CutPaths((Layer(Operation.CUT, outlines=rings),), (100, 100))


@pytest.mark.parametrize(
    ("written", "read"),
    [
        (lambda paths, settings: lightburn_bytes(paths, "a", settings), read_lightburn),
        (plotter_bytes, read_plotter),
        (lambda paths, settings: gcode_bytes(paths, settings, 1000.0), read_grbl),
    ],
)
def test_inner_outlines_are_cut_before_those_around_them(written, read):
    settings = {Operation.CUT: CutSetting(20.0, 50.0)}
    for paths, right in [(nested(), False), (tour(nested()), True)]:
        data = written(paths, settings)
        assert data == written(paths, settings)
        strokes = [Stroke(Operation.CUT, stroke.points) for stroke in read(data).strokes]
        assert len(strokes) == 4
        assert frees_pieces_last(strokes) == right
