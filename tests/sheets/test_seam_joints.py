"""Joints of seams: tabs that meet, tongues in their slots, stitches opposite each other."""

import json
from dataclasses import replace

import numpy as np
import pytest
import shapely
from click.testing import CliRunner
from flat_patterns import grid, triangles
from hypothesis import given, settings
from hypothesis import strategies as st
from shared_cases import shared_case

from fab.cli.group import main
from fab.pattern.crease_pattern import scaled
from fab.pattern.kinematics import fold_by_angles
from fab.sheets.pieces import SheetSplit, split

BED = (300.0, 200.0)


def box():
    """Four squares in a row that close to a ring, and a fifth for a floor: a box without a lid."""
    return grid(4, 2, 40.0, without=[(0, 1), (2, 1), (3, 1)])


def divided(pattern, tabs, bed=BED, **choices):
    return split(pattern, SheetSplit(tabs=tabs, margin_mm=0.0, **choices), bed)


def faces_of(pattern):
    for i, j in zip(pattern.faces_offsets[:-1], pattern.faces_offsets[1:], strict=True):
        yield pattern.faces_vertices[i:j]


def in_space(pattern, face, points):
    """Where points in the plane of a face are when it is folded."""
    corners = next(c for number, c in enumerate(faces_of(pattern)) if number == face)
    flat, folded = pattern.vertices_coords[corners], pattern.folded_coords[corners]
    arm = np.column_stack([flat[1] - flat[0], flat[2] - flat[0]])
    weight = np.linalg.solve(arm, (points - flat[0]).T).T
    return folded[0] + weight @ np.array([folded[1] - folded[0], folded[2] - folded[0]])


@pytest.fixture
def folded_box():
    pattern = box()
    return replace(pattern, folded_coords=fold_by_angles(pattern).folded_coords)


def test_tabs_on_both_sides_come_to_lie_on_each_other(folded_box):
    made, findings = divided(folded_box, "both sides")
    assert not findings
    (piece,) = made.pieces
    count = int((piece.faces < 0).sum())
    assert count == 2 * len(made.seams) > 0
    tabs = list(faces_of(piece.pattern))[-count:]
    middles = [piece.pattern.folded_coords[tab].mean(axis=0) for tab in tabs]
    for first, second in zip(tabs[::2], tabs[1::2], strict=True):
        one, other = piece.pattern.folded_coords[first], piece.pattern.folded_coords[second]
        assert one[[0, 1, 2, 3]] == pytest.approx(other[[1, 0, 3, 2]], abs=1e-9)
    assert len(np.unique(np.round(middles, 6), axis=0)) == len(made.seams)


def test_tabs_on_one_side_lie_in_the_plane_of_the_other_face(folded_box):
    made, _ = divided(folded_box, "one side")
    (piece,) = made.pieces
    pattern = piece.pattern
    count = int((piece.faces < 0).sum())
    assert count == len(made.seams)
    for seam, tab in zip(made.seams, list(faces_of(pattern))[-count:], strict=True):
        other = pattern.edges_faces[seam.piece_edges[1 - seam.tab], 0]
        corners = next(c for n, c in enumerate(faces_of(pattern)) if n == other)
        plane = pattern.folded_coords[corners]
        normal = np.cross(plane[1] - plane[0], plane[2] - plane[0])
        off = (pattern.folded_coords[tab] - plane[0]) @ (normal / np.linalg.norm(normal))
        assert np.abs(off).max() < 1e-9


@pytest.mark.parametrize("thickness", [0.36, 1.5])
def test_tongues_come_up_where_their_slots_are(folded_box, thickness):
    made, findings = divided(folded_box, "slots", thickness_mm=thickness)
    assert not findings
    (piece,) = made.pieces
    pattern = piece.pattern
    count = len(made.seams)
    tabs = list(faces_of(pattern))[-count:]
    assert [len(tab) for tab in tabs] == [8] * count
    assert len(piece.openings) == count
    polygons = [shapely.Polygon(pattern.vertices_coords[c]) for c in faces_of(pattern)]
    for seam, tab, slot in zip(made.seams, tabs, piece.openings, strict=True):
        face = int(pattern.edges_faces[seam.piece_edges[1 - seam.tab], 0])
        assert polygons[face].buffer(-1 + 1e-9, join_style="mitre").covers(shapely.Polygon(slot))
        space = in_space(pattern, face, slot)
        sides = np.linalg.norm(np.roll(space, -1, axis=0) - space, axis=1)
        across, along = sorted([sides[0], sides[1]])
        assert across == pytest.approx(thickness + 0.1)
        # corners of the tab, b a left low .. .. high right: its shoulders are at the near side
        low, high = pattern.folded_coords[tab[[3, 6]]]
        near = space[[0, 3]]
        assert along - np.linalg.norm(high - low) == pytest.approx(0.3)
        gaps = sorted(
            [np.linalg.norm(near - low, axis=1).min(), np.linalg.norm(near - high, axis=1).min()]
        )
        assert gaps == pytest.approx([0.15, 0.15], abs=1e-6)


