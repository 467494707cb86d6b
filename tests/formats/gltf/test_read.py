"""Reading glTF: accessors, nodes, people, takes."""

import zipfile
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from made_gltf import BODY, Made, body, plain_places, waving
from scipy.spatial.transform import Rotation

from lanindex import formats
from lanindex.errors import BodyError, CaptureError
from lanindex.formats import archives, gltf
from lanindex.formats.file import File, Wanted
from lanindex.formats.gltf import chosen
from lanindex.model import Motion, Reading


def read(data: bytes, subject: str = "", **told: str) -> Motion:
    return formats.read_file(File("a.glb", data, subject), Reading(**told), Wanted())


def waved(**told: str) -> Motion:
    made = Made()
    waving(made, body(made))
    return read(made.glb(), **told)


def test_a_body_that_waves():
    motion = waved()
    assert (len(motion), motion.rate, motion.warnings) == (10, 30, ())
    assert (motion.source.format, motion.source.unit, motion.source.up) == ("gltf", "m", "y")
    assert sorted(motion.skeleton.names) == sorted(BODY)
    assert motion.skeleton.played()["RWrist"] == "RightHand"
    at = dict(zip(motion.skeleton.names, motion.positions[-1], strict=True))
    np.testing.assert_allclose(at["Hips"], [0, 950, 180], atol=1e-3)
    np.testing.assert_allclose(at["RightHand"] - at["RightArm"], [0, 530, 0], atol=1e-3)


def test_turns_take_rest_to_the_world():
    motion = waved()
    offsets, parents = motion.skeleton.offsets, motion.skeleton.parents
    w, *axes = np.moveaxis(motion.rotations, -1, 0)
    turns = Rotation.from_quat(np.stack([*axes, w], axis=-1).reshape(-1, 4))
    turns = turns.as_matrix().reshape(len(motion), -1, 3, 3)
    for joint, parent in enumerate(parents):
        if parent >= 0:
            bone = motion.positions[:, joint] - motion.positions[:, parent]
            np.testing.assert_allclose(turns[:, parent] @ offsets[joint], bone, atol=1e-2)


def test_a_rate_that_is_told():
    assert waved(rate="60").rate == 60
    assert len(waved(rate="60")) == 10


def test_text_bytes_and_a_file_beside_are_the_same(tmp_path: Path):
    made = Made()
    waving(made, body(made))
    wanted = read(made.glb()).positions
    np.testing.assert_array_equal(read(made.gltf()).positions, wanted)
    (tmp_path / "in it").mkdir()
    (tmp_path / "in it" / "a.bin").write_bytes(made.bytes)
    (tmp_path / "a.gltf").write_bytes(made.gltf("in%20it/a.bin"))
    np.testing.assert_array_equal(formats.read(tmp_path / "a.gltf").positions, wanted)
    with zipfile.ZipFile(tmp_path / "all.zip", "w") as archive:
        archive.write(tmp_path / "a.gltf", "x/a.gltf")
        archive.write(tmp_path / "in it" / "a.bin", "x/in it/a.bin")
    inside = formats.read(f"{tmp_path / 'all.zip'}{archives.MARK}x/a.gltf")
    np.testing.assert_array_equal(inside.positions, wanted)


@pytest.mark.parametrize(
    "uri",
    ["../a.bin", "/etc/passwd", "file:///etc/passwd", "http://a/b", "", "a/../../b", "%2e%2e/b"],
)
def test_only_files_beside_it_are_read(uri, tmp_path):
    made = Made()
    waving(made, body(made))
    (tmp_path / "a.gltf").write_bytes(made.gltf(uri))
    with pytest.raises(CaptureError, match=r"buffers\[0\].uri is .* wanted the name of a file"):
        formats.read(tmp_path / "a.gltf")


