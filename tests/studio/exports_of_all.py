"""Compare what the studio exports with what `run` makes of the saved job, for all templates.

    python tests/studio/exports_of_all.py [--seconds 300] [TEMPLATE ...]

Every file has to be the same bytes; of the report all but its seconds. A template that takes more
seconds either way is passed over and named. Exit code 1 where any differs.
"""

from __future__ import annotations

import argparse
import io
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
import zipfile
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]

from starlette.testclient import TestClient
from studio_answers import head_of

from fab.catalogue import shipped
from fab.studio.app import Studio, studio_app

HOST = "127.0.0.1:8765"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=300)
    parser.add_argument("templates", nargs="*", default=list(shipped("jobs")))
    arguments = parser.parse_args()
    differ = 0
    with tempfile.TemporaryDirectory() as home:
        app = studio_app(Studio(Path(home), "token"), frozenset({HOST}))
        with TestClient(app, base_url=f"http://{HOST}/token/") as client:
            for name in arguments.templates:
                begin = time.monotonic()
                verdict = compared(client, name, Path(home), arguments.seconds)
                differ += verdict.startswith("differs")
                print(f"{name:<28} {time.monotonic() - begin:6.1f} s  {verdict}", flush=True)
    return int(differ > 0)


def compared(client: TestClient, name: str, folder: Path, seconds: float) -> str:
    """What comes of a template: saved by the studio, run, and exported by the studio."""
    text = head_of(post(client, "open", template=name))["text"]
    post(client, "save", text=text, file=f"{name}.toml")
    words = ["run", f"{name}.toml", "--out", name]
    try:
        ran = subprocess.run(
            [sys.executable, "-m", "fab", *words],
            cwd=folder,
            env={**os.environ, "PYTHONPATH": str(ROOT)},
            capture_output=True,
            timeout=seconds,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return f"passed over: run takes over {seconds:g} seconds"
    head = head_of(post(client, "make", command="run", text=text))
    if "key" not in head:
        return f"differs: the studio says {head}, run ends with {ran.returncode}"
    archive = client.get(f"made/{head['key']}/all.zip").content
    with zipfile.ZipFile(io.BytesIO(archive)) as package:
        made = {each: plain(package.read(each)) for each in package.namelist()}
    written = {path.name: plain(path.read_bytes()) for path in (folder / name).iterdir()}
    shutil.rmtree(folder / name)
    differing = [each for each in {*made, *written} if made.get(each) != written.get(each)]
    return f"differs: {', '.join(differing)}" if differing else f"equal: {len(made)} files"


def post(client: TestClient, name: str, **message: object) -> bytes:
    return client.post(name, content=json.dumps(message)).content


def plain(data: bytes) -> Any:
    """A file as it is; a report as values without its seconds."""
    if not data.startswith(b"{") or b'"seconds"' not in data:
        return data
    return {key: value for key, value in json.loads(data).items() if key != "seconds"}


if __name__ == "__main__":
    sys.exit(main())
