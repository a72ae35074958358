"""Sheets larger than the printer: parts, their joints, and how they lie on plates."""

import io
import json
import re
import shutil
import subprocess
from dataclasses import replace
from math import cos, radians, sin, tan

import numpy as np
import pytest
import shapely
import trimesh
from flat_patterns import grid, pattern_of
from helpers import ROOT, TEMPLATES
from hypothesis import given, settings
from hypothesis import strategies as st
from manifold3d import Manifold
from pydantic import ValidationError
from thick_sheets import in_pose

from fab import read_pattern
from fab.errors import Severity
from fab.geometry.booleans import manifold_of, manifolds, meshes, prism, solid
from fab.jobs.grow import grown_pattern
from fab.jobs.job import load_job
from fab.panels.bevelled_panels import PanelSettings
from fab.panels.hinges import HingeSettings
from fab.panels.thick_sheet import thicken
from fab.printing.dovetails import make_joints
from fab.printing.jointed_sheet import jointed
from fab.printing.plate_settings import JointSettings, PlateSettings
from fab.printing.plates import make_plates
from fab.printing.stl import inspect_stl, stl_bytes
from solver.errors import InvalidValue

BED = (210.0, 210.0)


def two_panels(length=45.0, angle=60.0, letter="V", width=60.0):
    """Two rectangles beside a crease at x = width, and their folded form; the second one moves."""
    x = [0.0, width, 2 * width]
    coords = [(x[0], 0), (x[1], 0), (x[2], 0), (x[2], length), (x[1], length), (x[0], length)]
    pattern = pattern_of(coords, [[0, 1, 4, 5], [1, 2, 3, 4]], letter, angle=angle)
    folded = np.column_stack([pattern.vertices_coords, np.zeros(6)])
    turn = radians(angle if letter == "V" else -angle)
    folded[[2, 3], 0] = width + width * cos(turn)
    folded[[2, 3], 2] = width * sin(turn)
    return replace(pattern, folded_coords=folded)


def thick(pattern, thickness=1.6, axis="bottom", gap=1.0, web=0.4, limit=150.0, hinge=None):
    panel = PanelSettings(thickness_mm=thickness, gap_mm=gap, axis=axis, fold_limit_deg=limit)
    return thicken(pattern, panel, hinge or HingeSettings(web_mm=web))[0]


def joined(sheet, **choices):
    """The two panels with joints, the second one carrying the pockets: sheet, joints, findings."""
    settings = JointSettings(**choices)
    edge = int(np.flatnonzero(sheet.pattern.edges_faces[:, 1] >= 0)[0])
    joints, findings = make_joints(sheet, np.array([[edge, 0, 1]]), settings)
    return jointed(sheet, joints, settings, np.array([0, 1]))[0], joints[0], findings


def bodies_of(sheet, kind):
    """The solids whose names begin with a kind, in their order."""
    return [
        manifold_of(sheet.bodies.mesh(number))
        for number, name in enumerate(sheet.names)
        if name.startswith(f"{kind}_")
    ]


def overlaps(bodies):
    """The largest common volume of two bodies whose boxes touch."""
    solids, (low, high) = manifolds(bodies), bodies.boxes()
    tree = shapely.STRtree(shapely.box(low[:, 0], low[:, 1], high[:, 0], high[:, 1]))
    pairs = np.transpose(tree.query(tree.geometries))
    return max(((solids[i] ^ solids[j]).volume() for i, j in pairs.tolist() if i < j), default=0.0)


# One joint


@pytest.mark.parametrize("axis", ["bottom", "middle"])
@pytest.mark.parametrize("letter", ["V", "M"])
@pytest.mark.parametrize("fit", [0.05, 0.1, 0.2])
def test_tongues_lie_in_their_pockets_with_the_fit_all_around(axis, letter, fit):
    sheet, joint, findings = joined(thick(two_panels(letter=letter), axis=axis), fit_mm=fit)
    assert findings == []
    assert joint.kind == "dovetail"
    tongues, pocket = bodies_of(sheet, "tongue"), bodies_of(sheet, "panel")[1]
    assert len(tongues) == len(joint.tongues) == 4
    for tongue in tongues:
        assert tongue.min_gap(pocket, 1.0) == pytest.approx(fit, abs=1e-6)
        # it comes in from below
        assert (tongue.translate((0, 0, -3.0)) ^ pocket).volume() == 0
        assert (tongue.translate((0, 0, fit - 1e-3)) ^ pocket).volume() == 0
        assert (tongue.translate((0, 0, fit + 1e-3)) ^ pocket).volume() > 0


