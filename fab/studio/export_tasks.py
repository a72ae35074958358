"""All files of a job or of a pattern, as `run`, `fabricate` and `thicken` make them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from fab.errors import Finding, InvalidJob
from fab.jobs.grow import grown_pattern
from fab.jobs.job import Job
from fab.jobs.job_files import make
from fab.jobs.reading import read_sheet
from fab.outputs import Made, plain_title, write
from fab.pattern.crease_pattern import CreasePattern
from fab.progress import Progress
from fab.settings import checked
from fab.studio.findings import listed
from fab.studio.job_text import job_of_text
from fab.studio.places import inside
from fab.studio.time_left import TimeLeft, run_stages

__all__ = ["Reports", "export"]


class Reports(Protocol):
    """Takes stage, steps done, steps in the stage, and the seconds that are left."""

    def __call__(self, stage: str, done: float, total: int, left: float | None = None) -> None: ...


@dataclass(frozen=True)
class _Source:
    """What files are made of: a job, or a file of the folder that has a pattern.

    Attributes
    ----------
    folder : where files are looked for that a request names.
    job : the job; None for a file, which is at path.
    """

    folder: Path
    job: Job | None
    path: Path

    @property
    def name(self) -> str:
        return plain_title(self.path.stem) if self.job is None else self.job.name

    def pattern(self, progress: Progress) -> tuple[CreasePattern, Sequence[Finding]]:
        """The crease pattern in mm, and what was found on the way to it."""
        if self.job is not None:
            return grown_pattern(self.job, progress)
        read = read_sheet(self.path)
        return read.pattern, read.findings


def export(
    command: str,
    text: str | None,
    file: str,
    request: Mapping[str, Any],
    folder: str,
    place: str,
    allow_code: bool,
    progress: Reports,
) -> dict[str, Any]:
    """Make files and write them into a folder: names and bytes, findings, and which is the page.

    command : "run", "fabricate" or "thicken". text : of a job; where it is None the pattern in a
    file. request : material, machine, copies and two_sided of `fabricate`; printer and
    print_material of `thicken` where there is no job. place : the folder to write into.

    Raises `InvalidJob`, `InvalidFile` and `InvalidValue`, as the commands refuse.
    """
    home = Path(folder)
    job = None if text is None else job_of_text(text, home, allow_code=allow_code)
    source = _Source(home, job, home / file)
    made, page = _COMMANDS[command](source, request, progress)
    write(made, place)
    return {
        "name": source.name,
        "files": [[name, len(data)] for name, data in made.files.items()],
        "findings": listed(made.findings),
        "findingsCount": len(made.findings),
        "sound": made.within_tolerance,
        "page": page if page in made.files else None,
    }


def _run(source: _Source, request: Mapping[str, Any], progress: Reports) -> tuple[Made, str]:
    del request
    if source.job is None:
        raise InvalidJob("a pattern: only a job can be run. Make sheets or panels of it.")
    timed = _timed(progress, run_stages(source.job.wanted))
    return make(source.job, None, timed), f"{source.name}.html"


def _fabricate(source: _Source, request: Mapping[str, Any], progress: Reports) -> tuple[Made, str]:
    from fab.jobs.sheet_files import fabricate
    from fab.sheets.cutter_settings import CutterSettings

    for key in ("material", "machine"):
        _require_inside(source.folder, request[key])
    keys = {key: request[key] for key in ("material", "machine", "copies", "two_sided")}
    settings = checked(CutterSettings, keys, "sheets", "Choose it.")
    asked = settings.request(guide=True, folder=source.folder)
    timed = _timed(progress, {})
    pattern, findings = source.pattern(timed)
    made = fabricate(pattern, source.name, asked, findings=findings, progress=timed)
    return made, f"{source.name}_sheets.html"


def _thicken(source: _Source, request: Mapping[str, Any], progress: Reports) -> tuple[Made, str]:
    from fab.jobs.print_files import ORDINARY, make_thick
    from fab.printing.thick_settings import PrinterSettings, ThickSettings

    if source.job is not None:
        tables = {key: getattr(source.job, key) for key in ThickSettings.model_fields}
    else:
        named = {"machine": request["printer"], "material": request["print_material"]}
        chosen = {key: name for key, name in named.items() if name}
        for name in chosen.values():
            _require_inside(source.folder, name)
        tables = {"printer": PrinterSettings(**chosen)}
    settings = ThickSettings(**tables)
    timed = _timed(progress, run_stages(ORDINARY))
    pattern, findings = source.pattern(timed)
    made = make_thick(
        pattern,
        source.name,
        settings,
        print_with=settings.print_with(source.folder),
        findings=findings,
        progress=timed,
    )
    return made, f"{source.name}_thick.html"


def _require_inside(folder: Path, name: str) -> None:
    """Raise `InvalidJob` for a material or machine that is a file outside of the folder."""
    if name.endswith(".toml"):
        inside(folder, name)


def _timed(progress: Reports, stages: Mapping[str, float]) -> Progress:
    """Progress that says how many seconds are left."""
    left = TimeLeft(stages)
    return lambda stage, done, total: progress(stage, done, total, left(stage, done, total))


_COMMANDS: Mapping[str, Callable[[_Source, Mapping[str, Any], Reports], tuple[Made, str]]] = {
    "run": _run,
    "fabricate": _fabricate,
    "thicken": _thicken,
}
