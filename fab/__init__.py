"""Fabrication of origami: what a cutter, a printer, a CAD program and a simulator take.

`import fab` alone loads nothing; each name below is loaded where it is first used.

| to | call |
|---|---|
| run a job | `load_job`, `parse_job`, `make`; `write` what was `Made` |
| make files of a folded quad mesh | `from_mesh`, a `Sheet`: `sheet.write("out", ["dxf", "fold"])` |
| read a crease pattern | `read_pattern`, with `ReadOptions`; `read_any` and `convert` |
| cut it | `fabricate` a `SheetRequest`, of `CutterSettings`, or `load_material`, `load_machine` |
| cut several together | `fabricate_together` some `PatternCopies` |
| fold it | `simulate`, with `FoldSettings`; `rigid_motion`, with flat faces |
| know whether it lies flat, and in which layers | `layer_orders` |
| see it grow and fold | `animate` |
| run many variations of a job | `sweep` |
| print it | `make_thick`, with `thick_settings` |
| have it as solids | `thicken`, with `PanelSettings` and `HingeSettings`; `step_bytes` |
| have it in build123d | `assembly`, a Compound with a joint at every crease; `pose` it |

Its wings, each of which imports only wings above it:

findings : what each code of a finding means, its cause and its cure.
geometry : rings, planar graphs, triangulations and closed solids as arrays.
pattern : the crease pattern in millimetres: development, kinematics, self-intersection.
formats : files of other programs: patterns in SVG, DXF, CP, OPX, ORI, ORH, FOLD and OBJ are read,
    in SVG, DXF, CP, FOLD and OBJ written; surfaces in STL, OBJ, PLY and STEP are read.
surfaces : files to clean triangle meshes that designs follow.
layers : whether a flat-folded sheet has an order of its layers, how many, and which.
layout : faces divided into pieces, and pieces placed on beds.
drawings : cut paths by operation, written as DXF, SVG and PDF, and in formats of machines.
sheets : a pattern as laser-cut sheets.
folding : simulation from flat to folded, and its verdict.
panels : thick panels and their hinges, CAD assemblies.
clearance : bodies that must stay apart in every folded state.
printing : printers, plates and joints, STL and 3MF.
viewing : one scene of a sheet, flat to folded, for all pictures of it.
jobs : a job to all its files.
sweeps : many variations of a job, in one table.
studio : a page in the browser that changes a job, and shows what it makes.
cli : the command line.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fab.errors import Finding, InvalidFile, InvalidJob, Severity
    from fab.folding.fold_settings import FoldSettings
    from fab.folding.rigid_motion import rigid_motion
    from fab.formats.read_options import ReadOptions
    from fab.jobs.animation_files import animate
    from fab.jobs.conversion import convert
    from fab.jobs.folding_files import simulate
    from fab.jobs.job import Job, load_job, parse_job
    from fab.jobs.job_files import Format, Sheet, from_mesh, make
    from fab.jobs.print_files import make_thick
    from fab.jobs.reading import read_any, read_pattern
    from fab.jobs.sheet_files import fabricate, fabricate_together
    from fab.layers.layer_orders import layer_orders
    from fab.outputs import Made, write
    from fab.panels.bevelled_panels import PanelSettings
    from fab.panels.cad_assembly import assembly, pose
    from fab.panels.hinges import HingeSettings
    from fab.panels.step import step_bytes
    from fab.panels.thick_sheet import thicken
    from fab.pattern.crease_pattern import CreasePattern
    from fab.printing.thick_settings import thick_settings
    from fab.sheets.cut_pieces import PatternCopies
    from fab.sheets.cutter_settings import CutterSettings
    from fab.sheets.materials import load_machine, load_material
    from fab.sheets.sheet_request import SheetRequest
    from fab.sweeps.sweep_run import sweep

    __version__: str

__all__ = [
    "CreasePattern",
    "CutterSettings",
    "Finding",
    "FoldSettings",
    "Format",
    "HingeSettings",
    "InvalidFile",
    "InvalidJob",
    "Job",
    "Made",
    "PanelSettings",
    "PatternCopies",
    "ReadOptions",
    "Severity",
    "Sheet",
    "SheetRequest",
    "__version__",
    "animate",
    "assembly",
    "convert",
    "fabricate",
    "fabricate_together",
    "from_mesh",
    "layer_orders",
    "load_job",
    "load_machine",
    "load_material",
    "make",
    "make_thick",
    "parse_job",
    "pose",
    "read_any",
    "read_pattern",
    "rigid_motion",
    "simulate",
    "step_bytes",
    "sweep",
    "thick_settings",
    "thicken",
    "write",
]

# The module of each name.
_MODULES = {
    "CreasePattern": "fab.pattern.crease_pattern",
    "CutterSettings": "fab.sheets.cutter_settings",
    "Finding": "fab.errors",
    "FoldSettings": "fab.folding.fold_settings",
    "Format": "fab.jobs.job_files",
    "HingeSettings": "fab.panels.hinges",
    "InvalidFile": "fab.errors",
    "InvalidJob": "fab.errors",
    "Job": "fab.jobs.job",
    "Made": "fab.outputs",
    "PanelSettings": "fab.panels.bevelled_panels",
    "PatternCopies": "fab.sheets.cut_pieces",
    "ReadOptions": "fab.formats.read_options",
    "Severity": "fab.errors",
    "Sheet": "fab.jobs.job_files",
    "SheetRequest": "fab.sheets.sheet_request",
    "animate": "fab.jobs.animation_files",
    "assembly": "fab.panels.cad_assembly",
    "convert": "fab.jobs.conversion",
    "fabricate": "fab.jobs.sheet_files",
    "fabricate_together": "fab.jobs.sheet_files",
    "from_mesh": "fab.jobs.job_files",
    "layer_orders": "fab.layers.layer_orders",
    "load_job": "fab.jobs.job",
    "load_machine": "fab.sheets.materials",
    "load_material": "fab.sheets.materials",
    "make": "fab.jobs.job_files",
    "make_thick": "fab.jobs.print_files",
    "parse_job": "fab.jobs.job",
    "pose": "fab.panels.cad_assembly",
    "read_any": "fab.jobs.reading",
    "read_pattern": "fab.jobs.reading",
    "rigid_motion": "fab.folding.rigid_motion",
    "simulate": "fab.jobs.folding_files",
    "step_bytes": "fab.panels.step",
    "sweep": "fab.sweeps.sweep_run",
    "thick_settings": "fab.printing.thick_settings",
    "thicken": "fab.panels.thick_sheet",
    "write": "fab.outputs",
}


def __getattr__(name: str) -> Any:
    """A public name, loaded where it is first used (PEP 562)."""
    if name == "__version__":
        value: Any = _version()
    elif name in _MODULES:
        value = getattr(import_module(_MODULES[name]), name)
    else:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})


def _version() -> str:
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("quadfold")
    except PackageNotFoundError:
        return "not installed"
