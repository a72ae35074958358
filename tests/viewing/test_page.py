"""The result page as text: nothing from outside, all of a report, no name that it obeys."""

import base64
import hashlib
import json
import re
import zlib
from dataclasses import replace
from functools import cache
from html.parser import HTMLParser

import numpy as np
import pytest
from flat_patterns import grid
from helpers import ROOT
from thick_sheets import miura_pattern, thick

from fab.drawings.cut_paths import CutPaths, Layer, Operation
from fab.drawings.svg import svg_bytes
from fab.errors import Finding, Severity
from fab.folding.fold_settings import FoldSettings
from fab.folding.folded_states import folded_states
from fab.folding.simulation import fold_and_judge
from fab.viewing.page import ResultPage, page_bytes
from fab.viewing.page_data import packed, page_data
from fab.viewing.page_drawings import crease_drawing, sheet_drawing
from fab.viewing.predicted_fold import predicted_scene
from fab.viewing.scene_builders import folding_scene, pattern_scene, thick_scene

KINDS = {"f32": "<f4", "u16": "<u2", "u32": "<u4"}
FINDING = Finding("made-up", Severity.WARNING, "a < b & 'c'", creases=(1,), panels=(2,))


class Elements(HTMLParser):
    """All elements with their attributes, and the text of each kind of them."""

    def __init__(self, page: bytes) -> None:
        super().__init__(convert_charrefs=True)
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.text: dict[str, list[str]] = {}
        self._open: list[str] = []
        self.feed(page.decode())

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        if tag not in ("meta", "input"):
            self._open.append(tag)

    def handle_endtag(self, tag):
        assert self._open.pop() == tag

    def handle_data(self, data):
        if self._open:
            self.text.setdefault(self._open[-1], []).append(data)

    def of(self, tag):
        return [attributes for name, attributes in self.elements if name == tag]


def numbers(entry):
    return np.frombuffer(zlib.decompress(base64.b64decode(entry["zlib"])), KINDS[entry["kind"]])


@cache
def scene(bodies=False):
    pattern = miura_pattern(3, 3)
    if not bodies:
        return predicted_scene(pattern, "miura")
    return thick_scene(thick(pattern), folded_states(pattern, count=2)[0], "miura")


def page_of(**changes):
    page = ResultPage("miura", "quadfold run", scene(), {"planarity_max": 0.5}, [FINDING])
    return page_bytes(replace(page, **changes))


def data_of(page):
    text = re.search(rb'<script type="application/json" id="data">(.*?)</script>', page, re.DOTALL)
    return json.loads(text[1])


def test_the_page_takes_nothing_from_outside():
    page = page_of(files={"a b&c.dxf": b"x"})
    elements = Elements(page)
    for _, attributes in elements.elements:
        for name in ("src", "srcset", "data", "action", "poster", "style"):
            assert (attributes.get(name) or "data:").startswith("data:")
        assert not any(name.startswith("on") for name in attributes)
    assert elements.of("link") == []
    assert [attributes["href"] for attributes in elements.of("a")] == ["a%20b%26c.dxf"]
    (policy,) = [a["content"] for a in elements.of("meta") if "http-equiv" in a]
    rules = dict(rule.strip().split(" ", 1) for rule in policy.split(";"))
    assert rules.pop("default-src") == rules.pop("base-uri") == rules.pop("form-action") == "'none'"
    assert rules.pop("img-src") == "data:"
    for element, count in (("script", 2), ("style", 1)):
        allowed = [
            f"'sha256-{base64.b64encode(hashlib.sha256(inner.encode()).digest()).decode()}'"
            for inner in elements.text[element][-count:]
        ]
        assert rules.pop(f"{element}-src").split() == allowed
    assert rules == {}


def test_names_and_texts_are_shown_and_not_obeyed():
    nasty = "</script><img src=x onerror=alert(1)>\"'&"
    finding = replace(FINDING, code=nasty, text=nasty)
    page = page_of(
        title=nasty,
        findings=[finding],
        files={nasty: b""},
        report={"growth": {nasty: nasty}, "job": {nasty: nasty}},
        sheets={nasty: CutPaths((), (10.0, 10.0))},
    )
    elements = Elements(page)
    assert elements.of("img") == []
    assert len(elements.of("script")) == 3
    assert elements.text["h1"] == [nasty]
    for kind in ("title", "code", "td", "th", "pre", "h2"):
        assert any(nasty in text or json.dumps(nasty)[1:-1] in text for text in elements.text[kind])


def test_the_same_page_gives_the_same_bytes_whatever_time_it_took():
    timed = [page_of(report={"growth": {"strips": 3}, "seconds": {"grow": t}}) for t in (0.1, 7.7)]
    assert timed[0] == timed[1]


