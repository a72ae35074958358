"""Sheets on gentle surfaces that fold rigidly: one motion, flat faces, panels that do not jam."""

import numpy as np
import pytest
from helpers import template_fold
from relaxed_surfaces import bump

import fab
from fab.folding.bar_hinge_model import framework
from fab.folding.rigid_folding import fold_rigidly
from fab.folding.rigid_motion import RigidVerdict, rigid_motion
from fab.jobs.grow import growth_findings
from fab.jobs.job import parse_job
from solver import Growth, InvalidValue, Status, explicit_surface
from solver.designs import SurfaceFit

GENTLE = {
    "paraboloid": (explicit_surface(lambda x, y: 0.15 * (x * x + y * y)), 2.0, np.pi / 4),
    "saddle": (explicit_surface(lambda x, y: 0.2 * (x * x - y * y)), 1.0, np.pi / 4),
    "bump": (bump(0.2), 0.7, 0.0),
}


def followed(name, **given):
    surface, zigzag, turn = GENTLE[name]
    cell = {"columns": 8, "zigzag": zigzag, "row_step": 1.0, "turn": turn}
    growth = SurfaceFit(surface, method="relax", **cell, **given).grow()
    return growth, fab.from_mesh(growth.mesh, folded_width_mm=300.0)


@pytest.mark.parametrize("name", list(GENTLE))
def test_rigid_sheets_follow_gentle_surfaces_and_fold_in_one_motion(name):
    growth, sheet = followed(name, rigid=True)
    assert growth.status is Status.GROWN
    assert growth.coverage > 0.98
    assert np.abs(growth.deviations).max() < 0.15 * growth.chosen["step"]
    assert growth_findings(growth) == []
    motion = rigid_motion(sheet.pattern)
    assert motion.verdict is RigidVerdict.FOLDS
    assert motion.freedom.exact
    assert motion.freedom.count == 1
    assert motion.freedom.moving.all()
    fold = fold_rigidly(framework(sheet.pattern), motion, 20, fold_flat=True)
    assert len(fold.folding.states) == 21
    assert fold.bend_max_mm < 1e-9
    np.testing.assert_allclose(fold.angles_deg[0], 0.0, atol=1e-9)
    np.testing.assert_allclose(np.abs(fold.angles_deg[-1]), 180.0, atol=1e-9)
    made = sheet.make(["stl"])
    assert not {"panels-jam", "panels-lock"} & {finding.code for finding in made.findings}


def test_a_sheet_that_is_free_to_follow_its_surface_is_told_apart():
    growth, sheet = followed("bump")
    assert growth.status is Status.GROWN
    motion = rigid_motion(sheet.pattern)
    assert motion.verdict is RigidVerdict.BENDS
    assert motion.freedom.count == 0


def test_a_rigid_sheet_far_off_its_surface_is_made_with_a_warning():
    growth, _ = followed("bump", rigid=True)
    off = np.abs(growth.deviations).max() / growth.chosen["step"]
    assert growth.chosen["off_steps"] == pytest.approx(off)
    off *= 3
    chosen = growth.chosen | {"off_steps": off}
    far = Growth(growth.mesh, growth.strips, chosen=chosen, deviations=3 * growth.deviations)
    (finding,) = growth_findings(far)
    assert finding.code == "far-from-surface"
    assert f"up to {off:.3g} steps" in finding.text
    assert "0.15 would be near" in finding.text


def test_the_acoustic_panel_folds_rigidly(tmp_path):
    (tmp_path / "panel.fold").write_bytes(template_fold("acoustic_panel"))
    motion = rigid_motion(fab.read_pattern(tmp_path / "panel.fold")[0])
    assert motion.verdict is RigidVerdict.FOLDS
    assert motion.freedom.count == 1


def test_rigid_sheets_are_relaxed():
    with pytest.raises(InvalidValue, match="rigid = true is out of bounds"):
        SurfaceFit("hypar", method="grow", rigid=True).grow()
    document = {"name": "r", "sheet": {"width_mm": 90.0}}
    document["design"] = {"kind": "surface_fit", "surface": "hypar", "rigid": True}
    assert parse_job(document).design.rigid is True
