"""FBX files, as text and binary, made up for tests."""

import re
import struct
from collections.abc import Collection, Iterator, Mapping

from made_gltf import BODY

SECOND = 46_186_158_000
"""What FBX counts time in."""

Keys = Mapping[tuple[str, str], list[float]]
"""By joint and ``Lcl Rotation|d|Z``, one value for each frame."""


def fbx(
    takes: Mapping[str, Keys],
    people: tuple[str, ...] = ("",),
    unit: float = 1.0,
    up: int = 1,
    left_handed: bool = False,
    bone: str = "LimbNode",
    timed: bool = True,
    joints: Collection[str] = tuple(BODY),
) -> bytes:
    """Return a body of `made_gltf` whose names begin as told, at 30 frames a second.

    Its units are so many centimetres; keys that are no angles are in centimetres.
    """
    objects, links = list[str](), list[str]()
    numbers: dict[str, int] = {}
    places: dict[int, list[float]] = {}
    for person in people:
        for name, (parent, at) in BODY.items():
            if name not in joints:
                continue
            number = numbers[person + name] = 1000 + 10 * len(numbers)
            at = at if up == 1 else (at[0], -at[2], at[1])
            x, y, z = places[number] = [100 * value / unit for value in at]
            objects.append(
                f'Model: {number}, "Model::{person}{name}", "{bone}" {{\n Version: 232\n'
                " Properties70:  {\n"
                f'  P: "Lcl Translation", "Lcl Translation", "", "A",{x},{y},{z}\n }}\n}}'
            )
            if bone == "LimbNode":
                objects.append(
                    f'NodeAttribute: {number + 1}, "NodeAttribute::{name}", "LimbNode" {{\n'
                    ' TypeFlags: "Skeleton"\n}'
                )
                links.append(f'C: "OO",{number + 1},{number}')
            links.append(f'C: "OO",{number},{numbers[person + parent] if parent else 0}')
    number = 100_000
    for take, keys in takes.items():
        stack, layer = number, number + 1
        number += 2
        count = max(map(len, keys.values()), default=1)
        stop = (count - 1) * SECOND // 30
        objects.append(
            f'AnimationStack: {stack}, "AnimStack::{take}", "" {{\n Properties70:  {{\n'
            + ('  P: "LocalStart", "KTime", "Time", "",0\n' * timed)
            + f'  P: "LocalStop", "KTime", "Time", "",{stop}\n }}\n}}'
        )
        objects.append(f'AnimationLayer: {layer}, "AnimLayer::Base", "" {{\n}}')
        links.append(f'C: "OO",{layer},{stack}')
        for (joint, path), values in keys.items():
            prop, _, axis = path.partition("|")
            turns = prop == "Lcl Rotation"
            still = zip("XYZ", [0] * 3 if turns else places[numbers[joint]], strict=True)
            told = "".join(f'  P: "d|{it}", "Number", "", "A",{value}\n' for it, value in still)
            objects.append(
                f'AnimationCurveNode: {number}, "AnimCurveNode::T", "" {{\n'
                f" Properties70:  {{\n{told} }}\n}}"
            )
            values = values if turns else [value / unit for value in values]
            times = ",".join(str(frame * SECOND // 30) for frame in range(len(values)))
            objects.append(
                f'AnimationCurve: {number + 1}, "AnimCurve::", "" {{\n Default: 0\n'
                f" KeyVer: 4008\n KeyTime: *{len(values)} {{\n  a: {times}\n }}\n"
                f" KeyValueFloat: *{len(values)} {{\n  a: {','.join(map(str, values))}\n }}\n"
                " KeyAttrFlags: *1 {\n  a: 4\n }\n KeyAttrDataFloat: *4 {\n  a: 0,0,0,0\n }\n"
                f" KeyAttrRefCount: *1 {{\n  a: {len(values)}\n }}\n}}"
            )
            links.append(f'C: "OO",{number},{layer}')
            links.append(f'C: "OP",{number},{numbers[joint]}, "{prop}"')
            links.append(f'C: "OP",{number + 1},{number}, "{axis}"')
            number += 2
    front = 2 if up == 1 else 1
    sign = 1 if (up == 1) != left_handed else -1
    settings = (
        ("UpAxis", up), ("UpAxisSign", 1), ("FrontAxis", front), ("FrontAxisSign", sign),
        ("CoordAxis", 0), ("CoordAxisSign", 1), ("TimeMode", 6),
    )  # fmt: skip
    told = "\n".join(f'  P: "{name}", "int", "Integer", "",{value}' for name, value in settings)
    return (
        "; FBX 7.4.0 project file\nFBXHeaderExtension:  {\n FBXVersion: 7400\n}\n"
        f"GlobalSettings:  {{\n Version: 1000\n Properties70:  {{\n{told}\n"
        f'  P: "UnitScaleFactor", "double", "Number", "",{unit}\n }}\n}}\n'
        f"Objects:  {{\n{chr(10).join(objects)}\n}}\nConnections:  {{\n{chr(10).join(links)}\n}}\n"
    ).encode()


def waving(person: str = "", frames: int = 10) -> dict[tuple[str, str], list[float]]:
    """Return keys with which the hips go forward and the right arm is raised."""
    return {
        (person + "Hips", "Lcl Translation|d|Z"): [2.0 * frame for frame in range(frames)],
        (person + "RightArm", "Lcl Rotation|d|Z"): [
            -90.0 * frame / (frames - 1) for frame in range(frames)
        ],
    }


_TOKEN = re.compile(rb'"[^"]*"|[A-Za-z]\w*:|[*\w.+-]+|[{}]')
_ARRAYS = {b"KeyTime": "lq", b"KeyAttrFlags": "ii", b"KeyAttrRefCount": "ii"}
_END = bytes(13)


def binary(text: bytes) -> bytes:
    """Return an FBX file that `fbx` has made, in the other encoding."""
    head = b"Kaydara FBX Binary  \0\x1a\0" + struct.pack("<I", 7400)
    tokens = iter(_TOKEN.findall(text.partition(b"\n")[2]))
    return head + _nodes(tokens, len(head))


def _nodes(tokens: Iterator[bytes], at: int) -> bytes:
    """Return the nodes up to the next closing bracket, the first of which stands at some byte."""
    written, token = b"", next(tokens, b"}")
    while token != b"}":
        name, values, inner = token[:-1], list[bytes](), b""
        token = next(tokens, b"}")
        while token not in b"{}" and not token.endswith(b":"):
            values.append(token)
            token = next(tokens, b"}")
        start = at + len(written) + 13 + len(name)
        if token == b"{" and values and values[0].startswith(b"*"):
            next(tokens)
            numbers = list[float]()
            while (token := next(tokens)) != b"}":
                numbers.append(float(token))
            code, kind = _ARRAYS.get(name, "ff")
            packed = [*numbers] if kind == "f" else [*map(int, numbers)]
            content = struct.pack(f"<{len(packed)}{kind}", *packed)
            told = code.encode() + struct.pack("<3I", len(packed), 0, len(content)) + content
            values, token = values[:1], next(tokens, b"}")
        else:
            told = b"".join(map(_value, values))
            if token == b"{":
                inner = _nodes(tokens, start + len(told))
                token = next(tokens, b"}")
        end = start + len(told) + len(inner)
        sizes = struct.pack("<3IB", end, len(values), len(told), len(name))
        written += sizes + name + told + inner
    return written + _END


def _value(token: bytes) -> bytes:
    if token.startswith(b'"'):
        kind, colons, name = token.strip(b'"').partition(b"::")
        text = name + b"\0\1" + kind if colons else kind
        return b"S" + struct.pack("<I", len(text)) + text
    if token.lstrip(b"-").isdigit():
        return b"L" + struct.pack("<q", int(token))
    return b"D" + struct.pack("<d", float(token))
