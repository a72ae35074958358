"""The studio ends at once, however it is asked to, also while it makes files."""

import json
import signal
import sys
import threading
import time
import urllib.request
from contextlib import suppress

import pytest
from helpers import TEMPLATES
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
