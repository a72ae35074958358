"""Animations of a sheet: how it grows, strip by strip, and how it folds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import partial
from typing import Any

import numpy as np

from fab.errors import Finding, InvalidJob
from fab.folding.fold_settings import FoldSettings
from fab.folding.quasi_static import Folding
from fab.folding.rigid_findings import with_motion
from fab.folding.rigid_motion import RigidVerdict, rigid_motion
from fab.folding.simulation import fold_and_judge, fold_rigidly_and_judge
from fab.jobs.file_names import ANIMATION
from fab.jobs.grow import Grown
from fab.layers.layer_findings import inspect_layers
from fab.layers.layer_orders import layer_orders
from fab.outputs import Made, with_report
from fab.pattern.crease_pattern import FLAT_ANGLE_DEG, CreasePattern
from fab.pattern.kinematics import unknown_angles
from fab.progress import Progress, silent
from fab.viewing.layered_scene import layered
from fab.viewing.movie_files import FRAME_MS, encoder, gif_bytes, mp4_bytes, there_and_back
from fab.viewing.scene_builders import folding_scene, pattern_scene
from solver.growth_order import faces_strip

__all__ = ["AnimationFormat", "Shown", "animate", "formats_here"]

_STATES = 30
# Sheets of few strips grow slowly, up to so long for a strip, others in about this time.
_GROWTH_MS, _SLOWEST_MS = 6000, 500
_LAST_MS = 2500


class AnimationFormat(StrEnum):
    """The kinds of files of an animation, named by their endings."""

    GIF = "gif"
    MP4 = "mp4"


class Shown(StrEnum):
    """What an animation shows."""

    GROWTH = "growth"
    FOLDING = "folding"


@dataclass(frozen=True)
class _Movie:
    """Pillow images, which of them is shown one after another, and how long, ms."""

    images: Sequence[Any]
    order: Sequence[int]
    times_ms: Sequence[int]


def formats_here() -> list[AnimationFormat]:
    """GIF, and MP4 where an encoder is installed."""
    return list(AnimationFormat) if encoder() else [AnimationFormat.GIF]


def animate(
    sheet: CreasePattern | Grown,
    name: str,
    *,
    shown: Sequence[Shown] | None = None,
    formats: Sequence[AnimationFormat] | None = None,
    settings: FoldSettings | None = None,
    findings: Sequence[Finding] = (),
    progress: Progress = silent,
) -> Made:
    """Animate a sheet: NAME_growth.gif, NAME_motion.gif, and NAME_animation.json, the report.

    MP4 files beside them where an encoder is installed. Growth is shown strip by strip, folding
    from flat to the target and back: along the rigid motion of the sheet where it has one, else as
    it is simulated.

    Parameters
    ----------
    sheet : a pattern in millimetres, or what was grown for a job (`fab.jobs.grow.grown`).
    name : what files and pictures call it.
    shown : both by default, of a pattern its folding alone.
    formats : `formats_here` by default.
    settings : of the simulation, with the number of its states; 30 states by default.
    findings : of its reader, repeated in the report.
    progress : called with (stage, steps done, steps in the stage).

    Raises `InvalidJob` for the growth of a pattern, for MP4 files without an encoder, and for a
    sheet in which nothing folds.
    """
    grown = sheet if isinstance(sheet, Grown) else None
    pattern = sheet.pattern if isinstance(sheet, Grown) else sheet
    if shown is None:
        shown = [Shown.FOLDING] if grown is None else list(Shown)
    formats = formats_here() if formats is None else formats
    _require_possible(pattern, grown, shown, formats)
    movies: dict[str, _Movie] = {}
    report: dict[str, Any] = {"name": name}
    every = list(findings)
    upright = grown is not None and grown.target is not None
    if Shown.GROWTH in shown and grown is not None:
        from fab.viewing.growth_picture import growth_images

        steps = faces_strip(grown.growth.mesh)
        scene = pattern_scene(pattern, name, upright=upright)
        images = growth_images(scene, steps, partial(progress, "draw growth"))
        each = max(FRAME_MS, min(_SLOWEST_MS, _GROWTH_MS // max(1, len(images))))
        times = [each] * (len(images) - 1) + [_LAST_MS]
        movies["growth"] = _Movie(images, range(len(images)), times)
        report["strips"] = int(steps.max(initial=-1)) + 1
    if Shown.FOLDING in shown:
        from fab.viewing.folding_picture import folding_images

        settings = settings or FoldSettings(steps=_STATES)
        folding, rigid, reached, found = _folded(pattern, settings, progress)
        layers = layer_orders(pattern)
        every += [*found, *inspect_layers(layers)]
        scene = layered(
            replace(folding_scene(folding, name, upright=upright), values=None),
            layers if reached else None,
        )
        images = folding_images(scene, partial(progress, "draw folding"))
        movies["motion"] = _Movie(images, *there_and_back(len(images)))
        report |= {"states": len(folding.states), "rigid": rigid}
    files: dict[str, bytes] = {}
    for number, (kind, movie) in enumerate(movies.items()):
        progress("write", number, len(movies))
        files |= _files(f"{name}_{kind}", movie, formats)
    progress("write", len(movies), len(movies))
    return with_report(files, ANIMATION.report_name(name), report, every)


def _require_possible(
    pattern: CreasePattern,
    grown: Grown | None,
    shown: Sequence[Shown],
    formats: Sequence[AnimationFormat],
) -> None:
    """Raise `InvalidJob` for what cannot be shown, or not in these formats."""
    if AnimationFormat.MP4 in formats and encoder() is None:
        raise InvalidJob(
            "mp4: no encoder is installed. `pip install 'quadfold[mp4]'` brings one, and so does "
            "ffmpeg; a GIF needs none."
        )
    if Shown.GROWTH in shown and grown is None:
        raise InvalidJob("growth: a crease pattern does not say how it grew. Give a job (TOML).")
    folds = (np.abs(pattern.edges_foldAngle) > FLAT_ANGLE_DEG) | unknown_angles(pattern)
    if Shown.FOLDING in shown and not (folds & pattern.edges_joining).any():
        raise InvalidJob(
            "folding: no crease folds. Give the file angles or --fold-deg, or show growth alone."
        )


def _folded(
    pattern: CreasePattern, settings: FoldSettings, progress: Progress
) -> tuple[Folding, bool, bool, list[Finding]]:
    """The fold of a pattern, whether it is rigid and reaches its target, and findings about it."""
    motion = rigid_motion(pattern)
    if motion.verdict is RigidVerdict.FOLDS and len(motion.path):
        fold, verdict, found = fold_rigidly_and_judge(pattern, motion, settings, progress)
        return fold.folding, True, verdict.reached, found
    folding, verdict, found = fold_and_judge(pattern, settings, progress=progress)
    return folding, False, verdict.reached, with_motion(found, verdict, motion)


def _files(stem: str, movie: _Movie, formats: Sequence[AnimationFormat]) -> Mapping[str, bytes]:
    writers = {AnimationFormat.GIF: gif_bytes, AnimationFormat.MP4: mp4_bytes}
    return {
        f"{stem}.{kind}": write(movie.images, movie.order, movie.times_ms)
        for kind, write in writers.items()
        if kind in formats
    }