def test_whatever_moves_it():
    """Shifts, turns and scales, of all kinds, under nodes that are turned and mirrored."""
    numbers = np.random.default_rng(7)
    made = Made()
    top = made.node("z up", matrix=[1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0.1, 0.2, 0.3, 1])
    under = made.node("mirror", top, scale=[-1.0, 1, 1], rotation=[0, 0, 0.6, 0.8])
    nodes = body(made, under=under)
    take = made.animation()
    seconds = np.arange(12) / 25
    every, some = made.accessor(seconds), made.accessor(seconds[[0, 3, 4, 9, 11]])
    tracks = {}
    kinds = ("LINEAR", "STEP", "CUBICSPLINE")
    for place, node in enumerate((under, *nodes.values())):
        for path, width in (("translation", 3), ("rotation", 4), ("scale", 3)):
            if numbers.random() < 0.3:
                continue
            kind = kinds[(place + width) % 3] if place else "LINEAR"
            dense = numbers.random() < 0.5
            keys = seconds if dense else seconds[[0, 3, 4, 9, 11]]
            count = len(keys) * (3 if kind == "CUBICSPLINE" else 1)
            values = numbers.normal(0, 0.1, (count, width))
            base = {"translation": 0, "scale": 1.0, "rotation": np.array([0.0, 0, 0, 1])}[path]
            values += (
                base
                if kind != "CUBICSPLINE"
                else np.where(np.arange(count) % 3 == 1, 1, 0)[:, None] * base
            )
            if path == "translation" and node != under:
                values += made.json["nodes"][node]["translation"]
            if path == "rotation" and kind != "CUBICSPLINE":
                values /= np.linalg.norm(values, axis=1, keepdims=True)
            values = values.astype(np.float32).astype(float)
            tracks[node, path] = (kind, keys.astype(np.float32).astype(float), values)
            made.track(take, node, path, every if dense else some, made.accessor(values), kind)
    made.track(take, nodes["Head"], "weights", every, made.accessor(np.zeros(24)))
    file = File("a.glb", made.glb())
    found, _ = chosen(file, None)
    assert found.clock.count == 12
    points, _ = found.placed(np.arange(12))
    for frame in range(12):
        plain = plain_places(made.json["nodes"], tracks, float(np.float32(seconds[frame])))
        np.testing.assert_allclose(points[frame], plain[list(found.person.joints)], atol=2e-6)


def test_numbers_in_every_way():
    """Sparse, strided, and whole numbers that stand for fractions."""
    made = Made()
    nodes = body(made)
    waving(made, nodes)
    wanted = read(made.glb()).positions
    take = made.json["animations"][0]
    way, turn = (sampler["output"] for sampler in take["samplers"])
    rows = np.stack([np.zeros(10), np.full(10, 0.95), np.arange(10) / 50], axis=1)
    strided = np.full((10, 5), 7.0, "<f4")
    strided[:, 1:4] = rows
    view = made.view(strided.tobytes(), byteStride=20)
    made.json["accessors"][way] |= {"bufferView": view, "byteOffset": 4}
    np.testing.assert_array_equal(read(made.glb()).positions, wanted)
    turns = Rotation.from_euler("z", np.linspace(0, -90, 10)[:, None], degrees=True).as_quat()
    whole = np.rint(turns * 32767)
    turned = made.accessor(whole, "i2", normalized=True)
    take["samplers"][1]["output"] = turned
    np.testing.assert_allclose(read(made.glb()).positions, wanted, atol=0.1)
    for kind in ("u1", "u2", "u4"):
        places = np.arange(10, dtype=kind)
        sparse = {
            "count": 10,
            "indices": {
                "bufferView": made.view(places.tobytes()),
                "componentType": {"u1": 5121, "u2": 5123, "u4": 5125}[kind],
            },
            "values": {"bufferView": made.view(turns.astype("<f4").tobytes())},
        }
        zeros = made.accessor(np.zeros((10, 4)), sparse=sparse)
        take["samplers"][1]["output"] = zeros
        np.testing.assert_array_equal(read(made.glb()).positions, wanted)
        del made.json["accessors"][zeros]["bufferView"]
        np.testing.assert_array_equal(read(made.glb()).positions, wanted)
    assert turn != turned


