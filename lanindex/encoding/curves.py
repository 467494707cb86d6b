"""How one curve goes, and which turns it makes, and where what turns or leans arrives.

Source: ``encoding/BODY.md``, "Turns", "Twists", "Swings" and "Onset".
"""

import math
from collections.abc import Iterable, Sequence
from itertools import chain, pairwise
from math import sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import DIRECTION_CODES, PLACE
from lanindex.encoding.arithmetic import blocks, slopes, smooth, window
from lanindex.encoding.profile import Profile

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


def swings(curve: Floats, turning: Iterable[int], least: float) -> list[Ends]:
    """Return the first and last frame of swings of a curve (N,), ended by `least` or more back."""
    found = []
    anchor = best = 0
    for frame in turning:
        way, now = curve[best] - curve[anchor], curve[frame] - curve[anchor]
        if now * way >= 0 and abs(now) >= abs(way):
            best = frame
        elif abs(curve[frame] - curve[best]) >= least:
            if best > anchor:
                found.append((anchor, best))
            anchor, best = best, frame
    if best > anchor:
        found.append((anchor, best))
    return found


def turning_points(curve: Floats) -> NDArray[np.int64]:
    """Return the frames at which a curve changes its direction, and the last frame."""
    step = np.sign(curve[1:] - curve[:-1])
    return np.append((step[1:] != step[:-1]).nonzero()[0] + 1, len(curve) - 1)


def lulls(pace: Floats, slow: float, least: int) -> list[Ends]:
    """Return the half-open frames in which a pace (N,) is below `slow` for `least` or more."""
    end = np.zeros(1, np.bool_)
    still = np.concatenate((end, pace < slow, end))
    edges = (still[1:] != still[:-1]).nonzero()[0]
    starts, stops = edges[::2], edges[1::2]
    return [(start, stop) for start, stop in zip(starts, stops) if stop - start >= least]  # noqa: B905


def departures(angles: Iterable[complex] | NDArray[np.complex128], least: float) -> list[Ends]:
    """Return the first and last frame of ways of angles (N,), ended by `least` or more back."""
    found = []
    anchor = best = 0
    start = far = 0j
    reach = 0.0
    for frame, angle in enumerate(angles):
        if frame == 0:
            start = angle
        away = abs(angle - start)
        if away >= reach:
            best, far, reach = frame, angle, away
        elif abs(angle - far) >= least:
            if reach >= least:
                found.append((anchor, best))
            anchor, start = best, far
            best, far, reach = frame, angle, abs(angle - start)
    if reach >= least:
        found.append((anchor, best))
    return found


LISTED = 1 << 14
"""Angles converted to Python numbers at a time, which take forty bytes each."""

FAINT, PLAIN = 0.1, 0.3
"""Parts of the fastest: at a slower pace movement is hardly seen, at a faster one it is plain."""

WIDTH = 0.35
"""Part of the time in which a movement is plain: from so far before to so far behind, in all, its
pace is measured."""


def ranked(values: Floats, place: int) -> float:
    """Return the value (N,) at a place in ascending order, counted from 0."""
    value: float = np.partition(values, place)[place]
    return value


def begun(pace: Floats, part: int, rests: float) -> float:
    """Return the frame at which a movement begins; `pace` (N,) float64, fast from `part` on."""
    peak = pace[part:].max()
    if peak <= 0:
        return 0.0
    plain = part + (pace[part:] >= PLAIN * peak).argmax()
    half = (plain + 1) // 2
    noise = ranked(pace[: plain + 1], half)
    faint = min(max(FAINT * peak, noise), PLAIN / 2 * peak, rests)
    slow = (pace[:plain] <= faint).nonzero()[0]
    if not len(slow):
        return 0.0
    last = slow[-1]
    clear = min(faint * PLAIN / FAINT, peak)
    then = last + 1 + (pace[last + 1 :] >= clear).argmax()
    one = last + (faint - pace[last]) / (pace[last + 1] - pace[last])
    two = then - (pace[then] - clear) / (pace[then] - pace[then - 1])
    start: float = max(one - (two - one) * FAINT / (PLAIN - FAINT), 0.0)
    return start


def seen(
    curve: NDArray[Any], pace: Floats, part: tuple[int, int], within: tuple[int, int], rests: float
) -> tuple[int, int]:
    """Return the frames at which `curve` (N,), real or complex, visibly begins and ends to move."""
    first, last = part
    low, high = within
    own = pace[first : last + 1]
    plain = (own >= PLAIN * own.max()).nonzero()[0]
    half = max(round(WIDTH / 2 * (plain[-1] - plain[0])), 1)
    way = curve[last] - curve[first]
    size, some = max(sqrt(way.real * way.real + way.imag * way.imag), 1e-9), curve[low : high + 1]
    along = some.real * (way.real / size) + some.imag * (way.imag / size)
    wide = np.concatenate((np.full(half, along[0]), along, np.full(half, along[-1])))
    calm = (wide[2 * half :] - wide[: -2 * half]) / (2 * half)
    top = first - low + calm[first - low : last - low + 1].argmax()
    begin = begun(calm[: top + 1], first - low, rests)
    end = high - low - begun(calm[top:][::-1].copy(), high - last, rests)
    lowest, highest = top - along[: top + 1][::-1].argmin(), top + along[top:].argmax()
    starts = min(max(round(begin), lowest), high - low - 1)
    return low + starts, low + max(min(round(end), highest), starts + 1)


STRIDE = 1.0
"""Seconds that path and heading are averaged over: the sway of a stride is gone then."""

BRIEF = 0.4
"""Seconds: what lasts shorter is part of what was before."""

TURNS = 30.0
"""Degrees: less is no turn."""

PAUSE = 10.0
"""Degrees a second: slower, for as long as `BRIEF`, parts two turns."""


