"""How one curve goes, and what is told of it: bends, turns, and where what turns or leans arrives.

Source: ``encoding/BODY.md``, "Turns", "Bends", "Swings" and "Onset".
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import chain, pairwise
from math import sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import DIRECTION_CODES, PLACE, SIXTHS
from lanindex.encoding.arithmetic import blocks, runs, smooth, window
from lanindex.encoding.profile import Profile
from lanindex.model.derived import DEGREE, bending, stretching

Floats = NDArray[np.float64]

SECTOR = 22.5
"""Degrees from the middle of a direction to its border."""


class Event(NamedTuple):
    """A foot that stands anew, or a flight; frames as in `Ground`, half-open."""

    start: int  # From when the weight goes there until all of it is there; of a flight, its frames
    stop: int
    direction: int  # Codes of the alphabet; -1: none
    level: int
    margin: float  # As of a symbol
    foot: int = 0  # 0 right, 1 left; of a flight 0
    amount: int = -1  # Of a flight, which feet; of a turn and a way, degrees; else -1
    # The highest: of a way in legs a second, of a turn in whole turns; below 0 not measured
    speed: float = -0.01
    beside: int = -1  # The direction across the nearest border; -1: none


def table(found: Sequence[Event]) -> Floats:
    """Return events as the rows of a table, (E, 9) float64: a column for each field."""
    return np.array(found, np.float64).reshape(-1, len(Event._fields))


Ends = tuple[int, int]


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


STRIDE = 1.0
"""Seconds that path and heading are averaged over: the sway of a stride is gone then."""

BRIEF = 0.4
"""Seconds: what lasts shorter is part of what was before."""

TURNS = 30.0
"""Degrees: less is no turn."""

PAUSE = 10.0
"""Degrees a second: slower, for as long as `BRIEF`, parts two turns."""


def pieces(codes: NDArray[Any], least: int) -> list[tuple[int, int]]:
    """Make of codes runs of some length, in place; return their frames.

    A run that is too short joins what was before it; at the beginning, what comes first that is
    long enough, or else the longest.
    """
    edges = [0, *((codes[1:] != codes[:-1]).nonzero()[0] + 1).tolist(), len(codes)]
    if len(edges) == 2:
        return [(0, len(codes))]
    sizes = [stop - start for start, stop in pairwise(edges)]
    long = [start for start, size in zip(edges, sizes, strict=False) if size >= least]
    starts, kept = [0], list[int]()
    for start in long or [edges[sizes.index(max(sizes))]]:
        if not kept or codes[start] != kept[-1]:
            starts += [start] if kept else []
            kept.append(int(codes[start]))
    found = list(pairwise([*starts, len(codes)]))
    for (start, stop), code in zip(found, kept, strict=True):
        codes[start:stop] = code
    return found


def turns(heading: Floats, profile: Profile) -> Floats:
    """Return the turns about the vertical, as from `table`.

    `heading` (N,) degrees, in one go: past half a circle it goes on.
    """
    rate = float(profile.rate)
    if len(heading) < 2:
        return table([])
    calm = smooth(heading, window(STRIDE, profile.rate))
    light = smooth(heading, window(profile.smoothing, profile.rate))
    pace = np.abs(np.gradient(calm)) * rate
    found = []
    for first, last in swings(calm, TURNS):
        rests = lulls(pace[first : last + 1], PAUSE, round(BRIEF * rate))
        edges = [first, *(first + edge for edge in chain(*rests)), last + 1]
        for start, stop in zip(edges[::2], edges[1::2], strict=True):
            if stop > start and abs(calm[stop - 1] - calm[start]) >= TURNS:
                found.append(_turn(light, start, stop, rate))
    return table([one for one in found if one.amount >= TURNS])


def _turn(heading: Floats, start: int, stop: int, rate: float) -> Event:
    """Return a turn, from when it is seen to begin until it is seen to end."""
    some = heading[start:stop]
    left = some[-1] > some[0]
    pace = np.gradient(some) * (rate if left else -rate)
    whole = 0, len(some) - 1
    first, last = seen(some, pace, whole, whole, PAUSE / rate)
    amount = round(abs(float(some[last] - some[first])))
    code = DIRECTION_CODES["left" if left else "right"]
    margin = min(amount / TURNS - 1, 1.0)
    speed = float(pace.max()) / 360
    return Event(start + first, start + last, code, -1, margin, amount=amount, speed=speed)


Angles = NDArray[np.complex128]

MOVED = 15.0
"""Degrees: what goes no farther has not moved."""

STEADY = 0.15
"""Seconds that angles are averaged over where it is told how fast they change."""


def moves(angles: Angles, profile: Profile, fast: bool = False) -> list[Ends]:
    """Return from which frame to which angles go somewhere.

    `angles` (N,) complex128, degrees: how far something is turned, or how far forward (the
    imaginary part) and to the right it leans.
    """
    rate, width = float(profile.rate), window(STEADY, profile.rate)
    least = round(BRIEF * rate)
    if fast:
        from lanindex.encoding import curves_fast

        return list(map(tuple, curves_fast.moves(angles, width, rate, least).tolist()))
    if len(angles) < 2:
        return []
    pace = np.empty(len(angles))
    for block in blocks(len(angles), width // 2 + 1):
        some = angles[block.outer]
        aside, ahead = np.gradient(smooth(np.array((some.real, some.imag)), width), axis=1)
        pace[block.inner] = np.hypot(aside * rate, ahead * rate)[block.within]
    found = []
    for first, last in departures(angles, MOVED):
        parts = _move_parts(angles, pace, first, last, least)
        before = [first, *(stop for _, stop in parts)]
        behind = [*(start for start, _ in parts[1:]), last]
        for part, low, high in zip(parts, before, behind, strict=False):
            found.append(seen(angles, pace, part, (low, high), PAUSE / rate))
    return found


def _move_parts(
    angles: Angles, pace: Floats, first: int, last: int, least: int
) -> list[tuple[int, int]]:
    """Part a way where it rests, in parts that are long enough; both frames are included."""
    rests = lulls(pace[first : last + 1], PAUSE, least)
    edges = [first, *(first + edge for edge in chain(*rests)), last + 1]
    found, begin = list[tuple[int, int]](), -1
    for start, stop in zip(edges[::2], edges[1::2], strict=True):
        if stop > start:
            begin = start if begin < 0 else begin
            if abs(angles[stop - 1] - angles[begin]) >= MOVED:
                found.append((begin, stop - 1))
                begin = -1
    return found or [(first, last)]


def arrivals(
    angles: Angles, away: float, profile: Profile, eighths: bool, fast: bool = False
) -> Floats:
    """Return where angles are at first, and where they go: as from `table`.

    `angles` (N,) complex128, as for `moves`; one at least.
    """
    found = [_there(angles, 0, 0, away, eighths)]
    for start, stop in moves(angles, profile, fast):
        one = _there(angles, start, min(stop, len(angles) - 1), away, eighths)
        if one.direction != PLACE or found[-1].direction != PLACE:
            found.append(one)
    return table(found)


def _there(angles: Angles, start: int, stop: int, away: float, eighths: bool) -> Event:
    """Return what says where angles have arrived."""
    angle = complex(angles[stop])
    size = abs(angle)
    if size < away:
        return Event(start, stop, PLACE, -1, 1 - size / away, amount=0)
    step = 45 if eighths else 180
    azimuth = math.degrees(math.atan2(angle.imag, angle.real))
    code = round(azimuth / step) % (360 // step)
    off = abs((azimuth - step * code + 180) % 360 - 180)
    margin = min(size / away - 1, 1 - off / (step / 2), 1.0)
    return Event(start, stop, code * step // 45, -1, margin, amount=round(size))


SWING = 20.0
"""Degrees of angle: less is no bend, and no farther from the middle of a degree is still that."""

CALM = 0.15
"""Seconds that an angle is averaged over where its pace is looked at."""

IDLES = 20.0
"""Degrees of angle a second: slower, for as long as `LULL`, parts two bends."""

LULL = 0.25
"""Seconds that a joint is slow for where it rests."""


def bends(angles: Floats, profile: Profile, fast: bool = False) -> list[Floats]:
    """Return the symbols of curves.

    `angles` (P, N) float64, degrees from straight; returned (P), as from `table`: the degree
    at the beginning, and the bends.
    """
    rate, width, least = float(profile.rate), window(CALM, profile.rate), round(LULL * profile.rate)
    first = smooth(angles[:, : width // 2 + 1], width)[:, 0].tolist()
    if fast:
        from lanindex.encoding import curves_fast

        parts = [curves_fast.bend_parts(angle, width, rate, least).tolist() for angle in angles]
    else:
        calm = smooth(angles, width)
        short = angles.shape[1] < 2
        pace = np.zeros(angles.shape) if short else np.gradient(calm, axis=1) * rate
        each = zip(angles, calm, pace, strict=True)
        parts = [list(_bend_parts(*curves, rate, least)) for curves in each]
    return [table(_bends(*curves)) for curves in zip(angles, first, parts, strict=True)]


def _bends(angle: Floats, first: float, parts: Iterable[tuple[int, int, int, int]]) -> list[Event]:
    """Return the degree at the beginning, and the bends: see `_bend_parts`."""
    degree = min(round(first / DEGREE), SIXTHS)
    bends = [_bend(0, 0, bending(degree), first, degree)]
    for way, last, start, stop in parts:
        arrived = float(angle[last])
        if way * (arrived - DEGREE * degree) > SWING:
            degree = min(round(arrived / DEGREE), SIXTHS)
            amount = bending(degree) if way > 0 else stretching(degree)
            bends.append(_bend(start, stop, amount, arrived, degree))
    return bends


def _bend(start: int, stop: int, amount: int, angle: float, degree: int) -> Event:
    off = abs(angle / DEGREE - degree)
    return Event(start, stop, -1, -1, max(1 - 2 * off, 0.0), amount=amount)


def _bend_parts(
    angle: Floats, calm: Floats, pace: Floats, rate: float, least: int
) -> Iterator[tuple[int, int, int, int]]:
    """Part swings where they rest or give way: what moves, and what may go on slowly between.

    Yielded are the way (1 or -1), the last frame, and from which frame to which it is seen. What
    moves may have begun in the rest before, and end in the one behind.
    """
    fast = np.abs(pace)
    for first, last in swings(calm, SWING):
        if abs(calm[last] - calm[first]) < SWING:
            continue
        way = 1 if calm[last] > calm[first] else -1
        slow = lulls(way * pace[first : last + 1], IDLES, least)
        rests = ((first + start, min(first + stop, last)) for start, stop in slow)
        edges = [first, first, *chain(*rests), last, last]
        for number, part in enumerate(pairwise(edges[1:-1])):
            if part[0] < part[1]:
                within = part if number % 2 else (edges[number], edges[number + 3])
                yield way, part[1], *seen(angle, fast, part, within, IDLES / rate)
