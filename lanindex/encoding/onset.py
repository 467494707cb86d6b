"""When a movement is seen to begin, and to end.

Source: ``encoding/BODY.md``, "Onset".
"""

from __future__ import annotations

from math import sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.encoding.arithmetic import Floats

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

    `curve` (N,) float64 or complex128: what moves; `pace` (N,) float64: roughly how fast.
    """
    (first, last), (low, high) = part, within
    own = pace[first : last + 1]
    plain = (own >= PLAIN * own.max()).nonzero()[0]
    half = max(round(WIDTH / 2 * int(plain[-1] - plain[0])), 1)
    way = curve[last] - curve[first]
    size, some = max(sqrt(way.real * way.real + way.imag * way.imag), 1e-9), curve[low : high + 1]
    along = some.real * (way.real / size) + some.imag * (way.imag / size)
    wide = np.empty(len(along) + 2 * half)
    wide[:half], wide[half:-half], wide[-half:] = along[0], along, along[-1]
    calm = ((wide[2 * half :] - wide[: -2 * half]) / (2 * half)).tolist()
    top = calm.index(max(calm[first - low : last - low + 1]), first - low)
    begin = begun(calm[: top + 1], first - low, rests)
    end = high - low - begun(calm[top:][::-1], high - last, rests)
    lowest, highest = top - int(along[top::-1].argmin()), top + int(along[top:].argmax())
    begin = min(max(round(begin), lowest), high - low - 1)
    return low + begin, low + max(min(round(end), highest), begin + 1)


def begun(pace: list[float], part: int, rests: float) -> float:
    """Return when a movement begins, in frames."""
    peak = max(pace[part:])
    if peak <= 0:
        return 0.0
    plain = next(it for it in range(part, len(pace)) if pace[it] >= PLAIN * peak)
    noise = sorted(pace[: plain + 1])[(plain + 1) // 2]
    faint = min(max(FAINT * peak, noise), PLAIN / 2 * peak, rests)
    last = next((it for it in range(plain - 1, -1, -1) if pace[it] <= faint), -1)
    if last < 0:
        return 0.0
    clear = min(faint * PLAIN / FAINT, peak)
    then = next(it for it in range(last + 1, len(pace)) if pace[it] >= clear)
    one = last + (faint - pace[last]) / (pace[last + 1] - pace[last])
    two = then - (pace[then] - clear) / (pace[then] - pace[then - 1])
    return max(one - (two - one) * FAINT / (PLAIN - FAINT), 0.0)
