"""Numbers out of text, frame by frame: the plain path.

The compiled path, `floats_fast`, gives the same arrays bit for bit: both round correctly.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lanindex.formats import decimals
from lanindex.formats.bvh.hierarchy import LARGEST


def parse(
    data: bytes, frames: NDArray[np.int64], width: int
) -> tuple[NDArray[np.float64], int | None]:
    """Read the numbers of each frame.

    Takes `frames` (T, 2).
    """
    values = np.empty((len(frames), width))
    read = decimals.fill(values, data, frames, b" ", range(width), width) if width else None
    bad = len(frames)
    for row in range(bad) if read is None else np.flatnonzero(~read).tolist():
        first, stop = frames[row].tolist()
        if not _fill(values[row], data[first:stop]):
            bad = row
            break
    large = ~(np.abs(values[:bad]) <= LARGEST).all(axis=1)
    bad = int(large.argmax()) if large.any() else bad
    return values, bad if bad < len(frames) else None


def _fill(row: NDArray[np.float64], line: bytes) -> bool:
    """Read a line; return whether it holds as many numbers as it should."""
    words = line.split()
    if len(words) != len(row) or b"_" in line:  # float() would let 1_0 pass
        return False
    try:
        row[:] = list(map(float, words))
    except ValueError:
        return False
    return True


def fault(line: bytes, width: int) -> tuple[str, str]:
    """Say what is wrong with a damaged frame."""
    words = line.split()
    for place, word in enumerate(words, 1):
        text = word.decode("latin-1")
        shown = repr(text if len(text) <= 40 else text[:40] + "...")
        try:
            value = float("" if b"_" in word else word)
        except ValueError:
            return f"has {shown} as number {place}", "numbers with a decimal point"
        if not abs(value) <= LARGEST:
            return f"has {shown} as number {place}", f"finite numbers up to {LARGEST:g}"
    return f"has {len(words)} numbers", f"{width} as the hierarchy declares"
