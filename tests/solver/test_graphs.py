"""Components and edges of graphs, against answers found one by one."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from solver.graphs import EdgeIndex, edge_keys, labels

pairs = st.lists(st.tuples(st.integers(0, 9), st.integers(0, 9)), max_size=30)


@given(pairs)
def test_nodes_have_one_label_exactly_where_a_path_joins_them(edges):
    reached = {n: {n} for n in range(10)}
    for _ in range(10):
        for a, b in edges:
            both = reached[a] | reached[b]
            for n in both:
                reached[n] = both
    label = labels(np.array(edges, int).reshape(-1, 2), 10)
    for a in range(10):
        for b in range(10):
            assert (label[a] == label[b]) == (b in reached[a])
    firsts = [int(np.flatnonzero(label == k)[0]) for k in range(label.max() + 1)]
    assert firsts == sorted(firsts)


@pytest.mark.parametrize("directed", [False, True])
@given(edges=pairs, wanted=pairs)
def test_the_first_edge_between_two_nodes_is_found(edges, wanted, directed):
    index = EdgeIndex.of(np.array(edges, int).reshape(-1, 2), 10, directed=directed)
    found = index.find(np.array(wanted, int).reshape(-1, 2)).tolist()
    for pair, edge in zip(wanted, found, strict=True):
        same = [i for i, e in enumerate(edges) if e == pair or (not directed and e == pair[::-1])]
        assert edge == (same[0] if same else -1)


@given(pairs)
def test_keys_are_equal_for_equal_pairs_alone(edges):
    ends = np.array(edges, int).reshape(-1, 2)
    keys = edge_keys(ends, 10)
    assert len(set(keys.tolist())) == len({tuple(sorted(e)) for e in edges})
