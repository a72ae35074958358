"""A glTF 2.0 document that is put together from arrays, and written as GLB by pygltflib."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pygltflib as gltf

from fab import __version__
from solver.vectors import FloatArray, IntArray

__all__ = ["Channels", "GltfDocument"]

_KINDS = {1: gltf.SCALAR, 3: gltf.VEC3, 4: gltf.VEC4}
_ALIGNMENT = 4
# Channels of one node: translation, rotation or weights, with a row for each time.
Channels = Mapping[str, FloatArray]


class GltfDocument:
    """Arrays, materials, meshes and nodes in the order in which they are added, equal ones once.

    Coordinates are in metres, y up, colours linear red, green, blue and opacity.
    """

    def __init__(self) -> None:
        self._made = gltf.GLTF2(
            asset=gltf.Asset(generator=f"quadfold {__version__}"), scene=0, scenes=[gltf.Scene()]
        )
        self._chunks: list[bytes] = []
        self._views: dict[tuple[bytes, int | None], int] = {}
        self._accessors: dict[tuple[int, int, str, bool], int] = {}
        self._meshes: dict[str, int] = {}
        self._size = 0

    def positions(self, rows: FloatArray) -> int:
        """Number of a new accessor of positions of vertices, shape (n, 3), with their box."""
        return self._vectors(rows, gltf.ARRAY_BUFFER, bounded=True)

    def directions(self, rows: FloatArray) -> int:
        """Number of a new accessor of normals of vertices, shape (n, 3)."""
        return self._vectors(rows, gltf.ARRAY_BUFFER, bounded=False)

    def _vectors(self, rows: FloatArray, target: int | None, *, bounded: bool) -> int:
        """An accessor of float32 vectors, shape (n, 3) or (n, 4), or of scalars (n,)."""
        values = np.ascontiguousarray(rows, dtype="<f4")
        table = values.reshape(len(values), -1)
        bounds: dict[str, list[float]] = {}
        if bounded:
            bounds = {"min": table.min(axis=0).tolist(), "max": table.max(axis=0).tolist()}
        view = self._view(values.tobytes(), target)
        return self._accessor(view, gltf.FLOAT, len(values), _KINDS[table.shape[1]], bounds)

    def numbers(self, numbers: IntArray) -> int:
        """Number of a new accessor of indices, in as few bytes as hold the largest of them."""
        small = int(numbers.max(initial=0)) < 0xFFFF
        values = np.ascontiguousarray(numbers.ravel(), dtype="<u2" if small else "<u4")
        view = self._view(values.tobytes(), gltf.ELEMENT_ARRAY_BUFFER)
        kind = gltf.UNSIGNED_SHORT if small else gltf.UNSIGNED_INT
        return self._accessor(view, kind, len(values), gltf.SCALAR, {})

    def material(self, name: str, colour: Sequence[float]) -> int:
        """Number of a new matt material, seen from one side."""
        surface = gltf.PbrMetallicRoughness(
            baseColorFactor=list(colour), metallicFactor=0.0, roughnessFactor=0.9
        )
        self._made.materials.append(
            gltf.Material(name=name, pbrMetallicRoughness=surface, alphaCutoff=None)
        )
        return len(self._made.materials) - 1

    def mesh(
        self, name: str, primitives: Sequence[gltf.Primitive], targets: Sequence[str] = ()
    ) -> int:
        """Number of a mesh; targets : of its morph targets, the last of which is shown.

        One of the same primitives that is there already is taken for it, with the name that it has.
        """
        alike = repr((primitives, targets))
        if alike in self._meshes:
            return self._meshes[alike]
        weights = [0.0] * (len(targets) - 1) + [1.0] if targets else []
        made = gltf.Mesh(name=name, primitives=list(primitives), weights=weights)
        if targets:
            made.extras = {"targetNames": list(targets)}
        self._made.meshes.append(made)
        self._meshes[alike] = len(self._made.meshes) - 1
        return self._meshes[alike]

    def node(
        self,
        name: str,
        mesh: int,
        translation: list[float] | None = None,
        rotation: list[float] | None = None,
    ) -> int:
        """Number of a new node at the top of the scene; rotation : a quaternion x, y, z, w."""
        made = gltf.Node(name=name, mesh=mesh, translation=translation, rotation=rotation)
        self._made.nodes.append(made)
        number = len(self._made.nodes) - 1
        self._made.scenes[0].nodes.append(number)
        return number

    def animate(self, name: str, times: FloatArray, nodes: Mapping[int, Channels]) -> None:
        """Add an animation; times : shape (k,), seconds, of the rows of all channels."""
        clock = self._vectors(times, None, bounded=True)
        made = gltf.Animation(name=name)
        for node, channels in nodes.items():
            for path, rows in channels.items():
                sampler = gltf.AnimationSampler(
                    input=clock, output=self._vectors(rows, None, bounded=False)
                )
                made.samplers.append(sampler)
                target = gltf.AnimationChannelTarget(node=node, path=path)
                channel = gltf.AnimationChannel(sampler=len(made.samplers) - 1, target=target)
                made.channels.append(channel)
        self._made.animations.append(made)

    def glb_bytes(self) -> bytes:
        """The document as a GLB file, the same bytes for the same calls."""
        self._made.buffers = [gltf.Buffer(byteLength=self._size)]
        self._made.set_binary_blob(b"".join(self._chunks))
        return b"".join(self._made.save_to_bytes())

    def _view(self, data: bytes, target: int | None) -> int:
        if (data, target) in self._views:
            return self._views[data, target]
        self._made.bufferViews.append(
            gltf.BufferView(buffer=0, byteOffset=self._size, byteLength=len(data), target=target)
        )
        padded = data + bytes(-len(data) % _ALIGNMENT)
        self._chunks.append(padded)
        self._size += len(padded)
        self._views[data, target] = len(self._made.bufferViews) - 1
        return self._views[data, target]

    def _accessor(
        self, view: int, component: int, count: int, kind: str, bounds: Mapping[str, list[float]]
    ) -> int:
        alike = (view, component, kind, bool(bounds))
        if alike in self._accessors:
            return self._accessors[alike]
        made = gltf.Accessor(bufferView=view, componentType=component, count=count, type=kind)
        made.min, made.max = bounds.get("min"), bounds.get("max")
        self._made.accessors.append(made)
        self._accessors[alike] = len(self._made.accessors) - 1
        return self._accessors[alike]
