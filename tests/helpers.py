"""What several test modules need: published models, the shipped jobs, rigid fits."""

from __future__ import annotations

import os
from functools import cache
from math import acos, dist
from pathlib import Path

import numpy as np
import pytest

from fab.jobs.job import load_job
from fab.jobs.job_files import make
from fab.outputs import Made

ROOT = Path(__file__).parent.parent
TEMPLATES = ROOT / "templates"
PATTERNS = ROOT / "tests" / "patterns"
DOCS = ROOT / ".github" / "docs"
SHARED = ROOT.parent / "shared"
REFERENCE = SHARED / "reference"

# The variable of the environment that names the folder of files that several tests need.
KEPT = "QUADFOLD_TESTS_KEPT"
TEMPLATE_NAMES = sorted(path.stem for path in TEMPLATES.glob("*.toml"))
# Rings are written with their first two vertices again at the end of each row.
GRIDS = {
    "F4B": (82, 6),
    "F4C": (19, 102),
    "F4D": (11, 101),
    "F4E": (41, 21),
    "F4F": (2, 401),
    "peaks_coarse": (34, 41),
}
# Models that are too large to lie beside every copy of the project.
LARGE = {"F4B", "F4C"}


def published(name: str, state: str) -> np.ndarray:
    """Rows of a model of the method's authors, shape (R, C, 3).

    Skips where their folder is missing, and the large ones, which it holds only where somebody has
    put them there; any other that is missing is an error.
    """
    path = REFERENCE / f"{name}_{state}.obj"
    if not path.is_file():
        place = "the authors' repository additive-origami, folder pattern"
        reason = f"no {path.name} in {REFERENCE.name}: put it there from {place}"
        assert not REFERENCE.is_dir() or name in LARGE, reason
        pytest.skip(reason)
    lines = (line.split() for line in path.read_text().splitlines() if line.startswith("v "))
    rows, columns = GRIDS[name]
    return np.array([[float(x) for x in line[1:4]] for line in lines]).reshape(rows, columns, 3)


def turned_onto(points: np.ndarray, target: np.ndarray) -> np.ndarray:
    """`points` (n, 2) moved onto `target` by the best rotation and shift, never mirrored."""
    a, b = points - points.mean(axis=0), target - target.mean(axis=0)
    za, zb = a[:, 0] + 1j * a[:, 1], b[:, 0] + 1j * b[:, 1]
    turn = np.vdot(za, zb)
    z = za * turn / abs(turn)
    return np.column_stack([z.real, z.imag]) + target.mean(axis=0)


def angle_at(p, q, r) -> float:
    """Angle at q between p and r, by the law of cosines."""
    u, v, w = dist(q, p), dist(q, r), dist(p, r)
    return acos((u * u + v * v - w * w) / (2 * u * v))


@cache
def made_template(name: str) -> Made:
    """All files of a shipped job, made once in a process."""
    made = make(load_job(TEMPLATES / f"{name}.toml"))
    if f"{name}.fold" in made.files:
        _keep(name, made.files[f"{name}.fold"])
    return made


def guide(*names: str) -> str:
    """Pages of the guide in the documentation, one after the other."""
    return "\n".join((DOCS / "guide" / f"{name}.md").read_text("utf-8") for name in names)


@cache
def template_fold(name: str) -> bytes:
    """The FOLD file of a shipped job, for tests that need no other of its files.

    Made once for all processes of the tests, unless two of them begin at the same time.
    """
    kept = Path(os.environ[KEPT], f"{name}.fold")
    if not kept.is_file():
        job = load_job(TEMPLATES / f"{name}.toml")
        _keep(name, make(job, ["fold"]).files[kept.name])
    return kept.read_bytes()


def _keep(name: str, data: bytes) -> None:
    kept = Path(os.environ[KEPT], f"{name}.fold")
    beside = kept.with_suffix(f".{os.getpid()}")
    beside.write_bytes(data)
    beside.replace(kept)
