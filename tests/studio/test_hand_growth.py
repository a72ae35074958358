"""Growing by hand in the studio: what the page asks for, and what becomes of the job's text."""

import json
import tomllib

import numpy as np
import pytest
from click.testing import CliRunner
from helpers import TEMPLATE_NAMES, TEMPLATES
from hypothesis import given, settings
from hypothesis import strategies as st
from starlette.testclient import TestClient
from studio_answers import arrays_of, head_of

from fab.cli.group import main
from fab.errors import InvalidJob
from fab.jobs.design_settings import SEEDS
from fab.jobs.job import load_job, parse_job
from fab.jobs.job_files import grown_sheet, make
from fab.studio.app import Studio, studio_app
from fab.studio.form_fields import form_fields
from fab.studio.hand_growth import by_hand, hand_state, next_strip
from fab.studio.job_text import changed_text
from fab.studio.tasks import grow
from solver import InvalidValue, Side, flap_angle_landscape
from solver.strip_choices import strip_front

HOST = "127.0.0.1:8765"
JOB = (TEMPLATES / "strip_by_strip.toml").read_text(encoding="utf-8")
STRIPS = tomllib.loads(JOB)["design"]["strips"]


def state(text=JOB, strip=None, strips=None, known="", folder="."):
    changes = [] if strips is None else [(["design", "strips"], strips)]
    return hand_state(text, changes, strip, known, folder, allow_code=False)


@pytest.fixture(scope="module")
def client(tmp_path_factory):
    app = studio_app(Studio(tmp_path_factory.mktemp("studio"), "token"), frozenset({HOST}))
    with TestClient(app, base_url=f"http://{HOST}/token/") as made:
        yield made


def test_the_choices_of_a_strip_are_those_of_its_front():
    data = state(strip=4)
    strip, arrays = head_of(data)["strip"], arrays_of(data)
    before = changed_text(JOB, [(["design", "strips"], STRIPS[:4])])
    mesh = grown_sheet(parse_job(tomllib.loads(before))).mesh
    front = strip_front(mesh, Side.RIGHT)
    assert strip["front"] == mesh.front_vertices(Side.RIGHT).tolist()
    assert strip["row"] == [*range(len(mesh.vertices_coords), len(mesh.vertices_coords) + 7)]
    np.testing.assert_allclose(np.radians(strip["free"]), front.free_flap_angles())
    bounds = front.rays(np.radians(STRIPS[4]["flap_angle_deg"])).length_bounds
    assert [bound is None for bound in strip["bounds"]] == np.isinf(bounds).tolist()
    known = np.array(strip["bounds"], float)
    np.testing.assert_allclose(known[~np.isnan(known)], bounds[np.isfinite(bounds)])
    lengths = np.array(STRIPS[4]["lengths"])
    found = flap_angle_landscape(front, lengths=lengths, flap_angles=360)
    np.testing.assert_allclose(arrays["cost"], found.cost, rtol=1e-6)
    np.testing.assert_array_equal(arrays["constraint"], found.constraint)
    assert strip["best"] == pytest.approx(np.degrees(found.best), abs=0.5)
    again = state(strip=4, known=strip["landscape"])
    assert head_of(again)["strip"] == strip
    assert arrays_of(again) == {}


def test_an_angle_that_is_refused_still_has_its_free_arcs_and_bounds():
    turned = [*STRIPS[:3], {**STRIPS[3], "flap_angle_deg": 225.0 + 130.0}]
    head = head_of(state(strip=3, strips=turned))
    assert head["sides"] is None
    assert all(start < 355.0 and end < 355.0 for start, end in head["strip"]["free"])
    later = [{**STRIPS[0], "flap_angle_deg": 20.0}, *STRIPS[1:]]
    with pytest.raises(InvalidValue, match=r"strip 1 \(top side\)"):
        state(strip=2, strips=later)


def test_sides_name_the_vertices_of_the_pattern():
    sides = head_of(state())["sides"]
    pattern = grown_sheet(load_job(TEMPLATES / "strip_by_strip.toml")).pattern
    edges = pattern.edges_vertices[pattern.edges_assignment == "B"]
    border = {tuple(sorted(pair)) for pair in edges.tolist()}
    walked = [
        tuple(sorted(pair))
        for side in sides.values()
        for pair in zip(side["vertices"], side["vertices"][1:], strict=False)
    ]
    assert set(walked) == border
    assert len(walked) == len(border)
    ring = changed_text(
        JOB, [(["design", "strips"], []), (["design", "seed", "kind"], "random_tube")]
    )
    for key in ("columns", "rows", "sector_angle_deg", "fold_deg"):
        ring = changed_text(ring, [(["design", "seed", key], None)])
    sides = head_of(state(ring))["sides"]
    assert [side for side, each in sides.items() if each["why"]] == ["right", "left"]


