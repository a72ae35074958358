"""Foreign files in a process of their own: crashes, hangs and greed end there, with a reason."""

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest
import trimesh
from build123d import Cylinder, Sphere, export_step
from helpers import ROOT
from shared_cases import shared_case

from fab.errors import InvalidFile, InvalidJob
from fab.formats.meshes import surface
from fab.formats.meshes.own_process import Bounds, in_own_process
from fab.formats.meshes.surface import read_surface
from solver.errors import InvalidState, InvalidValue
from solver.targets.mesh import MeshSurface

ENOUGH = Bounds(60, 4000)
WORK = """
import os, time
import numpy as np
from fab.errors import InvalidFile, InvalidJob
from solver.errors import InvalidState, InvalidValue

def doubled(values):
    return {"values": 2 * np.array(values), "names": np.array(["ä", "b"])}

def talks(path):
    os.write(1, b"*" * 200_000)
    os.write(2, b"*" * 200_000)
    return {}

def hangs(path):
    open(path, "w").write(str(os.getpid()))
    time.sleep(600)

def spins(path):
    while True:
        pass

def dies(path):
    os.abort()

def leaves(path):
    os._exit(3)

def eats(path):
    return {"zeros": np.ones(10**10)}

def value(path):
    raise InvalidValue("face", 7, "lie from 0 to 2", "The faces are three.")

def state(path):
    raise InvalidState("mesh", "the mesh is one-sided", "Cut it open.")

def file(path):
    raise InvalidFile("x.step: it holds no faces.")

def vast(path):
    import resource
    resource.setrlimit(resource.RLIMIT_FSIZE, (10**5, 10**5))
    return {"ones": np.ones(10**6)}

def other(path):
    raise RuntimeError("StdFail_NotDone\\nat 0x0")
"""


@pytest.fixture
def work(tmp_path, monkeypatch):
    """Calls a function of the module above for a file."""
    (tmp_path / "work_of_tests.py").write_text(WORK, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)

    def call(name, bounds=ENOUGH, **arguments):
        path = tmp_path / "a file.step"
        given = arguments or {"path": str(path)}
        return in_own_process(f"work_of_tests:{name}", path, given, bounds)

    return call


def test_arrays_come_back(work):
    found = work("doubled", values=[1.5, -2.0])
    assert found["values"].tolist() == [3.0, -4.0]
    assert found["names"].tolist() == ["ä", "b"]
    assert work("talks") == {}


def test_errors_of_our_own_come_back_as_they_are(work):
    with pytest.raises(InvalidValue, match="face = 7 is out of bounds") as caught:
        work("value")
    assert (caught.value.name, caught.value.value) == ("face", 7)
    assert (caught.value.bound, caught.value.cure) == ("lie from 0 to 2", "The faces are three.")
    with pytest.raises(InvalidState, match=r"^the mesh is one-sided\. Cut it open\.$"):
        work("state")
    with pytest.raises(InvalidFile, match=r"^x\.step: it holds no faces\.$"):
        work("file")


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("dies", r"crashed \(SIGABRT\)" if os.name == "posix" else "crashed"),
        ("leaves", r"crashed \(exit code 3\)"),
        ("other", r"cannot be read: RuntimeError: StdFail_NotDone\."),
    ],
)
def test_what_goes_wrong_is_a_refusal_with_its_reason(work, name, why):
    with pytest.raises(InvalidFile, match=rf"a file\.step: .*{why}.*export it again"):
        work(name)


@pytest.mark.skipif(os.name != "posix", reason="no bound on the size of files there")
def test_a_full_disk_is_not_blamed_on_the_file(work):
    with pytest.raises(InvalidJob, match=r"temporary files cannot be written: .* Free some space"):
        work("vast")


@pytest.mark.skipif(sys.platform != "linux", reason="no bound on address space there")
def test_memory_is_bounded(work):
    with pytest.raises(InvalidFile, match="needs over 1500 MB of memory"):
        work("eats", Bounds(60, 1500))


def alive(pid):
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_a_hang_ends_with_its_process(work, tmp_path):
    begin = time.monotonic()
    with pytest.raises(InvalidFile, match=r"took over 4 seconds to read and was given up"):
        work("hangs", Bounds(4, 4000))
    assert time.monotonic() - begin < 60
    assert not alive(int((tmp_path / "a file.step").read_text()))


