"""Result pages in a real browser: offline, by mouse, keyboard and touch, light, dark, printed."""

import io
import time

import numpy as np
import pytest
from browser import opened
from click.testing import CliRunner
from helpers import TEMPLATES
from PIL import Image

from fab.cli.group import main

PAGES = {
    "run": "out/miura.html",
    "fabricate": "sheets/miura_sheets.html",
    "thicken": "thick/miura_thick.html",
    "simulate": "folding/miura_folding.html",
}
SMALL = ["--set", "design.columns=5", "--set", "design.rows=4", "--set", "sheet.width_mm=90.0"]
# Panels are made for less than the target, which a finding says with its creases.
BLOCKED = ["--set", "panels.fold_limit_deg=80.0"]
PINK = (224, 0, 122)
RIM = 12
FOCUSED = """(({ tagName, id, dataset, value }) =>
  [tagName, id || dataset.finding || dataset.step || dataset.layer || value || ""].join(" ").trim()
)(document.activeElement)"""
NO_WEBGL = """
const context = HTMLCanvasElement.prototype.getContext;
HTMLCanvasElement.prototype.getContext = function (kind, ...others) {
  return kind.startsWith("webgl") ? null : context.call(this, kind, ...others);
};
"""


def made(*arguments):
    result = CliRunner().invoke(main, [str(argument) for argument in arguments])
    assert result.exit_code in (0, 1), result.output


@pytest.fixture(scope="module")
def pages(browser, tmp_path_factory):
    """The page of every command; not made where there is no browser to look at them."""
    folder = tmp_path_factory.mktemp("pages")
    job = TEMPLATES / "miura.toml"
    made("run", job, "--out", folder / "out", *SMALL, *BLOCKED, "--only", "fold,dxf,stl,png,html")
    pattern = folder / "out" / "miura.fold"
    sheet = ["--material", "card_300gsm", "--machine", "co2_60w_600x400"]
    made("fabricate", pattern, *sheet, "--out", folder / "sheets", "--two-sided")
    made("thicken", pattern, "--out", folder / "thick", "--only", "stl,html")
    made("simulate", pattern, "--out", folder / "folding", "--only", "png,html", "--states", 4)
    return {command: folder / place for command, place in PAGES.items()}


def shot(page, selector="canvas"):
    """The pixels of an element without its rounded rim, shape (height, width, 3)."""
    page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    picture = Image.open(io.BytesIO(page.locator(selector).first.screenshot())).convert("RGB")
    return np.asarray(picture)[RIM:-RIM, RIM:-RIM]


def wait_until(page, expression):
    """Wait until a script's expression is true; the policy of pages forbids playwright's own."""
    until = time.monotonic() + 30
    while not page.evaluate(expression):
        assert time.monotonic() < until, expression
        page.wait_for_timeout(50)


def drawn(pixels):
    """Width and height of what is not background."""
    other = np.abs(pixels.astype(int) - pixels[2, 2]).sum(axis=2) > 30
    rows, columns = np.flatnonzero(other.any(axis=1)), np.flatnonzero(other.any(axis=0))
    return np.array([np.ptp(columns), np.ptp(rows)])


def fold_to(page, share):
    page.locator("#fold").evaluate(
        "(slider, share) => { slider.value = share * slider.max;"
        " slider.dispatchEvent(new Event('input')); }",
        share,
    )


def is_lit(pixels):
    return (np.abs(pixels.astype(int) - PINK).max(axis=2) < 12).any()


@pytest.mark.parametrize("command", PAGES)
def test_pages_of_every_command_are_alive_without_a_network(browser, pages, command):
    with opened(browser, pages[command]) as found:
        assert found.page.locator("canvas").is_visible()
        assert np.ptp(shot(found.page).reshape(-1, 3), axis=0).max() > 100
        for picture in found.page.locator(".still img, .still figure > svg").all():
            assert not picture.is_visible()  # until it is asked for
        assert found.requests == [pages[command].as_uri()]
        assert found.complaints == []