@pytest.mark.parametrize("side", list(Side))
def test_the_strip_that_is_proposed_can_be_grown(side):
    strip = head_of(next_strip(JOB, [], side.value, ".", allow_code=False))["strip"]
    assert strip["side"] == side.value
    text = changed_text(JOB, [(["design", "strips"], [*STRIPS, strip])])
    assert tomllib.loads(text)["design"]["strips"] == [*STRIPS, strip]
    assert head_of(grow(text, [], ".", "", allow_code=False))["status"] == "grown"


@pytest.mark.parametrize("name", TEMPLATE_NAMES)
def test_every_other_job_goes_on_by_hand_with_its_comments(name):
    text = (TEMPLATES / f"{name}.toml").read_text(encoding="utf-8")
    if tomllib.loads(text)["design"]["kind"] not in SEEDS:
        with pytest.raises(InvalidJob, match="cannot be a seed"):
            by_hand(text, [], str(TEMPLATES), allow_code=False)
        return
    grown = head_of(by_hand(text, [], str(TEMPLATES), allow_code=False))["text"]
    before, after = tomllib.loads(text), tomllib.loads(grown)
    design = after.pop("design")
    assert design == {"kind": "strip_by_strip", "seed": before.pop("design")}
    assert after == before
    comments = [line.partition("#")[2] for line in text.splitlines() if "#" in line]
    assert [line.partition("#")[2] for line in grown.splitlines() if "#" in line] == comments
    parse_job(tomllib.loads(grown))


@pytest.mark.parametrize(
    "design", ['design = { kind = "miura" }', 'design.kind = "miura"', '[design]\nkind = "miura"']
)
def test_designs_of_any_form_of_table_go_on_by_hand(design):
    text = f'name = "x"\nsheet = {{ width_mm = 90.0 }}\n{design}\n'
    grown = head_of(by_hand(text, [], ".", allow_code=False))["text"]
    assert tomllib.loads(grown)["design"]["seed"] == {"kind": "miura"}
    strip = head_of(next_strip(grown, [], "top", ".", allow_code=False))["strip"]
    done = changed_text(grown, [(["design", "strips"], [strip])])
    assert tomllib.loads(done)["design"]["strips"] == [strip]


ROW = st.fixed_dictionaries(
    {
        "side": st.sampled_from(list("trbl")),
        "flap_angle_deg": st.floats(0.0, 360.0),
        "lengths": st.floats(0.1, 2.0) | st.lists(st.floats(0.1, 2.0), min_size=1, max_size=4),
    }
)
FORMS = [
    """
[design]
kind = "x"  # by hand

[design.seed]
kind = "miura"

[sheet]
width_mm = 3.0
""",
    """
[design]
strips = [{ side = "t" }, { side = "r", lengths = [1, 2] }]
[sheet]
width_mm = 3.0
""",
    """
[design]
strips = [
    { side = "t" },  # one
    { side = "r" } # two
]
""",
    """
[design]
kind = "x"
[design.seed]
kind = "miura"
[[design.strips]]  # one
side = "t"

[[design.strips]]
side = "l"
""",
    'design = { kind = "x", strips = [] }\n',
    'design.kind = "x"\nsheet.width_mm = 3.0\n',
]


@pytest.mark.parametrize("text", FORMS)
@settings(max_examples=20)
@given(data=st.data())
def test_any_strips_are_written_into_any_text(text, data):
    wanted = tomllib.loads(text)
    for _ in range(data.draw(st.integers(1, 4))):
        rows = data.draw(st.lists(ROW, max_size=4))
        text = changed_text(text, [(["design", "strips"], rows)])
        wanted["design"]["strips"] = rows
        found = tomllib.loads(text)
        found["design"].setdefault("strips", [])
        assert found == wanted


def test_comments_of_strips_that_stay_do_so_too():
    text = changed_text(
        FORMS[2], [(["design", "strips"], [{"side": "l"}, {"side": "r"}, {"side": "b"}])]
    )
    assert '    { side = "l" },  # one\n' in text
    assert "# two" in text
    text = changed_text(FORMS[3], [(["design", "strips"], [{"side": "b"}])])
    assert text.count("[[design.strips]]  # one") == 1


