"""Arrays of joints and of rotations: reading, refusals, clips, writing."""

import io
import os
import zipfile
from pathlib import Path

import numpy as np
import pytest
from made_points import NAMES, person
from mutations import fuzzed
from scipy.spatial.transform import Rotation

from lanindex import formats
from lanindex.errors import CaptureError
from lanindex.formats import smpl
from lanindex.formats.npy import write
from lanindex.formats.smpl import ORDERS, SMPL
from lanindex.formats.turning import rotated
from lanindex.model import Motion, Span


def npy(array: np.ndarray, **told) -> bytes:
    file = io.BytesIO()
    np.lib.format.write_array(file, array, **told)
    return file.getvalue()


def npz(pack: bool = False, **arrays) -> bytes:
    file = io.BytesIO()
    (np.savez_compressed if pack else np.savez)(file, **arrays)
    return file.getvalue()


def read(data: bytes, **told) -> Motion:
    return formats.read("walk.npz", data=data, **told)


def at(motion: Motion, names=NAMES) -> np.ndarray:
    return motion.positions[:, [motion.skeleton.names.index(name) for name in names]]


def ordered(names: tuple[str, ...], frames: int = 20) -> np.ndarray:
    """Return a person in metres, joints as one order has them; others far from any limb."""
    where = dict(zip(NAMES, person(frames).swapaxes(0, 1), strict=True))
    other = where["neck"] * [1, 0.9, 1]
    return np.stack([where.get(name, other) for name in names], axis=1) / 1000


PERSON = person() / 1000
KINDS = {
    "float32": PERSON.astype("f4"),
    "float64": PERSON,
    "half": PERSON.astype("f2"),
    "big-endian": PERSON.astype(">f8"),
    "Fortran order": np.asfortranarray(PERSON),
    "whole millimetres": person().astype("i2"),
    "one of one person": PERSON[None],
}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("pack", [False, True])
def test_a_person_in_every_kind(kind, pack):
    motion = read(npz(pack, joints=KINDS[kind], joint_names=np.array(NAMES), fps=25))
    np.testing.assert_allclose(at(motion), person(), atol=1)
    assert (motion.rate, motion.source.format, motion.warnings) == (25, "npz", ())


KEYS = [
    ("joints", "joint_names", "fps"),
    ("positions", "names", "rate"),
    ("keypoints", "joint_names", "mocap_framerate"),
    ("xyz", "names", "framerate"),
    ("joints3d", "labels", "mocap_frame_rate"),
]


@pytest.mark.parametrize("keys", KEYS)
def test_keys(keys):
    arrays = dict(zip(keys, (PERSON, np.array(NAMES, "S"), np.array([30.00012])), strict=True))
    assert read(npz(other=np.zeros(9), **arrays)).rate == 30


def test_a_key_that_nobody_knows_is_told():
    motion = read(npz(movement=PERSON, joint_names=np.array(NAMES), fps=25))
    assert motion.warnings == ("its array 'movement' is taken for places of joints",)


def test_unit_and_axis_are_told_by_the_file():
    flat = person()[..., [2, 0, 1]]
    motion = read(npz(joints=flat, names=np.array(NAMES), fps=25, unit="mm", up="z"))
    assert (motion.source.unit, motion.source.up, motion.warnings) == ("mm", "z", ())


@pytest.mark.parametrize("order", ORDERS, ids=lambda order: order.title)
def test_orders_are_known_by_number_and_bones(order):
    motion = read(npy(ordered(order.names)), rate=30)
    assert motion.skeleton.played()["RWrist"] == "right_wrist"
    np.testing.assert_allclose(
        at(motion, ("left_knee", "right_wrist")),
        person()[:, [NAMES.index("left_knee"), NAMES.index("right_wrist")]],
        atol=0.01,
    )
    assert motion.source.format == "npy"


def test_a_rate_that_is_assumed_is_told():
    motion = read(npy(ordered(SMPL[:22])))
    assert motion.rate == 20
    assert motion.warnings == (
        "no rate in it: 20 frames a second assumed, as HumanML3D has it. "
        "If that is wrong, give --fps",
    )
    assert read(npy(ordered(SMPL[:22])), rate=30).warnings == ()
    with pytest.raises(CaptureError, match="Give the rate with --fps"):
        read(npy(ordered(SMPL)))


