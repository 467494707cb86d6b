"""Clips keep the animation's frames and everything else of the file."""

import json
import struct
from pathlib import Path

import numpy as np
import pytest
from made_gltf import Made, body, waving, with_unknown
from scipy.spatial.transform import Rotation

from lanindex import formats
from lanindex.formats.file import File
from lanindex.model import Reading, Span

COMPASS = Path(__file__).parents[3] / "corpus" / "compass.bvh"


def read(data: bytes):
    return formats.read("a.glb", data=data)


def same(data: bytes, span: Span, exactly: bool = True) -> bytes:
    """Return a clip that gives the frames of the whole."""
    whole, clip = read(data), formats.cutter(File("a.glb", data))(span)
    back = read(clip)
    assert (len(back), back.rate) == (len(span), whole.rate)
    assert back.skeleton.names == whole.skeleton.names
    frames = slice(span.start, span.stop)
    if exactly:
        np.testing.assert_array_equal(back.positions, whole.positions[frames])
        np.testing.assert_array_equal(back.rotations, whole.rotations[frames])
    np.testing.assert_allclose(back.positions, whole.positions[frames], atol=2e-3)
    return clip


@pytest.mark.parametrize("span", [Span(0, 48), Span(0, 1), Span(7, 31), Span(47, 48)])
def test_real_files_read_back_equal(captures: Path, span: Span) -> None:
    data = (captures / "gltf" / "CesiumMan.glb").read_bytes()
    clip = same(data, span)
    length = struct.unpack("<I", clip[12:16])[0]
    told = json.loads(clip[20 : 20 + length])
    picture = told["bufferViews"][told["images"][0]["bufferView"]]
    first = 28 + length + picture["byteOffset"]
    assert clip[first : first + 8] == b"\x89PNG\r\n\x1a\n"
    assert clip[first : first + picture["byteLength"]] in data
    assert len(clip) < len(data)


def test_what_lanindex_wrote_reads_back_equal() -> None:
    motion = formats.read(COMPASS)
    data = with_unknown(formats.gltf.write(motion), {motion.skeleton.names[7]: [[100, 110]]})
    same(data, Span(95, 300))
    same(data, Span(105, 106))
    assert len(same(data, Span(105, 115))) < 40_000


def test_all_ways_to_move_and_text() -> None:
    """Keys between frames, splines and steps, weights of a mesh, another take, another person."""
    made = Made()
    nodes = body(made)
    waving(made, body(made, skin="Bob"), name="second")
    made.json["animations"].clear()
    waving(made, nodes, 40, "first")
    take = made.json["animations"][0]
    times = made.accessor(np.array([0.0, 0.51, 0.7, 1.3]))
    for joint, kind in (("LeftArm", "LINEAR"), ("Head", "STEP"), ("RightLeg", "CUBICSPLINE")):
        count = 12 if kind == "CUBICSPLINE" else 4
        turns = Rotation.random(count, random_state=5).as_quat()
        made.track(take, nodes[joint], "rotation", times, made.accessor(turns), kind)
    weights = made.accessor(np.arange(8.0))
    made.track(take, nodes["Neck"], "weights", times, weights)
    waving(made, nodes, 10, "other")
    for data in (made.glb(), made.gltf()):
        clip = same(data, Span(3, 33), exactly=False)
        assert clip[:4] == data[:4]
        assert read(clip).warnings == ()
        other = formats.cutter(formats.File("x.gltf", data), Reading(take="other"))(Span(2, 8))
        assert len(read(other)) == 6
    assert [take["name"] for take in json.loads(other)["animations"]] == ["other"]
    told = json.loads(clip)
    assert [take["name"] for take in told["animations"]] == ["first"]
    mixed = told["animations"][0]["samplers"][-1]
    assert told["accessors"][mixed["output"]]["count"] == 60


def test_still_frames_keep_their_number() -> None:
    made = Made()
    nodes = body(made)
    turns = np.tile([0, 0, 0, 1.0], (20, 1))
    times = made.accessor(np.arange(20) / 30)
    made.track(made.animation(), nodes["Head"], "rotation", times, made.accessor(turns))
    same(made.glb(), Span(5, 15))