@pytest.mark.parametrize("pitch", [3.0, 5.0, 8.0])
def test_stitches_of_both_sides_are_as_many_and_opposite_each_other(folded_box, pitch):
    made, findings = divided(folded_box, "stitches", stitch_mm=pitch, stitch_hole_mm=1.2)
    assert not [f for f in findings if f.code == "tab-no-room"]
    (piece,) = made.pieces
    pattern = piece.pattern
    middles = np.array([ring.mean(axis=0) for ring in piece.openings])
    assert {len(ring) for ring in piece.openings} == {16}
    areas = [shapely.Polygon(ring).area for ring in piece.openings]
    assert areas == pytest.approx([np.pi * 0.36] * len(areas))
    apart = np.hypot(*(middles[:, None] - middles[None]).transpose(2, 0, 1))
    assert (apart + 9 * np.eye(len(middles))).min() >= min(pitch, 1.75 * 1.2) - 1e-9
    seen = 0
    for seam in made.seams:
        places = []
        for edge in seam.piece_edges:
            ends = pattern.vertices_coords[pattern.edges_vertices[edge]]
            span = ends[1] - ends[0]
            u = span / np.hypot(*span)
            along = (middles - ends[0]) @ u
            beside = np.abs((middles - ends[0]) @ [-u[1], u[0]])
            row = np.isclose(beside, 2.4) & (along > 0) & (along < np.hypot(*span))
            # holes of a neighbouring row may be as far from this edge: those of the rhythm count
            middle = np.hypot(*span) / 2
            offset = (along - middle) / pitch + (seam.stitches - 1) / 2
            row &= np.isclose(offset, np.rint(offset)) & (offset > -0.5)
            row &= offset < seam.stitches - 0.5
            places.append(sorted(along[row].tolist()))
        assert len(places[0]) == len(places[1]) == seam.stitches > 1
        assert np.diff(places[0]) == pytest.approx(pitch)
        # symmetrical about the middle, so the same from either end
        assert places[0] == pytest.approx(places[1])
        seen += 2 * seam.stitches
    assert seen == len(middles)


@given(st.integers(0, 10**6), st.sampled_from(["both sides", "slots", "stitches", "none"]))
@settings(max_examples=12)
def test_joints_of_any_pattern_keep_to_their_faces_and_pieces_do_not_overlap(seed, kind):
    pattern = scaled(triangles(seed), width_mm=260.0)
    made, _ = divided(pattern, kind, (200.0, 150.0))
    for piece in made.pieces:
        polygons = [
            shapely.Polygon(piece.pattern.vertices_coords[c]) for c in faces_of(piece.pattern)
        ]
        assert all(polygon.is_valid for polygon in polygons)
        union = shapely.union_all(polygons)
        assert union.area == pytest.approx(sum(p.area for p in polygons), rel=1e-6)
        own = [shapely.Polygon(ring) for ring in piece.openings]
        faces = polygons[: int((piece.faces >= 0).sum())]
        assert all(sum(face.covers(ring) for face in faces) == 1 for ring in own)
        if own:
            assert shapely.union_all(own).area == pytest.approx(sum(ring.area for ring in own))
        for label in piece.labels:
            assert not any(ring.contains(shapely.Point(label.at)) for ring in own)
    tabs = sum(int((piece.faces < 0).sum()) for piece in made.pieces)
    if kind in ("stitches", "none"):
        assert tabs == 0
    if kind == "both sides":
        assert tabs == 2 * sum(seam.tab is not None for seam in made.seams)


def run(path, out, *words):
    command = ["fabricate", str(path), "--material", "card_300gsm", "--machine"]
    command += ["co2_60w_600x400", "--only", "dxf", "--out", str(out), *words]
    result = CliRunner().invoke(main, command)
    assert result.exit_code == 0, result.output
    (report,) = out.glob("*_report.json")
    return json.loads(report.read_text()), result.output


def test_a_cupboard_that_folds_flat_has_no_seam_in_any_style(tmp_path):
    for kind in ("one side", "both sides", "slots", "stitches"):
        out = tmp_path / kind.replace(" ", "_")
        report, _ = run(shared_case("cupboard_fold.fold"), out, "--set", f"cutter.tabs={kind}")
        assert report["glue_up"] == []


@pytest.mark.parametrize("name", ["boxnet.fold", "boxnet_folded.fold"])
def test_a_box_has_seven_joints_of_any_style(tmp_path, name):
    for kind in ("one side", "both sides", "slots", "stitches", "none"):
        out = tmp_path / kind.replace(" ", "_")
        report, output = run(shared_case(name), out, "--set", f"cutter.tabs={kind}")
        assert len(report["glue_up"]) == 7
        assert "no-room" not in output
        tabs = [row["tab"] for row in report["glue_up"]]
        assert (None in tabs) == (kind in ("stitches", "none"))
        stitches = [row.get("stitches", 0) for row in report["glue_up"]]
        assert min(stitches) > 3 or kind != "stitches"


def test_seams_without_room_are_named_with_the_key_that_helps():
    pattern = scaled(triangles(3), width_mm=200.0)
    much = {"slots": {"thickness_mm": 20.0}, "stitches": {"stitch_mm": 60.0}}
    for kind, key in (("slots", "tab_mm"), ("stitches", "stitch_mm")):
        _, findings = divided(pattern, kind, (180.0, 120.0), **much[kind])
        (finding,) = [f for f in findings if f.code == "tab-no-room"]
        assert f"lower {key}" in finding.text
