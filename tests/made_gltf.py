"""glTF files for tests, and their positions frame by frame."""

import base64
import json
import struct
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

CODES = {"i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125, "f4": 5126}
KINDS = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}

BODY = {  # parent and where within it, m
    "Hips": (None, (0, 0.95, 0)),
    "Chest": ("Hips", (0, 0.35, 0)),
    "Neck": ("Chest", (0, 0.2, 0)),
    "Head": ("Neck", (0, 0.12, 0.02)),
    **{
        f"{side}{joint}": (parent if parent in ("Hips", "Chest") else side + parent, at)
        for side, x in (("Left", 1), ("Right", -1))
        for joint, parent, at in (
            ("Arm", "Chest", (0.2 * x, 0.15, 0)),
            ("ForeArm", "Arm", (0.28 * x, 0, 0)),
            ("Hand", "ForeArm", (0.25 * x, 0, 0)),
            ("UpLeg", "Hips", (0.1 * x, -0.04, 0)),
            ("Leg", "UpLeg", (0, -0.42, 0)),
            ("Foot", "Leg", (0, -0.41, 0)),
            ("ToeBase", "Foot", (0, -0.06, 0.13)),
        )
    },
}


class Made:
    """A glTF file that grows."""

    def __init__(self) -> None:
        self.json: dict[str, Any] = {
            "asset": {"version": "2.0"},
            "nodes": [],
            "bufferViews": [],
            "accessors": [],
            "animations": [],
        }
        self.bytes = b""

    def node(self, name: str, parent: int | None = None, **rest: Any) -> int:
        nodes = self.json["nodes"]
        nodes.append({"name": name, **rest})
        if parent is not None:
            nodes[parent].setdefault("children", []).append(len(nodes) - 1)
        return len(nodes) - 1

    def view(self, data: bytes, **rest: Any) -> int:
        self.bytes += b"\0" * (-len(self.bytes) % 4)
        view = {"buffer": 0, "byteOffset": len(self.bytes), "byteLength": len(data), **rest}
        self.json["bufferViews"].append(view)
        self.bytes += data
        return len(self.json["bufferViews"]) - 1

    def accessor(self, values: Any, kind: str = "f4", **rest: Any) -> int:
        array = np.asarray(values, "<" + kind)
        array = array.reshape(len(array), -1)
        told = {
            "bufferView": self.view(array.tobytes()),
            "componentType": CODES[kind],
            "count": len(array),
            "type": KINDS[array.shape[1]],
            **rest,
        }
        self.json["accessors"].append({key: it for key, it in told.items() if it is not None})
        return len(self.json["accessors"]) - 1

    def animation(self, name: str | None = None) -> dict[str, Any]:
        made: dict[str, Any] = {"channels": [], "samplers": []}
        if name is not None:
            made["name"] = name
        self.json["animations"].append(made)
        return made

    def track(
        self,
        animation: dict[str, Any],
        node: int,
        path: str,
        times: int,
        values: int,
        kind: str | None = None,
    ) -> None:
        sampler = {"input": times, "output": values}
        if kind is not None:
            sampler["interpolation"] = kind
        animation["samplers"].append(sampler)
        target = {"node": node, "path": path}
        number = len(animation["samplers"]) - 1
        animation["channels"].append({"sampler": number, "target": target})

    def glb(self) -> bytes:
        told = {**self.json, "buffers": [{"byteLength": len(self.bytes)}]}
        text = json.dumps({key: it for key, it in told.items() if it != []}).encode()
        text += b" " * (-len(text) % 4)
        data = self.bytes + b"\0" * (-len(self.bytes) % 4)
        size = 12 + 8 + len(text) + 8 + len(data)
        return (
            struct.pack("<4sIII4s", b"glTF", 2, size, len(text), b"JSON")
            + text
            + struct.pack("<I4s", len(data), b"BIN\0")
            + data
        )

    def gltf(self, uri: str | None = None) -> bytes:
        if uri is None:
            data = base64.b64encode(self.bytes).decode()
            uri = f"data:application/octet-stream;base64,{data}"
        buffers = [{"byteLength": len(self.bytes), "uri": uri}]
        told = {**self.json, "buffers": buffers}
        return json.dumps({key: it for key, it in told.items() if it != []}).encode()


