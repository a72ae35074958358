"""The studio in a real browser, served by the command itself."""

import io
import os
import re
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
from browser import chromium
from helpers import ROOT, TEMPLATES
from PIL import Image

RIM = 12


@pytest.fixture(scope="module")
def browser():
    with chromium() as started:
        yield started


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("studio")
    text = (TEMPLATES / "miura.toml").read_text(encoding="utf-8")
    (made / "own.toml").write_text(text.replace("columns = 10 ", "columns = 6 "), encoding="utf-8")
    return made


class Served:
    """The command, and the address that it prints."""

    def __init__(self, folder, *arguments):
        self.process = subprocess.Popen(
            [sys.executable, "-m", "fab", "studio", "--no-browser", *arguments],
            cwd=folder,
            env={**os.environ, "PYTHONPATH": str(ROOT), "PYTHONUNBUFFERED": "1"},
            stdout=subprocess.PIPE,
            text=True,
        )
        guard = threading.Timer(60, self.process.kill)
        guard.start()
        self.address = ""
        for line in self.process.stdout:
            found = re.search(r"http://127\.0\.0\.1:\d+/[\w-]{32}/", line)
            if found:
                self.address = found.group()
                break
        guard.cancel()
        assert self.address

    def end(self):
        self.process.send_signal(signal.SIGINT)
        said, _ = self.process.communicate(timeout=30)
        return self.process.returncode, said


@pytest.fixture(scope="module")
def served(browser, folder):
    made = Served(folder, "own.toml")
    yield made
    assert made.end()[0] == 0


@pytest.fixture
def page(browser, served):
    """The studio with a job, in a tab of its own; whatever the browser complains about fails."""
    context = browser.new_context(viewport={"width": 1400, "height": 1000}, accept_downloads=True)
    made = context.new_page()
    complaints, foreign = [], []
    made.on("pageerror", lambda error: complaints.append(str(error)))
    made.on(
        "console",
        lambda message: (
            complaints.append(message.text)
            if message.type in ("error", "warning") and "ReadPixels" not in message.text
            else None
        ),
    )
    made.on(
        "request",
        lambda request: (
            foreign.append(request.url)
            if not request.url.startswith((served.address, "blob:", "data:"))
            else None
        ),
    )
    made.goto(served.address)
    wait_until(made, lambda: verdict(made).startswith("grown"))
    wait_until(made, made.locator("#fold").is_enabled)  # its states have come
    yield made
    context.close()
    assert complaints == []
    assert foreign == []


def wait_until(page, true):
    until = time.monotonic() + 30
    while not true():
        assert time.monotonic() < until
        page.wait_for_timeout(50)


def verdict(page):
    return page.locator("#verdict").text_content()


def put(page, key, value):
    page.locator(f'[data-key="{key}"]').fill(str(value))


def shot(page):
    page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    picture = Image.open(io.BytesIO(page.locator("#form-view canvas").screenshot())).convert("RGB")
    return np.asarray(picture)[RIM:-RIM, RIM:-RIM]


def differ(first, second):
    return (first != second).any(axis=2).mean()


def test_a_value_changes_form_and_pattern(page):
    assert page.locator("#title").text_content() == "miura"
    assert verdict(page) == "grown: 48 faces."
    before = shot(page)
    lines = page.locator('#pattern g[data-layer="M"] path').get_attribute("d")
    put(page, "design.rows", 4)
    wait_until(page, lambda: verdict(page) == "grown: 24 faces.")
    assert differ(before, shot(page)) > 0.02
    fewer = page.locator('#pattern g[data-layer="M"] path').get_attribute("d")
    assert 0 < fewer.count("M") < lines.count("M")
    slider = page.get_by_label("fold_deg, slider")
    between = shot(page)
    slider.evaluate("(s) => { s.value = 80; s.dispatchEvent(new Event('input')); }")
    wait_until(page, lambda: "fold_deg = 80.0 " in page.locator("#text").input_value())
    assert page.locator('[data-key="design.fold_deg"]').input_value() == "80"
    assert differ(between, shot(page)) > 0.02


