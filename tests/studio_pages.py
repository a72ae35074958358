"""The studio in a real browser: the command that serves it, and what tests look at in its page."""

from __future__ import annotations

import io
import os
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from helpers import ROOT
from PIL import Image

RIM = 12


def _heeds_signals():
    """What runs in the background of a shell ignores Ctrl-C, and with nohup a closed terminal."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGHUP, signal.SIG_DFL)


class Served:
    """The command, and the address that it prints."""

    def __init__(self, folder, *arguments):
        self.process = subprocess.Popen(
            [sys.executable, "-m", "fab", "studio", "--no-browser", *arguments],
            cwd=folder,
            env={**os.environ, "PYTHONPATH": str(ROOT), "PYTHONUNBUFFERED": "1"},
            stdout=subprocess.PIPE,
            text=True,
            preexec_fn=_heeds_signals,
        )
        guard = threading.Timer(60, self.process.kill)
        guard.start()
        self.address = ""
        for line in self.process.stdout:
            found = re.search(r"http://127\.0\.0\.1:\d+/[\w-]{32}/", line)
            if found:
                self.address = found.group()
                break
        guard.cancel()
        assert self.address

    def end(self):
        self.process.send_signal(signal.SIGINT)
        said, _ = self.process.communicate(timeout=30)
        return self.process.returncode, said


@dataclass
class Tab:
    """A tab of the studio, the complaints of the browser, and what it asked others for."""

    page: Any
    complaints: list[str] = field(default_factory=list)
    foreign: list[str] = field(default_factory=list)


@contextmanager
def studio_tab(browser: Any, address: str, expected: str = "\n") -> Iterator[Any]:
    """The studio in a tab with a memory of its own; foreign requests fail.

    So do complaints of the browser, but for those that have the expected words.
    """
    context = browser.new_context(viewport={"width": 1400, "height": 1000}, accept_downloads=True)
    tab = watched(context.new_page(), address)
    tab.page.goto(address)
    try:
        yield tab.page
    finally:
        context.close()
    assert [each for each in tab.complaints if expected not in each] == []
    assert tab.foreign == []


def watched(page: Any, address: str) -> Tab:
    """A page whose complaints and requests are noted."""
    tab = Tab(page)
    page.on("pageerror", lambda error: tab.complaints.append(str(error)))
    page.on(
        "console",
        lambda message: (
            tab.complaints.append(message.text)
            if message.type in ("error", "warning") and "ReadPixels" not in message.text
            else None
        ),
    )
    page.on(
        "request",
        lambda request: (
            tab.foreign.append(request.url)
            if not request.url.startswith((address, "blob:", "data:"))
            else None
        ),
    )
    return tab


def wait_until(page, true, seconds=30):
    until = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < until
        page.wait_for_timeout(50)


def verdict(page):
    return page.locator("#verdict").text_content()


def put(page, key, value):
    page.locator(f'[data-key="{key}"]').fill(str(value))


def shot(page):
    page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    picture = Image.open(io.BytesIO(page.locator("#form-view canvas").screenshot())).convert("RGB")
    return np.asarray(picture)[RIM:-RIM, RIM:-RIM]


def differ(first, second):
    return (first != second).any(axis=2).mean()


def make(page: Any) -> None:
    """Make what is chosen, and wait until it is made."""
    page.locator("#make").click()
    wait_until(page, lambda: page.locator("#made").text_content().startswith("made "))
