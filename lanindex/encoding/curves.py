"""How one curve goes: calmed, from turning point to turning point, away from where it was.

Source: ``encoding/BODY.md``, "Turns", "Bends" and "Swings".
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from lanindex.encoding.arithmetic import blocks, runs, smooth

Floats = NDArray[np.float64]
Ends = tuple[int, int]


def mean(curve: Floats, width: int) -> Floats:
    """Return the centred moving average of curves (..., N), over some odd number of frames."""
    return smooth(curve, width)


def swings(curve: Floats, least: float) -> list[Ends]:
    """Return from where to where a curve goes one way, less than `least` back not counted.

    `curve` (N,) float64.
    """
    found, anchor, best = list[Ends](), 0, 0
    for frame in chain(_turning(curve), [len(curve) - 1]):
        way = curve[best] - curve[anchor]
        now = curve[frame] - curve[anchor]
        if now * way >= 0 and abs(now) >= abs(way):
            best = frame
        elif abs(curve[frame] - curve[best]) >= least:
            if best > anchor:
                found.append((anchor, best))
            anchor, best = best, frame
    return [*found, (anchor, best)] if best > anchor else found


def _turning(curve: Floats) -> Iterator[int]:
    """Yield the frames at which a curve goes on another way, a block of numbers at a time."""
    for part in blocks(len(curve) - 2):
        step = np.sign(np.diff(curve[part.inner.start : part.inner.stop + 2]))
        yield from (np.flatnonzero(step[1:] != step[:-1]) + (part.inner.start + 1)).tolist()


def lulls(pace: Floats, slow: float, least: int) -> list[Ends]:
    """Return the frames, half-open, in which a pace stays below another for long enough.

    `pace` (N,) float64.
    """
    return [(start, stop) for start, stop in runs(pace < slow) if stop - start >= least]


def departures(angles: NDArray[np.complex128], least: float) -> list[Ends]:
    """Return from where to where angles go away, less than `least` back not counted.

    `angles` (N,) complex128: how far something is turned, or leans, to one side and another.
    """
    found, anchor, best = list[Ends](), 0, 0
    here = far = complex(angles[0])
    reach = 0.0
    each = chain.from_iterable(angles[part.inner].tolist() for part in blocks(len(angles)))
    for frame, angle in enumerate(each):
        away = abs(angle - here)
        if away >= reach:
            best, far, reach = frame, angle, away
        elif abs(angle - far) >= least:
            if reach >= least:
                found.append((anchor, best))
            anchor, here = best, far
            best, far, reach = frame, angle, abs(angle - here)
    return [*found, (anchor, best)] if reach >= least else found
