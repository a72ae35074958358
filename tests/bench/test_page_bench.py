"""From a slider to the picture: result pages and the studio in Chromium, drawn by software.

    pytest tests/bench/test_page_bench.py --benchmark-only -s

Seconds from the input event to the pixels of the canvas, read back; medians of 15 events. The fold
slider of a sheet and of its thick panels on result pages, and a slider of the design in the studio,
which grows another sheet. Bounds hold on 2 cores with nothing else to do.
"""

import statistics

import pytest
from browser import opened
from studio_pages import Served, studio_tab, verdict, wait_until
from thick_sheets import miura_pattern

from fab.jobs.print_files import ThickFormat, make_thick
from fab.printing.thick_settings import ThickSettings
from fab.viewing.page import ResultPage, page_bytes
from fab.viewing.predicted_fold import predicted_scene

SIZES = {100: (10, 10), 1000: (40, 25), 5000: (100, 50)}
MOST_S = {100: 0.1, 1000: 0.1, 5000: 0.5}
EVENTS = 15
# Pixels that are read wait for all that was drawn.
FOLDED = """(share) => new Promise((done) => {
  const gl = document.querySelector("canvas").getContext("webgl2");
  const slider = document.querySelector("#fold");
  const begin = performance.now();
  slider.value = slider.min - -share * (slider.max - slider.min);
  slider.dispatchEvent(new Event("input"));
  requestAnimationFrame(() => {
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
    done((performance.now() - begin) / 1000);
  });
})"""
GROWN = """(value) => new Promise((done) => {
  const gl = document.querySelector("canvas").getContext("webgl2");
  const label = document.querySelector("#verdict");
  const slider = document.querySelector("[aria-label='fold_deg, slider']");
  const begin = performance.now();
  const seen = new MutationObserver(() => {
    if (!label.textContent.startsWith("grown")) return;
    seen.disconnect();
    requestAnimationFrame(() => {
      gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
      done((performance.now() - begin) / 1000);
    });
  });
  seen.observe(label, { childList: true, characterData: true, subtree: true });
  slider.value = value;
  slider.dispatchEvent(new Event("input"));
})"""


def measured(benchmark, page, script, values, size, what):
    """Medians over values; the first two only warm up."""
    seconds = [page.evaluate(script, value) for value in values][2:]
    benchmark.pedantic(page.evaluate, args=(script, values[0]), rounds=1)
    median = statistics.median(seconds)
    benchmark.extra_info.update(median_s=round(median, 4), faces=size)
    print(f"\n{what} of {size} faces: {1000 * median:.0f} ms")
    assert median < MOST_S[size]


def shares():
    return [(1 + number) / (EVENTS + 3) for number in range(EVENTS + 2)]


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("shown", ["sheet", "panels"])
def test_the_fold_slider_of_a_result_page(benchmark, browser, tmp_path, size, shown):
    columns, rows = SIZES[size]
    pattern = miura_pattern(columns, rows)
    if shown == "panels":
        made = make_thick(pattern, "m", ThickSettings(), formats=[ThickFormat.HTML])
        data = made.files["m_thick.html"]
    else:
        data = page_bytes(ResultPage("m", "bench", predicted_scene(pattern, "m"), {}))
    (tmp_path / "m.html").write_bytes(data)
    with opened(browser, tmp_path / "m.html", viewport={"width": 1280, "height": 900}) as found:
        if shown == "panels":
            found.page.get_by_label("panels", exact=True).check()
        measured(benchmark, found.page, FOLDED, shares(), size, f"fold slider, {shown}")
        assert found.complaints == []


@pytest.mark.parametrize("size", SIZES)
def test_a_slider_of_the_design_in_the_studio(benchmark, browser, tmp_path, size):
    columns, rows = SIZES[size]
    text = f"""name = "m"
[design]
kind = "miura"
columns = {columns}
rows = {rows}
fold_deg = 40.0
[sheet]
width_mm = 200.0
"""
    (tmp_path / "m.toml").write_text(text, encoding="utf-8")
    served = Served(tmp_path, "m.toml")
    try:
        with studio_tab(browser, served.address) as page:
            wait_until(page, lambda: verdict(page).startswith("grown"))
            wait_until(page, page.locator("#fold").is_enabled)
            values = [20 + number for number in range(EVENTS + 2)]
            measured(benchmark, page, GROWN, values, size, "slider of a design")
    finally:
        served.end()
