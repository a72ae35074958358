"""What the studio answers, and what it refuses: by token, origin, size, form and place."""

import hashlib
import io
import json
import zipfile

import numpy as np
import pytest
from click.testing import CliRunner
from flat_patterns import grid
from folded_strips import folded_strip
from helpers import PATTERNS, ROOT, TEMPLATES
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from starlette.testclient import TestClient
from studio_answers import arrays_of, head_of

from fab import read_pattern
from fab.catalogue import shipped
from fab.cli.group import main
from fab.folding.fold_settings import FoldSettings
from fab.formats.fold.writer import fold_bytes
from fab.jobs.folding_files import simulate
from fab.jobs.job_files import grown_sheet
from fab.jobs.simulated_sheet import sentences, simulated_sheet
from fab.preferences import set_preference
from fab.studio.app import Studio, studio_app
from fab.studio.job_text import job_of_text
from fab.studio.serving import free_socket
from solver.vectors import norm

HOST = "127.0.0.1:8765"
MIURA = (TEMPLATES / "miura.toml").read_text(encoding="utf-8")
LONG = "a" * 300 + ".toml"
SMALL = [[["design", "columns"], 4], [["design", "rows"], 3]]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("studio") / "folder"  # whose parent has nothing else
    made.mkdir()
    return made


@pytest.fixture(scope="module")
def client(folder):
    app = studio_app(Studio(folder, "token"), frozenset({HOST}))
    with TestClient(app, base_url=f"http://{HOST}/token/") as made:
        yield made


def ask(client, name, **message):
    response = client.post(name, content=json.dumps(message))  # also what is no UTF-8
    assert response.status_code == 200, response.text
    return response.content


def grown(client, text=MIURA, changes=(), topology=""):
    return ask(client, "grow", text=text, changes=list(changes), topology=topology)


def test_the_page_and_its_files_come_from_the_package_alone(client):
    page = client.get("")
    assert "quadfold studio" in page.text
    assert "default-src 'none'" in page.headers["content-security-policy"]
    for name in ("studio.js", "views.js", "studio.css", "page.css", "three_licence.txt"):
        assert name in page.text
        assert client.get(name).status_code == 200
    assert "http://" not in page.text.replace("http://www.w3.org", "")
    for name in ("app.py", "..%2fapp.py", "%2e%2e/app.py", "studio.html.bak"):
        assert client.get(name).status_code in (403, 404)


@pytest.mark.parametrize("path", ["/", "/tokem/", "/token0/", "//", "/tok/start", "/\u00fc/start"])
def test_nobody_is_answered_without_the_token(client, path):
    assert client.get(f"http://{HOST}{path}").status_code == 403


@pytest.mark.parametrize(
    "headers",
    [
        {"origin": "http://example.com"},
        {"origin": "null"},
        {"origin": f"https://{HOST}"},
        {"origin": "http://127.0.0.1:9999"},
        {"host": "example.com"},
        {"host": "example.com:8765"},
        {"host": ""},
    ],
)
def test_other_pages_and_names_are_refused(client, headers):
    message = {"text": MIURA, "changes": [], "topology": ""}
    assert client.post("grow", json=message, headers=headers).status_code == 403
    assert client.get("start", headers=headers).status_code == 403
    assert client.get("start", headers={"origin": f"http://{HOST}"}).status_code == 200


@pytest.mark.parametrize(
    "body",
    [
        b"",
        b"{",
        b"[]",
        b"\xff\xfe",
        b"[" * 100_000,
        b'{"text": 1, "changes": [], "topology": ""}',
        b'{"text": "", "changes": {}, "topology": ""}',
        b'{"text": "", "changes": [[]], "topology": ""}',
        b'{"text": "", "changes": [[[], 1]], "topology": ""}',
        b'{"text": "", "changes": [[["a"], {}]], "topology": ""}',
        b'{"text": "", "changes": [[["a", 1], 1]], "topology": ""}',
        b'{"text": "", "changes": [], "topology": []}',
    ],
)
def test_malformed_messages_are_refused(client, body):
    assert client.post("grow", content=body).status_code == 400


def test_messages_have_a_bound(client):
    response = client.post("grow", content=b" " * 3_000_001)
    assert response.status_code == 413
    assert "3000000 bytes" in response.text


