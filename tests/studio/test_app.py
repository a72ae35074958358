"""What the studio answers, and what it refuses: by token, origin, size, form and place."""

import hashlib
import io
import json
import zipfile

import numpy as np
import pytest
from click.testing import CliRunner
from helpers import ROOT, TEMPLATES
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from starlette.testclient import TestClient
from studio_answers import arrays_of, head_of, rest_of

from fab.cli.group import main
from fab.studio.app import Studio, studio_app
from fab.studio.job_text import job_of_text
from fab.studio.serving import free_socket

HOST = "127.0.0.1:8765"
MIURA = (TEMPLATES / "miura.toml").read_text(encoding="utf-8")
SMALL = [[["design", "columns"], 4], [["design", "rows"], 3]]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("studio")


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
    for name in ("../out.toml", "/tmp/out.toml", "a/b.toml", "job.txt", "", ".", "\ud800.toml"):
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
    ask(client, "save", text=other, file="own.toml", replace=True)
    assert (folder / "own.toml").read_text(encoding="utf-8") == other


def test_files_are_made_within_the_folder_and_nowhere_else(client, folder):
    before = files_under(folder.parent)
    for into in ("..", "../out", "/tmp/studio_out"):
        assert "is outside" in head_of(ask(client, "make", text=MIURA, into=into))["refused"]
    assert "is outside" in head_of(ask(client, "read", file="../x.fold", topology=""))["refused"]
    assert files_under(folder.parent) == before


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
    archive = ask(client, "make", text=text, into=None)
    wrote = head_of(ask(client, "make", text=text, into=f"studio/{name}"))
    arguments = ["run", str(folder / f"{name}.toml"), "--out", str(folder / "run" / name)]
    assert CliRunner().invoke(main, arguments).exit_code in (0, 1)
    ran = {path.name: path.read_bytes() for path in (folder / "run" / name).iterdir()}
    with zipfile.ZipFile(io.BytesIO(rest_of(archive))) as package:
        packed = {each: package.read(each) for each in package.namelist()}
    written = {path.name: path.read_bytes() for path in (folder / "studio" / name).iterdir()}
    assert {each for each, _ in wrote["files"]} == set(written) == set(packed) == set(ran)
    for made in (packed, written):
        reports = [json.loads(each.pop("report.json")) for each in (made, dict(ran))]
        for report in reports:
            del report["seconds"]
        assert reports[0] == reports[1]
        assert made == {each: data for each, data in ran.items() if each != "report.json"}


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
    archive = ask(client, "make", text='outputs = ["fold"]\n' + text, into=None)
    with zipfile.ZipFile(io.BytesIO(rest_of(archive))) as package:
        return package.read("miura.fold")


def test_dropped_surfaces_come_with_a_job_and_others_are_refused(client, folder):
    head = head_of(client.post("drop", params={"name": "a.stl"}, content=b"solid").content)
    assert job_of_text(head["text"], folder).design.surface == head["file"] == "a.stl"
    assert "refused" in head_of(grown(client, head["text"]))
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