@pytest.mark.skipif(sys.platform != "linux", reason="no signal at a bound of processor time")
def test_work_without_end_is_stopped_by_its_processor_time(work):
    with pytest.raises(InvalidFile, match=r"took over 2 seconds to read and was given up"):
        work("spins", Bounds(2, 4000))


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_an_interrupt_ends_the_process_too(work, tmp_path):
    noted = tmp_path / "a file.step"

    def interrupt():
        while not (noted.is_file() and noted.read_text()):
            time.sleep(0.05)
        os.kill(os.getpid(), signal.SIGINT)

    thread = threading.Thread(target=interrupt)
    # a shell starts what runs in the background with this signal ignored
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        thread.start()
        with pytest.raises(KeyboardInterrupt):
            work("hangs")
        thread.join()
    finally:
        signal.signal(signal.SIGINT, before)
    assert not alive(int(noted.read_text()))


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_the_process_ends_with_one_that_is_killed(work, tmp_path):
    noted = tmp_path / "a file.step"
    code = (
        "import sys; from pathlib import Path\n"
        "from fab.formats.meshes.own_process import Bounds, in_own_process\n"
        "path = Path(sys.argv[1])\n"
        "in_own_process('work_of_tests:hangs', path, {'path': str(path)}, Bounds(60, 4000))\n"
    )
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path), "TMPDIR": str(tmp_path)}
    parent = subprocess.Popen([sys.executable, "-c", code, str(noted)], env=environment)
    while not (noted.is_file() and noted.read_text()):
        assert parent.poll() is None
        time.sleep(0.05)
    parent.kill()
    parent.wait()
    end = time.monotonic() + 30
    while alive(int(noted.read_text())) and time.monotonic() < end:
        time.sleep(0.05)
    assert not alive(int(noted.read_text()))


@pytest.mark.parametrize("share", [0.02, 0.3, 0.6, 0.9])
def test_truncated_models_are_refused(tmp_path, share):
    export_step(Cylinder(2, 5), tmp_path / "whole.step")
    text = (tmp_path / "whole.step").read_text()
    (tmp_path / "cut.step").write_text(text[: int(share * len(text))])
    with pytest.raises((InvalidFile, InvalidValue), match=r"cut\.step|face = 0"):
        read_surface(tmp_path / "cut.step", 0)


def test_a_hanging_reader_is_given_up(tmp_path, monkeypatch):
    export_step(Sphere(2), tmp_path / "ball.step")
    monkeypatch.setattr(surface, "reading_bounds", lambda size: Bounds(0.05, 4000))
    with pytest.raises(InvalidFile, match=r"ball\.step: took over 0.05 seconds"):
        read_surface(tmp_path / "ball.step")


def test_large_meshes_are_read_in_a_process_of_their_own(tmp_path, monkeypatch):
    mesh = trimesh.creation.icosphere(subdivisions=2)
    mesh.update_faces(mesh.triangles_center[:, 2] > 0.3)
    mesh.export(tmp_path / "dome.obj")
    within = read_surface(tmp_path / "dome.obj")
    monkeypatch.setattr(surface, "LARGE_MESH_BYTES", 10)
    apart = read_surface(tmp_path / "dome.obj")
    assert isinstance(apart, MeshSurface)
    assert np.array_equal(apart.vertices_coords, within.vertices_coords)
    assert np.array_equal(apart.triangles, within.triangles)
    (tmp_path / "lies.ply").write_bytes(
        b"ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float x\n"
        b"property float y\nproperty float z\nelement face 1\n"
        b"property list uchar int vertex_indices\nend_header\n" + bytes(40)
    )
    with pytest.raises((InvalidFile, InvalidValue), match=r"[Ee]xport it again"):
        read_surface(tmp_path / "lies.ply")


def test_a_model_that_crashes_its_reader_is_refused(tmp_path):
    """A job as users run it: exit code 2 and one line, not the signal of the library."""
    job = shared_case("step_crash") / "j.toml"
    command = [sys.executable, "-m", "fab", "run", str(job), "--only", "fold"]
    done = subprocess.run(
        [*command, "--out", str(tmp_path)],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(map(str, (ROOT, *map(Path, sys.path))))},
        check=False,
    )
    assert done.returncode == 2
    assert "s.step: the library that reads it crashed" in done.stderr
    assert done.stderr.count("\n") == 1
