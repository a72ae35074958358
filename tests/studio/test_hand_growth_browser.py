"""Growing by hand in a real browser: by mouse, by touch and by keyboard alone."""

import math
import re
import tomllib

import pytest
from studio_pages import differ, shot, verdict, wait_until

JOB = """name = "mine"
sheet = { scale_mm_per_unit = 20.0 }

[design]
kind = "strip_by_strip"   # by hand
strips = [
    { side = "top", flap_angle_deg = 120.0, lengths = 0.9 },  # the first
]

[design.seed]
kind = "miura"
columns = 4
rows = 2
"""


@pytest.fixture
def hand(page):
    """A sheet with one strip on its seed, as the text of a job."""
    page.locator("#source summary").click()
    applied(page, JOB, 12)
    settled(page)
    return page


def applied(page, text, faces):
    page.locator("#text").fill(text)
    page.locator("#apply").click()
    wait_until(page, lambda: verdict(page) == f"grown: {faces} faces.")


def strips(page):
    return tomllib.loads(page.locator("#text").input_value())["design"].get("strips", [])


def settled(page):
    """Wait for what may be chosen for the strip that is shown."""
    wait_until(page, lambda: page.locator("#hand .choices").is_visible())
    wait_until(page, lambda: page.locator("#hand .landscape .cost").count() == 1)


def handle(page):
    return page.locator("#hand [role=slider]")


def angle(page):
    return float(handle(page).get_attribute("aria-valuenow"))


def place(page, degrees):
    """Where an angle is on the circle, in pixels of the page."""
    page.locator("#hand .circle").scroll_into_view_if_needed()
    box = page.locator("#hand .circle circle.forbidden").bounding_box()
    radius, turn = box["width"] / 2, math.radians(degrees)
    middle = box["x"] + radius, box["y"] + box["height"] / 2
    return middle[0] + radius * math.cos(turn), middle[1] - radius * math.sin(turn)


def on_side(page, side):
    """A place on a side of the crease pattern, in pixels of the page, once it stays there."""
    page.locator("#pattern svg").scroll_into_view_if_needed()

    def read():
        page.wait_for_timeout(150)
        return page.evaluate(
            """(side) => {
              const path = document.querySelector(`#pattern [data-side="${side}"]`);
              if (!path) return null;
              const { x, y } = path.getPointAtLength(0.3 * path.getTotalLength());
              const point = new DOMPoint(x, y).matrixTransform(path.getScreenCTM());
              return [point.x, point.y];
            }""",
            side,
        )

    seen = [None, read()]
    wait_until(page, lambda: seen.append(read()) or (seen[-1] is not None and seen[-1] == seen[-2]))
    return seen[-1]


def drag(page, start, end, step=5):
    page.mouse.move(*place(page, start))
    page.mouse.down()
    for degrees in range(start, end, step if end > start else -step):
        page.mouse.move(*place(page, degrees))
    page.mouse.move(*place(page, end))
    page.mouse.up()


def test_the_flap_angle_is_dragged_and_the_sheet_follows(hand):
    before = shot(hand)
    lines = hand.locator('#pattern g[data-layer="B"] path').get_attribute("d")
    drag(hand, 120, 150)
    assert angle(hand) == pytest.approx(150.0, abs=0.11)
    wait_until(hand, lambda: strips(hand)[0]["flap_angle_deg"] == angle(hand))
    assert verdict(hand) == "grown: 12 faces."
    assert differ(before, shot(hand)) > 0.005
    assert hand.locator('#pattern g[data-layer="B"] path').get_attribute("d") != lines
    assert "# the first" in hand.locator("#text").input_value()
    assert hand.locator("#hand .angle").input_value() == f"{angle(hand):g}"


def test_the_handle_stays_out_of_arcs_where_faces_cross(hand):
    drag(hand, 120, 30)  # over the end of the free arc, at 45 degrees
    assert angle(hand) == pytest.approx(45.01, abs=1e-6)
    assert handle(hand).get_attribute("aria-valuetext") == "45.01 degrees, free"
    wait_until(hand, lambda: strips(hand)[0]["flap_angle_deg"] == pytest.approx(45.01))
    top = "document.querySelector('#hand .circle').getBoundingClientRect().top + scrollY"
    place_on_page = hand.evaluate(top)
    hand.locator("#hand .angle").fill("30")  # what is typed is asked for, and refused
    wait_until(hand, lambda: verdict(hand).startswith("Not grown"))
    assert hand.evaluate(top) == place_on_page  # a message moves no circle from under the pointer
    notice = hand.locator("#notice").text_content()
    assert "flap angle of strip 1 (top side) = 30 deg" in notice
    assert "must lie between 45 deg" in notice
    assert hand.locator("#save").is_disabled()
    assert handle(hand).get_attribute("aria-valuetext") == "30 degrees, forbidden"
    hand.locator("#hand .angle").fill("60")
    wait_until(hand, lambda: verdict(hand) == "grown: 12 faces.")