def pieces(codes: NDArray[Any], least: int) -> list[tuple[int, int]]:
    """Make runs of codes at least `least` long, in place, and return their frames.

    A shorter run joins the one before it; at the beginning, the first long run, or else the
    longest.
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


def turns(
    heading: Floats, profile: Profile, chest: Floats | None = None, fast: bool = False
) -> Floats:
    """Return the turns of an unwrapped heading (N,), degrees, as from `table`.

    `chest` (N,) is the heading of the shoulders, where they are known.
    """
    rate = float(profile.rate)
    if len(heading) < 2:
        return table([])
    calm = smooth(heading, window(STRIDE, profile.rate), fast)
    both = np.array((heading, heading if chest is None else chest))
    both = smooth(both, window(profile.smoothing, profile.rate), fast)
    pace = np.abs(slopes(calm)) * rate
    found = []
    for first, last in swings(calm, turning_points(calm), TURNS):
        rests = lulls(pace[first : last + 1], PAUSE, round(BRIEF * rate))
        edges = [first, *(first + edge for edge in chain(*rests)), last + 1]
        for start, stop in zip(edges[::2], edges[1::2], strict=True):
            if stop > start and abs(calm[stop - 1] - calm[start]) >= TURNS:
                found.append(_turning(both[0, start:stop], start, rate))
    while True:
        edges = [0, *chain(*((one.start, one.stop) for one in found)), len(heading)]
        around = zip(found, edges[::2], edges[3::2], strict=False)
        measured = [_measured(both, *one, round(STRIDE * rate)) for one in around]
        found = [one for one in measured if one.amount >= TURNS]
        if len(found) == len(measured):  # what is no turn must not bound the others
            return table(found)


def _turning(heading: Floats, start: int, rate: float) -> Event:
    """Return a turn without its degrees, from when it is seen to begin until it is seen to end."""
    left = heading[-1] > heading[0]
    pace = slopes(heading) * (rate if left else -rate)
    whole = 0, len(heading) - 1
    first, last = seen(heading, pace, whole, whole, PAUSE / rate)
    code = DIRECTION_CODES["left" if left else "right"]
    return Event(start + first, start + last, code, -1, 0, speed=float(pace.max()) / 360)


def _measured(headings: Floats, turn: Event, low: int, high: int, stride: int) -> Event:
    """Return a turn with its degrees, measured between its neighbours: in [low, high).

    `headings` (2, N) are those of the hips, which give the degrees, and of the chest, which has to
    turn as well: else the amount is 0.
    """
    start, stop = turn.start, turn.stop
    before = headings[:, max(low, start - stride + 1) : start + 1].mean(axis=1)
    after = headings[:, stop : max(min(high, stop + stride), stop + 1)].mean(axis=1)
    left = turn.direction == DIRECTION_CODES["left"]
    hips, chest = (after - before if left else before - after).tolist()
    amount = round(hips) if chest >= TURNS / 2 else 0
    return turn._replace(amount=amount, margin=min(amount / TURNS - 1, 1.0))


Angles = NDArray[np.complex128]

MOVED = 15.0
"""Degrees: what goes no farther has not moved."""

STEADY = 0.15
"""Seconds that angles are averaged over where it is told how fast they change."""


def moves(angles: Angles, profile: Profile, fast: bool = False) -> list[Ends]:
    """Return the frames from which to which angles (N,) move.

    `angles` complex128, degrees: a twist, or a lean to the right and (imaginary) forward.
    """
    rate, width = float(profile.rate), window(STEADY, profile.rate)
    least = round(BRIEF * rate)
    if fast:
        from lanindex.encoding import curves_fast

        frames: list[Ends] = curves_fast.moves(angles, width, rate, least)
        return frames
    if len(angles) < 2:
        return []
    pace = np.empty(len(angles))
    for block in blocks(len(angles), width // 2 + 1):
        some = angles[block.outer]
        aside, ahead = slopes(smooth(np.array((some.real, some.imag)), width))
        pace[block.inner] = np.hypot(aside * rate, ahead * rate)[block.within]
    numbers = (angles[it : it + LISTED].tolist() for it in range(0, len(angles), LISTED))
    return move_frames(angles, chain.from_iterable(numbers), pace, PAUSE / rate, least)


def move_frames(
    angles: Angles, numbers: Iterable[complex] | Angles, pace: Floats, rests: float, least: int
) -> list[Ends]:
    """Return the frames of `moves`; `numbers` are the angles, in the form that loops fastest."""
    found = []
    for first, last in departures(numbers, MOVED):
        parts = move_parts(angles, pace, first, last, least)
        for number in range(len(parts)):
            low = parts[number - 1][1] if number else first
            high = parts[number + 1][0] if number + 1 < len(parts) else last
            found.append(seen(angles, pace, parts[number], (low, high), rests))
    return found


def move_parts(angles: Angles, pace: Floats, first: int, last: int, least: int) -> list[Ends]:
    """Return the parts of a move between rests that go far enough, or all; both ends included."""
    edges = [first]
    for start, stop in lulls(pace[first : last + 1], PAUSE, least):
        edges.append(first + start)
        edges.append(first + stop)
    edges.append(last + 1)
    found, begin = [], -1
    for number in range(0, len(edges), 2):
        start, stop = edges[number], edges[number + 1]
        if stop > start:
            begin = start if begin < 0 else begin
            if abs(angles[stop - 1] - angles[begin]) >= MOVED:
                found.append((begin, stop - 1))
                begin = -1
    if not found:
        found.append((first, last))
    return found


def arrivals(
    angles: Angles, away: float, profile: Profile, eighths: bool, fast: bool = False
) -> Floats:
    """Return where angles (N,) begin and arrive, as for `moves`; as from `table`."""
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