def test_findings_light_up_what_they_name():
    page = page_of(
        findings=[replace(FINDING, creases=(1, 10**6)), replace(FINDING, creases=(), panels=())]
    )
    elements = Elements(page)
    buttons = [a for a in elements.of("button") if "data-finding" in a]
    assert [button["data-finding"] for button in buttons] == ["0"]  # the other names nothing
    assert data_of(page)["findings"][0] == {"creases": [1], "panels": [2]}
    assert "a < b & 'c'" in "".join(elements.text["li"])


@pytest.mark.parametrize(
    ("severity", "text"),
    [
        (Severity.NOTE, "Made, and within tolerance: 1 note."),
        (Severity.ERROR, "1 error: do not put material under it as it is."),
    ],
)
def test_the_page_says_first_whether_it_may_be_used(severity, text):
    assert Elements(page_of(findings=[replace(FINDING, severity=severity)])).text["p"][1] == text


def test_a_sheet_that_is_known_flat_alone_has_no_slider():
    flat = Elements(page_of(scene=pattern_scene(grid(2, 2, 10.0), "grid"), title="grid"))
    assert "Sheet, whose folded form is not known" in flat.text["h2"]
    for elements, hidden in ((flat, True), (Elements(page_of()), False)):
        (fold,) = [a for a in elements.of("div") if a.get("class") == "fold"]
        assert ("hidden" in fold) == hidden


def test_states_are_those_of_the_scene():
    data = data_of(page_of(scene=scene(bodies=True)))
    own = scene(bodies=True)
    assert data["states"] == list(own.bodies.state_names)
    states = numbers(data["sheet"]["positions"]).reshape(own.states_coords.shape)
    assert np.array_equal(states, own.states_coords.astype("<f4"))
    triangles = numbers(data["sheet"]["triangles"]).reshape(-1, 3)
    faces = numbers(data["sheet"]["trianglesFace"])
    pattern = own.pattern
    for face in range(pattern.face_count):
        corners = pattern.faces_vertices[slice(*pattern.faces_offsets[face : face + 2])]
        assert set(triangles[faces == face].ravel()) == set(corners)


def test_strain_has_its_place_on_its_scale_in_every_state():
    folding, _, _ = fold_and_judge(miura_pattern(3, 3), FoldSettings(steps=3))
    own = folding_scene(folding, "miura")
    page = page_of(scene=own)
    shares = numbers(data_of(page)["values"]["shares"]).reshape(own.values.values.shape)
    expected = own.values.scale.shares(own.values.values)
    assert np.abs(shares / 255 - expected).max() <= 0.5 / 255 + 1e-12
    assert expected.max() > 0.1
    assert "0.01 %" in page.decode()
    assert data_of(page_of())["values"] is None


def test_bodies_come_to_where_the_scene_has_them():
    own = scene(bodies=True)
    data = page_data(own, [])["bodies"]
    flat = numbers(data["positions"]).reshape(-1, 3).astype(float)
    face = numbers(data["verticesFace"])
    poses = numbers(data["poses"]).reshape(own.state_count, -1, 7).astype(float)
    for state in range(own.state_count):
        (x, y, z, w), shift = poses[state][face, :4].T, poses[state][face, 4:]
        vector = np.stack([x, y, z], axis=1)
        twice = 2 * np.cross(vector, flat)
        found = flat + w[:, None] * twice + np.cross(vector, twice) + shift
        assert found == pytest.approx(own.bodies.coords_in(state), abs=1e-4)
    counts = [numbers(data[key]) for key in ("verticesCount", "trianglesCount", "edgesCount")]
    first = np.cumsum(counts[0]) - counts[0]
    triangles = numbers(data["triangles"]).reshape(-1, 3) + np.repeat(first, counts[1])[:, None]
    assert triangles.tolist() == own.bodies.bodies.triangles.tolist()
    edges = numbers(data["edges"]).reshape(-1, 2) + np.repeat(first, counts[2])[:, None]
    box = next(body for body in range(len(own.bodies.names)) if counts[0][body] == 8)
    assert counts[2][box] == 12  # without the diagonals of its sides
    assert len(edges) == counts[2].sum() < 3 * len(triangles) / 2
    assert data["panels"] == own.bodies.faces.tolist()
    assert data["creases"] == own.bodies.creases.tolist()
    colours = np.array([[int(c[i : i + 2], 16) for i in (1, 3, 5)] for c in data["colours"]]) / 255
    assert colours[data["bodiesColour"]] == pytest.approx(own.bodies.colours, abs=0.5 / 255)


@pytest.mark.parametrize(
    "array", [np.arange(5), np.array([70_000]), np.array([0.1, -2.0]), np.empty(0)]
)
def test_arrays_survive_their_packing(array):
    assert numbers(packed(array)).tolist() == array.astype(KINDS[packed(array)["kind"]]).tolist()


