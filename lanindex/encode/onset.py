"""When a movement is seen to begin, and to end.

Source: ``encode/BODY.md``, "Onset".
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.encode.arithmetic import Floats, median

FAINT, PLAIN = 0.1, 0.3
"""Parts of the fastest: at a slower pace movement is hardly seen, at a faster one it is plain."""

WIDTH = 0.35
"""Part of the time in which a movement is plain: from so far before to so far behind, in all, its
pace is measured."""


def seen(
    curve: NDArray[Any],
    pace: Floats,
    part: tuple[int, int],
    within: tuple[int, int],
    rests: float,
) -> tuple[int, int]:
    """Return from which frame to which a movement is seen.

    Parameters
    ----------
    curve : ndarray
        (N,) float64 or complex128: what moves.
    pace : ndarray
        (N,) float64: roughly how fast.
    part : tuple of int
        The first and the last frame of the movement, as far as it is known.
    within : tuple of int
        The first and the last frame of the rests around it: it is looked for there.
    rests : float
        What of `curve` a frame is no rest any more.

    Examples
    --------
    >>> import numpy as np
    >>> from lanindex.encode.onset import seen
    >>> share = np.clip((np.arange(100) - 30) / 40, 0, 1)
    >>> there = 20 * (1 - np.cos(np.pi * share))  # from frame 30 to 70
    >>> seen(there, np.gradient(there), (35, 60), (0, 99), 0.3)
    (30, 70)
    """
    (first, last), (low, high) = part, within
    own = pace[first : last + 1]
    plain = (own >= PLAIN * own.max()).nonzero()[0]
    half = max(round(WIDTH / 2 * int(plain[-1] - plain[0])), 1)
    way = curve[last] - curve[first]
    along = (curve[low : high + 1] * (way.conjugate() / max(abs(way), 1e-9))).real
    frames = np.arange(len(along))
    on, back = np.minimum(frames + half, high - low), np.maximum(frames - half, 0)
    calm = (along[on] - along[back]) / np.maximum(on - back, 1)
    top = first - low + int(calm[first - low : last - low + 1].argmax())
    begin = begun(calm[: top + 1], first - low, rests)
    end = high - low - begun(calm[top:][::-1], high - last, rests)
    lowest, highest = top - int(along[top::-1].argmin()), top + int(along[top:].argmax())
    begin, end = max(round(begin), lowest), min(round(end), highest)
    return low + begin, low + max(end, begin + 1)


def begun(pace: Floats, part: int, rests: float) -> float:
    """Return when a movement begins, in frames.

    Parameters
    ----------
    pace : ndarray
        (N,) float64: of a rest and what comes after it, up to the fastest frame or farther.
    part : int
        The first frame of which it is known that it belongs to the movement.
    rests : float
        At a faster pace nothing rests.

    Examples
    --------
    >>> import numpy as np
    >>> from lanindex.encode.onset import begun
    >>> begun(np.array([0, 0, 0, 0, 1, 2, 3, 4, 5.0]), 5, 1)
    3.0
    """
    peak = float(pace[part:].max())
    plain = part + int((pace[part:] >= PLAIN * peak).argmax())
    faint = min(FAINT * peak, rests)
    if faint < rests:
        faint = min(max(faint, median(pace[: plain + 1])), rests)
    slow = (pace[:plain] <= faint).nonzero()[0]
    if not len(slow):
        return 0.0
    last, clear = int(slow[-1]), min(faint * PLAIN / FAINT, peak)
    then = last + int((pace[last:] >= clear).argmax())
    low, over, under, high = (float(pace[it]) for it in (last, last + 1, then - 1, then))
    one = last + (faint - low) / (over - low)
    two = then - (high - clear) / (high - under)
    return max(one - (two - one) * FAINT / (PLAIN - FAINT), 0.0)