@pytest.mark.parametrize("command", PAGES)
def test_the_slider_folds_the_sheet(browser, pages, command):
    with opened(browser, pages[command]) as found:
        page = found.page
        folded = shot(page)
        fold_to(page, 0.0)
        assert page.locator("#state").text_content() == "flat"
        flat = shot(page)
        fold_to(page, 0.4)
        between = shot(page)
        assert drawn(flat)[0] > drawn(between)[0] > drawn(folded)[0]


def test_places_between_states_are_called_by_their_share(browser, pages):
    with opened(browser, pages["fabricate"]) as found:  # states at every tenth
        for share, name in ((0.0, "flat"), (0.45, "45% of the fold"), (1.0, "100% of the fold")):
            fold_to(found.page, share)
            assert found.page.locator("#state").text_content() == name


def test_the_fold_plays_to_its_end(browser, pages):
    with opened(browser, pages["simulate"]) as found:
        page = found.page
        page.locator("#play").click()
        assert page.locator("#play").text_content() == "Stop"
        wait_until(page, "document.querySelector('#play').textContent === 'Fold'")
        assert page.locator("#fold").input_value() == page.locator("#fold").get_attribute("max")


def test_faces_are_coloured_by_strain_where_they_were_simulated(browser, pages):
    with opened(browser, pages["simulate"]) as found:
        page = found.page
        fold_to(page, 0.5)
        sides = shot(page)
        assert not page.locator(".scale").is_visible()
        page.get_by_label("strain").check()
        assert page.locator(".scale").is_visible()
        strained = shot(page)
        assert (sides != strained).any(axis=2).mean() > 0.02
        fold_to(page, 0.0)
        assert (drawn(shot(page)) != drawn(strained)).any()
        fold_to(page, 0.5)
        assert (shot(page) == strained).all()
        page.get_by_label("sides").check()
        assert (shot(page) == sides).all()
        assert found.complaints == []
    with opened(browser, pages["run"]) as found:
        assert found.page.get_by_label("strain").count() == 0


def test_panels_take_the_place_of_the_sheet(browser, pages):
    with opened(browser, pages["run"]) as found:
        page = found.page
        sheet = shot(page)
        page.get_by_label("panels", exact=True).check()
        panels = shot(page)
        assert (sheet != panels).any(axis=2).mean() > 0.02
        fold_to(page, 0.0)
        assert (shot(page) != panels).any(axis=2).mean() > 0.02


def test_panels_stop_where_they_were_made_to_and_the_sheet_goes_on(browser, pages):
    with opened(browser, pages["run"]) as found:
        page = found.page
        last, stop = page.evaluate(
            "(d => [d.states.length - 1, d.panelsState])"
            "(JSON.parse(document.querySelector('#data').textContent))"
        )
        assert 0 < stop < last
        fold_to(page, stop / last)
        at_stop = shot(page)
        fold_to(page, 1.0)
        assert (shot(page) != at_stop).any(axis=2).mean() > 0.01
        assert page.locator("#state").text_content() == "at the target"
        page.get_by_label("panels", exact=True).check()
        assert page.locator("#state").text_content().startswith("panels stop at")
        panels = shot(page)
        fold_to(page, stop / last)
        assert (shot(page) == panels).all()


def test_layers_are_switched_off_and_on(browser, pages):
    with opened(browser, pages["fabricate"]) as found:
        page = found.page
        for figure, layer in (("#pattern", "M"), ("section[aria-labelledby=sheet-1]", "MOUNTAIN")):
            group = page.locator(f'{figure} g[data-layer="{layer}"]')
            box = page.locator(f'{figure} input[data-layer="{layer}"]')
            assert group.is_visible()
            box.uncheck()
            assert not group.is_visible()
            box.check()
            assert group.is_visible()


