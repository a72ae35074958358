"""Names of the files of each command, by which those of an earlier run are found.

Every command has a family of files: that of a job, its sheets, its thick panels, its folding, its
animation. `run` makes the pattern anew that all the others are made from, so that files of every
family are older than it.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

__all__ = ["ANIMATION", "FAMILIES", "FOLDING", "JOB", "SHEETS", "THICK", "Family", "left_over"]


@dataclass(frozen=True)
class Family:
    """The files of a command, by what follows the name of the job or pattern in theirs.

    report : of the report; others : a regular expression, of all others.
    """

    report: str
    others: str

    def report_name(self, name: str) -> str:
        """The file of the report of a job or pattern.

        >>> SHEETS.report_name("miura")
        'miura_sheets_report.json'
        """
        return f"{name}{self.report}"


# Of folds that were cut short (`fab.folding.checkpoints`) and that this run does not take up.
_CHECKPOINT = r"_checkpoint_[0-9a-f]{12}\.npz"
JOB = Family(
    "_report.json",
    r"(_plate_\d+|_bodies)?\.(fold|dxf|svg|pdf|step|stl|3mf|png|zip|glb|html)|_loads\.png|"
    + _CHECKPOINT,
)
SHEETS = Family(
    "_sheets_report.json",
    r"_\d+(_front|_back)?(_frame)?\.(dxf|svg|pdf|lbrn2|plt|gcode)|_(sheets\.html|assembly\.pdf)",
)
THICK = Family(
    "_thick_report.json",
    r"_thick((_plate_\d+|_bodies)?\.(step|stl|3mf|png|zip|glb|html)|_assembly\.pdf)",
)
FOLDING = Family("_folding.json", r"_folding(\.(fold|png|gif|glb|html)|_loads\.png)|" + _CHECKPOINT)
ANIMATION = Family("_animation.json", r"_(growth|motion)\.(gif|mp4)")
FAMILIES = (JOB, SHEETS, THICK, FOLDING, ANIMATION)


def left_over(
    files: Iterable[str], name: str, families: Sequence[Family], folder: Path
) -> list[Path]:
    """Files of some families in a folder that are not among `files`: those of an earlier run.

    name : of the job or pattern.
    """
    present = sorted(folder.iterdir()) if folder.is_dir() else []
    ends = "|".join(f"{re.escape(each.report)}|{each.others}" for each in families)
    called = re.compile(f"{re.escape(name)}({ends})")
    made = set(files)
    return [path for path in present if called.fullmatch(path.name) and path.name not in made]
