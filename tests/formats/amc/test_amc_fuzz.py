"""Whatever the bytes: a motion or one of our errors, and a clip that reads back equal."""

import random
import re
from pathlib import Path

import numpy as np
import pytest
from mutations import mutated

from lanindex import formats
from lanindex.errors import CaptureError
from lanindex.formats.file import File
from lanindex.model import Reading, Span

ASF = b"""# made
:version 1.10
:units
 length 2.54
 angle deg
:root
 order TX TY TZ RX RY RZ
 axis XYZ
 position 0 0 0
 orientation 0 0 0
:bonedata
"""
WORDS = b"root rfemur begin end dof rx l :bonedata :hierarchy :DEGREES # 3 name axis XYZ".split()
BONES = """lfemur root 9 -40 0|ltibia lfemur 0 -42 0|lfoot ltibia 0 0 20|rfemur root -9 -40 0
rtibia rfemur 0 -42 0|rfoot rtibia 0 0 20|lhumerus root 28 60 0|lradius lhumerus 28 0 0
lhand lradius 9 0 0|rhumerus root -28 60 0|rradius rhumerus -28 0 0|rhand rradius -9 0 0"""


def made() -> tuple[bytes, bytes]:
    """Return a small skeleton and how it moves."""
    bones = [bone.split() for bone in BONES.replace("\n", "|").split("|")]
    text = "".join(
        f" begin\n  name {name}\n  direction {' '.join(way)}\n  length 1\n"
        f"  axis 0 0 20 XYZ\n  dof rx rz\n end\n"
        for name, _, *way in bones
    )
    text += ":hierarchy\n begin\n" + "".join(f"  {up} {name}\n" for name, up, *_ in bones)
    frames = "".join(
        f"{number}\nroot 0 90 {number} 1 2 3\n"
        + "".join(f"{name} {number}.5 -2e-1\n" for name, *_ in bones)
        for number in range(1, 9)
    )
    return ASF + text.encode() + b" end\n", b":FULLY-SPECIFIED\n:DEGREES\n" + frames.encode()


def outcome(folder: Path, asf: bytes, amc: bytes) -> str:
    """Read and cut; anything but a motion or one of our errors is a failure."""
    (folder / "ada.asf").write_bytes(asf)
    file, told = File(str(folder / "ada.amc"), amc), Reading(rate=30, unit="cm", up="y")
    refused = None
    try:
        found = formats.read_file(file, told, formats.Wanted())
    except CaptureError as error:
        refused = error
    if refused is not None:
        assert refused.place.startswith(str(folder))
        assert refused.wanted
        assert "\n" not in str(refused)
        return "error"
    clip = formats.cutter(file)(Span(len(found) // 2, len(found)))
    again = formats.read_file(File(file.name, clip), told, formats.Wanted())
    assert np.array_equal(again.positions, found.positions[len(found) // 2 :], equal_nan=True)
    return "motion"


def fuzz(folder: Path, pairs: list[tuple[bytes, bytes]], count: int) -> dict[str, int]:
    numbers = random.Random(1998)
    seen = {"motion": 0, "error": 0}
    for _ in range(count):
        asf, amc = numbers.choice(pairs)
        if numbers.random() < 0.4:
            asf = mutated(asf, numbers, WORDS)
        else:
            amc = mutated(amc, numbers, WORDS)
        seen[outcome(folder, asf, amc)] += 1
    return seen


def test_mutations_give_a_motion_or_an_error(tmp_path: Path) -> None:
    assert min(fuzz(tmp_path, [made()], 500).values()) > 50


@pytest.mark.slow
@pytest.mark.timeout(3600)
def test_long_fuzzing(tmp_path: Path, captures: Path) -> None:
    pairs = [made()]
    for path in sorted((captures / "amc" / "cmu").glob("*.amc")):
        asf = path.with_name(f"{path.stem[:2]}.asf").read_bytes()
        head, *frames = re.split(rb"^(?=\d+\s*$)", path.read_bytes(), maxsplit=13, flags=re.M)
        pairs.append((asf, head + b"".join(frames[:12])))
    seen = fuzz(tmp_path, pairs, 5_000)
    assert min(seen.values()) > 50, seen