def test_a_sheet_comes_with_its_topology_once(client):
    data = grown(client, changes=SMALL)
    head, arrays = head_of(data), arrays_of(data)
    assert (head["status"], head["faces"], head["findings"]) == ("grown", 12, [])
    assert "rows = 3\n" in head["text"]
    assert arrays["folded"].shape == (20 * 3,)
    assert len(arrays["triangles"]) == 3 * 24
    assert head["boxes"]["flat"][0] == pytest.approx(200.0)
    assert np.ptp(arrays["flat"].reshape(-1, 2), axis=0).max() == pytest.approx(200.0, rel=1e-6)
    fold = [[["design", "fold_deg"], 60]]
    again = grown(client, head["text"], fold, head["topology"])
    assert set(arrays_of(again)) == {"folded", "flat"}
    assert not np.array_equal(arrays_of(again)["folded"], arrays["folded"])
    more = grown(client, head["text"], [[["design", "rows"], 4]], head["topology"])
    assert "triangles" in arrays_of(more)


def test_states_run_from_flat_to_folded(client):
    text = head_of(grown(client, changes=SMALL))["text"]
    data = ask(client, "fold", text=text)
    states = arrays_of(data)["positions"].reshape(head_of(data)["states"], -1, 3)
    assert len(states) == 11
    thickness = np.linalg.svd(states[0] - states[0].mean(axis=0), compute_uv=False)[2]
    assert thickness < 1e-4  # it is flat, whichever way it lies
    folded = arrays_of(grown(client, text))["folded"].reshape(-1, 3)
    assert np.allclose(states[-1], folded)


@pytest.mark.parametrize("path", [["design", "fold_deg"], ["sheet", "width_mm"]])
def test_whole_numbers_that_no_float_holds_are_refused(client, path):
    refused = head_of(grown(client, changes=[[path, 10**400]]))["refused"]
    assert ".".join(path) in refused


def codes_of(head):
    return [each["code"] for each in head["findings"]]


def test_a_job_is_simulated_as_by_its_command(client):
    text = head_of(grown(client, changes=SMALL))["text"]
    data = ask(client, "simulate", text=text)
    head, arrays = head_of(data), arrays_of(data)
    job = job_of_text(text, ROOT)
    made = simulate(grown_sheet(job).pattern, "miura", formats=["html"], upright=False)
    assert head["sentences"] == list(sentences(made.report))
    assert codes_of(head) == [each.code for each in made.findings]
    assert not head["wrong"]
    assert head["shares"] == pytest.approx(np.linspace(0, 1, 11))
    assert (arrays["edgesSource"] == np.arange(len(head["letters"]))).all()
    folded = arrays_of(grown(client, text))["folded"].reshape(-1, 3)
    states = arrays["positions"].reshape(11, -1, 3)
    assert norm(np.ptp(states[-1], axis=0)) == pytest.approx(norm(np.ptp(folded, axis=0)), rel=1e-3)


def test_a_base_is_simulated_in_contact_with_its_layers_in_order(client, folder):
    name = "bird_base.fold"
    (folder / name).write_bytes((PATTERNS / name).read_bytes())
    data = ask(client, "simulate", file=name)
    head, arrays = head_of(data), arrays_of(data)
    assert "folds flat: yes, its layers have 16 orders" in head["sentences"]
    assert "folded-in-contact" in codes_of(head)
    states = arrays["positions"].reshape(head["states"], -1, 3)
    thickness = np.ptp(states[-1][:, 2])
    pattern = read_pattern(folder / name)[0]
    sheet = simulated_sheet(pattern, FoldSettings()).scene("x")
    np.testing.assert_allclose(states, sheet.states_coords, atol=1e-4)
    assert thickness > 3 * sheet.layer_mm > 0  # layers are apart


def test_a_sheet_that_is_stopped_is_simulated_up_to_there(client, folder):
    pattern = folded_strip([30.0] * 3, [150.0] * 2)
    (folder / "stuck.fold").write_bytes(fold_bytes(pattern, "stuck"))
    through = head_of(ask(client, "simulate", file="stuck.fold"))
    stopped = head_of(ask(client, "simulate", file="stuck.fold", contact=True))
    assert (through["wrong"], stopped["wrong"]) == (False, True)
    assert through["shares"][-1] == 1
    for head in (through, stopped):
        assert "faces 0 and 2 press on each other from 80.0% of the fold on" in head["sentences"][0]
        finding = next(each for each in head["findings"] if each["code"] == "stopped-by-contact")
        assert finding["panels"] == [0, 2]


def test_cuts_are_open_where_a_sheet_is_simulated(client, folder):
    pattern = grid(2, 2, 20.0, cuts=[(1, 4)])
    (folder / "cut.fold").write_bytes(fold_bytes(pattern, "cut"))
    data = ask(client, "simulate", file="cut.fold")
    source = arrays_of(data)["edgesSource"]
    assert len(source) == len(pattern.edges_vertices) + 1
    assert set(source) == set(range(len(pattern.edges_vertices)))