@pytest.mark.parametrize("undercut", [10.0, 15.0, 30.0])
def test_a_dovetail_slides_by_its_play_and_holds(undercut):
    choices = {"undercut_deg": undercut, "fit_mm": 0.1}
    sheet, _, _ = joined(thick(two_panels()), **choices)
    play = 0.1 / sin(radians(undercut))
    assert JointSettings(**choices).play_mm == pytest.approx(play)
    pocket = bodies_of(sheet, "panel")[1]
    for tongue in bodies_of(sheet, "tongue"):
        assert (tongue.translate((0.01 - play, 0, 0)) ^ pocket).volume() == 0
        assert (tongue.translate((-0.01 - play, 0, 0)) ^ pocket).volume() > 0
        for far in ((-1.0, 0, 0), (1.0, 0, 0), (0, 1.0, 0), (0, -1.0, 0)):
            assert (tongue.translate(far) ^ pocket).volume() > 0.01


def test_nothing_is_lost_but_the_gaps():
    old = thick(two_panels(letter="M"))  # upright sides, 0.5 mm from the crease
    sheet, joint, _ = joined(old)
    volume = dict(zip(sheet.names, sheet.bodies.volumes_mm3(), strict=True))
    before = dict(zip(old.names, old.bodies.volumes_mm3(), strict=True))
    panel = shapely.box(60.5, 0, 120.0, 45.0)
    # half the thickness is tongue, 0.1 mm of fit above it
    pockets = sum(0.9 * shapely.Polygon(ring).intersection(panel).area for ring in joint.pockets)
    assert volume["panel_1"] == pytest.approx(before["panel_1"] - pockets, abs=1e-6)
    assert volume["panel_0"] == before["panel_0"]
    for number in range(len(joint.tongues)):
        wide = 6.0 + 2 * 3.95 * tan(radians(15.0))  # after a neck of 0.05 mm
        tongue = volume[f"tongue_{joint.crease}_{number + 1}"]
        assert tongue == pytest.approx(0.8 * (0.05 * 6 + 3.95 * (6 + wide) / 2), abs=1e-6)
        web = volume[f"hinge_{joint.crease}_{number + 1}"]
        assert web == pytest.approx((6.0 - 0.1) * 0.4 * 1.0, abs=1e-6)


@settings(max_examples=30)
@given(
    angle=st.floats(0.0, 150.0),
    letter=st.sampled_from("MV"),
    thickness=st.floats(0.6, 4.0),
    axis=st.sampled_from(["bottom", "middle"]),
    gap=st.floats(0.2, 2.0),
    fit=st.floats(0.02, 0.15),
    joint=st.sampled_from(["dovetail", "pin"]),
)
def test_joints_take_no_more_space_than_their_panels(
    angle, letter, thickness, axis, gap, fit, joint
):
    old = thick(two_panels(angle=angle, letter=letter), thickness, axis, gap, web=0.3)
    sheet, made, _ = joined(old, joint=joint, fit_mm=fit)
    whole = bodies_of(old, "panel")[1]
    parts = [*bodies_of(sheet, "tongue"), bodies_of(sheet, "panel")[1]]
    for part in parts:
        assert (part - whole).volume() < 1e-9
        assert len(part.decompose()) == 1
    flat = np.column_stack([sheet.pattern.vertices_coords, np.zeros(6)])
    for coords in (flat, sheet.pattern.folded_coords):
        assert overlaps(in_pose(sheet, coords)) < 1e-9
    if made.kind != "tape":
        # the part with the tongues hangs together, webs and all
        numbers = [n for n, name in enumerate(sheet.names) if name != "panel_1"]
        solids = manifolds(sheet.joining.chosen(np.array(numbers)))
        assert len(sum(solids, Manifold()).decompose()) == 1