def body(
    made: Made, prefix: str = "", skin: str | None = "Ada", under: int | None = None
) -> dict[str, int]:
    """Add a body's nodes, and a skin of them; return them by their names."""
    nodes: dict[str, int] = {}
    for name, (parent, at) in BODY.items():
        above = under if parent is None else nodes[parent]
        nodes[name] = made.node(prefix + name, above, translation=list(map(float, at)))
    if skin is not None:
        skins = made.json.setdefault("skins", [])
        skins.append({"name": skin, "joints": list(nodes.values())})
    return nodes


def waving(made: Made, nodes: dict[str, int], frames: int = 10, name: str = "wave") -> None:
    """Add an animation at 30 frames a second: the hips go forward, the right arm is raised."""
    times = made.accessor(np.arange(frames) / 30)
    take = made.animation(name)
    ways = np.stack([np.zeros(frames), np.full(frames, 0.95), np.arange(frames) / 50], axis=1)
    made.track(take, nodes["Hips"], "translation", times, made.accessor(ways))
    angles = np.linspace(0, -90, frames)
    turns = Rotation.from_euler("z", angles[:, None], degrees=True).as_quat()
    made.track(take, nodes["RightArm"], "rotation", times, made.accessor(turns))


def with_unknown(data: bytes, gaps: dict[str, list[list[int]]]) -> bytes:
    """Return a GLB of LanIndex that says in which frames joints are unknown."""
    length = struct.unpack("<I", data[12:16])[0]
    root, binary = json.loads(data[20 : 20 + length]), data[20 + length :]
    root["animations"][0]["extras"]["unknown"] = gaps
    text = json.dumps(root, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    head = struct.pack("<4sIII4s", b"glTF", 2, 20 + len(text) + len(binary), len(text), b"JSON")
    return head + text + binary


def plain_value(
    node: dict[str, Any], path: str, tracks: dict[Any, Any], index: int, second: float
) -> Any:
    """Return a node's shift, turn or scale at a time, by scipy and by hand."""
    default = {"translation": [0, 0, 0], "rotation": [0, 0, 0, 1], "scale": [1, 1, 1]}[path]
    if (index, path) not in tracks:
        return np.array(node.get(path, default), float)
    kind, times, values = tracks[index, path]
    if kind == "CUBICSPLINE":
        values = values.reshape(len(times), 3, -1)
    if second <= times[0] or len(times) == 1:
        return values[0] if kind != "CUBICSPLINE" else values[0, 1]
    if second >= times[-1]:
        return values[-1] if kind != "CUBICSPLINE" else values[-1, 1]
    k = max(number for number, time in enumerate(times) if time <= second)
    if kind == "STEP":
        return values[k]
    wide = times[k + 1] - times[k]
    u = (second - times[k]) / wide
    if kind == "CUBICSPLINE":
        h = [2 * u**3 - 3 * u**2 + 1, u**3 - 2 * u**2 + u, -2 * u**3 + 3 * u**2, u**3 - u**2]
        return (
            h[0] * values[k, 1]
            + h[1] * wide * values[k, 2]
            + h[2] * values[k + 1, 1]
            + h[3] * wide * values[k + 1, 0]
        )
    if path == "rotation":
        return Slerp([0, 1], Rotation.from_quat(values[k : k + 2]))(u).as_quat()
    return (1 - u) * values[k] + u * values[k + 1]


def plain_places(nodes: list[dict[str, Any]], tracks: dict[Any, Any], second: float) -> Any:
    """Return where all nodes are at a time, (N, 3): matrices, one node after the other."""
    parents = {
        child: number for number, node in enumerate(nodes) for child in node.get("children", ())
    }
    worlds: dict[int, Any] = {}

    def world(number: int) -> Any:
        if number in worlds:
            return worlds[number]
        node = nodes[number]
        own = np.eye(4)
        if "matrix" in node:
            own = np.array(node["matrix"], float).reshape(4, 4).T
        else:
            turn = plain_value(node, "rotation", tracks, number, second)
            scale = plain_value(node, "scale", tracks, number, second)
            own[:3, :3] = Rotation.from_quat(turn).as_matrix() @ np.diag(scale)
            own[:3, 3] = plain_value(node, "translation", tracks, number, second)
        worlds[number] = world(parents[number]) @ own if number in parents else own
        return worlds[number]

    return np.array([world(number)[:3, 3] for number in range(len(nodes))])
