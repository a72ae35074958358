"""The page of file formats, from what the code reads and writes."""

from __future__ import annotations

from fab.formats.reading import READ
from fab.jobs.animation_files import AnimationFormat
from fab.jobs.conversion import WRITTEN
from fab.jobs.folding_files import SimulationFormat
from fab.jobs.job_formats import Format
from fab.jobs.sheet_files import FabricatedFormat
from fab.jobs.thick_products import ThickFormat
from made_pages.markdown import table

__all__ = ["formats_page"]

_PATTERNS = {
    ".fold": "FOLD 1.0 to 1.2: all letters, fold angles, folded forms and states",
    ".svg": "lines in colours or on named layers; angles by opacity, as in Origami Simulator",
    ".svgz": "the same, compressed",
    ".dxf": "text or binary, R12 to R2018: a layer or colour for each letter; no fold angles",
    ".cp": "ORIPA, Oriedita and others: borders, mountains, valleys, auxiliary lines",
    ".opx": "ORIPA",
    ".ori": "Oriedita",
    ".orh": "Orihime",
    ".obj": "meshes: a flat one, a folded one, or a pair of both",
    ".png": "a picture of what was understood",
}
_FILES = {
    "fold": "crease pattern, folded form and states, for simulators and other origami software",
    "dxf": "sheets for laser cutters and CAD: real segments, millimetres, a layer for each "
    "operation",
    "svg": "the same lines in colours",
    "pdf": "the same lines at 1:1",
    "lbrn2": "a LightBurn project with speeds and powers",
    "plt": "HP-GL for knife plotters",
    "gcode": "G-code for GRBL lasers",
    "assembly": "a PDF to be printed: how pieces, or plates, are put together",
    "step": "named, coloured solids for CAD programs",
    "stl": "all solids joined to one body, flat",
    "3mf": "panels and hinges as two materials, in the middle of the printer's bed",
    "zip": "an STL file of each body",
    "png": "a picture, to scale",
    "html": "a page that shows everything, without a network",
    "glb": "a model with the fold as its animation, in metres, y up",
    "gif": "a film of the fold, or of the growth",
    "mp4": "the same as a video",
}
_COMMANDS = {
    "run": Format,
    "fabricate": FabricatedFormat,
    "thicken": ThickFormat,
    "simulate": SimulationFormat,
    "animate": AnimationFormat,
}
_SURFACES = (".stl", ".obj", ".ply", ".off", ".3mf", ".glb", ".step", ".stp")


def formats_page() -> str:
    """What is read and written, and by which command."""
    patterns = [
        [f"`{ending}`", "yes" if ending in READ else "", "yes" if ending in WRITTEN else "", text]
        for ending, text in _PATTERNS.items()
    ]
    assert {*READ, *WRITTEN} == set(_PATTERNS), "a format of patterns is missing on its page"
    made = {str(kind.value) for formats in _COMMANDS.values() for kind in formats}
    assert made == set(_FILES), f"formats differ from their page: {made ^ set(_FILES)}"
    files = [
        [
            f"`{kind}`",
            text,
            ", ".join(f"`{name}`" for name, formats in _COMMANDS.items() if kind in list(formats)),
        ]
        for kind, text in _FILES.items()
    ]
    return "\n".join(
        [
            "# File formats\n",
            "## Crease patterns\n",
            "Every command that takes a pattern reads these; `convert` writes them. What the file "
            "holds is [in the guide](../guide/own_patterns.md).\n",
            table(["ending", "read", "written by `convert`", ""], patterns),
            "## What is made\n",
            "`--only` chooses among them: `quadfold run miura --only dxf,svg`.\n",
            table(["kind", "what it is", "made by"], files),
            "## Surfaces\n",
            f"A design follows a surface from {', '.join(f'`{each}`' for each in _SURFACES)}: "
            "[surfaces](../guide/surfaces.md).\n",
        ]
    )
