"""Which files tell that a crease pattern folds: states, pictures, and the verdict?"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from enum import StrEnum

from fab.errors import Finding
from fab.folding.fold_settings import FoldSettings
from fab.folding.simulation import Solver, simulated
from fab.folding.verdict import target_form
from fab.formats.fold_writer import fold_bytes
from fab.outputs import Made, with_report
from fab.pattern.crease_pattern import CreasePattern
from fab.pattern.inspection import inspect_angles
from fab.progress import Progress

__all__ = ["SimulationFormat", "simulate"]


class SimulationFormat(StrEnum):
    """The kinds of files of a simulation, named by their endings."""

    FOLD = "fold"
    PNG = "png"
    GIF = "gif"


def simulate(
    pattern: CreasePattern,
    name: str,
    settings: FoldSettings | None = None,
    *,
    solver: Solver = Solver.QUASI_STATIC,
    formats: Sequence[SimulationFormat] = tuple(SimulationFormat),
    findings: Sequence[Finding] = (),
    progress: Progress | None = None,
) -> Made:
    """Files of a simulation, all in memory: NAME_folding.fold, .png, .gif and .json.

    pattern : in millimetres; findings : of its reader, told again in the report.
    progress : called with (stage, steps done, steps in the stage).

    The FOLD file has the sheet with its cuts open, its folded form (that of the pattern, or of its
    angles where they close, or what it folds to), and a frame for each state. The report holds the
    verdict.
    """
    settings = settings or FoldSettings()
    tell = progress if progress is not None else lambda *_: None
    folding, verdict, told = simulated(pattern, settings, solver, progress)
    files: dict[str, bytes] = {}
    stem = f"{name}_folding"
    sheet = folding.frame.sheet.pattern
    if SimulationFormat.FOLD in formats:
        tell("write", 0, 1)
        states = [
            (f"{state.load:.2%} of the way", state.coords * folding.frame.size_mm)
            for state in folding.states[1:]
        ]
        form = target_form(folding.frame)
        if form is None and verdict.reached:
            form = folding.states[-1].coords
        folded = None if form is None else form * folding.frame.size_mm
        files[f"{stem}.fold"] = fold_bytes(replace(sheet, folded_coords=folded), name, states)
    if SimulationFormat.PNG in formats:
        from fab.folding.animation import strain_png_bytes

        tell("draw", 0, 1)
        files[f"{stem}.png"] = strain_png_bytes(folding, name)
    if SimulationFormat.GIF in formats:
        from fab.folding.animation import gif_bytes

        files[f"{stem}.gif"] = gif_bytes(folding, name, lambda *at: tell("draw", *at))
    every = [*findings, *inspect_angles(sheet), *told]
    report = {
        "name": name,
        "solver": solver,
        "settings": settings.model_dump(mode="json"),
        "verdict": verdict.report(),
    }
    tell("write", 1, 1)
    return with_report(files, f"{stem}.json", report, every)
