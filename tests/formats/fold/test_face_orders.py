import json
from dataclasses import replace

import numpy as np
import pytest
from folded_strips import strip

from fab.formats.fold.reader import read_fold
from fab.formats.fold.writer import fold_bytes
from fab.jobs.conversion import convert
from fab.layers.layer_orders import layer_orders
from fab.outputs import write
from fab.pattern.kinematics import fold_by_angles


def folded_file(tmp_path, pattern, orders=None, change=lambda document: None):
    """A FOLD file of a strip with its folded form, after a change of its document."""
    form = fold_by_angles(pattern).folded_coords
    document = json.loads(fold_bytes(replace(pattern, folded_coords=form), "strip", (), orders))
    change(document)
    path = tmp_path / "strip.fold"
    path.write_text(json.dumps(document))
    return path


def test_orders_of_all_faces_that_overlap_are_written_and_read(tmp_path):
    pattern = strip([2, 2, 2, 2], "VMV")
    orders = layer_orders(pattern).orders
    assert len(orders) == 6  # adjacent pairs are three
    read = read_fold(folded_file(tmp_path, pattern, orders))
    assert read.face_orders.tolist() == orders.tolist()
    made = convert(read, tmp_path / "again.fold")
    (frame,) = json.loads(made.files["again.fold"])["file_frames"]
    assert frame["faceOrders"] == orders.tolist()


def test_a_file_with_a_few_orders_gets_them_all_and_keeps_its_own(tmp_path):
    pattern = strip([2, 2, 2], "UU")
    pattern = replace(pattern, edges_foldAngle=np.where(pattern.edges_assignment == "U", 180.0, 0))
    pattern = replace(pattern, edges_assignment=np.where(pattern.edges_assignment == "U", "V", "B"))
    for side in (1, -1):
        path = folded_file(tmp_path, pattern, np.array([[0, 2, side]]))
        made = convert(read_fold(path), tmp_path / "out.fold")
        (frame,) = json.loads(made.files["out.fold"])["file_frames"]
        assert [0, 1, 1] in frame["faceOrders"]
        assert len(frame["faceOrders"]) == 3
        contradicts = {finding.code for finding in made.findings} == {"face-orders-contradict"}
        assert ([0, 2, side] in frame["faceOrders"]) != contradicts


def flat_file(tmp_path, letters, orders, lengths=(3, 3, 3)):
    """A FOLD file of a strip without a folded form, with orders of its faces."""
    path = tmp_path / "strip.fold"
    document = json.loads(fold_bytes(strip(lengths, letters), "strip"))
    path.write_text(json.dumps({**document, "faceOrders": orders}))
    return path


def converted(path):
    """The faceOrders of a file that is converted, and the codes of what is told."""
    made = convert(read_fold(path), path.parent / "out.fold")
    write(made, path.parent)
    document = json.loads(made.files["out.fold"])
    assert "file_frames" not in document
    return document.get("faceOrders"), {finding.code for finding in made.findings}


@pytest.mark.parametrize(
    ("orders", "codes"),
    [
        ([[0, 1, 1], [1, 2, 1], [0, 2, 1]], {"face-orders-contradict"}),
        ([[0, 1, -1], [1, 2, 1]], set()),
        ([[0, 2, 0]], set()),
        ([[0, 1, -1], [1, 2, 1], [0, 2, 1]], set()),
    ],
)
def test_orders_without_a_folded_form_are_kept_or_told(tmp_path, orders, codes):
    """A mountain and a valley: the first face is over the second, which is over the third."""
    path = flat_file(tmp_path, "MV", orders)
    assert converted(path) == (None if codes else orders, codes)
    assert read_fold(tmp_path / "out.fold").face_orders.tolist() == ([] if codes else orders)


def test_orders_of_a_sheet_that_cannot_lie_flat_are_told(tmp_path):
    path = flat_file(tmp_path, "VV", [[0, 1, 1]], (30, 10, 30))
    assert converted(path) == (None, {"cannot-lie-flat"})


def test_orders_that_are_not_judged_in_time_are_kept(tmp_path, monkeypatch):
    monkeypatch.setattr("fab.jobs.conversion._LAYERS_S", 0.0)
    path = flat_file(tmp_path, "MV", [[0, 1, -1]])
    assert converted(path) == ([[0, 1, -1]], {"layers-undecided"})


def test_faces_that_run_clockwise_in_the_file_have_their_orders_turned(tmp_path):
    pattern = strip([2, 2], "V")

    def turn(document):
        document["faces_vertices"][1].reverse()
        document["file_frames"][0]["faceOrders"] = [[0, 1, -1]]

    read = read_fold(folded_file(tmp_path, pattern, change=turn))
    assert "face-clockwise" in {finding.code for finding in read.findings}
    assert read.face_orders.tolist() == [[0, 1, 1]]
    assert layer_orders(read.pattern, read.face_orders).given is True


def test_orders_of_faces_without_area_go_with_them(tmp_path):
    pattern = strip([2, 2], "V")

    def add(document):
        document["faces_vertices"].insert(0, [0, 1, 2])
        document["file_frames"][0]["faceOrders"] = [[1, 2, 1], [0, 2, 1]]

    read = read_fold(folded_file(tmp_path, pattern, change=add))
    assert read.face_orders.tolist() == [[0, 1, 1]]


@pytest.mark.parametrize(
    "rows",
    [
        *([[0, 1]], [[0, 1, 2]], [[0, 7, 1]], [[-1, 0, 1]], [[0, 0, 1]], [[0, 1, 1.5]]),
        *([["a", 1, 1]], [[0, 1, 1], [0]], 5, {"a": 1}),
    ],
)
def test_rows_that_are_no_orders_are_left_out_and_reported(tmp_path, rows):
    def change(document):
        document["file_frames"][0]["faceOrders"] = rows

    read = read_fold(folded_file(tmp_path, strip([2, 2], "V"), change=change))
    assert not len(read.face_orders)
    assert "face-orders-unknown" in {finding.code for finding in read.findings}