def test_the_slider_folds_the_sheet(page):
    seen = []
    for share, name in ((1, "folded"), (0.5, "50% of the fold"), (0, "flat")):
        page.locator("#fold").evaluate(
            "(s, share) => { s.value = share; s.dispatchEvent(new Event('input')); }", share
        )
        assert page.locator("#state").text_content() == name
        seen.append(shot(page))
    assert differ(seen[0], seen[1]) > 0.01
    assert differ(seen[1], seen[2]) > 0.01


def test_a_refused_value_is_named_and_the_last_good_form_kept(page):
    before = shot(page)
    put(page, "design.columns", 0)
    wait_until(page, lambda: page.locator("#notice").is_visible())
    assert "design.columns" in page.locator("#notice").text_content()
    assert page.locator('[data-key="design.columns"]').get_attribute("aria-invalid") == "true"
    assert page.locator("#save").is_disabled()
    assert verdict(page).startswith("Not grown")
    assert differ(before, shot(page)) < 0.001
    put(page, "design.columns", 6)
    wait_until(page, lambda: verdict(page) == "grown: 48 faces.")
    assert not page.locator("#notice").is_visible()
    assert page.locator("#save").is_enabled()


def test_the_size_that_is_given_takes_the_place_of_the_other(page):
    put(page, "sheet.folded_width_mm", 100)
    wait_until(page, lambda: re.search(r"folded.* 100 ", page.locator("#sizes").text_content()))
    assert page.locator('[data-key="sheet.width_mm"]').input_value() == ""


def test_the_job_is_saved_with_its_comments(page, folder):
    put(page, "design.rows", 5)
    wait_until(page, lambda: verdict(page) == "grown: 30 faces.")
    page.locator("#save").click()  # over the file that it was opened from
    wait_until(page, lambda: "saved" in page.locator("#made").text_content())
    saved = (folder / "own.toml").read_text(encoding="utf-8")
    assert "rows = 5\n" in saved
    assert "# acute angle of the parallelograms" in saved
    page.locator('[data-key="design.rows"]').fill("8")
    wait_until(page, lambda: verdict(page) == "grown: 48 faces.")
    page.locator("#save").click()
    wait_until(page, lambda: "rows = 8\n" in (folder / "own.toml").read_text(encoding="utf-8"))


def test_all_files_are_made_as_a_zip(page, folder):
    page.locator("#source summary").click()
    text = page.locator("#text").input_value()
    page.locator("#text").fill('outputs = ["fold", "svg"]\n' + text)
    page.locator("#apply").click()
    wait_until(page, lambda: verdict(page) == "grown: 48 faces.")
    wait_until(page, lambda: "outputs" in page.locator("#text").input_value())
    with page.expect_download(timeout=60_000) as loaded:
        page.locator("#make-zip").click()
    assert loaded.value.suggested_filename == "miura.zip"
    listed = page.locator("#made-files").text_content()
    for name in ("miura.fold", "miura.svg", "report.json"):
        assert name in listed
    page.locator("#into").fill("files")
    page.locator("#make-folder").click()
    wait_until(page, lambda: "wrote into" in page.locator("#made").text_content())
    made = {path.name for path in (folder / "files").iterdir()}
    assert made == {"miura.fold", "miura.svg", "report.json"}


def test_the_gallery_shows_pictures_and_opens_a_template(page):
    page.locator("#to-gallery").click()
    first = page.locator(".card").first
    image = first.locator("img")
    wait_until(page, lambda: image.evaluate("(each) => each.naturalWidth") == 480)
    name = first.locator("strong").text_content()
    first.click()
    wait_until(page, lambda: page.locator("#save-name").input_value() == f"{name}.toml")
    wait_until(page, lambda: verdict(page).startswith("grown"))


def test_a_pattern_is_dropped_and_folds(page, folder):
    page.locator("#to-gallery").click()
    page.locator("#file").set_input_files(folder / "files" / "miura.fold")  # of the test above
    wait_until(page, lambda: verdict(page).startswith("read: 48 faces"))
    wait_until(page, page.locator("#fold").is_enabled)
    assert page.locator("#title").text_content() == "miura.fold"
    assert not page.locator("#form").is_visible()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_no_fault_of_accessibility(page, scheme):
    axe = pytest.importorskip("axe_playwright_python.sync_playwright")
    page.emulate_media(color_scheme=scheme)
    violations = axe.Axe().run(page).response["violations"]
    assert [(each["id"], [n["html"][:200] for n in each["nodes"]]) for each in violations] == []
