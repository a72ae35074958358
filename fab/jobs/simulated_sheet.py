"""A sheet that is simulated: how it folds, its rigid motion and layers, in words and as a scene.

What `simulate`, the simulation of a job and the studio say of a sheet is from here.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from fab.errors import Finding, Severity
from fab.folding.fold_settings import FoldSettings
from fab.folding.quasi_static import Checkpoint, Folding
from fab.folding.rigid_findings import with_motion
from fab.folding.rigid_motion import RigidMotion, rigid_motion
from fab.folding.simulation import Solver, fold_and_judge
from fab.folding.tolerance import Tolerance
from fab.folding.verdict import ANOTHER_PATH, Verdict
from fab.folding.verdict_words import VerdictWords, in_words
from fab.jobs.bearing_sheets import bearing_sheets
from fab.layers.layer_findings import inspect_layers
from fab.layers.layer_orders import FoldsFlat, LayerOrders, layer_orders
from fab.pattern.crease_pattern import CreasePattern
from fab.progress import Progress, silent
from solver.vectors import IntArray

if TYPE_CHECKING:
    from fab.viewing.scene import Scene

__all__ = ["SimulatedSheet", "judged_sheet", "sentences", "simulated_sheet"]


@dataclass(frozen=True)
class SimulatedSheet:
    """What is known of a sheet that was simulated.

    Attributes
    ----------
    folding : its states. shown : those that are looked at, which may go on beyond the target.
    verdict, words : whether it reaches its target, in numbers and in a sentence.
    motion : its rigid motion. layers : those of a sheet that folds flat; None of others.
    findings : with numbers of the pattern.
    """

    folding: Folding
    shown: Folding
    verdict: Verdict
    words: VerdictWords
    motion: RigidMotion
    layers: LayerOrders | None
    findings: tuple[Finding, ...]

    def report(self) -> dict[str, Any]:
        """As JSON values: "verdict", "rigid", and "layers"."""
        return {
            "verdict": self.words.report() | self.verdict.report(),
            "rigid": self.motion.report(),
            "layers": None if self.layers is None else self.layers.report(),
        }

    def scene(self, name: str, *, findings: Sequence[Finding] = (), upright: bool = False) -> Scene:
        """Its states, the layers of the last one in order where it reaches its target.

        findings, upright : as for `fab.viewing.scene_builders.folding_scene`.
        """
        from fab.viewing.layered_scene import layered
        from fab.viewing.scene_builders import folding_scene

        scene = folding_scene(self.shown, name, findings=findings, upright=upright)
        return layered(scene, self.layers if self.verdict.reached else None)


def simulated_sheet(
    pattern: CreasePattern,
    settings: FoldSettings,
    solver: Solver = Solver.QUASI_STATIC,
    *,
    tolerance: Tolerance | None = None,
    face_orders: IntArray | None = None,
    material: str | None = None,
    progress: Progress = silent,
    checkpoint: Checkpoint | None = None,
) -> SimulatedSheet:
    """Simulate a sheet, by any solver but that of rigid faces.

    pattern, settings, solver, tolerance, checkpoint : as for
    `fab.folding.simulation.fold_and_judge`, which raises the same. The rest as for `judged_sheet`.
    """
    folding, verdict, found = fold_and_judge(
        pattern, settings, solver, progress, tolerance, checkpoint
    )
    motion = rigid_motion(pattern, folding.frame)
    return judged_sheet(
        pattern,
        folding,
        verdict,
        motion,
        with_motion(found, verdict, motion),
        tolerance=tolerance,
        face_orders=face_orders,
        material=material,
        progress=progress,
    )


def judged_sheet(
    pattern: CreasePattern,
    folding: Folding,
    verdict: Verdict,
    motion: RigidMotion,
    findings: Sequence[Finding],
    *,
    shown: Folding | None = None,
    tolerance: Tolerance | None = None,
    face_orders: IntArray | None = None,
    material: str | None = None,
    progress: Progress = silent,
) -> SimulatedSheet:
    """A sheet that was simulated, with its layers and the verdict in words.

    Parameters
    ----------
    findings : of the simulation. shown : `folding` where left out.
    face_orders : rows of faceOrders of its file, shape (n, 3), which the layers have if they can.
    material : a shipped sheet material or a .toml file; several shipped ones are compared where it
        is left out.
    progress : called with the stage "layers".
    """
    progress("layers", 0, 1)
    layers = layer_orders(pattern, face_orders)
    every = (*_with_layers(findings, verdict, layers), *inspect_layers(layers))
    words = in_words(folding, verdict, motion, every, bearing_sheets(material), tolerance)
    return SimulatedSheet(folding, shown or folding, verdict, words, motion, layers, every)


def _with_layers(
    findings: Sequence[Finding], verdict: Verdict, layers: LayerOrders | None
) -> list[Finding]:
    """The findings of a simulation, without the hope of another path where layers have no order."""
    if layers is None or layers.folds_flat is not FoldsFlat.NO or layers.assumed:
        return list(findings)
    no_order = "Its layers have no order: see cannot-lie-flat."
    return [
        replace(finding, text=finding.text.replace(ANOTHER_PATH, no_order))
        for finding in findings
        if not (
            verdict.reached
            and finding.code == "stopped-by-contact"
            and finding.severity is Severity.WARNING
        )
    ]


def sentences(report: Mapping[str, Any]) -> Iterator[str]:
    """What a report (`SimulatedSheet.report`) says in words: none of it twice."""
    verdict, rigid, layers = report["verdict"], report["rigid"], report["layers"]
    if verdict is None:
        yield rigid["text"]
        return
    yield verdict["text"]
    if rigid["text"] not in verdict["text"]:
        yield f"with rigid faces: {rigid['text']}"
    if layers is not None and layers["text"] not in verdict["text"]:
        yield layers["text"]
