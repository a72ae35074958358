"""The page of a sweep: it has the rows of the table, sorts and filters, and loads nothing."""

import io
import json
import re

import numpy as np
import pytest
from browser import opened
from PIL import Image

from fab.sweeps.columns import FIGURES, OUTCOME
from fab.sweeps.sweep_page import sweep_page_bytes
from fab.sweeps.thumbnails import contact_sheet_bytes

AXES = ["design.fold_deg", "design.kind<b>"]


def picture_bytes(shade):
    stream = io.BytesIO()
    Image.new("RGB", (240, 180), (shade, shade, shade)).save(stream, "PNG")
    return stream.getvalue()


def rows_of(count):
    empty = dict.fromkeys([column.name for column in (*OUTCOME, *FIGURES)])
    return [
        {
            **empty,
            "number": number,
            "job_hash": f"h{number}",
            "design.fold_deg": 10.0 * (number % 4),
            "design.kind<b>": "ab"[number % 2],
            "status": "made" if number else "refused",
            "message": "" if number else "</script><b>no</b>",
            "sheets.minutes": None if number == 0 else float((number * 7) % count),
        }
        for number in range(count)
    ]


@pytest.fixture(scope="module")
def page_file(tmp_path_factory):
    rows = rows_of(12)
    pictures = {row["job_hash"]: picture_bytes(10 * row["number"]) for row in rows[1:]}
    path = tmp_path_factory.mktemp("page") / "sweep.html"
    path.write_bytes(sweep_page_bytes("angles & more", AXES, rows, 12, pictures))
    return path


def numbers_shown(page):
    return [int(text) for text in page.locator("tbody tr td:first-child").all_inner_texts()]


def column(page, name):
    return page.get_by_role("button", name=name, exact=True)


def test_the_page_sorts_filters_and_marks(browser, page_file):
    with opened(browser, page_file, ready="tbody tr") as found:
        page = found.page
        assert numbers_shown(page) == list(range(12))
        column(page, "sheets.minutes").click()
        minutes = [row["sheets.minutes"] for row in rows_of(12)]
        rising = sorted(range(1, 12), key=lambda number: minutes[number])
        assert numbers_shown(page) == [*rising, 0]  # what is unknown comes last
        column(page, "sheets.minutes").click()
        assert numbers_shown(page) == [*rising[::-1], 0]
        # drag along the upper half of the first axis: 20 and 30 degrees
        box = page.locator("#axes .grip").first.bounding_box()
        x, top, high = box["x"] + box["width"] / 2, box["y"], box["height"]
        page.mouse.move(x, top + 2)
        page.mouse.down()
        page.mouse.move(x, top + 0.45 * high, steps=5)
        page.mouse.up()
        kept = {number for number in range(12) if number % 4 >= 2}
        assert set(numbers_shown(page)) == kept
        assert page.locator("#count").inner_text() == "6 of 12 variations"
        page.locator("tbody tr").first.hover()
        assert page.locator("polyline.marked").count() == 1
        column(page, "Show all").click()
        assert len(numbers_shown(page)) == 12
        assert found.complaints == []
        assert [url for url in found.requests if not url.startswith(("file:", "data:"))] == []


def test_names_and_messages_are_text_and_nothing_else(browser, page_file):
    with opened(browser, page_file, ready="tbody tr") as found:
        assert found.page.locator("th b, td b").count() == 0
        assert found.page.get_by_text("</script><b>no</b>").count() == 1
        assert found.page.locator("h1").inner_text() == "angles & more"
        pictures = found.page.locator("tbody img")
        assert pictures.count() == 11
        assert pictures.first.evaluate("image => image.naturalWidth") == 240


def test_the_page_is_accessible(browser, page_file):
    axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="no axe")
    for scheme in ("light", "dark"):
        with opened(browser, page_file, ready="tbody tr", color_scheme=scheme) as found:
            result = axe.Axe().run(found.page)
            assert [each["id"] for each in result.response["violations"]] == []


def test_the_same_rows_give_the_same_page():
    rows = rows_of(30)
    first, second = (sweep_page_bytes("a", AXES, rows, 40, {}) for _ in range(2))
    assert first == second
    assert b"the first 30 of 40 variations" in first
    slower = [{**row, "seconds": 5.0} for row in rows]
    assert sweep_page_bytes("a", AXES, slower, 40, {}) == first


def test_figures_of_makers_come_first_and_names_that_are_alike_are_longer():
    rows = [
        {**row, "flat.x_mm": float(n), "folded.x_mm": -float(n), "counts.vertices": n}
        for n, row in enumerate(rows_of(3))
    ]
    page = sweep_page_bytes("a", AXES, rows, 3, {}).decode()
    columns = json.loads(re.search(r'id="data">(.*?)</script>', page)[1])["columns"]
    names = [column["name"] for column in columns]
    assert names.index("sheets.minutes") < names.index("flat.x_mm") < names.index("counts.vertices")
    titles = {column["name"]: column["axis"] for column in columns}
    assert titles["sheets.minutes"] == "minutes"
    assert (titles["flat.x_mm"], titles["folded.x_mm"]) == ("flat.x_mm", "folded.x_mm")
    assert titles["status"] is None


def test_captions_have_two_lines_where_one_is_too_short():
    texts = ("0: rows 4", "0: fold_deg 30, columns 6, rows 4, width_mm 300, thickness_mm 0.8")
    short, long, longer = (
        np.asarray(Image.open(io.BytesIO(contact_sheet_bytes([(text, picture_bytes(0))]))))
        for text in (*texts, 3 * texts[1])
    )
    assert len(longer) == len(long) == len(short) + 14
    assert long[-12:].min() < 90


def test_a_contact_sheet_has_every_picture_in_its_place():
    pictures = [(f"{number}: 30", picture_bytes(10 * number)) for number in range(19)]
    sheet = np.asarray(Image.open(io.BytesIO(contact_sheet_bytes(pictures))))
    assert sheet.shape == (3 * 196, 8 * 240, 3)
    for number in range(19):
        row, place = divmod(number, 8)
        assert (sheet[row * 196 + 90, place * 240 + 120] == 10 * number).all()
        assert sheet[row * 196 + 180 : (row + 1) * 196, place * 240 : (place + 1) * 240].min() < 90
