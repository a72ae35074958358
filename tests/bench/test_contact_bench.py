"""Folds in contact beside those without, on patterns whose faces pass through each other without.

    pytest tests/bench/test_contact_bench.py --benchmark-only

Nothing crosses at any state, the energy never rises, and the cost is at most five times that
without contact; less than twice for all ten together. Both times are the best of some runs in turn,
so that what else the machine does counts little; their ratio is in `extra_info`.
"""

import time

import numpy as np
import pytest
from helpers import PATTERNS
from shared_cases import shared_case

from fab import read_pattern
from fab.folding.bar_hinge_model import framework
from fab.folding.contact.contact_fold import fold_in_contact
from fab.folding.quasi_static import fold
from solver.self_intersection import crossing_faces

OWN = ["bird_base", "crane", "maze", "resch", "square_twist", "yoshimura"]
SHARED = ["crane_folded_form_0.3mm_off", "crane_plain", "cross", "framepart"]
AT_MOST = 5.0
RUNS = 4


def crossings(folding):
    triangles = folding.frame.triangles_vertices
    ends = triangles.ravel(), 3 * np.arange(len(triangles) + 1)
    return [len(crossing_faces(state.coords, *ends)) for state in folding.states]


@pytest.mark.parametrize("name", OWN + SHARED)
def test_a_fold_in_contact_beside_one_without(benchmark, name):
    file = PATTERNS / f"{name}.fold" if name in OWN else shared_case(f"{name}.fold")
    frame = framework(read_pattern(file)[0])
    took = {fold: [], fold_in_contact: []}
    made = {}
    for _ in range(RUNS):
        for each in (fold, fold_in_contact):
            begin = time.process_time()
            made[each] = each(frame)
            took[each].append(time.process_time() - begin)
    ratio = min(took[fold_in_contact]) / min(took[fold])
    benchmark.extra_info["ratio"] = ratio
    benchmark.pedantic(fold_in_contact, args=(frame,), rounds=1)
    assert any(crossings(made[fold]))
    assert not any(crossings(made[fold_in_contact]))
    for state in made[fold_in_contact].states:
        assert (np.diff(state.accepted) <= 0).all()
    assert ratio <= AT_MOST