def test_the_seed_has_fields_of_its_own():
    fields = {".".join(field.path): field for field in form_fields(parse_job(tomllib.loads(JOB)))}
    assert fields["design.seed.columns"].kind == "integer"
    assert fields["design.seed.fold_deg"].unit == "°"
    assert "design.seed.kind" not in fields
    assert "design.strips" not in fields


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("hand", {"changes": [], "strip": "1", "landscape": ""}),
        ("hand", {"changes": [], "strip": True, "landscape": ""}),
        ("hand", {"changes": [], "strip": 1}),
        ("hand", {"changes": [[["design", "strips"], [1]]], "strip": 1, "landscape": ""}),
        ("hand", {"changes": [[["a"], [{"b": None}]]], "strip": 1, "landscape": ""}),
        ("hand", {"changes": [[["a"], [{"b": [{}]}]]], "strip": 1, "landscape": ""}),
        ("next_strip", {"changes": []}),
        ("next_strip", {"changes": [], "side": "up"}),
        ("by_hand", {"text": 1, "changes": []}),
    ],
)
def test_malformed_messages_are_refused(client, name, message):
    content = json.dumps({"text": JOB, **message})
    assert client.post(name, content=content).status_code == 400


def test_refusals_are_told_and_other_jobs_have_no_sides(client):
    def ask(name, **message):
        return head_of(client.post(name, content=json.dumps(message)).content)

    miura = (TEMPLATES / "miura.toml").read_text(encoding="utf-8")
    head = ask("hand", text=miura, changes=[], strip=None, landscape="")
    assert (head["sides"], head["strip"], head["seedable"]) == (None, None, True)
    assert (
        "must be 'strip_by_strip'"
        in ask("next_strip", text=miura, changes=[], side="top")["refused"]
    )
    assert "cannot be a seed" in ask("by_hand", text=JOB, changes=[])["refused"]
    assert ask("hand", text=JOB, changes=[], strip=99, landscape="")["strip"] is None
    assert "not a TOML file" in ask("by_hand", text="[", changes=[])["refused"]


ANGLE = st.floats(-720.0, 720.0) | st.sampled_from([0, 180, 1e300, -0.0])
LENGTH = st.floats(-1.0, 3.0) | st.sampled_from([0, 1e300, 1e-300, 10**400])


@settings(max_examples=40)
@given(
    st.lists(
        st.fixed_dictionaries(
            {
                "side": st.sampled_from([*Side, "up"]),
                "flap_angle_deg": ANGLE,
                "lengths": LENGTH | st.lists(LENGTH, max_size=10),
            }
        ),
        max_size=3,
    ),
    st.integers(-1, 3),
)
def test_any_strips_give_a_sheet_or_a_refusal(strips, number):
    changes = [(["design", "strips"], strips)]
    try:
        head = head_of(grow(JOB, changes, ".", "", allow_code=False))
    except (InvalidJob, InvalidValue):
        head = None
    try:
        found = head_of(state(strips=strips, strip=number))
    except (InvalidJob, InvalidValue):
        assert head is None
    else:
        assert (found["sides"] is None) == (head is None)


def test_what_is_grown_is_what_run_makes_of_the_saved_job(tmp_path):
    text = 'outputs = ["fold", "dxf", "svg", "png"]\n' + JOB
    two = [(["design", "strips"], STRIPS[:2])]
    strips = [*STRIPS[:2], head_of(next_strip(JOB, two, "left", ".", allow_code=False))["strip"]]
    strips[1] = {**strips[1], "flap_angle_deg": 60.7}
    data = grow(text, [(["design", "strips"], strips)], str(tmp_path), "", allow_code=False)
    path = tmp_path / "job.toml"
    path.write_text(head_of(data)["text"], encoding="utf-8")
    out = CliRunner().invoke(main, ["run", str(path), "--out", str(tmp_path / "out")])
    assert out.exit_code == 0, out.output
    ran = {each.name: each.read_bytes() for each in (tmp_path / "out").iterdir()}
    made = make(load_job(path)).files
    assert set(ran) == set(made)
    for name in set(made) - {"strip_by_strip_report.json"}:
        assert made[name] == ran[name]
    frame = json.loads(ran["strip_by_strip.fold"])["file_frames"][0]
    shown = arrays_of(data)["folded"].reshape(-1, 3)
    apart = lambda coords: np.linalg.norm(coords - coords[:1], axis=1)  # noqa: E731
    np.testing.assert_allclose(apart(shown), apart(np.array(frame["vertices_coords"])), atol=1e-3)
