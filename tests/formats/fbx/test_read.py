"""What an FBX file means, as ``ufbx`` reads it in a process of its own."""

import importlib.util
import random
import subprocess
from dataclasses import dataclass

import numpy as np
import pytest
from made_fbx import binary, fbx, waving
from made_gltf import BODY

from lanindex import formats
from lanindex.errors import BodyError, CaptureError, LanindexError
from lanindex.formats import fbx as reader
from lanindex.formats.file import File, Wanted
from lanindex.model import Motion, Reading

needs_ufbx = pytest.mark.skipif(
    importlib.util.find_spec("ufbx") is None, reason="ufbx is not installed (extra fbx)"
)
GOOD = fbx({"wave": waving()})


def read(data: bytes, subject: str = "", **told: str) -> Motion:
    return formats.read_file(File("a.fbx", data, subject), Reading(**told), Wanted())


@needs_ufbx
def test_a_body_that_waves() -> None:
    motion = read(GOOD)
    assert (len(motion), motion.rate, motion.warnings) == (10, 30, ())
    assert (motion.source.unit, motion.source.up) == ("cm", "y")
    assert set(motion.skeleton.names) == set(BODY)
    at = dict(zip(motion.skeleton.names, motion.positions[-1], strict=True))
    np.testing.assert_allclose(at["Hips"], [0, 950, 180], atol=1e-2)
    np.testing.assert_allclose(at["RightHand"] - at["RightArm"], [0, 530, 0], atol=1e-2)
    rest = dict(zip(motion.skeleton.names, motion.skeleton.offsets, strict=True))
    np.testing.assert_allclose(rest["RightForeArm"], [-280, 0, 0], atol=1e-2)
    assert motion.rotations is not None
    np.testing.assert_allclose(motion.rotations[0, :, 0], 1, atol=1e-6)


@needs_ufbx
def test_both_encodings_are_the_same() -> None:
    text, other = read(GOOD), read(binary(GOOD))
    assert other.skeleton.names == text.skeleton.names
    np.testing.assert_array_equal(other.positions, text.positions)


@needs_ufbx
def test_nodes_that_are_no_bones() -> None:
    assert len(read(fbx({"wave": waving()}, bone="Null"))) == 10


@needs_ufbx
def test_unit_and_axis_are_the_file_s() -> None:
    assert read(fbx({"wave": waving()}, unit=2.54), unit="cm").source.unit == "cm"
    inches = read(fbx({"wave": waving()}, unit=2.54))
    assert inches.source.unit == "inch"
    odd = read(fbx({"wave": waving()}, unit=1.5))
    assert odd.source.unit == "m"
    hips = odd.positions[-1, odd.skeleton.names.index("Hips")]
    np.testing.assert_allclose(hips, [0, 950, 180], atol=1e-2)
    assert read(fbx({"wave": waving()}, up=2)).source.up == "z"
    with pytest.raises(CaptureError, match="has left-handed axes"):
        read(fbx({"wave": waving()}, left_handed=True))


@needs_ufbx
def test_two_people_and_two_takes() -> None:
    both = waving("Ada:") | waving("Bob:")
    data = fbx({"still": {}, "wave": both, "again": waving("Ada:", 20)}, ("Ada:", "Bob:"))
    assert reader.subjects(File("a.fbx", data)) == ("Ada", "Bob")
    motion = read(data)
    assert motion.warnings == (
        "Ada is read; it holds also Bob",
        "the take wave is read; it holds also still, again",
    )
    assert read(data, "Bob", take="wave").warnings == ()
    assert len(read(data, take="again")) == 20
    with pytest.raises(CaptureError, match="has no take 'x', wanted still, wave, again"):
        read(data, take="x")
    with pytest.raises(CaptureError, match="has nobody called 'Eve', wanted Ada or Bob"):
        read(data, "Eve")


@needs_ufbx
def test_nothing_human_and_nothing_that_moves() -> None:
    with pytest.raises(CaptureError, match="no take moves anything"):
        read(fbx({"still": {}}))
    with pytest.raises(CaptureError, match="has no animation"):
        read(fbx({}))
    keys = {("Hips", "Lcl Rotation|d|Y"): [0.0, 9.0]}
    few = fbx({"spin": keys}, joints=("Hips", "Chest", "Neck", "Head"))
    with pytest.raises(BodyError, match="no human skeleton"):
        read(few)


@needs_ufbx
def test_a_take_that_does_not_say_its_time() -> None:
    assert len(read(fbx({"wave": waving()}, timed=False))) == 10


@needs_ufbx
def test_a_time_that_lies() -> None:
    last = b'"LocalStop", "KTime", "Time", "",'
    data = GOOD.replace(last, last + b"9999999")
    with pytest.raises(CaptureError, match="has more frames than such a file can hold"):
        read(data)


def test_without_ufbx(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reader, "find_spec", lambda name: None)
    with pytest.raises(CaptureError, match=r"Install it: pip install 'lanindex\[fbx\]'"):
        read(GOOD)


@dataclass
class Done:
    returncode: int
    stdout: bytes = b""


@pytest.mark.parametrize(
    ("done", "found"),
    [
        (Done(-11), r"ended ufbx \(-11\)"),
        (Done(0, b'{"error": "TruncatedFileError: x"}\n'), "ufbx says TruncatedFileError"),
    ],
)
def test_a_library_that_crashes(monkeypatch: pytest.MonkeyPatch, done: Done, found: str) -> None:
    monkeypatch.setattr(reader, "find_spec", lambda name: object())
    monkeypatch.setattr(subprocess, "run", lambda *args, **rest: done)
    with pytest.raises(CaptureError, match=found):
        read(GOOD)


def mutated(data: bytes, numbers: random.Random) -> bytes:
    mutable = bytearray(data)
    for _ in range(numbers.choice((1, 1, 2, 5, 20))):
        place = numbers.randrange(len(mutable) + 1)
        length = min(numbers.choice((0, 1, 3, 30, 500)), len(mutable) - place)
        piece = (b"", mutable[place : place + length] * 2, numbers.randbytes(length), b"9" * 9)
        mutable[place : place + length] = numbers.choice(piece)
    return bytes(mutable)


def outcome(data: bytes) -> str:
    try:
        found = read(data)
    except LanindexError as refused:
        error = str(refused)
    else:
        assert isinstance(found, Motion)
        return "motion"
    assert error.startswith("a.fbx"), error
    return "crash" if "ended ufbx" in error else "error"


@needs_ufbx
def test_mutations_give_a_motion_or_an_error() -> None:
    numbers = random.Random(20260103)
    seen = [outcome(mutated(GOOD, numbers)) for _ in range(40)]
    assert {"motion", "error"} <= set(seen)


@needs_ufbx
@pytest.mark.slow
@pytest.mark.timeout(7200)
def test_long_fuzzing() -> None:
    """200, for each is a process; `--slow` runs it."""
    numbers = random.Random(20260104)
    seen = [outcome(mutated(GOOD, numbers)) for _ in range(200)]
    assert min(seen.count("motion"), seen.count("error")) > 10, seen
