"""A few random products of which everything says the same; `differential.py` makes long runs."""

import time

import numpy as np
import pytest
from fuzz import differential
from fuzz.differential import CHECKS, compared
from sheet_readers import read_dxf_sheet, read_svg_sheet

from fab.drawings.cut_paths import CutPaths, Layer, Operation
from fab.drawings.dxf import dxf_bytes
from fab.drawings.svg import svg_bytes

SEED = 20
# Of processor time for each check, and the least number of products.
SECONDS, LEAST = 2.0, 4


@pytest.mark.parametrize("check", CHECKS)
def test_all_formats_and_figures_of_a_product_agree(check):
    end, kinds = time.process_time() + SECONDS, set()
    for number in range(200):
        if number >= LEAST and time.process_time() > end:
            break
        outcome = compared(check, SEED, number)
        assert outcome.kind != "fault", f"{check} {number}: {outcome.text}"
        kinds.add(outcome.kind)
    assert "same" in kinds


def test_what_differs_is_found(monkeypatch):
    """A figure, a line of a drawing, and the volume of a mesh, each off by a little."""

    def spoilt(check, change):
        prepared, compare = CHECKS[check]

        def other(random):
            make_it = prepared(random)

            def made():
                found = make_it()
                change(found)
                return found

            return made

        monkeypatch.setitem(differential.CHECKS, check, (other, compare))
        outcomes = [compared(check, SEED, number) for number in range(8)]
        monkeypatch.setitem(differential.CHECKS, check, (prepared, compare))
        return [o.text.strip().splitlines()[-1] for o in outcomes if o.kind == "fault"]

    def longer(made):
        made.report["sheets"][0]["cut_mm"] += 0.01

    def narrower(made):
        made.report["bounding_box_mm"]["flat"][0] -= 1e-3

    def shifted(made):
        name = next(name for name in made.files if name.endswith(".svg"))
        made.files[name] = made.files[name].replace(b"1L", b"2L", 1)

    assert any("cut_mm" in text for text in spoilt("drawings", longer))
    assert any("svg: lines of" in text for text in spoilt("drawings", shifted))
    assert all("box flat" in text for text in spoilt("sheets", narrower))


def test_readers_of_sheets_read_lines_where_they_are():
    lines = np.array([[[1.0, 2.0], [3.5, 2.0]], [[0.25, 0.0], [0.25, 9.0]]])
    ring = np.array([[5.0, 5.0], [9.0, 5.0], [9.0, 8.0]])
    layer = Layer(Operation.CUT, lines, (ring,), (np.array([[1.0, 1.0], [2.0, 1.5], [4.0, 1.0]]),))
    paths = CutPaths((layer,), (10.0, 20.0), on_bed=True)
    for sheet in (read_dxf_sheet(dxf_bytes(paths)), read_svg_sheet(svg_bytes(paths, "a"))):
        assert sheet.page == (10.0, 20.0)
        assert list(sheet.lines) == ["CUT"]
        assert sheet.length("CUT") == pytest.approx(
            2.5 + 9 + 12 + np.hypot(1, 0.5) + np.hypot(2, 0.5), abs=1e-5
        )
        assert sheet.sides("CUT").min(axis=0).round(6).tolist() == [0.25, 0.0, 0.25, 1.0]