def test_touch_and_the_landscape_turn_it_too(hand):
    session = hand.context.new_cdp_session(hand)
    for kind, degrees in (("touchStart", 120), ("touchMove", 130), ("touchMove", 145)):
        x, y = place(hand, degrees)
        points = [{"x": x, "y": y}]
        session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
    session.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
    assert angle(hand) == pytest.approx(145.0, abs=0.11)
    left, top, width = hand.evaluate(
        """() => {
          const chart = document.querySelector("#hand .landscape rect.forbidden");
          chart.scrollIntoView({ block: "center", behavior: "instant" });
          const { x, y, width } = chart.getBoundingClientRect();
          return [x, y, width];
        }"""
    )
    hand.mouse.click(left + 0.25 * width, top + 10)
    assert angle(hand) == pytest.approx(90.0, abs=0.6)
    wait_until(hand, lambda: strips(hand)[0]["flap_angle_deg"] == angle(hand))


def test_rings_take_the_angles_at_which_they_close(hand):
    seed = (
        JOB.partition("[design.seed]")[0]
        + '[design.seed]\nkind = "closed_curved_fold"\nstrips = 2\n'
    )
    hand.locator("#text").fill(seed.replace("lengths = 0.9", "lengths = 0.001"))
    hand.locator("#apply").click()  # 120 degrees do not close it
    wait_until(hand, lambda: "the ring does not close" in hand.locator("#notice").text_content())
    wait_until(hand, lambda: hand.locator("#hand .closing").count() == 2)
    handle(hand).focus()
    seen = set()
    for _ in range(3):
        hand.keyboard.press("ArrowUp")
        seen.add(angle(hand))
        wait_until(hand, lambda: verdict(hand).startswith("grown"))
    assert len(seen) == 2
    wait_until(hand, hand.locator('#hand .sides [data-side="left"]').is_disabled)


def test_a_strip_is_grown_on_the_side_that_is_clicked_and_undone(hand):
    hand.mouse.click(*on_side(hand, "right"))
    wait_until(hand, lambda: verdict(hand) == "grown: 15 faces.")
    assert [strip["side"] for strip in strips(hand)] == ["top", "right"]
    hand.mouse.click(*on_side(hand, "bottom"))
    wait_until(hand, lambda: verdict(hand) == "grown: 20 faces.")
    grown = strips(hand)
    assert [strip["side"] for strip in grown] == ["top", "right", "bottom"]
    undo, redo = hand.locator("#hand .undo"), hand.locator("#hand .redo")
    for faces in (15, 12, 8):
        undo.click()
        wait_until(hand, lambda faces=faces: verdict(hand) == f"grown: {faces} faces.")
    assert undo.is_disabled()
    assert strips(hand) == []
    assert hand.locator("#hand .none").is_visible()
    for faces in (12, 15, 20):
        redo.click()
        wait_until(hand, lambda faces=faces: verdict(hand) == f"grown: {faces} faces.")
    assert redo.is_disabled()
    assert strips(hand) == grown


def test_all_of_it_by_keyboard(hand):
    hand.locator('#hand .sides [data-side="top"]').focus()
    hand.keyboard.press("Enter")
    wait_until(hand, lambda: verdict(hand) == "grown: 16 faces.")
    settled(hand)
    focused = hand.evaluate("document.activeElement.getAttribute('aria-label')")
    assert focused == "Flap angle of strip 2"
    before = angle(hand)
    for key, step in (
        ("ArrowUp", 1.0),
        ("ArrowLeft", -1.0),
        ("PageUp", 10.0),
        ("Shift+ArrowUp", 0.1),
    ):
        hand.keyboard.press(key)
        assert angle(hand) - before == pytest.approx(step, abs=0.011)
        before = angle(hand)
    for _ in range(40):  # all around: forbidden arcs are leapt over
        hand.keyboard.press("PageUp")
        assert handle(hand).get_attribute("aria-valuetext").endswith("free")
    hand.keyboard.press("Home")
    start = angle(hand)
    hand.keyboard.press("End")
    assert angle(hand) != start
    wait_until(
        hand, lambda: strips(hand)[1]["flap_angle_deg"] == pytest.approx(angle(hand), abs=0.01)
    )
    hand.locator("#hand .undo").focus()
    hand.keyboard.press("Space")
    wait_until(hand, lambda: verdict(hand) == "grown: 12 faces.")
    hand.keyboard.press("Tab")
    hand.keyboard.press("Enter")  # redo
    wait_until(hand, lambda: len(strips(hand)) == 2)