def test_refusals_name_the_key_and_growth_that_stops_is_shown(client):
    refused = head_of(grown(client, changes=[[["design", "rows"], 1]]))["refused"]
    assert "design.rows" in refused
    assert "from 2 to" in refused
    curved = (TEMPLATES / "curved_fold.toml").read_text(encoding="utf-8")
    stops = {"columns": 10, "step": 0.2, "k_deg": 183.0, "strips": 60, "flap_angle_deg": 150.0}
    changes = [[["design", key], value] for key, value in stops.items()]
    stopped = head_of(grown(client, curved, changes))
    assert stopped["status"] != "grown"
    assert stopped["advice"]
    assert stopped["faces"] == 130
    assert stopped["findings"][0]["code"] == "growth-stopped"


def test_unknown_templates_are_refused_with_the_nearest(client):
    assert "Did you mean miura?" in head_of(ask(client, "open", template="miurra"))["refused"]
    opened = head_of(ask(client, "open", template="miura"))
    assert opened["text"] == MIURA
    assert opened["values"]["design"]["rows"] == 8


def test_pictures_are_drawn_and_kept(client):
    first = client.get("pictures/miura")
    assert first.headers["content-type"] == "image/png"
    assert first.content == client.get("pictures/miura").content
    assert client.get("pictures/no_such").status_code == 404


NUMBERS = st.floats(-1e3, 1e3) | st.integers(-5, 40) | st.sampled_from([0, 1e300, -0.0, 10**30])


@pytest.mark.parametrize("name", ["miura", "curved_fold", "brownian_ribbon", "random_tube"])
@settings(
    max_examples=12, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(data=st.data())
def test_any_parameters_give_a_sheet_or_a_refusal(client, name, data):
    opened = head_of(ask(client, "open", template=name))
    keys = [each["path"] for each in opened["fields"] if each["path"][0] == "design"]
    chosen = data.draw(st.lists(st.sampled_from(keys), min_size=1, max_size=3, unique_by=str))
    changes = [[path, data.draw(NUMBERS | st.text(max_size=5) | st.booleans())] for path in chosen]
    head = head_of(grown(client, opened["text"], changes))
    assert "lost" not in head, head
    assert ("refused" in head) != ("faces" in head)


def files_under(folder):
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in folder.rglob("*")
        if path.is_file()
    }


def test_jobs_are_saved_in_the_folder_and_nowhere_else(client, folder):
    before = files_under(folder.parent)
    for name in (
        "../out.toml",
        "/tmp/out.toml",
        "a/b.toml",
        "job.txt",
        "",
        ".",
        "\ud800.toml",
        LONG,
    ):
        head = head_of(ask(client, "save", text=MIURA, file=name))
        assert "refused" in head, name
    bad = MIURA.replace("rows = 8", "rows = true")
    assert "rows" in head_of(ask(client, "save", text=bad, file="bad.toml"))["refused"]
    assert files_under(folder.parent) == before
    assert "saved" in head_of(ask(client, "save", text=MIURA, file="own.toml"))
    assert (folder / "own.toml").read_text(encoding="utf-8") == MIURA
    other = MIURA.replace("rows = 8", "rows = 6")
    assert head_of(ask(client, "save", text=other, file="own.toml")) == {
        "exists": "own.toml",
        "arrays": [],
    }
    assert (folder / "own.toml").read_text(encoding="utf-8") == MIURA
    ask(client, "save", text=other, file="own.toml", before=MIURA)  # which it has
    assert (folder / "own.toml").read_text(encoding="utf-8") == other
    assert "exists" in head_of(ask(client, "save", text=MIURA, file="own.toml", before=MIURA))
    ask(client, "save", text=MIURA, file="own.toml", before=MIURA, replace=True)
    assert (folder / "own.toml").read_text(encoding="utf-8") == MIURA


def test_files_are_read_and_kept_within_the_folder_and_nowhere_else(client, folder):
    key = made(client, text='outputs = ["fold"]\n' + MIURA)["key"]
    before = files_under(folder.parent)
    for into in ("..", "../out", "/tmp/studio_out", "a/../../out"):
        assert "is outside" in head_of(ask(client, "keep", key=key, into=into))["refused"]
    assert "is outside" in head_of(ask(client, "read", file="../x.fold", topology=""))["refused"]
    for stock in ({"material": "../m.toml"}, {"machine": "/tmp/m.toml"}, {"material": ""}):
        message = {"material": "card_300gsm", "machine": "co2_60w_600x400", **stock}
        assert "refused" in head_of(ask(client, "make", command="fabricate", text=MIURA, **message))
    for address in (f"{key}/x.fold", f"{key}/..%2fmiura.png", f"{'0' * 16}/miura.fold"):
        assert client.get(f"made/{address}").status_code == 404
    assert "gone" in head_of(ask(client, "keep", key="0" * 16, into="out"))["refused"]
    assert files_under(folder.parent) == before