def timed(seconds: np.ndarray, more: tuple[np.ndarray, ...] = ()) -> Motion:
    """Return a body whose arm has keys at some times, and whose other joints at others."""
    made = Made()
    nodes = body(made)
    take = made.animation()
    for joint, times in zip(("RightArm", "LeftArm", "Head"), (seconds, *more), strict=False):
        turns = Rotation.from_euler("z", np.sin(times * 3)[:, None]).as_quat()
        made.track(take, nodes[joint], "rotation", made.accessor(times), made.accessor(turns))
    return read(made.glb())


@pytest.mark.parametrize("rate", [24, 25, 30, 60, 120, Fraction(30000, 1001)])
@pytest.mark.parametrize("start", [0.0, 1 / 30, 100.0])
def test_rates_of_long_captures(rate, start):
    motion = timed(start + np.arange(36_000) / float(rate))
    assert (motion.rate, len(motion), motion.warnings) == (rate, 36_000, ())


def test_keys_that_were_left_out():
    seconds = np.arange(300) / 60
    keys = seconds[np.random.default_rng(1).random(300) < 0.6]
    motion = timed(keys, (seconds[[0, 299]], seconds[[0]]))
    assert (motion.rate, len(motion), motion.warnings) == (60, 300, ())


def test_rare_keys_are_looked_at_between():
    motion = timed(np.arange(5) / 2)
    assert (motion.rate, len(motion)) == (30, 61)
    assert motion.warnings == ("keys are 0.5 s apart: it is read at 30 frames a second",)


def test_uneven_keys():
    motion = timed(np.cumsum(np.random.default_rng(1).uniform(0.03, 0.037, 200)))
    assert 28 < motion.rate < 32
    assert motion.warnings[0].startswith("keys are at uneven times: it is read at")


def test_one_key_is_one_pose():
    motion = timed(np.array([0.5]))
    assert (len(motion), motion.rate) == (1, 30)


def test_keys_far_apart_take_no_memory():
    with pytest.raises(CaptureError, match="3 keys from 0 to 90000 s"):
        timed(np.array([0.0, 1e-3, 9e4]))


def test_two_people_and_whoever_is_no_person():
    made = Made()
    strip = made.node("strip")
    made.json["skins"] = [{"joints": [strip, made.node("end", strip, translation=[0, 1, 0])]}]
    top = made.node("stage")
    people = [body(made, skin=name, under=made.node(name, top)) for name in ("Ada", "Bob")]
    for nodes in people:
        waving(made, nodes)
    made.json["skins"].append({"name": "shirt", "joints": [people[0]["Chest"], people[0]["Neck"]]})
    times = made.accessor(np.arange(10) / 30)
    turns = made.accessor(np.tile([0, 0, 0, 1.0], (10, 1)))
    made.track(made.json["animations"][0], strip, "rotation", times, turns)
    data = made.glb()
    assert gltf.subjects(File("a.glb", data)) == ("Ada", "Bob")
    motion = read(data)
    assert "Ada is read; it holds also Bob" in motion.warnings
    bob = read(data, "Bob")
    assert not [doubt for doubt in bob.warnings if "holds also Ada" in doubt]
    assert len(bob.skeleton.names) == len(BODY)
    with pytest.raises(CaptureError, match="has nobody called 'Eve', wanted Ada or Bob"):
        read(data, "Eve")


def test_one_person_is_no_subject():
    made = Made()
    waving(made, body(made))
    assert gltf.subjects(File("a.glb", made.glb())) == ()


