"""Walks through the studio as users take them: what goes wrong is told, and nothing is lost."""

import os
import signal
from base64 import b64encode
from pathlib import Path

import pytest
from helpers import TEMPLATES
from studio_pages import make, put, shot, studio_tab, verdict, wait_until

AXE = "axe_playwright_python.sync_playwright"
DROP = """([name, base64]) => {
  const bytes = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
  const data = new DataTransfer();
  data.items.add(new File([bytes], name));
  for (const kind of ["dragenter", "dragover", "drop"]) {
    const event = new DragEvent(kind, { dataTransfer: data, bubbles: true, cancelable: true });
    document.querySelector("main").dispatchEvent(event);
    if (kind === "dragover" && !event.defaultPrevented) throw new Error("it takes no files");
  }
}"""
NAMED = """(({ tagName, id, value, dataset, textContent, name }) =>
  [tagName, id || dataset.template || dataset.key || value || textContent].join(" ").trim()
)(document.activeElement)"""
PAINTED = """(share) => new Promise((done) => {
  const slider = document.querySelector("#fold");
  slider.value = share;
  slider.dispatchEvent(new Event("input"));
  requestAnimationFrame(() => setTimeout(done));
})"""


@pytest.fixture(scope="module")
def tetrahedron(folder):
    """A hill of four triangles as an OBJ file of the user's."""
    made = folder.parent / "hill.obj"
    corners = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 1 0.4\n"
    made.write_text(corners + "f 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n", encoding="utf-8")
    return made


def drop(page, name, data):
    page.evaluate(DROP, [name, b64encode(data).decode()])


def notice(page):
    return page.locator("#notice").text_content()


def open_template(page, name):
    page.locator("#to-gallery").click()
    page.locator(f"[data-template={name}]").click()
    wait_until(page, lambda: page.locator("#save-name").input_value() == f"{name}.toml")
    wait_until(page, lambda: verdict(page).startswith("grown"))


def workers(process):
    """Numbers of the processes that a studio has started, by any of its threads."""
    tasks = Path(f"/proc/{process}/task").glob("*/children")
    listed = [int(child) for each in tasks for child in each.read_text().split()]
    return [each for each in listed if b"spawn_main" in Path(f"/proc/{each}/cmdline").read_bytes()]


def test_a_surface_is_dropped_and_a_sheet_follows_it(page, tetrahedron, folder):
    drop(page, "hill.obj", tetrahedron.read_bytes())
    wait_until(page, lambda: page.locator("#title").text_content() == "hill")
    wait_until(page, lambda: verdict(page).startswith("grown"))
    assert page.locator('[data-key="design.surface"]').input_value() == "hill.obj"
    assert (folder / "hill.obj").read_bytes() == tetrahedron.read_bytes()
    drop(page, "x.exe", b"MZ")
    wait_until(page, lambda: "must end in one of" in notice(page))
    assert verdict(page).startswith("grown")  # the work is still there


def test_sheets_are_made_of_stock_of_the_folder(page, folder):
    own = (TEMPLATES / "materials" / "card_300gsm.toml").read_text(encoding="utf-8")
    (folder / "own_card.toml").write_text(own, encoding="utf-8")
    page.reload()
    wait_until(page, lambda: verdict(page).startswith("grown"))
    page.get_by_label("thick panels").check()
    assert page.locator("#by-job").is_visible()
    page.get_by_label("sheets to cut").check()
    wait_until(page, lambda: page.locator("#material option").count() > 1)
    page.locator("#material").select_option("own_card.toml")
    make(page)
    frame = page.frame_locator("#result iframe")
    frame.get_by_role("heading", name="miura_1").wait_for(timeout=30_000)
    assert frame.locator("section[aria-labelledby=sheet-1] path").count() > 2
    page.locator("#copies").fill("0")
    page.locator("#make").click()
    wait_until(page, lambda: "copies = 0" in page.locator("#made").text_content())
    assert page.locator("#make").is_enabled()