def test_an_order_that_is_none_is_refused():
    shuffled = ordered(SMPL[:22])[:, ::-1]
    with pytest.raises(CaptureError, match="22 joints without names, in no order that is known"):
        read(npy(shuffled))


def poses(width: int = 156, frames: int = 9) -> dict[str, np.ndarray]:
    """Return AMASS at rest, z up."""
    turns = np.zeros((frames, width))
    turns[:, 0] = np.pi / 2
    return {"poses": turns, "trans": np.zeros((frames, 3)), "mocap_framerate": np.array(120.0)}


@pytest.mark.parametrize("width", sorted(smpl.WIDTHS))
def test_amass_at_rest(width):
    motion = read(npz(**poses(width), betas=np.zeros(16), gender="female"))
    assert (motion.rate, motion.source.unit, motion.source.up) == (120, "m", "z")
    assert motion.warnings == ()
    wrists = at(motion, ("left_wrist", "right_wrist"))[0]
    assert wrists[0, 0] - wrists[1, 0] == pytest.approx(1441, abs=1)  # arms to both sides
    assert wrists[0, 1] - at(motion, ("left_foot",))[0, 0, 1] == pytest.approx(1429, abs=1)
    half = np.sqrt(0.5)
    np.testing.assert_allclose(motion.rotations[0, 5], [half, half, 0, 0], atol=1e-6)


def test_amass_bends_an_elbow():
    arrays = poses()
    joint = SMPL.index("left_elbow")
    arrays["poses"][:, 3 * joint + 1] = -np.pi / 2  # about the body's vertical: forward
    motion = read(npz(**arrays))
    elbow, wrist = at(motion, ("left_elbow", "left_wrist"))[0]
    np.testing.assert_allclose(wrist - elbow, [7, 13, 266], atol=1.5)


def test_amass_agrees_with_matrices():
    pick = np.random.default_rng(3)
    vectors = pick.normal(0, 1, (5, 22, 3))
    shift = pick.normal(0, 1, (5, 3))
    places, turns = smpl.posed(vectors.reshape(5, 66), shift)
    for frame in range(5):
        world: list[np.ndarray] = []
        where: list[np.ndarray] = []
        for joint, parent in enumerate(smpl.PARENTS):
            local = matrix(vectors[frame, joint]) if joint < 22 else np.eye(3)
            if parent < 0:
                world, where = [local], [shift[frame] + smpl.REST]
                continue
            where.append(where[parent] + world[parent] @ smpl.OFFSETS[joint])
            world.append(world[parent] @ local)
        np.testing.assert_allclose(places[frame], where, atol=1e-5)
        made = [rotated(turns[frame, [k]].astype(float), np.eye(3)[0])[0] for k in range(24)]
        np.testing.assert_allclose(made, [turn[:, 0] for turn in world], atol=1e-5)


def matrix(vector: np.ndarray) -> np.ndarray:
    """Return a rotation by the series of its exponential."""
    x, y, z = vector
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    result, term = np.eye(3), np.eye(3)
    for k in range(1, 40):
        term = term @ cross / k
        result = result + term
    return result


class Trap:
    """Leaves a mark if it is ever unpickled."""

    def __reduce__(self):
        return os.mkdir, ("unpickled",)


