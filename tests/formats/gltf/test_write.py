"""Motions written as GLB read back equal, here and in other programs."""

import json
import struct
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from effort import examples
from hypothesis import given
from hypothesis import strategies as st
from made_gltf import plain_places, with_unknown
from random_scores import scores

from lanindex import formats
from lanindex.formats import gltf
from lanindex.formats.gltf import octahedra
from lanindex.model import Motion, Score, Skeleton, Source
from lanindex.perform import perform

COMPASS = Path(__file__).parents[3] / "corpus" / "compass.bvh"


def told(data: bytes) -> dict:
    """Return the JSON of a GLB."""
    length = struct.unpack("<I", data[12:16])[0]
    return json.loads(data[20 : 20 + length])


def again(motion: Motion) -> Motion:
    return formats.read("a.glb", data=gltf.write(motion))


def largest_error(one: Motion, other: Motion) -> float:
    order = [other.skeleton.names.index(name) for name in one.skeleton.names]
    assert len(order) == len(other.skeleton.names)
    return float(np.abs(one.positions - other.positions[:, order]).max())


@given(scores(), st.sampled_from([0.0, 2.0]))
@examples(15)
def test_it_reads_back(score: Score, noise: float) -> None:
    motion = perform(score, rate=12 * score.rate / score.frames, noise=noise)
    data = gltf.write(motion)
    tracks, nodes = plain_tracks(data)
    for frame in {0, len(motion) // 2, len(motion) - 1}:
        second = float(np.float32(frame / motion.rate))
        places = plain_places(nodes, tracks, second)[: len(motion.skeleton.names)]
        np.testing.assert_allclose(places * 1000, motion.positions[frame], atol=0.05)


def plain_tracks(data: bytes) -> tuple[dict, list]:
    """Return the tracks of a GLB that LanIndex wrote, read by hand, and its nodes."""
    parts = told(data)
    start = 28 + struct.unpack("<I", data[12:16])[0]

    def numbers(index: int) -> np.ndarray:
        accessor = parts["accessors"][index]
        view = parts["bufferViews"][accessor["bufferView"]]
        first = start + view["byteOffset"]
        return np.frombuffer(data[first : first + view["byteLength"]], "<f4").reshape(
            accessor["count"], -1
        )

    animation = parts["animations"][0]
    tracks = {}
    for channel in animation["channels"]:
        sampler = animation["samplers"][channel["sampler"]]
        target = channel["target"]["node"], channel["target"]["path"]
        tracks[target] = "LINEAR", numbers(sampler["input"])[:, 0], numbers(sampler["output"])
    return tracks, parts["nodes"]


@pytest.mark.parametrize("body_only", [False, True])
@pytest.mark.parametrize(
    "name",
    [
        "bvh/xsens/aitviewer_sample.bvh",
        "bvh/bandai2/walk/dataset-2_walk_active_005.bvh",
        "bvh/mixamo/test_freebvh.bvh",
        "bvh/pybvh/standard_skeleton.bvh",
        "gltf/CesiumMan.glb",
    ],
)
def test_real_files_read_back(captures: Path, name: str, body_only: bool) -> None:
    motion = formats.read(captures / name, body_only=body_only)
    back = again(motion)
    assert (back.rate, len(back)) == (motion.rate, len(motion))
    assert largest_error(motion, back) < 0.01


def test_turns_are_kept(captures: Path) -> None:
    """A twist of a hand is not seen in places."""
    motion = formats.read(captures / "gltf" / "CesiumMan.glb")
    back = again(motion)
    assert motion.rotations is not None
    assert back.rotations is not None
    order = [back.skeleton.names.index(name) for name in motion.skeleton.names]
    alike = np.abs((motion.rotations * back.rotations[:, order]).sum(axis=2))
    assert alike.min() > 1 - 1e-5
    np.testing.assert_allclose(back.skeleton.offsets[order], motion.skeleton.offsets, atol=0.01)


def loose(points: np.ndarray, parents: list[int], rate: Fraction = Fraction(30)) -> Motion:
    names = ("Hips", *(f"J{number}" for number in range(1, len(parents))))
    offsets = np.zeros((len(parents), 3))
    skeleton = Skeleton(names, np.array(parents, np.int16), offsets, np.full(20, -1, np.int16))
    return Motion(skeleton, rate, points.astype(np.float32), Source("a", "a", "mm", 1.0, "y"))


def test_points_without_a_rest_pose_stand_as_in_the_first_frame() -> None:
    points = np.random.default_rng(3).normal(0, 300, (5, 4, 3))
    data = gltf.write(loose(points, [-1, 0, 1, 1]))
    _, nodes = plain_tracks(data)
    np.testing.assert_allclose(plain_places(nodes, {}, 0)[:4] * 1000, points[0], atol=0.01)


def test_places_that_a_file_says_are_unknown_are_read_so() -> None:
    motion = formats.read(COMPASS)
    names = motion.skeleton.names
    wrist, hips = names.index("LeftHand"), names.index("Hips")
    places = motion.positions.copy()
    places[10:20, wrist] = np.nan
    places[:5, wrist] = np.nan
    places[-3:, hips] = np.nan
    gaps = {"LeftHand": [[0, 5], [10, 20]], "Hips": [[837, 840]]}
    back = formats.read("a.glb", data=with_unknown(gltf.write(motion), gaps))
    order = [back.skeleton.names.index(name) for name in names]
    np.testing.assert_allclose(back.positions[:, order], places, atol=0.01)


def test_what_was_unknown_is_not_believed_of_other_frames() -> None:
    motion = formats.read(COMPASS)
    data = with_unknown(gltf.write(motion), {motion.skeleton.names[5]: [[10, 20]]})
    assert not np.isfinite(formats.read("a.glb", data=data).positions).all()
    data = data.replace(b'"frames":840', b'"frames":841')
    assert np.isfinite(formats.read("a.glb", data=data).positions).all()


@pytest.mark.parametrize("rate", [Fraction(24), Fraction(30000, 1001), Fraction(120)])
def test_a_single_pose_keeps_its_rate(rate: Fraction) -> None:
    motion = formats.read(COMPASS)
    pose = replace(motion, positions=motion.positions[:1], axes={}, rate=rate)
    assert again(pose).rate == rate
    assert len(again(pose)) == 1


def test_bones_are_seen_from_outside() -> None:
    """Each face of a bone turns outward."""
    places = np.array([[0.0, 0, 0], [0, 1, 0], [0.5, 1, 0], [0.5, 1, 0]])
    corners, joints, faces = octahedra(places, [-1, 0, 1, 2])
    assert joints[::6].tolist() == [0, 1, 2, 3]
    for number in range(0, len(faces), 8):
        middle = corners[faces[number : number + 8]].mean(axis=(0, 1))
        for face in corners[faces[number : number + 8]]:
            normal = np.cross(face[1] - face[0], face[2] - face[0])
            assert normal @ (face.mean(axis=0) - middle) > 0
