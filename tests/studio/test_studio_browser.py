"""The studio in a real browser, served by the command itself."""

import re

import pytest
from folded_strips import folded_strip
from helpers import PATTERNS, ROOT
from studio_pages import differ, make, put, shot, verdict, wait_until

from fab.formats.fold.writer import fold_bytes


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


def simulated(page):
    return page.locator("#simulated").text_content()


def test_the_fold_is_simulated_until_the_sheet_changes(page):
    page.locator("#simulate").click()
    wait_until(page, lambda: "Folds rigidly" in simulated(page))
    assert page.locator("#state").text_content() == "folded"
    folded = shot(page)
    page.locator("#fold").evaluate("(s) => { s.value = 0.5; s.dispatchEvent(new Event('input')); }")
    assert page.locator("#state").text_content() == "50% of the fold"
    assert differ(folded, shot(page)) > 0.01
    put(page, "design.rows", 4)
    wait_until(page, lambda: verdict(page) == "grown: 24 faces.")
    assert simulated(page) == ""


def test_contact_that_stops_a_sheet_is_named_and_shown(page, tmp_path):
    file = tmp_path / "stuck.fold"
    file.write_bytes(fold_bytes(folded_strip([30.0] * 3, [150.0] * 2), "stuck"))
    page.locator("#to-gallery").click()
    page.locator("#file").set_input_files(file)
    wait_until(page, lambda: verdict(page).startswith("read: 3 faces"))
    page.locator("#contact").check()
    page.locator("#simulate").click()
    assert page.locator("#make").is_disabled()  # one thing at a time
    wait_until(page, lambda: "press on each other from 80.0%" in simulated(page))
    assert page.locator("#make").is_enabled()
    assert page.locator("#simulated .verdict.error").count() == 1
    assert "stopped-by-contact" in page.locator("#findings").text_content()
    before = shot(page)
    page.get_by_label("Show stopped-by-contact").click()
    assert differ(before, shot(page)) > 0.01


def test_a_simulation_is_cancelled(page):
    page.locator("#to-gallery").click()
    page.locator("#file").set_input_files(PATTERNS / "crane.fold")
    wait_until(page, lambda: verdict(page).startswith("read"))
    page.locator("#simulate").click()
    wait_until(page, lambda: page.locator("#simulating .stage").text_content() != "begins …")
    page.locator("#simulating button").click()
    wait_until(page, lambda: simulated(page) == "Cancelled.")
    assert page.locator("#simulate").is_enabled()
    assert not page.locator("#simulating").is_visible()


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
    wait_until(page, lambda: "saved" in page.locator("#saved").text_content())
    saved = (folder / "own.toml").read_text(encoding="utf-8")
    assert "rows = 5\n" in saved
    assert "# acute angle of the parallelograms" in saved
    page.locator('[data-key="design.rows"]').fill("8")
    wait_until(page, lambda: verdict(page) == "grown: 48 faces.")
    page.locator("#save").click()
    wait_until(page, lambda: "rows = 8\n" in (folder / "own.toml").read_text(encoding="utf-8"))


def test_all_files_are_made_looked_at_and_kept(page, folder):
    page.locator("#source summary").click()
    text = page.locator("#text").input_value()
    page.locator("#text").fill('outputs = ["fold", "svg", "html"]\n' + text)
    page.locator("#apply").click()
    wait_until(page, lambda: "outputs" in page.locator("#text").input_value())
    wait_until(page, lambda: verdict(page) == "grown: 48 faces.")
    make(page)
    names = {"miura.fold", "miura.svg", "miura.html", "miura_report.json"}
    assert {link.text_content() for link in page.locator("#made-files a").all()} == names
    frame = page.frame_locator("#result iframe")
    frame.locator("canvas").wait_for(timeout=30_000)
    assert frame.locator("h1").text_content() == "miura"
    for link, name in (("#zip", "miura.zip"), ("#made-files a >> nth=0", "miura.fold")):
        with page.expect_download(timeout=30_000) as loaded:
            page.locator(link).click()
        assert loaded.value.suggested_filename == name
    assert loaded.value.path().read_bytes().startswith(b"{")
    page.locator("#into").fill("files")
    page.locator("#keep").click()
    wait_until(page, lambda: "wrote into" in page.locator("#made").text_content())
    assert {path.name for path in (folder / "files").iterdir()} == names


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
    assert page.title() == "miura.fold - quadfold studio"
    assert not page.locator("#form").is_visible()


def test_a_job_is_dropped_and_its_text_is_shown(page, folder, tmp_path):
    text = (folder / "own.toml").read_text(encoding="utf-8").replace("rows = 8", "rows = 3")
    (tmp_path / "other.toml").write_text(text, encoding="utf-8")
    page.locator("#to-gallery").click()
    page.locator("#file").set_input_files(tmp_path / "other.toml")
    wait_until(page, lambda: verdict(page) == "grown: 18 faces.")
    assert page.locator("#save-name").input_value() == "other.toml"
    assert page.locator("#text").input_value() == text
    assert not (folder / "other.toml").exists()  # until it is saved
    (tmp_path / "broken.toml").write_text("name = ", encoding="utf-8")
    page.locator("#file").set_input_files(tmp_path / "broken.toml")
    wait_until(page, lambda: page.locator("#notice").is_visible())
    assert page.locator("#text").input_value() == text  # the job before it stays
    page.keyboard.press("Escape")
    assert not page.locator("#notice").is_visible()
    page.locator("#save-name").fill("../other.toml")
    page.locator("#save").click()
    page.locator("#notice").click()
    assert not page.locator("#notice").is_visible()


def test_a_file_that_cannot_be_read_shows_nothing_of_the_last_sheet(page, tmp_path):
    assert page.locator("#sizes").text_content() != ""
    (tmp_path / "broken.fold").write_text('{"vertices_coords": []}', encoding="utf-8")
    page.locator("#to-gallery").click()
    page.locator("#file").set_input_files(tmp_path / "broken.fold")
    wait_until(page, lambda: verdict(page) == "Not grown")
    assert "at least 3 points" in page.locator("#notice").text_content()
    assert page.locator("#sizes").text_content() == ""
    assert page.locator("#state").text_content() == ""
    assert not page.locator("#form-view canvas").is_visible()
    assert not page.locator('#pattern g[data-layer="B"]').is_visible()


def test_a_pattern_without_a_folded_form_is_called_flat(page):
    page.locator("#to-gallery").click()
    page.locator("#file").set_input_files(ROOT / "tests" / "patterns" / "miura.fold")
    wait_until(page, lambda: verdict(page).startswith("read: 40 faces"))
    assert page.locator("#state").text_content() == "flat: the file has no folded form"
    assert page.locator("#form-view canvas").is_visible()


def test_the_gallery_fits_the_width_of_a_phone(page):
    page.set_viewport_size({"width": 390, "height": 800})
    page.locator("#to-gallery").click()
    root = page.locator("html")
    assert root.evaluate("(each) => each.scrollWidth - each.clientWidth") == 0


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_no_fault_of_accessibility(page, scheme):
    axe = pytest.importorskip("axe_playwright_python.sync_playwright")
    page.emulate_media(color_scheme=scheme)
    violations = axe.Axe().run(page).response["violations"]
    assert [(each["id"], [n["html"][:200] for n in each["nodes"]]) for each in violations] == []