def test_lengths_have_their_bounds_beside_them(hand):
    hand.locator('#hand .sides [data-side="right"]').click()
    wait_until(hand, lambda: verdict(hand) == "grown: 15 faces.")
    settled(hand)
    hand.locator("#hand .angle").fill("165")
    bounds = hand.locator("#hand .lengths .bound")
    wait_until(hand, lambda: bounds.all_text_contents()[1:2] > ["below 6"])
    assert bounds.all_text_contents()[::3] == ["any", "any"]  # the ends, which have no neighbour
    n = 1
    bound = float(bounds.nth(n).text_content().removeprefix("below "))
    field = hand.locator("#hand .lengths input").nth(n)
    field.fill(f"{0.95 * bound:.4g}")
    wait_until(hand, lambda: isinstance(strips(hand)[1]["lengths"], list))
    assert strips(hand)[1]["lengths"][n] == float(f"{0.95 * bound:.4g}")
    assert hand.locator("#pattern .hand .crease").count() == 1  # the one that is edited
    field.fill(f"{1.05 * bound:.4g}")
    wait_until(hand, lambda: verdict(hand).startswith("Not grown"))
    assert f"length at vertex {n} of strip 2" in hand.locator("#notice").text_content()
    wait_until(hand, lambda: field.get_attribute("aria-invalid") == "true")
    hand.locator("#hand .one").fill("0.4")
    wait_until(hand, lambda: verdict(hand) == "grown: 15 faces.")
    assert strips(hand)[1]["lengths"] == 0.4
    hand.locator("#hand .first-end").fill("80")
    wait_until(hand, lambda: "boundary_angles_deg" in strips(hand)[1])
    assert strips(hand)[1]["boundary_angles_deg"][0] == 80.0
    hand.locator("#hand .parallel").click()
    wait_until(hand, lambda: "boundary_angles_deg" not in strips(hand)[1])


def test_an_earlier_strip_is_turned_and_special_angles_are_taken(hand):
    hand.locator('#hand .sides [data-side="top"]').click()
    wait_until(hand, lambda: verdict(hand) == "grown: 16 faces.")
    hand.locator("#hand .strip").select_option("0")
    settled(hand)
    wait_until(hand, lambda: angle(hand) == 120.0)
    special = hand.locator("#hand .special")
    least = special.locator("option", has_text="least cost")
    wait_until(hand, lambda: least.count() == 1)
    label = special.evaluate(  # at once: angles that come meanwhile replace the choices
        """(select) => {
          const option = [...select.options].find(({ text }) => text.includes("least cost"));
          select.value = option.value;
          select.dispatchEvent(new Event("change"));
          return option.text;
        }"""
    )
    wait_until(hand, lambda: strips(hand)[0]["flap_angle_deg"] != 120.0)
    assert f"{strips(hand)[0]['flap_angle_deg']:.2f}°" in label
    kept = strips(hand)
    assert len(kept) == 2
    hand.reload()
    wait_until(hand, lambda: verdict(hand) == "grown: 16 faces.")
    settled(hand)
    assert strips(hand) == kept
    assert hand.locator("#hand .strip").input_value() == "1"


def test_another_sheet_goes_on_by_hand(page):
    page.locator("#hand .begin button").click()
    wait_until(page, lambda: page.locator("#hand .sides").is_visible())
    wait_until(page, lambda: verdict(page) == "grown: 48 faces.")
    text = page.locator("#text").input_value()
    assert tomllib.loads(text)["design"]["seed"]["kind"] == "miura"
    assert "# acute angle of the parallelograms" in text
    page.locator('#hand .sides [data-side="bottom"]').click()
    wait_until(page, lambda: verdict(page) == "grown: 54 faces.")
    page.locator('[data-key="design.seed.columns"]').fill("4")
    wait_until(page, lambda: verdict(page) == "grown: 36 faces.")
    assert re.search(r"columns = 4 +#", page.locator("#text").input_value())


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_no_fault_of_accessibility(hand, scheme):
    axe = pytest.importorskip("axe_playwright_python.sync_playwright")
    hand.emulate_media(color_scheme=scheme)
    violations = axe.Axe().run(hand).response["violations"]
    assert [(each["id"], [n["html"][:200] for n in each["nodes"]]) for each in violations] == []
