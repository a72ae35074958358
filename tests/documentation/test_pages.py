"""Pages of the documentation: what they name exists, and what they show runs."""

import io
import json
import re
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path

import click
import pytest
from click.testing import CliRunner
from helpers import DOCS, PATTERNS, ROOT, TEMPLATE_NAMES
from PIL import Image

from fab.catalogue import PAPER, shipped_picture, template_groups
from fab.cli.group import main
from fab.findings import explained
from fab.jobs.job import Job
from fab.jobs.job_formats import Format
from fab.settings import Settings, alternatives

sys.path.insert(0, str(DOCS))
from made_pages import pages
from made_pages.keys import missing_texts
from made_pages.links import broken_links
from made_pages.markdown import docstring

WRITTEN = [
    path
    for path in sorted(
        [ROOT / "README.md", ROOT / ".github" / "CONTRIBUTING.md", *DOCS.rglob("*.md")]
    )
    if "made" not in path.relative_to(ROOT).parts
]
NAMES = [str(path.relative_to(ROOT)) for path in WRITTEN]


def blocks(text: str, language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", text, re.DOTALL | re.MULTILINE)


@pytest.fixture(scope="module")
def made():
    return pages({"miura"})


@pytest.mark.parametrize("name", NAMES)
def test_links_lead_somewhere(name, made):
    page = ROOT / name
    text = page.read_text("utf-8")
    for target in re.findall(
        r"\]\(([^)\s]+)\)", re.sub(r"```.*?```|`[^`\n]*`", "", text, flags=re.DOTALL)
    ):
        if re.match(r"https?:", target):
            continue
        place, _, anchor = target.partition("#")
        if place.startswith(("made/", "../made/")):
            assert place.partition("made/")[2] in made, target
        elif place:
            assert (page.parent / place).exists(), target
        if anchor.startswith("finding-"):
            assert anchor.removeprefix("finding-") in explained(), target


@pytest.mark.parametrize("name", NAMES)
def test_files_of_the_project_that_are_named_exist(name):
    text = (ROOT / name).read_text("utf-8")
    for place in re.findall(r"`((?:tests|fab|solver|templates)/[\w./]*)`", text):
        assert (ROOT / place).exists(), place


def commands_of(text: str) -> list[list[str]]:
    lines = [line for block in blocks(text, "sh") for line in block.splitlines()]
    return [shlex.split(line, comments=True)[1:] for line in lines if line.startswith("quadfold ")]


@pytest.mark.parametrize("name", NAMES)
def test_commands_have_the_options_and_keys_that_they_are_given(name):
    for words in commands_of((ROOT / name).read_text("utf-8")):
        if words == ["--version"]:
            continue
        command = main.commands[words[0]]
        context = command.make_context(words[0], list(words[1:]), resilient_parsing=False)
        for change in context.params.get("changes") or ():
            require_key(change.partition("=")[0].split("."))
        if words[0] == "run":
            for kinds in context.params.get("only") or ():
                assert set(kinds.split(",")) <= {each.value for each in Format}


def require_key(path: list[str]) -> None:
    """A key of a job; those of designs are checked by the models of designs."""
    model: type[Settings] = Job
    for part in path:
        assert part in model.model_fields, path
        inner = alternatives(model.model_fields[part].annotation)
        if part == "design" or len(inner) > 1:  # a choice of tables
            return
        if isinstance(inner[0], type) and issubclass(inner[0], Settings):
            model = inner[0]


@pytest.mark.parametrize("name", NAMES)
def test_code_blocks_are_what_they_say(name):
    text = (ROOT / name).read_text("utf-8")
    for block in blocks(text, "toml"):
        assert tomllib.loads(block)
    for block in blocks(text, "python"):
        compile(block, name, "exec")


def run(line: list[str]) -> click.testing.Result:
    result = CliRunner().invoke(main, line)
    assert result.exit_code == 0, (line, result.output)
    return result


@pytest.mark.parametrize("name", ["laser", "printer"])
def test_the_first_steps_of_makers_are_taken(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = (DOCS / "start" / f"{name}.md").read_text("utf-8")
    for words in commands_of(text):
        fast = ["--only", "stl,html"] if words[0] == "thicken" and "--suggest" not in words else []
        run([*words, *fast])
    for file in re.findall(r"`((?:sheets|solid)/[\w.]+)`", text):
        if not file.endswith(".3mf"):
            assert Path(file).is_file(), file


def test_the_first_steps_of_scripts_are_taken(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = (DOCS / "start" / "scripts.md").read_text("utf-8")
    (line,) = commands_of(text)
    assert json.loads(run(line).stdout)["counts"]["faces"] == 60
    first, best = blocks(text, "python")
    done = subprocess.run([sys.executable, "-c", first], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1].endswith("] True")
    assert {path.name for path in Path("out").iterdir()} >= {"screen.fold", "screen.svg"}
    Path("best.py").write_text(best)
    subprocess.run([sys.executable, "best.py"], capture_output=True, text=True, check=True)
    assert {path.name for path in Path("out/best").iterdir()} == {"m.svg", "m_report.json"}
    report = json.loads(Path("out/best/m_report.json").read_text())
    assert report["job"]["design"]["fold_deg"] == 30.0  # folded less, the pleats are lower


def test_the_job_and_the_drawing_of_the_how_tos_are_taken(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    run(["convert", str(PATTERNS / "square_twist.fold"), "twist.svg"])
    (first, cut, *_) = commands_of((DOCS / "howto" / "svg.md").read_text("utf-8"))
    run(first)
    run([*cut, "--only", "dxf"])
    (toml,) = blocks((DOCS / "howto" / "own_surface.md").read_text("utf-8"), "toml")
    assert Job.model_validate(tomllib.loads(toml)).sheet.folded_width_mm == 300.0


def test_every_key_says_what_it_is():
    assert missing_texts() == []


def test_pages_from_code_have_everything(made):
    for name in main.commands:
        assert f"(quadfold-{name})=" in made["commands.md"]
    for code in explained():
        assert f"(finding-{code})=" in made["findings.md"]
    for name in TEMPLATE_NAMES:
        assert f"gallery/{name}.md" in made
    assert "results/miura.html" in made["gallery/miura.md"]
    assert "results/" not in made["gallery/curved_fold.md"]
    for name, text in made.items():
        assert not re.search(
            r"\bNone\b.*\bPydanticUndefined|<object|<function|0x[0-9a-f]{6}", text
        ), name


def test_docstrings_become_markdown():
    text = (
        "Head with x[0..m] and *.\n\nwidth, height : of it,\n    in mm.\nrest : what.\n\n"
        "    a = b\n\n>>> 1\n1"
    )
    assert docstring(text) == (
        "Head with x\\[0..m\\] and \\*.\n\n"
        "- `width`, `height`: of it,\n  in mm.\n- `rest`: what.\n\n"
        "```text\na = b\n```\n\n```pycon\n>>> 1\n1\n```"
    )


def test_broken_links_of_a_site_are_found(tmp_path):
    (tmp_path / "a.html").write_text(
        '<h1 id="here">A</h1><a class="x" href="b.html#there">b</a><a href="#here">h</a>'
        '<a href="#gone">g</a><a href="c.html">c</a><img alt="" src="https://example.com/x.png">'
        '<a href="https://example.com">fine</a>'
    )
    (tmp_path / "b.html").write_text('<p id="there">')
    assert list(broken_links(tmp_path)) == [
        "a.html: #gone has no such place",
        "a.html: c.html leads nowhere",
        "a.html loads https://example.com/x.png",
    ]


def test_every_template_is_in_one_group_and_has_a_picture():
    groups = template_groups()
    every = [name for names in groups.values() for name in names]
    assert sorted(every) == TEMPLATE_NAMES
    assert list(groups)[-1] == PAPER
    for name in every:
        with Image.open(io.BytesIO(shipped_picture(name).read_bytes())) as image:
            assert image.size == (480, 360)
            assert len(image.convert("RGB").getcolors(480 * 360)) > 3
