"""Faults of drawings: lines moved, lost, repeated, crossed and torn as no good drawing has them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

__all__ = ["EXTREMES", "Drawn", "with_faults"]

EXTREMES = [
    *(0.0, -0.0, 1e-322, 5e-324, 1e-300, 1e-160, 1e-51, 1e-16, 1e-9, 1e-3, 1.0, 0.1 + 0.2),
    *(1e3, 1e6, 1e9, 1e15, 2.0**31, 2.0**53 + 1, 2.0**63, 1e49, 1e51, 1e154, 1e300, 1.7e308),
]
_MOST = 400


@dataclass(frozen=True)
class Drawn:
    """Lines (n, 2, 2) in mm, their letters and fold angles in degrees."""

    coords: np.ndarray
    letters: np.ndarray
    angles: np.ndarray

    def part(self, rows) -> Drawn:
        return Drawn(self.coords[rows], self.letters[rows], self.angles[rows])

    def more(self, coords, letters) -> Drawn:
        """With further lines, which fold by 90 degrees."""
        coords = np.asarray(coords, float).reshape(-1, 2, 2)
        letters = np.broadcast_to(np.asarray(letters, "U1"), len(coords))
        angles = np.where(letters == "V", 90.0, np.where(letters == "M", -90.0, 0.0))
        return Drawn(
            np.concatenate([self.coords, coords]),
            np.concatenate([self.letters, letters]),
            np.concatenate([self.angles, angles]),
        )

    @property
    def size(self) -> float:
        return float(np.ptp(self.coords.reshape(-1, 2), axis=0).max()) or 1.0


def _some(random, count, most=6):
    return random.choice(count, min(count, int(random.integers(1, most + 1))), replace=False)


def _near(random, size):
    """A small distance, from far below any tolerance to above it."""
    return size * 10.0 ** random.uniform(-14, -1) * random.choice([-1, 1])


def _gaps_and_overshoots(random, drawn):
    coords = drawn.coords.copy()
    for row in _some(random, len(coords)):
        end = random.integers(2)
        span = coords[row, end] - coords[row, 1 - end]
        length = np.hypot(*span) or 1.0
        coords[row, end] += span / length * _near(random, drawn.size)
    return Drawn(coords, drawn.letters, drawn.angles)


def _moved_ends(random, drawn):
    coords = drawn.coords.copy()
    for row in _some(random, len(coords)):
        coords[row, random.integers(2)] += [_near(random, drawn.size) for _ in range(2)]
    return Drawn(coords, drawn.letters, drawn.angles)


def _noise(random, drawn):
    coords = drawn.coords + random.normal(size=drawn.coords.shape) * _near(random, drawn.size)
    return Drawn(coords, drawn.letters, drawn.angles)


def _rounded(random, drawn):
    digits = int(random.integers(-1, 5))
    return Drawn(np.round(drawn.coords, digits), drawn.letters, drawn.angles)


def _repeated(random, drawn):
    rows = _some(random, len(drawn.coords))
    again = drawn.part(rows)
    turned = again.coords[:, ::-1] if random.integers(2) else again.coords
    shift = _near(random, drawn.size) if random.integers(2) else 0.0
    letters = random.choice(list("BMVFUCJ"), len(rows)) if random.integers(2) else again.letters
    return drawn.more(turned + shift, letters)


def _overlapping(random, drawn):
    coords, letters = [], []
    for row in _some(random, len(drawn.coords)):
        start, end = drawn.coords[row]
        low, high = np.sort(random.uniform(-0.3, 1.3, 2))
        tilt = (end - start)[::-1] * [1, -1] * _near(random, 1.0)
        coords.append([start + low * (end - start), start + high * (end - start) + tilt])
        letters.append(str(drawn.letters[row]) if random.integers(2) else "F")
    return drawn.more(coords, letters)


def _removed(random, drawn):
    keep = np.ones(len(drawn.coords), bool)
    keep[_some(random, len(keep), 4)] = False
    return drawn.part(keep) if keep.any() else drawn


def _reordered(random, drawn):
    out = drawn.part(random.permutation(len(drawn.coords)))
    turned = random.integers(0, 2, len(out.coords)).astype(bool)
    coords = np.where(turned[:, None, None], out.coords[:, ::-1], out.coords)
    return Drawn(coords, out.letters, out.angles)


def _other_letters(random, drawn):
    letters = drawn.letters.astype("U1").copy()
    rows = _some(random, len(letters), 10)
    letters[rows] = random.choice(list("BMVFUCJ"), len(rows))
    return Drawn(drawn.coords, letters, drawn.angles)


def _one_letter(random, drawn):
    letters = np.full(len(drawn.letters), random.choice(list("BMVFUCJ")))
    return Drawn(drawn.coords, letters, drawn.angles)


def _other_angles(random, drawn):
    angles = drawn.angles.copy()
    rows = _some(random, len(angles))
    angles[rows] = random.choice([0.0, 1e-9, 45.0, -90.0, 179.999999, 180.0, -180.0], len(rows))
    return Drawn(drawn.coords, drawn.letters, angles)


def _crossed(random, drawn):
    low, high = drawn.coords.min(axis=(0, 1)), drawn.coords.max(axis=(0, 1))
    count = int(random.integers(1, 25))
    ends = random.uniform(low, high, (count, 2, 2))
    if random.integers(3) == 0:  # through one point, or almost
        middle = random.uniform(low, high)
        ends[:, 1] = 2 * middle - ends[:, 0]
        ends += random.normal(size=ends.shape) * _near(random, drawn.size)
    elif random.integers(3) == 0:  # nearly parallel
        ends[1:] = ends[:1] + random.normal(size=(count - 1, 2, 2)) * _near(random, drawn.size)
    return drawn.more(ends, random.choice(list("MVFUC"), count))


def _ring(middle, radius, corners):
    turn = np.arange(corners) * 2 * np.pi / corners
    ring = middle + radius * np.column_stack([np.cos(turn), np.sin(turn)])
    return np.stack([ring, np.roll(ring, -1, axis=0)], axis=1)


def _islands(random, drawn):
    low, high = drawn.coords.min(axis=(0, 1)), drawn.coords.max(axis=(0, 1))
    out = drawn
    for _ in range(int(random.integers(1, 5))):
        radius = drawn.size * 10.0 ** random.uniform(-5, -0.2)
        ring = _ring(random.uniform(low, high), radius, int(random.integers(3, 9)))
        out = out.more(ring, random.choice(list("BMVFUC")))
    return out


def _slits(random, drawn):
    coords = []
    for row in _some(random, len(drawn.coords)):  # at a line, with a gap, or across it
        start, end = drawn.coords[row]
        foot = start + random.uniform() * (end - start)
        across = (end - start)[::-1] * [1, -1] * random.uniform(-0.4, 0.4)
        gap = across * _near(random, 1.0) if random.integers(2) else 0.0
        coords.append([foot + gap, foot + across])
    return drawn.more(coords, random.choice(list("CMVF")))


def _framed(random, drawn):
    low, high = drawn.coords.min(axis=(0, 1)), drawn.coords.max(axis=(0, 1))
    margin = abs(_near(random, drawn.size)) * random.choice([0, 1, 1])
    (x, y), (z, w) = low - margin, high + margin
    corners = np.array([[x, y], [z, y], [z, w], [x, w]])
    return drawn.more(np.stack([corners, np.roll(corners, -1, axis=0)], axis=1), "B")


def _again_beside(random, drawn):
    shift = random.choice([1.0, 1.1, 1.0 + 1e-7, 0.5, 0.999]) * np.ptp(
        drawn.coords.reshape(-1, 2), axis=0
    )
    shift[random.integers(2)] = 0.0
    return drawn.more(drawn.coords + shift, drawn.letters)


def _cut_up(random, drawn):
    """Lines as chains of short ones."""
    coords, rows = [], []
    for row in range(len(drawn.coords)):
        count = int(random.integers(1, 6))
        share = np.concatenate([[0.0], np.sort(random.uniform(size=count - 1)), [1.0]])
        points = drawn.coords[row, 0] + share[:, None] * np.diff(drawn.coords[row], axis=0)
        coords.append(np.stack([points[:-1], points[1:]], axis=1))
        rows += [row] * count
    return Drawn(np.concatenate(coords), drawn.letters[rows], drawn.angles[rows])


def _without_length(random, drawn):
    points = drawn.coords[_some(random, len(drawn.coords)), 0]
    shift = random.choice([0.0, abs(_near(random, drawn.size))])
    return drawn.more(np.stack([points, points + shift], axis=1), random.choice(list("BMC")))


def _scaled(random, drawn):
    factor = 10.0 ** random.uniform(-8, 8) * random.choice([-1, 1])
    if random.integers(2):
        factor = np.array([factor, random.choice([factor, 1e-12 * factor, 0.0])])
    return Drawn(drawn.coords * factor, drawn.letters, drawn.angles)


def _shifted(random, drawn):
    shift = drawn.size * 10.0 ** random.uniform(-2, 14, 2)
    return Drawn(drawn.coords + shift, drawn.letters, drawn.angles)


def _extremes(random, drawn):
    coords = drawn.coords.copy().reshape(-1)
    for place in _some(random, len(coords), 3):
        coords[place] = random.choice(EXTREMES) * random.choice([-1, 1])
    return Drawn(coords.reshape(-1, 2, 2), drawn.letters, drawn.angles)


def _soup(random, drawn):
    count = int(random.integers(1, 80))
    ends = random.uniform(0, 100, (count, 2, 2))
    if random.integers(2):
        ends = np.round(ends / 10) * 10
    return Drawn(ends, random.choice(list("BMVFUCJ"), count), np.zeros(count))


_FAULTS: list[tuple[float, Callable]] = [
    (3.0, _gaps_and_overshoots),
    (2.0, _moved_ends),
    (1.0, _noise),
    (1.0, _rounded),
    (2.0, _repeated),
    (2.0, _overlapping),
    (2.0, _removed),
    (1.0, _reordered),
    (1.0, _other_letters),
    (0.3, _one_letter),
    (1.0, _other_angles),
    (2.0, _crossed),
    (2.0, _islands),
    (2.0, _slits),
    (1.0, _framed),
    (1.0, _again_beside),
    (1.0, _cut_up),
    (1.0, _without_length),
    (0.5, _scaled),
    (0.5, _shifted),
    (0.3, _extremes),
    (0.3, _soup),
]


def with_faults(random: np.random.Generator, drawn: Drawn) -> Drawn:
    """The drawing with up to four faults; its border is spared in two of three drawings."""
    border = drawn.part(drawn.letters == "B")
    spared = bool(random.integers(3)) and len(border.coords) < len(drawn.coords)
    if spared:
        drawn = drawn.part(drawn.letters != "B")
    weights = np.array([weight for weight, _ in _FAULTS])
    for _ in range(int(random.integers(0, 5))):
        fault = _FAULTS[random.choice(len(_FAULTS), p=weights / weights.sum())][1]
        drawn = fault(random, drawn)
        if len(drawn.coords) > _MOST:
            drawn = drawn.part(np.sort(random.choice(len(drawn.coords), _MOST, replace=False)))
    if spared:
        out = drawn.more(border.coords, "B")
        drawn = out.part(random.permutation(len(out.coords))) if random.integers(2) else out
    return drawn
