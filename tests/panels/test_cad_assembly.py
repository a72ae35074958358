"""CAD solids of thick sheets, and their joints, posed against the folded form."""

import numpy as np
import pytest
from build123d import Plane
from helpers import TEMPLATES
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation
from thick_sheets import in_pose, miura_pattern, shipped_pattern, thick

from fab.jobs.grow import grown_pattern
from fab.jobs.job import load_job
from fab.panels.cad_assembly import assembly, pose
from solver import InvalidValue


def corners_of(compound) -> list[np.ndarray]:
    """Corners of every solid of a compound, in one order for solids of the same shape."""
    return [np.array([tuple(v) for v in child.vertices()]) for child in compound.children]


def moved_onto(points: np.ndarray, target: np.ndarray) -> np.ndarray:
    middle, goal = points.mean(axis=0), target.mean(axis=0)
    turn, _ = Rotation.align_vectors(target - goal, points - middle)
    return turn.apply(points - middle) + goal


def twisted_squares():
    return grown_pattern(load_job(TEMPLATES / "twisted_squares.toml"))[0]


PATTERNS = {
    "miura": (lambda: miura_pattern(6, 6), "middle"),
    "twisted_squares": (twisted_squares, "bottom"),
    "waterbomb": (lambda: shipped_pattern("waterbomb", 100.0), "bottom"),
    "square_twist": (lambda: shipped_pattern("square_twist", 120.0), "middle"),
}


@pytest.mark.parametrize("name", PATTERNS)
def test_joints_at_the_target_angles_give_the_folded_solids(name):
    make, axis = PATTERNS[name]
    pattern = make()
    sheet = thick(pattern, axis, 0.3 if name == "twisted_squares" else 0.8)
    assert len(sheet.panels.faces) == pattern.face_count
    flat = assembly(sheet, name)
    posed = pose(flat, pattern, pattern.edges_foldAngle)
    placed = assembly(sheet, name, pattern.folded_coords)
    assert [child.label for child in posed.children] == [child.label for child in placed.children]
    folded = in_pose(sheet, pattern.folded_coords)
    for i, corners in enumerate(corners_of(placed)):
        first, end = folded.vertices_offsets[i : i + 2]
        off, _ = cKDTree(corners).query(folded.vertices_coords[first:end])
        assert off.max() < 1e-9
        assert len(corners) == end - first
    first, second = (np.concatenate(corners_of(compound)) for compound in (posed, placed))
    assert moved_onto(first, second) == pytest.approx(second, abs=1e-6)
    # each is placed by one motion, however deep it is in the tree
    assert all(c.wrapped.Location().NextLocation().IsIdentity() for c in posed.children)
    # what was given stays flat
    assert np.concatenate(corners_of(flat))[:, 2].max() <= 0.8


def test_a_user_turns_one_panel_by_its_joint():
    """Two panels at a valley: the second rises by the angle, seen along the crease."""
    pattern = miura_pattern()
    sheet = thick(pattern)
    valley = int(np.flatnonzero(pattern.edges_assignment == "V")[0])
    panels = {child.label: child for child in assembly(sheet, "miura").children}
    first, second = (panels[f"panel_{face}"] for face in pattern.edges_faces[valley])
    label = f"crease_{valley}"
    flat = second.center().Z
    for angle in (0.0, 50.0, 90.0, -30.0):
        first.joints[label].connect_to(second.joints[label], angle=angle)
        normals = [Plane(part.location).z_dir for part in (first, second)]
        assert np.degrees(np.arccos(normals[0].dot(normals[1]))) == pytest.approx(abs(angle))
        assert np.sign(round(second.center().Z - flat, 6)) == np.sign(angle)
    with pytest.raises(ValueError, match="range"):
        first.joints[label].connect_to(second.joints[label], angle=181)


def test_posed_assemblies_can_be_posed_again():
    pattern = miura_pattern()
    flat = assembly(thick(pattern), "miura")
    half = pose(flat, pattern, pattern.edges_foldAngle / 2)
    whole = pose(half, pattern, pattern.edges_foldAngle)
    straight = pose(flat, pattern, pattern.edges_foldAngle)
    again = np.concatenate(corners_of(whole))
    assert again == pytest.approx(moved_onto(np.concatenate(corners_of(straight)), again), abs=1e-9)
    assert not np.allclose(np.concatenate(corners_of(half)), again, atol=1e-2)


def test_assemblies_have_labels_and_colours_and_a_joint_for_every_crease():
    pattern = miura_pattern()
    sheet = thick(pattern)
    compound = assembly(sheet, "miura")
    assert compound.label == "miura"
    assert [child.label for child in compound.children] == list(sheet.names)
    assert len({tuple(child.color) for child in compound.children}) == 3
    ends = [label for child in compound.children for label in child.joints]
    inner = np.flatnonzero(pattern.edges_faces[:, 1] >= 0)
    assert sorted(ends) == sorted(2 * [f"crease_{edge}" for edge in inner])
    exact = sheet.bodies.volumes_mm3()
    volumes = [child.volume for child in compound.children]
    assert volumes == pytest.approx(exact, rel=1e-12)
    assert all(child.is_valid for child in compound.children)


@pytest.mark.parametrize("angle", [180.5, np.nan, -np.inf])
def test_angles_out_of_bounds_are_named(angle):
    pattern = miura_pattern()
    flat = assembly(thick(pattern), "miura")
    crease = int(np.flatnonzero(pattern.edges_faces[:, 1] >= 0)[3])
    angles = np.zeros(len(pattern.edges_vertices))
    angles[crease] = angle
    with pytest.raises(InvalidValue, match=rf"angles_deg\[{crease}\]"):
        pose(flat, pattern, angles)
    with pytest.raises(InvalidValue, match="one angle for every edge"):
        pose(flat, pattern, angles[1:])