def test_drawings_zoom_and_move_and_come_back(browser, pages):
    with opened(browser, pages["fabricate"]) as found:
        page = found.page
        drawing = page.locator("#pattern figure > svg")
        begin = drawing.get_attribute("viewBox")
        width = float(begin.split()[2])
        page.locator("#pattern button[data-step=in]").click()
        assert float(drawing.get_attribute("viewBox").split()[2]) == pytest.approx(width / 1.25)
        page.locator("#pattern button[data-step=whole]").click()
        assert [float(x) for x in drawing.get_attribute("viewBox").split()] == [
            float(x) for x in begin.split()
        ]
        box = drawing.bounding_box()
        middle = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        page.mouse.move(*middle)
        page.mouse.down()
        page.mouse.move(middle[0] + 50, middle[1])
        page.mouse.up()
        assert float(drawing.get_attribute("viewBox").split()[0]) < float(begin.split()[0])
        page.mouse.wheel(0, -200)  # it has the focus
        zoomed = "document.querySelector('#pattern figure > svg').viewBox.baseVal.width"
        wait_until(page, f"{zoomed} < {0.9 * width}")


def test_findings_light_up_what_they_name(browser, pages):
    with opened(browser, pages["run"]) as found:
        page = found.page
        assert not is_lit(shot(page))
        button = page.get_by_role("button", name="Show fold-blocked")
        button.click()
        assert button.get_attribute("aria-pressed") == "true"
        assert is_lit(shot(page))
        assert is_lit(shot(page, "#pattern figure > svg"))
        path = page.locator("#pattern .lit-creases").get_attribute("d")
        named = page.evaluate(
            "JSON.parse(document.querySelector('#data').textContent).findings"
            "[document.querySelector('[aria-pressed=true]').dataset.finding].creases.length"
        )
        assert path.count("M") == path.count("L") == named > 0
        page.get_by_label("panels", exact=True).check()
        button.click()
        assert button.get_attribute("aria-pressed") == "false"
        assert not is_lit(shot(page))
        assert not is_lit(shot(page, "#pattern figure > svg"))


def test_everything_is_reached_and_moved_by_the_keyboard(browser, pages):
    with opened(browser, pages["run"]) as found:
        page = found.page
        reached = []
        for _ in range(80):
            page.keyboard.press("Tab")
            reached.append(page.evaluate(FOCUSED))
            if reached[-1] == "BODY":
                break
            if reached[-1] == "CANVAS":
                before = shot(page)
                page.keyboard.press("ArrowLeft")
                turned = shot(page)
                assert (turned != before).any()
                page.keyboard.press("+")
                assert (drawn(shot(page)) >= drawn(turned)).all()
                page.keyboard.press("0")
                assert (shot(page) == before).all()
            elif reached[-1] == "INPUT fold":
                page.keyboard.press("Home")
                assert page.locator("#state").text_content() == "flat"
            elif reached[-1] == "INPUT M":
                page.keyboard.press("Space")
                assert not page.locator('#pattern g[data-layer="M"]').is_visible()
            elif reached[-1] == "svg":
                box = page.locator("#pattern figure > svg").get_attribute("viewBox")
                page.keyboard.press("ArrowRight")
                page.keyboard.press("-")
                if page.evaluate("document.activeElement.closest('section').id") == "pattern":
                    assert page.locator("#pattern figure > svg").get_attribute("viewBox") != box
        assert reached[-1] == "BODY"  # nothing holds the focus
        for each in ("BUTTON theme", "BUTTON 1", "CANVAS", "BUTTON play", "INPUT fold", "svg"):
            assert each in reached
        for each in ("BUTTON in", "BUTTON out", "BUTTON whole", "BUTTON left", "SUMMARY", "A"):
            assert each in reached


