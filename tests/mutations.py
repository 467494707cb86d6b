"""Damage to text files: bytes, words and lines changed, cut, doubled and exchanged."""

import random
from collections.abc import Sequence

ODD = (b"", b"\n", b"\r", b"\0", b"\xff", b" ", b"-", b"1e999", b"nan", b"9" * 40, b"1_0", b"-1")


def mutated(data: bytes, numbers: random.Random, words: Sequence[bytes]) -> bytes:
    """Return a text damaged in a few places.

    Parameters
    ----------
    data : bytes
        The text.
    numbers : random.Random
        Chooses.
    words : sequence of bytes
        What has a meaning in it.
    """
    for _ in range(numbers.choice((1, 1, 2, 5, 20))):
        at = numbers.randrange(len(data) + 1)
        stop = min(at + numbers.choice((0, 1, 3, 30, 500)), len(data))
        kind = numbers.randrange(7)
        if kind == 0:
            data = data[:at] + data[stop:]
        elif kind == 1:
            data = data[:stop] + data[at:stop] + data[stop:]
        elif kind == 2:
            data = data[:at] + numbers.randbytes(stop - at) + data[stop:]
        elif kind == 3:
            data = data[:at] + numbers.choice((*ODD, *words)) + data[at:]
        elif kind == 4:
            begin, end = data.rfind(b" ", 0, at) + 1, data.find(b" ", at)
            data = data[:begin] + numbers.choice((*ODD, *words)) + data[max(end, begin) :]
        elif kind == 5:
            lines = data.splitlines(keepends=True)
            one, other = (numbers.randrange(len(lines) or 1) for _ in range(2))
            if lines:
                lines[one], lines[other] = lines[other], lines[one]
            data = b"".join(lines)
        else:
            data = data[:at] if numbers.random() < 0.3 else data
    return data
