"""A scene with states between flat and folded, for sheets whose fold nobody simulated."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fab.errors import Finding
from fab.folding.bar_hinge_model import framework
from fab.folding.quasi_static import aligned
from fab.folding.rotation_predictor import rotation_predictor
from fab.pattern.crease_pattern import CreasePattern
from fab.viewing.level_of_detail import states_between
from fab.viewing.scene import Scene
from fab.viewing.scene_builders import pattern_scene
from solver.errors import OrigamiError

__all__ = ["predicted_scene"]


def predicted_scene(
    pattern: CreasePattern,
    name: str,
    *,
    findings: Sequence[Finding] = (),
    upright: bool = False,
) -> Scene:
    """The flat sheet, some states on its way, and its folded form where the pattern has one.

    On the way all creases have turned by the same share of their angles, and the sheet fits that by
    least squares: it stretches a little where it does not fold at one rate. Sheets with cuts, and
    those whose faces cannot be cut into triangles, have no states between.

    upright : as in `fab.viewing.scene_builders.pattern_scene`.
    """
    scene = pattern_scene(pattern, name, findings=findings, upright=upright)
    cut = (pattern.edges_assignment == "C").any()
    if scene.folded_coords is None or cut:
        return scene
    try:
        frame = framework(pattern)
    except OrigamiError:
        return scene
    predictor = rotation_predictor(frame)
    shares = np.linspace(0.0, 1.0, states_between(pattern.face_count) + 2)
    states = [scene.folded_coords]
    for share in shares[-2:0:-1].tolist():
        coords = predictor.coords(share * frame.hinges_target) * frame.size_mm
        if not np.isfinite(coords).all():
            return scene
        states.append(aligned(coords, states[-1]))
    states.append(aligned(scene.states_coords[0], states[-1]))
    return Scene(
        name,
        pattern,
        shares,
        np.stack(states[::-1]),
        upright=upright,
        findings=tuple(findings),
    )