def test_stock_is_offered_with_what_the_user_mostly_takes(client):
    assert set(head_of(ask(client, "stock"))["usual"].values()) == {None}
    path = set_preference("machine", "knife_a4")
    try:
        found = head_of(ask(client, "stock"))
        assert found["usual"]["machine"] == "knife_a4"
        assert "knife_a4" in [each["name"] for each in found["stock"]["cutter"]]
        path.write_text("machine = 1", encoding="utf-8")
        assert head_of(ask(client, "stock"))["usual"] == {}
    finally:
        path.unlink()


def test_only_the_last_few_exports_are_held(client):
    text = 'outputs = ["fold"]\n' + MIURA
    keys = [made(client, text=text)["key"] for _ in range(9)]
    assert client.get(f"made/{keys[0]}/miura.fold").status_code == 404
    assert client.get(f"made/{keys[1]}/miura.fold").status_code == 200


def test_pages_that_were_made_are_cut_off_from_the_studio(client):
    found = made(client, text='outputs = ["fold", "html"]\n' + MIURA)
    page = client.get(f"made/{found['key']}/{found['page']}")
    assert page.text.startswith("<!DOCTYPE html>")
    policy = page.headers["content-security-policy"]
    assert policy.startswith("sandbox allow-scripts")
    assert "allow-same-origin" not in policy
    assert "'self'" in policy.partition("frame-ancestors")[2]


def made(client, command="run", **message):
    head = head_of(ask(client, "make", command=command, **message))
    assert "key" in head, head
    return head


def archive_of(client, key):
    with zipfile.ZipFile(io.BytesIO(client.get(f"made/{key}/all.zip").content)) as package:
        return {each: package.read(each) for each in package.namelist()}


def test_sheets_and_panels_are_what_the_commands_make_of_the_pattern(client, folder):
    """Of a job's pattern, and of one in a file of the folder; with stock of the folder."""
    text = head_of(grown(client, changes=SMALL))["text"]
    fold = archive_of(client, made(client, text='outputs = ["fold"]\n' + text)["key"])["miura.fold"]
    home = folder / "stock"
    home.mkdir()
    (folder / "miura.fold").write_bytes(fold)
    own = shipped("materials")["card_300gsm"].read_text().replace("Card, 300", "Own card, 300")
    (folder / "own_card.toml").write_text(own, encoding="utf-8")
    names = [each["name"] for each in head_of(ask(client, "stock"))["stock"]["sheet"]]
    assert names[0] == "acrylic_2mm"
    assert names[-1] == "own_card.toml"
    sheets = {"material": "own_card.toml", "machine": "co2_60w_600x400", "copies": 2}
    options = ["--material", folder / "own_card.toml", "--machine", sheets["machine"]]
    expected = run_command("fabricate", folder / "miura.fold", home, *options, "--copies", 2)
    for source in ({"text": text}, {"file": "miura.fold"}):
        found = made(client, "fabricate", **source, **sheets)
        assert found["page"] == "miura_sheets.html"
        assert archive_of(client, found["key"]) == expected
    printers = {"printer": "prusa_mk4s", "print_material": "pla_filament"}
    options = ["--printer", printers["printer"], "--material", printers["print_material"]]
    own = ["panels.gap_mm=0.8", "hinges.web_mm=0.4", "hinges.relief_mm=0.3"]  # of the job
    options += [word for each in own for word in ("--set", each)]
    expected = run_command("thicken", folder / "miura.fold", folder / "thick", *options)
    by_job = "".join([text, "\n[printer]\nmachine = 'prusa_mk4s'\nmaterial = 'pla_filament'\n"])
    found = made(client, "thicken", text=by_job)
    assert without_seconds(archive_of(client, found["key"])) == without_seconds(expected)
    by_file = made(client, "thicken", file="miura.fold", **printers)
    report = json.loads(archive_of(client, by_file["key"])["miura_thick_report.json"])
    named = {"machine": "prusa_mk4s", "material": "pla_filament"}
    assert report["settings"]["printer"].items() >= named.items()
    assert report["printer"]["nozzle_mm"] == 0.4
    assert "only a job" in head_of(ask(client, "make", command="run", file="miura.fold"))["refused"]


