"""Files of a folding simulation: its states, pictures, and the report with the verdict."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from enum import StrEnum
from functools import partial
from typing import TYPE_CHECKING, Any

from fab.errors import Finding
from fab.folding.fold_settings import FoldSettings
from fab.folding.quasi_static import Checkpoint
from fab.folding.rigid_findings import no_motion
from fab.folding.rigid_motion import rigid_motion
from fab.folding.simulation import Solver, fold_rigidly_and_judge
from fab.folding.target_forms import form_difference
from fab.folding.tolerance import Tolerance
from fab.folding.verdict import folded_form
from fab.formats.fold.writer import fold_bytes
from fab.jobs.file_names import FOLDING
from fab.jobs.simulated_sheet import judged_sheet, simulated_sheet
from fab.outputs import Made, with_report
from fab.pattern.crease_pattern import CreasePattern
from fab.pattern.inspection import inspect_angles
from fab.progress import Progress, silent
from solver.vectors import IntArray

if TYPE_CHECKING:
    from fab.jobs.sheet_loads import CarriedLoads
    from fab.viewing.scene import Scene

__all__ = ["SimulationFormat", "simulate"]


class SimulationFormat(StrEnum):
    """The kinds of files of a simulation, named by their endings."""

    FOLD = "fold"
    PNG = "png"
    GIF = "gif"
    GLB = "glb"
    HTML = "html"


def simulate(
    pattern: CreasePattern,
    name: str,
    settings: FoldSettings | None = None,
    *,
    solver: Solver = Solver.QUASI_STATIC,
    formats: Sequence[SimulationFormat] = tuple(SimulationFormat),
    findings: Sequence[Finding] = (),
    progress: Progress = silent,
    tolerance_deg: float | None = None,
    fold_flat: bool = False,
    upright: bool = False,
    face_orders: IntArray | None = None,
    checkpoint: Checkpoint | None = None,
    material: str | None = None,
) -> Made:
    """Fold a pattern from flat, and make NAME_folding.fold, .png, .gif, .glb, .html and .json.

    The FOLD file has the sheet with its cuts open, its folded form (that of the pattern, or of its
    angles where they close, or what it folds to), and a frame for each state. The report is the
    .json file and holds the verdict, and under "rigid" whether the sheet folds with flat faces. Of
    sheets that fold flat it has under "layers" whether their layers have an order, and the folded
    form in the FOLD file has that of one (`fab.layers`). Where the settings have loads, the folded
    sheet is loaded too: frames of its states, a picture NAME_folding_loads.png, and "loads" in the
    report.

    Parameters
    ----------
    pattern : in millimetres.
    name : what files and pictures call it.
    findings : of its reader, repeated in the report.
    solver : `Solver.RIGID` follows the rigid motion of the sheet; without one, the report is made
        alone, with an error.
    fold_flat : whether it goes on beyond the target until the sheet is folded flat, as far as no
        faces pass through each other; of that solver alone.
    upright : whether z is up in the folded form of the pattern, and in pictures.
    face_orders : rows of faceOrders of its file, shape (n, 3), which the layers have if they can.
    tolerance_deg : how exactly the target must be reached; 0.1 degrees of a crease's angle where
        left out, and in proportion for shape and strain.
    material : a shipped sheet material or a .toml file: whether it bears the strain, and what
        loads it has; several shipped ones are compared where left out.
    progress : called with (stage, steps done, steps in the stage).
    checkpoint : what keeps a quasi-static fold that is cut short.

    Raises `InvalidValue` as `fab.folding.simulation.fold_and_judge` does, and `InvalidJob` as
    `fab.jobs.sheet_loads.carried_loads`.
    """
    settings = settings or FoldSettings()
    tolerance = Tolerance() if tolerance_deg is None else Tolerance(tolerance_deg)
    solver = Solver(solver)
    report: dict[str, Any] = {
        "name": name,
        "solver": solver,
        "settings": settings.model_dump(mode="json"),
    }
    stem = f"{name}_folding"
    if solver is not Solver.RIGID:
        made = simulated_sheet(
            pattern,
            settings,
            solver,
            tolerance=tolerance,
            face_orders=face_orders,
            material=material,
            progress=progress,
            checkpoint=checkpoint,
        )
        report |= made.report()
    else:
        motion = rigid_motion(pattern)
        if not len(motion.path):
            report |= {"verdict": None, "rigid": motion.report(), "layers": None}
            return with_report(
                {}, FOLDING.report_name(name), report, [*findings, no_motion(motion)]
            )
        fold, verdict, found = fold_rigidly_and_judge(
            pattern, motion, settings, progress, tolerance, fold_flat=fold_flat
        )
        made = judged_sheet(
            pattern,
            fold.folding,
            verdict,
            motion,
            found,
            shown=fold.shown,
            tolerance=tolerance,
            face_orders=face_orders,
            material=material,
            progress=progress,
        )
        report |= made.report()
        report["rigid"] |= fold.report(motion)
    folding, verdict, found = made.folding, made.verdict, [*made.findings]
    files: dict[str, bytes] = {}
    sheet = folding.frame.sheet.pattern
    carried: CarriedLoads | None = None
    if settings.loads is not None:
        from fab.jobs.sheet_loads import carried_loads

        carried = carried_loads(
            folding, settings.loads, material, name, upright=upright, progress=progress
        )
        found += carried.findings()
    if SimulationFormat.FOLD in formats:
        progress("write", 0, 1)
        size = folding.frame.size_mm
        states = [
            (f"{state.load:.2%} of the way", state.coords * size) for state in made.shown.states[1:]
        ]
        if carried is not None:
            states += carried.states_mm(folding.states[-1].coords * size)
        form = folded_form(folding, verdict, tolerance)
        folded = None if form is None else form * size
        orders = made.layers.orders if made.layers and len(made.layers.orders) else None
        shown_sheet = replace(sheet, folded_coords=folded)
        files[f"{stem}.fold"] = fold_bytes(shown_sheet, name, states, orders)
    if SimulationFormat.PNG in formats:
        from fab.viewing.folding_picture import states_png_bytes

        progress("draw", 0, 1)
        files[f"{stem}.png"] = states_png_bytes(made.scene(name, upright=upright))
        if carried is not None:
            files[f"{stem}_loads.png"] = carried.png_bytes()
    if SimulationFormat.GIF in formats:
        from fab.viewing.folding_picture import folding_gif_bytes

        scene = made.scene(name, upright=upright)
        files[f"{stem}.gif"] = folding_gif_bytes(scene, partial(progress, "draw"))
    differs = form_difference(folding.frame, tolerance) is not None
    angles = [] if differs else inspect_angles(sheet)
    every = [*findings, *angles, *found]
    if carried is not None:
        report["loads"] = carried.report()
    if tolerance_deg is not None:
        report["tolerance_deg"] = tolerance_deg
    if {SimulationFormat.GLB, SimulationFormat.HTML} & set(formats):
        scene = made.scene(name, findings=every, upright=upright)
        files |= _scene_files(scene, stem, formats, report, files)
    progress("write", 1, 1)
    return with_report(files, FOLDING.report_name(name), report, every)


def _scene_files(
    scene: Scene,
    stem: str,
    formats: Sequence[SimulationFormat],
    report: Mapping[str, Any],
    files: Mapping[str, bytes],
) -> dict[str, bytes]:
    """The model and the result page, which lists the other files too."""
    made: dict[str, bytes] = {}
    if SimulationFormat.GLB in formats:
        from fab.viewing.glb import sheet_glb_bytes

        made[f"{stem}.glb"] = sheet_glb_bytes(scene)
    if SimulationFormat.HTML in formats:
        from fab.viewing.page import ResultPage, page_bytes

        page = ResultPage(
            scene.name,
            "quadfold simulate",
            scene,
            report,
            scene.findings,
            {**files, **made},
            pictures={
                f"{stem}.png": "states on the way, coloured by strain",
                f"{stem}_loads.png": "without load and under load, coloured by displacement",
            },
        )
        made[f"{stem}.html"] = page_bytes(page)
    return made
