"""The simulation of a sheet for the page, as `simulate` makes it: states, words and findings."""

from __future__ import annotations

from pathlib import Path

from fab.errors import Severity
from fab.folding.fold_settings import FoldSettings
from fab.jobs.job_files import grown_sheet
from fab.jobs.reading import read_sheet
from fab.jobs.simulated_sheet import SimulatedSheet, sentences, simulated_sheet
from fab.outputs import plain_title
from fab.pattern.crease_pattern import CreasePattern
from fab.progress import Progress
from fab.studio.export_tasks import Reports
from fab.studio.findings import listed
from fab.studio.job_text import job_of_text
from fab.studio.messages import packed_answer
from fab.studio.time_left import TimeLeft
from fab.viewing.face_triangles import face_corner_triangles
from fab.viewing.view_choice import best_view
from solver.vectors import FloatArray, IntArray

__all__ = ["simulate", "simulate_file"]


def simulate(text: str, folder: str, allow_code: bool, contact: bool, progress: Reports) -> bytes:
    """That of a job, with its settings, without what it carries. Raises `InvalidJob`.

    contact : whether faces stop each other, also where the settings leave that open.
    """
    timed = _timed(progress)
    sheet = grown_sheet(job_of_text(text, Path(folder), allow_code=allow_code), timed)
    cutter = sheet.settings.cutter
    made = simulated_sheet(
        sheet.pattern,
        _settings(sheet.settings.simulation or FoldSettings(), contact),
        material=None if cutter is None else cutter.material,
        progress=timed,
    )
    return _answer(made, sheet.pattern, sheet.settings.name, upright=sheet.upright)


def simulate_file(path: str, contact: bool, progress: Reports) -> bytes:
    """That of the pattern in a file; contact : as for `simulate`. Raises `InvalidFile`."""
    read = read_sheet(Path(path))
    made = simulated_sheet(
        read.pattern,
        _settings(FoldSettings(), contact),
        face_orders=read.face_orders,
        progress=_timed(progress),
    )
    return _answer(made, read.pattern, plain_title(Path(path).stem), upright=False)


def _settings(settings: FoldSettings, contact: bool) -> FoldSettings:
    return settings.model_copy(update={"contact": True}) if contact else settings


def _timed(progress: Reports) -> Progress:
    """Progress that says how many seconds are left of a stage."""
    left = TimeLeft({})
    return lambda stage, done, total: progress(stage, done, total, left(stage, done, total))


def _answer(made: SimulatedSheet, pattern: CreasePattern, name: str, *, upright: bool) -> bytes:
    """The states of the form, which has edges of its own where cuts are open, and what is found.

    edgesSource : the number of each of its edges in the pattern, which findings name.
    """
    scene = made.scene(name, upright=upright)
    form = scene.pattern
    triangles, faces = face_corner_triangles(form)
    rows = form.faces_vertices[triangles]
    view = best_view([scene.states_coords[-1][rows]], faces, upright=scene.upright)[2]
    wrong = any(finding.severity is Severity.ERROR for finding in made.findings)
    head = {
        "sentences": list(sentences(made.report())),
        "wrong": wrong,
        "states": scene.state_count,
        "shares": scene.shares.tolist(),
        "letters": "".join(form.edges_assignment.tolist()),
        "view": view.tolist(),
        "findings": listed(made.findings, pattern),
        "findingsCount": len(made.findings),
    }
    arrays: dict[str, FloatArray | IntArray] = {
        "positions": scene.states_coords,
        "triangles": rows,
        "trianglesFace": faces,
        "edges": form.edges_vertices,
        "edgesSource": made.folding.frame.sheet.edges_source,
    }
    return packed_answer(head, arrays)
