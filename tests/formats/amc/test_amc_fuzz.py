"""Whatever the bytes: a motion or one of our errors, and a clip that reads back equal."""

import random
import re
from pathlib import Path

import numpy as np
import pytest
from made_amc import made
from mutations import mutated

from lanindex import formats
from lanindex.errors import CaptureError
from lanindex.formats.file import File
from lanindex.model import Reading, Span

WORDS = b"root rfemur begin end dof rx l :bonedata :hierarchy :DEGREES # 3 name axis XYZ".split()


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