def test_takes():
    made = Made()
    nodes = body(made)
    waving(made, nodes, 10, "first")
    waving(made, nodes, 20)
    made.json["animations"][1].pop("name")
    data = made.glb()
    motion = read(data)
    assert len(motion) == 10
    assert motion.warnings == ("the take first is read; it holds also 2",)
    assert len(read(data, take="2")) == 20
    assert read(data, take="2").warnings == ()
    with pytest.raises(CaptureError, match="has no take 'third', wanted first, 2"):
        read(data, take="third")


def test_nodes_without_a_skin():
    made = Made()
    waving(made, body(made, skin=None, under=made.node("root")))
    assert len(read(made.glb())) == 10


def test_joints_that_a_skin_leaves_out():
    """Hips that no vertex follows, and tips below the last joints."""
    made = Made()
    nodes = body(made, under=made.node("Armature"))
    waving(made, nodes)
    made.node("HeadTop_End", nodes["Head"], translation=[0, 0.2, 0])
    made.node("sword", nodes["RightHand"], mesh=0)
    made.json["skins"][0]["joints"].remove(nodes["Hips"])
    names = read(made.glb()).skeleton.names
    assert set(names) == {*BODY, "HeadTop_End"}


def test_names_that_are_not_there_or_not_alone():
    made = Made()
    nodes = body(made)
    waving(made, nodes)
    made.json["nodes"][nodes["LeftToeBase"]].pop("name")
    made.json["nodes"][nodes["RightToeBase"]]["name"] = "Hips"
    number = nodes["LeftToeBase"], nodes["RightToeBase"]
    names = read(made.glb()).skeleton.names
    assert {f"node {number[0]}", f"Hips {number[1]}"} < set(names)


def test_nothing_that_moves():
    made = Made()
    nodes = body(made)
    with pytest.raises(CaptureError, match="has no animation, wanted an animation of a skeleton"):
        read(made.glb())
    made.animation()
    with pytest.raises(CaptureError, match="no animation moves a skeleton"):
        read(made.glb())
    assert nodes


def test_scales_in_scales_beyond_all_numbers():
    made = Made()
    nodes = body(made)
    waving(made, nodes)
    for name in ("Hips", "RightArm"):
        made.json["nodes"][nodes[name]]["scale"] = [1e20, 1e20, 1e20]
    with pytest.raises(CaptureError, match=r"is at .* in frame 0, wanted places up to 1e\+30"):
        read(made.glb())


def test_the_body_alone_is_where_it_is_among_all_joints():
    made = Made()
    nodes = body(made)
    for number in range(5):
        nodes[f"finger{number}"] = made.node(f"finger{number}", nodes["RightHand"])
    waving(made, nodes)
    whole, alone = (
        formats.read_file(File("a.glb", made.glb()), Reading(), Wanted(only)) for only in (0, 1)
    )
    kept = [whole.skeleton.names.index(name) for name in alone.skeleton.names]
    assert len(kept) < len(whole.skeleton.names)
    np.testing.assert_array_equal(alone.positions, whole.positions[:, kept])
    np.testing.assert_array_equal(alone.rotations, whole.rotations[:, kept])


def test_no_human(captures: Path):
    with pytest.raises(BodyError, match="no human skeleton: among 2 joints"):
        formats.read(captures / "gltf" / "SimpleSkin.gltf")


def test_a_walk(captures: Path):
    """Sides are as they are named, for the last joints of its feet point down and backward."""
    motion = formats.read(captures / "gltf" / "CesiumMan.glb")
    played = motion.skeleton.played()
    assert (len(motion), motion.rate) == (48, 24)
    assert (played["RAnkle"], played["LElbow"]) == ("leg_joint_R_3", "Skeleton_arm_joint_L__3_")
    knees = motion.positions[:, motion.skeleton.names.index("leg_joint_L_2")]
    hips = motion.positions[:, motion.skeleton.names.index("leg_joint_L_1")]
    assert (knees - hips)[:, 2].mean() > 0
    assert motion.positions[:, :, 1].max() > 1100