def test_an_export_says_how_far_it_is_and_is_cancelled(page, folder):
    before = sorted(folder.iterdir())
    put(page, "design.columns", 40)
    wait_until(page, lambda: verdict(page).startswith("grown: 320"))
    page.locator("#make").click()
    wait_until(page, lambda: " left" in page.locator("#stage").text_content())
    page.locator("#cancel").click()
    wait_until(page, lambda: page.locator("#made").text_content().startswith("Cancelled"))
    assert not page.locator("#making").is_visible()
    assert page.locator("#make").is_enabled()
    assert sorted(folder.iterdir()) == before


def test_growth_that_stops_says_what_to_do(page):
    open_template(page, "curved_fold")
    stops = {"columns": 10, "step": 0.2, "k_deg": 183, "flap_angle_deg": 150, "strips": 60}
    for key, value in stops.items():
        put(page, f"design.{key}", value)
    wait_until(page, lambda: "strips = 60" in page.locator("#text").input_value())
    assert not verdict(page).startswith("grown")
    assert ". " in verdict(page)  # advice
    assert "growth-stopped" in page.locator("#findings").text_content()


def test_what_was_done_is_there_again_after_a_reload(page):
    put(page, "design.rows", 3)
    wait_until(page, lambda: verdict(page) == "grown: 18 faces.")
    page.locator("#save-name").fill("other.toml")
    put(page, "design.columns", 0)  # refused, and kept as it was typed
    wait_until(page, lambda: "design.columns" in notice(page))
    page.reload()
    wait_until(page, lambda: "design.columns" in notice(page))
    assert page.locator("#save-name").input_value() == "other.toml"
    values = [
        page.locator(f'[data-key="design.{key}"]').input_value() for key in ("columns", "rows")
    ]
    assert values == ["0", "3"]
    put(page, "design.columns", 5)
    wait_until(page, lambda: verdict(page) == "grown: 15 faces.")
    page.locator("#to-gallery").click()
    page.reload()
    page.locator(".card").first.wait_for()
    assert not page.locator("#work").is_visible()


def test_two_tabs_work_apart_and_see_what_the_other_saved(page, browser, served, folder):
    with studio_tab(browser, served.address) as other:
        wait_until(other, lambda: verdict(other).startswith("grown"))
        open_template(other, "curved_fold")
        put(page, "design.rows", 2)
        wait_until(page, lambda: verdict(page) == "grown: 12 faces.")
        assert other.locator("#title").text_content() == "curved_fold"
        other.locator("#save-name").fill("own.toml")
        asked = []

        def answer(dialog):
            asked.append(dialog.message)
            dialog.accept() if len(asked) == 1 else dialog.dismiss()

        other.on("dialog", answer)
        page.on("dialog", answer)
        before = (folder / "own.toml").read_text(encoding="utf-8")
        other.locator("#save").click()
        wait_until(other, lambda: "saved" in other.locator("#saved").text_content())
        page.locator("#save").click()
        wait_until(page, lambda: len(asked) == 2)
        assert asked[0] == "own.toml exists. Replace it?"
        assert asked[1].startswith("own.toml was changed by another tab")
        assert "curved_fold" in (folder / "own.toml").read_text(encoding="utf-8")
        (folder / "own.toml").write_text(before, encoding="utf-8")
        put(other, "design.columns", 150)  # which takes long
        put(other, "design.strips", 150)
        other.wait_for_timeout(300)
    put(page, "design.rows", 3)  # the other tab is closed, and nobody waits for it
    wait_until(page, lambda: verdict(page) == "grown: 18 faces.", seconds=10)


