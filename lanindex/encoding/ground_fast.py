"""Which foot carries, and how legs take the weight, compiled (extra ``fast``).

The same as `ground` and `steps` do with numpy, which are the truth: equal flags and levels.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import inf

import numba
import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import HIGH, LOW, MID
from lanindex.encoding.ground import (
    FLICKER,
    LIFTED,
    NEAR,
    SHARE,
    SLIDES,
    STANCE,
    STANDS,
    UNEVEN,
    Feet,
    Flags,
    Floats,
)
from lanindex.encoding.nth_fast import middle, nth
from lanindex.encoding.steps import BENT, TOES, WEIGHT

_NUMBERS = np.array((NEAR, LIFTED, STANDS, SHARE, UNEVEN, BENT, TOES), np.float32)


@numba.njit
def _rest(heights, slow, sides, some):
    """Return the height of which a fifth are smaller where joints of these sides are slow."""
    count = 0
    for side in sides:
        for frame in range(heights.shape[1]):
            if slow[side, frame]:
                some[count] = heights[side, frame]
                count += 1
    return nth(some[:count], (count - 1) // 5) if count else np.float32(inf)


@numba.njit
def _lower(heights, slow):
    """Count heights of joints (2, K, N) from where these rest; return the lower one, (2, N)."""
    frames = heights.shape[2]
    some, found = np.empty(2 * frames, np.float32), np.empty((2, frames), np.float32)
    for kind in range(heights.shape[1]):
        own, rests = heights[:, kind], slow[:, kind]
        rest = min(_rest(own, rests, (0,), some), _rest(own, rests, (1,), some))
        if rest == inf:
            rests = np.ones((2, frames), np.bool_)
            rest = _rest(own, rests, (0, 1), some)
        for side in range(2):
            for frame in range(frames):
                high = own[side, frame] - rest
                found[side, frame] = min(found[side, frame], high) if kind else high
    return found


@numba.njit
def _uneven(height, speed, stands, most, least):
    """Tell whether the lower of the feet stands at heights that no floor explains."""
    frames = height.shape[1]
    lower, slow = np.empty(frames, np.float32), np.zeros(frames + 1, np.bool_)
    low, high = np.float32(inf), np.float32(-inf)
    for frame in range(frames):
        lower[frame] = min(height[0, frame], height[1, frame])
        if min(speed[0, frame], speed[1, frame]) < stands:
            slow[frame] = True
            low, high = min(low, lower[frame]), max(high, lower[frame])
    if not high - low > most:
        return False
    lowest, highest, start = inf, -inf, 0
    for frame in range(len(slow)):
        if not slow[frame]:
            if frame - start >= least and frame > start:
                stands = middle(lower[start:frame])
                lowest, highest = min(lowest, stands), max(highest, stands)
            start = frame + 1
    return highest - lowest > UNEVEN


@numba.njit
def _steady(state, value, most):
    """Turn what lasts no longer, but at the ends of the frames."""
    start = 0
    for frame in range(1, len(state)):
        if state[frame] != state[frame - 1]:
            if start > 0 and state[start] == value and frame - start <= most:
                state[start:frame] = not value
            start = frame


@numba.njit(cache=True, nogil=True)
def _carried(heights, speed, slow, pace, numbers, stands, slides, least, brief):
    near, lifted, quick, share, most = numbers[:5]
    height = _lower(heights, slow)
    uneven = _uneven(height, speed, stands, most, least)
    carries = np.zeros(speed.shape, np.bool_)
    for foot in range(2):
        on = False
        for frame in range(len(pace)):
            high = np.float32(0) if uneven else height[foot, frame]
            stays = speed[foot, frame] < slides and high < lifted
            begins = speed[foot, frame] < max(quick, share * pace[frame]) and high < near
            on = stays and (on or begins)
            carries[foot, frame] = on
        _steady(carries[foot], False, brief)
        _steady(carries[foot], True, brief - 1)
    return carries, uneven


def carried(feet: Feet, heights: NDArray[np.float32], rate: float) -> tuple[Flags, bool]:
    """Return which feet carry: see `lanindex.encoding.ground.carried`."""
    told = _NUMBERS, STANDS, SLIDES, STANCE * rate, round(FLICKER * rate)
    carries, uneven = _carried(heights, feet.speed, feet.slow, feet.pace, *told)
    return carries, bool(uneven)


@numba.njit(cache=True, nogil=True)
def _stood(points, speed, stands, near, least):
    frames, count = speed.shape[1], 0
    found = np.empty((frames + 1, 3))
    for side in range(2):
        start = 0
        own, other = points[side], points[1 - side]
        for frame in range(frames + 1):
            if frame < frames and speed[side, frame] < stands:
                continue
            low = frame > start and frame - start >= least
            for place in range(start, frame if low else start):
                low = low and own[place, 1] <= other[place, 1] + near
            if low:
                some = own[start:frame].T.copy()
                found[count, 0], found[count, 1] = middle(some[0]), middle(some[2])
                found[count, 2] = nth(some[1], (frame - start - 1) // 5)
                count += 1
            start = frame + 1
    return found[:count].copy()


def stood(points: NDArray[np.float32], speed: Floats, least: float) -> Floats:
    """Return where feet stand: see `lanindex.encoding.ground.stood`."""
    found: Floats = _stood(points, speed, STANDS, _NUMBERS[0], least)
    return found


@numba.njit(cache=True, nogil=True)
def _levels(frames, carries, bent, heights, usual, width, numbers):
    least, toes = numbers[5:]
    rise, found = np.empty(width, np.float32), np.empty(len(frames), np.int64)
    for number in range(len(frames)):
        first, many, lowest = frames[number], 0, np.float32(inf)
        for frame in range(first, min(first + width, len(carries))):
            if carries[frame]:
                if lowest == lowest and not bent[frame] >= lowest:  # once unknown, ever unknown
                    lowest = bent[frame]
                rise[many] = heights[0, frame] - heights[-1, frame]
                many += 1
        found[number] = MID
        if lowest > least and lowest < inf:
            found[number] = LOW
        elif many and np.float32(middle(rise[:many])) - usual > toes:  # never, if it is NaN
            found[number] = HIGH
    return found


def levels(
    frames: Sequence[int],
    carries: Flags,
    bent: NDArray[np.float32],
    heights: NDArray[np.float32],
    usual: float | None,
    rate: float,
) -> list[int]:
    """Return how a leg takes the weight: see `lanindex.encoding.steps.levels`."""
    own, width = np.float32(np.nan if usual is None else usual), max(round(WEIGHT * rate), 1)
    told = np.array(frames, np.int64), carries, bent, heights
    found: list[int] = _levels(*told, own, width, _NUMBERS).tolist()
    return found
