"""Numbers out of text, frame by frame: the plain path.

The compiled path, `floats_fast`, gives the same arrays bit for bit: both round correctly.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lanindex.formats.bvh.hierarchy import LARGEST

_BLOCK = 4096


def parse(
    data: bytes, frames: NDArray[np.int64], width: int
) -> tuple[NDArray[np.float64], int | None]:
    """Read the numbers of each frame.

    Parameters
    ----------
    data : bytes
        The file.
    frames : ndarray
        (T, 2) int64, the bytes of each frame.
    width : int
        How many numbers each has to hold.

    Returns
    -------
    tuple of ndarray and (int or None)
        (T, width) float64, and the first frame that is damaged: `fault` says how.
    """
    values = np.empty((len(frames), width))
    for start in range(0, len(frames), _BLOCK):
        block = values[start : start + _BLOCK]
        read = _fill(block, data, frames[start : start + _BLOCK].tolist())
        sound = (np.abs(block[:read]) <= LARGEST).all(axis=1)
        if not sound.all():
            return values, start + int(sound.argmin())
        if read < len(block):
            return values, start + read
    return values, None


def _fill(rows: NDArray[np.float64], data: bytes, frames: list[list[int]]) -> int:
    """Read lines into rows; return how many could be read."""
    for count, (first, stop) in enumerate(frames):
        line = data[first:stop]
        words = line.split()
        if len(words) != rows.shape[1] or b"_" in line:  # float() would let 1_0 pass
            return count
        try:
            rows[count] = list(map(float, words))
        except ValueError:
            return count
    return len(frames)


def fault(line: bytes, width: int) -> tuple[str, str]:
    """Say what is wrong with a damaged frame.

    Parameters
    ----------
    line : bytes
        Its text.
    width : int
        How many numbers it has to hold.

    Returns
    -------
    tuple of str and str
        What was found, and what was wanted.
    """
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