def test_a_worker_that_dies_is_told_and_another_grows_76_000_faces(page, served):
    """The level of detail of such a sheet is told too, and its page stays usable."""
    good = shot(page)
    text = page.locator("#text").input_value()
    text = text.replace("columns = 6 ", "columns = 320").replace("rows = 8", "rows = 238")
    page.locator("#source summary").click()
    page.locator("#text").fill(text)
    page.locator("#apply").click()
    page.wait_for_timeout(1500)  # it grows for some seconds
    for each in workers(served.process.pid):
        os.kill(each, signal.SIGKILL)
    wait_until(page, lambda: verdict(page).startswith("Lost"))
    assert "crashed (exit code -9); a new process is ready" in notice(page)
    assert (shot(page) == good).all()
    page.locator("#again").click()
    wait_until(page, lambda: verdict(page) == "grown: 76160 faces.")
    assert notice(page) == ""
    assert page.locator("#detail").text_content().startswith("76160 faces: ")
    assert not page.locator("#creases").is_checked()
    assert (shot(page) != good).any()
    wait_until(page, page.locator("#fold").is_enabled)
    flat = shot(page)
    page.evaluate(PAINTED, 0.5)
    assert (shot(page) != flat).any()
    put_back = page.locator("#text").input_value().replace("rows = 238", "rows = 2")
    page.locator("#text").fill(put_back.replace("columns = 320", "columns = 6"))
    page.locator("#apply").click()
    wait_until(page, lambda: verdict(page) == "grown: 12 faces.")
    assert not page.locator("#detail").is_visible()
    assert page.locator("#creases").is_checked()


def test_a_studio_that_does_not_answer_is_told(browser, served):
    with studio_tab(browser, served.address, expected="ERR_FAILED") as page:
        wait_until(page, lambda: verdict(page) == "grown: 48 faces.")
        page.route("**/grow", lambda route: route.abort())
        put(page, "design.rows", 7)
        wait_until(page, lambda: "does not answer" in notice(page))
        assert verdict(page) == "Lost: the last good form is shown"
        page.unroute("**/grow")
        page.locator("#again").click()
        wait_until(page, lambda: verdict(page) == "grown: 42 faces.")


def tab_to(page, name):
    """Move the focus with the keyboard until it is on an element."""
    for _ in range(150):
        page.keyboard.press("Tab")
        if page.evaluate(NAMED) == name:
            return
    raise AssertionError(f"the keyboard does not reach {name}")


def test_the_keyboard_goes_from_the_gallery_to_the_files(browser, served):
    with studio_tab(browser, served.address) as page:
        wait_until(page, lambda: verdict(page).startswith("grown"))
        tab_to(page, "BUTTON to-gallery")
        page.keyboard.press("Enter")
        page.locator(".card").first.wait_for()
        tab_to(page, "BUTTON miura")
        page.keyboard.press("Enter")
        wait_until(page, lambda: page.locator("#save-name").input_value() == "miura.toml")
        wait_until(page, lambda: verdict(page) == "grown: 80 faces.")
        tab_to(page, "INPUT key-design-rows")
        page.keyboard.press("ArrowDown")  # one less
        wait_until(page, lambda: verdict(page) == "grown: 70 faces.")
        tab_to(page, "INPUT save-name")
        page.keyboard.type("by_keyboard.toml")
        tab_to(page, "BUTTON save")
        page.keyboard.press("Enter")
        wait_until(page, lambda: "by_keyboard.toml" in page.locator("#saved").text_content())
        tab_to(page, "INPUT run")
        page.keyboard.press("ArrowDown")  # to the sheets
        tab_to(page, "BUTTON make")
        page.keyboard.press("Enter")
        wait_until(page, lambda: page.locator("#made").text_content().startswith("made "))
        tab_to(page, "A miura_1.dxf")
        with page.expect_download(timeout=30_000) as loaded:
            page.keyboard.press("Enter")
        assert loaded.value.suggested_filename == "miura_1.dxf"
        tab_to(page, "INPUT fold")
        page.keyboard.press("Home")
        assert page.locator("#state").text_content() == "flat"


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_no_fault_in_gallery_errors_and_files(page, scheme):
    axe = pytest.importorskip(AXE).Axe()
    page.emulate_media(color_scheme=scheme)

    def faults():
        violations = axe.run(page).response["violations"]
        return [(each["id"], [n["html"][:200] for n in each["nodes"]]) for each in violations]

    page.get_by_label("sheets to cut").check()
    make(page)
    put(page, "design.columns", 0)
    wait_until(page, lambda: "design.columns" in notice(page))
    for summary in page.locator("#form summary").all()[2:]:
        summary.click()
    assert faults() == []
    page.locator("#to-gallery").click()
    page.locator(".card").first.wait_for()
    assert faults() == []