def ends_of(path):
    """Lines of a path of the page, shape (n, 2, 2)."""
    found = np.array(re.findall(r"M(\S+) (\S+?)l(\S+?) ([^Ml]+)", path), float).reshape(-1, 2, 2)
    found[:, 1] += found[:, 0]
    return found


def path_of(svg, layer):
    return re.search(rf'<g data-layer="{layer}"[^>]*><path d="([^"]*)"', svg)[1]


def test_a_crease_pattern_has_its_edges_in_a_layer_for_each_letter():
    pattern = miura_pattern(3, 3)
    drawing = crease_drawing(pattern, "miura")
    high = pattern.vertices_coords[:, 1].max()
    letters = set(pattern.edges_assignment.tolist())
    assert set(drawing.layers) == letters
    for letter in letters:
        lines = pattern.vertices_coords[pattern.edges_vertices[pattern.edges_assignment == letter]]
        found = ends_of(path_of(drawing.svg, letter))
        assert found == pytest.approx(lines * [1, -1] + [0, high], abs=0.0101)


def dashes(count):
    start = np.stack([np.arange(count) * 2.0, np.full(count, 5.0)], axis=1)
    return np.stack([start, start + np.array([1.0, 0.0])], axis=1)


def test_a_sheet_has_the_lines_of_its_file():
    cut = np.array([[0.0, 0.0], [40.0, 0.0], [40.0, 10.0]])
    paths = CutPaths(
        (Layer(Operation.VALLEY, dashes(20)), Layer(Operation.CUT, outlines=(cut,))), (40.0, 10.0)
    )
    drawing = sheet_drawing(paths, "sheet")
    assert drawing.note == ""
    assert ends_of(path_of(drawing.svg, "VALLEY")) == pytest.approx(dashes(20))
    assert path_of(drawing.svg, "CUT") == "M0,10L40,10L40,0Z"
    file = svg_bytes(paths, "sheet").decode()
    assert all(f'id="{layer}"' in file for layer in drawing.layers)


def test_many_dashes_become_the_lines_that_they_are_on():
    two = np.concatenate([dashes(20), dashes(20) + np.array([0.0, 3.0])])
    paths = CutPaths((Layer(Operation.VALLEY, two),), (40.0, 10.0))
    drawing = sheet_drawing(paths, "sheet", most=30)
    assert "Dashes are drawn as lines" in drawing.note
    expected = [[[0, 5], [39, 5]], [[0, 2], [39, 2]]]
    assert ends_of(path_of(drawing.svg, "VALLEY")).tolist() == expected
    fewest = sheet_drawing(paths, "sheet", most=1)
    assert "Only outlines" in fewest.note
    assert path_of(fewest.svg, "VALLEY") == ""


def test_creases_on_the_way_turn_by_a_share_of_their_angles():
    pattern = miura_pattern(4, 4)
    found = predicted_scene(pattern, "miura")
    whole = pattern_scene(pattern, "miura")
    assert found.shares == pytest.approx(np.linspace(0, 1, 11))
    assert found.folded_coords == pytest.approx(whole.folded_coords)
    ends = pattern.edges_vertices
    lengths = np.linalg.norm(
        found.states_coords[:, ends[:, 0]] - found.states_coords[:, ends[:, 1]], axis=2
    )
    assert lengths == pytest.approx(np.broadcast_to(lengths[0], lengths.shape), rel=0.01)
    heights = np.linalg.svd(found.states_coords - found.states_coords.mean(axis=1, keepdims=True))[
        1
    ]
    assert np.all(np.diff(heights[:, 2]) > 0)  # thicker from state to state


def test_the_script_is_made_of_the_sources_beside_it():
    """Run `npm install && npm run build` in page_source after a change."""
    folder = ROOT / "fab" / "viewing"
    digest = hashlib.sha256()
    for source in sorted((folder / "page_source").glob("*.js")):
        digest.update(source.read_bytes())
    for name in ("views.js", "page.js"):
        script = (folder / "page_assets" / name).read_text(encoding="utf-8")
        assert script.startswith(f"/* sources {digest.hexdigest()} */")
        assert "</script" not in script
    assert "three.js authors" in (folder / "page_assets" / "three_licence.txt").read_text("utf-8")


@pytest.mark.parametrize(("columns", "many"), [(100, False), (101, True)])
def test_pages_of_many_faces_say_what_they_leave_out(columns, many):
    pattern = miura_pattern(columns, 200)
    page = page_of(scene=pattern_scene(pattern, "miura")).decode()
    assert (f"{pattern.face_count} faces: lines of the folded form are off" in page) == many
    assert ('id="creases" checked>' in page) != many


def test_a_page_of_a_thousand_faces_is_under_two_megabytes():
    pattern = miura_pattern(40, 25)
    assert pattern.face_count == 1000
    assert len(page_of(scene=predicted_scene(pattern, "miura"))) < 2e6