def widest(size, fit=0.1):
    """Width of the pocket of a dovetail of a share of 6 x 4 mm, at 15 degrees."""
    slope = radians(15.0)
    return size * 6 + 2 * (size * 4 - 0.05) * tan(slope) + 2 * fit * (tan(slope) + 1 / cos(slope))


@pytest.mark.parametrize("size", [1.0, 0.75, 0.5])
@pytest.mark.parametrize("beyond", [-0.01, 0.01])
def test_creases_as_long_as_a_pocket_with_its_walls_have_a_dovetail(size, beyond):
    length = widest(size) + 2 * 1.2 + beyond
    _, joint, findings = joined(thick(two_panels(length)))
    if beyond > 0 or size > 0.5:
        smaller = size if beyond > 0 else size - 0.25
        assert findings == []
        mouth = np.ptp(joint.mouths[0, :, 1])
        assert mouth == pytest.approx(6 * smaller - 0.1)
    else:
        assert joint.kind == "tape"
        (found,) = findings
        assert found.code == "joint-tape"
        assert found.creases == (joint.crease,)
        assert f"{widest(0.5):.4g} x 2.2 mm and walls of 1.2 mm" in found.text


@pytest.mark.parametrize("beyond", [-0.01, 0.01])
def test_panels_as_wide_as_a_pocket_with_its_wall_have_a_dovetail(beyond):
    # half the gap, a pocket of half the length, its fit and its wall
    width = 0.5 + 2.0 + 0.1 + 1.2 + beyond
    _, joint, _ = joined(thick(two_panels(letter="M", width=width)))
    assert joint.kind == ("dovetail" if beyond > 0 else "tape")


@pytest.mark.parametrize("beyond", [-0.01, 0.01])
def test_there_are_two_tongues_where_there_is_room_for_two(beyond):
    length = 2 * widest(1.0) + 3 * 1.2 + beyond
    _, joint, _ = joined(thick(two_panels(length)))
    assert len(joint.tongues) == (2 if beyond > 0 else 1)


def test_a_pocket_that_one_panel_has_no_room_for_lies_in_the_other():
    pattern = two_panels()
    narrow = pattern.vertices_coords.copy()
    narrow[[2, 3], 0] = 62.0
    sheet = thick(replace(pattern, vertices_coords=narrow))
    _, joint, findings = joined(sheet)
    assert joint.faces == (1, 0)
    assert joint.kind == "dovetail"
    assert findings == []


def test_a_pin_goes_through_strap_and_roof():
    sheet, joint, findings = joined(thick(two_panels()), joint="pin")
    assert findings == []
    assert joint.kind == "pin"
    pocket = bodies_of(sheet, "panel")[1]
    for tongue, hole in zip(bodies_of(sheet, "tongue"), joint.holes, strict=True):
        middle = hole.mean(axis=0)
        for radius, share in ((1.75 / 2, 0.0), (1.75 / 2 + 0.1, 1.0)):
            pin = Manifold.cylinder(9.0, radius, circular_segments=64).translate((*middle, -3.0))
            assert ((pin ^ tongue).volume() > 0) == ((pin ^ pocket).volume() > 0) == bool(share)
        assert tongue.genus() == 1
        # straight sides: without a pin it slides out
        assert (tongue.translate((-3.0, 0, 0)) ^ pocket).volume() == 0


def test_taped_creases_have_no_web():
    old = thick(two_panels())
    sheet, joint, findings = joined(old, joint="tape")
    assert findings == []
    assert joint.kind == "tape"
    assert sheet.names == ("panel_0", "panel_1")
    assert sheet.bodies.volumes_mm3() == pytest.approx(old.bodies.volumes_mm3()[:2], rel=1e-12)


def test_creases_that_are_to_have_no_hinge_are_noted_without_advice_for_dovetails():
    _, joint, (found,) = joined(thick(two_panels(), hinge=HingeSettings(kind="none")))
    assert joint.kind == "tape"
    assert (found.code, found.severity) == ("joint-bare", Severity.NOTE)
    assert found.creases == (joint.crease,)
    assert "mouth_mm" not in found.text


