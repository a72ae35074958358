"""The studio ends at once, however it is asked to, also while it makes files."""

import json
import os
import signal
import subprocess
import sys
import threading
import time
import urllib.request
from contextlib import suppress

import pytest
from helpers import ROOT, TEMPLATES
from studio_pages import Served

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")


@pytest.mark.parametrize("number", [signal.SIGTERM, getattr(signal, "SIGHUP", None)])
def test_it_ends_while_it_makes_files_and_leaves_nothing(tmp_path, monkeypatch, number):
    temporary, folder = tmp_path / "temporary", tmp_path / "folder"
    temporary.mkdir()
    folder.mkdir()
    monkeypatch.setenv("TMPDIR", str(temporary))
    served = Served(folder)
    text = (TEMPLATES / "helicoid_80.toml").read_text("utf-8")  # which takes a while
    message = {"command": "run", "text": text, "tab": "1"}
    request = urllib.request.Request(served.address + "make", json.dumps(message).encode())

    def ask():
        with suppress(OSError):
            urllib.request.urlopen(request, timeout=120)

    asking = threading.Thread(target=ask)
    asking.start()
    time.sleep(2.0)
    begin = time.monotonic()
    served.process.send_signal(number)
    served.process.communicate(timeout=60)
    assert served.process.returncode == 0
    assert time.monotonic() - begin < 30
    asking.join(60)
    assert not asking.is_alive()
    assert not list(temporary.iterdir())
    assert not list(folder.iterdir())


@pytest.mark.parametrize("module", ["webbrowser", "wsproto"])
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, getattr(signal, "SIGHUP", None)])
def test_it_ends_by_what_came_while_a_library_was_imported(tmp_path, module, number):
    """Before the server begins, and as it does, when nothing may be raised."""
    act = f"import os, signal\nos.kill(os.getpid(), {int(number)})\nraise ImportError"
    if module == "webbrowser":
        act = act.replace("raise ImportError", "open = print")
    (tmp_path / f"{module}.py").write_text(act)

    def heed():
        for each in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            signal.signal(each, signal.SIG_DFL)  # a shell's background ignores some

    ended = subprocess.run(
        [sys.executable, "-m", "fab", "studio", "--no-browser"],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path), str(ROOT)])},
        capture_output=True,
        text=True,
        timeout=120,
        preexec_fn=heed,
    )
    assert "Traceback" not in ended.stderr
    assert ended.returncode in (0, 128 + number)
