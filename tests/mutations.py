"""Damaged copies of a file, and what reading one may come to: a motion or one of our errors."""

import random
from collections.abc import Sequence

from lanindex import formats
from lanindex.errors import LanindexError
from lanindex.model import Motion, Span

PIECES = (
    b"\n", b"\r\n", b" ", b"-", b".", b"e5", b"nan", b"\0", b"\t", b",", b",,,", b";", b"_",
    b"1e999", b"\xff", b"9" * 30, b"-1", b"0",
)  # fmt: skip


def mutated(data: bytes, numbers: random.Random, words: Sequence[bytes] = ()) -> bytes:
    """Return data with a few bytes changed, stretches cut, doubled or exchanged.

    What is put in is odd, or one of some words that mean something in the format.
    """
    if not numbers.randrange(200):
        return b""
    mutable = bytearray(data)
    near = numbers.choice((len(mutable), 2000, 200))  # headers matter most
    for _ in range(numbers.choice((1, 1, 2, 5, 20))):
        at = numbers.randrange(min(near, len(mutable)) + 1)
        length = min(numbers.choice((0, 1, 3, 30, 500)), len(mutable) - at)
        kind = numbers.randrange(6)
        if kind == 0:
            mutable[at : at + length] = b""
        elif kind == 1:
            mutable[at:at] = mutable[at : at + length]
        elif kind == 2:
            mutable[at : at + length] = numbers.randbytes(length)
        elif kind == 3:
            del mutable[at + length :]
        elif kind == 4:
            lines = bytes(mutable).split(b"\n")
            one, other = numbers.randrange(len(lines)), numbers.randrange(len(lines))
            lines[one], lines[other] = lines[other], lines[one]
            mutable = bytearray(b"\n".join(lines))
        else:
            mutable[at:at] = numbers.choice((*PIECES, *words))
    return bytes(mutable)


def outcome(name: str, data: bytes) -> str:
    """Read, and cut a clip; anything but a motion or one of our errors is a failure."""
    try:
        found = formats.read(name, data=data)
        formats.cutter(formats.File(name, data))(Span(0, len(found)))
    except LanindexError as refused:
        error = refused
    else:
        error = None
    if error is not None:
        assert str(error).startswith(name), str(error)
        return "error"
    assert isinstance(found, Motion)
    assert len(found) >= 1
    return "motion"


def fuzzed(name: str, sources: Sequence[bytes], count: int, seed: int) -> dict[str, int]:
    """Return how often a mutation of some files came to what."""
    numbers = random.Random(seed)
    seen = {"motion": 0, "error": 0}
    for _ in range(count):
        seen[outcome(name, mutated(numbers.choice(sources), numbers))] += 1
    return seen
