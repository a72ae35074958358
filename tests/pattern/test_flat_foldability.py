"""Letters of flat-folding vertices against known counts, and against all orders of their layers."""

from itertools import permutations, product
from math import comb

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fab.pattern.flat_foldability import balanced_letters, foldable_letters, kawasaki_rad


def folds_flat(sectors, valleys):
    """Whether some order of the layers folds a vertex flat, by trying all of them."""
    count = len(sectors)
    places = np.concatenate([[0.0], np.cumsum(np.where(np.arange(count) % 2, -1, 1) * sectors)])
    places = places[:-1]  # of crease k, between the sectors k - 1 and k
    spans = [sorted((places[k], places[(k + 1) % count])) for k in range(count)]
    for layers in permutations(range(count)):
        if all(
            # a valley brings the next sector above one whose upper side is up
            (layers[k] > layers[k - 1]) == (valleys[k] == ((k - 1) % count % 2 == 0))
            for k in range(count)
        ) and not crosses(places, spans, layers):
            return True
    return False


def crosses(places, spans, layers):
    count = len(places)
    for k in range(count):
        low, high = sorted((layers[k - 1], layers[k]))
        for other in range(count):
            start, end = spans[other]
            through = start + 1e-9 < places[k] < end - 1e-9
            if through and low < layers[other] < high:
                return True
            if other == k or abs(places[other] - places[k]) > 1e-9 or other % 2 != k % 2:
                continue
            # two creases in one place that close the same side must not interlock
            inner = [low < layer < high for layer in (layers[other - 1], layers[other])]
            if inner[0] != inner[1]:
                return True
    return False


def flat_sectors(shares):
    """Sectors that satisfy Kawasaki's condition, in proportion to shares (n,)."""
    out = np.array(shares, float)
    for side in (slice(0, None, 2), slice(1, None, 2)):
        out[side] *= np.pi / out[side].sum()
    return out


@pytest.mark.parametrize("half", [1, 2, 3, 4, 5, 6])
def test_counts_of_hull(half):
    """Equal sectors admit all that Maekawa does; sectors of which no two ever are, 2 ** half."""
    equal = np.full((1, 2 * half), np.pi / half)
    assert foldable_letters(equal, 1e-9).sum() == 2 * comb(2 * half, half - 1)
    assert len(balanced_letters(2 * half)) == 2 * comb(2 * half, half - 1)
    random = np.random.default_rng(half)
    unequal = np.stack([flat_sectors(random.uniform(1, 3, 2 * half)) for _ in range(20)])
    assert (foldable_letters(unequal, 1e-9).sum(axis=1) == 2**half).all()


@pytest.mark.parametrize("degree", [2, 4, 6])
@pytest.mark.parametrize("seed", range(4))
def test_letters_are_those_of_some_order_of_layers(degree, seed):
    """With many equal sectors, as small whole numbers give, and with none."""
    random = np.random.default_rng(seed)
    shares = random.integers(1, 4, degree) if seed < 3 else random.uniform(1, 3, degree)
    sectors = flat_sectors(shares)
    found = foldable_letters(sectors[None], 1e-9)[0]
    listed = {tuple(row) for row in balanced_letters(degree)[found].tolist()}
    exact = {
        letters for letters in product([False, True], repeat=degree) if folds_flat(sectors, letters)
    }
    assert listed == exact


@given(st.integers(1, 6), st.integers(0, 2**32 - 1))
def test_symmetries(half, seed):
    """Turned, mirrored, seen from below, a vertex has as many letters that fold it flat."""
    random = np.random.default_rng(seed)
    sectors = flat_sectors(random.integers(1, 5, 2 * half))
    assert kawasaki_rad(sectors[None]) < 1e-12
    several = np.stack([sectors, np.roll(sectors, 1), sectors[::-1]])
    counts = foldable_letters(several, 1e-9).sum(axis=1)
    assert counts[0] > 0
    assert (counts == counts[0]).all()
    found = balanced_letters(2 * half)[foldable_letters(sectors[None], 1e-9)[0]]
    assert {tuple(row) for row in found.tolist()} == {tuple(row) for row in (~found).tolist()}


@given(st.integers(0, 2**32 - 1), st.floats(1e-9, 1e-3))
def test_sectors_within_the_tolerance_admit_no_more(seed, tolerance):
    random = np.random.default_rng(seed)
    rounded = flat_sectors(random.integers(1, 3, 6))
    change = random.uniform(-1, 1, 6) * tolerance / 8
    change[::2] -= change[::2].mean()
    change[1::2] -= change[1::2].mean()
    exact = foldable_letters((rounded + change)[None], 1e-13)
    assert not (exact & ~foldable_letters((rounded + change)[None], tolerance)).any()
