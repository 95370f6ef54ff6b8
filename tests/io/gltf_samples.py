"""Small glTF documents built by hand, independently of the writer."""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np

CODES = {"int8": 5120, "uint8": 5121, "int16": 5122, "uint16": 5123, "uint32": 5125, "float32": 5126}
KINDS = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}

SQUARE = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0.5]], np.float32)
FACES = np.array([[0, 1, 2], [2, 1, 3]], np.uint16)


class Sample:
    """A document that grows by one array, mesh or node at a time."""

    def __init__(self) -> None:
        self.root: dict[str, Any] = {
            "asset": {"version": "2.0"},
            "buffers": [{"byteLength": 0}],
            "scenes": [{"nodes": []}],
            "scene": 0,
        }
        self.binary = b""

    def add(self, kind: str, element: dict[str, Any]) -> int:
        self.root.setdefault(kind, []).append(element)
        return len(self.root[kind]) - 1

    def view(self, content: bytes, **more: Any) -> int:
        self.binary += b"\0" * (-len(self.binary) % 4)
        view = {"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(content), **more}
        self.binary += content
        self.root["buffers"][0]["byteLength"] = len(self.binary)
        return self.add("bufferViews", view)

    def array(self, values: np.ndarray, **more: Any) -> int:
        values = np.ascontiguousarray(values).reshape(len(values), -1)
        accessor = {"componentType": CODES[values.dtype.name], "count": len(values), "type": KINDS[values.shape[1]]}
        if values.shape[1] in {1, 3}:
            accessor |= {"min": values.min(0).tolist(), "max": values.max(0).tolist()}
        return self.add("accessors", {**accessor, "bufferView": self.view(values.tobytes()), **more})

    def primitive(
        self, vertices: np.ndarray = SQUARE, faces: np.ndarray | None = FACES, deltas: Any = (), **more: Any
    ) -> dict[str, Any]:
        attributes = {"POSITION": self.array(vertices), **more.pop("attributes", {})}
        primitive: dict[str, Any] = {"attributes": attributes, **more}
        if faces is not None:
            primitive["indices"] = self.array(faces.ravel())
        if len(deltas):
            primitive["targets"] = [{} if d is None else {"POSITION": self.array(np.float32(d))} for d in deltas]
        return primitive

    def mesh(self, *primitives: dict[str, Any], shapes: Any = None, **more: Any) -> int:
        extras = {} if shapes is None else {"extras": {"targetNames": list(shapes)}}
        return self.add("meshes", {"primitives": list(primitives), **extras, **more})

    def node(self, root: bool = True, **fields: Any) -> int:
        number = self.add("nodes", fields)
        if root:
            self.root["scenes"][0]["nodes"].append(number)
        return number

    def animate(self, *channels: tuple[int, str, np.ndarray, np.ndarray, str], name: str = "take") -> int:
        animation: dict[str, Any] = {"name": name, "channels": [], "samplers": []}
        for i, (node, path, times, values, interpolation) in enumerate(channels):
            flat = values.reshape(-1, 1) if path == "weights" else values.reshape(-1, values.shape[-1])
            sampler = {"input": self.array(np.float32(times)[:, None]), "output": self.array(np.float32(flat))}
            animation["samplers"].append({**sampler, "interpolation": interpolation})
            animation["channels"].append({"sampler": i, "target": {"node": node, "path": path}})
        return self.add("animations", animation)

    def content(self) -> bytes:
        text = json.dumps(self.root).encode()
        text += b" " * (-len(text) % 4)
        binary = self.binary + b"\0" * (-len(self.binary) % 4)
        chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(binary), 0x004E4942) + binary
        return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks

    def save(self, path: Path) -> Path:
        path.write_bytes(self.content())
        return path


def turn(axis: int, angle: float) -> np.ndarray:
    """A quaternion xyzw."""
    q = np.zeros(4)
    q[axis], q[3] = np.sin(angle / 2), np.cos(angle / 2)
    return q


def matrix(translation: Any = (0, 0, 0), rotation: Any = (0, 0, 0, 1), scale: Any = (1, 1, 1)) -> np.ndarray:
    """The 4 × 4 matrix of a node, column by column from Rodrigues' formula."""
    axis, w = np.asarray(rotation[:3], float), float(rotation[3])
    result = np.eye(4)
    for i, e in enumerate(np.eye(3)):
        result[:3, i] = (e + 2 * np.cross(axis, np.cross(axis, e) + w * e)) * scale[i]
    result[:3, 3] = translation
    return result


def contents(path: Path) -> tuple[dict[str, Any], bytes]:
    """The JSON and the binary chunk of a .glb."""
    content = path.read_bytes()
    (length,) = struct.unpack_from("<I", content, 12)
    return json.loads(content[20 : 20 + length]), content[28 + length :]


def skinned(animated: bool = True) -> Sample:
    """A skinned square with shapes on a bent arm of two joints under a scaled root, an unskinned eye beside it."""
    rng = np.random.default_rng(3)
    s = Sample()
    joints = np.array([[0, 1, 0, 0], [1, 0, 0, 0], [1, 0, 0, 0], [0, 1, 0, 0]], np.uint8)
    weights = np.pad(rng.random((4, 2)), ((0, 0), (0, 2))).astype(np.float32)
    weights /= weights.sum(1, keepdims=True)
    inverse = np.stack([matrix((0.1, -0.2, 0.3), turn(2, 0.4)), matrix((-1, 0.5, 0), turn(0, -0.3), (2, 2, 2))])
    attributes = {"JOINTS_0": s.array(joints), "WEIGHTS_0": s.array(weights)}
    face = s.primitive(deltas=rng.normal(0, 0.1, (2, 4, 3)), attributes=attributes)
    s.mesh(face, shapes=["jawOpen", "smile"], name="face")
    s.mesh(s.primitive(SQUARE * np.float32(0.1), deltas=rng.normal(0, 0.1, (1, 4, 3))), shapes=["jawOpen"], name="eye")
    skin = {"joints": [1, 2], "inverseBindMatrices": s.array(np.float32(inverse.swapaxes(1, 2).reshape(2, 16)))}
    s.add("skins", skin)
    s.node(name="hips", scale=[2, 2, 2], children=[1], translation=[0, 1, 0])
    s.node(root=False, name="neck", translation=[0, 0.5, 0], rotation=turn(0, 0.2).tolist(), children=[2])
    s.node(root=False, name="mixamorig:Head", matrix=matrix((0, 0.3, 0), turn(1, 0.5)).T.ravel().tolist(), children=[4])
    s.node(name="body", mesh=0, skin=0)
    s.node(root=False, name="eye", mesh=1, translation=[0, 0.1, 0.1])
    if animated:
        times = np.arange(5) / 24
        q = np.stack([turn(2, a) for a in np.linspace(0, 2, 5)])
        s.animate(
            (1, "rotation", times, q, "LINEAR"),
            (0, "translation", times, rng.normal(0, 1, (5, 3)), "LINEAR"),
            (3, "weights", times, rng.random((5, 2)), "LINEAR"),
        )
    return s