def test_creases_without_room_for_a_web_are_taped_and_refer_to_what_gives_them_one():
    sheet = thick(two_panels(), hinge=HingeSettings(relief_mm=30.0))
    assert sheet.names == ("panel_0", "panel_1")
    (found,) = joined(sheet)[2]
    assert found.code == "joint-tape"
    assert "no web" in found.text
    assert "hinge-missing" in found.text
    assert "mouth_mm" not in found.text


def test_thin_panels_have_tongues_as_high_as_themselves():
    # half of 0.96 mm, a fit of 0.1 mm and a roof of 0.4 mm do not go into it; into 1 mm they do
    for thickness, top in ((0.96, 0.96), (1.0, 0.5)):
        sheet, _, _ = joined(thick(two_panels(), thickness))
        high = [tongue.bounding_box()[5] for tongue in bodies_of(sheet, "tongue")]
        assert high == pytest.approx([top] * len(high))


def test_a_tongue_without_a_roof_above_it_is_refused():
    sheet = thick(two_panels(), 1.6)
    assert joined(sheet, tongue_mm=1.1)[1].kind == "dovetail"
    with pytest.raises(InvalidValue, match=r"tongue_mm = 1\.11 .* at most 1\.1 mm"):
        joined(sheet, tongue_mm=1.11)
    assert joined(sheet, tongue_mm=1.6)[1].kind == "dovetail"


def test_a_fit_that_lets_tongues_slide_out_is_refused():
    # half of the shortest tongue, 2 mm, times the sine of the undercut
    JointSettings(fit_mm=0.99 * sin(radians(15.0)))
    with pytest.raises(ValidationError, match=r"fit_mm = 0\.26.* at most 0\.2588"):
        JointSettings(fit_mm=1.01 * sin(radians(15.0)))


