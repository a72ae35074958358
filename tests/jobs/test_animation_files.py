"""Animations of growth and of folding, from Python and from the command line."""

import io
import json
import re
from itertools import pairwise

import numpy as np
import pytest
from click.testing import CliRunner
from flat_patterns import grid, pattern_of
from helpers import PATTERNS, TEMPLATES
from PIL import Image

from fab.cli.group import main
from fab.errors import InvalidJob
from fab.folding.fold_settings import FoldSettings
from fab.jobs import animation_files
from fab.jobs.animation_files import AnimationFormat, Shown, animate, formats_here
from fab.jobs.grow import grown
from fab.jobs.job import parse_job
from fab.progress import Clock, silent

GIF = [AnimationFormat.GIF]


def run(*words):
    return CliRunner().invoke(main, ["animate", *map(str, words)])


def small(rows=4):
    design = {"kind": "miura", "columns": 4, "rows": rows}
    job = parse_job({"name": "m", "design": design, "sheet": {"width_mm": 90.0}})
    return grown(job, Clock(silent))


def frames(data):
    with Image.open(io.BytesIO(data)) as movie:
        out = []
        for number in range(movie.n_frames):
            movie.seek(number)
            out.append(np.asarray(movie.convert("RGB"), int))
        return out


def drawn(frame):
    """Pixels of faces."""
    return np.ptp(frame[40:740], axis=2) > 15


def test_a_sheet_grows_strip_by_strip_and_keeps_what_it_has():
    made = animate(small(), "m", shown=[Shown.GROWTH], formats=GIF)
    assert sorted(made.files) == ["m_animation.json", "m_growth.gif"]
    assert made.report["strips"] == 4
    shown = [drawn(frame) for frame in frames(made.files["m_growth.gif"])]
    assert len(shown) == 4
    assert shown[0].sum() > 5000
    for before, after in pairwise(shown):
        assert after.sum() > before.sum() + 5000
        # what has grown stays where it is, but for lines between its faces and new ones
        assert (before & ~after).sum() < 0.02 * before.sum()


def test_a_miura_sheet_folds_along_its_rigid_motion_and_back():
    settings = FoldSettings(steps=4)
    progress = []
    made = animate(
        small(),
        "m",
        formats=GIF,
        settings=settings,
        progress=lambda *step: progress.append(step),
    )
    assert sorted(made.files) == ["m_animation.json", "m_growth.gif", "m_motion.gif"]
    assert made.report["rigid"] is True
    assert made.report["states"] == 5
    assert "folds-rigidly" in {finding.code for finding in made.findings}
    shown = frames(made.files["m_motion.gif"])
    assert len(shown) == 5 + 3
    areas = [drawn(frame).sum() for frame in shown[:5]]
    assert areas == sorted(areas, reverse=True)  # it folds up
    assert np.array_equal(shown[1], shown[-1])
    stages = {stage for stage, _, _ in progress}
    assert {"draw growth", "draw folding", "write"} <= stages
    assert all(0 <= done <= total for _, done, total in progress)
    json.loads(made.files["m_animation.json"])


def test_the_same_sheet_gives_the_same_bytes():
    settings = FoldSettings(steps=1)
    first, second = (animate(small(2), "m", formats=GIF, settings=settings) for _ in "ab")
    assert first.files == second.files


def test_a_pattern_shows_its_folding_alone_as_it_is_simulated():
    result = run(PATTERNS / "square_twist.fold", "--states", 3, "--only", "gif", "--dry-run")
    assert result.exit_code == 1  # it is shown, and said not to lie flat
    assert "error: cannot-lie-flat" in result.output
    assert "would write square_twist_motion.gif" in result.output
    assert "growth" not in result.output
    assert "folds as it is simulated: 4 states" in result.output


def test_a_job_is_animated_from_its_file(tmp_path):
    text = (TEMPLATES / "miura.toml").read_text()
    job = tmp_path / "miura.toml"
    job.write_text(text.replace("rows = 8", "rows = 3"))
    out = tmp_path / "out"
    result = run(job, "--show", "growth", "--only", "gif", "--out", out)
    assert result.exit_code == 0, result.output
    assert "grows in 3 strips" in result.output
    names = sorted(path.name for path in out.iterdir())
    assert names == ["miura_animation.json", "miura_growth.gif"]


def test_mp4_files_are_made_where_there_is_an_encoder(monkeypatch):
    monkeypatch.setattr(animation_files, "encoder", lambda: None)
    assert formats_here() == GIF
    with pytest.raises(InvalidJob, match=re.escape("pip install 'quadfold[mp4]'")):
        animate(small(), "m", formats=[AnimationFormat.MP4])
    monkeypatch.setattr(animation_files, "encoder", lambda: "ffmpeg")
    assert formats_here() == [AnimationFormat.GIF, AnimationFormat.MP4]


def test_what_cannot_be_shown_is_refused():
    with pytest.raises(InvalidJob, match="does not say how it grew"):
        animate(grid(2, 2, 10.0), "g", shown=[Shown.GROWTH], formats=GIF)
    flat = pattern_of([[0, 0], [10, 0], [10, 10], [0, 10]], [[0, 1, 2, 3]])
    with pytest.raises(InvalidJob, match="no crease folds"):
        animate(flat, "flat", formats=GIF)


@pytest.mark.parametrize(
    ("words", "match"),
    [
        ([PATTERNS / "miura.fold", "--show", "growth"], "does not say how it grew"),
        ([PATTERNS / "miura.fold", "--states", 0], "steps"),
        ([PATTERNS / "miura.fold", "--only", "avi"], "--only 'avi'"),
        ([TEMPLATES / "miura.toml", "--width-mm", 100], "a job says itself"),
        (["missing.toml"], "cannot be read"),
        (["missing.fold"], "cannot be read"),
    ],
)
def test_bad_usage_is_refused(words, match):
    result = run(*words)
    assert result.exit_code == 2
    assert match in result.output
