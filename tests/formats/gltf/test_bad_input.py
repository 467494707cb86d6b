"""Damaged files raise errors with found and wanted."""

import random
import struct
import time
import tracemalloc

import numpy as np
import pytest
from made_gltf import Made, body, waving

from lanindex.errors import CaptureError, LanindexError
from lanindex.formats import gltf, read
from lanindex.formats.file import File
from lanindex.model import Motion, Span


def good() -> Made:
    made = Made()
    waving(made, body(made))
    return made


GOOD = good().glb()
TEXT = good().gltf()


def changed(change) -> bytes:
    made = good()
    change(made.json)
    return made.glb()


def at(*keys, value):
    """Return what sets a value somewhere in the JSON."""

    def change(told):
        for key in keys[:-1]:
            told = told[key]
        told[keys[-1]] = value

    return change


CASES = {
    "empty": (b"", "the file is empty", "glTF"),
    "cut in the head": (GOOD[:15], "has 15 bytes", "the 20 with which a GLB begins"),
    "cut in the JSON": (GOOD[:90], "has 90 bytes", "as its JSON is said to be long"),
    "cut in the numbers": (GOOD[:-100], "buffers[0] has", "as it says"),
    "no numbers": (GOOD[: GOOD.index(b"BIN") - 4], "buffers[0] is {", "bytes in the file"),
    "version 1": (struct.pack("<4sI", b"glTF", 1) + GOOD[8:], "GLB 1", "GLB 2"),
    "asset 1.0": (changed(at("asset", "version", value="1.0")), "asset.version is '1.0'", "2.0"),
    "broken JSON": (TEXT[:-5], "its JSON breaks at line 1", "JSON"),
    "no UTF-8": (TEXT.replace(b"wave", b"wav\xff"), "is no UTF-8", "JSON"),
    "deep": (b'{"asset": ' + b"[" * 100_000, "", "JSON"),
    "deeper": (
        b'{"asset": ' + b"[" * 100_000 + b"]" * 100_000 + b"}",
        "numbers too long or lists too deep",
        "JSON",
    ),
    "long number": (TEXT.replace(b"10,", b"1" * 5000 + b",", 1), "too long", "JSON"),
    "NaN": (TEXT.replace(b"0.95", b"NaN", 1), "NaN is no number", "JSON"),
    "many values": (b'{"asset": [' + b"0," * 4_000_001 + b"0]}", "too large", "values"),
    "a list": (b'["asset"]', "begins with", "glTF"),
    "nodes": (changed(at("nodes", value={})), "nodes is {}", "a list"),
    "a node": (changed(at("nodes", 0, value=3)), "nodes[0] is 3", "an object"),
    "a name": (changed(at("nodes", 0, "name", value=3)), "nodes[0].name is 3", "a text"),
    "a child": (changed(at("nodes", 0, "children", 0, value=99)), "children[0] is 99", "0 to 17"),
    "itself": (changed(at("nodes", 3, "children", value=[3])), "[0] is 3", "in no other node"),
    "twice": (changed(at("nodes", 3, "children", value=[1])), "is 1", "in no other node"),
    "a shift": (
        changed(at("nodes", 2, "translation", value=[0, 1e400, 0])),
        "no number",
        "JSON",
    ),
    "two numbers": (
        changed(at("nodes", 2, "translation", value=[0, 1])),
        "nodes[2].translation is [0, 1]",
        "3 finite numbers",
    ),
    "a matrix": (changed(at("nodes", 2, "matrix", value=[1] * 15)), "matrix", "16 finite"),
    "a joint": (changed(at("skins", 0, "joints", 0, value=-1)), "joints[0] is -1", "0 to 17"),
    "an accessor": (
        changed(at("animations", 0, "samplers", 0, "input", value=77)),
        "input is 77",
        "from 0 to 2",
    ),
    "no sampler": (
        changed(at("animations", 0, "samplers", value=[])),
        "sampler is 0",
        "of which there are none",
    ),
    "count": (
        changed(at("accessors", 0, "count", value=10**12)),
        "1000000000000 keys",
        "as many values",
    ),
    "counts": (
        changed(lambda told: [it.update(count=10**12) for it in told["accessors"]]),
        "needs 1000000000000 elements",
        "lies in the 40 bytes",
    ),
    "zeros": (
        changed(lambda told: [(it.update(count=10**12), it.pop("bufferView"))
                              for it in told["accessors"]]),
        "count is 1000000000000",
        "elements that are somewhere",
    ),
    "type": (changed(at("accessors", 0, "type", value="VEC9")), "'VEC9'", "SCALAR or"),
    "component": (changed(at("accessors", 0, "componentType", value=5130)), "is 5130", "5126"),
    "view": (changed(at("bufferViews", 0, "byteLength", value=10**9)), "ends at byte", "at most"),
    "kind": (
        changed(at("animations", 0, "samplers", 0, "interpolation", value="BEZIER")),
        "'BEZIER'",
        "LINEAR or STEP",
    ),
    "stride": (changed(at("bufferViews", 1, "byteStride", value=4)), "4 apart", "lies in"),
    "not finite": (
        GOOD.replace(struct.pack("<f", np.float32(1 / 30)), struct.pack("<f", np.nan)),
        "element 1 of accessors[0] is [nan]",
        "finite",
    ),
    "nothing beside it": (
        good().gltf("numbers.bin"),
        "buffers[0].uri is 'numbers.bin': there is no such file",
        "its numbers",
    ),
    "times": (
        GOOD.replace(struct.pack("<f", np.float32(1 / 30)), struct.pack("<f", 7)),
        "go back at key 2",
        "times that rise",
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_damage_is_named(case):
    data, found, wanted = CASES[case]
    with pytest.raises(CaptureError) as caught:
        read("a.glb", data=data)
    assert found in caught.value.found
    assert wanted in caught.value.wanted
    assert caught.value.place == "a.glb"
    assert "\n" not in str(caught.value)


def test_no_memory_for_bytes_that_are_used_again_and_again():
    made = good()
    times = made.accessor(np.arange(200_000) / 30)
    view = made.view(bytes(200_000 * 16))
    take = made.animation("again")
    for node in range(18):
        made.json["accessors"].append(
            {"bufferView": view, "componentType": 5126, "count": 200_000, "type": "VEC4"}
        )
        made.track(take, node, "rotation", times, len(made.json["accessors"]) - 1)
    made.json["animations"] = [take]
    data = made.glb()
    tracemalloc.start()
    with pytest.raises(CaptureError, match="is the same bytes once more"):
        read("a.glb", data=data)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 3 * len(data)


def test_no_time_for_skins_and_nodes_without_end():
    made = Made()
    top = None
    for number in range(502):
        top = made.node(f"n{number}", top)
    made.json["skins"] = [{"joints": list(range(501))}] * 200
    with pytest.raises(CaptureError, match="500 in each other"):
        read("a.glb", data=made.glb())


def outcome(data: bytes) -> str:
    """Read and cut; anything but a motion or one of our errors is a failure."""
    try:
        found = read("a.glb", data=data)
        gltf.subjects(File("a.glb", data))
        clip = gltf.cutter(File("a.glb", data))(Span(0, len(found)))
    except LanindexError as refused:
        error = refused
    else:
        error = None
    if error is not None:
        assert str(error).startswith("a.glb"), error
        return "error"
    assert isinstance(found, Motion)
    assert len(found) >= 1
    assert len(read("clip.glb", data=clip)) == len(found)
    return "motion"


SWAPS = (b"0", b"-1", b"9", b"1e9", b"1e-9", b"null", b"[]", b"{}", b'""', b"true", b"123456789")


def mutated(data: bytes, numbers: random.Random) -> bytes:
    """Return data with bytes changed, numbers of the JSON exchanged, stretches cut or doubled."""
    mutable = bytearray(data)
    for _ in range(numbers.choice((1, 1, 2, 5, 20))):
        place = numbers.randrange(len(mutable) + 1)
        length = min(numbers.choice((0, 1, 3, 30, 500)), len(mutable) - place)
        kind = numbers.randrange(5)
        if kind == 0:
            mutable[place : place + length] = b""
        elif kind == 1:
            mutable[place:place] = mutable[place : place + length]
        elif kind == 2:
            mutable[place : place + length] = numbers.randbytes(length)
        else:
            words = mutable.replace(b"]", b",").replace(b"}", b",")
            colon = words.find(b":" if kind == 3 else b",", place)
            stop = words.find(b",", colon + 1)
            if 0 < colon < stop < colon + 40:
                mutable[colon + 1 : stop] = numbers.choice(SWAPS)
    return bytes(mutable)


def rebuilt(data: bytes, numbers: random.Random) -> bytes:
    """Return a GLB whose JSON alone is mutated, its length mended."""
    length = struct.unpack("<I", data[12:16])[0]
    text = mutated(data[20 : 20 + length], numbers)
    return data[:12] + struct.pack("<I", len(text)) + b"JSON" + text + data[20 + length :]


def fuzz(sources: list[bytes], count: int, seed: int) -> dict[str, int]:
    numbers = random.Random(seed)
    seen = {"motion": 0, "error": 0}
    for _ in range(count):
        source = numbers.choice(sources)
        glb = source[:4] == b"glTF"
        change = rebuilt if glb and numbers.random() < 0.6 else mutated
        seen[outcome(change(source, numbers))] += 1
    return seen


def test_mutations_give_a_motion_or_an_error():
    begun = time.process_time()
    seen = fuzz([GOOD, TEXT], 500, 20260101)
    assert min(seen.values()) > 50, seen
    assert time.process_time() - begun < 120


@pytest.mark.slow
@pytest.mark.timeout(7200)
def test_long_fuzzing(captures):
    """Mutations of made and real files; `--slow` runs it."""
    real = [path.read_bytes() for path in sorted((captures / "gltf").iterdir())]
    seen = fuzz([GOOD, TEXT, *real], 5_000, 20260102)
    assert min(seen.values()) > 500, seen
