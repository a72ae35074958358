import json
from dataclasses import replace

import numpy as np
import pytest
from folded_strips import strip

from fab.formats.fold.reader import read_fold
from fab.formats.fold.writer import fold_bytes
from fab.jobs.conversion import convert
from fab.layers.layer_orders import layer_orders
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
