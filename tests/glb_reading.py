"""GLB files read back: arrays of accessors, nodes by name, and the Khronos validator."""

from __future__ import annotations

import json
import shutil
import struct
import subprocess
from functools import cache
from pathlib import Path

import numpy as np
import pygltflib
import pytest

_NUMPY = {5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTH = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}
_VALIDATE = """
const { validateBytes } = require("gltf-validator");
const { readFileSync } = require("fs");
const [, file] = process.argv;
const data = new Uint8Array(readFileSync(file));
validateBytes(data).then((found) => console.log(JSON.stringify(found)));
"""


def read_glb(data: bytes) -> pygltflib.GLTF2:
    return pygltflib.GLTF2.load_from_bytes(data)


def rows(document: pygltflib.GLTF2, number: int) -> np.ndarray:
    """The rows of an accessor."""
    accessor = document.accessors[number]
    view = document.bufferViews[accessor.bufferView]
    width = _WIDTH[accessor.type]
    kind = _NUMPY[accessor.componentType]
    flat = np.frombuffer(
        document.binary_blob(), kind, accessor.count * width, view.byteOffset + accessor.byteOffset
    )
    assert flat.nbytes == view.byteLength
    return flat.reshape(-1, width) if width > 1 else flat


def states_of(document: pygltflib.GLTF2, primitive, attribute: str) -> np.ndarray:
    """An attribute of a primitive in its base and with each morph target, shape (n, nv, 3)."""
    base = rows(document, getattr(primitive.attributes, attribute))
    changes = [rows(document, target[attribute]) for target in primitive.targets]
    return np.stack([base, *(base + change for change in changes)])


def channels(document: pygltflib.GLTF2) -> dict[tuple[str, str], tuple[np.ndarray, np.ndarray]]:
    """Times and values of the only animation, by name of the node and path."""
    (animation,) = document.animations
    out = {}
    for channel in animation.channels:
        sampler = animation.samplers[channel.sampler]
        key = document.nodes[channel.target.node].name, channel.target.path
        out[key] = rows(document, sampler.input), rows(document, sampler.output)
    return out


@cache
def _missing() -> str:
    """What of the validator is missing: node, its package, or nothing."""
    if shutil.which("node") is None:
        return "node"
    look = subprocess.run(
        ["node", "-e", "require.resolve('gltf-validator')"], cwd=Path(__file__).parent, check=False
    )
    return "npm's gltf-validator, which NODE_PATH may lead to" if look.returncode else ""


def validated(data: bytes, folder: Path) -> dict:
    """What the Khronos validator says of a file; skips where there is none."""
    if _missing():
        pytest.skip(f"no {_missing()}")
    file = folder / "model.glb"
    file.write_bytes(data)
    done = subprocess.run(
        ["node", "-e", _VALIDATE, str(file)],
        cwd=Path(__file__).parent,
        capture_output=True,
        text=True,
        check=True,
    )
    return json.loads(done.stdout)


def chunks(data: bytes) -> list[bytes]:
    """The names of the chunks of a GLB file, which is as long as it says."""
    magic, version, length = struct.unpack_from("<4sII", data)
    assert (magic, version, length) == (b"glTF", 2, len(data))
    place, names = 12, []
    while place < length:
        size, name = struct.unpack_from("<I4s", data, place)
        assert size % 4 == 0
        names.append(name)
        place += 8 + size
    return names