def run_command(command, file, out, *options):
    arguments = [command, file, "--out", out, *options]
    assert CliRunner().invoke(main, [*map(str, arguments)]).exit_code in (0, 1)
    return {path.name: path.read_bytes() for path in out.iterdir()}


def without_seconds(files):
    """Files as they are, but reports as values without their durations."""
    reports = {name: json.loads(data) for name, data in files.items() if name.endswith(".json")}
    for report in reports.values():
        report.pop("seconds", None)
    return {**files, **reports}


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("miura", SMALL),
        ("curved_fold", [[["design", "columns"], 12], [["design", "strips"], 3]]),
        ("brownian_ribbon", []),
    ],
)
def test_what_is_exported_is_what_run_makes_of_the_saved_job(client, folder, name, changes):
    opened = head_of(ask(client, "open", template=name))
    text = head_of(grown(client, opened["text"], changes))["text"]
    ask(client, "save", text=text, file=f"{name}.toml")
    found = made(client, text=text)
    ask(client, "keep", key=found["key"], into=f"studio/{name}")
    ran = without_seconds(run_command("run", folder / f"{name}.toml", folder / "run" / name))
    kept = {path.name: path.read_bytes() for path in (folder / "studio" / name).iterdir()}
    assert [each for each, _ in found["files"]] == list(packed := archive_of(client, found["key"]))
    assert without_seconds(packed) == without_seconds(kept) == ran


def test_dropped_patterns_are_kept_and_read(client, folder):
    data = made_fold(client)
    for number, name in enumerate(["../up/miura x.fold", "miura x.fold"]):
        head = head_of(client.post("drop", params={"name": name}, content=data).content)
        assert (head["file"], head["text"]) == ("miura_x.fold", None), number
    assert (folder / "miura_x.fold").read_bytes() == data
    read = ask(client, "read", file="miura_x.fold", topology="")
    assert (head_of(read)["status"], head_of(read)["faces"]) == ("read", 12)
    states = ask(client, "read", file="miura_x.fold", states=True)
    assert head_of(states)["states"] == 11
    other = head_of(client.post("drop", params={"name": "miura_x.fold"}, content=b"{}").content)
    assert other["file"] == "miura_x_2.fold"
    assert "refused" in head_of(ask(client, "read", file="miura_x_2.fold", topology=""))


def made_fold(client):
    text = head_of(grown(client, changes=SMALL))["text"]
    return archive_of(client, made(client, text='outputs = ["fold"]\n' + text)["key"])["miura.fold"]


def test_dropped_surfaces_come_with_a_job_and_others_are_refused(client, folder):
    head = head_of(client.post("drop", params={"name": "a.stl"}, content=b"solid").content)
    assert job_of_text(head["text"], folder).design.surface == head["file"] == "a.stl"
    assert "refused" in head_of(grown(client, head["text"]))
    for name in ("old.orh", "packed.svgz"):  # patterns, as every format that is read
        kept = head_of(client.post("drop", params={"name": name}, content=b"x").content)
        assert (kept["file"], kept["text"]) == (name, None)
    before = files_under(folder.parent)
    for name in ("x.exe", "x", "", ".fold", "x.toml"):
        head = head_of(client.post("drop", params={"name": name}, content=b"x").content)
        assert "must end in one of" in head["refused"]
    large = client.post("drop", params={"name": "large.stl"}, content=b" " * 50_000_001)
    assert large.status_code == 413
    assert client.post("drop", content=b"").status_code == 400
    assert files_under(folder.parent) == before


def test_a_port_that_is_taken_is_passed_over():
    with free_socket(20_000) as first:
        port = first.getsockname()[1]
        assert first.getsockname()[0] == "127.0.0.1"
        with free_socket(port) as second:
            assert port < second.getsockname()[1] < port + 50


def test_the_script_is_made_of_the_sources_beside_it():
    """Run `npm install && npm run build` in fab/viewing/page_source after a change."""
    digest = hashlib.sha256()
    for wing in ("viewing", "studio"):
        for source in sorted((ROOT / "fab" / wing / "page_source").glob("*.js")):
            digest.update(source.read_bytes())
    script = (ROOT / "fab" / "studio" / "page_assets" / "studio.js").read_text(encoding="utf-8")
    assert script.startswith(f"/* sources {digest.hexdigest()} */")
    assert len(script) < 100_000  # what it draws with is in views.js