def test_nothing_is_unpickled(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    trap = np.array([Trap()], object)
    for data in (npy(trap), npz(joints=trap), npz(results=trap, fps=np.array(5))):
        with pytest.raises(CaptureError, match=r"Python objects \(a pickle\)"):
            read(data)
    read(npz(joints=PERSON, names=np.array(NAMES), fps=25, more=trap))
    assert not Path("unpickled").exists()


def test_a_real_pickle_is_refused(captures):
    with pytest.raises(CaptureError, match="'results' holds Python objects"):
        formats.read(captures / "npz" / "romp_output.npz")


def header(text: str, version: int = 1) -> bytes:
    size = len(text).to_bytes(2 if version == 1 else 4, "little")
    return b"\x93NUMPY" + bytes([version, 0]) + size + text.encode()


def said(kind="'<f4'", shape="(20, 15, 3)", order="False") -> str:
    return f"{{'descr': {kind}, 'fortran_order': {order}, 'shape': {shape}}}"


BAD = {
    "a size that lies": (header(said(shape="(10**9, 22, 3)")), "the header"),
    "too large": (header(said(shape="(1000000000, 22, 3)")) + b"0" * 99, "of which 99 are there"),
    "beyond all": (header(said(shape=f"({1 << 60}, 3, 3)")), "the shape"),
    "negative": (header(said(shape="(-1, 22, 3)")), "the shape"),
    "a shape of words": (header(said(shape="('a',)")), "the shape"),
    "objects": (header(said("'|O'")), "a pickle"),
    "records": (header(said("[('x', '<f4')]")), "numbers of the kind"),
    "nested": (header(said("'(3,)<f4'")), "numbers of the kind"),
    "dates": (header(said("'<M8[s]'")), "numbers of the kind"),
    "a call": (header("__import__('os').mkdir('called')"), "the header"),
    "deep": (header("[" * 9000), "the header"),
    "version 9": (header(said(), 9), "begins with"),
    "cut": (npy(PERSON)[:-1], "of which"),
    "a header that ends nowhere": (header(said())[:20], "a header of"),
    "no frames": (npy(np.zeros((0, 22, 3))), "no frames"),
    "flat": (npy(np.zeros((20, 66))), r"an array \(20, 66\)"),
    "features of nothing": (npy(np.zeros((20, 263))), "features of HumanML3D in which bones keep"),
    "unknown features": (npy(np.full((20, 251), np.nan)), "array: frame 0 has nan"),
    "unknown places": (npy(np.full((20, 22, 3), np.nan)), "no place is known in any frame"),
    "people": (npz(joints=np.zeros((2, 9, 22, 3))), r"places of 2 people \(2, 9, 22, 3\)"),
    "pictures": (npy(np.zeros((20, 17, 2))), "points in a picture"),
    "several": (npz(a=PERSON, b=PERSON), "several arrays that may be places of joints: 'a', 'b'"),
    "nothing": (npz(name="Bob"), "no array of numbers"),
    "infinity": (npy(np.full((20, 22, 3), np.inf)), "frame 0 has inf"),
    "huge": (npy(np.full((20, 22, 3), 1e300)), r"frame 0 has 1e\+300"),
    "turns of nothing": (npz(**poses() | {"trans": np.full((9, 3), np.nan)}), "trans: frame 0"),
    "a rate of 0": (npz(joints=PERSON, names=np.array(NAMES), fps=0), "a rate of '0.0'"),
    "a cut ZIP": (npz(joints=PERSON)[:-30], "a damaged ZIP"),
}


@pytest.mark.parametrize("kind", BAD)
def test_errors(kind, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    data, found = BAD[kind]
    with pytest.raises(CaptureError, match=found) as caught:
        read(data)
    assert str(caught.value).startswith("walk.npz")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("version", [(1, 0), (2, 0), (3, 0)])
def test_versions(version):
    assert len(read(npy(ordered(SMPL[:22]), version=version))) == 20


def test_a_bomb_is_not_unpacked():
    data = npz(True, joints=np.zeros((1 << 17, 22, 3)), fps=25)
    assert len(data) < 1 << 17
    with pytest.raises(CaptureError, match="unpacks to 69206144 bytes"):
        read(data)


def test_a_member_that_is_damaged():
    data = bytearray(npz(True, joints=ordered(SMPL[:22]), fps=25))
    data[200:260] = bytes(60)
    with pytest.raises(CaptureError, match=r"cannot be unpacked|a damaged|the header"):
        read(bytes(data))
    data = bytearray(npz(joints=ordered(SMPL[:22]), fps=25))
    data[1000] ^= 1
    with pytest.raises(CaptureError, match=r"cannot be unpacked \(Bad CRC"):
        read(bytes(data))


class Asked:
    """A file's content that counts the bytes which are asked of it."""

    def __init__(self, content: bytes) -> None:
        self.content, self.count = content, 0

    def __len__(self) -> int:
        return len(self.content)

    def __getitem__(self, piece: slice) -> bytes:
        data = self.content[piece]
        self.count += len(data)
        return data


def test_a_clip_asks_for_its_own_frames():
    places = person(20_000) / 1000
    for source in (npz(joints=places, names=np.array(NAMES), fps=25), npz(joints=places[None])):
        content = Asked(source)
        clip = formats.cutter(formats.File("walk.npz", content))(Span(9_000, 9_100))
        cut = np.load(io.BytesIO(clip))["joints"]
        np.testing.assert_array_equal(cut.reshape(100, -1, 3), places[9_000:9_100])
        assert len(clip) < content.count < len(source) / 20


def test_clips_keep_kind_order_and_packing():
    for kind, array in KINDS.items():
        for pack in (False, True):
            names = np.array(NAMES)
            source = npz(
                pack, joints=array, names=names, fps=25, other=np.arange(40).reshape(20, 2)
            )
            data = formats.cutter(formats.File("walk.npz", source))(Span(4, 9))
            clip = np.load(io.BytesIO(data))
            cut = array[:, 4:9] if array.ndim == 4 else array[4:9]
            np.testing.assert_array_equal(clip["joints"], cut)
            assert clip["joints"].dtype == array.dtype
            assert clip["joints"].flags.f_contiguous == cut.flags.f_contiguous or kind != "Fortran"
            assert clip["names"].tolist() == list(NAMES)
            assert clip["other"].tolist() == np.arange(40).reshape(20, 2)[4:9].tolist()
            packed = zipfile.ZipFile(io.BytesIO(data)).infolist()
            assert {info.compress_type for info in packed} == {8 if pack else 0}
            np.testing.assert_array_equal(read(data).positions, read(source).positions[4:9])


@pytest.mark.parametrize("key", ["poses", "pose_body"])
def test_amass_in_parts(key):
    whole = poses() | {"poses": np.random.default_rng(1).normal(0, 0.3, (9, 165))}
    parts = {"root_orient": whole["poses"][:, :3], "pose_body": whole["poses"][:, 3:66]}
    given = whole | parts
    given.pop("pose_body" if key == "poses" else "poses")
    np.testing.assert_array_equal(read(npz(**given)).positions, read(npz(**whole)).positions)
    clip = formats.cutter(formats.File("walk.npz", npz(**given)))(Span(4, 9))
    np.testing.assert_array_equal(read(clip).positions, read(npz(**whole)).positions[4:])


def features(places: np.ndarray) -> np.ndarray:
    """Return what HumanML3D makes of joints: the same, as they face, and how the root moves."""
    names = list(SMPL if places.shape[1] == 22 else next(
        order.names for order in ORDERS if order.title == "KIT-ML"
    ))  # fmt: skip
    right, left = ([names.index(f"{side}_{it}") for it in ("hip", "shoulder")]
                   for side in ("right", "left"))  # fmt: skip
    across = (places[:, right] - places[:, left]).sum(axis=1)
    ahead = np.cross([0, 1, 0], across)
    facing = Rotation.from_rotvec(np.outer(-np.arctan2(ahead[:, 0], ahead[:, 2]), [0, 1, 0]))
    local = places.copy()
    local[..., [0, 2]] -= places[:, :1, [0, 2]]
    local = np.stack([turn.apply(pose) for turn, pose in zip(facing, local, strict=True)])
    faster = (facing[1:] * facing[:-1].inv()).as_quat(canonical=True)[:, 1]
    moved = facing[1:].apply(np.diff(places[:, 0], axis=0))
    rest = np.zeros((len(places) - 1, 9 * places.shape[1] - 6 + 4))
    columns = (np.arcsin(faster)[:, None], moved[:, [0, 2]], places[:-1, 0, 1:2])
    return np.hstack((*columns, local[:-1, 1:].reshape(len(rest), -1), rest))


@pytest.mark.parametrize("order", ["HumanML3D", "KIT-ML"])
def test_features_give_the_joints_that_they_are_of(order):
    names = next(it.names for it in ORDERS if it.title == order)
    places = ordered(names, 40)
    places -= places[:1, :1] * [1, 0, 1]
    turns = Rotation.from_rotvec(np.outer(np.linspace(0, 4, 40) ** 2 / 3, [0, 1, 0]))
    walked = places + np.linspace(0, [[2, 0.3, 1]], 40)
    walked = np.stack([turn.apply(pose) for turn, pose in zip(turns, walked, strict=True)])
    array = features(walked)
    assert array.shape == (39, 263 if order == "HumanML3D" else 251)
    motion = read(npy(array.astype("f4")))
    assert (float(motion.rate), motion.source.up) == (20 if order == "HumanML3D" else 12.5, "y")
    found = np.stack([motion.positions[:, motion.skeleton.names.index(it)] for it in names], axis=1)
    np.testing.assert_allclose(found, walked[:-1] * 1000, atol=0.05)
    clip = formats.cutter(formats.File("walk.npy", npy(array)))(Span(10, 30))
    np.testing.assert_array_equal(np.load(io.BytesIO(clip)), array[10:30])
    with pytest.raises(CaptureError, match=r"multiply them by Std\.npy and add Mean\.npy"):
        read(npy((array - array.mean(axis=0)) / (array.std(axis=0) + 1e-3)))


def test_clips_of_amass_are_amass():
    source = npz(**poses(frames=16), betas=np.arange(16.0), dmpls=np.zeros((16, 8)))
    clip = np.load(io.BytesIO(formats.cutter(formats.File("walk.npz", source))(Span(4, 9))))
    assert clip["poses"].shape == (5, 156)
    assert clip["trans"].shape == (5, 3)
    assert clip["dmpls"].shape == (5, 8)
    assert clip["betas"].shape == (16,)


def test_real_files(captures):
    for path in sorted((captures / "npz").glob("derived*")):
        whole = formats.read(path)
        clip = formats.cutter(formats.opened(path))(Span(10, 50))
        again = formats.read(path, data=clip)
        np.testing.assert_array_equal(again.positions, whole.positions[10:50])
        assert again.rate == whole.rate
        written = read(write(whole))
        assert written.skeleton.names == whole.skeleton.names
        assert (written.rate, written.source.unit, written.source.up) == (whole.rate, "m", "y")
        np.testing.assert_allclose(written.positions, whole.positions, atol=1e-3)


def test_what_is_unknown_stays_so():
    gone = PERSON.copy()
    gone[3, 7, 1] = np.nan
    motion = read(npz(joints=gone, names=np.array(NAMES), fps=25))
    assert np.isnan(at(motion)[3, 7]).all()
    again = read(write(motion))
    assert np.isnan(at(again)[3, 7]).all()
    assert np.isnan(again.positions).sum() == 3


def test_a_file_that_is_not_in_memory(tmp_path, monkeypatch):
    monkeypatch.setattr("lanindex.formats.file.WHOLE", 10)
    for data in (npz(True, joints=PERSON, names=np.array(NAMES), fps=25), npy(ordered(SMPL[:22]))):
        path = tmp_path / "walk.npz"
        path.write_bytes(data)
        np.testing.assert_array_equal(formats.read(path).positions, read(data).positions)


SOURCES = [
    npy(ordered(SMPL[:22], 4)),
    npz(joints=PERSON[:4], names=np.array(NAMES), fps=25),
    npz(True, joints=PERSON[:4].astype("f4"), names=np.array(NAMES), fps=25),
    npz(**poses(frames=3)),
    npy(features(ordered(SMPL[:22], 5))),
]


def test_fuzzing():
    seen = fuzzed("walk.npz", SOURCES, 500, 1)
    assert min(seen.values()) > 20, seen


@pytest.mark.slow
@pytest.mark.timeout(3600)
def test_long_fuzzing(captures):
    real = [path.read_bytes() for path in sorted((captures / "npz").glob("*walk*"))]
    seen = fuzzed("walk.npz", [*SOURCES, *real], 5_000, 2)
    assert min(seen.values()) > 200, seen


def test_numbers_that_signal_are_unknown():
    walk = ordered(SMPL[:22], 5).astype(np.float64)
    walk.view(np.uint64)[2, 3, 1] = 0x7FF0000000000001  # a NaN that complains where it is used
    motion = formats.read("walk.npy", data=npy(walk))
    assert np.isnan(motion.positions).any()
