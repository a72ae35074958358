"""Random walks in space for ribbons to run along."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from solver.errors import require_count
from solver.vectors import FloatArray, angle_between

__all__ = ["can_fold", "random_walks"]

# At every vertex, radians.
_ROOM = 1e-3


def random_walks(steps: int, random_seed: int, draws: int) -> Iterator[FloatArray]:
    """Up to `draws` walks from the origin, shape (steps + 1, 3); the same seed gives the same ones.

    Each step is normally distributed in x, y and z. Raises `InvalidValue` for fewer than 3 steps
    and for a negative seed.
    """
    require_count("steps", steps, 3, "A ribbon needs interior creases.")
    require_count("random_seed", random_seed, 0, "Any whole number in this range will do.")
    random = np.random.Generator(np.random.PCG64(random_seed))
    for _ in range(draws):
        ends = np.cumsum(random.normal(size=(steps, 3)), axis=0)
        yield np.concatenate([np.zeros((1, 3)), ends])


def can_fold(walk: FloatArray, k: FloatArray) -> bool:
    """Whether beta < k < 2 pi - beta at every inner vertex of a walk, with room to spare."""
    edges = np.diff(walk, axis=0)
    beta = angle_between(-edges[:-1], edges[1:])
    return bool((np.abs(k - np.pi) < np.pi - beta - _ROOM).all())
