"""Cost of splitting a sheet, from a thousand faces to fifty thousand, and how even its pieces are.

    pytest tests/bench --benchmark-only -s

`relative_cost` is the time per face over that in the smallest sheet, measured in the same run.
"""

import time

import numpy as np
import pytest

from fab.pattern.crease_pattern import crease_pattern, scaled
from fab.pattern.development import develop
from fab.sheets.pieces import SheetSplit, split
from solver import Miura

BED = (600.0, 400.0)


def miura(faces, width_mm):
    side = round(faces**0.5)
    mesh = Miura(columns=side, rows=side, fold=np.radians(40)).grow().mesh
    return scaled(crease_pattern(mesh, develop(mesh), 1.0), width_mm=width_mm)


@pytest.mark.parametrize(
    "width_mm",
    [lambda _: 3000.0, lambda faces: 30.0 * faces**0.5],
    ids=["the same sheet in finer faces", "larger sheets of faces of 30 mm"],
)
def test_cost_of_a_face(benchmark, width_mm):
    sizes, pieces, uneven, cost = [], [], [], []
    for faces in (1_000, 10_000, 50_000):
        pattern = miura(faces, width_mm(faces))
        begin = time.perf_counter()
        made, _ = split(pattern, SheetSplit(), BED)
        cost.append((time.perf_counter() - begin) / pattern.face_count)
        sizes.append(pattern.face_count)
        pieces.append(len(made.pieces))
        held = np.array([(piece.faces >= 0).sum() for piece in made.pieces])
        uneven.append(round(float(held.max() / held.mean()), 3))
    benchmark.pedantic(split, args=(miura(1_000, 1000.0), SheetSplit(), BED))
    relative = [round(own / cost[0], 2) for own in cost]
    figures = {"faces": sizes, "pieces": pieces, "largest_per_mean": uneven}
    figures |= {"relative_cost": relative, "us_per_face": [round(own * 1e6) for own in cost]}
    benchmark.extra_info.update(figures)
    print(f"\n{figures}")
    assert relative[-1] < 4