def brightness(page):
    """Of the page's ground and of its text."""
    ground, text = page.evaluate(
        "(s => [s.backgroundColor, s.color])(getComputedStyle(document.body))"
    )
    return [sum(map(int, colour[4:-1].split(", "))) for colour in (ground, text)]


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_pages_are_light_or_dark_as_the_system_is_and_as_the_user_chooses(browser, pages, scheme):
    with opened(browser, pages["run"], color_scheme=scheme) as found:
        page = found.page
        ground, text = brightness(page)
        space = shot(page)[2, 2].astype(int).sum()
        assert (ground < text) == (space < 300) == (scheme == "dark")
        under = "(each) => getComputedStyle(each).backgroundColor"
        swatch = page.locator("label > svg").first.evaluate(under)
        assert swatch == page.locator(".drawing > svg").first.evaluate(under)  # seen as on paper
        page.locator("#theme").click()
        other_ground, other_text = brightness(page)
        assert (other_ground < other_text) != (ground < text)
        assert (shot(page)[2, 2].astype(int).sum() < 300) != (space < 300)


def test_without_webgl_pictures_take_its_place(browser, pages):
    with opened(browser, pages["run"], script=NO_WEBGL) as found:
        page = found.page
        assert not page.locator(".live-view").is_visible()
        assert "no WebGL" in page.locator(".without").text_content()
        assert page.locator(".without").is_visible()
        for number in range(page.locator(".still img").count()):
            picture = page.locator(".still img").nth(number)
            assert picture.is_visible()
            assert picture.evaluate("image => image.naturalWidth") > 300
        page.get_by_role("button", name="Show fold-blocked").click()
        assert is_lit(shot(page, "#pattern figure > svg"))
        assert found.complaints == []
    with opened(browser, pages["fabricate"], script=NO_WEBGL) as found:
        assert found.page.locator(".still svg polygon").count() == 20  # drawn without a picture


def test_without_a_script_there_are_pictures_drawings_and_numbers(browser, pages):
    with opened(browser, pages["run"], java_script_enabled=False) as found:
        page = found.page
        for selector in (".still img", "#pattern figure > svg", "#files", "#accuracy", "#growth"):
            assert page.locator(selector).first.is_visible()
        for selector in (".live-view", ".tools", "#theme", "button"):
            assert not any(each.is_visible() for each in page.locator(selector).all())


@pytest.mark.parametrize("command", PAGES)
def test_pages_print_pictures_and_all_numbers(browser, pages, command):
    with opened(browser, pages[command], color_scheme="dark") as found:
        page = found.page
        page.emulate_media(media="print")
        page.evaluate("dispatchEvent(new Event('beforeprint'))")
        assert page.locator(".still img, .still figure > svg").first.is_visible()
        assert not page.locator("canvas").is_visible()
        assert not page.locator("footer pre").is_visible()  # a licence of software, not of paper
        ground, text = brightness(page)
        assert ground > text
        assert len(page.pdf()) > 10_000


@pytest.mark.parametrize("command", PAGES)
def test_pages_fit_a_telephone(browser, pages, command):
    small = {"width": 390, "height": 800}
    with opened(browser, pages[command], viewport=small, has_touch=True, is_mobile=True) as found:
        page = found.page
        assert page.evaluate("document.documentElement.scrollWidth") <= 390
        for button in page.locator("button:visible").all():
            assert min(button.bounding_box()["width"], button.bounding_box()["height"]) >= 34
        page.locator("#play").tap()
        wait_until(page, "Number(document.querySelector('#fold').value) < 3")


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("command", PAGES)
def test_axe_finds_no_fault_of_accessibility(browser, pages, command, scheme):
    axe = pytest.importorskip("axe_playwright_python.sync_playwright")
    with opened(browser, pages[command], color_scheme=scheme) as found:
        for details in found.page.locator("summary").all():
            details.click()
        found.page.locator("button[data-finding]").first.click() if command == "run" else None
        violations = axe.Axe().run(found.page).response["violations"]
        assert [(each["id"], [n["html"][:200] for n in each["nodes"]]) for each in violations] == []
