"""Our own sheets with bridges, closed slots, titles and holes give their pattern back."""

from collections import Counter

import numpy as np
import pytest
from flat_patterns import grid
from helpers import PATTERNS

from fab import read_pattern
from fab.drawings.drawing_files import SheetFormat
from fab.jobs.reading import read_any
from fab.jobs.sheet_files import fabricate
from fab.pattern.crease_pattern import scaled
from fab.sheets.cut_wishes import CutWishes
from fab.sheets.materials import load_machine, load_material
from fab.sheets.sheet_request import SheetRequest


def lengths(pattern):
    ends = pattern.vertices_coords[pattern.edges_vertices]
    length = np.hypot(*(ends[:, 1] - ends[:, 0]).T)
    out = Counter()
    for letter, size in zip(pattern.edges_assignment.tolist(), length.tolist(), strict=True):
        out[letter] += size
    return {letter: size for letter, size in out.items() if letter not in "FJ"}


@pytest.mark.parametrize("kind", [SheetFormat.DXF, SheetFormat.SVG])
@pytest.mark.parametrize(
    "wishes",
    [{"bridges": 1}, {"bridges": 4, "title": True}, {"closed_slots": True}, {"mirror": True}],
)
@pytest.mark.parametrize("name", ["miura", "window"])
def test_a_sheet_with_wishes_gives_its_pattern_back(name, wishes, kind, tmp_path):
    pattern = (
        grid(4, 4, 40.0, without=[(1, 1)])
        if name == "window"
        else scaled(read_pattern(PATTERNS / "miura.fold")[0], width_mm=160)
    )
    machine, material = load_machine("co2_60w_600x400"), load_material("card_300gsm")
    request = SheetRequest(
        material, machine, formats=[kind], page=False, wishes=CutWishes(tabs="none", **wishes)
    )
    made = fabricate(pattern, "sheet", request)
    path = tmp_path / f"sheet_1.{kind}"
    path.write_bytes(made.files[path.name])
    found = read_any([path])
    again = found.pattern
    assert "colour-unknown" not in {finding.code for finding in found.findings}
    assert lengths(again) == pytest.approx(lengths(pattern), rel=1e-4)