def test_cut_bodies_know_their_sides():
    box = meshes([prism(np.array([[0.0, 0], [10, 0], [10, 10], [0, 10]]), 0.0, 2.0)])[0]
    slot = prism(np.array([[4.0, -1], [6, -1], [6, 11], [4, 11]]), 1.0, 3.0)
    (cut,) = meshes([solid(box) - slot])
    # below four sides and the bottom; a slot with two walls and a floor cuts the top in two
    names, first = np.unique(cut.triangles_plane, return_index=True)
    assert len(names) == 4 + 1 + 3 + 2
    corners = cut.vertices_coords[cut.triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    for name, lead in zip(names, first, strict=True):
        same = cut.triangles_plane == name
        assert np.abs(normal[same] - normal[lead]).max() < 1e-9
        assert np.ptp(corners[same] @ normal[lead]) < 1e-9


# Knuckles and films


@pytest.mark.parametrize("letter", ["V", "M"])
@pytest.mark.parametrize("fit", [0.05, 0.2])
def test_barrels_of_the_other_panel_end_in_tongues_around_the_pin(letter, fit):
    old = thick(two_panels(letter=letter), 3.2, "middle", hinge=KNUCKLE)
    sheet, joint, findings = joined(old, fit_mm=fit)
    assert findings == []
    assert joint.kind == "dovetail"
    pinned, panel = bodies_of(sheet, "panel")
    tongues = bodies_of(sheet, "tongue")
    assert joint.faces == (0, 1)
    assert len(tongues) == (old.knuckles.counts[0] - 1) // 2
    for tongue in tongues:
        assert len(tongue.decompose()) == 1
        assert tongue.min_gap(panel, 1.0) == pytest.approx(fit, abs=1e-6)
        # it turns about the pin with its play, and does not come off
        assert tongue.min_gap(pinned, 1.0) == pytest.approx(0.3, rel=0.1)
        for far in ((0, 0, 1.0), (1.0, 0, 0), (0, 1.0, 0)):
            assert (tongue.translate(far) ^ pinned).volume() > 0.01
        # it comes into its panel from below, and is not drawn out of it in the plane
        assert (tongue.translate((0, 0, -4.0)) ^ panel).volume() == 0
        assert (tongue.translate((-2.0, 0, 0)) ^ panel).volume() > 0.01
    # nothing else is lost
    whole = manifold_of(old.bodies.mesh(1))
    around = sum((shapely.Polygon(ring).area for ring in joint.pockets), 0.0) * 3.2
    assert 0 < whole.volume() - panel.volume() - sum(t.volume() for t in tongues) < around
    assert pinned.volume() == pytest.approx(manifold_of(old.bodies.mesh(0)).volume(), rel=1e-9)


def test_knuckles_without_room_for_tongues_are_given_up_and_taped():
    old = thick(two_panels(width=5.0), 3.2, "middle", hinge=KNUCKLE)
    assert len(old.knuckles.creases) == 1
    sheet, joint, (found,) = joined(old)
    assert joint.kind == "tape"
    assert found.code == "joint-tape"
    assert "no room for pockets behind its barrels" in found.text
    first, second = bodies_of(sheet, "panel")
    assert first.bounding_box()[3] <= 5.0  # no barrel reaches over the crease
    assert second.bounding_box()[0] >= 5.0
    assert len(first.decompose()) == len(second.decompose()) == 1


def test_a_film_is_cut_at_the_creases_between_parts_and_told():
    sheet = thick(grid(5, 5, 40.0), hinge=FILM)
    plates, findings = make_plates(sheet, (150.0, 120.0), PlateSettings())
    (told,) = findings
    assert told.code == "film-taped"
    assert f"cut along {len(plates.joints)} creases" in told.text
    films = [n for n, name in enumerate(plates.sheet.names) if name.startswith("film")]
    assert len(films) == len(plates.parts)
    volumes = plates.sheet.bodies.volumes_mm3()
    whole = sheet.bodies.volumes_mm3()[-1]
    assert volumes[films].sum() == pytest.approx(whole, rel=1e-9)
    for part in plates.parts:
        (film,) = set(films) & set(part.numbers.tolist())
        low, high = (box[film] for box in plates.sheet.bodies.boxes())
        corners = sheet.pattern.vertices_coords[
            [
                v
                for f in part.faces
                for v in np.split(sheet.pattern.faces_vertices, sheet.pattern.faces_offsets[1:-1])[
                    f
                ]
            ]
        ]
        assert low[:2] == pytest.approx(corners.min(axis=0))
        assert high[:2] == pytest.approx(corners.max(axis=0))


def test_pockets_keep_away_from_the_holes_of_panels():
    """Holes of 12 mm in the middle of strips 20 mm wide: full pockets would reach into them."""
    pattern = two_panels(width=22.0)
    plain, bored = (
        thick(pattern, hinge=HingeSettings(web_mm=0.4, hole_mm=hole)) for hole in (0.0, 12.0)
    )
    holes = manifold_of(plain.bodies.mesh(1)) - manifold_of(bored.bodies.mesh(1))
    assert holes.volume() > 10
    _, joint, _ = joined(bored)
    assert len(joint.pockets)
    for ring in joint.pockets:
        pocket = meshes([prism(ring, -1.0, 5.0)])[0]
        assert manifold_of(pocket).min_gap(holes, 50.0) >= 1.2 - 1e-6
    _, free, _ = joined(plain)
    near = [meshes([prism(ring, -1.0, 5.0)])[0] for ring in free.pockets]
    assert min(manifold_of(mesh).min_gap(holes, 50.0) for mesh in near) < 1.2


# Whole sheets


def enlarged(pattern, width_mm):
    factor = width_mm / np.ptp(pattern.vertices_coords, axis=0).max()
    folded = pattern.folded_coords
    return replace(
        pattern,
        vertices_coords=pattern.vertices_coords * factor,
        folded_coords=None if folded is None else folded * factor,
    )


WEB, FILM = HingeSettings(web_mm=0.4), HingeSettings(kind="film")
KNUCKLE = HingeSettings(kind="knuckle", play_mm=0.3)
MODELS = {
    "miura": (600.0, "bottom", (), WEB),
    "twisted_squares": (600.0, "middle", (), WEB),
    "surface_fit": (420.0, "bottom", ("design.columns=16",), WEB),
    "waterbomb": (400.0, "bottom", (), WEB),
    "miura of knuckles": (600.0, "middle", ("design.rows=4",), KNUCKLE),
    "waterbomb of knuckles": (400.0, "middle", (), KNUCKLE),
    "waterbomb on a film": (400.0, "bottom", (), FILM),
}


@pytest.fixture(scope="module", params=MODELS)
def made(request):
    width, axis, changes, hinge = MODELS[request.param]
    name = request.param.partition(" ")[0]
    if name == "waterbomb":
        pattern, _ = read_pattern(ROOT / "tests" / "patterns" / f"{name}.fold")
    else:
        pattern, _ = grown_pattern(load_job(TEMPLATES / f"{name}.toml", changes))
    sheet = thick(enlarged(pattern, width), 3.2 if hinge is KNUCKLE else 1.6, axis, hinge=hinge)
    return sheet, *make_plates(sheet, BED, PlateSettings())


def test_every_face_and_every_body_is_in_one_part(made):
    old, plates, _ = made
    faces = np.concatenate([part.faces for part in plates.parts])
    assert np.sort(faces).tolist() == old.panels.faces.tolist()
    numbers = np.concatenate([part.numbers for part in plates.parts])
    assert np.sort(numbers).tolist() == list(range(len(plates.sheet.bodies)))
    assert len(plates.parts) > 1
    assert sorted({part.plate for part in plates.parts}) == list(range(plates.count))
    # creases between parts, and no others, have joints
    part = plates.faces_part[old.pattern.edges_faces]
    both = (old.pattern.edges_faces[:, 1] >= 0) & (part >= 0).all(axis=1)
    cut = np.flatnonzero(both & (part[:, 0] != part[:, 1]))
    assert sorted(joint.crease for joint in plates.joints) == cut.tolist()


def test_parts_lie_on_the_bed_apart_from_each_other(made):
    _, plates, _ = made
    margin, gap = 5.0, 3.0
    for part in plates.parts:
        low, high = part.mesh.vertices_coords.min(axis=0), part.mesh.vertices_coords.max(axis=0)
        assert low[2] == pytest.approx(0, abs=1e-12)
        assert (low[:2] >= margin - 1e-6).all()
        assert (high[:2] <= np.array(BED) - margin + 1e-6).all()
        own, (first, last) = plates.bodies(part), plates.bodies(part).boxes()
        assert first.min(axis=0) == pytest.approx(low, abs=2e-3)  # where joined, webs reach further
        assert last.max(axis=0) == pytest.approx(high, abs=2e-3)
        assert own.volumes_mm3().sum() == pytest.approx(manifold_of(part.mesh).volume(), rel=1e-6)
    for plate in range(plates.count):
        solids = [manifold_of(part.mesh) for part in plates.parts if part.plate == plate]
        for number, first in enumerate(solids):
            for second in solids[:number]:
                assert first.min_gap(second, 2 * gap) >= gap - 1e-6


def test_plates_need_no_repair_in_single_precision(made):
    """No facet without area and no edge without its partner."""
    _, plates, _ = made
    for part in plates.parts:
        data = stl_bytes(part.mesh)
        read = trimesh.load(io.BytesIO(data), file_type="stl")
        assert read.is_watertight
        assert read.is_winding_consistent
        assert (read.area_faces > 0).all()
        assert len(read.faces) == len(part.mesh.triangles)
        assert inspect_stl(part.mesh) == []


@pytest.mark.skipif(shutil.which("admesh") is None, reason="no admesh: install Debian's admesh")
def test_admesh_finds_nothing_to_repair_on_plates(made, tmp_path):
    _, plates, _ = made
    for part in plates.parts:
        file = tmp_path / "part.stl"
        file.write_bytes(stl_bytes(part.mesh))
        said = subprocess.run(
            ["admesh", str(file)], capture_output=True, text=True, check=True
        ).stdout
        for what in (
            "Total disconnected facets",
            "Degenerate facets",
            "Edges fixed",
            "Facets removed",
            "Facets added",
            "Facets reversed",
            "Backwards edges",
        ):
            counts = re.search(rf"{what} *: *([\d ]+)", said)[1].split()
            assert counts[-1] == "0", said


def test_sheets_with_joints_fold_as_they_did(made):
    old, plates, _ = made
    pattern = old.pattern
    states = [np.column_stack([pattern.vertices_coords, np.zeros(len(pattern.vertices_coords))])]
    if pattern.folded_coords is not None:
        states.append(pattern.folded_coords)
    for coords in states:
        assert overlaps(in_pose(plates.sheet, coords)) <= overlaps(in_pose(old, coords)) + 1e-9
    for name, body in zip(plates.sheet.names, manifolds(plates.sheet.bodies), strict=True):
        assert body.volume() > 0, name
        assert len(body.decompose()) == 1, name


def test_the_guide_is_plain_and_assembles_every_part_onto_those_before(made):
    _, plates, findings = made
    guide = plates.guide()
    assert json.loads(json.dumps(guide)) == guide
    names = [part.name for part in plates.parts]
    assert sorted(row["part"] for plate in guide["plates"] for row in plate) == sorted(names)
    assembled = {names[0]}
    for row in guide["assembly"]:
        pair = {row["tongue_part"], row["pocket_part"]}
        assert len(pair) == 2
        assert pair & assembled
        assembled |= pair
    assert assembled == set(names)
    taped = sum(row["kind"] == "tape" for row in guide["assembly"])
    code = "film-taped" if plates.sheet.hinge.kind == "film" else "joint-tape"
    assert (code in {finding.code for finding in findings}) == (taped > 0)


def test_a_sheet_that_fits_is_one_part_without_joints():
    sheet = thick(grid(3, 3, 30.0))
    plates, findings = make_plates(sheet, BED, PlateSettings())
    assert findings == []
    assert plates.joints == ()
    (part,) = plates.parts
    assert part.name == "A"
    assert plates.sheet.names == sheet.names
    assert plates.sheet.bodies.vertices_coords.tolist() == sheet.bodies.vertices_coords.tolist()


def test_the_same_sheet_gives_the_same_plates():
    sheet = thick(grid(5, 5, 40.0))
    first, second = (make_plates(sheet, (150.0, 120.0), PlateSettings())[0] for _ in range(2))
    assert first.guide() == second.guide()
    for a, b in zip(first.parts, second.parts, strict=True):
        assert a.mesh.vertices_coords.tobytes() == b.mesh.vertices_coords.tobytes()
        assert a.mesh.triangles.tobytes() == b.mesh.triangles.tobytes()


def test_tongues_are_on_the_part_that_comes_first():
    plates, _ = make_plates(thick(grid(5, 5, 40.0)), (150.0, 120.0), PlateSettings())
    assert len(plates.parts) > 2
    for joint in plates.joints:
        first, second = plates.faces_part[list(joint.faces)]
        assert first < second


def test_progress_rises_to_its_end():
    steps = []
    sheet = thick(grid(5, 5, 40.0))
    make_plates(sheet, (150.0, 120.0), PlateSettings(), lambda *step: steps.append(step))
    assert [done for done, _ in steps] == sorted(done for done, _ in steps)
    assert {total for _, total in steps} == {50}
    assert steps[-1] == (50, 50)


@pytest.mark.parametrize(
    ("bed", "named"),
    [
        ((10.0, 200.0), r"bed width = 10 mm .* greater than 2 x margin_mm = 10 mm"),
        ((200.0, -1.0), r"bed depth = -1"),
        (
            (40.0, 200.0),
            r"size of face 0 with its joints = .* fit 30 x 190 mm, the bed of",
        ),
    ],
)
def test_beds_without_room_are_refused(bed, named):
    with pytest.raises(InvalidValue, match=named):
        make_plates(thick(grid(3, 3, 40.0)), bed, PlateSettings())


def test_beds_have_room_for_tongues_too():
    # half the gap, and a strap for a pin of 1.75 mm, which may come where no dovetail does
    reach = 60.0 + 0.5 + (1.75 + 0.1 + 2 * 1.2) + 2 * 5.0
    sheet = thick(two_panels(letter="M"))
    assert len(make_plates(sheet, (reach + 0.01, 60.0), PlateSettings())[0].parts) == 2
    with pytest.raises(InvalidValue, match="size of face 0 with its joints"):
        make_plates(sheet, (reach - 0.01, 60.0), PlateSettings())


def test_a_sheet_without_panels_is_refused():
    sheet = thick(two_panels(angle=180.0), limit=180.0)
    assert len(sheet.panels.faces) == 0
    with pytest.raises(InvalidValue, match=r"panels = 0 .* at least 1"):
        make_plates(sheet, BED, PlateSettings())
